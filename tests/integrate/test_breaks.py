"""Loads that jump, kink or last shorter than a step: every integrator ends its steps there and begins anew.

The references are closed forms of a mass of 1 kg on a slide: velocity and place after an impulse, and after a step.
"""

import numpy as np
import pytest
from by_turns import every_second

import flexmb as fmb
from flexmb.integrate.runs.breaks import just_before, refined, with_breaks
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
        (fmb.table([0.0, 1.0, 3.0], [0, 1, 0], of=fmb.expression("1 - 2*t"), kind="linear"), [-1.0, 0.0, 0.5]),
        (fmb.table([0.0, 1.0, 3.0], [0, 1, 0]), [0.0, 3.0]),  # the parabola through three points bends at none
        (fmb.expression("where(t < 2, sin(t), max(1 - t/4, 0)) + abs(3*t - 6)"), [2.0, 4.0]),
        (fmb.expression("step(0.5 - t) * sign(t - 0.1) + smooth((t - 1) / 2)"), [0.1, 0.5, 1.0, 3.0]),
        (fmb.table(np.arange(RECORD + 1), np.zeros(RECORD + 1), kind="linear"), [0.0, RECORD]),
    ],
)
def test_breakpoints_of_signals(signal, times):
    found = breakpoints(signal.program(), -2.0, 1.0 + max([4.0, *times]))
    np.testing.assert_allclose(found.times, times, atol=1e-14)
    assert found.complete


E = fmb.expression


@pytest.mark.parametrize(
    ("signal", "times"),
    [
        (E("where(abs(t - 5) < 1e-3, 1000, 0)"), [4.999, 5.0, 5.001]),
        (E("where(abs(t - 5) < 1e-9, 1000, 0)"), [5.0 - 1e-9, 5.0, 5.0 + 1e-9]),
        (E("step(sin(t)) + t**2"), [0.0, np.pi, 2 * np.pi, 3 * np.pi]),
        (E("where(t**2 < 4 and t > 1, 1, 0) + abs(t**3 - 2*t)"), [0.0, 1.0, np.sqrt(2.0), 2.0]),
        (E("where(max(t - 1, 0) == t - 1, 1, 0)"), [1.0]),
        (E("atan2(sin(t), cos(t))"), [0.0, np.pi, 2 * np.pi, 3 * np.pi]),  # it jumps by a full turn
        (E("sqrt(max(t - 1, 0))"), [1.0]),
        (E("where(exp(-t) < 0.5, min(t, 3), 0)"), [np.log(2.0), 3.0]),
        (E("where(sin(1/(t + 0.1)) > 0, 1, 0)"), [-0.1, *(1 / (np.pi * np.array([3, 2, 1])) - 0.1)]),
        (E("sign((t - 4)**3 * (t - 4 - 1e-6))"), [4.0, 4.000001]),
        (
            fmb.table([0, 1, 3], [0, 1, 0], of=E("2*sin(t)"), kind="linear"),
            np.pi * np.array([0, 1 / 6, 5 / 6, 1, 2, 13 / 6, 17 / 6, 3]),
        ),
    ],
    ids=repr,
)
def test_breakpoints_whatever_the_arguments(signal, times):
    found = breakpoints(signal.program(), 0.0, 10.0)
    np.testing.assert_allclose(found.times, times, atol=1e-10)
    assert found.complete


def test_a_straight_table_has_no_corners():
    """101 points of 3 t, whose cubic pieces differ by rounding only."""
    x = np.linspace(0.0, 10.0, 101)
    for kind in ("cubic", "linear"):
        np.testing.assert_array_equal(breakpoints(fmb.table(x, 3.0 * x, kind=kind).program(), 0.0, 10.0).times, [0, 10])


def test_what_cannot_be_found_in_advance_is_told():
    """A signal with some 10^9 jumps: the run says so, and with which part."""
    with pytest.warns(fmb.ValidityWarning, match="Force 'F' has a signal that changes too often"):
        solution = fmb.simulate(slide(E("where(sin(1e9*t) > 0.5, 1, 0)")), 1.0, samples=2)
    assert "Force 'F'" in solution.statistics["warnings"][0]


def test_a_load_of_many_steps():
    """Sixty changes of a load in one phase, from 1 to -1 N and back: v returns to 0, x grows by 1 m per pair."""
    load = fmb.expression("sign(sin(pi*t))")
    for integrator in (fmb.GeneralizedAlpha(), fmb.IDA()):
        solution = fmb.simulate(slide(load), 60.0, samples=[0.0, 30.0, 60.0], integrator=integrator)
        np.testing.assert_allclose(solution["x"], [0.0, 15.0 * 1.0, 30.0], atol=1e-4)


@pytest.mark.parametrize(("samples", "integrator"), every_second([2, 401], INTEGRATORS), ids=repr)
def test_pulses_of_two_milliseconds_in_ten_seconds(integrator, samples):
    """The momentum is the impulse: 1000 N for 2 ms, and 1000 N exp(-x^2), x = (t - 5 s) / 1 ms.

    A fixed step of ten times the pulse ends where the signal tells, and integrates coarsely there.
    """
    for text, impulse, error in (
        ("where(abs(t - 5) < 1e-3, 1000, 0)", 2.0, 1e-6),
        ("1000*exp(-((t - 5)/1e-3)**2)", np.sqrt(np.pi), 4e-3 if getattr(integrator, "step", None) is None else 0.1),
    ):
        solution = fmb.simulate(slide(fmb.expression(text)), 10.0, samples=samples, integrator=integrator)
        assert solution["x"][-1] == pytest.approx(5.0 * impulse, rel=error)


def test_breakpoints_of_a_model():
    model = slide(fmb.step(1.0, at=0.4))
    model = model.with_parts(joints=[fmb.Drive("d", joint="A", displacement=fmb.step(1.0, at=0.2, rise=0.3))])
    np.testing.assert_allclose(compile(model).signal_times.between(0.0, 1.0).breaks, [0.2, 0.4, 0.5], atol=1e-15)


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


def test_gaps_are_divided():
    """Equal pieces, no longer than asked for; times that are there stay the same to the last bit."""
    times = np.array([0.0, 0.1, 0.1, 0.35, 0.36])
    found = refined(times, 0.1)
    np.testing.assert_allclose(found, [0.0, 0.1, 0.1 + 0.25 / 3, 0.1 + 0.5 / 3, 0.35, 0.36], rtol=1e-15)
    assert set(times) <= set(found)
