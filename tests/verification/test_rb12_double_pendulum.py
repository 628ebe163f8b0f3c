"""RB12: double pendulum of two point masses, from the horizontal; minimal coordinates.

Reached over 5 s: generalized-alpha, h = 1e-4: 4e-7 m; adaptive at 1e-7: 1.7e-4 m; IDA at 1e-10: 2.4e-8 m.
"""

import numpy as np
import pytest

import flexmb as fmb


@pytest.mark.parametrize(
    ("integrator", "tolerance"),
    [
        (fmb.GeneralizedAlpha(step=1e-4), 1e-6),
        (fmb.GeneralizedAlpha(rtol=1e-8), 1e-4),
        (fmb.IDA(rtol=1e-10, atol=1e-10), 1e-6),
    ],
    ids=["alpha", "alpha adaptive", "IDA"],
)
def test_position(reference, integrator, tolerance):
    expected = reference("RB12")["reference"]
    masses = [fmb.PointMass("one", mass=1.0, at=(1, 0, 0)), fmb.PointMass("two", mass=1.0, at=(2, 0, 0))]
    rods = [
        fmb.Rod("upper", markers=("ground.origin", "one.center")),
        fmb.Rod("lower", markers=("one.center", "two.center")),
    ]
    model = fmb.Model(
        gravity=(0, -9.81, 0),
        bodies=[fmb.Ground(), *masses],
        joints=rods,
        sensors=[fmb.Position("p", marker="two.center")],
    )
    times = [0.0, *(float(t) for t in expected)]
    solution = fmb.simulate(model, times[-1], samples=times, integrator=integrator)
    np.testing.assert_allclose(solution["p"][1:, :2], [x["p2"] for x in expected.values()], atol=tolerance)
