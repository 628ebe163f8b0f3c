"""Meshes of MED files, written by meshio and by Gmsh."""

import h5py
import meshio
import numpy as np
import pytest

from flexmb import fem
from flexmb.errors import FlexmbError
from flexmb.fem.meshes.mesh import MeshWarning
from flexmb.model.material import MATERIALS

STEEL = MATERIALS["steel"]
POINTS = np.array([[x, y, z] for z in (0.0, 1.0) for y in (0.0, 1.0) for x in (0.0, 1.0, 2.0)])
HEXAHEDRA = np.array([[0, 1, 4, 3, 6, 7, 10, 9], [1, 2, 5, 4, 7, 8, 11, 10]])
STEP = "ENS_MAA/mesh/-0000000000000000001-0000000000000000001"


@pytest.fixture
def path(tmp_path):
    """Two cubes with one family each, quadrilaterals at both ends, two families of nodes."""
    mesh = meshio.Mesh(
        POINTS,
        [("hexahedron", HEXAHEDRA), ("quad", [[0, 3, 9, 6], [2, 5, 11, 8]])],
        point_data={"point_tags": np.array([1, 0, 2, 1, 0, 0, 0, 0, 0, 0, 0, 0])},
        cell_data={"cell_tags": [np.array([-1, -2]), np.array([-3, 0])]},
    )
    mesh.point_tags = {1: ["edge"], 2: ["edge", "corner"]}
    mesh.cell_tags = {-1: ["all", "west"], -2: ["all"], -3: ["fixed"]}
    target = tmp_path / "cubes.med"
    meshio.med.write(str(target), mesh)
    return target


def changed(path, change):
    with h5py.File(path, "r+") as file:
        change(file)
    return path


def test_cells_and_families_of_a_file_of_meshio(path):
    mesh = fem.read_mesh(path)
    assert {kind: cells.tolist() for kind, cells in mesh.cells} == {
        "hexahedron": HEXAHEDRA.tolist(),
        "quad": [[0, 3, 9, 6], [2, 5, 11, 8]],
    }
    np.testing.assert_array_equal(mesh.points, POINTS)
    assert mesh.node_sets["edge"].tolist() == [0, 2, 3]
    assert mesh.node_sets["corner"].tolist() == [2]
    assert mesh.node_sets["west"].tolist() == sorted(HEXAHEDRA[0])
    assert {name: [rows.tolist() for rows in mesh.cell_sets[name]] for name in ("all", "west", "fixed")} == {
        "all": [[0, 1], []],
        "west": [[0], []],
        "fixed": [[], [0]],
    }
    assert mesh.facet_sets["fixed"].tolist() == [[0, 3, 9, 6]]
    assert fem.solid(mesh, STEEL).M.sum() / 3.0 == pytest.approx(2.0 * STEEL.density, rel=1e-12)
    assert fem.read_mesh(path, scale=1e-3).points.max() == pytest.approx(2e-3)


def test_what_files_leave_out(path):
    """No families of a kind of cells, and a family without groups: both are usual."""

    def change(file):
        del file[f"{STEP}/MAI/QU4/FAM"]
        for family in file["FAS/mesh/ELEME"].values():
            if family.attrs["NUM"] == -2:
                del family["GRO"]

    mesh = fem.read_mesh(changed(path, change))
    assert [rows.tolist() for rows in mesh.cell_sets["all"]] == [[0], []]
    assert "fixed" not in mesh.node_sets


def test_units_of_the_axes(path):
    changed(path, lambda file: file["ENS_MAA/mesh"].attrs.create("UNI", np.bytes_(f"{'mm':16}" * 3)))
    assert fem.read_mesh(path).points.max() == pytest.approx(2e-3)
    changed(path, lambda file: file["ENS_MAA/mesh"].attrs.create("UNI", np.bytes_(f"{'inch':16}" * 3)))
    with pytest.warns(MeshWarning, match="the unit of its axes is 'inch inch inch'"):
        assert fem.read_mesh(path).points.max() == pytest.approx(2.0)


@pytest.mark.parametrize(
    ("match", "change"),
    [
        ("2 meshes: mesh, other", lambda file: file.copy("ENS_MAA/mesh", "ENS_MAA/other")),
        ("an HDF5 file with .*CHA", lambda file: file.move("ENS_MAA", "ELSE")),
        ("cells of the kind POG", lambda file: file.move(f"{STEP}/MAI/QU4", f"{STEP}/MAI/POG")),
        ("'pyramid'|pyramid cells", lambda file: file.move(f"{STEP}/MAI/QU4", f"{STEP}/MAI/PY5")),
        ("cylindrical coordinates", lambda file: file["ENS_MAA/mesh"].attrs.modify("REP", 1)),
        ("name the node 12", lambda file: file[f"{STEP}/MAI/HE8/NOD"].write_direct(np.full(16, 13))),
        ("is a link to another place", lambda file: file.__setitem__("x", h5py.ExternalLink("/etc/passwd", "/"))),
    ],
)
def test_what_cannot_be_read_is_named(path, match, change):
    with pytest.raises(FlexmbError, match=match):
        fem.read_mesh(changed(path, change))


def test_damaged_files_end_with_a_message(path):
    whole = path.read_bytes()
    for text in (b"", b"no HDF5 file", whole[: len(whole) // 2]):
        path.write_bytes(text)
        with pytest.raises(FlexmbError, match=r"cubes\.med"):
            fem.read_mesh(path)


@pytest.mark.parametrize("shape", ["tetrahedra", "hexahedra", "wedges"])
@pytest.mark.parametrize("order", [1, 2])
def test_the_same_mesh_as_msh_and_med_of_gmsh(tmp_path, order, shape):
    """Gmsh writes by the library of the format, whose solids turn the other way round."""
    gmsh = pytest.importorskip("gmsh")
    gmsh.initialize(interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.option.setNumber("Mesh.SecondOrderIncomplete", 1)
        gmsh.option.setNumber("Mesh.ElementOrder", order)
        gmsh.option.setNumber("Mesh.MeshSizeMin", 1.0)
        surface = gmsh.model.occ.addRectangle(0, 0, 0, 2, 1)
        layers = [] if shape == "tetrahedra" else [2]
        made = gmsh.model.occ.extrude([(2, surface)], 0, 0, 1, layers, recombine=bool(layers))
        gmsh.model.occ.synchronize()
        if shape == "hexahedra":
            gmsh.model.mesh.setTransfiniteSurface(surface)
            gmsh.model.mesh.setRecombine(2, surface)
        box = next(tag for dimension, tag in made if dimension == 3)
        gmsh.model.addPhysicalGroup(3, [box], name="block")
        gmsh.model.addPhysicalGroup(2, [surface], name="floor")
        gmsh.model.addPhysicalGroup(2, [surface, made[0][1]], name="ends")
        gmsh.model.mesh.generate(3)
        for suffix in ("msh", "med"):
            gmsh.write(str(tmp_path / f"box.{suffix}"))
    finally:
        gmsh.finalize()
    expected, found = (fem.read_mesh(tmp_path / f"box.{suffix}") for suffix in ("msh", "med"))
    kinds = {"tetrahedra": "tetra", "hexahedra": "hexahedron", "wedges": "wedge"}
    assert any(kind.startswith(kinds[shape]) for kind, _ in found.cells)
    a, b = fem.solid(expected, STEEL), fem.solid(found, STEEL)
    assert abs(a.K - b.K).max() < 1e-12 * abs(a.K).max()
    assert abs(a.M - b.M).max() < 1e-12 * abs(a.M).max()
    for name in ("block", "floor", "ends"):
        assert found.node_sets[name].tolist() == expected.node_sets[name].tolist()
    assert np.allclose(fem.pressure_load(a, "floor"), fem.pressure_load(b, "floor"))
