"""What acts with reactions that are not unique is told: a door with friction in one of its two hinges."""

import warnings
from dataclasses import replace

import numpy as np
import pytest

import flexmb as fmb

ABOUT = "acts with the reaction of joint"


def door(second=fmb.Revolute, **parts):
    """Return a door of 20 kg on two hinges, which turns."""
    ground = fmb.Ground(markers={"h1": (0, 0, 0.5), "h2": (0, 0, -0.5)})
    leaf = fmb.RigidBody(
        "door",
        mass=20.0,
        inertia=(2, 2, 3),
        at=(0.5, 0, 0),
        velocity=(0, 0.5, 0),
        angular_velocity=(0, 0, 1),
        markers={"h1": (-0.5, 0, 0.5), "h2": (-0.5, 0, -0.5)},
    )
    hinges = [
        fmb.Revolute("h1", markers=("ground.h1", "door.h1")),
        second("h2", markers=("ground.h2", "door.h2")),
    ]
    return fmb.Model(bodies=[ground, leaf], joints=hinges, gravity=(0, 0, -9.81), **parts)


def friction(joint="h1", **fields):
    return fmb.JointFriction("rub", joint=joint, moving=0.3, radius=0.02, **fields)


def told(model, **settings):
    """Return the warnings of a short run about what acts with shared reactions."""
    with warnings.catch_warnings(record=True) as seen:
        warnings.simplefilter("always")
        fmb.simulate(model, 0.05, samples=6, **settings)
    return [str(one.message) for one in seen if ABOUT in str(one.message)]


@pytest.mark.parametrize(
    "integrator", [fmb.GeneralizedAlpha(), fmb.IDA(), fmb.Implicit()], ids=lambda x: type(x).__name__
)
def test_friction_in_one_of_two_hinges_is_told_once(integrator):
    sentences = told(door(forces=[friction()]), integrator=integrator)
    assert len(sentences) == 1
    assert "Force 'rub'" in sentences[0]
    assert "'h1'" in sentences[0]


def test_the_motion_does_depend_on_how_the_hinges_share():
    """The other hinge takes no moment: the same door, but the least norm is another one."""
    turned = []
    for second in (fmb.Revolute, fmb.InLine):
        with pytest.warns(fmb.ValidityWarning, match=ABOUT):
            run = fmb.simulate(door(second, forces=[friction()]), 0.2, samples=3, integrator=fmb.IDA(rtol=1e-8))
        turned.append(np.linalg.norm(run.final.u[3:6]))
    assert abs(turned[0] - turned[1]) > 1e-3


def test_linearize_tells_it_too():
    """Least norm gives the swinging door a damping ratio of 0.107; 0.162 where the other hinge takes no moment."""
    ratios = []
    for second in (fmb.Revolute, fmb.InLine):
        spring = fmb.TorsionSpring("spring", joint="h1", stiffness=10.0)
        swinging = door(second, forces=[friction(transition=0.1), spring])
        still = replace(swinging.bodies[1], velocity=(0, 0, 0), angular_velocity=(0, 0, 0))
        with pytest.warns(fmb.ValidityWarning, match=ABOUT):
            ratios.extend(fmb.linearize(replace(swinging, bodies=[swinging.bodies[0], still])).damping_ratios)
    assert ratios == pytest.approx([0.107, 0.162], abs=1e-3)


def test_drives_and_accelerations_tell_it_too():
    """The torque of a drive works against the friction, the acceleration is made by it."""
    drive = fmb.Drive("motor", joint="h1", angle=fmb.ramp(rate=1.0))
    with pytest.warns(fmb.ValidityWarning, match=ABOUT):
        solution = fmb.inverse_dynamics(door(forces=[friction()]), [drive], 0.1, samples=3)
    assert [text for text in solution.statistics["warnings"] if ABOUT in text]
    with pytest.warns(fmb.ValidityWarning, match=ABOUT):
        fmb.accelerations(door(forces=[friction()]))


def test_without_a_share_nothing_is_told():
    """Friction by a preload alone; in the only hinge; in a plane mechanism, whose shared reactions are zero."""
    assert not told(door(forces=[friction(from_reaction=False, preload=100.0)]))
    alone = door(forces=[friction()])
    assert not told(fmb.Model(bodies=alone.bodies, joints=alone.joints[:1], forces=alone.forces, gravity=alone.gravity))
    assert fmb.check(four_bar()).redundant
    assert not told(four_bar())


def four_bar():
    """Return a plane four-bar on four hinges with parallel axes (y), friction in one of them."""
    along = fmb.Pose(rotation=[[1, 0, 0], [0, 0, 1], [0, -1, 0]])
    at = {"A": (0, 0, 0), "B": (0, 0, 0.1), "C": (0.3, 0, 0.25), "D": (0.3, 0, 0)}

    def rod(name, first, last):
        a, b = np.array(at[first]), np.array(at[last])
        ends = {key: fmb.Pose(tuple(s * (b - a) / 2), along.rotation) for key, s in ((first, -1), (last, 1))}
        return fmb.RigidBody(name, mass=1.0, inertia=(1e-2, 1e-2, 1e-2), at=tuple((a + b) / 2), markers=ends)

    ground = fmb.Ground(markers={key: fmb.Pose(at[key], along.rotation) for key in "AD"})
    bodies = [ground, rod("crank", "A", "B"), rod("coupler", "B", "C"), rod("rocker", "C", "D")]
    pairs = {"A": ("ground", "crank"), "B": ("crank", "coupler"), "C": ("coupler", "rocker"), "D": ("rocker", "ground")}
    joints = [fmb.Revolute(key, markers=(f"{a}.{key}", f"{b}.{key}")) for key, (a, b) in pairs.items()]
    return fmb.Model(bodies=bodies, joints=joints, forces=[friction("B")], gravity=(0, 0, -9.81))


def test_an_event_that_waits_for_such_a_reaction_is_told():
    stop = fmb.Event("much", sensor="lam", column=2, above=50, then=(fmb.Stop(),))
    model = door(sensors=[fmb.Multiplier("lam", joint="h1")], events=[stop])
    sentences = told(model)
    assert len(sentences) == 1
    assert "Event 'much'" in sentences[0]


def test_a_sampler_that_reads_such_a_reaction_is_told():
    held = fmb.Sampled(fmb.measured("load fx"), period=0.01)
    push = fmb.PointLoad("push", marker="door.center", force=(0.0, 1e-3 * held, 0.0))
    sentences = told(door(sensors=[fmb.Reaction("load", joint="h1")], forces=[push]))
    assert len(sentences) == 1
    assert "A measured reaction" in sentences[0]


def test_reading_multipliers_is_told_as_reading_reactions():
    run = fmb.simulate(door(sensors=[fmb.Multiplier("lam", joint="h1")]), 0.05, samples=3)
    with pytest.warns(fmb.ValidityWarning, match="not unique"):
        run["lam"]
