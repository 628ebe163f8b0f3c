"""RB18: a sphere slides on a plane with friction until it rolls: v = 5/7 v0 at t = 2 v0 / (7 mu g).

Reference: closed form, 1e-3 with regularised friction.
"""

import numpy as np
import pytest

import flexmb as fmb


def test_onset_of_rolling(reference):
    case = reference("RB18")
    m, r = case["model"], case["reference"]
    stiffness, exponent = 1e7, 1.5
    rest = (m["m"] * m["g"] / stiffness) ** (1.0 / exponent)
    J = 0.4 * m["m"] * m["r"] ** 2
    model = fmb.Model(
        gravity=(0, 0, -m["g"]),
        bodies=[
            fmb.Ground(),
            fmb.RigidBody("ball", mass=m["m"], inertia=(J, J, J), at=(0, 0, m["r"] - rest), velocity=(2.0, 0, 0)),
        ],
        forces=[
            fmb.Contact(
                "floor",
                markers=("ground.origin", "ball.center"),
                radius=m["r"],
                stiffness=stiffness,
                damping=0.1,
                friction=m["mu"],
                transition=1e-4,
            )
        ],
        sensors=[fmb.Position("at", marker="ball.center"), fmb.Velocity("v", marker="ball.center")],
    )
    times = np.concatenate([np.linspace(0.0, 0.5, 1001), [1.0]])
    solution = fmb.simulate(model, 1.0, samples=times, integrator=fmb.GeneralizedAlpha(rtol=1e-7))
    x, v = solution["at"][:, 0], solution["v"][:, 0]
    assert v[-1] == pytest.approx(r["v_roll"], rel=1e-3)
    onset = np.interp(-(r["v_roll"] + 1e-3), -v[:900], times[:900])
    assert onset == pytest.approx(r["t_roll"], rel=3e-3)
    assert np.interp(r["t_roll"], times, x) == pytest.approx(r["x_roll"], rel=1e-3)
