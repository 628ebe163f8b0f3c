"""A block on a rough rail, pulled by a spring whose end moves slowly: it sticks, breaks away, slips and sticks again.

References: the spring breaks the block away at the largest friction, ``standing N`` but for the regularisation; the
equation of this one freedom solved by SciPy's Radau (Hairer & Wanner 1996, IV.8).
"""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import flexmb as fmb

MASS, K, NORMAL, STANDING, MOVING, STRIBECK, SPEED = 1.0, 100.0, 10.0, 0.4, 0.2, 1e-3, 0.01


def block(transition: float) -> fmb.Model:
    along = fmb.Pose.axes((0, 0, 0), z=(1, 0, 0))
    parts = [
        fmb.RigidBody(name, mass=MASS, inertia=(1, 1, 1), at=(x, 0, 0), markers={"rail": along})
        for name, x in (("block", 0.0), ("end", 1.0))
    ]
    return fmb.Model(
        bodies=[fmb.Ground(markers={"rail": along}), *parts],
        joints=[
            fmb.Prismatic("rail", markers=("ground.rail", "block.rail")),
            fmb.Prismatic("guide", markers=("ground.rail", "end.rail")),
            fmb.Drive("pull", joint="guide", displacement=fmb.expression(f"1 + {SPEED} * t")),
        ],
        forces=[
            fmb.SpringDamper("spring", markers=("block.rail", "end.rail"), stiffness=K, length=1.0),
            fmb.JointFriction(
                "rub",
                joint="rail",
                moving=MOVING,
                standing=STANDING,
                stribeck=STRIBECK,
                transition=transition,
                preload=NORMAL,
                from_reaction=False,
            ),
        ],
        sensors=[
            fmb.JointCoordinate("x", joint="rail"),
            fmb.Velocity("v", marker="block.rail"),
            fmb.ForceOf("F", force="spring"),
        ],
    )


@pytest.mark.parametrize("rho_inf", [0.8, 0.4])
@pytest.mark.parametrize("transition", [1e-5, 1e-4])
def test_stick_slip(transition, rho_inf):
    def friction(v):
        return (MOVING + (STANDING - MOVING) * np.exp(-((v / STRIBECK) ** 2))) * NORMAL * np.tanh(v / transition)

    def rates(t, y):
        return y[1], (K * (SPEED * t - y[0]) - friction(y[1])) / MASS

    t = np.linspace(0.0, 7.0, 701)
    exact = solve_ivp(rates, (0.0, 7.0), (0.0, 0.0), "Radau", t, rtol=1e-9, atol=1e-12, max_step=0.01).y
    solution = fmb.simulate(block(transition), 7.0, samples=t, integrator=fmb.GeneralizedAlpha(rho_inf=rho_inf))
    pull = np.linalg.norm(solution["F"][:, :3], axis=1)
    assert pull.max() == pytest.approx(friction(np.linspace(0.0, STRIBECK, 10001)).max(), rel=0.01)
    np.testing.assert_allclose(solution["x"], exact[0], atol=2e-3)  # of a slip of 0.07 m
    sticking = t > 5.0
    np.testing.assert_allclose(solution["v"][sticking, 0], exact[1, sticking], rtol=2e-2, atol=1e-9)
    assert solution.statistics["steps"] < 4000
    assert solution.statistics["rejected by iteration"] < 400
