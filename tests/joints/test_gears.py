"""Couplers, racks and screws against closed forms, through many turns."""

import numpy as np
import pytest
from tolerances import SOLVER

import flexmb as fmb

INTEGRATORS = [fmb.GeneralizedAlpha(rho_inf=0.9, step=1e-3), fmb.IDA(rtol=1e-9, atol=1e-11)]


def wheel(name, J, at=(0, 0, 0), **fields):
    return fmb.RigidBody(name, mass=1.0, inertia=(J, J, J), at=at, **fields)


@pytest.mark.parametrize("integrator", INTEGRATORS, ids=["alpha", "IDA"])
def test_gear_pair_accelerates_as_one_inertia(integrator):
    """alpha_A = T / (J_A + J_B / i^2) with i = speed of A over speed of B; 23 turns."""
    J, T, i = (0.2, 0.5), 3.0, -2.5
    model = fmb.Model(
        bodies=[
            fmb.Ground(markers={"A": (0, 0, 0), "B": (0.3, 0, 0)}),
            wheel("a", J[0]),
            wheel("b", J[1], (0.3, 0, 0)),
        ],
        joints=[
            fmb.Revolute("A", markers=("ground.A", "a.center")),
            fmb.Revolute("B", markers=("ground.B", "b.center")),
            fmb.Coupler("gear", joints=("A", "B"), ratio=i),
        ],
        forces=[fmb.Actuator("motor", joint="A", effort=T)],
        sensors=[
            fmb.JointCoordinate("x", joint="A"),
            fmb.JointCoordinate("y", joint="B"),
            fmb.Reaction("mesh", joint="gear"),
        ],
    )
    solution = fmb.simulate(model, 5.0, samples=51, integrator=integrator)
    alpha = T / (J[0] + J[1] / i**2)
    assert solution["x"][-1] == pytest.approx(12.5 * alpha, rel=SOLVER)
    np.testing.assert_allclose(solution["x"], i * solution["y"], atol=1e-7)
    assert solution["mesh"][-1, 5] == pytest.approx(-alpha / i * J[1] / i, rel=1e-5)


def test_planetary_gear():
    """Willis with a fixed ring: speed of the sun / speed of the carrier = 1 + z_R / z_S."""
    z_s, z_p, z_r = 20, 16, 52
    arm = (z_s + z_p) * 1e-3
    model = fmb.Model(
        bodies=[
            fmb.Ground(),
            wheel("carrier", 0.3, markers={"pin": (arm, 0, 0)}),
            wheel("sun", 0.1),
            wheel("planet", 0.05, (arm, 0, 0)),
        ],
        joints=[
            fmb.Revolute("carrier axis", markers=("ground.origin", "carrier.center")),
            fmb.Revolute("sun axis", markers=("carrier.center", "sun.center")),
            fmb.Revolute("planet axis", markers=("carrier.pin", "planet.center")),
            fmb.Coupler("sun mesh", joints=("sun axis", "planet axis"), ratio=-z_p / z_s),
            # the ring is the ground: its turn in the carrier is minus that of the carrier
            fmb.Coupler("ring mesh", joints=("planet axis", "carrier axis"), ratio=-z_r / z_p),
            fmb.Drive("motor", joint="carrier axis", angle=fmb.ramp(rate=40.0, rise=0.2)),
        ],
        sensors=[
            fmb.JointCoordinate("carrier", joint="carrier axis"),
            fmb.JointCoordinate("sun", joint="sun axis"),
        ],
    )
    assert fmb.check(model).mobility == 0
    for solution in (fmb.simulate(model, 1.0, samples=101), fmb.kinematics(model, 1.0, samples=101)):
        assert solution["carrier"][-1] == pytest.approx(36.0, rel=SOLVER)
        np.testing.assert_allclose(
            solution["carrier"] + solution["sun"], (1 + z_r / z_s) * solution["carrier"], atol=1e-8
        )


def test_right_angle_gearbox():
    """Shafts along x and y in one casing, 1:1; the casing carries both torques."""
    x, y = fmb.Pose.axes(z=(1, 0, 0)), fmb.Pose.axes(z=(0, 1, 0))
    model = fmb.Model(
        bodies=[
            fmb.Ground(markers={"x": x, "y": y}),
            wheel("in", 0.1, markers={"a": x}),
            wheel("out", 0.3, markers={"a": y}),
        ],
        joints=[
            fmb.Revolute("X", markers=("ground.x", "in.a")),
            fmb.Revolute("Y", markers=("ground.y", "out.a")),
            fmb.Coupler("bevel", joints=("Y", "X"), ratio=1.0),
        ],
        forces=[fmb.Actuator("motor", joint="X", effort=2.0)],
    )
    result = fmb.accelerations(model)
    np.testing.assert_allclose(result["out"][3:], [0, 5.0, 0], atol=1e-9)
    np.testing.assert_allclose(result["in"][3:], [5.0, 0, 0], atol=1e-9)


@pytest.mark.parametrize("integrator", INTEGRATORS, ids=["alpha", "IDA"])
def test_rack(integrator):
    """The rack falls with g m / (m + J / r^2) and turns its pinion many times."""
    m, J, r = 2.0, 1e-3, 0.02
    up = fmb.Pose.axes(z=(0, 0, 1))
    model = fmb.Model(
        gravity=(0, 0, -9.81),
        bodies=[
            fmb.Ground(markers={"pin": fmb.Pose.axes(z=(0, 1, 0)), "guide": up}),
            fmb.RigidBody("rack", mass=m, inertia=(1, 1, 1)),
            fmb.RigidBody("pinion", mass=1.0, inertia=(J, J, J), markers={"pin": fmb.Pose.axes(z=(0, 1, 0))}),
        ],
        joints=[
            fmb.Revolute("pin", markers=("ground.pin", "pinion.pin")),
            fmb.Prismatic("guide", markers=("ground.guide", "rack.center")),
            fmb.RackAndPinion("teeth", joints=("pin", "guide"), radius=r),
        ],
        sensors=[
            fmb.JointCoordinate("turn", joint="pin"),
            fmb.JointCoordinate("slide", joint="guide"),
            fmb.Reaction("force", joint="teeth"),
        ],
    )
    solution = fmb.simulate(model, 1.5, samples=151, integrator=integrator)
    a = -9.81 * m / (m + J / r**2)
    assert solution["slide"][-1] == pytest.approx(0.5 * a * 1.5**2, rel=SOLVER)
    assert solution["turn"][-1] == pytest.approx(solution["slide"][-1] / r, rel=SOLVER)
    assert solution["force"][-1, 2] == pytest.approx(m * (a + 9.81), rel=1e-5)


@pytest.mark.parametrize("integrator", INTEGRATORS, ids=["alpha", "IDA"])
def test_nut_runs_down_its_screw(integrator):
    """s'' = -g / (1 + J (2 pi / p)^2 / m) over 12 turns."""
    m, J, pitch = 1.5, 2e-3, 0.05
    model = fmb.Model(
        gravity=(0, 0, -9.81),
        bodies=[fmb.Ground(), fmb.RigidBody("nut", mass=m, inertia=(J, J, J))],
        joints=[fmb.Screw("thread", markers=("ground.origin", "nut.center"), pitch=pitch)],
        sensors=[
            fmb.Position("nut", marker="nut.center"),
            fmb.JointCoordinate("turn", joint="thread", kind="turn"),
        ],
    )
    assert fmb.check(model).mobility == 1
    solution = fmb.simulate(model, 1.6, samples=161, integrator=integrator)
    a = -9.81 / (1.0 + J * (2 * np.pi / pitch) ** 2 / m)
    assert solution["nut"][-1, 2] == pytest.approx(0.5 * a * 1.6**2, rel=SOLVER)
    np.testing.assert_allclose(solution["turn"], solution["nut"][:, 2] * 2 * np.pi / pitch, atol=1e-6)


def test_turns_are_kept_through_an_event_and_a_file(tmp_path):
    """A screw that has turned three times goes on from there when a force breaks."""
    model = fmb.Model(
        bodies=[
            fmb.Ground(),
            fmb.RigidBody(
                "nut",
                mass=1.0,
                inertia=(0.1, 0.1, 0.1),
                angular_velocity=(0, 0, 20.0),
                velocity=(0, 0, 2.0 / np.pi),
            ),
        ],
        joints=[fmb.Screw("thread", markers=("ground.origin", "nut.center"), pitch=0.2)],
        forces=[
            fmb.TorsionSpring("spring", joint="thread", stiffness=0.0),
            fmb.PointLoad("nothing", marker="nut.center"),
        ],
        sensors=[fmb.Position("nut", marker="nut.center"), fmb.ForceOf("torque", force="spring")],
        events=[fmb.Event("break", at=1.0, then=fmb.Release("nothing"))],
    )
    solution = fmb.simulate(model.changed("spring", stiffness=1e-9), 2.0, samples=41, output=tmp_path / "run.h5")
    assert len(solution.phases) == 2
    assert solution["nut"][-1, 2] == pytest.approx(40.0 * 0.2 / (2 * np.pi), rel=SOLVER)
    assert solution["torque"][-1, 5] == pytest.approx(-40e-9, rel=1e-5)
    assert fmb.Solution.load(tmp_path / "run.h5")["torque"][-1, 5] == pytest.approx(-40e-9, rel=1e-5)


@pytest.mark.parametrize(
    ("make", "found"),
    [
        (lambda: fmb.Coupler("c", joints=("A", "A"), ratio=2.0), "coupled with itself"),
        (lambda: fmb.Coupler("c", joints=("A", "X"), ratio=2.0), "joint 'X' does not exist"),
        (lambda: fmb.Coupler("c", joints=("A", "ball"), ratio=2.0), "permits no turn or slide"),
        (
            lambda: fmb.Coupler("c", joints=("A", "B"), ratio=2.0, freedoms=("turn", "slide")),
            "permits no slide",
        ),
        (lambda: fmb.Coupler("c", joints="A", ratio=2.0), "joints = 'A'"),
        (lambda: fmb.Coupler("c", joints=("A", "B"), ratio=0.0), "ratio = 0.0"),
        (lambda: fmb.RackAndPinion("r", joints=("A", "B"), radius=0.1), "permits no slide"),
        (lambda: fmb.RackAndPinion("r", joints=("A", "B"), radius=0.0), "radius = 0.0"),
        (lambda: fmb.RackAndPinion("r", joints="A", radius=0.1), "joints = 'A'"),
        (lambda: fmb.Screw("s", markers=("ground.origin", "a.center"), pitch=0.0), "pitch = 0.0"),
        (lambda: fmb.Drive("d", joint="A", angle=0.0, freedom="turn_b"), "permits no turn_b"),
        (lambda: fmb.Drive("d", joint="A", displacement=0.0, freedom="slid"), "permits no slid"),
    ],
)
def test_messages(make, found):
    with pytest.raises(fmb.ModelError, match=found):
        fmb.Model(
            bodies=[fmb.Ground(), wheel("a", 0.1), wheel("b", 0.1)],
            joints=[
                fmb.Revolute("A", markers=("ground.origin", "a.center")),
                fmb.Revolute("B", markers=("ground.origin", "b.center")),
                fmb.Spherical("ball", markers=("ground.origin", "b.center")),
                make(),
            ],
        )
