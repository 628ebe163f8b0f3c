"""How far a block of steps goes past an event depends on the clock; numbers of the run must not.

The motion beside a run was taken over an event from wherever the block had come, and steps past it were counted: a
reduced part under a controller took 28 580 to 28 841 steps, and its coordinates differed by 1e-12 m.
"""

from dataclasses import replace

import numpy as np
import pytest

import flexmb as fmb
from flexmb.integrate.runs import phases

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


@pytest.mark.parametrize("integrator", METHODS, ids=lambda method: type(method).__name__)
def test_events(integrator, monkeypatch):
    """Coordinates, reactions, added errors and numbers of steps are the same to the last bit."""
    short, long = (run(swing(), integrator, monkeypatch, given) for given in (SHORT, LONG))
    assert len(short.phases) == 3
    require_same(short, long)


@pytest.mark.parametrize("integrator", [fmb.GeneralizedAlpha(), fmb.IDA()], ids=lambda method: type(method).__name__)
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
