"""Nothing of a mesh file counts twice, and no group of it vanishes: by the rules of each format."""

import warnings

import numpy as np
import pytest
from fem.test_read_mesh import ABAQUS, NASTRAN, STEEL, assert_refused, write

from flexmb import fem
from flexmb.errors import MeshError

__all__ = ["write"]

NODES = """$Nodes
8
1 0 0 0
2 1 0 0
3 1 1 0
4 0 1 0
5 0 0 1
6 1 0 1
7 1 1 1
8 0 1 1
$EndNodes
"""

OVERLAPPING_22 = (
    """$MeshFormat
2.2 0 8
$EndMeshFormat
$PhysicalNames
4
2 3 "both"
3 1 "all"
3 2 "core"
3 3 "both"
$EndPhysicalNames
"""
    + NODES
    + """$Elements
4
1 3 2 3 6 1 2 3 4
2 5 2 1 1 1 2 3 4 5 6 7 8
3 5 2 2 1 1 2 3 4 5 6 7 8
4 5 2 3 1 1 2 3 4 5 6 7 8
$EndElements
"""
)

UNNAMED_41 = """$MeshFormat
4.1 0 8
$EndMeshFormat
$PhysicalNames
1
3 1 "all"
$EndPhysicalNames
$Entities
0 0 1 1
6 0 0 0 1 1 0 2 8 -9 0
1 0 0 0 1 1 1 3 1 7 5 1 6
$EndEntities
$Nodes
1 8 1 8
3 1 0 8
1
2
3
4
5
6
7
8
0 0 0
1 0 0
1 1 0
0 1 0
0 0 1
1 0 1
1 1 1
0 1 1
$EndNodes
$Elements
2 2 1 2
2 6 3 1
1 1 2 3 4
3 1 5 1
2 1 2 3 4 5 6 7 8
$EndElements
"""


def test_overlapping_groups_of_gmsh_weigh_once(write):
    """MSH 2.2 writes a cell once for each of its groups; a cubic metre of steel weighs 7850 kg all the same."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        mesh = fem.read_mesh(write("a.msh", OVERLAPPING_22))
    assert len(mesh.cells_of("hexahedron")) == 1
    assert fem.solid(mesh, STEEL).M.sum() / 3 == pytest.approx(7850.0)
    for name in ("all", "core", "both"):
        assert mesh.cell_set(name)[1].tolist() == [0]
    assert mesh.cell_set("both")[0].tolist() == [0]  # a name of two dimensions keeps both
    assert mesh.facet_sets["both"].tolist() == [[0, 1, 2, 3]]


def test_a_cell_twice_in_one_group_of_gmsh_is_reported(write):
    text = OVERLAPPING_22.replace("4 5 2 3 1 1", "4 5 2 2 1 1")
    with pytest.warns(fem.MeshWarning, match=r"1 hexahedron cells are listed twice.*\[0, 1, 2, 3, 4, 5, 6, 7\]"):
        mesh = fem.read_mesh(write("a.msh", text))
    assert fem.solid(mesh, STEEL).M.sum() / 3 == pytest.approx(7850.0)


@pytest.mark.parametrize("binary", [False, True])
def test_all_unnamed_groups_of_an_entity(write, binary, tmp_path):
    """MSH 4.1: an entity in several groups, of which some have no name, some a negative number (turned round)."""
    path = write("a.msh", UNNAMED_41)
    if binary:
        path = tmp_path / "binary.msh"
        path.write_bytes(_binary_41())
    mesh = fem.read_mesh(path)
    assert {"all", "volume_7", "volume_5", "surface_8", "surface_9"} == set(mesh.cell_sets)
    assert mesh.cell_set("volume_7")[1].tolist() == mesh.cell_set("volume_5")[1].tolist() == [0]
    assert mesh.facet_sets["surface_9"].tolist() == [[0, 1, 2, 3]]


def _binary_41() -> bytes:
    """The same file in binary form, written by the description of the format."""
    points = [float(x) for line in NODES.splitlines()[2:10] for x in line.split()[1:]]
    i4, u8, f8 = (
        (lambda kind: lambda *x: np.array(x, kind).tobytes())("i4"),
        *map(lambda k: lambda *x: np.array(x, k).tobytes(), ("u8", "f8")),
    )
    entities = u8(0, 0, 1, 1)
    entities += i4(6) + f8(*[0.0] * 6) + u8(2) + i4(8, -9) + u8(0)
    entities += i4(1) + f8(*[0.0] * 6) + u8(3) + i4(1, 7, 5) + u8(1) + i4(6)
    nodes = u8(1, 8, 1, 8) + i4(3, 1, 0) + u8(8) + u8(*range(1, 9)) + f8(*points)
    cells = u8(2, 2, 1, 2) + i4(2, 6, 3) + u8(1) + u8(1, 1, 2, 3, 4) + i4(3, 1, 5) + u8(1) + u8(2, *range(1, 9))
    parts = [b"$MeshFormat\n4.1 1 8\n" + i4(1) + b"\n$EndMeshFormat\n"]
    parts += [b'$PhysicalNames\n1\n3 1 "all"\n$EndPhysicalNames\n']
    for name, data in ((b"Entities", entities), (b"Nodes", nodes), (b"Elements", cells)):
        parts.append(b"$" + name + b"\n" + data + b"\n$End" + name + b"\n")
    return b"".join(parts)


def test_elements_listed_twice_in_a_deck(write):
    """Two numbers for one place, also with its nodes in another order: merged, and said."""
    twice = ABAQUS.replace(
        "*Elset, elset=upper\n", "*Element, type=C3D8R\n9, 6, 7, 8, 5, 2, 3, 4, 1\n*Elset, elset=upper\n"
    )
    twice = twice.replace("9, 6, 7, 8, 5, 2, 3, 4, 1", "9, 2, 3, 4, 1, 6, 7, 8, 5")
    with pytest.warns(fem.MeshWarning, match="1 hexahedron cells are listed twice"):
        mesh = fem.read_mesh(write("a.inp", twice))
    assert fem.solid(mesh, STEEL).M.sum() / 3 == pytest.approx(2 * 7850.0)
    deck = NASTRAN.replace(
        "SET3,4", "CHEXA   101     7       1       2       3       4       5       6       +\n+       7       8\nSET3,4"
    )
    with pytest.warns(fem.MeshWarning, match="1 hexahedron cells are listed twice"):
        assert len(fem.read_mesh(write("a.bdf", deck)).cells_of("hexahedron")) == 1


def test_cells_listed_twice_in_arrays_are_refused():
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]])
    mesh = fem.Mesh(points=points, cells=(("tetra", np.array([[0, 1, 2, 3], [1, 2, 0, 3]])),), name="tip")
    with pytest.raises(MeshError, match=r"'tip': 1 tetra cells are listed twice, the first is number 1.*read_mesh"):
        fem.solid(mesh, STEEL)


def test_shells_and_bars_on_one_another_are_reported(write):
    """A doubler on a skin is meant: it stays, with its own thickness; the same group twice is not."""
    deck = "BEGIN BULK\n" + "".join(
        f"GRID,{k + 1},,{x}.,{y}.,0.\n" for k, (x, y) in enumerate([(0, 0), (1, 0), (1, 1), (0, 1)])
    )
    doubled = deck + "CQUAD4,1,1,1,2,3,4\nCQUAD4,2,2,1,2,3,4\n"
    mesh = fem.read_mesh(write("a.bdf", doubled))
    with pytest.warns(fem.MeshWarning, match="1 quad cells lie on others"):
        shell = fem.shell(mesh, STEEL, {"pid_1": 0.001, "pid_2": 0.002})
    assert shell.M[::6, ::6].sum() == pytest.approx(7850.0 * 0.003)
    with pytest.warns(fem.MeshWarning, match="1 quad cells are listed twice"):
        assert len(fem.read_mesh(write("b.bdf", doubled.replace("CQUAD4,2,2", "CQUAD4,2,1"))).cells_of("quad")) == 1


SHELLS = """*NODE
1, 0., 0., 0.
2, 1., 0., 0.
3, 1., 1., 0.
4, 0., 1., 0.
5, 2., 0., 0.
6, 2., 1., 0.
*ELEMENT, TYPE=S4R, ELSET=plate
1, 1, 2, 3, 4
2, 2, 5, 6, 3
*SURFACE, NAME=top
plate, SPOS
*SURFACE, NAME=bottom
1, SNEG
*SURFACE, NAME=whole
plate,
*SURFACE, TYPE=NODE, NAME=rim
1, 0.5
4,
*NSET, NSET=corners, ELSET=plate
"""


def test_sides_of_abaqus_shells(write):
    """The top is where the normal of the cell points, the bottom runs the other way round."""
    mesh = fem.read_mesh(write("a.inp", SHELLS))
    assert mesh.facet_sets["top"].tolist() == mesh.facet_sets["whole"].tolist() == [[0, 1, 2, 3], [1, 4, 5, 2]]
    assert mesh.facet_sets["bottom"].tolist() == [[0, 3, 2, 1]]
    assert mesh.node_sets["rim"].tolist() == [0, 3]
    assert mesh.node_sets["corners"].tolist() == list(range(6))
    shell = fem.shell(mesh, STEEL, 0.01)
    up, down = (fem.pressure_load(shell, side, 100.0)[2::6].sum() for side in ("top", "bottom"))
    assert (up, down) == pytest.approx((-200.0, 100.0))  # 100 Pa on 2 m2 from above, on 1 m2 from below


def test_free_faces_of_a_set_of_solids(write):
    """A surface of a whole set of solids has its faces that no other solid of the file touches."""
    mesh = fem.read_mesh(write("a.inp", ABAQUS + "*SURFACE, NAME=outside\nupper,\n*SURFACE, NAME=all over\nboth\n"))
    assert len(mesh.facet_sets["outside"]) == 5
    assert len(mesh.facet_sets["all over"]) == 10
    force = fem.pressure_load(fem.solid(mesh, STEEL), "outside", 1.0)
    assert force[2::3].sum() == pytest.approx(-1.0)  # the lower face is inside: top alone is pressed down


def test_what_a_surface_means_that_is_not_read(write):
    for text, words in (
        ("*SURFACE, NAME=edge\nlower, E1\n", "surface 'edge' on 'lower', face E1"),
        ("*SURFACE, NAME=sum, COMBINE=UNION\ntop\n", "surface 'sum' with COMBINE=UNION"),
        ("*SURFACE, NAME=side\nlower, SPOS\n", "surface 'side', side 'SPOS': its elements have no such face"),
    ):
        with pytest.warns(fem.MeshWarning, match=f"not read: {words}"):
            fem.read_mesh(write("a.inp", ABAQUS + text))
    assert_refused(write("a.inp", ABAQUS + "*SURFACE, NAME=x\nnowhere, S1\n"), "unknown set 'nowhere'")


def test_a_facet_listed_twice_is_pressed_once(write):
    mesh = fem.read_mesh(write("a.inp", ABAQUS.replace("upper, S2\n", "upper, S2\n5, S2\n")))
    assert len(mesh.facet_sets["top"]) == 2


CASE = (
    NASTRAN.replace('$HMSET        2        2 "bar"\n', "")
    .replace("CHEXA   100", "CHEXA   1  ")
    .replace("SET 2 = 100", "{}")
)


@pytest.mark.parametrize(
    ("text", "cells", "nodes"),
    [
        ("SET 2 = 1\nSTRESS(PLOT) = 2", True, 8),
        ("SET 2 = 1\nDISP = 2", False, 1),
        ("SET 2 = 8\nFORCE = 2", False, 1),  # there is no element 8
    ],
)
def test_a_case_control_set_is_what_uses_it(write, text, cells, nodes):
    mesh = fem.read_mesh(write("a.bdf", CASE.format(text)))
    assert ("set_2" in mesh.cell_sets) == cells
    assert len(mesh.node_sets["set_2"]) == nodes


def test_a_case_control_set_of_element_numbers(write):
    """No request uses it, but its numbers are of elements only."""
    mesh = fem.read_mesh(write("a.bdf", CASE.replace("CHEXA   1  ", "CHEXA   100").format("SET 2 = 100")))
    assert mesh.cell_set("set_2")[0].tolist() == [0]
    assert len(mesh.node_sets["set_2"]) == 8


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("SET 2 = 1", "set_2' fit grid points and elements, and nothing says which"),
        ("SET 2 = 20, 21", "names neither grid points nor elements"),
        ("SET 2 = ALL", "reads 'ALL'"),
        ("SET 2 = 10.5, 20.0", "reads '10.5 20.0'"),
    ],
)
def test_a_case_control_set_that_says_nothing(write, text, words):
    with pytest.warns(fem.MeshWarning, match=words):
        mesh = fem.read_mesh(write("a.bdf", CASE.format(text)))
    assert "set_2" not in mesh.cell_sets
