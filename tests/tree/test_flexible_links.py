"""Reduced bodies as links of the compiled recursion: every joint, force and loop beside the sparse solution of all
equations.

The sparse solution shares only the kernels of the bodies in absolute coordinates, which links do not use.
"""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from by_turns import every_second
from contracts.random_models import FORCES, PAIRS, beam, connected, put_together
from tree.models import branched, flexible_chain, loops, random_consistent
from tree.test_agreement import AGREED, KINDS
from tree.test_links import linked

import flexmb as fmb
from flexmb import fem, reduction
from flexmb.math.energies import powers
from flexmb.system import assemble
from flexmb.system.program import evaluate
from flexmb.tree.coordinates.linked import timeless_chart
from flexmb.tree.coordinates.no_inertia import without_inertia
from flexmb.tree.coordinates.settle import unit_length
from flexmb.tree.rigid.motion import close_links, link_rates, loops_are_open
from flexmb.tree.rigid.places import BEND

FLEXIBLE = [pair for pair in PAIRS if "floating" in pair and set(pair.split("-")) <= {"ground", "rigid", "floating"}]


def assert_same_rates(model, rng, **options):
    """Compare second rates, joints and modes each with their largest, and powers, with those of the sparse solution."""
    system, state = random_consistent(model, rng, **options)
    unknowns, work = linked(system, state)
    assert len(unknowns.links.flexible.bodies)
    other = system.workspace()
    state.a[:], state.lam[:] = fmb.Augmented().accelerate(system, state, other)
    x, v, a = unknowns.of(state)
    assert link_rates(unknowns.links, work, state.t, x, v) == -1
    modal = np.array([".mode_" in name for name in unknowns.tree.rate_names])
    for some in (modal, ~modal):
        largest = np.abs(a[some]).max(initial=1.0)
        np.testing.assert_allclose(unknowns.links.a[some] / largest, a[some] / largest, atol=AGREED)
    other.weights[0].wanted = 0
    evaluate(system.program, state, other)
    found = unknowns.links.powers
    np.testing.assert_allclose(found, powers(other.energy), atol=AGREED * max(1.0, np.abs(found).max()))
    return unknowns


@pytest.mark.parametrize(("kind", "pair"), every_second(KINDS, FLEXIBLE))
def test_on_every_joint(kind, pair, rng):
    assert_same_rates(connected(kind, pair, rng), rng)


@pytest.mark.parametrize(("kind", "pair"), every_second(FORCES, FLEXIBLE))
def test_on_every_force(kind, pair, rng):
    model = connected(kind, pair, rng)
    system, state = assemble(model)
    if any(force.reads_reactions for force in model.forces):
        assert fmb.Recursive().unknowns(system, state, system.workspace()).links is None
        return
    assert_same_rates(model, rng)


@pytest.mark.parametrize("groups", [False, True, "inertia", "interface"])
def test_chains_with_each_group_of_stiffness(groups, rng):
    own = (groups,) if isinstance(groups, str) else groups
    for n in (1, 4):
        assert_same_rates(flexible_chain(n, geometric_stiffness=own), rng)


@cache
def straight_beam(modes: int) -> fmb.ModalNeutralData:
    """Return a beam with `modes` shapes, six of them of its interfaces; with fewer, one interface that has none."""
    points = np.column_stack([np.linspace(0.0, 1.0, 6), np.zeros(6), np.zeros(6)])
    fe = fem.frame(points=points, section=fem.Section.rectangle(0.02, 0.01), material=fmb.MATERIALS["steel"])
    ends = {"root": [0], "tip": [5]} if modes >= 6 else {"root": [0]}
    stations = {} if modes >= 6 else {"tip": (1.0, 0.0, 0.0)}
    inner = modes - 6 if modes >= 6 else modes
    return reduction.reduce(fe, interfaces=ends, modes=inner, stations=stations, geometric_stiffness=True)


@pytest.mark.parametrize("modes", [(1,), (2, 1), (6,), (8,), (16,), (17,), (17, 1, 8), (6, 16, 9, 7)])
def test_any_number_of_modes(modes, rng):
    """Rows over the modes are filled up to eights: numbers at and beside whole eights, and different ones in a tree."""
    bodies = [fmb.FloatingBody(f"f{k}", data=straight_beam(m), at=(k, 0, 0), damping=0.01) for k, m in enumerate(modes)]
    ends = ["ground.origin", *(f"f{k}.tip" for k in range(len(modes)))]
    kinds = (fmb.Revolute, fmb.Spherical, fmb.Prismatic)
    joints = [kinds[k % 3](f"j{k}", markers=(ends[k], f"f{k}.root")) for k in range(len(modes))]
    load = fmb.PointLoad("pull", marker=ends[-1], force=(8.0, 2.0, 3.0))
    assert_same_rates(
        fmb.Model(gravity=(1, -9.81, 2), bodies=[fmb.Ground(), *bodies], joints=joints, forces=[load]), rng
    )


def test_branches_of_rigid_and_flexible_bodies(rng):
    """The hub carries a wing, a fin and rigid branches; a ball hangs on the wing."""
    model = branched()
    bodies = [body for body in model.bodies if not isinstance(body, fmb.PointMass)]
    model = replace(model, bodies=bodies, forces=[force for force in model.forces if force.name == "p"])
    unknowns = assert_same_rates(model, rng)
    flexible, links = unknowns.links.flexible, unknowns.links.links
    order = unknowns.tree.tree.order
    rigid = [k for k, n in enumerate(flexible.wide_of) if n < 0 and links[k]["kind"] != -3]
    assert {"tail", "rod", "ball", "free"} <= {order[links[k]["body"]] for k in rigid}  # they take the rigid passes


def random_tree(rng, n: int = 9) -> fmb.Model:
    """Return a tree of rigid and reduced bodies on joints of many freedoms, drawn in both directions; one floats."""

    def pose():
        return fmb.Pose(0.4 * rng.normal(size=3), 0.2 * rng.normal(size=3))

    kinds = (fmb.Revolute, fmb.Spherical, fmb.Cylindrical, fmb.Universal, fmb.Planar, fmb.Fixed, fmb.Prismatic)
    bodies, joints, ends = [fmb.Ground(markers={"m0": pose()})], [], ["ground.m0"]
    for k in range(n):
        at = {"at": 0.2 * rng.normal(size=3), "rotation": 0.1 * rng.normal(size=3)}
        if rng.uniform() < 0.6:
            axes = {name: fmb.Pose(tuple(r), 0.2 * rng.normal(size=3)) for name, r in places().items()}
            bodies.append(fmb.FloatingBody(f"b{k}", data=beam(), damping=0.01, markers=axes, **at))
            own, *further = (f"b{k}.{name}" for name in rng.permutation(("root", "tip", "mid")))
        else:
            inertia = rng.uniform(0.1, 0.15, 3)
            given = {name: pose() for name in ("m0", "m1", "m2")}
            bodies.append(fmb.RigidBody(f"b{k}", mass=1.0 + rng.uniform(), inertia=inertia, markers=given, **at))
            own, *further = (f"b{k}.{name}" for name in given)
        if k != 4:
            pair = (ends[int(rng.integers(len(ends)))], own)
            kind = kinds[int(rng.integers(len(kinds)))]
            joints.append(kind(f"j{k}", markers=pair if rng.uniform() < 0.5 else pair[::-1]))
        ends += further
    forces = [
        fmb.SpringDamper("s", markers=(ends[1], ends[-1]), stiffness=50.0, damping=2.0),
        fmb.PointLoad("p", marker=ends[-2], force=(1.0, fmb.expression("sin(t)"), 2.0), axes=ends[-2]),
    ]
    return put_together(fmb.Model(bodies=bodies, joints=joints, forces=forces, gravity=(1.0, 2.0, -9.81)))


def places() -> dict[str, np.ndarray]:
    """Return the markers of the beam."""
    return dict(zip(beam().marker_names, beam().marker_positions, strict=True))


@pytest.mark.parametrize("seed", range(6))
def test_random_trees(seed):
    rng = np.random.default_rng(seed)
    assert_same_rates(random_tree(rng), rng, spread=0.02)


@pytest.mark.parametrize(
    ("options", "free"),
    [
        ({"modes": 12}, False),
        ({"modes": 4, "frame": "root"}, False),
        ({"modes": 4}, True),
        ({"modes": 6, "basis": "Rubin"}, False),
        ({"basis": "Krylov frequencies=0,200"}, False),
    ],
    ids=["one mode", "clamped frame", "free chain", "Rubin", "Krylov"],
)
def test_chains_of_other_bases_and_of_one_mode(options, free):
    """Whatever the shapes are, links take them as they come."""
    points = np.column_stack([np.linspace(0.0, 1.0, 21), np.zeros(21), np.zeros(21)])
    fe = fem.frame(points=points, section=fem.Section.rectangle(0.02, 0.03), material=fmb.MATERIALS["aluminium"])
    ends = {"root": [0], "tip": [20]}
    data = reduction.reduce(fe, ends, **options, geometric_stiffness=True, compare=0, stress=False)
    if options.get("modes") == 12:
        data = data.selected([0])
    bodies = [fmb.FloatingBody(f"b{k}", data=data, at=(k, 0, 0)) for k in range(3)]
    hinges = [("ground.origin", "b0.root"), ("b0.tip", "b1.root"), ("b1.tip", "b2.root")][1 if free else 0 :]
    joints = [fmb.Revolute(f"j{k}", markers=pair) for k, pair in enumerate(hinges)]
    model = fmb.Model(gravity=(0, -9.81, 1.0), bodies=[fmb.Ground(), *bodies], joints=joints)
    assert_same_rates(model, np.random.default_rng(3), spread=0.005)


@cache
def panel() -> fmb.ModalNeutralData:
    """Return a prestressed strip with a load shape that turns with it."""
    points = np.column_stack([np.linspace(0.0, 1.0, 11), np.zeros(11), np.zeros(11)])
    fe = fem.frame(points=points, section=fem.Section.rectangle(0.05, 0.005), material=fmb.MATERIALS["steel"])
    return reduction.reduce(
        fe,
        interfaces={"root": [0], "tip": [10]},
        modes=3,
        loads={"air": dict.fromkeys(range(11), (0, 0, 0.1))},
        geometric_stiffness=True,
    )


def test_load_shapes_with_their_stiffness(rng):
    bodies = [fmb.Ground(), *(fmb.FloatingBody(f"f{k}", data=panel(), at=(k, 0, 0)) for k in range(2))]
    joints = [
        fmb.Revolute("a", markers=("ground.origin", "f0.root")),
        fmb.Spherical("b", markers=("f0.tip", "f1.root")),
    ]
    forces = [fmb.Pressure(f"w{k}", load=f"f{k}.air", amount=fmb.expression("30 + 5*t")) for k in range(2)]
    assert_same_rates(fmb.Model(bodies=bodies, joints=joints, forces=forces), rng)


def test_a_distant_centre_attracts_every_element(rng):
    body = fmb.FloatingBody("f", data=beam(), at=(7e6, 0, 0), velocity=(0, 7500.0, 0), geometric_stiffness=False)
    model = fmb.Model(bodies=[fmb.Ground(), body], forces=[fmb.CentralGravity("g", body="f")])
    assert_same_rates(model, rng)


@pytest.mark.parametrize("stiffness", [True, False])
def test_loops_close_by_multipliers_and_by_motion(stiffness, rng):
    model = loops()
    bodies = [replace(b, geometric_stiffness=stiffness) if b.name == "coupler" else b for b in model.bodies]
    model = replace(model, bodies=bodies)
    unknowns = assert_same_rates(model, rng, spread=0.02)
    system, links, work = unknowns.system, unknowns.links, unknowns.work
    x, v, _ = unknowns.of(random_consistent(model, rng, spread=0.02)[1])
    tight = np.full(system.ng, 1e-13)
    links.x[:], links.v[:] = x + 1e-6 * rng.normal(size=len(x)), v + 1e-6 * rng.normal(size=len(v))
    unit_length(unknowns.chart.rows, links.x)
    assert close_links(links, work, 0.0, tight, system.gaps, system.program.equation_level)
    assert link_rates(links, work, 0.0, links.x.copy(), links.v.copy()) == -1
    assert not loops_are_open(links, work, 100.0 * tight, np.ones(system.ng))
    assert np.abs(links.x - x).max() < 1e-3


def test_forward_and_inverse_dynamics_are_inverse(rng):
    tree = fmb.JointTree(random_tree(rng))
    modal = np.array([".mode_" in name for name in tree.rate_names])
    q, v = tree.start.q, rng.normal(size=len(tree.rate_names)) * np.where(modal, 1e-3, 1.0)
    tau = rng.normal(size=len(v))
    np.testing.assert_allclose(tree.torques(q, v, tree.accelerations(q, v, tau)), tau, atol=1e-7)


def bent_beams(modes: int, n: int, closed: bool = False) -> fmb.Model:
    """Return beams of 1 m in a row; where they are `closed`, a rod holds the last tip."""
    bodies = [fmb.FloatingBody(f"f{k}", data=straight_beam(modes), at=(k, 0, 0), damping=0.01) for k in range(n)]
    ends = ["ground.origin", *(f"f{k}.tip" for k in range(n))]
    kinds = (fmb.Revolute, fmb.Spherical, fmb.Prismatic)
    joints: list = [kinds[k % 3](f"j{k}", markers=(ends[k], f"f{k}.root")) for k in range(n)]
    if closed:
        joints.append(fmb.Rod("L", markers=("ground.E", ends[-1])))
    ground = fmb.Ground(markers={"E": (n - 0.1, 0.1, 0)})
    return fmb.Model(gravity=(1, -9.81, 2), bodies=[ground, *bodies], joints=joints)


@pytest.mark.parametrize("seed", [0, 1, 2])
@pytest.mark.parametrize(("modes", "n", "closed"), [(8, 1, False), (20, 1, False), (8, 2, True), (8, 3, True)])
def test_bodies_bent_beyond_their_inertia(modes, n, closed, seed):
    """What accelerations do to bodies bent by 5 % of their length takes more than the inertia of some modes: neither
    modal blocks nor articulated inertias nor mobilities of loops are positive, and the first need exchanges of rows.
    """
    rng = np.random.default_rng(seed)
    unknowns = assert_same_rates(bent_beams(modes, n, closed), rng, strain=0.05, spread=0.02)
    assert np.any(unknowns.links.flexible.pivots[:, 0] >= 0)


def test_a_run_that_begins_with_a_bent_body_takes_its_links():
    system, state = random_consistent(bent_beams(8, 1), np.random.default_rng(1), strain=0.05, spread=0.02)
    state.a[:], state.lam[:] = fmb.Augmented().accelerate(system, state, system.workspace())
    unknowns = fmb.Recursive().unknowns(system, state, system.workspace())
    assert unknowns.recursion == "links"
    tree = fmb.JointTree.of(system, state)
    here = tree.start
    expected = tree.relative(state).a
    np.testing.assert_allclose(tree.accelerations(here), expected, atol=AGREED * np.abs(expected).max())


@pytest.mark.parametrize("groups", [True, ("interface",)], ids=str)
def test_accelerations_of_far_bent_small_bodies_need_their_forces(groups):
    """Beams of 1 mm at random modal coordinates; the inverse dynamics, which solves nothing, is the reference."""
    points = np.column_stack([np.linspace(0.0, 1e-3, 41), np.zeros(41), np.zeros(41)])
    section = fem.Section.rectangle(2e-5, 3e-5)
    fe = fem.frame(points=points, section=section, material=fmb.MATERIALS["aluminium"])
    data = reduction.reduce(fe, interfaces={"root": [0], "tip": [40]}, modes=20, geometric_stiffness=True)
    beams = [fmb.FloatingBody(f"b{k}", data=data, at=(1e-3 * k, 0, 0), geometric_stiffness=groups) for k in range(2)]
    ends = ["ground.origin", "b0.tip"]
    joints = [fmb.Revolute(f"j{k}", markers=(ends[k], f"b{k}.root")) for k in range(2)]
    tree = fmb.JointTree(fmb.Model(gravity=(0, -9.81, 0), bodies=[fmb.Ground(), *beams], joints=joints))
    bent = np.random.default_rng(0).standard_normal(len(tree.start.q))
    for size in (1e-12, 1e-9):
        q = tree.start.q + size * bent
        free = tree.accelerations(q)
        M = np.array([tree.mass_product(q, unit) for unit in np.eye(len(free))]).T
        terms = np.abs(M) @ np.abs(free) + np.abs(tree.bias(q))
        np.testing.assert_array_less(np.abs(tree.torques(q, None, free)), 1e-11 * terms.max())
    nothing = np.full(len(tree.start.q), np.nan)
    with pytest.raises(fmb.FlexmbError, match=r"finite|no value"):
        tree.accelerations(nothing)


def test_modes_without_inertia_are_told_by_what_took_it():
    tree = fmb.JointTree(bent_beams(8, 1))
    tree.accelerations(tree.start.q)
    links = tree.linked(timeless_chart(tree, tree.absolute(tree.start)))
    links.run[0].failed = int(np.flatnonzero(links.links["kind"] == BEND)[0])
    error = without_inertia(tree.tree, links, tree.model)
    assert "Body 'f0' (joint 'j0'): with these modal coordinates it is bent so far" in str(error)
    assert "Give smaller modal coordinates" in str(error)


@pytest.mark.parametrize("stiffness", [True, False])
def test_products_with_the_mass_matrix(stiffness, rng):
    """Beside the matrix of the equations of all bodies in joint coordinates; bent bodies are stiffened as well."""
    model = flexible_chain(3, geometric_stiffness=stiffness)
    tree = fmb.JointTree(model)
    n = len(tree.rate_names)
    q = tree.start.q + 1e-3 * rng.normal(size=len(tree.names))
    unit_length(tree.rows, q)
    a, tau = rng.normal(size=(2, n))
    product = tree.mass_product(q, a)
    largest = np.abs(product).max()
    np.testing.assert_allclose(tree.mass_product(q, tree.mass_solution(q, tau)), tau, atol=1e-9)
    np.testing.assert_allclose(tree.bias(q, a), tree.torques(q, a), atol=0.0)
    np.testing.assert_allclose(
        tree.torques(q, a, tau) - tree.bias(q, a), tree.mass_product(q, tau), atol=1e-6 * largest
    )
    if not stiffness:
        arrays = fmb.equations(model, tree.absolute(q)).in_joint_coordinates()
        np.testing.assert_allclose(product, arrays.M @ a, atol=1e-12 * largest)
