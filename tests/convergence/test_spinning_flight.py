"""Bodies that spin while they travel, against closed forms: parabolic flight, a ball that rolls (also on a turning
table).

Their translation is integrated in W, whatever the spin; what joints hold to the ground keeps its own axes.
"""

from dataclasses import replace

import numpy as np
import pytest
from convergence.test_drift import flying

import flexmb as fmb

TIME = 2.0


def flight(integrator, spin, centre=(0.0, 0.0, 0.0)):
    """Return the distance from the parabola (20 m long) at the end, m, and the solution."""
    start = np.array([10.0, 0.0, 10.0])
    ball = fmb.RigidBody(
        "ball",
        mass=1.0,
        inertia=(0.01, 0.02, 0.025),
        at=-np.array(centre),
        center_of_mass=centre,
        velocity=start - np.cross(spin, centre),
        angular_velocity=spin,
    )
    model = fmb.Model(
        gravity=(0, 0, -9.81), bodies=[fmb.Ground(), ball], sensors=[fmb.Position("r", marker="ball.center")]
    )
    solution = fmb.simulate(model, TIME, samples=3, integrator=integrator)
    place = start * TIME - np.array([0.0, 0.0, 0.5 * 9.81 * TIME**2])
    return float(np.linalg.norm(solution["r"][-1] - place)), solution


@pytest.mark.parametrize("spin", [20.0, 200.0])
@pytest.mark.parametrize("rtol", [1e-6, 1e-8])
def test_the_parabola_is_exact_and_needs_few_steps(spin, rtol):
    error, solution = flight(fmb.GeneralizedAlpha(rtol=rtol), (0.0, 0.0, spin))
    assert error < 1e-11
    assert solution.statistics["steps"] < 50


def test_a_tumbling_body_keeps_to_the_parabola_at_fixed_steps():
    assert flight(fmb.GeneralizedAlpha(step=0.01), (5.0, 20.0, 3.0))[0] < 1e-7


def test_second_order_where_the_origin_is_off_the_centre_of_mass():
    spin, centre = (2.0, 5.0, 1.0), (0.1, -0.05, 0.02)
    coarse, fine = (flight(fmb.GeneralizedAlpha(step=h), spin, centre)[0] for h in (4e-3, 2e-3))
    assert coarse / fine == pytest.approx(4.0, rel=0.1)


@pytest.mark.parametrize(("integrator", "bound"), [(fmb.Explicit(), 1e-5), (fmb.IDA(), 1e-2)], ids=["explicit", "IDA"])
def test_other_methods_keep_to_the_parabola(integrator, bound):
    assert flight(integrator, (0.0, 0.0, 20.0))[0] < bound


def test_a_ball_rolls_straight_with_steps_of_a_radian():
    radius, spin = 0.1, 20.0
    ball = fmb.RigidBody(
        "ball",
        mass=1.0,
        inertia=(0.004,) * 3,
        at=(0, 0, radius),
        velocity=(spin * radius, 0, 0),
        angular_velocity=(0, spin, 1.0),
    )
    rolling = fmb.Rolling("rolling", markers=("ground.origin", "ball.center"), radius=radius, disc=False)
    model = fmb.Model(
        gravity=(0, 0, -9.81),
        bodies=[fmb.Ground(), ball],
        joints=[rolling],
        sensors=[fmb.Position("r", marker="ball.center"), fmb.Reaction("force", joint="rolling")],
    )
    solution = fmb.simulate(model, 5.0, samples=6, integrator=fmb.GeneralizedAlpha(step=1.0 / spin))
    np.testing.assert_allclose(solution["r"][:, 0], spin * radius * solution.t, atol=1e-10)
    np.testing.assert_allclose(solution["force"][:, 2], 9.81, atol=1e-8)


def table(turn, integrator):
    """Return the path of a ball on a table that turns, started where its centre goes round in a circle at
    2/7 of the turn.
    """
    radius, distance = 0.1, 0.5
    disc = fmb.RigidBody("disc", mass=1e4, inertia=(5e5, 5e5, 1e6), angular_velocity=(0, 0, turn))
    ball = fmb.RigidBody(
        "ball",
        mass=2.0,
        inertia=(0.4 * 2.0 * radius**2,) * 3,
        at=(distance, 0, radius),
        velocity=(0, 2.0 / 7.0 * turn * distance, 0),
        angular_velocity=(5.0 / 7.0 * turn * distance / radius, 0, 0),
    )
    joints = [
        fmb.Revolute("axle", markers=("ground.origin", "disc.center")),
        fmb.Rolling("rolling", markers=("disc.center", "ball.center"), radius=radius, disc=False),
    ]
    model = fmb.Model(
        gravity=(0, 0, -9.81),
        bodies=[fmb.Ground(), disc, ball],
        joints=joints,
        sensors=[fmb.Position("r", marker="ball.center"), fmb.Reaction("force", joint="rolling")],
    )
    return fmb.simulate(model, 3.0, samples=4, integrator=integrator)


def test_ball_on_a_turning_table_circles_at_two_sevenths_of_its_speed():
    """Fixed steps of 0.11, 0.21 and 0.43 of a radian of the ball's spin: stable, and of second order."""
    turn, errors = 10.0, []
    for h in (3e-3, 6e-3, 12e-3):
        solution = table(turn, fmb.GeneralizedAlpha(step=h))
        angle = 2.0 / 7.0 * turn * solution.t[-1]
        errors.append(np.linalg.norm(solution["r"][-1, :2] - 0.5 * np.array([np.cos(angle), np.sin(angle)])))
        np.testing.assert_allclose(np.linalg.norm(solution["r"][:, :2], axis=1), 0.5, atol=300.0 * h * h)
    assert errors[-1] < 0.2
    np.testing.assert_allclose(np.log2(np.array(errors[1:]) / errors[:-1]), 2.0, atol=0.2)


def test_multipliers_and_velocities_of_free_bodies_on_a_hinge_are_of_second_order():
    """The two bodies of test_drift, against the explicit method at 1e-11."""
    model = replace(
        flying(),
        sensors=[
            fmb.Position("r", marker="b.center"),
            fmb.Velocity("v", marker="b.center"),
            fmb.Reaction("force", joint="j"),
        ],
    )

    def end(integrator):
        solution = fmb.simulate(model, 1.0, samples=2, integrator=integrator)
        return [solution[name][-1] for name in ("r", "v", "force")]

    exact = end(fmb.Explicit(rtol=1e-11, atol=1e-12))
    errors = np.array(
        [
            [np.linalg.norm(x - y) for x, y in zip(end(fmb.GeneralizedAlpha(step=h)), exact, strict=True)]
            for h in (2e-3, 1e-3)
        ]
    )
    np.testing.assert_allclose(np.log2(errors[0] / errors[1]), 2.0, atol=0.15)


@pytest.mark.parametrize("held", [False, True], ids=["free", "ball"])
@pytest.mark.parametrize(("spin", "samples"), [(10.0, 2), (10.0, 101), (0.1, 2)])
def test_steps_of_implicit_follow_a_steady_spin(held, spin, samples):
    """The rates have no error at any step, the Euler parameters have: an angle of 100 rad is right to a milliradian."""
    ground = fmb.Ground()
    body = fmb.RigidBody("body", mass=1.0, inertia=(0.1, 0.1, 0.2), angular_velocity=(0, 0, spin))
    joints = [fmb.Spherical("ball", markers=(f"{ground.name}.origin", "body.center"))] if held else []
    model = fmb.Model(bodies=[ground, body], joints=joints)
    t_end = 100.0 / spin
    solution = fmb.simulate(model, t_end, samples=samples, integrator=fmb.Implicit())
    e0, _, _, e3 = solution.final.q[-4:]
    turned = 2.0 * np.arctan2(e3, e0)
    assert abs(np.sin(0.5 * (turned - 100.0))) < 5e-4
    assert solution.statistics["steps"] < 500
    assert solution.statistics["errors added up"] < 1e-3
