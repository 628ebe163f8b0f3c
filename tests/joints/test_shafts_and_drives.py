"""Universal and constant-velocity joints between two shafts; drives of every freedom."""

import numpy as np
import pytest

import flexmb as fmb


def shafts(joint, bend):
    """Two shafts through the origin, the second bent by an angle about x, the first one driven."""
    second = fmb.Pose(rotation=(bend, 0, 0))
    quarter = fmb.Pose.axes(x=(1, 0, 0), z=(0, -1, 0))
    markers = {"fork": quarter} if joint is fmb.Universal else {}
    return fmb.Model(
        bodies=[
            fmb.Ground(markers={"bent": second}),
            fmb.RigidBody(
                "one", mass=1.0, inertia=(1, 1, 1), markers={"fork": fmb.Pose.axes(x=(0, 1, 0), z=(1, 0, 0))}
            ),
            fmb.RigidBody("two", mass=1.0, inertia=(1, 1, 1), rotation=second.matrix, markers=markers),
        ],
        joints=[
            fmb.Revolute("in", markers=("ground.origin", "one.center")),
            fmb.Cylindrical("out", markers=("ground.bent", "two.center")),
            joint("coupling", markers=("one.fork", "two.fork") if markers else ("one.center", "two.center")),
            fmb.Drive("motor", joint="in", angle=fmb.ramp(rate=5.0)),
        ],
        sensors=[
            fmb.JointCoordinate("angle", joint="in"),
            fmb.JointCoordinate("turned", joint="out", kind="turn"),
        ],
    )


@pytest.mark.parametrize("bend", [0.0, 0.6, 1.3])
def test_constant_velocity(bend):
    solution = fmb.kinematics(shafts(fmb.ConstantVelocity, bend), 3.0, samples=301)
    np.testing.assert_allclose(solution["turned"], solution["angle"], atol=1e-9)


def test_universal_joint_is_not():
    """Hooke's joint: tan(out) = tan(in) cos(bend), for the phase in which the input fork lies across the bend."""
    bend = 0.6
    solution = fmb.kinematics(shafts(fmb.Universal, bend), 3.0, samples=301)
    a, b = solution["angle"], solution["turned"] - solution["turned"][0]
    ways = [np.unwrap(np.arctan2(np.sin(a) * k, np.cos(a))) for k in (np.cos(bend), 1.0 / np.cos(bend))]
    assert min(np.abs(b - way).max() for way in ways) < 1e-8
    assert np.abs(b - a).max() > 0.05


@pytest.mark.parametrize(
    ("joint", "freedom", "kind"),
    [
        (fmb.Planar, "slide_x", "displacement"),
        (fmb.Planar, "slide_y", "displacement"),
        (fmb.Planar, "turn", "angle"),
        (fmb.Cylindrical, "slide", "displacement"),
        (fmb.Cylindrical, "turn", "angle"),
    ],
)
def test_drive_of_a_freedom(joint, freedom, kind):
    signal = fmb.expression("0.2*sin(3*t)")
    model = fmb.Model(
        bodies=[fmb.Ground(), fmb.RigidBody("b", mass=1.0, inertia=(1, 1, 1))],
        joints=[
            joint("j", markers=("ground.origin", "b.center")),
            fmb.Drive("d", joint="j", freedom=freedom, **{kind: signal}),
        ],
        sensors=[fmb.Position("r", marker="b.center"), fmb.JointCoordinate("turn", joint="j", kind="turn")],
    )
    solution = fmb.simulate(model, 1.0, samples=11, integrator=fmb.GeneralizedAlpha(step=1e-3))
    moved = np.column_stack([solution["r"], solution["turn"]])
    column = {"slide_x": 0, "slide_y": 1, "slide": 2, "turn": 3}[freedom]
    np.testing.assert_allclose(moved[:, column], 0.2 * np.sin(3 * solution.t), atol=1e-9)
    np.testing.assert_allclose(np.delete(moved, column, axis=1), 0.0, atol=1e-6)


def test_both_freedoms_of_a_universal_joint():
    """Cross shaft: turn about z of a, then about z of b: R = Rz(first) C Rz(second)."""
    first, second = 0.4, -0.7
    cross = fmb.Pose.axes(x=(0, 1, 0), z=(1, 0, 0))
    model = fmb.Model(
        bodies=[fmb.Ground(), fmb.RigidBody("b", mass=1.0, inertia=(1, 1, 1), rotation=cross.matrix)],
        joints=[
            fmb.Universal("j", markers=("ground.origin", "b.center")),
            fmb.Drive("one", joint="j", angle=first),
            fmb.Drive("two", joint="j", angle=second, freedom="turn_b"),
        ],
    )
    solution = fmb.kinematics(model, 1.0, samples=2)
    sensor = fmb.Orientation("o", marker="b.center")
    w, x, y, z = solution[sensor][-1]
    R = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )
    np.testing.assert_allclose(np.arctan2(R[1, 2], R[0, 2]), first, atol=1e-10)
    np.testing.assert_allclose(-np.arctan2(R[2, 1], R[2, 0]), second, atol=1e-10)
