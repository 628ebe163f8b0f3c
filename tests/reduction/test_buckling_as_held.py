"""A body with geometric stiffness is told its share of the load under which it buckles as its joints hold it.

Reference: Euler's columns, P = c EI / L^2 with c = pi^2 (pins), 4 pi^2 (clamped ends, one slides), pi^2 / 4 (clamped
and free), 20.1907 (clamped and pinned: tan x = x). In its own frame a strut between pins would be told four times its
share where the frame is clamped to an end, and a column that is clamped and free a quarter of it in the mean frame.
"""

from dataclasses import replace

import numpy as np
import pytest
from by_turns import every_second

import flexmb as fmb
from flexmb import fem, reduction

STEEL = fmb.Material(young=210e9, poisson=0.3, density=7850.0)
L, WIDE, FLAT = 1.0, 0.02, 0.01
EI = 210e9 * WIDE * FLAT**3 / 12.0
ALONG = fmb.Pose.axes(z=(1, 0, 0), x=(0, 1, 0))
HOLDS = {"pins": np.pi**2, "clamps": 4.0 * np.pi**2, "free": np.pi**2 / 4.0, "foot": 20.1907}


def strut(frame, **more):
    points = np.column_stack([np.linspace(0.0, L, 21), np.zeros((21, 2))])
    fe = fem.frame(points, section=fem.Section.rectangle(WIDE, FLAT), material=STEEL)
    return reduction.reduce(fe, {"a": 0, "b": 20}, 8, geometric_stiffness=True, frame=frame, **more)


def model(data, hold, force, more=()):
    """A strut along x, pressed at its end b by a force."""
    foot = fmb.Spherical if hold == "pins" else fmb.Fixed
    joints = [foot("A", markers=("ground.origin", "strut.a"))]
    if hold in ("pins", "foot"):
        joints.append(fmb.InLine("B", markers=("ground.end", "strut.b")))
    elif hold == "clamps":
        joints.append(fmb.Prismatic("B", markers=("ground.end", "strut.b")))
    end = fmb.Pose.axes(at=(L, 0, 0), z=(1, 0, 0), x=(0, 1, 0))
    body = fmb.FloatingBody("strut", data=data, markers={"b": ALONG} if hold == "clamps" else {})
    return fmb.Model(
        bodies=[fmb.Ground(markers={"end": end}), body],
        joints=joints,
        forces=[fmb.PointLoad("press", marker="strut.b", force=(-force, 0.0, 0.0)), *more],
    )


def told(model):
    """Return the share of the buckling load in equilibrium."""
    return fmb.statics(model).statistics["share of validity"]["Body 'strut'"]["load"]


@pytest.mark.parametrize(("hold", "frame"), every_second(list(HOLDS), ["buckens", "a"]))
def test_share_of_eulers_load(frame, hold, recwarn):
    data, euler = strut(frame), HOLDS[hold] * EI / L**2
    for part in (0.3, 0.9, 1.1):
        assert told(model(data, hold, part * euler)) == pytest.approx(part, rel=5e-3)
        assert any("its reduced stiffness buckles" in str(w.message) for w in recwarn) == (part > 1.0)


@pytest.mark.parametrize("frame", ["buckens", "a"])
def test_a_preload_in_tension_lets_it_carry_more(frame):
    """Half of Euler's load as tension in the material, kept up by the foot: 1.2 times the load is a share of 0.7."""
    euler = HOLDS["free"] * EI / L**2
    data = strut(frame, loads={"pull": {20: (1.0, 0.0, 0.0)}}, preload={"pull": 0.5 * euler})
    assert told(model(data, "free", 1.2 * euler)) == pytest.approx(0.7, rel=5e-3)


def test_bodies_that_float_count_as_holding(recwarn):
    """Between two bodies without which it would not stand: the load of clamped and pinned, whatever the frame is."""
    euler = HOLDS["pins"] * EI / L**2
    for frame in ("buckens", "a"):
        heavy = {"mass": 1e3, "inertia": (1e3, 1e3, 1e3)}
        pressed = fmb.Model(
            bodies=[
                fmb.RigidBody("left", **heavy, at=(0.0, 0.0, 0.0)),
                fmb.RigidBody("right", **heavy, at=(L, 0.0, 0.0)),
                fmb.FloatingBody("strut", data=strut(frame)),
            ],
            joints=[
                fmb.Fixed("A", markers=("left.center", "strut.a")),
                fmb.Spherical("B", markers=("right.center", "strut.b")),
            ],
            forces=[
                fmb.PointLoad("push", marker="left.center", force=(0.3 * euler, 0.0, 0.0)),
                fmb.PointLoad("back", marker="right.center", force=(-0.3 * euler, 0.0, 0.0)),
            ],
        )
        solution = fmb.simulate(pressed, 1e-2, integrator=fmb.IDA(), samples=11)
        share = solution.statistics["share of validity"]["Body 'strut'"]["load"]
        # it rings along: twice the load at the most
        assert share == pytest.approx(2.0 * 0.3 * np.pi**2 / HOLDS["foot"], rel=0.05)
    assert not [w for w in recwarn if "buckles" in str(w.message)]


@pytest.mark.parametrize("frame", ["buckens", "a"])
def test_a_roof_that_hangs_on_a_column_alone_holds_nothing(frame, recwarn):
    """Clamped and free, the weight of a body at its tip: that body could hold the tip only if something held it."""
    euler = HOLDS["free"] * EI / L**2
    for part in (0.9, 1.1):
        column = fmb.FloatingBody("strut", data=strut(frame))
        roof = fmb.RigidBody("roof", mass=part * euler / 10.0, inertia=(1.0, 1.0, 1.0), at=(L, 0.0, 0.0))
        joints = [
            fmb.Fixed("A", markers=("ground.origin", "strut.a")),
            fmb.Fixed("B", markers=("strut.b", "roof.center")),
        ]
        standing = fmb.Model(gravity=(-10.0, 0.0, 0.0), bodies=[fmb.Ground(), column, roof], joints=joints)
        assert told(standing) == pytest.approx(part, rel=0.01)  # with a part of the column's own weight, 1.6 kg
        assert any("its reduced stiffness buckles" in str(w.message) for w in recwarn) == (part > 1.0)


@pytest.mark.parametrize(("frame", "words"), [("buckens", "that nothing holds"), ("a", "clamped to 'a'")])
def test_data_that_do_not_know_what_holds_them_say_so(frame, words):
    """Of former files: in a frame clamped to an end 0.9 of Euler's load is told as 3.6, and nothing said why."""
    data, euler = strut(frame), HOLDS["pins"] * EI / L**2
    known = fmb.statics(model(data, "pins", 0.9 * euler)).statistics
    old = fmb.statics(model(replace(data, left_out=None), "pins", 0.9 * euler)).statistics
    assert not [note for note in known.get("notes", ()) if "how joints and other bodies hold it" in note]
    notes = [note for note in old["notes"] if "how joints and other bodies hold it" in note]
    assert len(notes) == 1
    assert words in notes[0]
