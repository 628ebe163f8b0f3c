"""RB01: planar pendulum (IFToMM A01), closed form with Jacobi elliptic functions.

Reached at t = 10 s: generalized-alpha, rho 0.8, h = 1e-3: 1.3e-4 m, energy 7.7e-5 J; h = 5e-4: 3e-5 m,
1.9e-5 J; IDA at 1e-10: 2.6e-7 m, energy 5e-7 J; at 1e-12: below 1e-8 m.
"""

import numpy as np
import pytest

import flexmb as fmb


@pytest.fixture
def pendulum():
    return fmb.Model(
        gravity=(0, -9.81, 0),
        bodies=[fmb.Ground(), fmb.PointMass("mass", mass=1.0, at=(-1, 0, 0))],
        joints=[fmb.Rod("rod", markers=("ground.origin", "mass.center"))],
        sensors=[fmb.Position("p", marker="mass.center"), fmb.Energy("energy")],
    )


def error(model, case, integrator):
    expected = case["reference"]["x_y_at_t"]
    times = [0.0, *(float(t) for t in expected)]
    solution = fmb.simulate(model, times[-1], samples=times, integrator=integrator)
    difference = solution["p"][1:, :2] - np.array(list(expected.values()))
    return np.abs(difference).max(), np.ptp(solution["energy"])


@pytest.mark.parametrize(
    ("integrator", "position", "energy"),
    [
        (fmb.GeneralizedAlpha(step=5e-4), 1e-3, 5e-5),
        (fmb.GeneralizedAlpha(step=1e-3), 1e-3, 1e-4),
        (fmb.GeneralizedAlpha(rtol=1e-8), 1e-3, 2e-4),
        (fmb.IDA(rtol=1e-10, atol=1e-10), 1e-6, 5e-5),
        (fmb.IDA(rtol=1e-12, atol=1e-12), 1e-8, 1e-7),
    ],
    ids=["alpha fine", "alpha", "alpha adaptive", "IDA 1e-10", "IDA 1e-12"],
)
def test_position_and_energy(pendulum, reference, integrator, position, energy):
    found, drift = error(pendulum, reference("RB01"), integrator)
    assert found < position
    assert drift < energy
