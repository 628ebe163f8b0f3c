"""RB17: a mass on a spring with Coulomb friction: every half swing loses 2 mu m g / k, then it sticks.

Reference: closed form; 1e-3 with regularised friction.
"""

import numpy as np
import pytest

import flexmb as fmb


def test_turning_points_and_rest(reference):
    case = reference("RB17")
    m = case["model"]
    model = fmb.Model(
        gravity=(0, 0, -m["g"]),
        bodies=[
            fmb.Ground(markers={"rail": fmb.Pose.axes(z=(1, 0, 0)), "wall": (-1.0, 0, 0)}),
            fmb.RigidBody(
                "block",
                mass=m["m"],
                inertia=(0.1, 0.1, 0.1),
                at=(0.1, 0, 0),
                markers={"shoe": fmb.Pose.axes(z=(1, 0, 0))},
            ),
        ],
        joints=[fmb.Prismatic("rail", markers=("ground.rail", "block.shoe"))],
        forces=[
            fmb.SpringDamper("spring", markers=("ground.wall", "block.center"), stiffness=m["k"], length=1.0),
            fmb.JointFriction("friction", joint="rail", moving=m["mu"], transition=1e-4),
        ],
        sensors=[fmb.JointCoordinate("x", joint="rail"), fmb.Energy("energy"), fmb.Energy("lost", kind="dissipated")],
    )
    times = np.linspace(0.0, 2.0, 2001)
    solution = fmb.simulate(model, 2.0, samples=times, integrator=fmb.GeneralizedAlpha(rtol=1e-6))
    x, points = solution["x"], case["reference"]["turning_points"]
    half = np.pi / np.sqrt(m["k"] / m["m"])
    for k, expected in enumerate(points):
        assert np.interp(k * half, times, x) == pytest.approx(expected, abs=1e-3)
    # afterwards it creeps with a fraction of the transition speed
    assert x[-1] == pytest.approx(case["reference"]["rest_position"], abs=1e-3)
    np.testing.assert_allclose(solution["energy"] + solution["lost"], solution["energy"][0], atol=1e-3)
