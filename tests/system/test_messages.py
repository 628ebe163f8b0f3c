"""Descriptions that do not fit together: which part, what was found, what was expected, what to do."""

import re
from dataclasses import replace

import pytest
from contracts.random_models import connected

import flexmb as fmb
from flexmb.errors import CompileError, FlexmbError, ModelError
from flexmb.joints import KINDS

GROUND = fmb.Ground(markers={"A": (0, 0, 0), "far": (5, 0, 0)})
ROD = fmb.RigidBody.rod("rod", length=1.0, mass=1.0, radius=0.05)
PIN = fmb.Revolute("pin", markers=("ground.A", "rod.start"))


def message(caught) -> str:
    error: FlexmbError = caught.value
    assert all((error.part, error.found, error.expected, error.remedy)), error
    return str(error)


def test_unknown_marker_with_a_suggestion():
    with pytest.raises(ModelError) as caught:
        fmb.Model(bodies=[GROUND, ROD], joints=[fmb.Revolute("pin", markers=("ground.A", "rod.strat"))])
    text = message(caught)
    assert "Joint 'pin'" in text
    assert "rod.strat" in text
    assert "Did you mean 'rod.start'?" in text


def test_unknown_body_with_a_suggestion():
    with pytest.raises(ModelError) as caught:
        fmb.Model(bodies=[GROUND, ROD], joints=[fmb.Revolute("pin", markers=("ground.A", "rob.start"))])
    assert "Did you mean 'rod'?" in message(caught)


def test_unknown_joint_of_a_drive():
    with pytest.raises(ModelError) as caught:
        fmb.Model(bodies=[GROUND, ROD], joints=[PIN, fmb.Drive("motor", joint="pan", angle=1.0)])
    assert "Did you mean 'pin'?" in message(caught)


def test_two_of_one_name():
    with pytest.raises(ModelError) as caught:
        fmb.Model(bodies=[GROUND, ROD, ROD])
    assert "'rod': the name is used twice" in message(caught)


@pytest.mark.parametrize("mass", [-1.0, float("nan"), "heavy"])
def test_mass_is_not_negative(mass):
    for make in (lambda: fmb.RigidBody("b", mass=mass, inertia=(1, 1, 1)), lambda: fmb.PointMass("p", mass=mass)):
        with pytest.raises(ModelError) as caught:
            make()
        assert f"mass = {mass!r}" in message(caught)


def test_inertia_obeys_the_triangle_inequality():
    with pytest.raises(ModelError) as caught:
        fmb.RigidBody("b", mass=1.0, inertia=(1.0, 1.0, 3.0))
    assert "principal moments" in message(caught)


@pytest.mark.parametrize("drive", [{"displacement": 0.1}, {}, {"angle": 1.0, "displacement": 1.0}])
def test_drives_follow_a_permitted_freedom(drive):
    with pytest.raises(ModelError) as caught:
        fmb.Model(bodies=[GROUND, ROD], joints=[PIN, fmb.Drive("motor", joint="pin", **drive)])
    assert "Joint 'motor'" in message(caught)


def test_joint_within_one_body():
    with pytest.raises(ModelError) as caught:
        fmb.Model(bodies=[GROUND, ROD], joints=[fmb.Revolute("pin", markers=("rod.start", "rod.end"))])
    assert "both markers are on body 'rod'" in message(caught)


def test_impossible_assembly_names_the_worst_equations():
    joints = [PIN, fmb.Spherical("stretch", markers=("ground.far", "rod.end"))]
    with pytest.raises(CompileError) as caught:
        fmb.simulate(fmb.Model(name="bad", bodies=[GROUND, ROD], joints=joints), 1.0)
    text = message(caught)
    assert "Model 'bad'" in text
    assert "cannot be assembled" in text
    assert "stretch" in text


def test_drives_that_contradict_each_other_at_the_start():
    joints = [PIN, fmb.Drive("one", joint="pin", angle=0.0), fmb.Drive("two", joint="pin", angle=0.5)]
    with pytest.raises(CompileError) as caught:
        fmb.simulate(fmb.Model(bodies=[GROUND, ROD], joints=joints), 1.0)
    assert "one: Angle" in message(caught) or "two: Angle" in message(caught)


def test_drives_that_contradict_each_other_later():
    joints = [
        PIN,
        fmb.Drive("one", joint="pin", angle=0.0),
        fmb.Drive("two", joint="pin", angle=fmb.expression("t**2")),
    ]
    with pytest.raises(CompileError) as caught:
        fmb.simulate(fmb.Model(bodies=[GROUND, ROD], joints=joints), 1.0)
    text = message(caught)
    assert "second derivative" in text
    assert "contradict" in text


def test_nothing_moves():
    with pytest.raises(CompileError) as caught:
        fmb.check(fmb.Model(bodies=[GROUND]))
    assert "no body that can move" in message(caught)


def test_a_freedom_without_inertia_is_named():
    slender = fmb.RigidBody.rod("slender", length=1.0, mass=1.0)
    slender = slender.replaced(inertia=(0.0, 1 / 12, 1 / 12))
    joint = fmb.Spherical("ball", markers=("ground.A", "slender.start"))
    with pytest.raises(CompileError) as caught:
        fmb.simulate(fmb.Model(bodies=[GROUND, slender], joints=[joint]), 1.0)
    assert "slender" in message(caught)
    assert "singular" in message(caught)


def test_a_universal_joint_with_parallel_axes_names_both_axes():
    joint = fmb.Universal("cross", markers=("ground.A", "rod.start"))
    with pytest.raises(CompileError) as caught:
        fmb.check(fmb.Model(bodies=[GROUND, ROD], joints=[joint]))
    text = message(caught)
    assert "Joint 'cross': the z-axis of 'ground.A' and the z-axis of 'rod.start' are parallel" in text
    assert "Pose.axes" in text
    assert "flexmb.check" not in text


def test_a_hinge_drawn_across_names_the_axes():
    across = ROD.replaced(markers={"hinge": fmb.Pose.axes(z=(1, 0, 0), x=(0, 0, 1))})
    joint = fmb.Revolute("pin", markers=("ground.A", "rod.hinge"))
    with pytest.raises(CompileError) as caught:
        fmb.check(fmb.Model(bodies=[GROUND, across], joints=[joint]))
    assert "the z-axis of 'ground.A' and the x-axis of 'rod.hinge' are parallel" in message(caught)


@pytest.mark.parametrize("kind", [fmb.Revolute, fmb.Cylindrical])
@pytest.mark.parametrize("z", [(1, 0, 0), (0, 1, 0)])
def test_a_driven_hinge_drawn_across_names_the_axes(kind, z):
    """The angle from x to x has no value there; neither the drive nor the inertia is to blame."""
    across = ROD.replaced(markers={"hinge": fmb.Pose.axes(z=z, x=(0, 0, 1))})
    joints = [kind("pin", markers=("ground.A", "rod.hinge")), fmb.Drive("turn", joint="pin", angle=0.3)]
    with pytest.raises(CompileError) as caught:
        fmb.check(fmb.Model(bodies=[GROUND, across], joints=joints))
    assert "Joint 'pin': the z-axis of 'ground.A' and the x-axis of 'rod.hinge' are parallel" in message(caught)


@pytest.mark.parametrize(
    ("inertia", "axes"),
    [((0, 0, 0), "its x-axis and its y-axis and its z-axis"), ((0, 1, 1), "its x-axis:"), ((1, 0, 1), "its y-axis:")],
)
def test_a_body_without_inertia_is_told_about_which_axes(inertia, axes):
    body = fmb.RigidBody("bob", mass=1.0, inertia=inertia)
    with pytest.raises(CompileError) as caught:
        fmb.check(fmb.Model(bodies=[GROUND, body], joints=[fmb.Spherical("s", markers=("ground.A", "bob.center"))]))
    text = message(caught)
    assert f"no inertia about {axes.rstrip(':')}. " in text
    assert "Body 'bob'" in text
    assert "Give Body 'bob' inertia=(Jxx, Jyy, Jzz)" in text
    assert "flexmb.check" not in text


INTERNAL = re.compile(
    r"\b(Turn|Slide|Ball|Coordinate|Coincident|Perpendicular|InPlane|Distance|Angle|NoTwist|OnCurve)\("
)


@pytest.mark.parametrize("freedom", [None, "turn", "turn_b", "slide", "slide_x", "slide_y", "spin"])
@pytest.mark.parametrize("kind", KINDS)
def test_messages_about_freedoms_are_in_words(kind, freedom, rng):
    """Whatever of a joint is driven, sprung or read: what is refused is refused without names of the inside."""
    model = connected(kind, "rigid-rigid", rng)
    asked = [
        lambda: replace(model, joints=(*model.joints, fmb.Drive("x", joint="j", angle=1.0, freedom=freedom))),
        lambda: replace(model, joints=(*model.joints, fmb.Drive("x", joint="j", displacement=1.0, freedom=freedom))),
        lambda: replace(model, sensors=[fmb.JointCoordinate("x", joint="j", freedom=freedom)]),
        lambda: replace(model, forces=(*model.forces, fmb.TorsionSpring("x", joint="j", stiffness=1.0))),
        lambda: replace(model, forces=(*model.forces, fmb.JointFriction("x", joint="j", moving=1.0))),
    ]
    refused = []
    for ask in asked:
        try:
            ask()
        except FlexmbError as error:
            refused.append(str(error))
    assert refused or kind == "Cylindrical"  # which has all that is asked for
    for text in refused:
        assert not INTERNAL.search(text), text
