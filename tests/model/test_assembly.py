"""Placed and added models."""

import numpy as np
import pytest
from tolerances import MACHINE

import flexmb as fmb
from flexmb import measured
from flexmb.bodies import Box, Ground, PointMass, RigidBody
from flexmb.errors import ModelError
from flexmb.events import Change, Event, Lock, Release, Stop
from flexmb.forces import PointLoad, SpringDamper
from flexmb.joints import Drive, Revolute
from flexmb.math.rotations import rotation_matrix
from flexmb.model.model import Model
from flexmb.model.pose import Pose
from flexmb.sensors import Distance, Position, Reaction

R = rotation_matrix((0.3, -0.5, 1.1))
AT = np.array([1.0, 2.0, -3.0])


@pytest.fixture
def arm():
    return Model(
        name="arm",
        gravity=(0, 0, -9.81),
        bodies=[
            Ground(markers={"A": Pose((0.1, 0, 0), (0.2, 0, 0))}),
            RigidBody(
                "bar",
                mass=1,
                inertia=(1, 1, 1),
                at=(0.5, 0, 0.2),
                rotation=(0, 0, 0.4),
                velocity=(1, 2, 3),
                angular_velocity=(0, 1, 0),
                markers={"end": (1, 0, 0)},
            ),
            PointMass("bob", mass=1, at=(1, 1, 1), velocity=(0, 0, 2)),
        ],
        joints=[Revolute("A", markers=("ground.A", "bar.center")), Drive("motor", joint="A", angle=1.0)],
        forces=[
            SpringDamper("spring", markers=("bar.end", "bob.center"), stiffness=1.0),
            PointLoad("pull", marker="bar.end", force=(1, 0, 0)),
            PointLoad("follow", marker="bar.end", force=(1, 0, 0), axes="bar.end"),
            PointLoad("origin", marker="ground.origin"),
        ],
        sensors=[Position("p", marker="bar.end"), Reaction("r", joint="motor")],
        parameters={"length": 1.0},
    )


def test_every_name_has_the_prefix(arm):
    placed = arm.placed("left", at=AT, rotation=R)
    assert [p.name for f in ("bodies", "joints", "forces", "sensors") for p in getattr(placed, f)] == [
        "ground",
        "left_bar",
        "left_bob",
        "left_A",
        "left_motor",
        "left_spring",
        "left_pull",
        "left_follow",
        "left_origin",
        "left_p",
        "left_r",
    ]
    assert placed.joint("left_A").markers == ("ground.left_A", "left_bar.center")
    assert placed.joint("left_motor").joint == "left_A"
    assert placed.force("left_spring").markers == ("left_bar.end", "left_bob.center")
    assert placed.force("left_origin").marker == "ground.left_origin"
    assert placed.force("left_follow").axes == "left_bar.end"
    assert placed.force("left_pull").axes == "ground.left_origin"
    assert placed.sensors[1].joint == "left_motor"
    assert placed.parameters == {"left_length": 1.0}
    assert placed.name == "left_arm"


def test_everything_moves_as_one(arm):
    """Every marker's position goes from x to AT + R x, its axes from A to R A, velocities from v to R v."""
    placed = arm.placed("left", at=AT, rotation=R)
    for body in arm.bodies:
        twin = placed.body("ground" if body.name == "ground" else f"left_{body.name}")
        at, own = (getattr(body, "at", (0, 0, 0)), rotation_matrix(getattr(body, "rotation", None)))
        new_at, new_own = (getattr(twin, "at", (0, 0, 0)), rotation_matrix(getattr(twin, "rotation", None)))
        for name, marker in body.marker_poses().items():
            moved = twin.marker_poses()[f"left_{name}" if body.name == "ground" else name]
            expected = AT + R @ (np.array(at) + own @ np.array(marker.at))
            assert np.array(new_at) + new_own @ np.array(moved.at) == pytest.approx(expected, abs=MACHINE)
            if body.has_frame or body.name == "ground":
                assert new_own @ moved.matrix == pytest.approx(R @ own @ marker.matrix, abs=MACHINE)
        for field in ("velocity", "angular_velocity"):
            if hasattr(body, field):
                assert getattr(twin, field) == pytest.approx(R @ np.array(getattr(body, field)), abs=MACHINE)


def test_translation_leaves_world_loads_alone(arm):
    assert arm.placed("left", at=AT).force("left_pull").axes is None


def test_sum_has_one_ground(arm):
    both = arm.placed("left") + arm.placed("right", at=(0, 1, 0))
    assert [b.name for b in both.bodies] == ["ground", "left_bar", "left_bob", "right_bar", "right_bob"]
    assert set(both.bodies[0].markers) == {"left_origin", "left_A", "right_origin", "right_A"}
    assert both.gravity == arm.gravity
    assert both.name == "left_arm"
    assert both.parameters == {"left_length": 1.0, "right_length": 1.0}
    assert len((Model() + arm).bodies) == 3
    assert (Model() + arm).gravity == arm.gravity


def test_what_is_drawn_of_the_ground_goes_along(arm):
    drawn = arm.changed("ground", shape=[Box(size=(1, 1, 1)), Box(size=(2, 2, 2), on="A")])
    both = drawn.placed("left") + drawn.placed("right", at=(0, 1, 0))
    assert [shape.on for shape in both.bodies[0].shape] == ["left_origin", "left_A", "right_origin", "right_A"]


def test_one_name_for_two_places(arm):
    other = Model(bodies=[Ground(markers={"A": (0, 0, 9)})])
    with pytest.raises(ModelError, match=r"Ground marker 'A': it lies at .* and at .*one place.*different prefixes"):
        arm + other


def test_two_gravities(arm):
    with pytest.raises(ModelError, match=r"gravity .* and .*one gravity.*in one of them only"):
        arm + Model(name="moon", gravity=(0, 0, -1.6))


def test_two_parts_of_one_name(arm):
    with pytest.raises(ModelError, match="the name is used twice"):
        arm + arm


@pytest.mark.parametrize("prefix", ["", "a.b", 3])
def test_prefix(arm, prefix):
    with pytest.raises(ModelError, match=r"Assembly of model 'arm': prefix = .*without dots"):
        arm.placed(prefix)


def test_what_is_no_model(arm):
    with pytest.raises(TypeError):
        arm + 3


def test_actions_of_events_are_renamed(arm):
    event = Event(
        "breaks",
        sensor="p",
        above=1.0,
        column=0,
        then=[Release("spring"), Lock("A"), Change("pull", marker="bar.center", force=(0, 0, 0)), Stop()],
    )
    placed = arm.with_parts(events=[event]).placed("left")
    release, lock, change, stop = placed.events[0].then
    assert placed.events[0].sensor == "left_p"
    assert (release.part, lock.joint, change.part) == ("left_spring", "left_A", "left_pull")
    assert change.values == {"marker": "left_bar.center", "force": (0, 0, 0)}
    assert isinstance(stop, Stop)
    assert event.then[0].part == "spring"


@pytest.mark.parametrize(
    ("name", "within"),
    [
        ("p", "left_p"),
        ("p x", "left_p x"),
        ("p: x", "left_p: x"),
        ("p x [m]", "left_p x [m]"),
        ("r fx", "left_r fx"),
        ("bar tip", "bar tip"),  # a sensor of the model around it, not a column of the body "bar"
        ("p q", "p q"),
        ("q", "q"),
    ],
)
def test_columns_of_own_sensors_are_renamed(arm, name, within):
    push = PointLoad("push", marker="bar.end", force=(measured(name), 0, 0))
    placed = arm.with_parts(forces=[push]).placed("left")
    assert f"'{within}'" in repr(placed.forces[-1].force[0])


def test_events_that_watch_a_column_are_renamed(arm):
    event = Event("e", sensor="p x [m]", above=1.0, then=Stop())
    assert arm.with_parts(events=[event]).placed("left").events[0].sensor == "left_p x [m]"


def test_a_sensor_around_that_begins_like_a_part_within():
    """The load follows "bob place", a sensor of the whole model; it was looked for as "left_bob place"."""
    push = PointLoad("push", marker="bob.center", force=(measured("bob place"), 0, 0))
    within = Model(bodies=[Ground(), PointMass("bob", mass=2.0)], forces=[push])
    around = Model(
        bodies=[Ground(), PointMass("other", mass=1.0, at=(3.0, 0, 0))],
        sensors=[Distance("bob place", markers=("ground.origin", "other.center"))],
    )
    run = fmb.simulate(around + within.placed("left"), t_end=1.0, samples=2)
    assert run[fmb.Position("x", marker="left_bob.center")][-1, 0] == pytest.approx(0.5 * 3.0 / 2.0, rel=1e-6)
