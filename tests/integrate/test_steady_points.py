"""A point on a rod of a hub that turns steadily: the same in any unit of length, beside its closed form.

In the axes of the hub the point is at e + L, the rod is hinged at e, and a spring pulls the point towards the axis with
T. With the centrifugal force, the swings in the plane and out of it obey (by hand)

    phi'' = -(e / L) (W^2 - T / (m (e + L))) phi,   psi'' = phi'' - W^2 psi.
"""

from __future__ import annotations

import numpy as np
import pytest

import flexmb as fmb

E, L, W, MASS, STIFFNESS, FREE = 0.1, 0.3, 4.8, 0.35, 20.0, 0.3


def turning(unit: float) -> fmb.Model:
    """Return the hub with lengths in units of 1 / unit metres."""
    x = (E + L) * unit
    return fmb.Model(
        gravity=(0, 0, 0),
        bodies=[
            fmb.Ground(),
            fmb.RigidBody(
                "hub",
                mass=0.8,
                inertia=np.array([0.012, 0.016, 0.011]) * unit**2,
                angular_velocity=(0, 0, W),
                markers={"axis": (0, 0, 0), "hinge": (E * unit, 0, 0)},
            ),
            fmb.PointMass("point", mass=MASS, at=(x, 0, 0), velocity=(0, W * x, 0)),
        ],
        joints=[
            fmb.Revolute("axle", markers=("ground.origin", "hub.axis")),
            fmb.Drive("motor", joint="axle", angle=fmb.ramp(rate=W, rise=0.0)),
            fmb.Rod("rod", markers=("hub.hinge", "point.center")),
        ],
        forces=[
            fmb.SpringDamper("spring", markers=("hub.axis", "point.center"), stiffness=STIFFNESS, length=FREE * unit)
        ],
    )


@pytest.mark.filterwarnings("error::flexmb.ValidityWarning")
@pytest.mark.parametrize("unit", [1e-6, 1e-3, 1.0, 1e3, 1e5])
def test_swings_of_a_point(unit):
    linear = fmb.linearize(turning(unit))
    tension = STIFFNESS * (E + L - FREE)
    plane = E / L * (W**2 - tension / (MASS * (E + L)))
    np.testing.assert_allclose(linear.eigenvalues, 1j * np.sqrt([plane, plane + W**2]), rtol=1e-7, atol=1e-7)
