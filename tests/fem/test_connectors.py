"""Masses, springs, supports, rigid and averaging links."""

from dataclasses import replace

import numpy as np
import pytest
from fem.beams import STEEL, frequencies, solve, straight
from reduction.solids import block
from scipy.optimize import brentq
from tolerances import MACHINE

from flexmb import fem
from flexmb.errors import MeshError
from flexmb.fem import Section
from flexmb.fem.links.links import average_motion

SECTION = Section.rectangle(0.02, 0.01)


@pytest.fixture
def beam():
    return fem.frame(straight(4), section=SECTION, material=STEEL)


@pytest.fixture
def linked(beam):
    """Every connector at once: a rigid hub of two nodes with a mass, and an averaging node with a mass."""
    fe = fem.with_rigid_link(beam, (0.5, 0.3, 0.1), [2, 3], name="hub")
    fe = fem.with_mass(fe, "hub", 3.0, inertia=(0.1, 0.2, 0.3), offset=(0.0, 0.0, 0.2))
    fe = fem.with_averaging_link(fe, (0.1, 0.4, 0.3), [0, 1, 5], weights=(1.0, 2.0, 0.5), name="sensor")
    return fem.with_mass(fe, "sensor", 1.0, offset=(0.0, 0.0, 1.0))


def rigid_inertia(fe):
    motions = fe.rigid_motions()
    return motions.T @ fe.M @ motions


def test_mass_with_offset_has_the_inertia_of_a_rigid_body(beam):
    """Parallel axes: 6 x 6 inertia about the origin of a body with its centre at c."""
    mass, own, offset = 2.0, np.diag([1.0, 2.0, 3.0]), np.array([0.1, 0.2, 0.3])
    added = rigid_inertia(fem.with_mass(beam, "end", mass, own, offset)) - rigid_inertia(beam)
    c = np.array([1.0, 0, 0]) + offset
    skew = np.array([[0, -c[2], c[1]], [c[2], 0, -c[0]], [-c[1], c[0], 0]])
    expected = np.block([[mass * np.eye(3), -mass * skew], [mass * skew, own - mass * skew @ skew]])
    np.testing.assert_allclose(added, expected, atol=MACHINE * 10)


def test_cantilever_with_tip_mass():
    """f = sqrt(3 E I / (m + 33/140 rho A L) L^3) / 2 pi, Rayleigh, within 1 % for a heavy mass (Blevins,
    table 8-8)."""
    fe = fem.with_mass(fem.frame(straight(8), section=SECTION, material=STEEL), (1.0, 0.0, 0.0), 50.0)
    expected = np.sqrt(3 * STEEL.young * SECTION.inertia_y / (50.0 + 33 / 140 * 1.57)) / (2 * np.pi)
    assert frequencies(fem.with_supports(fe, "start"), 1)[0] == pytest.approx(expected, rel=1e-3)


def test_links_keep_rigid_motions(linked):
    motions = linked.rigid_motions()
    assert np.abs(linked.K @ motions).max() < MACHINE * abs(linked.K).max()
    field, expected = linked.field(motions), np.zeros((7, 6, 6))
    for k in range(3):
        expected[:, k, k] = expected[:, 3 + k, 3 + k] = 1.0
        expected[:, :3, 3 + k] = np.cross(np.eye(3)[k], linked.nodes)
    np.testing.assert_allclose(field, expected, atol=MACHINE * 100)


def test_links_keep_the_mass(beam, linked):
    found = rigid_inertia(linked) - rigid_inertia(beam)
    assert found[0, 0] == pytest.approx(4.0, rel=MACHINE)
    x = 3.0 * np.array([0.5, 0.3, 0.3]) + np.array([0.1, 0.4, 1.3])  # first moment of both masses
    np.testing.assert_allclose(found[[2, 0, 1], [4, 5, 3]], [-x[0], -x[1], -x[2]], atol=1e-10)


def test_rigid_link_stiffens_as_a_rigid_bar(beam):
    """Cantilever of length L = 1 whose last quarter is rigid, force at the tip: superposition of closed
    forms."""
    beam = fem.frame(straight(4), section=SECTION, material=STEEL, shear=False)
    fe = fem.with_supports(fem.with_rigid_link(beam, 3, [4]), "start")
    tip = solve(fe, 4, (0, 1, 0, 0, 0, 0))[4, 1]
    ei, a, r = STEEL.young * SECTION.inertia_z, 0.75, 0.25
    moment = r  # about z at x = a
    deflection = a**3 / (3 * ei) + moment * a**2 / (2 * ei)
    slope = a**2 / (2 * ei) + moment * a / ei
    assert tip == pytest.approx(deflection + r * slope, rel=1e-10)


def test_averaging_link_spreads_a_force_statically(linked, rng):
    """The nodal forces on the three nodes have the resultant and the moment of the load on the reference
    node."""
    points, weights = rng.random((5, 3)), rng.random(5)
    at = rng.random(3)
    mean = average_motion(points, weights, at, "test")
    load = rng.standard_normal(6)
    forces = np.einsum("d,dik->ik", load, mean)
    np.testing.assert_allclose(forces.sum(axis=0), load[:3], atol=1e-10)
    np.testing.assert_allclose(np.cross(points - at, forces).sum(axis=0), load[3:], atol=1e-10)


def test_forces_on_dependent_nodes_reach_the_freedoms(linked, rng):
    """Virtual work: f^T U = F^T u for any motion."""
    load, motion = rng.standard_normal((7, 6, 1)), rng.standard_normal((linked.ndof, 1))
    assert np.vdot(linked.forces(load), motion) == pytest.approx(np.vdot(load, linked.field(motion)), rel=1e-10)


def test_pressure_on_linked_nodes_reaches_the_freedoms():
    """Traction on a face whose nodes follow a rigid link: resultant and moment act on the reference node."""
    fe = block()
    hub = fem.with_rigid_link(fe, (0.2, 0.0, 0.1), "right", "hub")
    free, linked = (fem.traction_load(model, "top", (1.0, 2.0, 3.0)) for model in (fe, hub))
    for model, load in ((fe, free), (hub, linked)):
        np.testing.assert_allclose(
            model.rigid_motions()[:, :3].T @ load, 0.4 * 0.06 * np.array([1.0, 2.0, 3.0]), rtol=1e-10
        )
    np.testing.assert_allclose(hub.rigid_motions().T @ linked, fe.rigid_motions().T @ free, rtol=1e-10, atol=1e-12)


@pytest.mark.parametrize("arm", [0.5, -0.3])
def test_column_with_a_rigid_extension(arm):
    """Load P at the end of a rigid extension a of a clamped column L: tan(k L) = 1 / (k a), P = k^2 E I.

    From E I y'' = P (y(L) + a y'(L) - y). A negative arm hangs the load below the top.
    """
    section = Section.rectangle(0.02, 0.01)
    fe = fem.frame(straight(16), section=section, material=STEEL, shear=False)
    fe = fem.with_supports(fem.with_rigid_link(fe, (1.0 + arm, 0.0, 0.0), "end", "load"), "start")
    load = np.zeros((len(fe.nodes), 6, 1))
    load[fe.node_sets["load"], 0] = -1.0
    found = fem.buckling(fe, fe.forces(load)[:, 0], None, 1)[0][0]
    low, high = (1e-6, np.pi / 2) if arm > 0.0 else (np.pi / 2 + 1e-6, np.pi)
    k = brentq(lambda k: np.cos(k) - arm * k * np.sin(k), low, high)
    assert found == pytest.approx(k**2 * STEEL.young * section.inertia_y, rel=1e-5)


def test_geometric_stiffness_of_linked_models(linked, rng):
    modes = rng.standard_normal((linked.ndof, 3))
    stress = linked.field(rng.standard_normal((linked.ndof, 1)))
    assembled = linked.blocks[0].geometric_stiffness(stress[..., 0], linked.dofs)
    projected = linked.blocks[0].projected_geometric_stiffness(stress, linked.field(modes))
    np.testing.assert_allclose(modes.T @ assembled @ modes, projected[0], atol=1e-10 * np.abs(projected).max())
    held = fem.with_supports(linked, "start")
    assert held.blocks[0].geometric_stiffness(stress[..., 0], held.dofs).shape == (held.ndof, held.ndof)
    assert linked.blocks[0].nodal_stress(stress).shape == stress.shape


def test_springs(beam):
    grounded = fem.with_spring(beam, 0, [1e5, 1e6, 1e7, 1e3, 1e4, 1e5])
    field = solve(grounded, 0, (1, 1, 1, 1, 1, 1))[0]
    np.testing.assert_allclose(field, [1e-5, 1e-6, 1e-7, 1e-3, 1e-4, 1e-5], rtol=1e-8)
    between = fem.with_spring(beam, 0, [1e5] * 6, to=4)
    assert np.abs(between.K @ between.rigid_motions()).max() < MACHINE * abs(between.K).max()


def test_supports_make_a_model_planar(beam):
    planar = fem.with_supports(beam, directions=(0, 2, 3, 4))
    assert planar.ndof == 10
    assert set(planar.dofs[:, 1]) == {1, 5}


@pytest.mark.parametrize(
    ("act", "found", "remedy"),
    [
        (lambda b, k: fem.with_supports(k, 3), "node 3 depends on other nodes", "reference node"),
        (lambda b, k: fem.with_supports(b, 0, [6]), "directions [6]", "rotations"),
        (
            lambda b, k: fem.with_rigid_link(k, 4, [3]),
            "node 3 depends on another link",
            "one of the two links",
        ),
        (lambda b, k: fem.with_rigid_link(k, 3, [4]), "0 independent freedoms", "a new node is made"),
        (lambda b, k: fem.with_rigid_link(fem.with_supports(b, 0), 1, [0]), "node 0 is held", "link first"),
        (lambda b, k: fem.with_rigid_link(b, 0, [0]), "no nodes", "node numbers"),
        (lambda b, k: fem.with_averaging_link(b, (0, 0, 1), [0, 1, 2]), "on one line", "with_rigid_link"),
        (
            lambda b, k: fem.with_averaging_link(b, (0, 0, 1), [0, 1], [1.0]),
            "weights of shape (1,)",
            "equal ones",
        ),
        (lambda b, k: fem.with_mass(b, 7, 1.0), "node 7 does not exist", "start at 0"),
        (
            lambda b, k: fem.with_mass(b, (0.3, 0, 0), 1.0),
            "nearest, node 1, is 0.05 m away",
            "with_rigid_link",
        ),
        (lambda b, k: fem.with_mass(b, 0, -1.0), "mass = -1.0 kg", "centre of the mass"),
        (
            lambda b, k: fem.with_mass(replace(b, node_sets={"two": np.arange(2)}), "two", 1.0),
            "2 nodes",
            "rigid_link",
        ),
        (lambda b, k: fem.with_mass(b, [0.0, 1.0], 1.0), "nodes = [0.0, 1.0]", "whole numbers"),
        (lambda b, k: fem.with_spring(b, 0, [1.0] * 3), "shape (3,)", "three rotational"),
        (
            lambda b, k: fem.with_mass(fem.with_supports(b, 0, [3]), 0, 1.0, (1, 1, 1)),
            "rotation x",
            "no rotations",
        ),
        (lambda b, k: fem.with_mass(b, "hub", 1.0), "node set 'hub' does not exist", ""),
    ],
)
def test_messages(beam, linked, act, found, remedy):
    with pytest.raises(MeshError) as caught:
        act(beam, linked)
    assert found in caught.value.found
    assert remedy in caught.value.remedy


def test_supports_in_the_notation_of_fixed(beam):
    """A mapping holds what `fixed` holds; what is no node is refused."""
    both = {"start": "xyzrxryrz", "end": "y"}
    held = fem.with_supports(beam, both)
    assert frequencies(held, 3) == pytest.approx(fem.eigenmodes(beam, both, n=3).frequencies, rel=1e-9)
    with pytest.raises(MeshError, match="nodes = True"):
        fem.with_supports(beam, True)
