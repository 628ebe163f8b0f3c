"""A circle that shrinks through its centre, and constraints that only turn."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import flexmb as fmb
from flexmb.errors import IntegrationError


def on_a_circle(radius: str, speed: float = 0.0, **parameters) -> fmb.Model:
    """Return a point in the plane z = 0 on a circle about the origin."""
    place = fmb.Position("p", marker="bob.center")
    radius_at_start = 0.5
    return fmb.Model(
        bodies=[fmb.Ground(), fmb.PointMass("bob", mass=1.0, at=(radius_at_start, 0, 0), velocity=(0, speed, 0))],
        joints=[
            fmb.Constraint("ring", over=[place], equation=f"p[0]**2 + p[1]**2 = ({radius})**2", parameters=parameters),
            fmb.Constraint("flat", over=[place], equation="p[2]"),
        ],
        sensors=[place],
    )


@pytest.mark.parametrize("integrator", [fmb.GeneralizedAlpha(step=0.01), fmb.Explicit()], ids=repr)
def test_a_circle_that_shrinks_through_its_centre_ends_the_run(integrator):
    model = on_a_circle("0.5*cos(t)")
    with pytest.raises(
        IntegrationError, match=r"Joint 'ring'.*vanishes near t = 1\.5|step size fell below.* at t = 1\.5.*ring"
    ) as caught:
        fmb.simulate(model, 3.0, samples=38, integrator=integrator)
    assert caught.value.solution.t[-1] < 1.7  # pi / 2


@pytest.mark.parametrize("integrator", [fmb.GeneralizedAlpha(), fmb.Explicit()], ids=repr)
def test_a_circle_whose_area_shrinks_to_nothing_is_named(integrator):
    """R = (0.25 - t)^1/2: the point becomes infinitely fast, and no step comes to the end at 0.25 s."""
    ring = on_a_circle("0.5")
    joints = [ring.joint("flat"), replace(ring.joint("ring"), equation="p[0]**2 + p[1]**2 = 0.25 - t")]
    with pytest.raises(IntegrationError, match=r"Joint 'ring': the gradient .* shrinks to nothing towards t = 0\.25 s"):
        fmb.simulate(replace(ring, joints=joints), 0.6, samples=4, integrator=integrator)


def test_a_stepped_run_tells_it_too():
    with fmb.stepper(on_a_circle("0.5*cos(t)"), integrator=fmb.GeneralizedAlpha(step=0.01)) as run:
        run.advance(to=1.5)
        with pytest.raises(IntegrationError, match=r"the gradient of its equation vanishes near t = 1\.57"):
            run.advance(to=1.65)


@pytest.mark.parametrize("samples", [2, 5, 31, 301])
def test_constraints_that_turn_go_on(samples):
    """A point that goes round, from half a turn between samples to a hundredth, and one on a ring that breathes."""
    round_ = fmb.simulate(on_a_circle("0.5", speed=2.0), 3.0, samples=samples)
    breathing = fmb.simulate(on_a_circle("0.3 + 0.2*cos(7*t)", speed=1.5), 3.0, samples=samples)
    assert round_.status.ok
    assert breathing.status.ok
    np.testing.assert_allclose(np.linalg.norm(round_["p"][:, :2], axis=1), 0.5, atol=1e-6)
    radius = 0.3 + 0.2 * np.cos(7.0 * breathing.t)
    np.testing.assert_allclose(np.linalg.norm(breathing["p"][:, :2], axis=1), radius, atol=1e-6)


def test_the_half_turn_is_seen_as_a_turn():
    solution = fmb.simulate(on_a_circle("0.5", speed=2.0), 3.0, samples=np.arange(0.0, 3.0, np.pi / 4 / 4))
    assert np.linalg.norm(solution["p"][:, :2], axis=1) == pytest.approx(0.5, abs=1e-6)


def on_a_turning_line(pace: str) -> fmb.Model:
    """Return a point on a line through the origin that turns with 20 rad/s; its equation is multiplied by the pace."""
    place = fmb.Position("p", marker="bob.center")
    line = f"({pace})*(p[0]*sin(20*t) - p[1]*cos(20*t)) = 0"
    return fmb.Model(
        bodies=[fmb.Ground(), fmb.PointMass("bob", mass=1.0, at=(1e-3, 0, 0), velocity=(0, 0.02, 0))],
        joints=[
            fmb.Constraint("line", over=[place], equation=line),
            fmb.Constraint("flat", over=[place], equation="p[2]"),
        ],
        sensors=[place],
    )


@pytest.mark.parametrize("integrator", [fmb.GeneralizedAlpha(step=0.002), fmb.IDA()], ids=lambda i: type(i).__name__)
@pytest.mark.parametrize("samples", [2, 5, 38])
def test_what_turns_far_between_samples_is_judged_too(integrator, samples):
    """Up to 40 rad between two samples; the equation is empty at t = 0.5."""
    with pytest.raises(IntegrationError, match=r"Joint 'line'.*vanishes near t = 0\.[45]|at t = 0\.[45]"):
        fmb.simulate(on_a_turning_line("0.5 - t"), 2.0 if samples > 2 else 0.8, samples=samples, integrator=integrator)


def test_a_stepped_run_judges_within_its_steps():
    with (
        fmb.stepper(on_a_turning_line("0.5 - t"), integrator=fmb.GeneralizedAlpha(step=0.002)) as run,
        pytest.raises(IntegrationError, match=r"Joint 'line'.*vanishes near t = 0\.5"),
    ):
        run.advance(to=0.8)


@pytest.mark.parametrize("samples", [2, 5])
def test_lines_that_turn_far_between_samples_go_on(samples):
    """r'' = w^2 r from rest along the line: 1e-3 cosh(20 t)."""
    run = fmb.simulate(on_a_turning_line("1.5 - t"), 0.4, samples=samples, integrator=fmb.GeneralizedAlpha(rtol=1e-7))
    found = np.linalg.norm(run["p"][:, :2], axis=1)
    np.testing.assert_allclose(found, 1e-3 * np.cosh(20.0 * run.t), rtol=1e-3)
