"""How far a block of steps goes past an event depends on the clock; numbers of the run must not.

The motion beside a run was taken over an event from wherever the block had come, and steps past it were counted: a
reduced part under a controller took 28 580 to 28 841 steps, and its coordinates differed by 1e-12 m.
"""

from dataclasses import replace

import numpy as np
import pytest
from by_turns import slow

import flexmb as fmb
from flexmb.integrate.runs import kept_rows, phases
from flexmb.integrate.runs.energy_watch import EnergyWatch
from flexmb.integrate.runs.fastest import present_rows
from flexmb.integrate.runs.validity import Validity
from flexmb.system import assemble

ROWS = ("t", "q", "u", "a", "lam", "works")
SHORT = {"CHUNK": 0.0, "PATIENCE": 0.0}
"""s: the integrator comes back at every sample, and after every step."""
LONG = {"CHUNK": 1e9, "PATIENCE": 1e9}
"""s: the blocks of a phase grow fourfold, until they have all of its samples."""
METHODS = [
    fmb.GeneralizedAlpha(),
    fmb.GeneralizedAlpha(step=2e-3),
    fmb.Implicit(),
    fmb.Explicit(),
    fmb.IDA(),
]


def swing(*more) -> fmb.Model:
    """Return an arm that falls, with a stone on a spring that softens on the way, and hardens further down."""
    angle = fmb.JointCoordinate("angle", joint="hinge")
    hang = fmb.SpringDamper("spring", markers=("arm.tip", "stone.center"), stiffness=200.0, damping=0.5, length=0.3)
    light = {"inertia": (0.02, 0.02, 0.001)}
    y = fmb.Pose.axes((0, 0, 0), z=(0, 1, 0))
    return fmb.Model(
        gravity=(0, 0, -9.81),
        bodies=[
            fmb.Ground(markers={"y": y}),
            fmb.RigidBody(
                "arm",
                mass=1.0,
                at=(0.5, 0, 0),
                **light,
                markers={"y": fmb.Pose.axes((-0.5, 0, 0), z=(0, 1, 0)), "tip": (0.5, 0, 0)},
            ),
            fmb.PointMass("stone", mass=0.5, at=(1.0, 0, -0.3)),
        ],
        joints=[fmb.Revolute("hinge", markers=("ground.y", "arm.y"))],
        forces=[hang, *more],
        sensors=[angle],
        events=[
            fmb.Event("softens", sensor="angle", above=0.5, then=fmb.Change("spring", stiffness=50.0)),
            fmb.Event("hardens", sensor="angle", above=1.0, then=fmb.Change("spring", stiffness=100.0)),
        ],
    )


def run(model, integrator, monkeypatch, given) -> fmb.Solution:
    for name, value in given.items():
        monkeypatch.setattr(phases, name, value)
    return fmb.simulate(model, t_end=0.6, samples=61, integrator=integrator)


def require_same(one, other):
    assert len(one.phases) == len(other.phases)
    for a, b in zip(one.phases, other.phases, strict=True):
        for name in ROWS:
            np.testing.assert_array_equal(getattr(a, name), getattr(b, name), err_msg=name)
    told, again = ({k: v for k, v in s.statistics.items() if k != "seconds"} for s in (one, other))
    assert told == again


@pytest.mark.parametrize(
    "integrator", [METHODS[0], *map(slow, METHODS[1:4]), METHODS[4]], ids=lambda method: type(method).__name__
)
def test_events(integrator, monkeypatch):
    """Coordinates, reactions, added errors and numbers of steps are the same to the last bit."""
    short, long = (run(swing(), integrator, monkeypatch, given) for given in (SHORT, LONG))
    assert len(short.phases) == 3
    require_same(short, long)


@pytest.mark.parametrize(
    "integrator", [fmb.GeneralizedAlpha(), slow(fmb.IDA())], ids=lambda method: type(method).__name__
)
def test_relays(integrator, monkeypatch):
    """A block that goes past the change of a relay is taken back to it, too; a pause between two looks at it is no
    reason to say that it came back.
    """
    angle = fmb.JointCoordinate("of relay", joint="hinge")
    relay = fmb.Relay(angle, limits=(0.1, 0.3), values=(0.0, 2.0))
    model = swing(fmb.Actuator("brake", joint="hinge", effort=relay))
    require_same(*(run(model, integrator, monkeypatch, given) for given in (SHORT, LONG)))


@pytest.mark.parametrize(
    "integrator", [fmb.GeneralizedAlpha(), fmb.Implicit()], ids=lambda method: type(method).__name__
)
def test_states_held_on_the_way(integrator, monkeypatch):
    """A state that is kept between samples, by the clock, leaves no comparison of reactions behind."""
    model = replace(swing(), events=())
    whole = run(model, integrator, monkeypatch, LONG)
    looked = run(model, integrator, monkeypatch, {**SHORT, "HOLD": -1.0})
    require_same(whole, looked)


def test_looks_planned_by_gradients(monkeypatch):
    """Where an equation of the user turns fast, the integrator comes back at more times: at the same ones, however
    many samples a block has.
    """
    place = fmb.Position("p", marker="bob.center")
    ring = fmb.Constraint("ring", over=[place], equation="p[0]**2 + p[1]**2 = (0.3 + 0.2*cos(7*t))**2")
    model = fmb.Model(
        bodies=[fmb.Ground(), fmb.PointMass("bob", mass=1.0, at=(0.5, 0, 0), velocity=(0, 30.0, 0))],
        joints=[ring, fmb.Constraint("flat", over=[place], equation="p[2]")],
        sensors=[place],
    )
    marks: dict[str, list[float]] = {}
    for name, given in (("short", SHORT), ("long", LONG)):
        seen = marks.setdefault(name, [])

        class Noting(fmb.Explicit):
            def run(self, system, work, variables, samples, first, last, patience=np.inf, seen=seen):
                outcome = super().run(system, work, variables, samples, first, last, patience)
                seen.extend(outcome.rows["t"].tolist())
                return outcome

        run(model, Noting(), monkeypatch, given)
    assert len(marks["long"]) > 61
    assert marks["short"] == marks["long"]


def test_contacts_after_an_event_are_not_told(monkeypatch):
    """A ball goes to and fro between stops 0.2 m apart at 2 m/s; the event comes between the second and the third
    impact, and a block goes on to the fifth.
    """
    x = fmb.Pose.axes((0, 0, 0), z=(1, 0, 0))
    model = fmb.Model(
        bodies=[
            fmb.Ground(markers={"x": x}),
            fmb.RigidBody("ball", mass=1.0, inertia=(1, 1, 1), velocity=(2, 0, 0), markers={"x": x}),
            fmb.PointMass("clock", mass=1.0, velocity=(1, 0, 0)),
        ],
        joints=[fmb.Prismatic("rail", markers=("ground.x", "ball.x"))],
        forces=[fmb.BiStop("stops", joint="rail", travel=(-0.1, 0.1), stiffness=1e5)],
        sensors=[fmb.Position("time", marker="clock.center")],
        events=[fmb.Event("end", sensor="time", column=0, above=0.2, then=fmb.Stop())],
    )
    short, long = (run(model, fmb.IDA(), monkeypatch, given) for given in (SHORT, LONG))
    assert short.statistics["contacts ended"] == 2
    require_same(short, long)


def test_a_look_at_a_slow_run_leaves_its_numbers():
    """What the solver of IDA counts begins at the last row, wherever the look was."""
    system, state = assemble(replace(swing(), events=()))
    work, integrator, samples = system.workspace(), fmb.IDA(), np.linspace(0.0, 0.6, 7)
    variables = integrator.start(system, state, work, 0.6)
    integrator.run(system, work, variables, samples, 0, 2)
    at_row = dict(variables.counts)
    for _ in range(5):  # a step each, the first to where it had come when it looked back to the row
        reached = integrator.run(system, work, variables, samples, 2, 3, patience=0.0).reached
    assert samples[1] < reached < samples[2]
    assert len(present_rows(integrator, system, work, variables, reached)["t"]) == 1
    integrator.run(system, work, variables, samples, 2, 4)
    assert variables.counts != at_row
    assert integrator.statistics(integrator.taken_back(variables, 0)) == at_row


WATCHED = {"PARTS": 4, "SHORTEST": 1}


def test_who_is_to_blame(monkeypatch):
    """The owner that a warning about energy names, and the samples at which loads of reduced bodies are looked at."""
    for name, value in WATCHED.items():
        monkeypatch.setattr(kept_rows, name, value)
    blamed, looked = [], []
    for given in (SHORT, LONG):
        watches: list[EnergyWatch] = []
        parts: list[list[float]] = []

        class Noted(EnergyWatch):
            def __init__(self, *given, watches=watches):
                super().__init__(*given)
                watches.append(self)

        def noted(self, system, rows, parts=parts, look=Validity.look):
            parts.append(rows["t"].tolist())
            look(self, system, rows)

        with monkeypatch.context() as patched:
            patched.setattr(kept_rows, "EnergyWatch", Noted)
            patched.setattr(Validity, "look", noted)
            run(swing(), fmb.GeneralizedAlpha(step=2e-2), patched, given)
        blamed.append([watch.blame for watch in watches])
        looked.append(parts)
    assert blamed[0] == blamed[1]
    assert sum(len(blame) for blame in blamed[0]) > 3
    assert looked[0] == looked[1]
