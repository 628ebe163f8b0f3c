"""Rolling without slip against closed forms; the slope of velocity-level rows against differences."""

import numpy as np
import pytest
from contracts.random_models import derivative, moved, random_state

import flexmb as fmb
from flexmb.integrate.matrices import equations_at
from flexmb.math.weights import no_matrix, weigh
from flexmb.system.program import evaluate


def ball(slope=0.3, **fields):
    m, r = 2.0, 0.25
    J = 0.4 * m * r * r
    return fmb.Model(
        gravity=(9.81 * np.sin(slope), 0, -9.81 * np.cos(slope)),
        bodies=[fmb.Ground(), fmb.RigidBody("ball", mass=m, inertia=(J, J, J), at=(0, 0, r), **fields)],
        joints=[fmb.Rolling("rolling", markers=("ground.origin", "ball.center"), radius=r, disc=False)],
        sensors=[
            fmb.Position("r", marker="ball.center"),
            fmb.Reaction("force", joint="rolling"),
            fmb.Energy("energy"),
        ],
    )


@pytest.mark.parametrize(
    "integrator",
    [fmb.GeneralizedAlpha(rho_inf=0.9, step=2.5e-4), fmb.IDA(rtol=1e-9, atol=1e-11)],
    ids=["alpha", "IDA"],
)
def test_ball_on_a_slope(integrator):
    """a = 5/7 g sin(slope), friction 2/7 m g sin(slope) up the slope, normal force m g cos(slope)."""
    slope = 0.3
    solution = fmb.simulate(ball(slope), 2.0, samples=21, integrator=integrator)
    a = 5.0 / 7.0 * 9.81 * np.sin(slope)
    np.testing.assert_allclose(solution["r"][:, 0], 0.5 * a * solution.t**2, atol=1e-5)
    np.testing.assert_allclose(solution["force"][:, 0], -2.0 / 7.0 * 2.0 * 9.81 * np.sin(slope), atol=1e-4)
    np.testing.assert_allclose(solution["force"][:, 2], 2.0 * 9.81 * np.cos(slope), atol=5e-4)
    assert np.ptp(solution["energy"]) < 1e-5 * 2.0 * 9.81


def test_velocity_is_made_consistent():
    """A ball described with velocity and without spin starts rolling with its momentum about the contact point."""
    model = ball(0.0, velocity=(1.0, 0, 0))
    solution = fmb.simulate(model, 1.0, samples=3, integrator=fmb.GeneralizedAlpha(rho_inf=0.9, step=2.5e-4))
    np.testing.assert_allclose(solution["r"][:, 0], 5.0 / 7.0 * solution.t, atol=1e-6)


def test_rank_counts_velocities():
    report = fmb.check(ball())
    assert report.mobility == 3


@pytest.mark.parametrize("disc", [True, False])
def test_slope_of_the_residual(disc, rng):
    """d(A u)/dq at constant velocities in body axes, by the weights (1, gamma c / (beta h), c)."""
    bodies = [
        fmb.RigidBody(
            name,
            mass=1.0,
            inertia=(1, 1.2, 1.5),
            at=rng.normal(size=3),
            rotation=rng.normal(size=3),
            markers={"m": fmb.Pose(rng.normal(size=3) * 0.3, rng.normal(size=3))},
        )
        for name in "ab"
    ]
    model = fmb.Model(
        bodies=[fmb.Ground(), *bodies],
        joints=[fmb.Rolling("j", markers=("a.m", "b.m"), radius=0.4, disc=disc)],
    )
    system, state = random_state(model, rng)
    work = system.workspace()
    A = equations_at(system, state, work).G.toarray()[1:]

    def residual(now):
        no_matrix(work.weights)
        evaluate(system.program, now, work)
        return work.equations["g"][1:].copy()

    from flexmb.math.block_pattern import stored

    weigh(work.weights, 1.0, 2.0, 0.5)
    evaluate(system.program, state, work)
    row = stored(work.S, system.program.pattern).toarray()[system.nu + 1 :, : system.nu]
    expected = np.array(
        [derivative(lambda x, d=d: residual(moved(system, state, d, x)), 1e-2) for d in np.eye(system.nu)]
    ).T
    np.testing.assert_allclose((row - A) / 0.25, expected, atol=1e-6 * np.abs(expected).max())


def test_message():
    with pytest.raises(fmb.ModelError, match="radius = 0"):
        fmb.Rolling("r", markers=("ground.origin", "b.center"), radius=0)
