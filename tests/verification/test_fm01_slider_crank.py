"""FM01: flexible slider-crank of Simeon (1996), IVP test set "crank"; published reference at 0.1 s.

The longitudinal mass block is that of the test set, without its factor 1/15, so that the numbers can be compared.
"""

import numpy as np
import pytest
from verification.simeon_crank import CRANK, rod_angle, rod_data, slider_crank, start

import flexmb as fmb

BAR_MASS = np.array([[8.0, 1.0], [1.0, 2.0]])


@pytest.mark.slow
def test_state_after_two_turns(reference):
    case = reference("FM01")
    rod = fmb.FloatingBody("rod", data=rod_data(BAR_MASS), at=(CRANK, 0, 0))
    model = slider_crank(
        rod,
        sensors=[
            fmb.Position("slider", marker="slider.center"),
            *(fmb.Reaction(joint, joint=joint) for joint in ("B", "guide", "motor")),
        ],
    )
    solution = fmb.simulate(model, 0.1, samples=11, start=start(case), integrator=fmb.IDA(rtol=1e-8, atol=1e-10))
    expected = np.array(case["reference"]["y24"])
    assert rod_angle(solution)[-1] == pytest.approx(expected[1], abs=1e-7)
    assert solution["slider"][-1, 0] == pytest.approx(expected[2], abs=1e-8)
    np.testing.assert_allclose(solution.final.q[14:18], expected[3:7], rtol=0, atol=1e-8)
    np.testing.assert_allclose(solution.final.u[12:16], expected[10:14], rtol=0, atol=3e-4)
    # the published multipliers: forces of the guide and of the rod on the slider, torque of the motor
    across, along, torque = expected[21:24]
    assert solution["guide"][-1, 1] == pytest.approx(-across, rel=3e-4)
    assert solution["B"][-1, 0] == pytest.approx(-along, rel=3e-4)
    assert solution["motor"][-1, 5] == pytest.approx(-torque, rel=3e-4)
