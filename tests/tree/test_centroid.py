"""Centre of mass and centroidal momentum of trees: beside Pinocchio, differences, and the momenta of single bodies."""

import numpy as np
import pytest
from tree.models import branched, chain, flexible_chain, loops, random_consistent
from tree.pinocchio_trees import Twin
from tree.test_flexible_links import random_tree
from tree.test_joint_products import assert_close, random_motion

import flexmb as fmb
from flexmb.tree.coordinates.reach import advanced


@pytest.mark.peer
@pytest.mark.parametrize("seed", range(12))
def test_random_rigid_trees_in_pinocchio(seed):
    """centerOfMass, jacobianCenterOfMass, ccrba and computeCentroidalMomentumTimeVariation; lengths 1e-6 to 1e6."""
    pin = pytest.importorskip("pinocchio")
    rng = np.random.default_rng(seed)
    length, mass = 10.0 ** rng.uniform(-6, 6, 2) if seed % 2 else (1.0, 1.0)
    twin = Twin(pin, rng, int(rng.integers(1, 25)), length, mass, floating=seed % 3 == 0)
    model, data = twin.theirs, twin.data
    about, fall = mass * np.array([length] * 3 + [length**2] * 3), np.linalg.norm(model.gravity.linear)
    for _ in range(2):
        q, v, a, _ = twin.state(rng, length)
        found = twin.tree.centroid(twin.coordinates(q), twin.rates(v), twin.rates(a))
        pin.centerOfMass(model, data, q, v, a)
        place, moved, driven = data.com[0].copy(), data.vcom[0].copy(), data.acom[0].copy()
        own = [twin.rates(row) for row in pin.jacobianCenterOfMass(model, data, q)]
        size = length * np.sqrt(len(twin.limbs))
        assert found.mass == pytest.approx(pin.computeTotalMass(model), rel=1e-14)
        assert_close(found.position, place, size, 1e-13)
        assert_close(found.velocity, moved, size, 1e-12)
        # the weight is taken out of the equations of motion
        np.testing.assert_allclose(found.acceleration, driven, atol=1e-12 * np.abs(driven).max() + 1e-15 * fall)
        assert_close(found.jacobian, np.array(own), size, 1e-12)
        pin.ccrba(model, data, q, v)
        matrix, momentum = data.Ag.copy(), data.hg.vector.copy()
        assert_close(found.momentum_matrix, np.array([twin.rates(row) for row in matrix]), about[:, None], 1e-12)
        assert_close(found.momentum, momentum, about, 1e-12)
        assert_close(found.inertia, data.Ig.inertia, mass * length**2, 1e-12)
        pin.computeCentroidalMomentumTimeVariation(model, data, q, v, a)
        rounded = 1e-15 * fall / length * len(twin.limbs) ** 2
        np.testing.assert_allclose(
            found.momentum_rate / about, data.dhg.vector / about, rtol=1e-11, atol=1e-11 + rounded
        )


def trees(seed):
    """Return a tree of rigid and reduced bodies with springs, with a point mass and friction that has a state."""
    model = random_tree(np.random.default_rng(seed))
    point = fmb.PointMass("point", mass=0.7, at=(0.1, 0.2, 0.3))
    tie = fmb.SpringDamper("tie", markers=("ground.m0", "point.center"), stiffness=30.0)
    hinge = next((j.name for j in model.joints if isinstance(j, fmb.Revolute | fmb.Prismatic | fmb.Cylindrical)), None)
    rub = [fmb.LuGre("rub", joint=hinge, stiffness=50.0, moving=0.2)] if hinge else []
    return fmb.JointTree(model.with_parts(bodies=[point], forces=[tie, *rub]))


@pytest.mark.parametrize("seed", range(4))
def test_rates_are_derivatives(seed):
    """Central differences of the place by the rates, and of velocity and momentum by rates and second rates."""
    tree, rng = trees(seed), np.random.default_rng(seed)
    q, v, a = random_motion(tree, rng, 1e-2)
    here, h = tree.centroid(q, v, a), 1e-5
    ahead, behind = (tree.centroid(advanced(tree, q, s * h * v + 0.5 * h * h * a), v + s * h * a) for s in (1.0, -1.0))

    def slope(name):
        return (getattr(ahead, name) - getattr(behind, name)) / (2.0 * h)

    np.testing.assert_allclose(here.velocity, slope("position"), atol=1e-7)
    np.testing.assert_allclose(
        here.acceleration, slope("velocity"), atol=1e-6 * max(1, np.abs(here.acceleration).max())
    )
    rates = here.momentum_rate
    np.testing.assert_allclose(rates, slope("momentum"), atol=1e-6 * max(1, np.abs(rates).max()))
    np.testing.assert_allclose(here.jacobian @ v, here.velocity, atol=1e-14 * np.abs(here.velocity).max())
    still = tree.centroid(q, v)
    np.testing.assert_allclose(
        rates - still.momentum_rate, here.momentum_matrix @ a, atol=1e-11 * max(1, np.abs(rates).max())
    )


def assert_sum_of_bodies(tree, state, here) -> None:
    """Compare momenta with those of the bodies, of which `Body.momentum` knows each alone, about the origin of W."""
    total = np.zeros(6)
    for body in tree.model.bodies:
        if body.n_velocities:
            own_q, own_u = tree.system.body_slices[body.name]
            total += body.momentum(state.q[None, own_q], state.u[None, own_u])[0]
    total[3:] -= np.cross(here.position, total[:3])
    np.testing.assert_allclose(here.momentum, total, atol=1e-12 * np.abs(total).max())


@pytest.mark.parametrize("seed", range(4))
def test_momenta_are_the_sums_of_those_of_the_bodies(seed):
    tree, rng = trees(seed), np.random.default_rng(seed)
    q, v, _ = random_motion(tree, rng, 1e-2)
    assert_sum_of_bodies(tree, tree.absolute(q, v), tree.centroid(q, v))


@pytest.mark.parametrize("make", [loops, branched])
def test_momenta_of_closed_loops_and_of_free_bodies(make, rng):
    system, state = random_consistent(make(), rng)
    tree = fmb.JointTree.of(system, state)
    assert_sum_of_bodies(tree, state, tree.centroid(tree.start))


def test_a_floating_tree_falls_as_its_centre_of_mass(rng):
    """Without the ground the centre has the acceleration of gravity, and the angular momentum stays."""
    model = flexible_chain(3).without("j0").without("pull")
    tree = fmb.JointTree(model)
    q, v, _ = random_motion(tree, rng, 1e-3)
    free = tree.accelerations(q, v)
    here = tree.centroid(q, v, free)
    terms = np.abs(here.momentum_matrix) @ np.abs(free)
    np.testing.assert_allclose(here.acceleration, model.gravity, atol=1e-12 * terms[:3].max() / here.mass)
    np.testing.assert_allclose(here.momentum_rate[3:], 0.0, atol=1e-12 * terms[3:].max())


def test_a_state_in_joint_coordinates_is_taken_as_it_is():
    """Of a chain of rods in a line that turns about its first hinge."""
    tree = fmb.JointTree(chain(3))
    here = tree.centroid(tree.relative(tree.absolute(tree.start.q, [2.0, 0.0, 0.0])))
    np.testing.assert_allclose(here.position, [1.5, 0.0, 0.0], atol=1e-14)
    np.testing.assert_allclose(here.velocity, [0.0, 3.0, 0.0], atol=1e-14)
    across = 9.0 * 3.0 / 12.0 + 3.0 * 0.05**2 / 4.0
    np.testing.assert_allclose(here.momentum[5], 2.0 * across, rtol=1e-12)
    np.testing.assert_allclose(np.diag(here.inertia)[1:], across, rtol=1e-12)


def test_a_tree_without_mass_has_no_centre():
    held = fmb.Spherical("pin", markers=("ground.origin", "p.center"))
    tree = fmb.JointTree(fmb.Model(bodies=[fmb.Ground(), fmb.PointMass("p", mass=0.0)], joints=[held]))
    with pytest.raises(fmb.ModelError, match=r"the mass 0 kg.*a mass, which has a centre.*Give a body mass"):
        tree.centroid(tree.start.q)
