"""GS01: rods with tip masses on a spinning hub: the stiffness that the spin adds (Banerjee 1993, eqs. 1 to 7).

Reference: closed form K = [[k + 3 m w^2 r L, m w^2 r L], [m w^2 r L, k + m w^2 L (r + L)]] in relative angles.
"""

import numpy as np
import pytest

import flexmb as fmb


def rods(m, omega):
    tiny = 1e-12
    r, length = m["r"], m["L"]
    spin = {"angular_velocity": (0, 0, omega)}
    tip = {
        "mass": m["m"],
        "inertia": (tiny, tiny, tiny),
        "center_of_mass": (length, 0, 0),
        "markers": {"root": (0, 0, 0), "tip": (length, 0, 0)},
    }
    return fmb.Model(
        bodies=[
            fmb.Ground(),
            fmb.RigidBody("hub", mass=1.0, inertia=(1, 1, 1), markers={"rim": (r, 0, 0)}, **spin),
            fmb.RigidBody("one", at=(r, 0, 0), velocity=(0, r * omega, 0), **tip, **spin),
            fmb.RigidBody("two", at=(r + length, 0, 0), velocity=(0, (r + length) * omega, 0), **tip, **spin),
        ],
        joints=[
            fmb.Revolute("axis", markers=("ground.origin", "hub.center")),
            fmb.Drive("motor", joint="axis", angle=fmb.ramp(rate=omega)),
            fmb.Revolute("first", markers=("hub.rim", "one.root")),
            fmb.Revolute("second", markers=("one.tip", "two.root")),
        ],
        forces=[
            fmb.TorsionSpring("spring one", joint="first", stiffness=m["k"]),
            fmb.TorsionSpring("spring two", joint="second", stiffness=m["k"]),
        ],
    )


@pytest.mark.parametrize("omega", ["0.0", "1.0", "3.0", "10.0"])
def test_stiffness_in_relative_angles(reference, omega):
    case = reference("GS01")
    linear = fmb.linearize(rods(case["model"], float(omega)))
    hub, one, two = (linear.basis[6 * k + 5] for k in range(3))  # rotations about z
    angles = np.linalg.inv(np.stack([one - hub, two - one]))
    K = angles.T @ linear.K @ angles
    np.testing.assert_allclose(K, case["reference"][omega]["K"], rtol=1e-9, atol=1e-7)
