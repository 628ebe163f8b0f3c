"""Mesh files of every format: the same part gives the same model; groups; every message."""

import re
import tracemalloc
import warnings
from pathlib import Path

import meshio
import numpy as np
import pytest
from fem.structured import structured

from flexmb import fem
from flexmb.errors import MeshError
from flexmb.model.material import MATERIALS

MESHES = Path(__file__).parents[2] / "meshes"
SMALL = Path(__file__).parents[1] / "data" / "mesh"
PARTS = ("lever_arm", "conrod", "bracket_hex8", "bracket_hex20")
STEEL = MATERIALS["steel"]


@pytest.fixture
def write(tmp_path):
    """``write("a.bdf", text)`` writes a file and returns its path."""

    def to_file(name, text):
        path = tmp_path / name
        path.write_text(text)
        return path

    return to_file


@pytest.mark.parametrize("part", PARTS)
def test_three_formats_give_the_same_model(part):
    """Gmsh, Nastran (ten digits) and Abaqus files of one part: same nodes, cells, groups, matrices."""
    gmsh, *others = (fem.read_mesh(MESHES / f"{part}{suffix}") for suffix in (".msh", ".bdf", ".inp"))
    reference = fem.solid(gmsh, STEEL)
    for mesh in others:
        assert mesh.points == pytest.approx(gmsh.points, abs=1e-9)
        assert {k: v.tolist() for k, v in mesh.node_sets.items()} == {k: v.tolist() for k, v in gmsh.node_sets.items()}
        fe = fem.solid(mesh, STEEL)
        assert abs(fe.K - reference.K).max() < 1e-7 * abs(reference.K).max()
        assert abs(fe.M - reference.M).max() < 1e-7 * abs(reference.M).max()
        assert set(fe.facet_sets) == set(reference.facet_sets)
        assert fe.facet_sets
        for name, facets in fe.facet_sets.items():
            expected = reference.facet_sets[name]
            assert {frozenset(f) for f in facets.tolist()} == {frozenset(f) for f in expected.tolist()}
            force = fem.pressure_load(reference, name) - fem.pressure_load(fe, name)
            assert np.abs(force).max() < 1e-9


@pytest.mark.parametrize(
    ("part", "mass", "material"),
    [("lever_arm", 24.0, "titanium"), ("conrod", 1.310, "steel"), ("bracket_hex20", 1.006, "steel")],
)
def test_parts_weigh_what_the_table_says(part, mass, material):
    fe = fem.solid(fem.read_mesh(MESHES / f"{part}.msh"), MATERIALS[material])
    assert fe.M.sum() / 3.0 == pytest.approx(mass, rel=5e-4)
    motions = fe.rigid_motions()
    assert np.abs(fe.K @ motions).max() < 1e-9 * abs(fe.K).max()


def test_bores_are_where_the_table_says():
    mesh = fem.read_mesh(MESHES / "lever_arm.msh")
    for name, x, radius in (("bore_root", 0.0, 0.045), ("bore_tip", 0.60, 0.025)):
        bore = mesh.points[mesh.node_sets[name]]
        assert np.hypot(bore[:, 0] - x, bore[:, 2]) == pytest.approx(radius, rel=2e-3)  # mid-side nodes of the mesh
    (mid,) = mesh.node_sets["mid"]
    assert mesh.points[mid] == pytest.approx([0.30, 0.0, 0.0], abs=1e-12)


@pytest.mark.parametrize(
    ("file", "cell_type"),
    [
        ("wedge15.msh", "wedge15"),
        ("wedge15.inp", "wedge15"),
        ("wedge15.bdf", "wedge15"),
        ("hexahedron20.msh", "hexahedron20"),
        ("hexahedron27.msh", "hexahedron27"),
    ],
)
def test_node_order_of_second_order_cells(file, cell_type):
    """Files written by Gmsh: each node lies where the reference cell has it, and a unit cube weighs 7850 kg."""
    mesh = fem.read_mesh(SMALL / file)
    from flexmb.fem.solids.elements import SOLID_ELEMENTS, shape_functions

    element = SOLID_ELEMENTS[cell_type]
    linear = SOLID_ELEMENTS[element.family]
    weights = shape_functions(linear, element.nodes)[0]
    for row in mesh.cells_of(cell_type):
        assert weights @ mesh.points[row[: len(element.corners)]] == pytest.approx(mesh.points[row], abs=1e-6)
    assert fem.solid(mesh, STEEL).M.sum() / 3 == pytest.approx(7850.0)


def test_gmsh_groups_of_every_dimension():
    mesh = fem.read_mesh(SMALL / "hexahedron27.msh")
    assert {name: len(nodes) for name, nodes in mesh.node_sets.items()} == {
        "corner": 1,
        "edge": 3,
        "bottom": 9,
        "surface_3": 9,
        "block": 27,
    }
    assert mesh.facet_sets["bottom"].shape == (1, 9)
    assert mesh.points[mesh.node_sets["corner"]] == pytest.approx(np.zeros((1, 3)))
    assert [len(rows) for rows in mesh.cell_set("edge")] == [1, 0, 0]
    assert fem.read_mesh(SMALL / "wedge15.msh").node_sets.keys() == mesh.node_sets.keys()  # version 2.2


def test_groups_written_by_gmsh_for_abaqus():
    mesh = fem.read_mesh(SMALL / "wedge15.inp")
    assert len(mesh.node_sets["corner"]) == 1
    assert len(mesh.node_sets["bottom"]) == 9
    assert sum(len(rows) for rows in mesh.cell_set("block")) == 2
    (line,) = mesh.cells_of("line3")
    assert mesh.points[line[2]] == pytest.approx(mesh.points[line[:2]].mean(axis=0))  # middle node last


def test_vtu_arrays_become_sets(tmp_path):
    """Arrays of 0 and 1 are sets; other integer arrays one set per value; real arrays are results."""
    block = structured("tetra10", (1, 1, 1))
    path = tmp_path / "block.vtu"
    at_foot = np.zeros(len(block.points), np.int32)
    at_foot[block.node_sets["z0"]] = 1
    meshio.Mesh(
        block.points,
        [("tetra10", block.cells[0][1])],
        point_data={"foot": at_foot, "temperature": np.linspace(0, 1, len(at_foot))},
        cell_data={"core": [np.array([1, 0, 0, 0, 0, 1])], "layer": [np.array([3, 3, 5, 5, 5, 5])]},
    ).write(path)
    mesh = fem.read_mesh(path)
    assert np.array_equal(mesh.node_sets["foot"], block.node_sets["z0"])
    assert "temperature" not in mesh.node_sets
    assert mesh.cell_set("core")[0].tolist() == [0, 5]
    assert mesh.cell_set("layer_3")[0].tolist() == [0, 1]
    assert fem.solid(mesh, STEEL).facet_sets["foot"].shape == (2, 6)


NASTRAN = """SOL 101
CEND
$HMSET        1        1 "foot of it"
SET 1 = 1, 2 THRU 8 EXCEPT 5, 6,
        7, 8
$HMSET        2        2 "bar"
SET 2 = 100
$HMNAME PROP       7"brick"
BEGIN BULK
GRID,1,,0.,0.,0.
GRID,2,,1.,0.,0.
GRID     3              1.      1.      0.
grid*                  4                              0.              1.
*                     0.
GRID,5,,0.,0.,1.
GRID,6,,1.,0.,1.
GRID,7,,1.,1.,1.
GRID,8,,0.,1.,1.
GRID,99,,5.,5.,5.
CHEXA   100     7       1       2       3       4       5       6       +
+       7       8
SET3,4,GRID,5,THRU,7
SET1    5       1       2       3       4       5       6       7
        8
PSOLID,7,1
"""


def test_nastran_sets_names_and_formats(write):
    """Free, small and large field; SET, SET1, SET3; no ENDDATA; an unused grid point."""
    mesh = fem.read_mesh(write("a.bdf", NASTRAN))
    assert len(mesh.points) == 8
    assert {name: nodes.tolist() for name, nodes in mesh.node_sets.items()} == {
        "foot of it": [0, 1, 2, 3],
        "set_4": [4, 5, 6],
        "set_5": list(range(8)),
        "bar": list(range(8)),
        "brick": list(range(8)),
    }
    assert mesh.cell_set("bar")[0].tolist() == mesh.cell_set("brick")[0].tolist() == [0]
    assert fem.solid(mesh, STEEL).facet_sets["foot of it"].tolist() == [[0, 3, 2, 1]]


def test_long_ranges_of_nastran_sets_cost_nothing(write):
    """THRU 99999999 means all, many times over; a set that leaves the numbers of a file is refused by its name."""
    text = NASTRAN.replace("SET3,4,GRID,5,THRU,7", "SET3,4,GRID,5,THRU,99999999,1,THRU,99999999,1,THRU,99999999")
    tracemalloc.start()
    mesh = fem.read_mesh(write("a.bdf", text))
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert mesh.node_sets["set_4"].tolist() == list(range(8))
    assert peak < 20e6
    for members in ("5,THRU,9999999999999999", "7,THRU,5", "0,5", "99999999999999999999"):
        with pytest.raises(MeshError, match=r"set 'set_4' reads .* Expected: numbers from 1 to 9{15}, ascending"):
            fem.read_mesh(write("b.bdf", NASTRAN.replace("GRID,5,THRU,7", f"GRID,{members}")))


ABAQUS = """*HEADING
two bricks
*Node, nset=all
1, 0., 0., 0.
2, 1., 0., 0.
3, 1., 1., 0.
4, 0., 1., 0.
5, 0., 0., 1.
6, 1., 0., 1.
7, 1., 1., 1.
8, 0., 1., 1.
9, 0., 0., 2.
10, 1., 0., 2.
11, 1., 1., 2.
12, 0., 1., 2.
*Element, type=C3D8R, elset=lower
1, 1, 2, 3, 4, 5, 6, 7, 8
*Element, type=C3D8RH
5, 5, 6, 7, 8,
9, 10, 11, 12
*Elset, elset=upper
5
*Elset, elset=both
lower, upper
*Nset, nset=foot, generate
1, 3, 1
*Nset, nset=FOOT
4
*Surface, type=ELEMENT, name=top
upper, S2
5, S3
"""


def test_abaqus_sets_and_surfaces(write):
    """Second definitions extend a set, sets of sets, generated sets, surfaces of element faces."""
    mesh = fem.read_mesh(write("a.inp", ABAQUS))
    assert mesh.node_sets["foot"].tolist() == [0, 1, 2, 3]
    assert len(mesh.node_sets["all"]) == 12
    assert [rows.tolist() for rows in mesh.cell_set("both")] == [[0, 1]]
    assert [rows.tolist() for rows in mesh.cell_set("lower")] == [[0]]
    top = fem.solid(mesh, STEEL).facet_sets["top"]
    assert sorted(map(sorted, top.tolist())) == [[4, 5, 8, 9], [8, 9, 10, 11]]
    soft = fem.solid(mesh, {"lower": STEEL, "upper": MATERIALS["aluminium"]})
    assert soft.M.sum() / 3 == pytest.approx(7850.0 + 2800.0)


def test_abaqus_include(write):
    write("grid.inp", ABAQUS)
    assert len(fem.read_mesh(write("a.inp", "*INCLUDE, INPUT=grid.inp\n")).points) == 12


def test_planar_meshes_get_z(write):
    mesh = fem.read_mesh(write("flat.inp", "*NODE\n1, 0., 0.\n2, 1., 0.\n3, 0., 1.\n*ELEMENT, TYPE=CPS3\n1, 1, 2, 3\n"))
    assert mesh.points.shape == (3, 3)


def assert_refused(path, *parts):
    with pytest.raises(MeshError) as caught:
        fem.read_mesh(path)
    for part in parts:
        assert re.search(part, str(caught.value)), str(caught.value)


def test_missing_file(tmp_path):
    (tmp_path / "conrod.msh").touch()
    assert_refused(tmp_path / "conrd.msh", "conrd.msh", "no such file", "Did you mean 'conrod.msh'")
    assert_refused(tmp_path / "nowhere" / "a.msh", "current folder")


def test_unknown_suffix(write):
    assert_refused(write("part.step", ""), "suffix '.step'", r"\.msh, \.bdf")


@pytest.mark.parametrize("suffix", [".msh", ".bdf", ".inp", ".vtu", ".vtk"])
def test_garbage(write, suffix):
    assert_refused(
        write(f"bad{suffix}", "this is\nnot a mesh, 1, 2\n"), f"bad{suffix}", "cannot be read|no cells|no \\*NODE"
    )


def test_truncated_file(tmp_path):
    path = tmp_path / "cut.msh"
    path.write_bytes((MESHES / "conrod.msh").read_bytes()[:50_000])
    assert_refused(path, "cannot be read", "write it again")


def test_unsupported_cells(write, tmp_path):
    assert_refused(write("a.inp", "*NODE\n1, 0., 0., 0.\n*ELEMENT, TYPE=AC3D8\n1, 1\n"), "'AC3D8'", "C3D10", "Delete")
    path = tmp_path / "pyramid.vtu"
    meshio.Mesh(np.eye(5, 3), [("pyramid", [[0, 1, 2, 3, 4]])]).write(path)
    assert_refused(path, "1 cells of the type 'pyramid'", "tetra10", "Mesh again")


@pytest.mark.parametrize(
    ("keyword", "name"),
    [
        ("*INSTANCE, NAME=a, PART=b\n0., 0., 1.\n", "INSTANCE"),
        ("*SYSTEM\n0., 0., 1.\n", "SYSTEM"),
        ("*NODE, SYSTEM=C\n50, 0., 0., 0.\n", "NODE"),
    ],
)
def test_moved_coordinates(write, keyword, name):
    assert_refused(write("a.inp", keyword + ABAQUS), rf"\*{name} moves or turns", "flat input file")


def test_parts_with_their_own_numbers(write):
    assert_refused(write("a.inp", ABAQUS + ABAQUS), "12 node numbers twice", "without parts and instances")


def test_half_an_element(write):
    assert_refused(write("a.inp", "*NODE\n1, 0., 0., 0.\n*ELEMENT, TYPE=C3D4\n1, 1, 1\n"), "3 numbers", "multiple of 5")


def test_unknown_set_in_a_set(write):
    assert_refused(write("a.inp", ABAQUS + "*NSET, NSET=x\nnope\n"), "unknown set 'nope'")


def test_set_of_missing_nodes(write):
    assert_refused(
        write("a.bdf", NASTRAN.replace("$HMSET        2        2", "$HMSET        2        1")),
        "'bar' names the node 100",
        "type 2",
    )


def test_set_that_is_no_list(write):
    assert_refused(
        write("a.bdf", NASTRAN.replace("SET 2 = 100", "SET 2 = ALL")), "'bar' reads 'ALL'", "list of numbers"
    )


def test_local_coordinate_systems(write):
    assert_refused(write("a.bdf", NASTRAN.replace("GRID,5,,", "GRID,5,3,")), "coordinate system 3", "basic system")


def test_gmsh_file_with_some_cells_in_no_group(tmp_path):
    """The same message as for a file saved with 'Save all elements'."""
    text = (SMALL / "hexahedron20.msh").read_text()
    lines = text.splitlines()
    start = lines.index("$Entities")
    volume = next(i for i in range(len(lines) - 1, start, -1) if lines[i] == "$EndEntities") - 1
    words = lines[volume].split()
    assert words[7] == "1"  # one physical group
    lines[volume] = " ".join([*words[:7], "0", *words[9:]])
    path = tmp_path / "mixed.msh"
    path.write_text("\n".join(lines) + "\n")
    assert_refused(path, "some cells are in physical groups", "Save all elements")


def test_file_without_cells(write):
    assert_refused(write("a.inp", "*NODE\n1, 0., 0., 0.\n"), "1 points, but no cells", "physical group")


def test_millimetres_are_suspected(write):
    big = re.sub(r"(?<=[ ,])([12])\.", r"\g<1>000.", ABAQUS)
    mesh = fem.read_mesh(write("mm.inp", big))
    with pytest.warns(fem.MeshWarning, match=r"diagonal is 2449\.49 m.*scale=1e-3"):
        fem.solid(mesh, STEEL)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        told = fem.read_mesh(write("mm.inp", big), scale=1e-3)
        fem.solid(told, STEEL)
    assert np.array_equal(told.points, mesh.scaled(1e-3).points)
    with pytest.raises(MeshError, match=r"scale = 0\. Expected: a factor > 0"):
        fem.read_mesh(write("mm.inp", big), scale=0)
    assert np.ptp(mesh.scaled(1e-3).points, axis=0) == pytest.approx([1.0, 1.0, 2.0])


def test_coincident_nodes_are_reported(write):
    lines = ABAQUS.replace("5, 6, 7, 8,\n9,", "13, 6, 7, 8,\n9,")
    lines = lines.replace("9, 0., 0., 2.", "13, 0., 0., 1.\n9, 0., 0., 2.")
    with pytest.warns(fem.MeshWarning, match=r"1 pairs of nodes coincide .* 4 and 8 at \[0\.0, 0\.0, 1\.0\]"):
        fem.read_mesh(write("a.inp", lines))


def test_sets_without_cells_are_reported(write):
    with pytest.warns(fem.MeshWarning, match="'lonely' holds only nodes without cells"):
        fem.read_mesh(
            write(
                "a.inp",
                ABAQUS.replace("*Element, type=C3D8R,", "*NODE, NSET=lonely\n50, 1., 1., 1.5\n*Element, type=C3D8R,"),
            )
        )


def test_mesh_from_arrays_is_checked():
    for change, text in (
        ({"points": np.zeros((4, 2))}, r"shape \(4, 2\)"),
        ({"points": np.full((4, 3), np.nan)}, "node 0 is at"),
        ({"cells": (("tetra", np.array([[0, 1, 2, 7]])),)}, "name the node 7"),
        ({"cells": (("tetra", np.array([[0, 1, 2]])),)}, r"shape \(1, 3\)"),
    ):
        arguments = {"points": np.eye(4, 3), "cells": (("tetra", np.array([[0, 1, 2, 3]])),), **change}
        with pytest.raises(MeshError, match=text):
            fem.Mesh(**arguments)
    with pytest.raises(MeshError, match=r"'cor' does not exist.*core.*Did you mean 'core'"):
        fem.Mesh(points=np.eye(4, 3), cells=(), cell_sets={"core": ()}).cell_set("cor")


def test_long_ranges_of_abaqus_sets_cost_nothing(write):
    """GENERATE to 40 million is all that there is; one that cannot be meant is refused as in decks."""
    text = ABAQUS.replace("1, 3, 1\n", "1, 40000001, 4\n3, 40000000, 1\n")
    text = text.replace("*Elset, elset=upper\n5", "*Elset, elset=upper, generate\n2, 40000000, 1")
    tracemalloc.start()
    mesh = fem.read_mesh(write("a.inp", text))
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert mesh.node_sets["foot"].tolist() == [0, *range(2, 12)]
    assert mesh.cell_set("upper")[0].tolist() == [1]
    assert peak < 20e6
    for line in ("1, 100000000, 1", "1, 3, 0", "1, 3, -1", "3, 1", "1, x", "1, 2, 1, 1", "1, 99999999999999999999"):
        with pytest.raises(MeshError, match=r"GENERATE .* Expected: first, last and a positive increment, 50000000"):
            fem.read_mesh(write("b.inp", ABAQUS.replace("1, 3, 1\n", f"{line}\n")))
