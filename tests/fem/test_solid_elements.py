"""Every solid element: patch test, rigid motions, mass properties, stress, geometric stiffness, buckled modes."""

import numpy as np
import pytest
from fem.structured import CELL_TYPES, QUADRATIC, skin_nodes, structured
from tolerances import MACHINE, SOLVER

from flexmb import fem
from flexmb.model.material import Material
from flexmb.model.orthotropic_material import OrthotropicMaterial

pytestmark = pytest.mark.filterwarnings("ignore::flexmb.fem.meshes.mesh.MeshWarning")

MATERIAL = Material(young=2.0, poisson=0.3, density=3.0)
PLY = OrthotropicMaterial(
    young=(20.0, 3.0, 2.0), poisson=(0.3, 0.35, 0.25), shear=(1.2, 0.7, 0.9), density=3.0, rotation=(0.3, -0.5, 0.8)
)
GRADIENT = np.array([[0.3, -0.2, 0.5], [0.1, 0.4, -0.6], [0.25, 0.7, -0.1]])
STRAIN = np.array(
    [
        GRADIENT[0, 0],
        GRADIENT[1, 1],
        GRADIENT[2, 2],
        GRADIENT[0, 1] + GRADIENT[1, 0],
        GRADIENT[1, 2] + GRADIENT[2, 1],
        GRADIENT[2, 0] + GRADIENT[0, 2],
    ]
)


@pytest.mark.parametrize("material", [MATERIAL, PLY], ids=["isotropic", "orthotropic"])
@pytest.mark.parametrize("cell_type", CELL_TYPES)
def test_patch(cell_type, material):
    """A linear displacement on the surface of a distorted patch is the solution inside, with constant stress."""
    mesh = structured(cell_type, (3, 3, 3), (1.0, 2.0, 3.0), skew=0.2)
    fe = fem.solid(mesh, material)
    exact = (mesh.points @ GRADIENT.T).ravel()
    held = fem.fixed_freedoms(fe, skin_nodes(mesh))
    assert not held.all()
    u = np.where(held, exact, 0.0)
    u[~held] = fem.static(fe, -fe.K @ u, held)[~held]
    assert np.abs(u - exact).max() < 100 * MACHINE
    stress = fe.blocks[0].nodal_stress(fe.field(u))[:, :, 0]
    assert np.abs(stress - material.elasticity @ STRAIN).max() < 1000 * MACHINE


@pytest.mark.parametrize("cell_type", CELL_TYPES)
def test_six_rigid_motions_and_no_seventh(cell_type):
    fe = fem.solid(structured(cell_type, (1, 1, 1), skew=0.0), MATERIAL)
    assert np.abs(fe.K @ fe.rigid_motions()).max() < MACHINE * abs(fe.K).max() * 10
    values = np.linalg.eigvalsh(fe.K.toarray())
    assert values[5] < MACHINE * values[-1]
    assert values[6] > 1e-4 * values[-1]
    assert abs(fe.K - fe.K.T).max() == 0.0


@pytest.mark.parametrize("cell_type", CELL_TYPES)
@pytest.mark.parametrize("lumped", [False, True])
def test_mass_and_inertia_of_a_block(cell_type, lumped):
    """Mass 18 kg of a block 1 x 2 x 3 m; centre of mass and inertia exact with the consistent mass."""
    fe = fem.solid(structured(cell_type, (2, 2, 3), (1.0, 2.0, 3.0)), MATERIAL, lumped=lumped)
    motions = fe.rigid_motions()
    body = motions.T @ (fe.M @ motions)
    assert body[:3, :3] == pytest.approx(18.0 * np.eye(3), abs=1e-11)
    if lumped:
        assert fe.M.nnz == fe.ndof
        assert fe.M.diagonal().min() > 0.0
    else:
        assert body[5, 1] == pytest.approx(18.0 * 0.5, rel=MACHINE * 10)
        assert np.diag(body)[3:] == pytest.approx(18.0 * np.array([13.0, 10.0, 5.0]) / 3.0, rel=MACHINE * 10)


@pytest.mark.parametrize("cell_type", QUADRATIC)
def test_linear_stress_is_exact_at_the_nodes(cell_type):
    """Pure bending: u_x = x y, u_y = -(x^2 + nu y^2 - nu z^2) / 2, u_z = -nu y z gives stress_xx = E y alone."""
    mesh = structured(cell_type, (2, 2, 2), (1.0, 2.0, 1.0))
    fe = fem.solid(mesh, MATERIAL)
    (x, y, z), nu = mesh.points.T, MATERIAL.poisson
    u = np.column_stack([x * y, -(x**2 + nu * y**2 - nu * z**2) / 2, -nu * y * z]).ravel()
    stress = fe.blocks[0].nodal_stress(fe.field(np.column_stack([u, 2 * u])))
    exact = np.zeros((len(x), 6))
    exact[:, 0] = MATERIAL.young * y
    assert np.abs(stress[:, :, 0] - exact).max() < 1e-11
    assert np.abs(stress[:, :, 1] - 2 * exact).max() < 1e-11
    (block,) = fe.blocks
    cells = np.array([3, 0])
    single = block.element_stress(fe.field(u), cells)[..., 0]
    assert np.abs(single - exact[block.connectivity[cells]]).max() < 1e-11


@pytest.mark.parametrize("cell_type", CELL_TYPES)
def test_projected_geometric_stiffness_equals_the_assembled_one(cell_type, rng):
    fe = fem.solid(structured(cell_type, (2, 2, 2), skew=0.2), MATERIAL)
    (block,) = fe.blocks
    loads, modes = rng.standard_normal((fe.ndof, 4)), rng.standard_normal((fe.ndof, 5))
    found = block.projected_geometric_stiffness(fe.field(loads), fe.field(modes))
    for k in range(4):
        kg = block.geometric_stiffness(fe.field(loads)[:, :, k], fe.dofs)
        reference = modes.T @ (kg @ modes)
        assert np.abs(found[k] - reference).max() < 10 * MACHINE * np.abs(reference).max()


@pytest.mark.parametrize("cell_type", CELL_TYPES)
def test_geometric_stiffness_of_uniform_tension(cell_type):
    """Rotation by the small angle a about z under the stress s along x: energy 1/2 s a^2 V."""
    fe = fem.solid(structured(cell_type, (2, 2, 2), (1.0, 2.0, 3.0), skew=0.2), MATERIAL)
    nu, stress = MATERIAL.poisson, 0.7
    pull = fe.nodes * (stress / MATERIAL.young) * np.array([1.0, -nu, -nu])
    kg = fe.blocks[0].geometric_stiffness(np.hstack([pull, np.zeros_like(pull)]), fe.dofs)
    turn = fe.rigid_motions()
    assert turn[:, 5] @ (kg @ turn[:, 5]) == pytest.approx(stress * 6.0, rel=100 * MACHINE)
    assert turn[:, 3] @ (kg @ turn[:, 3]) == pytest.approx(0.0, abs=100 * MACHINE)
    assert np.abs(kg @ turn[:, :3]).max() < 100 * MACHINE


def test_geometric_stiffness_follows_the_numbering_of_the_model(rng):
    """Freedoms may be shuffled and may contain rotations of other elements."""
    fe = fem.solid(structured("tetra10", (1, 1, 1)), MATERIAL)
    u = rng.standard_normal(fe.ndof)
    plain = fe.blocks[0].geometric_stiffness(fe.field(u)[:, :, 0], fe.dofs).toarray()
    order = rng.permutation(fe.ndof)
    dofs = np.vstack([[[0, 3], [0, 4]], fe.dofs[order]])
    mixed = fe.blocks[0].geometric_stiffness(fe.field(u)[:, :, 0], dofs).toarray()
    assert mixed[2:, 2:] == pytest.approx(plain[np.ix_(order, order)])
    assert np.abs(mixed[:2]).max() == 0.0


def test_tetrahedra_and_hexahedra_in_one_mesh():
    """Linear hexahedra beside wedges over a common face: the patch test holds across the kinds."""
    left, right = structured("hexahedron", (1, 2, 2)), structured("wedge", (1, 2, 2))
    shifted = right.points + [1.0, 0.0, 0.0]
    points = np.vstack([left.points, shifted])
    _, first, number = np.unique(np.round(points, 9), axis=0, return_index=True, return_inverse=True)
    cells = (("hexahedron", number[left.cells[0][1]]), ("wedge", number[right.cells[0][1] + len(left.points)]))
    mesh = fem.Mesh(points=points[first], cells=cells)
    fe = fem.solid(mesh, MATERIAL)
    exact = (mesh.points @ GRADIENT.T).ravel()
    held = fem.fixed_freedoms(
        fe,
        np.flatnonzero(
            (np.abs(mesh.points - [1.0, 0.5, 0.5]) > 0.4).any(axis=1)
            & ~np.isclose(mesh.points, [1.0, 0.5, 0.5]).all(axis=1)
        ),
    )
    u = np.where(held, exact, 0.0)
    u[~held] = fem.static(fe, -fe.K @ u, held)[~held]
    assert np.abs(u - exact).max() < 100 * MACHINE
    stress = [block.nodal_stress(fe.field(u)) for block in fe.blocks]
    assert np.isnan(stress[0]).any()  # nodes of the other block
    assert np.nanmean(np.stack(stress), axis=0)[:, :, 0] == pytest.approx(
        np.tile(MATERIAL.elasticity @ STRAIN, (len(fe.nodes), 1)), abs=1e-10
    )


def test_two_materials_by_cell_set():
    """Springs in series: equal bars of E = 1 and E = 3 (nu = 0) under unit stress lengthen by 1 + 1/3."""
    mesh = structured("hexahedron20", (2, 1, 1), (2.0, 1.0, 1.0))
    left = fem.Mesh(
        points=mesh.points,
        cells=mesh.cells,
        node_sets=mesh.node_sets,
        cell_sets={"soft": (np.array([0]),), "hard": (np.array([1]),)},
    )
    soft, hard = (Material(young=e, poisson=0.0, density=e) for e in (1.0, 3.0))
    fe = fem.solid(left, {"soft": soft, "hard": hard})
    assert fe.M.sum() / 3 == pytest.approx(4.0)
    u = fem.static(fe, fem.traction_load(fe, "x1", (1.0, 0.0, 0.0)), "x0").reshape(-1, 3)
    assert u[left.node_sets["x1"], 0] == pytest.approx(4.0 / 3.0, rel=SOLVER)


def test_off_axis_modulus_of_a_ply():
    """Jones, Mechanics of Composite Materials, eq. (2.97): 1/E_x = c^4/E1 + (1/G12 - 2 nu12/E1) s^2 c^2 + s^4/E2."""
    angle = np.radians(30.0)
    ply = OrthotropicMaterial(
        young=(135e9, 10e9, 10e9),
        poisson=(0.3, 0.4, 0.3),
        shear=(5e9, 3.5e9, 5e9),
        density=1600.0,
        rotation=(0.0, 0.0, angle),
    )
    c, s = np.cos(angle), np.sin(angle)
    exact = 1.0 / (c**4 / 135e9 + (1 / 5e9 - 2 * 0.3 / 135e9) * s**2 * c**2 + s**4 / 10e9)
    assert 1.0 / np.linalg.inv(ply.elasticity)[0, 0] == pytest.approx(exact, rel=MACHINE * 10)


def test_orthotropic_with_equal_axes_is_isotropic():
    """Whatever the rotation."""
    e, nu = 2.0, 0.3
    same = OrthotropicMaterial(
        young=(e,) * 3, poisson=(nu,) * 3, shear=(e / 2 / (1 + nu),) * 3, density=1.0, rotation=(0.4, -1.0, 2.0)
    )
    assert same.elasticity == pytest.approx(MATERIAL.elasticity, abs=MACHINE * 10)


@pytest.mark.parametrize("cell_type", CELL_TYPES)
def test_pressure_and_facets(cell_type):
    """Closed surface: no resultant. One side: area times pressure, against the outward normal."""
    fe = fem.solid(structured(cell_type, (2, 2, 2), (1.0, 2.0, 3.0), skew=0.2), MATERIAL)
    force = np.array([fem.pressure_load(fe, f"{a}{i}", 2.0).reshape(-1, 3).sum(axis=0) for a in "xyz" for i in (0, 1)])
    exact = np.kron(np.diag([6.0, 3.0, 2.0]), [[2.0], [-2.0]])
    assert np.abs(force - exact).max() < 100 * MACHINE
    shear = fem.traction_load(fe, "z1", (1.0, -2.0, 0.5)).reshape(-1, 3).sum(axis=0)
    assert shear == pytest.approx([2.0, -4.0, 1.0])


def test_static_accepts_many_loads_and_eigenmodes_are_orthonormal():
    fe = fem.solid(structured("tetra10", (2, 2, 2)), MATERIAL)
    loads = np.column_stack([fem.traction_load(fe, "x1", t) for t in np.eye(3)])
    u = fem.static(fe, loads, "x0")
    assert np.abs(u[:, 1] - fem.static(fe, loads[:, 1], "x0")).max() < SOLVER
    modes = fem.eigenmodes(fe, n=9)
    assert modes.shapes.T @ (fe.M @ modes.shapes) == pytest.approx(np.eye(9), abs=1e-8)
    assert modes.frequencies[5] < 1e-3 * modes.frequencies[6]


@pytest.mark.parametrize(("elements", "low", "high"), [(None, 0.91, 1.0), ({"wedge": fem.WEDGE6_COMPATIBLE}, 0.6, 0.7)])
def test_wedges_bend_out_of_the_plane_of_their_triangles(elements, low, high):
    """A cantilever of one layer of wedges, 20 along it: 0.926 of Timoshenko's tip deflection, plain ones 0.658."""
    mesh = structured("wedge", (20, 1, 1), (1.0, 0.05, 0.05))
    fe = fem.solid(mesh, Material(young=210e9, poisson=0.3, density=7850.0), elements=elements)
    tip = np.flatnonzero(fe.nodes[:, 0] > 1.0 - 1e-9)
    load = np.zeros((len(fe.nodes), 6, 1))
    load[tip, 2, 0] = 1000.0 / len(tip)
    u = fe.field(fem.static(fe, fe.forces(load)[:, 0], np.flatnonzero(fe.nodes[:, 0] < 1e-9)))[tip, 2, 0].mean()
    exact = 1000.0 / (3 * 210e9 * 0.05**4 / 12) + 1000.0 / (5 / 6 * 210e9 / 2.6 * 0.05**2)
    assert low < u / exact < high
