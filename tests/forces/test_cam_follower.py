"""Followers on cams: lift-off speed in closed form, motion after it by an independent integration, a pawl, energy."""

from dataclasses import replace

import numpy as np
import pytest
from contracts.random_models import random_state
from contracts.test_tangents import assert_tangent
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

import flexmb as fmb
from flexmb.errors import ModelError
from flexmb.io import model_text, read_model_text
from flexmb.system.program import evaluate

M, E, RADIUS, SPRING, PRELOAD, STIFF = 0.5, 0.005, 0.03, 2000.0, 40.0, 2e7
"""kg, m, m, N/m, N, N/m: an eccentric disc under a follower that a spring presses down."""
LIFT_OFF = ((2.0 * SPRING * E + PRELOAD) / (M * E)) ** 0.5
"""rad/s: at the top the spring just accelerates the follower, k 2e + F0 = m e w^2."""


def follower(speed, roller=0.0, **fields):
    """Return the model: the cam begins at the bottom of the lift, and the follower with the force of its motion."""
    rest = PRELOAD + M * E * speed**2
    height = RADIUS + roller - E - rest / STIFF
    return fmb.Model(
        bodies=[
            fmb.Ground(markers={"axis": (0, 0, 0), "guide": fmb.Pose.axes(z=(0, 1, 0), x=(1, 0, 0))}),
            fmb.RigidBody("cam", mass=1.0, inertia=(1e-3, 1e-3, 1e-3), angular_velocity=(0, 0, speed)),
            fmb.RigidBody(
                "follower",
                mass=M,
                inertia=(1e-4, 1e-4, 1e-4),
                at=(0, height, 0),
                markers={"guide": fmb.Pose.axes(z=(0, 1, 0), x=(1, 0, 0))},
            ),
        ],
        joints=[
            fmb.Revolute("axis", markers=("ground.axis", "cam.center")),
            fmb.Prismatic("guide", markers=("ground.guide", "follower.guide")),
            fmb.Drive("turning", joint="axis", angle=fmb.expression("w*t", w=speed)),
        ],
        forces=[
            fmb.CamFollower(
                "contact",
                markers=("cam.center", "follower.center"),
                profile=fmb.Disc(radius=RADIUS, center=(0.0, -E)),
                roller=roller,
                stiffness=STIFF,
                **fields,
            ),
            fmb.PointLoad("preload", marker="follower.center", force=(0, -PRELOAD, 0)),
            fmb.SpringDamper("coil", markers=("ground.axis", "follower.center"), stiffness=SPRING, length=height),
        ],
        sensors=[
            fmb.ForceOf("force", force="contact"),
            fmb.Position("place", marker="follower.center"),
            fmb.Energy("energy"),
        ],
    )


def independent(speed, t, gap):
    """Return height and speed of the follower at times t by SciPy, with gap(y, angle)."""
    start = follower(speed).bodies[2].at[1] if gap is face_gap else follower(speed, ROLLER).bodies[2].at[1]

    def rates(time, x):
        found = gap(x[0], speed * time)
        force = STIFF * max(0.0, -found[0]) * found[1]
        return [x[1], (force - PRELOAD - SPRING * (x[0] - start)) / M]

    found = solve_ivp(rates, (0, t[-1]), [start, 0.0], method="DOP853", t_eval=t, rtol=1e-11, atol=1e-14, max_step=2e-5)
    return found.y


ROLLER = 0.01


def face_gap(y, angle):
    """Return the gap and the share of its normal along y."""
    return y - (RADIUS - E * np.cos(angle)), 1.0


def roller_gap(y, angle):
    high = y + E * np.cos(angle)
    far = np.hypot(E * np.sin(angle), high)
    return far - RADIUS - ROLLER, high / far


def test_force_below_the_speed_of_lift_off():
    """N = F0 + k e (1 - cos wt) + m e w^2 cos wt: with the face on an eccentric, the lift is exactly harmonic."""
    speed = 0.9 * LIFT_OFF
    found = fmb.simulate(follower(speed), t_end=2 * np.pi / speed, samples=121)
    angle = speed * found.t
    expected = PRELOAD + SPRING * E * (1 - np.cos(angle)) + M * E * speed**2 * np.cos(angle)
    # the penetration shares in the lift, and the contact rings with what its spring adds: both of 2 k e / STIFF
    np.testing.assert_allclose(found["force"][:, 1], expected, atol=0.01 * expected.max())
    assert expected.min() > 0.0


@pytest.mark.parametrize(("factor", "lifts"), [(0.97, False), (1.03, True)])
def test_the_speed_of_lift_off(factor, lifts):
    speed = factor * LIFT_OFF
    found = fmb.simulate(follower(speed), t_end=2 * np.pi / speed, samples=401)
    assert (found["force"][:, 1].min() == 0.0) == lifts


@pytest.mark.parametrize("roller", [0.0, ROLLER], ids=["face", "roller"])
def test_bouncing_against_an_independent_integration(roller):
    """At 1.3 of the speed of lift-off the follower jumps; over 1.2 turns, before impacts make it chaotic."""
    speed = 1.3 * LIFT_OFF
    found = fmb.simulate(follower(speed, roller), t_end=1.2 * 2 * np.pi / speed, samples=61, integrator=FINE)
    y, _ = independent(speed, found.t, roller_gap if roller else face_gap)
    assert found["force"][:, 1].min() == 0.0
    np.testing.assert_allclose(found["place"][:, 1], y, atol=1e-6)


FINE = fmb.GeneralizedAlpha(rtol=1e-8, rho_inf=0.95)


def test_a_roller_rolls_through_a_groove_without_loss():
    """A ball of a marble run: no damping, no friction: what it loses in height it has in speed."""
    x = np.linspace(0.5, -0.5, 21)  # the material is below: to the left of a walk to the left
    valley = fmb.SmoothOutline(through=np.column_stack([x, 0.8 * x**2 - 0.05 * np.cos(9.0 * x)]), ends=True)
    model = fmb.Model(
        gravity=(0, -9.81, 0),
        bodies=[
            fmb.Ground(markers={"track": (0, 0, 0)}),
            fmb.RigidBody("ball", mass=0.2, inertia=(1e-5, 1e-5, 1e-5), at=(-0.4, 0.25, 0)),
        ],
        forces=[
            fmb.CamFollower(
                "contact",
                markers=("ground.track", "ball.center"),
                profile=valley,
                roller=0.02,
                stiffness=1e5,
                exponent=1.5,
            )
        ],
        sensors=[fmb.Energy("energy"), fmb.Position("place", marker="ball.center")],
    )
    found = fmb.simulate(model, t_end=0.8, samples=81, integrator=fmb.Explicit(rtol=1e-9))
    assert np.ptp(found["place"][:, 0]) > 0.6
    np.testing.assert_allclose(found["energy"], found["energy"][0], atol=1e-5 * 0.2 * 9.81 * 0.3)


@pytest.mark.parametrize("roller", [0.4, 0.0], ids=["roller", "face"])
def test_tangents_on_a_curved_profile(roller, rng):
    """Against differences, at tilted followers that touch an egg, at rest and in motion."""
    angles = np.arange(6) * np.pi / 3.0
    egg = fmb.SmoothOutline(through=[(1.2 * np.cos(a) + 0.2, np.sin(a) + 0.05 * np.cos(2 * a)) for a in angles])
    frame = Rotation.from_rotvec((0.1, -0.2, 0.3))
    for angle in rng.uniform(0.0, 2.0 * np.pi, 3):
        place = (1.25 if roller else 0.75) * np.array([np.cos(angle), np.sin(angle), 0.1])
        more = {"roller": roller, **({"flanges": (-0.3, 0.05)} if roller else {})}
        moving = {name: rng.normal(size=3) for name in ("velocity", "angular_velocity")}
        cam = fmb.RigidBody("cam", mass=1.0, inertia=(1, 1, 1), rotation=frame)
        tilt = Rotation.from_rotvec((0.1, 0.05, angle - np.pi / 2.0))
        tappet = fmb.RigidBody(
            "tappet", mass=1.0, inertia=(1, 1, 1), at=frame.apply(place), rotation=frame * tilt, **moving
        )
        law = {"stiffness": 300.0, "exponent": 1.5, "damping": 0.05, "friction": 0.3, "transition": 3.0}
        contact = fmb.CamFollower("f", markers=("cam.center", "tappet.center"), profile=egg, **more, **law)
        system, state = random_state(fmb.Model(bodies=[fmb.Ground(), cam, tappet], forces=[contact]), rng)
        work = system.workspace()
        evaluate(system.program, state, work)
        assert np.abs(work.markers["wrench"]).max() > 1.0
        assert_tangent(system, state, blocks=("D",))
        assert_tangent(system, state._replace(u=np.zeros(system.nu)))


def track(**fields):
    """Return a roller in a slot around a circle of 0.3 m, which begins at rest at 0.6 rad from the bottom."""
    angles = np.linspace(-1.2, 1.2, 25)
    slot = fmb.Slot(through=0.3 * np.column_stack([np.sin(angles), -np.cos(angles)]), width=0.0202)
    start = 0.3 + 0.0001  # on the outer wall
    return fmb.Model(
        gravity=(0, -9.81, 0),
        bodies=[
            fmb.Ground(markers={"track": (0, 0, 0)}),
            fmb.RigidBody(
                "roller",
                mass=0.5,
                inertia=(1e-5, 1e-5, 1e-5),
                at=(start * np.sin(0.6), -start * np.cos(0.6), 0.0),
            ),
        ],
        forces=[
            fmb.CamFollower(
                "walls", markers=("ground.track", "roller.center"), profile=slot, roller=0.01, stiffness=1e7, **fields
            )
        ],
        sensors=[
            fmb.Position("place", marker="roller.center"),
            fmb.ForceOf("force", force="walls"),
            fmb.Energy("energy"),
        ],
    )


def test_a_roller_in_a_curved_track():
    """It swings as a pendulum on the outer wall, which presses with m (v^2/r + g cos)."""
    found = fmb.simulate(track(), t_end=0.4, samples=41, integrator=fmb.Explicit(rtol=1e-8))
    radius = 0.3001
    there = solve_ivp(
        lambda _, x: [x[1], -9.81 / radius * np.sin(x[0])], (0, 0.4), [0.6, 0.0], t_eval=found.t, rtol=1e-10, atol=1e-12
    )
    x, y = found["place"][:, 0], found["place"][:, 1]
    np.testing.assert_allclose(np.arctan2(x, -y), there.y[0], atol=1e-5)
    pressed = 0.5 * (radius * there.y[1] ** 2 + 9.81 * np.cos(there.y[0]))
    # it began without its penetration, and rings about the mean
    assert np.mean(np.linalg.norm(found["force"][:, :3], axis=1)) == pytest.approx(np.mean(pressed), rel=0.1)
    np.testing.assert_allclose(np.hypot(x, y), radius, atol=3 * pressed.max() / 1e7)
    np.testing.assert_allclose(found["energy"], found["energy"][0], atol=1e-6)


def test_flanges_hold_a_roller_sideways():
    """A side force of 20 N presses it 2 um into the upper flange: F/k."""
    model = track(flanges=(-0.001, 0.0015), damping=500.0)
    pushed = model.with_parts(forces=[fmb.PointLoad("side", marker="roller.center", force=(0, 0, 20.0))])
    found = fmb.simulate(pushed, t_end=0.3, samples=61)
    assert found["place"][:, 2].max() < 0.0015 + 5e-5
    assert found["place"][-1, 2] == pytest.approx(0.0015 + 20.0 / 1e7, abs=3e-7)


def test_model_files_keep_profiles():
    model = follower(100.0)
    for profile in (
        fmb.Cam(base_radius=0.03, motion=[(3.0, 0.01, "cycloidal"), (2 * np.pi, 0.0, "harmonic")]),
        fmb.Outline(
            start=(0.02, 0), pieces=[fmb.Arc(center=(0, 0), sweep=np.pi), fmb.Spline(through=[(0, -0.03), (0.02, 0)])]
        ),
        fmb.SmoothOutline(through=[(0.03, 0), (0, 0.03), (-0.03, 0), (0, -0.03)]),
    ):
        given = replace(model, forces=[model.forces[0].replaced(profile=profile)])
        read = read_model_text(model_text(given)).forces[0]
        np.testing.assert_array_equal(read.profile.table, profile.table)


@pytest.mark.parametrize(
    ("fields", "words"),
    [
        ({"profile": "disc"}, "a Profile"),
        ({"profile": fmb.Outline(start=(0, 0), pieces=[fmb.Line(to=(1, 0))], ends=True)}, "open profile"),
        ({"stiffness": -1.0}, "stiffness = -1.0"),
        ({"roller": -0.1}, "roller = -0.1"),
        ({"flanges": (0.1, -0.1), "roller": 0.1}, "flanges"),
        ({"flanges": (-0.1, 0.1)}, "of a roller"),
        ({"exponent": 0.5}, "a number >= 1"),
        ({"friction": -0.1}, "friction = -0.1"),
    ],
)
def test_bad_input_is_refused_by_name(fields, words):
    known = {"profile": fmb.Disc(radius=0.1), "stiffness": 1e5, "markers": ("ground.A", "b.A")}
    with pytest.raises(ModelError, match=words):
        fmb.CamFollower("contact", **{**known, **fields})
