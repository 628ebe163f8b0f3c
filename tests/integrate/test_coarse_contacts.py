"""Contacts that are closed for a few steps are named, and impacts are resolved however shallow they are.

Reference: a mass on a linear spring that can only press is in contact for half a period, pi sqrt(m/k), and leaves with
the speed at which it came.
"""

import re
import warnings

import numpy as np
import pytest

import flexmb as fmb
from flexmb.integrate.runs.counts import together

H = 1e-3
PHASES = (0.02, 0.3, 0.6, 0.8)
"""Parts of a step at which the contact begins."""
FIXED = {"alpha": fmb.GeneralizedAlpha, "implicit": fmb.Implicit}


def falling(stiffness, speed, height, units=1.0):
    """Return a mass of 1 kg that is so far above a spring, of which a unit of length has `units` to the metre."""
    at = {"at": (0, 0, units * (0.1 + height)), "velocity": (0, 0, -units * speed)}
    contact = fmb.Contact(
        "hit", markers=("ground.origin", "m.center"), radius=0.1 * units, stiffness=stiffness, exponent=1.0
    )
    return fmb.Model(
        bodies=[fmb.Ground(), fmb.RigidBody("m", mass=1.0, inertia=(1, 1, 1), **at)],
        gravity=(0, 0, 0),
        joints=[fmb.Prismatic("A", markers=("ground.origin", "m.center"))],
        forces=[contact],
        sensors=[fmb.Velocity("v", marker="m.center")],
    )


def rebound(steps, phase, integrator, units=1.0):
    """Return the error of the speed after a contact of so many steps of H, the words about it, and the solution."""
    model = falling((np.pi / (steps * H)) ** 2, 1.0, (5.0 + phase) * H, units)
    end = (np.ceil(steps) + 30) * H
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always", fmb.ValidityWarning)
        solution = fmb.simulate(model, end, samples=2, integrator=integrator)
    words = [str(entry.message) for entry in told if "closed and opened" in str(entry.message)]
    return abs(solution["v"][-1, 2] / units - 1.0), words, solution


@pytest.mark.parametrize(
    ("name", "few"), [("alpha", 2), ("alpha", 3.5), ("alpha", 5), ("implicit", 1.5), ("implicit", 2.5)]
)
def test_a_contact_of_a_few_steps_is_named_with_its_error(name, few):
    """What is told bounds the error of the speed, wherever in a step the contact begins, and is not far above it."""
    worst, told = 0.0, 0.0
    for phase in PHASES:
        error, words, solution = rebound(few, phase, FIXED[name](step=H))
        assert len(words) == 1
        assert words[0].startswith("Force 'hit': it closed and opened again within ")
        share = float(re.search(r"up to ([\d.]+) % is wrong", words[0])[1]) / 100.0
        change = float(re.search(r"change of speed of ([\d.]+) m/s", words[0])[1])
        assert share * change >= error
        assert solution.statistics["contacts ended"] == 1
        assert solution.statistics["fewest steps in a contact"] == pytest.approx(few, abs=0.4)
        worst, told = max(worst, error), max(told, share * change)
    assert told < 8.0 * worst


@pytest.mark.parametrize(("name", "enough"), [("alpha", 8.5), ("alpha", 20), ("implicit", 5.5), ("implicit", 10)])
def test_a_contact_of_enough_steps_is_not_named(name, enough):
    for phase in PHASES:
        error, words, _ = rebound(enough, phase, FIXED[name](step=H))
        assert error < 0.02  # of half the change of speed
        assert not words


@pytest.mark.parametrize("name", FIXED)
def test_the_step_that_is_named_resolves_it(name):
    _, words, _ = rebound(2, 0.6, FIXED[name](step=H))
    step = float(re.search(r"Give step=([\d.e-]+),", words[0])[1])
    error, words, _ = rebound(2, 0.6, FIXED[name](step=step))
    assert error < 0.02
    assert not words


def test_millimetres_say_the_same():
    in_metres, in_millimetres = (rebound(3, 0.6, fmb.GeneralizedAlpha(step=H), units) for units in (1.0, 1e3))
    assert in_metres[0] == pytest.approx(in_millimetres[0], rel=1e-6)
    assert re.sub(r"of [\d.e+]+ m/s", "", in_metres[1][0]) == re.sub(r"of [\d.e+]+ m/s", "", in_millimetres[1][0])


def test_a_stop_of_a_hinge_is_named_too():
    """5 rad/s against a stop of 2.5 steps: in rad/s."""
    rod = fmb.RigidBody("rod", mass=1.0, inertia=(1, 1, 1), angular_velocity=(0, 0, 5.0))
    stiffness = (np.pi / (2.5 * H)) ** 2
    model = fmb.Model(
        bodies=[fmb.Ground(), rod],
        gravity=(0, 0, 0),
        joints=[fmb.Revolute("A", markers=("ground.origin", "rod.center"))],
        forces=[fmb.BiStop("stops", joint="A", travel=(-0.05, 0.0513), stiffness=stiffness)],
    )
    with pytest.warns(fmb.ValidityWarning, match=r"'stops': it closed .* rad/s, of which"):
        fmb.simulate(model, 0.03, samples=2, integrator=fmb.GeneralizedAlpha(step=H))


@pytest.mark.parametrize("name", FIXED)
@pytest.mark.parametrize("stiffness", [1e4, 1e6, 1e8, 1e10])
@pytest.mark.parametrize("speed", [1e-5, 1e-3, 1.0])
def test_slow_impacts_on_hard_springs_keep_their_speed(name, stiffness, speed):
    """By default tolerances, down to depths of 1e-10 m in a model of 0.1 m: no step passes over the change of speed."""
    model = falling(stiffness, speed, 0.25 * speed)
    solution = fmb.simulate(model, 1.0, samples=2, integrator=FIXED[name]())
    assert solution["v"][-1, 2] == pytest.approx(speed, rel=0.01)
    assert solution.statistics["fewest steps in a contact"] > FIXED[name].steps_in_contact


@pytest.mark.parametrize("name", FIXED)
def test_coarse_tolerances_are_named(name):
    """A variable step with rtol=0.01 takes a few steps in a contact; where the rebound is off, it is said."""
    found = 0
    for stiffness in (1e3, 1e4, 1e5):
        with warnings.catch_warnings(record=True) as told:
            warnings.simplefilter("always", fmb.ValidityWarning)
            solution = fmb.simulate(falling(stiffness, 1.0, 0.3), 1.0, samples=2, integrator=FIXED[name](rtol=1e-2))
        words = [str(entry.message) for entry in told]
        if abs(solution["v"][-1, 2] - 1.0) > 0.01:
            found += 1
            assert any("'hit': it closed and opened" in text for text in words)
        assert all("smaller rtol than 0.01" in text for text in words if "closed and opened" in text)
    assert found


def test_steps_from_outside_name_it():
    run = fmb.stepper(falling((np.pi / (3 * H)) ** 2, 1.0, 5.6 * H), integrator=fmb.GeneralizedAlpha(step=H))
    assert run.advance(by=33 * H)
    with pytest.warns(fmb.ValidityWarning, match="'hit': it closed and opened again within 3"):
        solution = run.solution
    assert solution.statistics["contacts ended"] == 1


def test_the_fewest_of_two_parts_of_a_run():
    parts = {"fewest steps": 7.5, "steps": 10}, {"fewest steps": 3.0, "steps": 5}
    assert together(*parts) == {"fewest steps": 3.0, "steps": 15}
    assert together({"steps": 1}, {"fewest steps": 3.0}) == {"steps": 1, "fewest steps": 3.0}
