"""RB03: Andrews' squeezing mechanism (IFToMM A03; Hairer & Wanner II; IVP test set), seven bodies, crank at 1140 rad/s.

Ten revolute joints in space: nine equations are redundant; the reactions in the plane are unique and equal to the
multipliers of the reference. Reached at t = 0.03 s: generalized-alpha, h = 2e-6: 4.4e-6 rad, forces 8e-4 N of 199 N;
IDA at 1e-6: 4e-4 rad. DOP853 with all formulations: 1.4e-9 rad (the accuracy of the reference), forces 1.5e-5 N.
"""

import numpy as np
import pytest
from by_turns import slow
from verification.mechanisms import andrews

import flexmb as fmb

ORDER = ("O", "K", "B", "H4", "A5", "H6", "A7")


def run(case, integrator, samples=301):
    """Return the largest error of the angles (rad) and of the loop forces (N) at the end."""
    solution = fmb.simulate(andrews(case), case["duration_s"], samples=samples, integrator=integrator)
    angles = np.array([solution[f"angle {name}"] for name in ORDER])
    expected = np.array(case["reference"]["q"]) - case["initial_conditions"]["q0"]
    # the reference counts from the drawing, and the sum of crank and first link turns once more than the crank
    difference = np.angle(np.exp(1j * (angles[:, -1] - angles[:, 0] - expected)))
    forces = np.concatenate([solution[f"force P{k}"][-1, :2] for k in (3, 4, 6)])
    return np.abs(difference).max(), np.abs(forces - case["reference"]["lam"]).max()


def test_initial_accelerations(reference):
    case = reference("RB03")
    found = fmb.accelerations(andrews(case))
    crank, link = found["k1"][5], found["k2"][5]
    np.testing.assert_allclose([crank, link - crank], case["initial_conditions"]["a0"][:2], rtol=1e-11)
    forces = np.concatenate([found.reactions[f"P{k}"][:2] for k in (3, 4, 6)])
    np.testing.assert_allclose(forces, case["initial_conditions"]["lambda0"], atol=1e-8)


@pytest.mark.parametrize(
    ("integrator", "angle", "force"),
    [
        slow(fmb.GeneralizedAlpha(step=2e-6), 1e-5, 5e-3),
        (fmb.GeneralizedAlpha(rtol=1e-8), 2e-4, 0.1),
        (fmb.IDA(rtol=1e-8, atol=1e-10), 1e-4, 0.02),
    ],
    ids=["alpha", "alpha adaptive", "IDA"],
)
def test_motion_and_forces(reference, integrator, angle, force):
    angles, forces = run(reference("RB03"), integrator)
    assert angles < angle
    assert forces < force


@pytest.mark.parametrize(
    "formulation",
    [
        fmb.Augmented(),
        fmb.NullSpace(),
        slow(fmb.UdwadiaPhohomsiri()),
        fmb.Recursive(),
        slow(fmb.Baumgarte(fmb.NullSpace(), alpha=100.0, beta=100.0)),
    ],
    ids=repr,
)
def test_formulations_agree(reference, formulation):
    """DOP853 on the accelerations of each formulation; Radau in the test below."""
    angles, forces = run(reference("RB03"), fmb.Explicit(rtol=1e-9, atol=1e-10, formulation=formulation), samples=61)
    assert angles < 1e-7
    assert forces < 1e-3


@pytest.mark.slow
def test_radau(reference):
    angles, forces = run(reference("RB03"), fmb.Explicit(method="Radau", rtol=1e-7, atol=1e-8), samples=61)
    assert angles < 1e-5
    assert forces < 0.05


def test_mobility(reference):
    report = fmb.check(andrews(reference("RB03")))
    assert report.mobility == 1
    assert len(report.redundant) == 9
