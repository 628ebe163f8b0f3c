"""What `fem.solid`, the loads and the solvers say about wrong input."""

from dataclasses import replace

import numpy as np
import pytest
from fem.structured import structured

from flexmb import fem
from flexmb.errors import MeshError, ModelError
from flexmb.model.material import MATERIALS
from flexmb.model.orthotropic_material import OrthotropicMaterial

STEEL = MATERIALS["steel"]


def changed(mesh, **fields):
    return replace(mesh, **fields)


def test_no_solids():
    shell = fem.Mesh(points=np.eye(3), cells=(("triangle", np.array([[0, 1, 2]])),), name="skin")
    with pytest.raises(MeshError, match=r"Mesh 'skin': no solid cells, but 1 triangle\..*use fem\.shell"):
        fem.solid(shell, STEEL)
    with pytest.raises(MeshError, match="no cells at all"):
        fem.solid(fem.Mesh(points=np.eye(3), cells=()), STEEL)


def test_folded_cells():
    mesh = structured("hexahedron", (2, 2, 2))
    points = mesh.points.copy()
    center = np.flatnonzero(np.isclose(points, 0.5).all(axis=1))
    points[center] += 0.45
    with pytest.raises(MeshError, match=r"1 of 8 hexahedron cells are inverted or flat .* the first is number 7 "):
        fem.solid(changed(mesh, points=points), STEEL)


def test_flat_cells():
    mesh = structured("tetra10", (1, 1, 1))
    with pytest.raises(MeshError, match="6 of 6 tetra10 cells are inverted or flat"):
        fem.solid(changed(mesh, points=mesh.points * [1.0, 1.0, 0.0]), STEEL)


@pytest.mark.parametrize("cell_type", ["tetra10", "hexahedron27", "wedge15"])
def test_left_handed_cells_are_renumbered(cell_type):
    """A mirrored mesh: same stiffness as the mirror image of the right-handed one."""
    mesh = structured(cell_type, (1, 2, 1), skew=0.1)
    mirrored = changed(mesh, points=mesh.points * [1.0, 1.0, -1.0])
    with pytest.warns(fem.MeshWarning, match="numbered left-handed"):
        fe = fem.solid(mirrored, STEEL)
    flip = np.tile([1.0, 1.0, -1.0], len(mesh.points))
    expected = fem.solid(mesh, STEEL).K.multiply(np.outer(flip, flip))
    assert abs(fe.K - expected).max() < 1e-11 * abs(expected).max()
    assert fem.pressure_load(fe, "z0").reshape(-1, 3).sum(axis=0) == pytest.approx([0.0, 0.0, -1.0])


def test_some_left_handed_tetrahedra_are_renumbered():
    """scikit-fem and some mesh generators sort node numbers: half of the cells are then left-handed."""
    mesh = structured("tetra10", (2, 2, 2))
    mixed = mesh.cells[0][1].copy()
    mixed[::2] = mixed[::2][:, [0, 2, 1, 3, 6, 5, 4, 7, 9, 8]]
    fe = fem.solid(changed(mesh, cells=(("tetra10", mixed),)), STEEL)
    assert abs(fe.K - fem.solid(mesh, STEEL).K).max() < 1e-3


def test_a_tetrahedron_turned_inside_out():
    """A node pushed through the opposite face: mirroring would hide that the cell covers its neighbour."""
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 1]], float)
    cells = np.array([[0, 1, 2, 3], [1, 2, 3, 4]])
    good = fem.Mesh(points=points, cells=(("tetra", cells),))
    with pytest.warns(fem.MeshWarning):
        fem.solid(good, STEEL)
    points[4] = [0.2, 0.2, 0.2]
    with pytest.raises(MeshError, match=r"1 of 2 tetra cells are inverted or flat .* number 1 "):
        fem.solid(changed(good, points=points), STEEL)


def test_materials_by_set():
    mesh = changed(structured("hexahedron20", (2, 1, 1)), cell_sets={"left": (np.array([0]),), "all": (np.arange(2),)})
    with pytest.raises(MeshError, match=r"1 hexahedron20 cells have no material, the first is number 1 .*all, left"):
        fem.solid(mesh, {"left": STEEL})
    with pytest.raises(MeshError, match=r"1 hexahedron20 cells have several materials, the first is number 0 "):
        fem.solid(mesh, {"left": STEEL, "all": STEEL})
    with pytest.raises(MeshError, match=r"'lft', which does not exist.*Did you mean 'left'"):
        fem.solid(mesh, {"lft": STEEL})


@pytest.mark.parametrize(("cell_type", "better"), [("tetra", "tetra10"), ("wedge", "wedge15")])
def test_stiff_elements_are_reported(cell_type, better):
    with pytest.warns(fem.MeshWarning, match=f"first order are far too stiff in bending; use {better}"):
        fem.solid(structured(cell_type, (1, 1, 1)), STEEL)


def test_separate_pieces_are_reported():
    block = structured("tetra10", (1, 1, 1))
    cells = block.cells[0][1]
    two = fem.Mesh(
        points=np.vstack([block.points, block.points + 3.0]),
        cells=(("tetra10", np.vstack([cells, cells + len(block.points)])),),
        name="two",
    )
    with pytest.warns(fem.MeshWarning, match="Mesh 'two': the solid cells form 2 separate pieces of 27, 27 nodes"):
        fem.solid(two, STEEL)


def test_supports_and_loads():
    fe = fem.solid(structured("tetra10", (1, 1, 1)), STEEL)
    load = np.zeros(fe.ndof)
    with pytest.raises(MeshError, match=r"singular stiffness matrix of 81 free freedoms.*Fix more nodes"):
        fem.static(fe, load, None)
    with pytest.raises(MeshError, match="singular stiffness"):
        fem.static(fe, load, {"x0": "x"})
    with pytest.raises(MeshError, match=r"set 'x0': directions 'xq'.*x y z rx ry rz"):
        fem.fixed_freedoms(fe, {"x0": "xq"})
    with pytest.raises(MeshError, match=r"mask of the shape \(3,\)"):
        fem.fixed_freedoms(fe, np.zeros(3, bool))
    with pytest.raises(MeshError, match=r"node 99 does not exist.*0 to 26"):
        fem.fixed_freedoms(fe, [99])
    with pytest.raises(MeshError, match=r"facet set 'x00' does not exist.*Did you mean 'x0'"):
        fem.pressure_load(fe, "x00")
    bare = fem.FEModel(nodes=fe.nodes, dofs=fe.dofs, K=fe.K, M=fe.M, name="bare")
    with pytest.raises(MeshError, match="FE model 'bare': no element blocks"):
        fem.buckling(bare, load, [0])


@pytest.mark.parametrize("entry", [1e300, np.inf, np.nan])
@pytest.mark.parametrize(("symbol", "what"), [("K", "stiffness"), ("M", "mass")])
def test_entries_whose_products_overflow_are_refused_by_node(symbol, what, entry):
    fe = fem.solid(structured("tetra10", (1, 1, 1)), STEEL)
    matrix = getattr(fe, symbol).copy()
    matrix[31, 31] = entry  # one row per direction: node 10
    with pytest.raises(MeshError, match=r"at node 10, \(.*\) m.*up to 1e\+60") as refused:
        replace(fe, **{symbol: matrix})
    assert f"a {what} of {entry:.3g}" in str(refused.value)


@pytest.mark.parametrize(
    ("change", "text"),
    [
        ({"young": (1.0, -1.0, 1.0)}, r"young = \(1\.0, -1\.0, 1\.0\) Pa"),
        ({"shear": (1.0, 1.0)}, "three positive numbers"),
        ({"density": 0.0}, "density = 0.0 kg/m3"),
        ({"poisson": (0.9, 0.9, 0.9)}, "strain energy negative.*nu_12"),
    ],
)
def test_orthotropic_material_is_checked(change, text):
    good = {"young": (1.0,) * 3, "poisson": (0.3,) * 3, "shear": (0.4,) * 3, "density": 1.0}
    OrthotropicMaterial(**good)
    with pytest.raises(ModelError, match=text):
        OrthotropicMaterial(**{**good, **change})
