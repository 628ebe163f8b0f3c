"""Jacobians, recursive inverse dynamics, inverse kinematics and arms from tables."""

import runpy
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from contracts.random_models import beam, connected, put_together
from scipy.spatial.transform import Rotation
from tolerances import MACHINE
from tree.models import branched, chain, flexible_chain, loops, random_consistent

import flexmb as fmb
from flexmb.tree.coordinates.reach import advanced

PLAIN = ("Fixed", "Revolute", "Prismatic", "Cylindrical", "Spherical", "Universal", "Planar", "Screw")


def difference(tree, marker, q, k, h=1e-3):
    """Return the twist (6,) per rate k by central differences of sixth order."""
    _, R = tree.pose(marker, q)
    unit = np.zeros(len(tree.rate_names))
    unit[k] = h * (1e-3 if "mode" in tree.rate_names[k] else 1.0)
    total = np.zeros(6)
    for n, weight in zip((-3, -2, -1, 1, 2, 3), np.array((-1, 9, -45, 45, -9, 1)) / 60, strict=True):
        r, R_n = tree.pose(marker, advanced(tree, q, n * unit))
        total += weight * np.concatenate([r, Rotation.from_matrix(R_n @ R.T).as_rotvec()])
    return total / unit[k]


def assert_jacobian(model, marker, rng):
    _, state = random_consistent(model, rng)
    tree = fmb.JointTree(model)
    here = tree.relative(state)
    J = tree.jacobian(marker, here.q)
    for k in range(len(tree.rate_names)):
        np.testing.assert_allclose(
            J[:, k],
            difference(tree, marker, here.q, k),
            atol=1e-8 * max(1.0, np.abs(J).max()),
            err_msg=tree.rate_names[k],
        )


@pytest.mark.parametrize("pair", ["ground-rigid", "floating-ground", "rigid-floating", "floating-floating"])
@pytest.mark.parametrize("kind", PLAIN)
def test_jacobian_over_every_joint(kind, pair, rng):
    model = put_together(connected(kind, pair, rng))
    assert_jacobian(model, model.marker_names()[-1], rng)


@pytest.mark.parametrize("marker", ["ball.center", "wing.tip", "tail.end", "dust.center", "fin.mid", "hub.center"])
def test_jacobian_over_a_branched_tree(marker, rng):
    assert_jacobian(branched(), marker, rng)


@pytest.mark.parametrize(
    "make",
    [branched, lambda: flexible_chain(3), lambda: chain(5, fmb.Spherical)],
    ids=["branched", "flexible", "spherical"],
)
def test_free_motion_needs_no_torques(make, rng):
    """Accelerations of the recursion and the recursive inverse dynamics are inverse to each other, modes included."""
    model = make()
    system, state = random_consistent(model, rng)
    tree = fmb.JointTree(model)
    closed = tree.absolute(tree.relative(state))  # assembly leaves joints open by 1e-11 m, which stiff modes resist
    state = system.state(0.0, closed.q, closed.u)
    state.a[:] = fmb.Recursive().accelerate(system, state, system.workspace())[0]
    free = tree.relative(state)
    tau = tree.torques(free)
    scale = np.abs(tree.torques(free.q, free.v)).max()
    driven = [tree.rate_names.index(name) for name in tree.drives]
    assert np.abs(np.delete(tau, driven)).max() < 1e-9 * scale


def test_double_pendulum_in_closed_form(rng):
    """Two slender rods: inertia matrix, centrifugal and gravity terms as in textbooks (Craig 1986,
    section 6.7, in kind).
    """
    tree = fmb.JointTree(chain(2))
    (a, b), (u, v), (s, t) = rng.normal(size=(3, 2))
    g, J = 9.81, 1.0 / 12.0 + 0.05**2 / 4.0
    c, sine = np.cos(b), np.sin(b)
    one = (J + 0.25 + 1.0 + 0.25 + J + c) * s + (J + 0.25 + 0.5 * c) * t - 0.5 * sine * (2 * u * v + v * v)
    two = (J + 0.25 + 0.5 * c) * s + (J + 0.25) * t + 0.5 * sine * u * u
    one += g * (1.5 * np.cos(a) + 0.5 * np.cos(a + b))
    two += g * 0.5 * np.cos(a + b)
    np.testing.assert_allclose(tree.torques([a, b], [u, v], [s, t]), (one, two), rtol=1e-12, atol=1e-12)


def test_torques_are_those_of_drives():
    """Against the multipliers of `inverse_dynamics`, which solves all equations at once."""
    model = chain(3)
    drives = [fmb.Drive(f"d{k}", joint=f"j{k}", angle=fmb.expression(f"sin({k + 1}*t) - 0.3*t**2")) for k in range(3)]
    solution = fmb.inverse_dynamics(model, drives, 1.0, samples=51)
    tree = fmb.JointTree(model)
    tau = tree.torques(tree.relative(solution.final))
    for k in range(3):
        drive = solution[fmb.Reaction("torque", joint=f"d{k}")][-1]
        np.testing.assert_allclose(tau[k], drive[5], rtol=1e-9)


def mixed(rng):
    """Return a branched tree of hinges, slides and a weld in random places, half of them drawn from b to a."""
    bodies, joints = [fmb.Ground(markers={"m0": fmb.Pose(rng.normal(size=3), rng.normal(size=3))})], []
    kinds = (fmb.Revolute, fmb.Prismatic, fmb.Fixed, fmb.Revolute, fmb.Prismatic, fmb.Revolute)
    for k, kind in enumerate(kinds):
        poses = {f"m{n}": fmb.Pose(0.4 * rng.normal(size=3), rng.normal(size=3)) for n in range(3)}
        bodies.append(
            fmb.RigidBody(
                f"b{k}",
                mass=1.0 + rng.uniform(),
                inertia=rng.uniform(0.1, 0.15, 3),
                markers=poses,
                center_of_mass=0.2 * rng.normal(size=3),
                at=rng.normal(size=3),
            )
        )
        before = "ground.m0" if k == 0 else f"b{max(0, k - 1 - k % 2)}.m{1 + k % 2}"
        ends = (before, f"b{k}.m0")
        joints.append(kind(f"j{k}", markers=ends if k % 3 else ends[::-1]))
    return put_together(fmb.Model(bodies=bodies, joints=joints, gravity=(1.0, 2.0, -9.81)))


def test_accelerations_in_link_axes_are_those_of_the_recursion(rng):
    """Forward and inverse dynamics are inverse to each other; without torques the motion is that of `Recursive`."""
    tree = fmb.JointTree(mixed(rng))
    for _ in range(3):
        q, v, tau = rng.normal(size=(3, len(tree.names)))
        a = tree.accelerations(q, v, tau)
        np.testing.assert_allclose(tree.torques(q, v, a), tau, atol=1e-9 * max(1.0, np.abs(a).max()))
        state = tree.absolute(q, v)
        state.a[:] = fmb.Recursive().accelerate(tree.system, state, tree.system.workspace())[0]
        free = tree.relative(state).a
        np.testing.assert_allclose(tree.accelerations(q, v), free, atol=1e-9 * np.abs(free).max())


def flat() -> fmb.Model:
    """Return a reduced body on a hinge, whose mesh has no mass along z, like a planar one."""
    thin = replace(beam().invariants, vv=np.diag((1.0, 1.0, 0.0)) * beam().invariants.vv)
    model = flexible_chain(1)
    bodies = [
        body.replaced(data=replace(beam(), invariants=thin)) if body.name == "f0" else body for body in model.bodies
    ]
    return replace(model, bodies=bodies)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (
            flat,
            r"Body 'f0' \(joint 'j0'\): 9 modes, of which it does not tell .*\. Expected: points, rigid bodies with a "
            r"frame, and reduced ones in space\. Use .*formulation=fmb.Recursive",
        ),
        (
            lambda: chain(1).with_parts(
                bodies=[fmb.PointMass("bob", mass=1e-6, at=(1.0, -1.0, 0))],
                joints=[fmb.Rod("string", markers=("b0.end", "bob.center"))],
            ),
            r"Body 'bob': 1e-06 kg between joints that hold far heavier bodies",
        ),
        (
            lambda: chain(1).with_parts(forces=[fmb.JointFriction("rub", joint="j0", moving=0.1, radius=0.1)]),
            r"'rub'.*: a force that depends on reactions\. Expected: forces of place and motion",
        ),
    ],
)
def test_what_is_no_motion_of_links_is_named(make, message):
    tree = fmb.JointTree(make())
    with pytest.raises(fmb.CompileError, match=message):
        tree.accelerations(tree.start.q)


def test_drives_are_no_forward_dynamics():
    drive = fmb.Drive("motor", joint="j0", angle=fmb.ramp(rate=1.0))
    tree = fmb.JointTree(chain(2).with_parts(joints=[drive]))
    with pytest.raises(fmb.CompileError, match=r"prescribed motions: j0.turn\. .*Leave the drives out"):
        tree.accelerations(tree.start.q)


def test_a_link_without_inertia_is_named():
    tree = fmb.JointTree(chain(1))
    tree.accelerations([0.0])
    for name in ("mass", "h", "J"):  # assembly refuses such a body at the start; it shows up where it is needed only
        tree._links.links[name] = 0.0
    with pytest.raises(fmb.CompileError, match=r"Body 'b0' \(joint 'j0'\): its articulated inertia is singular"):
        tree.accelerations([0.0])


def test_torques_of_loops_are_refused():
    tree = fmb.JointTree(loops())
    with pytest.raises(fmb.CompileError, match=r"no tree: loops are closed by .*link"):
        tree.torques(tree.start)


def arm(kind=fmb.StandardLink, n=3):
    fields = {"mass": 1.0, "inertia": (0.1, 0.1, 0.1)}
    return fmb.serial_arm([kind(a=0.5, **fields) for _ in range(n)], tool=(0.0, 0.0, 0.0))


def test_inverse_kinematics_finds_the_pose(rng):
    tree = fmb.JointTree(runpy.run_path(str(Path(__file__).parents[2] / "examples" / "puma_arm.py"))["arm"]())
    for _ in range(5):
        there = rng.uniform(-1.5, 1.5, 6)
        r, R = tree.pose("link_6.tool", there)
        found = tree.reach("link_6.tool", fmb.Pose(r, R), start=there + 0.3 * rng.normal(size=6))
        r2, R2 = tree.pose("link_6.tool", found)
        np.testing.assert_allclose(r2, r, atol=1e-10)
        np.testing.assert_allclose(R2, R, atol=1e-9)


def test_inverse_kinematics_keeps_limits():
    """Elbow up and down reach the same point: limits choose; the angles follow from the law of cosines."""
    tree = fmb.JointTree(arm(n=2))
    elbow = np.arccos((0.6**2 - 2 * 0.25) / (2 * 0.25))
    for sign in (1, -1):
        limits = {"joint_2.turn": (0.01, 3.0) if sign > 0 else (-3.0, -0.01)}
        q = tree.reach("link_2.tool", (0.6, 0.0, 0.0), limits=limits, orientation=False)
        np.testing.assert_allclose(q[1], sign * elbow, atol=1e-9)
        np.testing.assert_allclose(q[0], -sign * elbow / 2, atol=1e-9)


def test_out_of_reach_says_how_far():
    tree = fmb.JointTree(arm(n=2))
    with pytest.raises(
        fmb.ModelError, match=r"'link_2.tool' gets no closer to its target than 0.25 m, at joint_1.turn = "
    ):
        tree.reach("link_2.tool", (0.0, 1.25, 0.0), orientation=False)
    with pytest.raises(fmb.ModelError, match=r"no closer to its target than 1\.[0-9]+ m"):
        tree.reach(
            "link_2.tool",
            (-0.9, 0.0, 0.0),
            orientation=False,
            limits={"joint_1.turn": (-0.5, 0.5), "joint_2.turn": (-0.5, 0.5)},
        )


def test_ball_joints_and_driven_joints_in_inverse_kinematics():
    tree = fmb.JointTree(chain(2, fmb.Spherical))
    q = tree.reach("b1.end", (0.5, 0.8, -0.7), orientation=False)
    np.testing.assert_allclose(tree.pose("b1.end", q)[0], (0.5, 0.8, -0.7), atol=1e-9)
    model = chain(2)
    driven = model.with_parts(joints=[fmb.Drive("d", joint="j0", angle=fmb.ramp(rate=0.0))])
    q = fmb.JointTree(driven).reach("b1.end", (1.0, 1.0, 0.0), orientation=False)
    np.testing.assert_allclose(q, (0.0, np.pi / 2), atol=1e-9)


@pytest.mark.parametrize(
    ("limits", "message"),
    [
        ({"joint_1.turn": (1.0, -1.0)}, r"limits of 'joint_1.turn': 1.0 to -1.0"),
        ({"joint_9.turn": (0.0, 1.0)}, r"no coordinate 'joint_9.turn'"),
    ],
)
def test_wrong_limits_are_named(limits, message):
    with pytest.raises(fmb.ModelError, match=message):
        fmb.JointTree(arm()).reach("link_3.tool", (1, 0, 0), limits=limits)


def test_a_marker_that_no_joint_moves_is_named():
    with pytest.raises(fmb.ModelError, match=r"no joint moves marker 'ground.base'"):
        fmb.JointTree(arm()).reach("ground.base", (1, 0, 0))


def matrix(kind, a, alpha, d, theta):
    """Return the product of the table's row as it is printed in Paul 1981 and Craig 1986."""
    c, s, ca, sa = np.cos(theta), np.sin(theta), np.cos(alpha), np.sin(alpha)
    if kind is fmb.StandardLink:
        return np.array([[c, -s * ca, s * sa, a * c], [s, c * ca, -c * sa, a * s], [0, sa, ca, d], [0, 0, 0, 1]])
    return np.array([[c, -s, 0, a], [s * ca, c * ca, -sa, -sa * d], [s * sa, c * sa, ca, ca * d], [0, 0, 0, 1]])


@pytest.mark.parametrize("kind", [fmb.StandardLink, fmb.ModifiedLink])
def test_arms_are_products_of_denavit_hartenberg_matrices(kind, rng):
    rows = rng.uniform(-1, 1, (5, 4))
    slides = (False, True, False, True, False)
    links = [
        kind(a=a, alpha=alpha, d=d, theta=theta, slides=slide, mass=1.0, inertia=(1, 1, 1))
        for (a, alpha, d, theta), slide in zip(rows, slides, strict=True)
    ]
    tree = fmb.JointTree(fmb.serial_arm(links))
    assert tree.names == ("joint_1.turn", "joint_2.slide", "joint_3.turn", "joint_4.slide", "joint_5.turn")
    q = rng.uniform(-2, 2, 5)
    T = np.eye(4)
    for (a, alpha, d, theta), slide, x in zip(rows, slides, q, strict=True):
        T = T @ matrix(kind, a, alpha, d + x if slide else d, theta if slide else theta + x)
    r, R = tree.pose("link_5.tool", q)
    np.testing.assert_allclose(r, T[:3, 3], atol=10 * MACHINE)
    np.testing.assert_allclose(R, T[:3, :3], atol=10 * MACHINE)


def test_puma_560():
    """The pose in closed form, and the holding torques that the Robotics Toolbox for Python (Corke & Haviland,
    tests/test_DHRobot.py, test_gravload) expects, to the digits printed."""
    found = runpy.run_path(str(Path(__file__).parents[2] / "examples" / "puma_arm.py"))["main"]()
    hand = ((2 * 0.4318 - 0.0203) / np.sqrt(2.0), -0.15005, -0.0203 / np.sqrt(2.0))
    np.testing.assert_allclose(found[:3], hand, atol=10 * MACHINE)
    np.testing.assert_allclose(found[3:], (0.0, 31.6399, 6.0351, 0.0, 0.0283, 0.0), atol=6e-5)


def test_links_that_are_none_are_refused():
    with pytest.raises(fmb.ModelError, match=r"links = \[\]\..*at least one StandardLink"):
        fmb.serial_arm([])
    with pytest.raises(fmb.ModelError, match="alpha = '90'"):
        fmb.StandardLink(alpha="90", mass=1.0, inertia=(1, 1, 1))


@pytest.mark.peer
def test_pinocchio_agrees(rng):
    """Poses, Jacobians, inverse dynamics and accelerations of a random arm in Pinocchio."""
    pin = pytest.importorskip("pinocchio")
    model, data, q, v, a = pinocchio_arm(pin, rng)
    tree = fmb.JointTree(pinocchio_twin(model))
    pin.forwardKinematics(model, data, q, v, a)
    end = data.oMi[model.njoints - 1]
    name = f"link_{model.njoints - 1}.tool"
    r, R = tree.pose(name, q)
    np.testing.assert_allclose(r, end.translation, atol=1e-11)
    np.testing.assert_allclose(R, end.rotation, atol=1e-11)
    theirs = pin.computeJointJacobian(model, data, q, model.njoints - 1)
    np.testing.assert_allclose(tree.jacobian(name, q), np.kron(np.eye(2), end.rotation) @ theirs, atol=1e-10)
    tau = pin.rnea(model, data, q, v, a)
    np.testing.assert_allclose(tree.torques(q, v, a), tau, atol=1e-10 * np.abs(tau).max())
    system = tree.system
    free = tree.absolute(q, v)
    free.a[:] = fmb.Recursive().accelerate(system, free, system.workspace())[0]
    ours = tree.relative(free).a
    np.testing.assert_allclose(tree.accelerations(q, v, tau), a, atol=1e-9 * np.abs(a).max())
    np.testing.assert_allclose(ours, pin.aba(model, data, q, v, np.zeros(len(q))), atol=1e-9 * np.abs(ours).max())


def pinocchio_arm(pin, rng, n=6):
    """Return an arm of n hinges about z with random placements and inertias, its data and a random state."""
    model = pin.Model()
    model.gravity.linear = np.array([0.3, -0.5, -9.81])
    for k in range(n):
        placement = pin.SE3(Rotation.from_rotvec(rng.normal(size=3)).as_matrix(), rng.normal(size=3))
        joint = model.addJoint(k, pin.JointModelRZ(), placement, f"joint_{k + 1}")
        A = rng.normal(size=(3, 3))
        J = A @ A.T + np.eye(3)
        body = pin.Inertia(1.0 + rng.uniform(), 0.2 * rng.normal(size=3), 0.1 * (np.trace(J) * np.eye(3) - J))
        model.appendBodyToJoint(joint, body, pin.SE3.Identity())
    return model, model.createData(), *rng.normal(size=(3, n))


def pinocchio_twin(model):
    """Return the same arm as a model."""
    bodies, joints, T = [], [], np.eye(4)
    seats = [model.jointPlacements[k] for k in range(1, model.njoints)]
    poses = [fmb.Pose(seat.translation, seat.rotation) for seat in seats]
    bodies.append(fmb.Ground(markers={"out": poses[0]}))
    for k, seat in enumerate(seats, 1):
        T = T @ seat.homogeneous
        inertia = model.inertias[k]
        last = {"out": poses[k]} if k < len(seats) else {"tool": (0, 0, 0)}
        bodies.append(
            fmb.RigidBody(
                f"link_{k}",
                mass=inertia.mass,
                inertia=inertia.inertia,
                center_of_mass=inertia.lever,
                at=T[:3, 3],
                rotation=T[:3, :3],
                markers={"in": (0, 0, 0), **last},
            )
        )
        joints.append(fmb.Revolute(f"joint_{k}", markers=(f"{bodies[k - 1].name}.out", f"link_{k}.in")))
    return fmb.Model(bodies=bodies, joints=joints, gravity=tuple(model.gravity.linear))
