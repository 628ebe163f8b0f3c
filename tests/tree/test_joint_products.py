"""`M a`, `M^-1 f`, bias and torques of trees: beside Pinocchio, the equations of all bodies, and what they refuse."""

from dataclasses import replace

import numpy as np
import pytest
from contracts.random_models import put_together
from tree.models import chain, flexible_chain, loops
from tree.pinocchio_trees import Twin
from tree.test_flexible_links import panel, random_tree

import flexmb as fmb
from flexmb.system.program import energies
from flexmb.tree.coordinates.products import _of_bodies
from flexmb.tree.coordinates.reach import advanced
from flexmb.tree.coordinates.settle import unit_length


def assert_close(found, expected, scale, atol: float) -> None:
    """Compare two vectors, number by number divided by a scale that makes them alike."""
    found, expected = found / scale, expected / scale
    np.testing.assert_allclose(found, expected, atol=atol * np.abs(expected).max(), rtol=0.0)


@pytest.mark.peer
@pytest.mark.parametrize("seed", range(12))
def test_random_rigid_trees_in_pinocchio(seed):
    """crba (by rnea of unit motions), rnea with and without weight, bias, weight, aba, inverse; lengths 1e-6 to 1e6."""
    pin = pytest.importorskip("pinocchio")
    rng = np.random.default_rng(seed)
    length, mass = 10.0 ** rng.uniform(-6, 6, 2) if seed % 2 else (1.0, 1.0)
    twin = Twin(pin, rng, int(rng.integers(1, 25)), length, mass)
    model, data, tree = twin.theirs, twin.data, twin.tree
    falling = model.copy()
    falling.gravity.linear = np.zeros(3)
    weightless = fmb.JointTree(replace(twin.model, gravity=(0, 0, 0)))
    for _ in range(2):
        q, v, a, _ = twin.state(rng, length)
        x, u, s = twin.coordinates(q), twin.rates(v), twin.rates(a)
        still, own = np.zeros(model.nv), falling.createData()
        M = np.array([pin.rnea(falling, own, q, still, e) for e in np.eye(model.nv)]).T
        size = twin.rates(twin.sv * np.sqrt(np.diag(M)))  # per rate: units of coordinates cancel
        tau = twin.rates(pin.rnea(model, data, q, v, a))
        assert_close(tree.mass_product(x, u), twin.rates(M @ v), size, 1e-12)
        assert_close(tree.torques(x, u, s), tau, size, 1e-12)
        assert_close(weightless.torques(x, u, s), twin.rates(pin.rnea(falling, own, q, v, a)), size, 1e-12)
        assert_close(tree.bias(x, u), twin.rates(pin.nonLinearEffects(model, data, q, v)), size, 1e-12)
        weight = twin.rates(pin.computeGeneralizedGravity(model, data, q))
        assert_close(tree.bias(x, 0.0 * u), weight, size, 1e-12)
        assert_close(tree.mass_solution(x, tree.mass_product(x, u)), u, 1.0 / size, 1e-11)
        # rounding of the accelerations of free fall, which cancel
        free = tree.accelerations(x, u)
        assert_close(free, twin.rates(pin.aba(model, data, q, v, still)), 1.0 / size, 1e-10)


def random_motion(tree, rng, deflection: float = 1e-3):
    modal = np.array([".mode_" in name for name in tree.rate_names])
    size = np.where(modal, deflection, 1.0)
    bent = np.array([deflection * (".mode_" in name) for name in tree.names])
    q = tree.start.q + np.where(bent > 0, bent, 0.3) * rng.normal(size=len(tree.names))
    unit_length(tree.rows, q)
    return q, size * rng.normal(size=len(modal)), size * rng.normal(size=len(modal))


@pytest.mark.parametrize("seed", range(8))
def test_links_and_bodies_need_the_same_forces(seed):
    """Random trees of rigid and bent bodies on all joints, both directions; springs, loads, stiffness of all kinds."""
    rng = np.random.default_rng(seed)
    tree = fmb.JointTree(random_tree(rng, 12))
    assert tree.invertible_links is not None
    for _ in range(2):
        q, v, a = random_motion(tree, rng)
        expected = _of_bodies(tree, q, v, a, 0.7)
        size = np.abs(expected) + np.abs(expected).max() * 1e-3
        assert_close(tree.torques(q, v, a, 0.7), expected, size, 1e-9)
        # a product is what is linear in the second rates
        linear = _of_bodies(tree, q, 0 * v, 1e6 * a, 0.0) - _of_bodies(tree, q, 0 * v, 0 * a, 0.0)
        assert_close(tree.mass_product(q, 1e6 * a), linear, np.abs(linear).max(), 1e-9)
        tau = tree.mass_product(q, a)
        assert_close(tree.mass_solution(q, tau), a, np.abs(a) + 1e-3 * np.abs(a).max(), 1e-7)


def preloaded() -> fmb.ModalNeutralData:
    """Return the strip with a preload that stiffens it."""
    data = panel()
    return replace(data, geometric=replace(data.geometric, preload=0.3 * data.stiffness))


def strips(data, **fields) -> fmb.Model:
    """Return two strips on a hinge and a ball, with loads that turn with them."""
    bodies = [fmb.FloatingBody(f"f{k}", data=data, at=(k, 0, 0), **fields) for k in range(2)]
    joints = [
        fmb.Revolute("a", markers=("ground.origin", "f0.root")),
        fmb.Spherical("b", markers=("f0.tip", "f1.root")),
    ]
    forces = [fmb.Pressure(f"w{k}", load=f"f{k}.air", amount=fmb.expression("30 + 5*t")) for k in range(2)]
    return fmb.Model(bodies=[fmb.Ground(), *bodies], joints=joints, forces=forces, gravity=(1, 2, -9.81))


GROUPS = [True, False, ("inertia",), ("interface",), ("loads",), ("preload",)]


@pytest.mark.parametrize("groups", GROUPS, ids=str)
def test_loads_on_shapes_and_each_group_of_stiffness(groups, rng):
    for data in (panel(), preloaded()):
        tree = fmb.JointTree(strips(data, geometric_stiffness=groups))
        q, v, a = random_motion(tree, rng)
        expected = _of_bodies(tree, q, v, a, 2.0)
        assert_close(tree.torques(q, v, a, 2.0), expected, np.abs(expected) + 1e-3 * np.abs(expected).max(), 1e-9)


def test_a_preload_stiffens_the_modes(rng):
    """By its matrix times the modal coordinates, and nothing else."""
    bare, loaded = (fmb.JointTree(strips(data, geometric_stiffness=("preload",))) for data in (panel(), preloaded()))
    q, *_ = random_motion(bare, rng)
    modes = np.array([".mode_" in name for name in bare.names])
    m = panel().n_modes
    expected = [0.3 * panel().stiffness @ eta for eta in q[modes].reshape(2, m)]
    found = (loaded.bias(q) - bare.bias(q))[[".mode_" in name for name in bare.rate_names]]
    np.testing.assert_allclose(found, np.ravel(expected), atol=1e-9 * np.abs(expected).max())


@pytest.mark.parametrize("pieces", [2, 3])
def test_a_body_in_pieces(pieces, rng):
    """Welds between reduced bodies have no coordinates: torques and products beside the equations of all bodies."""
    bodies = [fmb.FloatingBody(f"f{k}", data=panel(), at=(k, 0, 0)) for k in range(pieces)]
    ends = ["ground.origin", *(f"f{k}.tip" for k in range(pieces))]
    kinds = [fmb.Revolute] + [fmb.Fixed] * pieces
    joints = [kinds[k](f"j{k}", markers=(ends[k], f"f{k}.root")) for k in range(pieces)]
    tree = fmb.JointTree(fmb.Model(bodies=[fmb.Ground(), *bodies], joints=joints, gravity=(0, 0, -9.81)))
    q, v, a = random_motion(tree, rng)
    expected = _of_bodies(tree, q, v, a, 0.0)
    assert_close(tree.torques(q, v, a), expected, np.abs(expected) + 1e-3 * np.abs(expected).max(), 1e-9)
    back = tree.mass_solution(q, tree.mass_product(q, a))
    assert_close(back, a, np.abs(a) + 1e-3 * np.abs(a).max(), 1e-7)


def test_the_product_is_symmetric_and_twice_the_kinetic_energy(rng):
    """Without geometric stiffness M is symmetric; v M v / 2 is the sum of the bodies' energies."""
    model = flexible_chain(3, geometric_stiffness=False)
    tree = fmb.JointTree(model)
    q, v, _ = random_motion(tree, rng)
    M = np.array([tree.mass_product(q, e) for e in np.eye(len(v))]).T
    np.testing.assert_allclose(M, M.T, atol=1e-13 * np.abs(M).max())
    arrays = fmb.equations(model, tree.absolute(q, v)).in_joint_coordinates()
    np.testing.assert_allclose(M, arrays.M, atol=1e-12 * np.abs(M).max())
    work = tree.system.workspace()
    energies(tree.system.program, tree.absolute(q, v), work)
    np.testing.assert_allclose(0.5 * v @ M @ v, work.energy["kinetic"][0], rtol=1e-12)


@pytest.mark.parametrize("size", [1e-300, 1e-12, 1e12, 1e200])
def test_products_of_any_size(size, rng):
    for model in (chain(3, fmb.Spherical), flexible_chain(2)):
        tree = fmb.JointTree(model)
        q, a, tau = random_motion(tree, rng)
        np.testing.assert_allclose(tree.mass_product(q, size * a) / size, tree.mass_product(q, a), rtol=1e-10)
        np.testing.assert_allclose(tree.mass_solution(q, size * tau) / size, tree.mass_solution(q, tau), rtol=1e-9)


def test_driven_joints_move_as_they_are_told(rng):
    """A drive supplies the force of its joint; second rates are as they are given, not as its signal says."""
    drive = fmb.Drive("motor", joint="j1", angle=fmb.expression("0.3*t**2"))
    free, driven = (fmb.JointTree(chain(3).with_parts(joints=parts)) for parts in ((), (drive,)))
    q, v, a = rng.normal(size=(3, 3))
    np.testing.assert_allclose(driven.torques(q, v, a, 1.0), free.torques(q, v, a, 1.0), rtol=1e-13)
    np.testing.assert_allclose(driven.mass_product(q, a), free.mass_product(q, a), rtol=1e-13)
    with pytest.raises(fmb.CompileError, match=r"prescribed motions: j1.turn"):
        driven.mass_solution(q, a)


def test_the_rates_of_a_point_are_its_velocities(rng):
    """A mass on a spring: forces on its rates are those on it."""
    bob = fmb.PointMass("bob", mass=2.0, at=(0, 1.0, 0))
    tie = fmb.SpringDamper("tie", markers=("b0.end", "bob.center"), stiffness=30.0, length=0.5)
    tree = fmb.JointTree(chain(1).with_parts(bodies=[bob], forces=[tie]))
    assert tree.invertible_links is not None
    names, a = tree.rate_names, rng.normal(size=4)
    hinge = names.index("j0.turn")
    product = tree.mass_product(tree.start.q, a)
    J = 1.0 / 3.0 + 0.05**2 / 4.0
    expected = 2.0 * a
    expected[hinge] = J * a[hinge]
    np.testing.assert_allclose(product, expected, rtol=1e-12)
    np.testing.assert_allclose(tree.mass_solution(tree.start.q, expected), a, rtol=1e-12)


def test_forces_that_depend_on_reactions_are_refused():
    """Their reactions are not known to a pass that finds torques: friction would be left out without a word."""
    rub = fmb.JointFriction("rub", joint="j0", moving=0.1, radius=0.1)
    tree = fmb.JointTree(chain(2).with_parts(forces=[rub]))
    message = r"'rub'.*: a force that depends on reactions\. .*fmb.inverse_dynamics"
    for call in (tree.torques, tree.bias):
        with pytest.raises(fmb.CompileError, match=message):
            call(tree.start.q, [1.0, 2.0])
    plain = fmb.JointTree(chain(2))
    np.testing.assert_allclose(tree.mass_product([0.3, 0.4], [1, 2]), plain.mass_product([0.3, 0.4], [1, 2]), rtol=1e-9)


def followed() -> fmb.Model:
    """Return a slider with a force that follows its acceleration, as a mass of 3 kg more would need it."""
    body = fmb.RigidBody("cart", mass=1.0, inertia=(1, 1, 1))
    rail = fmb.Prismatic("rail", markers=("ground.origin", "cart.center"))
    seen = fmb.Acceleration("seen", marker="cart.center")
    push = fmb.Actuator("push", joint="rail", effort=-3.0 * fmb.measured("seen", 2))
    return fmb.Model(bodies=[fmb.Ground(), body], joints=[rail], forces=[push], sensors=[seen])


def test_forces_that_follow_accelerations_count_as_mass_or_are_refused():
    tree = fmb.JointTree(followed())
    np.testing.assert_allclose(tree.torques([0.0], [0.0], [2.0]), [8.0], rtol=1e-12)
    np.testing.assert_allclose(tree.mass_product([0.0], [2.0]), [8.0], rtol=1e-12)
    for call in (tree.accelerations, tree.mass_solution):
        with pytest.raises(fmb.CompileError, match=r"forces follow accelerations\. .*fmb.accelerations"):
            call([0.0], [0.0])


def test_closed_loops(rng):
    """No product without a tree; solutions move as the loops allow: the energy of what a force does."""
    tree = fmb.JointTree(loops())
    with pytest.raises(fmb.CompileError, match=r"no tree: loops are closed by .*link"):
        tree.mass_product(tree.start.q, np.zeros(len(tree.rate_names)))
    q, n = tree.start.q, len(tree.rate_names)
    inverse = np.array([tree.mass_solution(q, e) for e in np.eye(n)]).T
    tau = rng.normal(size=n)
    difference = tree.accelerations(q, None, 1e9 * tau) - tree.accelerations(q)
    np.testing.assert_allclose(inverse @ tau, difference / 1e9, atol=1e-6 * np.abs(inverse @ tau).max())
    np.testing.assert_allclose(inverse, inverse.T, atol=1e-9 * np.abs(inverse).max())


def four_bar() -> fmb.Model:
    """Return a parallelogram in motion, with a spring that counts the turns of the joint that is cut."""
    up, spin = (0, 0, np.pi / 2), (0, 0, 6.0)
    fields = {"mass": 1.0, "radius": 0.02}
    bodies = [
        fmb.Ground(markers={"A": (0, 0, 0), "D": (1, 0, 0)}),
        fmb.RigidBody.rod("crank", length=0.5, rotation=up, angular_velocity=spin, **fields),
        fmb.RigidBody.rod("coupler", length=1.0, at=(0, 0.5, 0), velocity=(-3.0, 0, 0), **fields),
        fmb.RigidBody.rod("rocker", length=0.5, at=(1, 0, 0), rotation=up, angular_velocity=spin, **fields),
    ]
    pairs = {
        "A": ("ground.A", "crank.start"),
        "B": ("crank.end", "coupler.start"),
        "C": ("coupler.end", "rocker.end"),
        "D": ("ground.D", "rocker.start"),
    }
    joints = [fmb.Revolute(name, markers=pair) for name, pair in pairs.items()]
    return fmb.Model(bodies=bodies, joints=joints, forces=[fmb.TorsionSpring("s", joint="C", stiffness=1.0)])


def test_the_time_does_not_turn_joints():
    """Nothing in the model depends on time: a turn that no coordinate counts is the one next to the start."""
    tree = fmb.JointTree(four_bar(), cut=("C",))
    here = tree.start
    now, later = (tree.accelerations(here.q, here.v, t=t) for t in (0.0, 2.3))
    np.testing.assert_allclose(later, now, rtol=1e-12)


def test_states_in_joint_coordinates_give_their_rates(rng):
    """A RelativeState brings its rates and time along; bias leaves out its second rates."""
    tree = fmb.JointTree(chain(3, forces=[fmb.PointLoad("p", marker="b2.end", force=(fmb.expression("t"), 0, 0))]))
    q, v, a = rng.normal(size=(3, 3))
    state = tree.relative(tree.absolute(q, v, a, 1.5))
    np.testing.assert_allclose(tree.bias(state), tree.torques(q, v, None, 1.5), rtol=1e-10)
    np.testing.assert_allclose(tree.torques(state), tree.torques(q, v, a, 1.5), rtol=1e-10)
    np.testing.assert_allclose(tree.accelerations(state), tree.accelerations(q, v, None, 1.5), rtol=1e-10)
    np.testing.assert_allclose(tree.mass_product(state, a), tree.mass_product(q, a), rtol=1e-10)


def test_axes_and_times_that_are_none_are_named():
    tree = fmb.JointTree(chain(2, fmb.Spherical))
    nothing, rest = np.zeros(8), np.zeros(6)
    for call in (tree.torques, tree.accelerations, tree.mass_product, tree.mass_solution, tree.absolute):
        with pytest.raises(fmb.ModelError, match=r"Euler parameters from 'j0.ball_0' on are all zero"):
            call(nothing, rest)
    for t in (np.nan, np.inf, "now", None):
        for call in (tree.torques, tree.accelerations, tree.absolute):
            with pytest.raises(fmb.ModelError, match=r"t = .*\. Expected: a time in s"):
                call(tree.start.q, rest, None, t)
    with pytest.raises(fmb.ModelError, match=r"a or tau = \['a'.*\. Expected: real numbers"):
        tree.mass_product(tree.start.q, ["a"] * 6)
    twice = tree.mass_product(2.0 * tree.start.q, np.arange(6))  # their length does not matter
    np.testing.assert_allclose(twice, tree.mass_product(tree.start.q, np.arange(6)), rtol=1e-13)


@pytest.mark.parametrize("name", ["torques", "accelerations", "mass_product", "mass_solution", "bias"])
def test_wrong_numbers_are_named(name):
    call = getattr(fmb.JointTree(chain(2)), name)
    two = [0.1, 0.2]
    with pytest.raises(fmb.ModelError, match=r"q has the shape \(3,\)\. Expected: \(2,\): j0.turn, j1.turn"):
        call([0, 0, 0], two)
    with pytest.raises(fmb.ModelError, match=r"has the shape \(1,\)"):
        call(two, [0.0])
    with pytest.raises(fmb.ModelError, match=r"has nan for 'j1.turn'"):
        call(two, [0.0, np.nan])
    with pytest.raises(fmb.ModelError, match=r"q has inf for 'j0.turn'"):
        call([np.inf, 0.0], two)


def test_a_massless_frame_between_two_joints(rng):
    """The cross of a gimbal: inverse dynamics and, as it carries a body with inertia, forward dynamics."""
    pose = fmb.Pose((0, 0, 0), (np.pi / 2, 0, 0))
    cross = fmb.RigidBody("cross", mass=0.0, inertia=(0, 0, 0), markers={"a": (0, 0, 0), "b": pose})
    rotor = fmb.RigidBody("rotor", mass=1.0, inertia=(0.1, 0.2, 0.3), markers={"c": pose})
    joints = [
        fmb.Revolute("A", markers=("ground.origin", "cross.a")),
        fmb.Revolute("B", markers=("cross.b", "rotor.c")),
    ]
    tree = fmb.JointTree(put_together(fmb.Model(bodies=[fmb.Ground(), cross, rotor], joints=joints)))
    q, v, tau = rng.normal(size=(3, 2))
    # turns about z and about the turned y: w = (-s u, u_b, c u) or alike; the energy tells the matrix
    M = np.array([tree.mass_product(q, e) for e in np.eye(2)]).T
    c, s = np.cos(q[1]), np.sin(q[1])
    np.testing.assert_allclose(M, np.diag([0.1 * s * s + 0.3 * c * c, 0.2]), atol=1e-14)
    np.testing.assert_allclose(tree.mass_solution(q, tau), np.linalg.solve(M, tau), rtol=1e-12)
    np.testing.assert_allclose(tree.torques(q, v, tree.accelerations(q, v, tau)), tau, rtol=1e-11)


@pytest.mark.peer
@pytest.mark.parametrize("seed", range(4))
def test_markers_and_momentum_in_pinocchio(seed):
    """Jacobians and accelerations of markers, with second rates and without."""
    pin = pytest.importorskip("pinocchio")
    rng = np.random.default_rng(seed)
    twin = Twin(pin, rng, 15)
    model, tree = twin.theirs, twin.tree
    q, v, a, _ = twin.state(rng)
    x, u, s = twin.coordinates(q), twin.rates(v), twin.rates(a)
    place = pin.SE3(np.eye(3), np.array(twin.tool))
    frames = [model.addFrame(pin.Frame(f"tool_{k}", k, 0, place, pin.OP_FRAME)) for k in range(1, model.njoints)]
    data = model.createData()
    pin.forwardKinematics(model, data, q, v, a)
    pin.computeJointJacobians(model, data, q)
    pin.updateFramePlacements(model, data)
    for k, frame in enumerate(frames, 1):
        theirs = pin.getFrameClassicalAcceleration(model, data, frame, pin.LOCAL_WORLD_ALIGNED).vector
        ours = tree.marker_acceleration(f"link_{k}.tool", x, u, s)
        np.testing.assert_allclose(ours, theirs, atol=1e-11 * max(1.0, np.abs(theirs).max()))
        J = pin.getFrameJacobian(model, data, frame, pin.LOCAL_WORLD_ALIGNED)
        found = tree.jacobian(f"link_{k}.tool", x)
        np.testing.assert_allclose(found[:, twin.iv] * twin.sv, J, atol=1e-11 * np.abs(J).max())
        drift = tree.marker_acceleration(f"link_{k}.tool", x, u)
        np.testing.assert_allclose(ours, found @ s + drift, atol=1e-11 * max(1.0, np.abs(theirs).max()))


@pytest.mark.peer
def test_the_momentum_of_a_floating_base_in_pinocchio(rng):
    """The first six numbers of M v: linear, and about the origin of the base, in its axes."""
    pin = pytest.importorskip("pinocchio")
    twin = Twin(pin, rng, 9, floating=True)
    q, v, *_ = twin.state(rng)
    x, u = twin.coordinates(q), twin.rates(v)
    pin.computeCentroidalMomentum(twin.theirs, twin.data, q, v)
    h, centre = twin.data.hg, pin.centerOfMass(twin.theirs, twin.data, q)
    r, R = twin.tree.pose("link_1.in", x)
    at = [twin.tree.rate_places[f"link_1.frame_{k}"] for k in range(6)]
    found = twin.tree.mass_product(x, u)[at]
    np.testing.assert_allclose(found[:3], R.T @ h.linear, atol=1e-11 * np.abs(found).max())
    moment = h.angular + np.cross(centre - r, h.linear)
    np.testing.assert_allclose(found[3:], R.T @ moment, atol=1e-11 * np.abs(found).max())


def test_accelerations_of_markers_on_bent_bodies(rng):
    """Differences of the twist J v along a motion, fourth order."""
    tree = fmb.JointTree(flexible_chain(2))
    q, v, a = random_motion(tree, rng)
    h, total = 1e-3, np.zeros(6)

    def twist(t):
        moved = advanced(tree, q, v * t + 0.5 * a * t * t)
        return tree.jacobian("f1.tip", moved) @ (v + a * t)

    for n, weight in zip((-2, -1, 1, 2), np.array((1, -8, 8, -1)) / (12 * h), strict=True):
        total += weight * twist(n * h)
    found = tree.marker_acceleration("f1.tip", q, v, a)
    np.testing.assert_allclose(found, total, atol=1e-6 * np.abs(found).max())


def test_a_run_starts_from_joint_coordinates():
    model = chain(2)
    tree = fmb.JointTree(model)
    start = tree.absolute([0.3, -0.4], [1.0, 2.0])
    here = tree.relative(fmb.simulate(model, 1e-9, start=start, samples=2).final)
    np.testing.assert_allclose([*here.q, *here.v], [0.3, -0.4, 1.0, 2.0], atol=1e-7)
    with fmb.stepper(model, start=start) as run:
        np.testing.assert_allclose(tree.relative(run.state).q, [0.3, -0.4], atol=1e-12)
    with pytest.raises(fmb.ModelError, match=r"a start of the class ndarray\. .*JointTree.absolute"):
        fmb.simulate(model, 1.0, start=np.zeros(2))
