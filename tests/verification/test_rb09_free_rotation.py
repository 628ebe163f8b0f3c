"""RB09: free body that turns about its intermediate axis (Dzhanibekov); Euler's equations, Jacobi elliptic functions.

Reached over 40 s, two flips: generalized-alpha, h = 1e-3: 3.5e-7, angular momentum 2e-7; IDA at 1e-10: 1.2e-7; at
1e-12: 2e-9, energy and angular momentum 1e-9.
"""

import numpy as np
import pytest

import flexmb as fmb


@pytest.mark.parametrize(
    ("integrator", "tolerance", "drift"),
    [(fmb.GeneralizedAlpha(step=1e-3), 1e-6, 1e-6), (fmb.IDA(rtol=1e-12, atol=1e-12), 1e-7, 1e-9)],
    ids=["alpha", "IDA"],
)
def test_flips(reference, integrator, tolerance, drift):
    expected = reference("RB09")["reference"]["states"]
    body = fmb.RigidBody("body", mass=1.0, inertia=(1, 2, 3), angular_velocity=(0.01, 1, 0.01))
    sensors = [fmb.Orientation("p", marker="body.center"), fmb.Energy("energy"), fmb.Momentum("momentum")]
    model = fmb.Model(bodies=[fmb.Ground(), body], sensors=sensors)
    times = [0.0, *(float(t) for t in expected)]
    solution = fmb.simulate(model, times[-1], samples=times, integrator=integrator)
    spin = solution.phases[0].u[1:, 3:6]
    np.testing.assert_allclose(spin, [x["omega_body"] for x in expected.values()], atol=tolerance)
    for found, state in zip(solution["p"][1:], expected.values(), strict=True):
        p = np.array(state["quat_body_to_world"])
        np.testing.assert_allclose(found * np.sign(found @ p), p, atol=tolerance)
    assert np.ptp(solution["energy"]) < drift
    assert np.abs(solution["momentum"] - solution["momentum"][0]).max() < drift
