"""CT01: impact of a steel sphere on a steel half-space: deepest penetration, largest force and duration.

Reference: closed form of Hertz (Timoshenko & Goodier, Theory of Elasticity, section 142); 0.5 %.
"""

import pytest

import flexmb as fmb


def test_impact(reference):
    case = reference("CT01")
    m, r = case["model"], case["reference"]
    steel = fmb.Material(young=m["E"], poisson=m["nu"], density=m["rho"])
    stiffness = fmb.Contact.hertz_stiffness(m["R"], steel)
    assert stiffness == pytest.approx(m["k"], rel=1e-9)
    model = fmb.Model(
        bodies=[
            fmb.Ground(),
            fmb.RigidBody.sphere("ball", radius=m["R"], density=m["rho"], at=(0, 0, m["R"]), velocity=(0, 0, -m["v"])),
        ],
        forces=[fmb.Contact("hit", markers=("ground.origin", "ball.center"), radius=m["R"], stiffness=stiffness)],
        sensors=[
            fmb.Position("at", marker="ball.center"),
            fmb.Velocity("v", marker="ball.center"),
            fmb.ForceOf("force", force="hit"),
        ],
    )
    solution = fmb.simulate(model, 3e-4, samples=3001, integrator=fmb.GeneralizedAlpha(rho_inf=0.95, step=1e-7))
    force = solution["force"][:, 2]
    assert (m["R"] - solution["at"][:, 2]).max() == pytest.approx(r["delta_max"], rel=5e-3)
    assert force.max() == pytest.approx(r["F_max"], rel=5e-3)
    touching = solution.t[force > 0.0]
    assert touching[-1] - touching[0] == pytest.approx(r["T"], rel=5e-3)
    assert solution["v"][-1, 2] == pytest.approx(m["v"], rel=1e-3)
