"""DAE1: the car axis of the IVP test set (Mazzia & Magherini), built of bodies, joints and springs.

Reached at t = 3 s: generalized-alpha, h = 5e-5: positions 8e-7, velocities 5e-5; IDA at 1e-8: positions 1.4e-7,
velocities 6e-6, forces 1.5e-8; at 1e-10: positions 1.1e-8.
"""

import numpy as np
import pytest
from by_turns import slow
from verification.mechanisms import car_axis

import flexmb as fmb


@pytest.mark.parametrize(
    ("integrator", "velocity"),
    [slow(fmb.GeneralizedAlpha(step=5e-5), 1e-4), (fmb.IDA(rtol=1e-8, atol=1e-8), 1e-5)],
    ids=["alpha", "IDA"],
)
def test_positions_velocities_and_multipliers(reference, integrator, velocity):
    case = reference("DAE1")
    y = np.array(case["reference"]["y"])
    end = fmb.simulate(car_axis(case), case["duration_s"], samples=31, integrator=integrator)
    np.testing.assert_allclose([*end["p left"][-1, :2], *end["p right"][-1, :2]], y[:4], atol=1e-6)
    np.testing.assert_allclose([*end["v left"][-1, :2], *end["v right"][-1, :2]], y[4:8], atol=velocity)
    # G^T lam: the rail's force is lam_1 times the unit vector along the base, the rod's 2 lam_2 times the axle
    forces = [np.linalg.norm(end[f"{name} force"][-1, :3]) for name in ("rail", "axle")]
    np.testing.assert_allclose(forces, np.abs(y[8:]) * [1, 2], atol=2e-7)
