"""Relative coordinates: round trips over every kind of joint and body, closed forms, and what is refused."""

import numpy as np
import pytest
from by_turns import every_second
from contracts.random_models import connected, put_together
from scipy.spatial.transform import Rotation
from tolerances import MACHINE, SOLVER
from tree.models import branched, chain, flexible_chain, loops, random_consistent

import flexmb as fmb
from flexmb.math.rotations import euler_to_matrix
from flexmb.system import assemble

PLAIN = ("Fixed", "Revolute", "Prismatic", "Cylindrical", "Spherical", "Universal", "Planar", "Screw")
"""Kinds of joints that have relative coordinates."""
ROUND = 1e-10
"""Round trip, relative: the states of the test satisfy their joints to 1e-11."""
ACROSS = fmb.Pose((0, 0, 0), (0, np.pi / 2, 0))


def frames(model, q):
    """Return the poses (4, 4) of all bodies with frames by name."""
    system, _ = assemble(model)
    out = {}
    for name, (iq, _) in system.body_slices.items():
        if model.body(name).has_frame and iq.stop > iq.start:
            T = np.eye(4)
            R = np.empty((3, 3))
            euler_to_matrix(q[iq][3:7].copy(), R)
            T[:3, :3], T[:3, 3] = R, q[iq][:3]
            out[name] = T
    return out


def assert_round_trip(model, rng, tolerance=ROUND, **options):
    """Compare a random consistent state, with its accelerations, with what comes back."""
    system, state = random_consistent(model, rng, **options)
    state.a[:] = fmb.Recursive().accelerate(system, state, system.workspace())[0]
    tree = fmb.JointTree(model)
    back = tree.absolute(tree.relative(state))
    for name in frames(model, state.q):
        np.testing.assert_allclose(frames(model, back.q)[name], frames(model, state.q)[name], atol=tolerance)
    for one, two in ((back.u, state.u), (back.a, state.a)):
        np.testing.assert_allclose(one, two, atol=tolerance * max(1.0, np.abs(two).max()))
    return tree, state, back


@pytest.mark.parametrize(
    ("kind", "pair"),
    every_second(PLAIN, ["ground-rigid", "rigid-rigid", "floating-ground", "rigid-floating", "floating-floating"]),
)
def test_round_trip_over_every_joint(kind, pair, rng):
    tree, _, _ = assert_round_trip(put_together(connected(kind, pair, rng)), rng)
    assert not tree.tree.cut


def tubes(n: int) -> fmb.Model:
    """Return rods on balls that slide, each in the end of the one before."""
    return chain(n, fmb.InLine)


@pytest.mark.parametrize("model", [branched, flexible_chain, chain, tubes])
def test_round_trip_over_trees(model, rng):
    tree, state, back = assert_round_trip(branched() if model is branched else model(3), rng)
    np.testing.assert_allclose(back.q[-1], state.q[-1], atol=ROUND)  # a branch, where there is one
    again = tree.relative(back)
    first = tree.relative(state)
    np.testing.assert_allclose(again.v, first.v, atol=ROUND * np.abs(first.v).max())
    np.testing.assert_allclose(again.a, first.a, atol=ROUND * np.abs(first.a).max())


def test_round_trip_over_loops(rng):
    """The joints of the tree place the bodies as the state does; redundant equations leave velocities open by 1e-9."""
    assert_round_trip(loops(), rng, tolerance=SOLVER)


def test_relative_rates_are_derivatives(rng):
    """Rates and second rates against differences of coordinates along a motion of constant second rates."""
    tree = fmb.JointTree(branched())
    start = tree.start
    scalar = [n for n in tree.names if "ball" not in n and "frame" not in n]
    places = [(tree.names.index(n), tree.rate_names.index(n)) for n in scalar]
    v, a = np.zeros(len(tree.rate_names)), np.zeros(len(tree.rate_names))
    for i, j in places:
        v[j], a[j] = rng.normal(size=2) * (1e-3 if "mode" in tree.names[i] else 1.0)

    def moved(h):
        q = start.q.copy()
        for i, j in places:
            q[i] += h * v[j] + 0.5 * h * h * a[j]
        return tree.absolute(q, v + h * a, a)

    h, here = 1e-3, moved(0.0)
    rates = [moved(k * h).u for k in (-2, -1, 1, 2)]
    slope = (rates[0] - 8 * rates[1] + 8 * rates[2] - rates[3]) / (12 * h)
    np.testing.assert_allclose(slope, here.a, atol=1e-8 * np.abs(here.a).max())
    at = {name: [frames(tree.model, moved(k * h).q)[name] for k in (-2, -1, 1, 2)] for name in ("wing", "tail", "ball")}
    for name, T in at.items():
        _, iu = tree.system.body_slices[name]
        speed = ((T[0] - 8 * T[1] + 8 * T[2] - T[3]) / (12 * h))[:3, 3]
        R = frames(tree.model, here.q)[name][:3, :3]
        np.testing.assert_allclose(R.T @ speed, here.u[iu][:3], atol=1e-8)


def test_chain_of_hinges_is_a_product_of_matrices(rng):
    """Each hinge contributes the pose of its marker a, a turn about z and the inverse of that of its marker b."""

    def pose():
        return fmb.Pose(rng.normal(size=3), rng.normal(size=3))

    bodies = [fmb.Ground(markers={"out": pose()})]
    joints, inn = [], []
    for k in range(4):
        inn.append(pose())
        bodies.append(fmb.RigidBody(f"b{k}", mass=1.0, inertia=(1, 1, 1), markers={"in": inn[-1], "out": pose()}))
        joints.append(fmb.Revolute(f"j{k}", markers=(f"{bodies[k].name}.out", f"b{k}.in")))
    tree = fmb.JointTree(put_together(fmb.Model(bodies=bodies, joints=joints)))
    angles = rng.uniform(-3, 3, 4)
    found = frames(tree.model, tree.absolute(angles).q)

    def matrix(pose):
        T = np.eye(4)
        T[:3, :3], T[:3, 3] = pose.matrix, pose.at
        return T

    T = np.eye(4)
    for k, angle in enumerate(angles):
        turn = np.eye(4)
        turn[:3, :3] = Rotation.from_rotvec([0, 0, angle]).as_matrix()
        seat = np.eye(4)  # the drawing decides which of the two ways the z-axes point along each other
        seat[:3, :3] = np.round(tree.rows[k]["C"])
        T = T @ matrix(bodies[k].markers["out"]) @ turn @ seat @ np.linalg.inv(matrix(inn[k]))
        np.testing.assert_allclose(found[f"b{k}"], T, atol=1e-11)


def test_spherical_and_universal_joints_against_products_of_rotations(rng):
    body = fmb.RigidBody("b", mass=1.0, inertia=(1, 1, 1), markers={"m": (0.2, 0.1, 0.3), "x": ACROSS})

    def on(joint):
        return fmb.JointTree(put_together(fmb.Model(bodies=[fmb.Ground(), body], joints=[joint])))

    ball = on(fmb.Spherical("s", markers=("ground.origin", "b.m")))
    turn = Rotation.from_rotvec(rng.normal(size=3))
    T = frames(ball.model, ball.absolute(turn.as_quat(scalar_first=True)).q)["b"]
    np.testing.assert_allclose(T[:3, :3], turn.as_matrix(), atol=MACHINE)
    np.testing.assert_allclose(T[:3, 3], -turn.as_matrix() @ (0.2, 0.1, 0.3), atol=MACHINE)
    cross = on(fmb.Universal("u", markers=("ground.origin", "b.x")))
    assert cross.names == ("u.turn", "u.turn_b")
    angles = np.array([0.7, -0.4])
    T = frames(cross.model, cross.absolute(angles).q)["b"][:3, :3]
    R_b = T @ ACROSS.matrix
    # z of b points at the first angle in the x-y plane of a; seen from b, z of a has turned back by the second
    np.testing.assert_allclose(R_b[:, 2], (np.cos(0.7), np.sin(0.7), 0.0), atol=MACHINE)
    np.testing.assert_allclose(R_b.T @ (0, 0, 1), (np.cos(0.4), np.sin(0.4), 0.0), atol=MACHINE)


def test_coordinates_are_those_of_sensors_through_full_turns():
    """A driven hinge that turns seven times: JointCoordinate and the relative coordinate count alike."""
    model = chain(1, sensors=[fmb.JointCoordinate("angle", joint="j0")])
    driven = model.with_parts(joints=[fmb.Drive("motor", joint="j0", angle=fmb.ramp(rate=44.0))])
    solution = fmb.kinematics(driven, 1.0, samples=101)
    tree = fmb.JointTree(driven)
    assert list(tree.drives) == ["j0.turn"]
    seen = tree.relative(solution.final)
    np.testing.assert_allclose(seen.q[0], solution["angle"][-1], atol=1e-9)
    np.testing.assert_allclose((seen.q[0], seen.v[0]), (44.0, 44.0), atol=1e-9)
    ends = (frames(driven, q)["b0"] for q in (tree.absolute(seen).q, solution.final.q))
    np.testing.assert_allclose(*ends, atol=1e-9)


def test_joints_without_simple_motion_are_cut():
    tree = fmb.JointTree(loops())
    assert {"link", "gear"} <= set(tree.tree.cut)


def test_a_rod_that_shall_carry_a_body_is_refused():
    with pytest.raises(fmb.CompileError, match=r"Joint 'link': Rod permits no turns or slides"):
        fmb.JointTree(loops(), keep=("link",))


def test_joints_to_keep_that_close_a_loop_are_refused():
    with pytest.raises(fmb.CompileError, match=r"Joint '(A|A2)': it closes a loop"):
        fmb.JointTree(loops(), keep=("A", "A2"))
    assert "C" not in fmb.JointTree(loops(), keep=("C", "D", "A")).tree.cut


def test_a_joint_to_keep_that_does_not_exist_is_refused():
    with pytest.raises(fmb.CompileError, match=r"joint 'CC' to keep does not exist.*Did you mean 'C'"):
        fmb.JointTree(loops(), keep=("CC",))


def test_a_vector_of_another_length_is_refused():
    with pytest.raises(fmb.ModelError, match=r"v has the shape \(3,\)\..*\(2,\): j0.turn, j1.turn"):
        fmb.JointTree(chain(2)).absolute([0.0, 0.0], [0.0, 0.0, 0.0])


def test_an_unknown_coordinate_is_named():
    with pytest.raises(fmb.ModelError, match=r"no coordinate 'j1.trun'.*Did you mean 'j1.turn'"):
        fmb.JointTree(chain(2)).index("j1.trun")


def test_a_coordinate_that_is_no_number_is_named():
    with pytest.raises(fmb.ModelError, match=r"q has nan for 'j1.turn'\. Expected: finite numbers"):
        fmb.JointTree(chain(2)).pose("b1.end", [0.0, np.nan])


def test_a_state_of_another_model_is_refused():
    other = fmb.simulate(chain(3), 0.01, samples=2).final
    with pytest.raises(fmb.ModelError, match=r"JointTree: a state with 21 coordinates.*as in model 'model'"):
        fmb.JointTree(chain(2)).relative(other)
