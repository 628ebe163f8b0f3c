"""RC01: a door on two or three coaxial hinges: five equations of every further hinge are redundant.

The motion is unique, the reactions are those of least norm: equal shares. Reached: accelerations 1e-14, angle over 2 s
with generalized-alpha, h = 2e-4: 2e-7 rad, with IDA at 1e-10: 1e-7 rad; the shares 1e-6 N.
"""

import numpy as np
import pytest
from verification.mechanisms import door

import flexmb as fmb

HINGES = {"2 hinges": (-0.5, 0.5), "3 hinges": (-0.5, 0.0, 0.5)}


@pytest.mark.parametrize("name", HINGES)
def test_accelerations_and_shares(reference, name):
    case = reference("RC01")
    model = door(case, HINGES[name])
    found = fmb.accelerations(model)
    expected = case["reference"]
    assert found["door"][4] == pytest.approx(-expected["alpha0"], rel=1e-10)
    share = expected["total_vertical_force0"] / len(HINGES[name])
    for reaction in found.reactions.values():
        np.testing.assert_allclose(reaction, [0, 0, share, 0, 0, 0], atol=1e-5)
    report = fmb.check(model)
    assert report.velocities - report.mobility == expected["rank"][name]
    assert report.equations == expected["equations"][name]
    assert {text.split(":")[0] for text in report.redundant} == set(found.reactions) - {"h0"}


@pytest.mark.parametrize("name", HINGES)
@pytest.mark.parametrize(
    "integrator",
    [fmb.GeneralizedAlpha(step=2e-4), fmb.IDA(rtol=1e-10, atol=1e-10)],
    ids=["alpha", "IDA"],
)
def test_motion(reference, name, integrator):
    case = reference("RC01")
    expected = case["reference"]["angle_from_horizontal_at_t"]
    times = [0.0, *(float(t) for t in expected)]
    solution = fmb.simulate(door(case, HINGES[name]), times[-1], samples=times, integrator=integrator)
    np.testing.assert_allclose(-solution["turn"][1:], list(expected.values()), atol=1e-6)
    share = case["reference"]["total_vertical_force0"] / len(HINGES[name])
    np.testing.assert_allclose(solution["force h0"][0], [0, 0, share, 0, 0, 0], atol=1e-5)
