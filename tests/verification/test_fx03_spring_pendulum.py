"""FX03: a mass on a spring (spring pendulum); minimal coordinates.

Reached over 10 s: generalized-alpha, h = 1e-4: 8.4e-6 (m, m/s); IDA at 1e-10: 4.9e-7, the 1e-6 of the case.
"""

import numpy as np
import pytest

import flexmb as fmb


@pytest.mark.parametrize(
    ("integrator", "tolerance"),
    [(fmb.GeneralizedAlpha(step=2e-4), 5e-5), (fmb.IDA(rtol=1e-10, atol=1e-10), 1e-6)],
    ids=["alpha", "IDA"],
)
def test_motion(reference, integrator, tolerance):
    case = reference("FX03")
    expected = case["reference"]
    model = fmb.Model(
        gravity=(0, -case["model"]["g"], 0),
        bodies=[fmb.Ground(), fmb.PointMass("mass", mass=case["model"]["m"], at=(1.1, 0, 0))],
        forces=[
            fmb.SpringDamper(
                "spring",
                markers=("ground.origin", "mass.center"),
                stiffness=case["model"]["k"],
                length=case["model"]["l0"],
            )
        ],
        sensors=[fmb.Position("p", marker="mass.center"), fmb.Velocity("v", marker="mass.center")],
    )
    times = [0.0, *(float(t) for t in expected)]
    solution = fmb.simulate(model, times[-1], samples=times, integrator=integrator)
    found = np.hstack([solution["p"][1:, :2], solution["v"][1:, :2]])
    np.testing.assert_allclose(found, list(expected.values()), atol=tolerance)
