"""A plate that flies freely, spinning and flapping: momentum and energy are laws,
and the world frame does not matter.
"""

import numpy as np
import pytest

import flexmb as fmb
from flexmb.math.rotations import rotation_matrix

KINDS = pytest.mark.parametrize("shear", [False, True], ids=["thin", "shear"])
CURVED = [[(x, y, 0.3 * x * y) for y in (0.0, 0.4, 0.8)] for x in (0.0, 0.5, 1.0)]


def flight(shear, integrator, at=(0, 0, 0), rotation=(0, 0, 0), t_end=0.3):
    """Return the solution of a twisted soft plate that is flat without load: it flaps by its size while it spins."""
    R = rotation_matrix(rotation)
    body = fmb.AncfPlate(
        "p",
        points=CURVED,
        thickness=0.02,
        material=fmb.Material(young=1e4, poisson=0.3, density=1e3),
        shear=shear,
        flat=True,
        at=at,
        rotation=R,
        velocity=tuple(R @ (1.0, 0.5, 0.0)),
        angular_velocity=tuple(R @ (3.0, -4.0, 2.0)),
    )
    model = fmb.Model(
        bodies=(fmb.Ground(), body),
        gravity=(0, 0, 0),
        sensors=(
            fmb.Momentum("P"),
            fmb.Energy("E"),
            fmb.Energy("U", kind="strain"),
            fmb.Position("corner", marker="p.corner_11"),
        ),
    )
    return fmb.simulate(model, t_end=t_end, samples=11, integrator=integrator)


@KINDS
def test_momentum_and_energy(shear):
    solution = flight(shear, fmb.IDA(rtol=1e-8, atol=1e-10))
    P, E, U = (np.asarray(solution[name]) for name in ("P", "E", "U"))
    assert np.ptp(U) > 0.02 * E[0]  # it does deform
    np.testing.assert_allclose(E, E[0], rtol=2e-5)
    np.testing.assert_allclose(P, np.tile(P[0], (len(P), 1)), atol=2e-5 * np.abs(P[0]).max())


@KINDS
def test_motion_turns_with_the_frame(shear):
    """The same steps in a world that is turned and moved: the same motion, to rounding and the solver's tolerance."""
    steps, R = fmb.GeneralizedAlpha(step=2e-3), rotation_matrix((0.4, -1.1, 0.7))
    one = flight(shear, steps, t_end=0.1)
    other = flight(shear, steps, at=(3.0, -2.0, 5.0), rotation=(0.4, -1.1, 0.7), t_end=0.1)
    np.testing.assert_allclose(other["corner"], one["corner"] @ R.T + (3.0, -2.0, 5.0), atol=1e-7)
