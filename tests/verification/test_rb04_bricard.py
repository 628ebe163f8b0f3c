"""RB04: Bricard's mechanism (IFToMM A04): one freedom although the count says none; one equation is redundant.

Reached over 10 s: generalized-alpha, h = 1e-3: 3.4e-6 m, energy 8e-7 J; adaptive at 1e-8: 2e-5 m; IDA at 1e-9: 4e-7 m.
"""

import numpy as np
import pytest
from by_turns import slow
from verification.mechanisms import bricard

import flexmb as fmb


def test_mobility(reference):
    report = fmb.check(bricard(reference("RB04")))
    assert (report.mobility, report.gruebler) == (1, 0)
    assert len(report.redundant) == 1
    assert report.redundant[0].startswith("j5")


@pytest.mark.parametrize(
    ("integrator", "position", "energy"),
    [
        (fmb.GeneralizedAlpha(step=1e-3), 1e-5, 1e-5),
        (fmb.GeneralizedAlpha(rtol=1e-8), 1e-4, 1e-4),
        slow(fmb.IDA(rtol=1e-9, atol=1e-9), 1e-6, 1e-4),
    ],
    ids=["alpha", "alpha adaptive", "IDA"],
)
def test_motion(reference, integrator, position, energy):
    case = reference("RB04")
    expected = case["reference"]["P3"]
    times = [0.0, *(float(t) for t in expected)]
    solution = fmb.simulate(bricard(case), times[-1], samples=times, integrator=integrator)
    np.testing.assert_allclose(solution["P3"][1:], [x["P3"] for x in expected.values()], atol=position)
    assert np.ptp(solution["energy"]) < energy


@pytest.mark.parametrize("integrator", [slow(fmb.GeneralizedAlpha(step=2e-3)), fmb.GeneralizedAlpha(rtol=1e-6)])
def test_long_run(reference, integrator):
    """One multiplier is left to chance: what the iteration leaves in it must not grow from step to step."""
    solution = fmb.simulate(bricard(reference("RB04")), 90.0, samples=91, integrator=integrator)
    drift = np.abs(solution["energy"] - solution["energy"][0])
    assert drift[-1] < 1e-3
    assert drift[-1] < 3.0 * drift[45]  # it grows like the time, by numerical damping
