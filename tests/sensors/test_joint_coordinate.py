"""Joint coordinates: turns counted by drives whatever the samples are, every freedom of joints that have several."""

from dataclasses import replace

import numpy as np
import pytest
from by_turns import slow

import flexmb as fmb

ANGLE = "40*t + 6*sin(25*t)"


def crank(*joints, sensors) -> fmb.Model:
    body = fmb.RigidBody("crank", mass=1.0, inertia=(0.1, 0.1, 0.1), markers={"pin": (0, 0, 0)})
    return fmb.Model(bodies=[fmb.Ground(), body], joints=list(joints), sensors=sensors)


@pytest.mark.parametrize(
    "integrator", [fmb.GeneralizedAlpha(), slow(fmb.IDA()), fmb.Explicit()], ids=["alpha", "IDA", "explicit"]
)
def test_turns_of_a_driven_joint_do_not_depend_on_the_samples(integrator):
    """13 turns between two samples at changing speed: the drive has counted them."""
    joint = fmb.Revolute("pin", markers=("ground.origin", "crank.pin"))
    model = crank(
        joint,
        fmb.Drive("motor", joint="pin", angle=fmb.expression(ANGLE)),
        sensors=[fmb.JointCoordinate("angle", joint="pin"), fmb.JointCoordinate("motor angle", joint="motor")],
    )
    solution = fmb.simulate(model, 6.0, samples=[0.0, 2.1, 5.9, 6.0], integrator=integrator)
    expected = 40 * solution.t + 6 * np.sin(25 * solution.t)
    for name in ("angle", "motor angle"):
        np.testing.assert_allclose(solution[name], expected, atol=1e-8)


def spinning(**fields) -> fmb.Model:
    """A crank that a torque of 3 N m speeds up from 50 rad/s: 0.1 w' = 3."""
    joint = fmb.Revolute("pin", markers=("ground.origin", "crank.pin"))
    return replace(
        crank(joint, **fields).changed("crank", angular_velocity=(0, 0, 50.0)),
        forces=[fmb.PointLoad("torque", marker="crank.center", moment=(0, 0, 3.0))],
    )


@pytest.mark.parametrize(
    "integrator",
    [fmb.GeneralizedAlpha(), fmb.GeneralizedAlpha(step=0.25), fmb.IDA(), fmb.Explicit()],
    ids=["alpha", "2 turns in a step", "IDA", "explicit"],
)
def test_turns_of_a_free_joint_do_not_depend_on_the_samples(integrator):
    """Uniform acceleration makes steps of many radians exact; phi = 50 t + 15 t^2, 69 turns between two samples."""
    solution = fmb.simulate(
        spinning(sensors=[fmb.JointCoordinate("angle", joint="pin")]),
        6.0,
        samples=[0.0, 0.5, 5.9, 6.0],
        integrator=integrator,
    )
    np.testing.assert_allclose(solution["angle"], 50.0 * solution.t + 15.0 * solution.t**2, rtol=1e-6)


def test_turns_of_a_torsion_spring_at_large_steps():
    """The spring counts them too: 0.002 N m/rad and 0.1 kg m2, phi = 500/w sin(w t), w = sqrt(0.02) rad/s."""
    model = spinning(sensors=[fmb.JointCoordinate("angle", joint="pin")])
    model = replace(
        model.changed("crank", angular_velocity=(0, 0, 500.0)),
        forces=[fmb.TorsionSpring("spring", joint="pin", stiffness=2e-3)],
    )
    w = np.sqrt(2e-3 / 0.1)
    for integrator in (fmb.GeneralizedAlpha(rtol=1e-4), fmb.Explicit(rtol=1e-6)):
        solution = fmb.simulate(model, 10.0, samples=[0.0, 10.0], integrator=integrator)
        assert solution["angle"][-1] == pytest.approx(500.0 / w * np.sin(10.0 * w), rel=1e-3)


def test_turns_of_a_kinematic_motion_with_few_samples():
    """A drive of one joint, its turn read in the coupled one: x_a = x_b / 5, 100 rad between samples."""
    bodies = [fmb.Ground(), *(fmb.RigidBody(name, mass=1.0, inertia=(0.1, 0.1, 0.1)) for name in "ab")]
    joints = [fmb.Revolute(f"axis {name}", markers=("ground.origin", f"{name}.center")) for name in "ab"]
    joints += [
        fmb.Drive("motor", joint="axis a", angle=fmb.expression("10*t")),
        fmb.Coupler("gear", joints=("axis a", "axis b"), ratio=0.2),
    ]
    model = fmb.Model(bodies=bodies, joints=joints, sensors=[fmb.JointCoordinate("b", joint="axis b")])
    solution = fmb.kinematics(model, 6.0, samples=4)
    np.testing.assert_allclose(solution["b"], 50.0 * solution.t, rtol=1e-9, atol=1e-9)


def test_a_sensor_that_comes_later_says_when_samples_are_too_far_apart():
    sensor = fmb.JointCoordinate("angle", joint="pin")
    model = spinning(sensors=[])
    torque = fmb.PointLoad("torque", marker="crank.center", moment=(0, 0, fmb.expression("40*sin(3*t)")))
    model = replace(model, forces=[torque])
    solution = fmb.simulate(model, 6.0, samples=[0.0, 3.1, 6.0])
    with pytest.raises(fmb.FlexmbError) as caught:
        solution[sensor]
    assert "too far apart to count the turns" in str(caught.value)
    assert all((caught.value.part, caught.value.expected, caught.value.remedy))
    closer = fmb.simulate(model, 6.0, samples=61)
    w = 50.0 + 400.0 / 3.0
    np.testing.assert_allclose(closer[sensor], w * closer.t - 400.0 / 9.0 * np.sin(3 * closer.t), rtol=1e-4, atol=1e-3)


def test_slides_of_a_planar_joint():
    joint = fmb.Planar("table", markers=("ground.origin", "crank.pin"))
    sensors = [fmb.JointCoordinate(name, joint="table", freedom=name) for name in ("turn", "slide_x", "slide_y")]
    model = crank(joint, sensors=sensors)
    model = model.changed("crank", velocity=(0.3, -0.2, 0), angular_velocity=(0, 0, 4.0))
    solution = fmb.simulate(model, 2.0, samples=5, integrator=fmb.Explicit())
    for name, rate in (("turn", 4.0), ("slide_x", 0.3), ("slide_y", -0.2)):
        np.testing.assert_allclose(solution[name], rate * solution.t, atol=1e-6)
    assert solution.column_titles("slide_x") == ("displacement [m]",)


def test_both_turns_of_a_cross_shaft():
    """One turn is driven, the other follows a second drive: each sensor reads its own."""
    body = fmb.RigidBody(
        "crank", mass=1.0, inertia=(0.1, 0.1, 0.1), markers={"pin": fmb.Pose.axes(z=(1, 0, 0), x=(0, 0, 1))}
    )
    turns = {"turn": "0.3*sin(4*t)", "turn_b": "-0.5*sin(3*t)"}
    joint = fmb.Universal("cross", markers=("ground.origin", "crank.pin"))
    drives = [
        fmb.Drive(f"drive {name}", joint="cross", freedom=name, angle=fmb.expression(text))
        for name, text in turns.items()
    ]
    sensors = [fmb.JointCoordinate(name, joint="cross", freedom=name) for name in turns]
    model = fmb.Model(bodies=[fmb.Ground(), body], joints=[joint, *drives], sensors=sensors)
    solution = fmb.simulate(model, 1.0, samples=11)
    t = solution.t
    for name, expected in (("turn", 0.3 * np.sin(4 * t)), ("turn_b", -0.5 * np.sin(3 * t))):
        np.testing.assert_allclose(solution[name], expected, atol=1e-6)


@pytest.mark.parametrize(
    ("fields", "found"),
    [
        ({"freedom": "slide_x"}, "permits no slide_x"),
        ({"freedom": "spin"}, "permits no spin"),
        ({"freedom": "turn", "kind": "turn"}, "both kind = 'turn' and freedom = 'turn'"),
    ],
)
def test_messages(fields, found):
    joint = fmb.Revolute("pin", markers=("ground.origin", "crank.pin"))
    with pytest.raises(fmb.ModelError) as caught:
        crank(joint, sensors=[fmb.JointCoordinate("angle", joint="pin", **fields)])
    assert found in str(caught.value)
    assert all((caught.value.part, caught.value.expected, caught.value.remedy))
