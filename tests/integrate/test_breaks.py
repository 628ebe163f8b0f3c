"""Loads that jump, kink or last shorter than a step: every integrator ends its steps there and begins anew.

The references are closed forms of a mass of 1 kg on a slide: velocity and place after an impulse, and after a step.
"""

import numpy as np
import pytest

import flexmb as fmb
from flexmb.integrate.breaks import just_before, with_breaks
from flexmb.model.breakpoints import RECORD, breakpoints
from flexmb.system import compile

INTEGRATORS = [
    fmb.GeneralizedAlpha(),
    fmb.GeneralizedAlpha(step=0.01),
    fmb.Implicit(),
    fmb.Implicit(step=0.01),
    fmb.Explicit(),
    fmb.Explicit(formulation=fmb.Recursive()),
    fmb.IDA(),
]


def slide(load, **parts):
    """Return a mass of 1 kg on a slide along z with a load."""
    mass = fmb.RigidBody("mass", mass=1.0, inertia=(1, 1, 1))
    return fmb.Model(
        bodies=[fmb.Ground(), mass],
        joints=[fmb.Prismatic("A", markers=("ground.origin", "mass.center"))],
        forces=[fmb.PointLoad("F", marker="mass.center", force=(0, 0, load))],
        gravity=(0, 0, 0),
        sensors=[
            fmb.JointCoordinate("x", joint="A"),
            fmb.Acceleration("a", marker="mass.center"),
            fmb.Energy("energy"),
        ],
        **parts,
    )


@pytest.mark.parametrize(
    ("signal", "times"),
    [
        (fmb.ramp(rate=2.0, rise=0.5, start=1.0), [1.0, 1.5]),
        (fmb.ramp(rate=2.0, start=1.0), [1.0]),
        (fmb.step(3.0, at=0.3), [0.3]),
        (fmb.step(3.0, at=0.3, rise=0.1), [0.3, 0.4]),
        (fmb.harmonic(2.0, 5.0, start=0.2), [0.2]),
        (2.0 * fmb.table([0.0, 1.0, 3.0], [0, 1, 0], kind="linear") - fmb.step(1.0, at=2.0), [0.0, 1.0, 2.0, 3.0]),
        (fmb.table([0.0, 1.0, 3.0], [0, 1, 0], of=fmb.expression("1 - 2*t")), [-1.0, 0.0, 0.5]),
        (fmb.expression("where(t < 2, sin(t), max(1 - t/4, 0)) + abs(3*t - 6)"), [2.0, 4.0]),
        (fmb.expression("step(0.5 - t) * sign(t - 0.1) + smooth((t - 1) / 2)"), [0.1, 0.5, 1.0, 3.0]),
        (fmb.expression("step(sin(t)) + t**2"), []),
        (fmb.table(np.arange(RECORD + 1), np.zeros(RECORD + 1), kind="linear"), [0.0, RECORD]),
    ],
)
def test_breakpoints_of_signals(signal, times):
    np.testing.assert_allclose(breakpoints(signal.program()), times, atol=1e-14)


def test_breakpoints_of_a_model():
    model = slide(fmb.step(1.0, at=0.4))
    model = model.with_parts(joints=[fmb.Drive("d", joint="A", displacement=fmb.step(1.0, at=0.2, rise=0.3))])
    np.testing.assert_allclose(compile(model).breakpoints, [0.2, 0.4, 0.5], atol=1e-15)


@pytest.mark.parametrize("integrator", INTEGRATORS, ids=repr)
def test_a_pulse_between_two_steps_is_not_lost(integrator):
    """A triangle of 1 ms whose impulse is 0.5 Ns, while steps are 10 ms and more; then 0.5 (t - 0.4995)."""
    model = slide(fmb.table([0.499, 0.4995, 0.5], [0.0, 1000.0, 0.0], kind="linear"))
    solution = fmb.simulate(model, 1.0, samples=11, integrator=integrator)
    expected = np.where(solution.t < 0.4999, 0.0, 0.5 * (solution.t - 0.4995))
    np.testing.assert_allclose(solution["x"], expected, atol=1e-4)
    # the product of two sudden steps: 100 N from 0.5003 to 0.5013 s; the second has its left value at its time itself
    pulse = fmb.expression("100 * step(t - 0.5003) * step(0.5013 - t)")
    solution = fmb.simulate(slide(pulse), 1.0, samples=2, integrator=integrator)
    np.testing.assert_allclose(solution["x"][-1], 0.1 * (1.0 - 0.5008), atol=1e-9)


@pytest.mark.parametrize("integrator", INTEGRATORS, ids=repr)
@pytest.mark.parametrize("at", [0.3137, 0.3, 1.0], ids=["between samples", "at a sample", "at the end"])
def test_a_sudden_load(integrator, at):
    """x = F (t - at)^2 / 2: no step has the load on one part of it only; samples at the jump have the load after it."""
    solution = fmb.simulate(slide(fmb.step(10.0, at=at)), 1.0, samples=11, integrator=integrator)
    np.testing.assert_array_equal(solution.t, np.linspace(0.0, 1.0, 11))
    since = np.maximum(solution.t - at, 0.0)
    np.testing.assert_allclose(solution["x"], 5.0 * since**2, atol=1e-9)
    if not isinstance(integrator, fmb.GeneralizedAlpha):
        np.testing.assert_allclose(solution["a"][:, 2], 10.0 * (solution.t >= at - 1e-9), atol=1e-6)
    works = solution.phases[0].works
    np.testing.assert_allclose(works[:, 0], 10.0 * solution["x"], atol=1e-5)
    np.testing.assert_allclose(solution["energy"], works[:, 0], atol=1e-5)


def test_the_order_holds_over_kinks():
    """A rotor on a spring under a zigzag moment, 1 s: half the step, a sixteenth of the error,
    wherever the kinks lie.
    """
    at, moment, n = np.array([0.0, 0.137, 0.291, 0.553, 0.9]), np.array([0.0, 30.0, -20.0, 25.0, 0.0]), np.sqrt(40.0)
    zigzag = fmb.table(at, moment, kind="linear")
    rotor = fmb.RigidBody("rotor", mass=1.0, inertia=(1, 1, 1))
    model = fmb.Model(
        bodies=[fmb.Ground(), rotor],
        joints=[fmb.Revolute("A", markers=("ground.origin", "rotor.center"))],
        forces=[
            fmb.TorsionSpring("k", joint="A", stiffness=40.0),
            fmb.PointLoad("M", marker="rotor.center", moment=(0, 0, zigzag)),
        ],
        sensors=[fmb.JointCoordinate("x", joint="A")],
        gravity=(0, 0, 0),
    )
    corners = np.diff([0.0, *np.diff(moment) / np.diff(at), 0.0])
    exact = np.sum(corners * ((1.0 - at) - np.sin(n * (1.0 - at)) / n)) / n**2
    errors = [
        abs(fmb.simulate(model, 1.0, samples=2, integrator=fmb.Implicit(step=h))["x"][-1] - exact)
        for h in (0.02, 0.01, 0.005, 0.0025)
    ]
    assert min(np.divide(errors[:-1], errors[1:])) > 13.0
    assert errors[-1] < 1e-8


@pytest.mark.parametrize("integrator", [fmb.GeneralizedAlpha(), fmb.Implicit(), fmb.Explicit(), fmb.IDA()], ids=repr)
def test_an_event_at_a_jump(integrator):
    """What the load itself sets off happens when it jumps."""
    event = fmb.Event("on", sensor="a", column=2, above=5.0, then=fmb.Stop())
    solution = fmb.simulate(slide(fmb.step(10.0, at=0.3137), events=(event,)), 1.0, samples=11, integrator=integrator)
    assert solution.status.kind == "stopped"
    assert solution.t[-1] == pytest.approx(0.3137, abs=1e-9)


def test_where_methods_begin_anew():
    """Jumps of loads, of second rates of drives; rates of loads only for methods that remember;
    smooth changes for none.
    """
    drive = fmb.Drive("d", joint="A", displacement=fmb.expression("where(t < 0.5, t**2, t - 0.25)"))
    load = (
        fmb.step(1.0, at=0.2) + fmb.step(1.0, at=0.3, rise=0.05) + fmb.table([0.7, 0.8, 0.9], [0, 1, 0], kind="linear")
    )
    system = compile(slide(load).with_parts(joints=[drive]))
    times = np.array([0.0, 0.5 + 1e-14, 1.0])
    marks, anew = with_breaks(system, times, False)
    np.testing.assert_allclose(anew, [0.2, 0.5], atol=1e-13)
    np.testing.assert_allclose(marks, [0, 0.2, 0.2, 0.3, 0.35, 0.5, 0.5, 0.7, 0.8, 0.9, 1.0], atol=2e-12)
    assert times[1] in marks  # a sample stays as it is
    np.testing.assert_allclose(with_breaks(system, times, True)[1], [0.2, 0.5, 0.7, 0.8, 0.9], atol=1e-13)
    assert not len(with_breaks(compile(slide(1.0)), times, True)[1])


@pytest.mark.parametrize(
    "integrator", [fmb.Implicit(step=0.05), fmb.Implicit(), fmb.Explicit(), fmb.IDA(rtol=1e-10, atol=1e-11)], ids=repr
)
def test_a_drive_whose_acceleration_jumps(integrator):
    """A bead of 2 kg that slides on a driven mass and is pulled by 1 N: it moves as if the mass were not there."""
    drive = fmb.Drive("d", joint="A", displacement=fmb.expression("where(t < 0.53, t**2, 1.06*t - 0.2809)"))
    mass = fmb.RigidBody("mass", mass=1.0, inertia=(1, 1, 1), markers={"ring": (1, 0, 0)})
    bead = fmb.RigidBody("bead", mass=2.0, inertia=(1, 1, 1), at=(1, 0, 0))
    model = fmb.Model(
        bodies=[fmb.Ground(), mass, bead],
        gravity=(0, 0, 0),
        joints=[
            fmb.Prismatic("A", markers=("ground.origin", "mass.center")),
            drive,
            fmb.Prismatic("B", markers=("mass.ring", "bead.center")),
        ],
        forces=[fmb.PointLoad("F", marker="bead.center", force=(0, 0, 1.0))],
        sensors=[fmb.JointCoordinate("x", joint="B"), fmb.Position("p", marker="bead.center")],
    )
    solution = fmb.simulate(model, 1.0, samples=5, integrator=integrator)
    np.testing.assert_allclose(solution["p"][:, 2], 0.25 * solution.t**2, atol=1e-8)  # the drive does not push the bead
    np.testing.assert_allclose(
        solution["x"], 0.25 * solution.t**2 - drive.displacement.sample(solution.t)[:, 0], atol=1e-8
    )


def test_times_just_before_are_before():
    t = np.array([1e-9, 0.3, 1.0, 1e4])
    assert np.all(just_before(t) < t)
