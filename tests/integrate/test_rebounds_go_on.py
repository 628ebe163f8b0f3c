"""Runs with rigid contacts go on from any moment, within a rebound too: after events, sample times, and when resumed.

Reference: Newton's law of impact, a ball that falls from the height h leaves with e sqrt(2 g h), found within a step.
"""

import numpy as np
import pytest

import flexmb as fmb

HEIGHT, RADIUS, E, STEP = 0.05, 0.05, 0.4, 5e-4
STRIKES = float(np.sqrt(2.0 * HEIGHT / 9.81))


def falling(height=HEIGHT, forces=()):
    """Return a ball above a floor, and a cart that others may drive."""
    light = {"inertia": (1e-3, 1e-3, 1e-3)}
    return fmb.Model(
        gravity=(0, 0, -9.81),
        bodies=[
            fmb.Ground(markers={"rail": (2, 0, 0)}),
            fmb.RigidBody("ball", mass=0.5, at=(0, 0, RADIUS + height), **light),
            fmb.RigidBody("cart", mass=1.0, at=(2, 0, 0.05), **light),
        ],
        surfaces=[
            fmb.Surface("floor", marker="ground.origin", shape=fmb.Plane()),
            fmb.Surface("ball", marker="ball.center", shape=fmb.Sphere(RADIUS)),
            fmb.Surface("cart", marker="cart.center", shape=fmb.Sphere(0.2 * RADIUS)),
        ],
        joints=[fmb.Prismatic("rail", markers=("ground.rail", "cart.center"))],
        forces=[fmb.SurfaceContact("hit", surfaces=("floor", ("ball", "cart")), law=fmb.Rigid(restitution=E)), *forces],
        sensors=[fmb.Position("x", marker="ball.center"), fmb.Velocity("v", marker="ball.center")],
    )


def run(model, t_end, samples):
    return fmb.simulate(model, t_end, samples=samples, integrator=fmb.MoreauJean(step=STEP))


def leaves(found) -> None:
    """Look at a run that ends 20 ms after the impact."""
    t = found.t[-1]
    expected = E * 9.81 * STRIKES - 9.81 * (t - STRIKES)
    assert found["v"][-1, 2] == pytest.approx(expected, abs=2.0 * 9.81 * STEP)


def test_a_controller_samples_within_the_rebound():
    place = fmb.JointCoordinate("place", joint="rail")
    drive = fmb.Sampled(fmb.formula("1 - x", over={"x": place}), period=1e-3)
    found = run(falling(forces=[fmb.Actuator("drive", joint="rail", effort=drive)]), 0.12, 241)
    assert found.status.kind == "finished"
    leaves(found)


def test_resumed_within_the_rebound():
    """The ball is still within the floor when the run ends; what goes on is the run in one piece."""
    whole = run(falling(), 0.12, 241)
    inside = np.flatnonzero((whole["x"][:, 2] < RADIUS - 1e-3 * RADIUS) & (whole["v"][:, 2] > 0.0))
    assert len(inside)
    k = int(inside[0])
    first = run(falling(), float(whole.t[k]), k + 1)
    found = fmb.resume(first, 0.12, samples=241, integrator=fmb.MoreauJean(step=STEP))
    leaves(found)
    np.testing.assert_allclose(found["x"][-1], whole["x"][-1], atol=1e-9)


def test_interrupted_just_before_a_controller_samples():
    """What is left of a step is a rounding then: the resumed run is that in one piece."""
    place = fmb.JointCoordinate("place", joint="rail")
    drive = fmb.Sampled(fmb.formula("1 - x", over={"x": place}), period=4e-3)
    model = falling(forces=[fmb.Actuator("drive", joint="rail", effort=drive)])
    whole = run(model, 0.12, 241)
    start = fmb.simulate(model, 0.04 * (1.0 - 3e-12), samples=81, integrator=fmb.MoreauJean(step=STEP))
    found = fmb.resume(start, 0.12, samples=241, integrator=fmb.MoreauJean(step=STEP))
    leaves(found)
    np.testing.assert_allclose(found["x"][-1], whole["x"][-1], atol=1e-9)


def test_overlaps_at_the_start_are_refused():
    with pytest.raises(fmb.FlexmbError, match=r"overlap by 0\.005 m"):
        run(falling(height=-0.005), 0.1, 3)


@pytest.mark.parametrize("t_start", [0.0, 7.0, -2.0])
def test_a_motion_that_begins_late_is_no_rebound(t_start):
    """Bodies drawn into each other are refused whatever the clock says; half the smallest reach is 5 mm here."""
    with pytest.raises(fmb.FlexmbError, match=r"overlap by 0\.004 m"):
        fmb.simulate(
            falling(height=-0.004), t_start + 0.1, t_start=t_start, integrator=fmb.MoreauJean(step=STEP), samples=3
        )


@pytest.mark.parametrize("t_start", [0.0, 3.0])
def test_started_from_an_instant_within_the_rebound(t_start):
    """An instant of another run is where that motion was, inside the floor too, whatever the clock says."""
    whole = run(falling(), 0.12, 241)
    inside = np.flatnonzero((whole["x"][:, 2] < RADIUS - 1e-3 * RADIUS) & (whole["v"][:, 2] > 0.0))
    k = int(inside[0])
    first = run(falling(), float(whole.t[k]), k + 1)
    rest = 0.12 - float(whole.t[k])
    found = fmb.simulate(
        falling(),
        t_start + rest,
        t_start=t_start,
        start=first,
        samples=3,
        integrator=fmb.MoreauJean(step=STEP),
    )
    np.testing.assert_allclose(found["x"][-1], whole["x"][-1], atol=1e-6)
