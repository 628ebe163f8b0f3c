"""Rigid bodies as links in axes of their own: every joint, force and loop beside the sparse solution of all
equations.
"""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from contracts.random_models import FORCES, PAIRS, connected, put_together
from scipy.spatial.transform import Rotation
from tree.models import chain, random_consistent
from tree.test_agreement import AGREED, KINDS
from verification import mechanisms

import flexmb as fmb
from flexmb.math.energies import powers
from flexmb.math.rotations import euler_to_matrix
from flexmb.system import assemble
from flexmb.system.program import evaluate
from flexmb.system.projection import project
from flexmb.tree.coordinates.products import _of_bodies
from flexmb.tree.coordinates.settle import unit_length
from flexmb.tree.rigid.motion import close_links, link_rates, loops_are_open

RIGID = [pair for pair in PAIRS if set(pair.split("-")) <= {"ground", "rigid"}]


def linked(system, state):
    """Return the joint coordinates of a system as unknowns, with its links, and the workspace that they share."""
    work = system.workspace()
    unknowns = fmb.Recursive().unknowns(system, state, work)
    assert unknowns.links is not None
    return unknowns, work


def assert_same_rates(model, rng, **options):
    """Compare second rates, and the powers of loads and drives, with those of the sparse solution."""
    system, state = random_consistent(model, rng, **options)
    unknowns, work = linked(system, state)
    other = system.workspace()
    state.a[:], state.lam[:] = fmb.Augmented().accelerate(system, state, other)
    x, v, a = unknowns.of(state)
    assert link_rates(unknowns.links, work, state.t, x, v) == -1
    np.testing.assert_allclose(unknowns.links.a, a, atol=AGREED * max(1.0, np.abs(a).max()))
    other.weights[0].wanted = 0
    evaluate(system.program, state, other)
    found = unknowns.links.powers
    np.testing.assert_allclose(found, powers(other.energy), atol=AGREED * max(1.0, np.abs(found).max()))


@pytest.mark.parametrize(
    ("kind", "pair"), [(k, p) for k in KINDS for p in RIGID if (k, p) != ("Fixed", "ground-rigid")]
)
def test_on_every_joint(kind, pair, rng):
    assert_same_rates(connected(kind, pair, rng), rng)


@pytest.mark.parametrize("pair", RIGID)
@pytest.mark.parametrize("kind", FORCES)
def test_on_every_force(kind, pair, rng):
    model = connected(kind, pair, rng)
    system, state = assemble(model)
    if any(force.reads_reactions for force in model.forces):
        assert fmb.Recursive().unknowns(system, state, system.workspace()).links is None
        return
    assert_same_rates(model, rng)


def deep(rng) -> fmb.Model:
    """Return a tree of all joints with coordinates, every other one drawn from b to a,
    a free body in between, and forces.
    """

    def pose():
        return fmb.Pose(0.4 * rng.normal(size=3), 0.3 * rng.normal(size=3))

    kinds = (
        fmb.Revolute,
        fmb.Spherical,
        fmb.Cylindrical,
        fmb.Universal,
        fmb.Planar,
        fmb.Screw,
        fmb.Prismatic,
        fmb.Fixed,
        fmb.Spherical,
        fmb.Universal,
        fmb.Cylindrical,
    )
    bodies, joints = [fmb.Ground(markers={"m0": pose()})], []
    for k in range(len(kinds) + 1):
        bodies.append(
            fmb.RigidBody(
                f"b{k}",
                mass=1.0 + rng.uniform(),
                inertia=rng.uniform(0.1, 0.15, 3),
                center_of_mass=0.2 * rng.normal(size=3),
                at=0.3 * rng.normal(size=3),
                rotation=0.3 * rng.normal(size=3),
                markers={f"m{n}": pose() for n in range(3)},
            )
        )
    for k, kind in enumerate(kinds):  # b5 floats
        before = "ground.m0" if k == 0 else f"b{k - 1 - k % 2}.m{1 + k % 2}" if k > 1 else "b0.m1"
        ends = (before, f"b{k if k < 5 else k + 1}.m0")
        more = {"pitch": 0.3} if kind is fmb.Screw else {}
        joints.append(kind(f"j{k}", markers=ends if k % 2 else ends[::-1], **more))
    forces = [
        fmb.SpringDamper("s", markers=("b2.m1", "b9.m2"), stiffness=50.0, damping=2.0),
        fmb.PointLoad("p", marker="b6.m2", force=(1.0, fmb.expression("sin(t)"), 2.0), axes="b6.m2"),
    ]
    return put_together(fmb.Model(bodies=bodies, joints=joints, forces=forces, gravity=(1.0, 2.0, -9.81)))


def closed(rng) -> fmb.Model:
    """Return the same tree with two loops, closed where its bodies are, and a drive."""
    tree = deep(rng)
    system, state = assemble(tree)
    evaluate(system.program, state, work := system.workspace())
    at = work.markers[system.marker_index["b3.m2"]]["r"]
    bodies = [fmb.Ground(markers={**tree.bodies[0].markers, "m1": fmb.Pose(at)})]
    for body in tree.bodies[1:]:
        q = state.q[system.body_slices[body.name][0]]
        R = np.empty((3, 3))
        euler_to_matrix(q[3:7], R)
        bodies.append(replace(body, at=q[:3], rotation=R))
    loops = [
        fmb.Rod("rod", markers=("b4.m2", "b10.m2")),
        fmb.Spherical("closed", markers=("b3.m2", "ground.m1")),
        fmb.Drive("motor", joint="j0", angle=fmb.expression("0.3*sin(2*t)")),
    ]
    return replace(tree, bodies=bodies).with_parts(joints=loops)


@pytest.mark.parametrize("loops", [False, True], ids=["tree", "loops"])
def test_on_joints_of_several_freedoms_in_both_directions(loops, rng):
    for _ in range(3):
        assert_same_rates(closed(rng) if loops else deep(rng), rng, spread=0.02)


def test_on_balls_in_tubes_one_behind_the_other(rng):
    """Each has a slide and a ball, so the coordinates of the next begin after five."""
    assert_same_rates(chain(3, fmb.InLine), rng)


@pytest.mark.parametrize("make", [lambda rng: mechanisms.four_bars(3), closed], ids=["planar", "spatial"])
def test_loops_are_closed_with_least_motion(make, rng):
    """Coordinates, then rates, that left the loops come back to them, as with the projection of all bodies."""
    system, state = random_consistent(make(rng), rng, spread=0.02)
    unknowns, work = linked(system, state)
    links = unknowns.links
    x, v, _ = unknowns.of(state)
    moving = [k for k, name in enumerate(unknowns.tree.names) if name not in unknowns.tree.drives]
    tight, beside = np.full(system.ng, 1e-13), x.copy()
    beside[moving] += 1e-5 * rng.normal(size=len(moving))
    for q, u, which in ((beside, v, "q"), (x, v + 1e-5 * rng.normal(size=len(v)), "u")):
        links.x[:], links.v[:] = q, u
        unit_length(unknowns.chart.rows, links.x)
        assert close_links(links, work, state.t, tight, system.gaps, system.program.equation_level)
        assert link_rates(links, work, state.t, links.x.copy(), links.v.copy()) == -1
        assert not loops_are_open(links, work, 10.0 * tight, np.ones(system.ng))
        ours = unknowns.state(state.t, links.x.copy(), links.v.copy())
        other = unknowns.state(state.t, q.copy(), u.copy())
        project(
            system.program,
            other,
            system.workspace(),
            np.zeros(system.nu + system.ng),
            other.q,
            tight,
            system.gaps,
            system.units,
            10,
        )
        np.testing.assert_allclose(getattr(ours, which), getattr(other, which), atol=1e-9)


@pytest.mark.parametrize("tolerance", [1e-5, 1e-8])
def test_many_four_bars_pass_the_line_of_all_bars(tolerance):
    """Forty of them, against the closed equation of their one freedom; at 1.24 s all bars lie in one line."""
    solution = fmb.simulate(
        mechanisms.four_bars(40),
        1.5,
        samples=[0.0, 1.5],
        integrator=fmb.Explicit(rtol=tolerance, atol=0.1 * tolerance, formulation=fmb.Recursive()),
    )
    np.testing.assert_allclose(solution["B0"][-1], mechanisms.four_bar_places(40, 1.5)[41], atol=20.0 * tolerance)


def test_forward_and_inverse_dynamics_are_inverse(rng):
    """Forces on the rates of every joint, balls and free bodies among them,
    come back from the motion that they give.
    """
    tree = fmb.JointTree(deep(rng))
    q, v, tau = tree.start.q, *rng.normal(size=(2, len(tree.rate_names)))
    np.testing.assert_allclose(tree.torques(q, v, tree.accelerations(q, v, tau)), tau, atol=1e-10)


def told_recursion(model) -> str:
    """Return which recursion a run has taken."""
    run = fmb.simulate(model, 1e-3, samples=2, integrator=fmb.Explicit(formulation=fmb.Recursive()))
    return run.statistics["recursion"]


def test_statistics_tell_which_recursion_was_taken():
    """Not silently: which passes, and why they are not those of links."""
    assert told_recursion(chain(1)) == "links"
    rubbing = fmb.JointFriction("rub", joint="j0", moving=0.1, radius=0.02, from_reaction=True)
    told = told_recursion(replace(chain(1), forces=[rubbing]))
    assert told.startswith("bodies: Force 'rub': a force that depends on reactions; its steps are Python's")


def with_points(rng, *, light: bool = False) -> fmb.Model:
    """Return two pendulums that a rod and a string of point masses join, and a point on springs."""
    law = {"stiffness": 50.0, "damping": 0.3, "viscous": 0.05, "moving": 0.2, "standing": 0.3, "stribeck": 0.1}
    names = ("one", "two", "three", "free")
    masses = dict(zip(names, rng.uniform(0.1, 0.5, 4), strict=True)) | ({"two": 1e-6} if light else {})
    places = {"one": (0.5, -1.2, 0.2), "two": (1.0, -1.4, 0.1), "three": (1.6, -1.2, -0.1), "free": (0, 1, 1)}
    rods = [
        fmb.RigidBody.rod(f"rod {k}", length=1.0, mass=1.0, at=(2 * k, 0, 0), rotation=(0.2, 0, -1.3)) for k in (0, 1)
    ]
    points = [fmb.PointMass(name, mass=masses[name], at=places[name]) for name in names]
    ends = ["rod 0.end", "one.center", "two.center", "three.center", "rod 1.end"]
    joints = [
        fmb.Revolute("A", markers=("ground.A", "rod 0.start")),
        fmb.Spherical("B", markers=("ground.B", "rod 1.start")),
        *(fmb.Rod(f"string {k}", markers=pair) for k, pair in enumerate(pairwise(ends))),
    ]
    forces = [
        fmb.LuGre("seal", joint="A", **law),
        fmb.SpringDamper("s", markers=("rod 0.end", "free.center"), stiffness=20.0, damping=0.3, length=0.5),
        fmb.Actuator(
            "motor", joint="A", effort=fmb.Pid(fmb.measured(fmb.JointCoordinate("angle", joint="A")), kp=9.0, ki=1.0)
        ),
    ]
    ground = fmb.Ground(markers={"A": (0, 0, 0), "B": (2, 0, 0)})
    return put_together(fmb.Model(bodies=[ground, *rods, *points], joints=joints, forces=forces, gravity=(1, -9.81, 2)))


@pytest.mark.parametrize("seed", range(3))
def test_points_in_loops_and_states_of_forces_and_controllers(seed):
    rng = np.random.default_rng(seed)
    assert_same_rates(with_points(rng), rng)


def test_points_that_are_too_light_for_a_closure_by_inverse_masses_take_the_recursion_over_bodies(rng):
    told = told_recursion(with_points(rng, light=True))
    assert told.startswith("bodies: Body 'two': 1e-06 kg between joints that hold far heavier bodies")


def test_explicit_runs_with_states_and_points_equal_implicit_ones(rng):
    model = with_points(rng)
    tight = fmb.simulate(model, 0.5, samples=6, integrator=fmb.Explicit(rtol=1e-10, formulation=fmb.Recursive()))
    assert tight.statistics["recursion"] == "links"
    other = fmb.simulate(model, 0.5, samples=6, integrator=fmb.Implicit(rtol=1e-9))
    np.testing.assert_allclose(tight.final.q, other.final.q, atol=1e-6)
    np.testing.assert_allclose(tight.final.u, other.final.u, atol=1e-5)


def test_points_on_a_spring_and_behind_a_lag_by_closed_forms():
    """x'' = -k/m (x - 1) of one; of the other x'' = z / m with z' = (1 - z) / T."""
    spring = fmb.SpringDamper("s", markers=("ground.origin", "p.center"), stiffness=40.0, length=1.0)
    late = fmb.PointLoad("load", marker="q.center", force=(fmb.Lag(1.0, time=0.2), 0, 0))
    points = [fmb.PointMass("p", mass=0.1, at=(1.2, 0, 0)), fmb.PointMass("q", mass=2.0)]
    model = fmb.Model(bodies=[fmb.Ground(), *points], forces=[spring, late])
    run = fmb.simulate(model, 1.0, samples=11, integrator=fmb.Explicit(rtol=1e-11, formulation=fmb.Recursive()))
    assert run.statistics["recursion"] == "links"
    t, T = run.t, 0.2
    places = np.array([(state.q[0], state.q[3]) for state in map(run.state, t)])
    np.testing.assert_allclose(places[:, 0], 1.0 + 0.2 * np.cos(20.0 * t), atol=1e-9)
    np.testing.assert_allclose(places[:, 1], 0.5 * (t**2 / 2 - T * t + T**2 * (1.0 - np.exp(-t / T))), atol=1e-9)


def test_products_of_trees_with_points_and_states(rng):
    """A point moves by its mass, a state by one; both beside the equations of all bodies."""
    model = with_points(rng)
    model = replace(model, joints=[j for j in model.joints if not isinstance(j, fmb.Rod)])
    tree = fmb.JointTree(model)
    q, v = tree.start.q, rng.normal(size=len(tree.rate_names))
    a, tau = rng.normal(size=(2, len(v)))
    np.testing.assert_allclose(tree.torques(q, v, a, 0.3), _of_bodies(tree, q, v, a, 0.3), atol=1e-10)
    linear = _of_bodies(tree, q, 0 * v, 1e6 * a, 0.0) - _of_bodies(tree, q, 0 * v, 0 * a, 0.0)
    np.testing.assert_allclose(tree.mass_product(q, a), 1e-6 * linear, atol=1e-10)
    np.testing.assert_allclose(tree.mass_product(q, tree.mass_solution(q, tau)), tau, atol=1e-10)
    np.testing.assert_allclose(tree.torques(q, v, tree.accelerations(q, v, tau, 0.3), 0.3), tau, atol=1e-10)
    of_free = [name.startswith("free.") for name in tree.rate_names]
    mass = next(body.mass for body in model.bodies if body.name == "free")
    np.testing.assert_allclose(tree.mass_product(q, a)[of_free], mass * a[of_free], rtol=1e-14)


@pytest.mark.parametrize("kind", [fmb.Revolute, fmb.Cylindrical, fmb.Spherical])
def test_rounding_of_an_inertia_is_none(kind):
    """A moment of 1e-20 about the axis of a joint that is turned in space: what is computed of it is rounding.

    The acceleration was that of rounding, 6e4 rad/s2; the general recursion refuses it by the same bound.
    """
    R = Rotation.random(random_state=1)
    own = Rotation.from_euler("y", 0.5 * np.pi)
    rod = fmb.RigidBody(
        "rod", mass=1.0, inertia=(1e-20, 0.1, 0.1), rotation=R, markers={"axis": fmb.Pose((-0.5, 0, 0), own)}
    )
    seat = fmb.Pose(tuple(R.apply((-0.5, 0, 0))), R * own)
    joint = kind("hinge", markers=("ground.seat", "rod.axis"))
    model = fmb.Model(bodies=[fmb.Ground(markers={"seat": seat}), rod], joints=[joint], gravity=(1, 2, -9.81))
    tree = fmb.JointTree(model)
    message = r"Body 'rod' \(joint 'hinge'\): its articulated inertia is singular"
    with pytest.raises(fmb.CompileError, match=message):
        tree.accelerations(tree.start.q)
    with pytest.raises(fmb.CompileError, match=message):
        fmb.accelerations(model, formulation=fmb.Recursive())
