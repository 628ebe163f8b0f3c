"""The recursion alone: exact chains, spanning trees, many loops, trajectories, and what it refuses."""

import time

import numpy as np
import pytest
from contracts.random_models import beam
from tolerances import MACHINE
from tree.models import branched, chain, loops, random_consistent
from tree.test_flexible_links import straight_beam
from verification.mechanisms import four_bars

import flexmb as fmb
from flexmb.integrate.matrices import equations_at
from flexmb.system import assemble, compile
from flexmb.tree import spanning_tree


def slender_chain(n):
    """Return RB21: n slender rods of 1 m and 1 kg, hinged and horizontal, gravity 1 m/s2."""
    rods = [fmb.RigidBody.rod(f"b{k}", length=1.0, mass=1.0, at=(k, 0, 0)) for k in range(n)]
    ends = ["ground.origin"] + [f"b{k}.end" for k in range(n)]
    joints = [fmb.Revolute(f"j{k}", markers=(ends[k], f"b{k}.start")) for k in range(n)]
    return fmb.Model(gravity=(0, -1, 0), bodies=[fmb.Ground(), *rods], joints=joints)


@pytest.mark.parametrize("n", [3, 10])
def test_rb21_first_accelerations_of_a_chain(n, reference):
    """RB21, exact rational solution; tolerance of the case: relative 1e-12."""
    found = fmb.accelerations(slender_chain(n), formulation=fmb.Recursive())
    expected = np.array(reference("RB21")["reference"][f"n={n}"])
    angular = np.array([found[f"b{k}"][5] for k in range(n)])
    np.testing.assert_allclose(angular, expected, atol=MACHINE * np.abs(expected).max(), rtol=0)


def test_the_tree_leaves_the_fewest_closing_equations():
    tree = spanning_tree(compile(loops()))
    assert set(tree.order) == {"crank", "coupler", "rocker", "wheel", "bob"}
    assert set(tree.cut) == {"A2", "C", "gear", "link"} or set(tree.cut) == {"A", "C", "gear", "link"}
    assert len(tree.tables.cut_equations) == 5 + 3 + 1 + 1


def test_trees_have_only_the_ground_in_common():
    tree = spanning_tree(compile(branched()))
    assert len(tree.tables.trees) - 1 == 3  # hub with its branches, dust, free
    assert tree.order.index("wing") < tree.order.index("ball")
    assert spanning_tree(compile(chain(5))).tables.trees.tolist() == [0, 5]


def test_drives_go_with_their_joint():
    tree = spanning_tree(compile(branched()))
    assert tree.joints["tail"] == "b"
    assert not tree.cut


def test_four_hundred_loops():
    """RB02 in kind: constraints hold at all levels, and the equations of motion are satisfied."""
    system, state = assemble(four_bars(400))
    work = system.workspace()
    a, lam = fmb.Recursive().accelerate(system, state, work)
    e = equations_at(system, state, work)
    assert np.abs(e.G @ a - e.b).max() < 1e-9
    assert np.abs(e.M @ a - e.L @ lam - e.f).max() < 1e-9
    np.testing.assert_allclose(a, fmb.Augmented().accelerate(system, state, work)[0], atol=1e-8)


def test_trajectory_of_loops():
    """Against the generalised-alpha method at a tight tolerance; energy and constraints hold at every output."""
    model = four_bars(2)
    one = fmb.simulate(model, 0.5, formulation=fmb.Recursive(), samples=6)
    two = fmb.simulate(model, 0.5, integrator=fmb.GeneralizedAlpha(rtol=1e-7, atol=1e-9), samples=6)
    np.testing.assert_allclose(one.final.q, two.final.q, atol=2e-5)
    energy = one["energy"]
    assert np.abs(energy - energy[0]).max() < 1e-6
    assert np.abs(one["error"]).max() < 1e-8


def test_friction_by_reactions():
    """The fixed point of the recursion is that of Newton's method on the augmented equations."""
    model = chain(3, forces=[fmb.JointFriction("f", joint="j1", moving=0.3, radius=0.05, transition=1e-2)])
    system, state = random_consistent(model, np.random.default_rng(3))
    work = system.workspace()
    a, lam = fmb.Recursive().accelerate(system, state, work)
    for other in (fmb.Augmented(), fmb.NullSpace()):
        b, mu = other.accelerate(system, state, work)
        np.testing.assert_allclose(a, b, atol=1e-9 * np.abs(b).max())
        np.testing.assert_allclose(lam, mu, atol=1e-9 * np.abs(mu).max())


def test_linear_cost():
    """Ten times the bodies take about ten times as long: no quadratic term (a ratio, so no timer of the machine)."""

    def seconds(n):
        system, state = assemble(chain(n))
        work, formulation = system.workspace(), fmb.Recursive()
        formulation.accelerate(system, state, work)
        spent = []
        for _ in range(7):
            clock = time.process_time()
            formulation.accelerate(system, state, work)
            spent.append(time.process_time() - clock)
        return min(spent)

    assert seconds(1000) < 30 * seconds(100)


def singular():
    """Return a massless link at the end of a chain: a rod that turns freely about its axis without inertia."""
    end = fmb.RigidBody("end", mass=1.0, inertia=(0.0, 0.1, 0.1), center_of_mass=(0.5, 0, 0), markers={"a": (0, 0, 0)})
    return fmb.Model(bodies=[fmb.Ground(), end], joints=[fmb.Spherical("ball", markers=("ground.origin", "end.a"))])


def test_a_free_motion_without_inertia_is_named():
    system = compile(singular())
    with pytest.raises(fmb.CompileError, match=r"Body 'end' \(joint 'ball'\).*articulated inertia is singular"):
        fmb.Recursive().accelerate(system, system.state(), system.workspace())


@pytest.mark.parametrize(
    "ask",
    [
        lambda m: fmb.accelerations(m, formulation=fmb.Recursive()),
        fmb.JointTree,
        lambda m: fmb.simulate(m, 0.1, formulation=fmb.Recursive()),
        lambda m: fmb.simulate(m, 0.1, integrator=fmb.Implicit()),
    ],
)
@pytest.mark.parametrize(("joint", "lacking"), [(fmb.Revolute, "no inertia about its"), (fmb.Prismatic, "no mass")])
def test_a_massless_body_at_the_end_of_a_branch_is_named(joint, lacking, ask):
    arm = fmb.RigidBody.rod("arm", length=1.0, mass=1.0, radius=0.05)
    end = fmb.RigidBody("end", mass=0.0, inertia=(0, 0, 0), at=(1, 0, 0), markers={"a": (0, 0, 0)})
    joints = [fmb.Revolute("A", markers=("ground.origin", "arm.start")), joint("B", markers=("arm.end", "end.a"))]
    with pytest.raises(fmb.CompileError, match=rf"Body 'end': the equations of motion are singular: {lacking}"):
        ask(fmb.Model(bodies=[fmb.Ground(), arm, end], joints=joints))


def test_a_joint_to_cut_that_does_not_exist_is_named():
    with pytest.raises(fmb.CompileError, match=r"joint 'jj1' to cut does not exist.*Did you mean 'j1'"):
        fmb.accelerations(chain(3), formulation=fmb.Recursive(cut=("jj1",)))


def test_two_drives_on_one_freedom_are_named():
    drives = [fmb.Drive(name, joint="j0", angle=fmb.ramp(rate=1.0)) for name in ("one", "two")]
    model = chain(1)
    system = compile(fmb.Model(bodies=model.bodies, joints=[*model.joints, *drives]))
    with pytest.raises(fmb.CompileError, match=r"Joint 'j0': its equations, with its drives, are dependent"):
        fmb.Recursive().accelerate(system, system.state(), system.workspace())


def test_a_text_instead_of_names_is_refused():
    with pytest.raises(fmb.ModelError, match=r"cut = 'A'.*names of joints"):
        fmb.Recursive(cut="A")


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize(("modes", "end"), [(9, "tip"), (20, "root")])
def test_modes_that_let_a_marker_move_cost_no_digits(modes, end, seed):
    """Two beams in flight on a ball: of the inertia at a marker that modes move little is left.

    Without refinement 1e-11 to 3e-10 were lost. The null space of the constraints eliminates no modes.
    """
    first = fmb.FloatingBody("f0", data=beam() if modes == 9 else straight_beam(modes))
    second = fmb.FloatingBody("f1", data=straight_beam(1), at=(float(end == "tip"), 0, 0))
    ball = fmb.Spherical("ball", markers=(f"f0.{end}", "f1.root"))
    model = fmb.Model(bodies=[fmb.Ground(), first, second], joints=[ball], gravity=(0, 0, -9.81))
    system, state = random_consistent(model, np.random.default_rng(seed))
    work = system.workspace()
    expected, force = fmb.NullSpace().accelerate(system, state, work)
    found, lam = fmb.Recursive().accelerate(system, state, work)
    np.testing.assert_allclose(found, expected, atol=1e-13 * np.abs(expected).max())
    np.testing.assert_allclose(lam, force, atol=1e-13 * np.abs(force).max())
