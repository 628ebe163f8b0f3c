"""RB13: chain of six links towed at one end (after Wang & Huston 1988); the prescribed motion tests the multipliers.

The moving end hangs on a cart of 1 g on a rail (links weigh 14.6 kg). Reached over 1 s: generalized-alpha, h = 1e-4:
4.5e-6 m, force 7e-5; adaptive at 1e-8: 2e-5 m; IDA at 1e-9: 1e-5 m; DOP853 with four
formulations: 4.1e-6 m, force 6.5e-5, alike to 2e-10 m: this is the effect of the cart.
"""

import numpy as np
import pytest
from verification.mechanisms import towing_chain

import flexmb as fmb

POSITION, FORCE = 1e-4, 5e-3


@pytest.mark.parametrize(
    "integrator",
    [
        fmb.GeneralizedAlpha(step=1e-4),
        fmb.GeneralizedAlpha(rtol=1e-8),
        fmb.IDA(rtol=1e-9, atol=1e-9),
        *(
            fmb.Explicit(formulation=f)
            for f in (fmb.Augmented(), fmb.NullSpace(), fmb.UdwadiaPhohomsiri(), fmb.Recursive())
        ),
    ],
    ids=["alpha", "alpha adaptive", "IDA", "augmented", "null space", "Udwadia-Phohomsiri", "recursive"],
)
def test_joints_and_force(reference, integrator):
    case = reference("RB13")
    expected = case["reference"]
    times = [0.0, *(float(t) for t in expected)]
    solution = fmb.simulate(towing_chain(case), times[-1], samples=times, integrator=integrator)
    for k, state in enumerate(expected.values(), 1):
        joints = [solution[f"p{j}"][k, :2] for j in range(6)]
        np.testing.assert_allclose(joints, state["joints_xy"], atol=POSITION)
        # the reaction is that on the cart; the case gives the force on the chain
        np.testing.assert_allclose(-solution["pull"][k, :2], state["force_on_moving_end_xy"], rtol=FORCE)
