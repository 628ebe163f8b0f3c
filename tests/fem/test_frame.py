"""Frames: axes, branches, meshes, section forces, lumped mass, messages."""

import numpy as np
import pytest
from fem.beams import STEEL, frequencies, solve, straight
from tolerances import MACHINE

from flexmb import fem
from flexmb.errors import MeshError
from flexmb.fem import Section
from flexmb.fem.meshes.mesh import Mesh

SECTION = Section.rectangle(0.02, 0.01)
OFFSET = Section.values(
    1e-3,
    2e-6,
    3e-6,
    1e-6,
    0.8,
    0.7,
    product_yz=1e-6,
    area_center=(0.01, 0.02),
    shear_center=(-0.03, 0.01),
    mass_center=(0.02, 0.01),
)


@pytest.mark.parametrize("section", [SECTION, OFFSET, (Section.box(0.1, 0.05, 0.004), Section.box(0.05, 0.05, 0.002))])
@pytest.mark.parametrize("shear", [True, False])
def test_rigid_motions_are_exact_in_space(rng, section, shear):
    fe = fem.frame(np.cumsum(rng.random((6, 3)), axis=0), section=section, material=STEEL, shear=shear)
    motions = fe.rigid_motions()
    assert np.abs(fe.K @ motions).max() < 1e-14 * abs(fe.K).max() * np.abs(motions).max() * 36
    values = np.linalg.eigvalsh(fe.K.toarray())
    assert np.abs(values[:6]).max() < 1e-11 * values[-1]
    assert values[6] > 1e-9 * values[-1]
    assert (abs(fe.K - fe.K.T)).max() == 0.0


def test_mass_properties_of_a_bar():
    """m, m L / 2, and the inertia of a box (m / 12)(h^2 + L^2) about its centre."""
    fe = fem.frame(straight(3), section=SECTION, material=STEEL)
    mass = STEEL.density * 2e-4
    found = fe.rigid_motions().T @ fe.M @ fe.rigid_motions()
    expected = np.diag(
        [mass] * 3 + [mass / 12 * (0.02**2 + 0.01**2), mass / 3 + mass / 12 * 0.01**2, mass / 3 + mass / 12 * 0.02**2]
    )
    expected[1, 5] = expected[5, 1] = mass / 2
    expected[2, 4] = expected[4, 2] = -mass / 2
    np.testing.assert_allclose(found, expected, atol=MACHINE * mass)


def test_default_orientation_keeps_z_up():
    for along in ((1, 0, 0), (0, 1, 0), (1, 1, 0), (1, 0, 1)):
        axes = fem.frame(straight(1, direction=along), section=SECTION, material=STEEL).blocks[0].axes[0]
        assert axes[2, 2] > 0.7  # local z against global z
        assert axes[1, 2] == pytest.approx(0.0, abs=MACHINE)
    axes = fem.frame(straight(1, direction=(0, 0, 1)), section=SECTION, material=STEEL).blocks[0].axes[0]
    np.testing.assert_allclose(axes[1], (0, 1, 0), atol=MACHINE)


def test_orientation_names_the_section_y_axis():
    """Tip deflection F L^3 / 3 E I: the stiff side (width) bends in the plane of the orientation vector."""
    force = 10.0
    for orientation, axis in (((0, 1, 0), 1), ((0, 0, 1), 2)):
        fe = fem.frame(straight(2), section=SECTION, material=STEEL, orientation=orientation, shear=False)
        fe = fem.with_supports(fe, "start")
        tip = solve(fe, 2, np.eye(6)[axis] * force)[2, axis]
        assert tip == pytest.approx(force / (3 * STEEL.young * SECTION.inertia_z), rel=1e-10)


def test_branched_frame_is_in_equilibrium():
    """A T of three beams: the reactions of the three clamped ends carry the force on the joint."""
    points = [(0, 0, 0), (1, 0, 0), (2, 0, 0), (1, 1, 0)]
    fe = fem.frame(points, connectivity=[(0, 1), (1, 2), (1, 3)], section=SECTION, material=STEEL)
    held = fem.with_supports(fe, [0, 2, 3])
    field = solve(held, 1, (3.0, 4.0, 5.0, 0, 0, 0))
    nodal = fe.field(fe.K @ fe.vectors(field[..., None]))[..., 0]
    np.testing.assert_allclose(nodal[[0, 2, 3], :3].sum(axis=0), (-3, -4, -5), atol=1e-10)


def test_line_mesh_with_sections_by_group():
    """Two groups of lines in one mesh: series of springs E A / L; unused nodes are left out."""
    points = np.array([(0, 0, 0), (9, 9, 9), (1, 0, 0), (3, 0, 0)], float)
    mesh = Mesh(
        points=points,
        cells=(("line", np.array([(0, 2), (2, 3)])),),
        node_sets={"root": np.array([0]), "tip": np.array([3])},
        cell_sets={"thick": (np.array([0]),), "thin": (np.array([1]),)},
    )
    thick, thin = Section.rectangle(0.02, 0.02), Section.rectangle(0.01, 0.01)
    fe = fem.frame(mesh=mesh, section={"thick": thick, "thin": thin}, material=STEEL)
    assert len(fe.nodes) == 3
    tip = solve(fem.with_supports(fe, "root"), fe.node_sets["tip"][0], (1, 0, 0, 0, 0, 0))[2, 0]
    assert tip == pytest.approx(1 / STEEL.young * (1 / thick.area + 2 / thin.area), rel=1e-10)


def test_section_forces_of_a_cantilever():
    fe = fem.with_supports(fem.frame(straight(4), section=SECTION, material=STEEL), "start")
    field = solve(fe, 4, (5.0, 2.0, 3.0, 0.7, 0.0, 0.0))
    forces = fe.blocks[0].section_forces(field)[..., 0]
    x = np.linspace(0, 1, 5)
    for end in (0, 1):
        at = x[end : end + 4]
        expected = np.stack([0 * at + 5, 0 * at + 2, 0 * at + 3, 0 * at + 0.7, -3 * (1 - at), 2 * (1 - at)], axis=1)
        np.testing.assert_allclose(forces[:, end], expected, atol=1e-9)
    stress = fe.blocks[0].fibre_stress(field, (0.01, -0.005))[0, 0, 0]
    # N / A - M_z y / I_z + M_y z / I_y
    expected = 5 / SECTION.area - 2 * 0.01 / SECTION.inertia_z + (-3) * -0.005 / SECTION.inertia_y
    assert stress == pytest.approx(expected, rel=1e-9)
    assert np.isnan(fe.blocks[0].nodal_stress(field[..., None])).all()


def test_fibre_stress_refers_to_the_line_of_nodes():
    """An axial force through an eccentric area centre gives N / A in every fibre."""
    fe = fem.with_supports(fem.frame(straight(1), section=OFFSET, material=STEEL), "start")
    y, z = OFFSET.area_center
    field = solve(fe, 1, (100.0, 0, 0, 0, 100.0 * z, -100.0 * y))
    for fibre in ((0.0, 0.0), (0.03, -0.05)):
        np.testing.assert_allclose(fe.blocks[0].fibre_stress(field, fibre), 100.0 / OFFSET.area, rtol=1e-9)


def test_fibre_stress_of_a_tapered_beam():
    """N / A of the section at each end of each beam."""
    thick, thin = Section.rectangle(0.2, 0.1), Section.rectangle(0.1, 0.1)
    fe = fem.with_supports(fem.frame(straight(4), section=[thick, thin], material=STEEL), "start")
    stress = fe.blocks[0].fibre_stress(solve(fe, 4, (100.0, 0, 0, 0, 0, 0)), (0.0, 0.0))
    areas = 0.1 * np.linspace(0.2, 0.1, 5)
    np.testing.assert_allclose(stress[:, :, 0], 100.0 / np.column_stack([areas[:-1], areas[1:]]), rtol=1e-9)


def test_lumped_mass_converges_to_the_consistent_frequencies():
    first = []
    for lumped in (False, True):
        fe = fem.frame(straight(40), section=SECTION, material=STEEL, lumped=lumped)
        mass = fe.rigid_motions().T @ fe.M @ fe.rigid_motions()
        assert mass[0, 0] == pytest.approx(STEEL.density * SECTION.area, rel=MACHINE)
        assert np.linalg.eigvalsh(fe.M.toarray())[0] > 0.0
        first.append(frequencies(fem.with_supports(fe, "start"), 3))
    np.testing.assert_allclose(first[1], first[0], rtol=2e-3)


@pytest.mark.parametrize(
    ("arguments", "found", "remedy"),
    [
        ({}, "neither points nor a mesh", "Give points"),
        ({"points": [(0, 0, 0)]}, "shape (1, 3)", "one row x, y, z"),
        ({"points": [(0, 0, 0), (1, 0, 0), (1, 0, 0)]}, "beam 1 between the nodes [1, 2]", "Merge"),
        ({"points": straight(2), "orientation": (1, 0, 0)}, "orientation of beam 0", "across the beam"),
        ({"points": straight(2), "connectivity": [(0, 3)]}, "node numbers 0..3", "start at 0"),
        ({"points": straight(3), "section": [SECTION] * 3}, "3 sections", "two for a taper"),
        (
            {"points": straight(3), "section": {"spar": SECTION}},
            "group 'spar' does not exist",
            "physical groups",
        ),
    ],
)
def test_messages(arguments, found, remedy):
    with pytest.raises(MeshError) as caught:
        fem.frame(**{"section": SECTION, "material": STEEL, **arguments})
    assert found in caught.value.found
    assert remedy in caught.value.remedy


def test_messages_of_meshes():
    triangle = Mesh(points=np.eye(3), cells=(("triangle", np.array([(0, 1, 2)])),))
    with pytest.raises(MeshError, match="1 triangle"):
        fem.frame(mesh=triangle, section=SECTION, material=STEEL)
    lines = Mesh(points=np.eye(3), cells=(("line", np.array([(0, 1), (1, 2)])),), cell_sets={"a": (np.array([0]),)})
    with pytest.raises(MeshError, match="beam 1 has no section"):
        fem.frame(mesh=lines, section={"a": SECTION}, material=STEEL)


def test_planar_beam_of_the_reduction_cases():
    """CB01 and CB02 use the textbook Hermite matrices (4 x 4, consistent mass): the frame has them in its
    bending plane."""
    from reduction.beams import planar_beam

    expected = planar_beam()
    fe = fem.frame(
        straight(20, 2.0), section=Section.rectangle(0.02, 0.04), material=STEEL, shear=False, rotary_inertia=False
    )
    planar = fem.with_supports(fe, directions=(0, 2, 3, 4))
    np.testing.assert_array_equal(planar.dofs, expected.dofs)
    for found, matrix in ((planar.K, expected.K), (planar.M, expected.M)):
        assert abs(found - matrix).max() < MACHINE * abs(matrix).max()
