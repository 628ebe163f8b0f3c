"""Joint coordinates: turns counted by drives whatever the samples are, every freedom of joints that have several."""

import numpy as np
import pytest

import flexmb as fmb

ANGLE = "40*t + 6*sin(25*t)"


def crank(*joints, sensors) -> fmb.Model:
    body = fmb.RigidBody("crank", mass=1.0, inertia=(0.1, 0.1, 0.1), markers={"pin": (0, 0, 0)})
    return fmb.Model(bodies=[fmb.Ground(), body], joints=list(joints), sensors=sensors)


@pytest.mark.parametrize("integrator", [fmb.GeneralizedAlpha(), fmb.IDA(), fmb.Explicit()], ids=["alpha", "IDA", "explicit"])
def test_turns_of_a_driven_joint_do_not_depend_on_the_samples(integrator):
    """13 turns between two samples at changing speed: the drive has counted them."""
    joint = fmb.Revolute("pin", markers=("ground.origin", "crank.pin"))
    model = crank(joint, fmb.Drive("motor", joint="pin", angle=fmb.expression(ANGLE)),
                  sensors=[fmb.JointCoordinate("angle", joint="pin"), fmb.JointCoordinate("motor angle", joint="motor")])
    solution = fmb.simulate(model, 6.0, samples=[0.0, 2.1, 5.9, 6.0], integrator=integrator)
    expected = 40 * solution.t + 6 * np.sin(25 * solution.t)
    for name in ("angle", "motor angle"):
        np.testing.assert_allclose(solution[name], expected, atol=1e-8)


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
    body = fmb.RigidBody("crank", mass=1.0, inertia=(0.1, 0.1, 0.1), markers={"pin": fmb.Pose.axes(z=(1, 0, 0), x=(0, 0, 1))})
    turns = {"turn": "0.3*sin(4*t)", "turn_b": "-0.5*sin(3*t)"}
    joint = fmb.Universal("cross", markers=("ground.origin", "crank.pin"))
    drives = [fmb.Drive(f"drive {name}", joint="cross", freedom=name, angle=fmb.expression(text))
              for name, text in turns.items()]  # fmt: skip
    sensors = [fmb.JointCoordinate(name, joint="cross", freedom=name) for name in turns]
    model = fmb.Model(bodies=[fmb.Ground(), body], joints=[joint, *drives], sensors=sensors)
    solution = fmb.simulate(model, 1.0, samples=11)
    t = solution.t
    for name, expected in (("turn", 0.3 * np.sin(4 * t)), ("turn_b", -0.5 * np.sin(3 * t))):
        np.testing.assert_allclose(solution[name], expected, atol=1e-6)


@pytest.mark.parametrize(
    ("fields", "found"),
    [({"freedom": "slide_x"}, "permits no slide_x"), ({"freedom": "spin"}, "permits no spin"),
     ({"freedom": "turn", "kind": "turn"}, "both kind = 'turn' and freedom = 'turn'")],
)  # fmt: skip
def test_messages(fields, found):
    joint = fmb.Revolute("pin", markers=("ground.origin", "crank.pin"))
    with pytest.raises(fmb.ModelError) as caught:
        crank(joint, sensors=[fmb.JointCoordinate("angle", joint="pin", **fields)])
    assert found in str(caught.value)
    assert all((caught.value.part, caught.value.expected, caught.value.remedy))
