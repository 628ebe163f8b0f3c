"""Impacts of cables and beams by `LineContact`, with every integrator that has such bodies (`Implicit` refuses them).

References: without friction and damping what hits flat comes back with its speed (energy and symmetry), and so does a
slack cable that lands point by point; of a bar that strikes a held line, a run of IDA with a tolerance of 1e-9.
"""

import warnings
from functools import cache

import numpy as np
import pytest
from by_turns import every_second

import flexmb as fmb
from flexmb import fem
from flexmb.integrate.runs.switching import PassedOver, new_switching
from flexmb.system import compile
from flexmb.system.program import evaluate

LENGTH, THICK, DENSITY, DEEP, BEFORE = 0.5, 0.02, 7800.0, 2e-3, 5e-3
BAR, RADIUS, TOUCHED = 0.5, 0.05, 0.02
LINE_MASS = 0.25 * np.pi * THICK**2 * DENSITY
SPEEDS = (3.0, 30.0)
FALLING = {"flat cable": ("cable", 0.0), "flat beam": ("beam", 0.0), "tilted cable": ("cable", 0.02)}
KINDS = {"cable": fmb.AncfCable, "beam": fmb.AncfBeam}
METHODS = {
    "alpha": lambda _: fmb.GeneralizedAlpha(follow_errors=False),
    "IDA": lambda _: fmb.IDA(),
    "explicit": lambda _: fmb.Explicit(),
    "Moreau-Jean": lambda speed: fmb.MoreauJean(step=1e-3 / speed),
}


def line(kind, speed, height, tilt=0.0, velocity=0.0):
    """Return a line whose waves are slow against its impacts, whatever the speed."""
    return KINDS[kind](
        "line",
        points=((-0.5 * LENGTH, 0.0, height), (0.5 * LENGTH, 0.0, height + tilt)),
        elements=4,
        stretches={"all": (0.0, 1.0)},
        section=fem.Section.solid_circle(THICK),
        material=fmb.Material(young=1e6 * speed**2, poisson=0.3, density=DENSITY),
        markers={"middle": 0.5},
        velocity=(0.0, 0.0, velocity),
    )


def falling(kind, speed, tilt):
    """Return a line that falls on a plane, whose points press for pi DEEP / speed."""
    return fmb.Model(
        gravity=(0, 0, 0),
        bodies=[fmb.Ground(), line(kind, speed, 0.5 * THICK + BEFORE, tilt, -speed)],
        forces=[
            fmb.LineContact(
                "floor",
                stretch="line.all",
                marker="ground.origin",
                against="plane",
                offset=0.5 * THICK,
                stiffness=LINE_MASS * (speed / DEEP) ** 2,
            )
        ],
        sensors=[fmb.Velocity("v", marker="line.middle"), fmb.Energy("E")],
    )


def struck(kind, speed):
    """Return a line between two hinges that a bar across it strikes, beside the middle."""
    bar = fmb.RigidBody(
        "bar",
        mass=BAR,
        inertia=(1e-3,) * 3,
        at=(0.013, 0.0, RADIUS + 0.5 * THICK + BEFORE),
        velocity=(0.0, 0.0, -speed),
        markers={"axis": fmb.Pose((0, 0, 0), (0.5 * np.pi, 0, 0))},
    )
    ends = {"start": (-0.5 * LENGTH, 0, 0), "end": (0.5 * LENGTH, 0, 0)}
    return fmb.Model(
        gravity=(0, 0, 0),
        bodies=[fmb.Ground(markers=ends), line(kind, speed, 0.0), bar],
        joints=[fmb.Spherical(end, markers=(f"ground.{end}", f"line.{end}")) for end in ends],
        forces=[
            fmb.LineContact(
                "hit",
                stretch="line.all",
                marker="bar.axis",
                radius=RADIUS,
                offset=0.5 * THICK,
                stiffness=BAR / TOUCHED * (speed / DEEP) ** 2,
            )
        ],
        sensors=[fmb.Velocity("v", marker="bar.center"), fmb.Energy("E")],
    )


def end(model, duration, integrator):
    """Return the last velocity, m/s, and the last energy by the first one."""
    with warnings.catch_warnings():
        warnings.simplefilter("error", fmb.ValidityWarning)
        found = fmb.simulate(model, duration, samples=2, integrator=integrator)
    return found["v"][-1], found["E"][-1] / found["E"][0]


@pytest.mark.parametrize(("method", "speed", "which"), every_second(METHODS, SPEEDS, FALLING))
def test_lines_that_fall(method, speed, which):
    """Flat or point by point: within 0.3 % of their speed."""
    kind, tilt = FALLING[which]
    v, energy = end(falling(kind, speed, tilt), 0.04 / speed, METHODS[method](speed))
    np.testing.assert_allclose(v / speed, (0.0, 0.0, 1.0), atol=3e-3)
    assert energy == pytest.approx(1.0, abs=3e-3)


@cache
def closely(kind, speed):
    return end(struck(kind, speed), 0.03 / speed, fmb.IDA(rtol=1e-9))[0]


@pytest.mark.parametrize(("method", "speed", "kind"), every_second(METHODS, SPEEDS, KINDS))
def test_bars_that_strike(method, speed, kind):
    v, energy = end(struck(kind, speed), 0.03 / speed, METHODS[method](speed))
    np.testing.assert_allclose(v, closely(kind, speed), atol=0.01 * speed)
    assert energy == pytest.approx(1.0, abs=5e-3)


def test_coarse_steps_are_named():
    """Three fixed steps in the contact of a line, as of any other; sixty are within 1 %, without a word."""
    span = np.pi * DEEP / SPEEDS[0]
    with pytest.warns(fmb.ValidityWarning) as told:
        fmb.simulate(
            falling("cable", SPEEDS[0], 0.0), 4.0 * span, samples=2, integrator=fmb.GeneralizedAlpha(step=span / 3.0)
        )
    assert any("Force 'floor': it closed and opened again within" in str(x.message) for x in told)
    v, _ = end(falling("cable", SPEEDS[0], 0.0), 4.0 * span, fmb.GeneralizedAlpha(step=span / 60.0))
    assert v[2] == pytest.approx(SPEEDS[0], rel=1e-2)


@pytest.mark.parametrize("against", ["plane", "cylinder"])
@pytest.mark.parametrize("spin", [0.0, 500.0])
def test_a_turn_of_all_is_no_speed(against, spin):
    """A line that turns with its plane, or with the axis of its cylinder, at 500 rad/s, and nears it at 1 m/s.

    What touches slowly is measured by 1 m/s; by the 150 m/s of the turn, as before, no impact was seen.
    """
    gap, axis = 0.05, np.array([0.0, 1.0, 0.0])  # across the normal of the plane, and across the axis z
    place = np.array(
        [[0.2, 0.0, 0.1 + gap], [0.3, 0.0, 0.1 + gap]] if against == "plane" else [[0.15, 0, 0], [0.15, 0, 0.3]]
    )
    toward = np.array([0.0, 0.0, -1.0] if against == "plane" else [-1.0, 0.0, 0.0])
    rope = fmb.AncfCable(
        "line",
        points=place,
        elements=2,
        stretches={"all": (0.0, 1.0)},
        section=fem.Section.solid_circle(0.01),
        material=fmb.Material(young=1e9, poisson=0.3, density=DENSITY),
    )
    disc = fmb.RigidBody("disc", mass=1.0, inertia=(1, 1, 1), angular_velocity=spin * axis)
    contact = fmb.LineContact(
        "c",
        stretch="line.all",
        marker="disc.center",
        against=against,
        radius=0.1 if against == "cylinder" else None,
        stiffness=1e6,
    )
    system = compile(fmb.Model(bodies=[fmb.Ground(), disc, rope], forces=[contact]))
    state, work = system.state(0.0), system.workspace()
    iq, iu = system.body_slices["line"]
    q, u = state.q[iq].reshape(-1, 2, 3), state.u[iu].reshape(-1, 2, 3)  # places and slopes of the nodes
    u[:] = np.cross(spin * axis, q)
    u[:, 0] += toward
    evaluate(system.program, state, work)
    switching = new_switching(system, state, work, PassedOver())
    np.testing.assert_allclose(switching.now[:, 8], 1.0, rtol=1e-9)
