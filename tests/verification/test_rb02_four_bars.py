"""RB02: N-four-bar mechanism (IFToMM A02), which passes configurations where all bars are aligned.

Modelled with revolute joints in space: 3 N of the equations are redundant everywhere, more where the bars are aligned.
Reached at t = 10 s: N = 2: generalized-alpha, h = 1e-3: 1.6e-4 m, energy 9e-4 J; IDA at 1e-8: 4e-5 m.
N = 40: h = 1e-3: 5e-5 m, energy 0.02 J.
"""

import numpy as np
import pytest
from by_turns import slow
from verification.mechanisms import four_bar_places, four_bars

import flexmb as fmb

POSITION, ENERGY = 1e-3, 0.1


def assert_motion(reference, n, integrator):
    expected = reference("RB02")["reference"][f"N={n}"]["B0_xy"]
    solution = fmb.simulate(four_bars(n), 10.0, samples=101, integrator=integrator)
    np.testing.assert_allclose(solution["B0"][-1, :2], expected, atol=POSITION)
    assert np.ptp(solution["energy"]) < ENERGY


@pytest.mark.parametrize(
    "integrator",
    [fmb.GeneralizedAlpha(step=1e-3), fmb.GeneralizedAlpha(rtol=3e-8), fmb.IDA(rtol=1e-8, atol=1e-8)],
    ids=["alpha", "alpha adaptive", "IDA"],
)
def test_two(reference, integrator):
    assert_motion(reference, 2, integrator)


@pytest.mark.slow
def test_forty(reference):
    assert_motion(reference, 40, fmb.GeneralizedAlpha(step=1e-3))


@pytest.mark.parametrize("n", [2, 40])
def test_mobility(n):
    report = fmb.check(four_bars(n))
    assert report.mobility == 1
    assert len(report.redundant) == 3 * n
    assert all(name.startswith("r") for name in report.redundant)


@pytest.mark.parametrize(("n", "step"), [slow(10, 1e-4), (40, 5e-4)])
def test_small_steps_pass_the_aligned_position(n, step):
    """At 0.72 s all bars lie on one line, where rounding shows in the accelerations;
    closed equation of the one freedom.
    """
    solution = fmb.simulate(four_bars(n), 0.8, samples=3, integrator=fmb.GeneralizedAlpha(step=step))
    np.testing.assert_allclose(solution["B0"][-1, :2], four_bar_places(n, 0.8)[n + 1, :2], atol=10.0 * step**2)
