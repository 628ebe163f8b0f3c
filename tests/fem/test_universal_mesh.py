"""Meshes of universal files, written by hand from the public description of the datasets, and by Gmsh."""

import numpy as np
import pytest

from flexmb import fem
from flexmb.errors import MeshError
from flexmb.fem.meshes.mesh import MeshWarning
from flexmb.model.material import MATERIALS

STEEL = MATERIALS["steel"]
CORNERS = np.array([[0, 0, 0], [2, 0, 0], [0, 1, 0], [0, 0, 3]], float)
BRICK = np.array([[0, 0, 0], [2, 0, 0], [2, 1, 0], [0, 1, 0], [0, 0, 3], [2, 0, 3], [2, 1, 3], [0, 1, 3]], float)
WEDGE = np.array([[0, 0, 0], [2, 0, 0], [0, 1, 0], [0, 0, 3], [2, 0, 3], [0, 1, 3]], float)


def dataset(number, *lines):
    return "\n".join(["    -1", f"{number:6d}", *lines, "    -1", ""])


def integers(*numbers):
    return "".join(f"{number:10d}" for number in numbers)


def nodes_2411(points, first=1):
    lines = []
    for k, point in enumerate(points):
        lines += [integers(first + k, 1, 1, 11), "".join(f"{x:25.16E}".replace("E", "D") for x in point)]
    return dataset(2411, *lines)


def nodes_15(points, system=0):
    rows = enumerate(points, start=1)
    return dataset(15, *(integers(k, system, 0, 8) + "".join(f"{x:13.5E}" for x in p) for k, p in rows))


def element(label, descriptor, *nodes, family=1):
    lines = [integers(label, descriptor, family, 1, 7, len(nodes))]
    if descriptor in (11, 21, 22, 23, 24):
        lines.append(integers(0, 1, 1))
    return [*lines, *(integers(*nodes[k : k + 8]) for k in range(0, len(nodes), 8))]


def elements(*rows):
    return dataset(2412, *(line for row in rows for line in row))


def group(number, name, *members):
    lines = [integers(*(number, 0, 0, 0, 0, 0, 0, len(members))), name]
    return [*lines, *("".join(integers(*m, 0, 0) for m in members[k : k + 2]) for k in range(0, len(members), 2))]


def groups(*rows, number=2467):
    return dataset(number, *(line for row in rows for line in row))


def unit(factor):
    lines = [f"{9:10d}{'millimetres':>20}{2:10d}", f"{factor:25.17E}{1.0:25.17E}{1.0:25.17E}", f"{273.15:25.17E}"]
    return dataset(164, lines[0], *(line.replace("E", "D") for line in lines[1:]))


def written(tmp_path, *parts, name="part.unv"):
    path = tmp_path / name
    path.write_text("".join(parts))
    return path


def ring(face):
    """Return the corners of a face and the middles of its edges in turn."""
    return [x for k, a in enumerate(face) for x in (a, (a + face[(k + 1) % len(face)]) / 2)]


def parabolic(corners):
    """Return the nodes of a parabolic wedge or brick in the order of the file: lower face, verticals, upper face."""
    low, high = np.split(corners, 2)
    return np.array([*ring(low), *(low + high) / 2, *ring(high)])


TETRAHEDRON = np.array([*ring(CORNERS[:3]), *(CORNERS[:3] + CORNERS[3]) / 2, CORNERS[3]])
CASES = [
    (111, CORNERS, "tetra", 1.0),
    (118, TETRAHEDRON, "tetra10", 1.0),
    (112, WEDGE, "wedge", 3.0),
    (113, parabolic(WEDGE), "wedge15", 3.0),
    (115, BRICK, "hexahedron", 6.0),
    (116, parabolic(BRICK), "hexahedron20", 6.0),
]


@pytest.mark.parametrize(("descriptor", "points", "kind", "volume"), CASES)
def test_solids_have_their_nodes_in_order(tmp_path, descriptor, points, kind, volume):
    """Volume, six rigid motions, and every midside node in the middle of its edge."""
    number = len(points)
    path = written(tmp_path, nodes_2411(points, 101), elements(element(7, descriptor, *range(101, 101 + number))))
    mesh = fem.read_mesh(path)
    assert [(name, cells.shape) for name, cells in mesh.cells] == [(kind, (1, number))]
    assert sorted(mesh.numbering.nodes) == list(range(101, 101 + number))
    fe = fem.solid(mesh, STEEL)
    assert fe.M.sum() / 3.0 == pytest.approx(volume * STEEL.density, rel=1e-12)
    frequencies = fem.eigenmodes(fe, n=7).frequencies
    assert frequencies[5] < 1e-3 * frequencies[6]
    cells = mesh.points[mesh.cells[0][1][0]]
    edges = {"tetra10": [(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)]}
    edges["wedge15"] = [(0, 1), (1, 2), (2, 0), (3, 4), (4, 5), (5, 3), (0, 3), (1, 4), (2, 5)]
    edges["hexahedron20"] = [(k + a, k + (a + 1) % 4) for k in (0, 4) for a in range(4)] + [
        (a, a + 4) for a in range(4)
    ]
    corners = {"tetra10": 4, "wedge15": 6, "hexahedron20": 8}.get(kind, number)
    for row, (a, b) in enumerate(edges.get(kind, [])):
        np.testing.assert_allclose(cells[corners + row], (cells[a] + cells[b]) / 2, atol=1e-15)


def test_shells_beams_groups_and_numbers(tmp_path):
    square = np.array([[0, 0, 0], [0.5, 0, 0], [1, 0, 0], [1, 0.5, 0], [1, 1, 0], [0.5, 1, 0], [0, 1, 0], [0, 0.5, 0]])
    path = written(
        tmp_path,
        dataset(151, "a header", "of another program"),
        nodes_2411(np.vstack([square, [[2, 0, 0], [2, 1, 0]]])),
        elements(
            element(11, 95, 1, 2, 3, 4, 5, 6, 7, 8),
            element(12, 94, 3, 9, 10, 5, family=2),
            element(13, 91, 3, 9, 10, family=2),
            element(14, 21, 3, 9),
            element(15, 24, 1, 2, 3),
            element(16, 161, 9),
        ),
        groups(
            group(1, "SKIN", (8, 11), (8, 12), (8, 13)),
            group(2, "EDGE NODES", (7, 1), (7, 7), (7, 8)),
            group(3, "", (7, 10), (8, 14)),
            group(4, "mixed", (7, 10), (3, 5)),
        ),
        name="part.uff",
    )
    with pytest.warns(MeshWarning) as told:
        mesh = fem.read_mesh(path)
    text = " ".join(str(one.message) for one in told)
    assert "1 lumped masses" in text
    assert "1 members of the group 'mixed'" in text
    assert {kind: cells.tolist() for kind, cells in mesh.cells} == {
        "quad8": [[0, 2, 4, 6, 1, 3, 5, 7]],
        "quad": [[2, 8, 9, 4]],
        "triangle": [[2, 8, 9]],
        "line": [[2, 8]],
        "line3": [[0, 2, 1]],
    }
    assert mesh.node_sets["EDGE NODES"].tolist() == [0, 6, 7]
    assert mesh.node_sets["group_3"].tolist() == [2, 8, 9]
    assert [rows.tolist() for rows in mesh.cell_sets["SKIN"]] == [[0], [0], [0], [], []]
    assert [rows.tolist() for rows in mesh.cell_sets["pid_2"]] == [[], [0], [0], [], []]
    assert len(mesh.facet_sets["SKIN"]) == 3


def test_units_of_the_file_are_honoured(tmp_path):
    """A factor of 1000: lengths divided by it are metres (dataset 164)."""
    brick = elements(element(1, 115, *range(1, 9)))
    path = written(tmp_path, unit(1000.0), nodes_15(100.0 * BRICK), brick)
    np.testing.assert_allclose(fem.read_mesh(path).points, 0.1 * BRICK, rtol=1e-12)
    np.testing.assert_allclose(fem.read_mesh(path, scale=1e-3).points, 0.1 * BRICK, rtol=1e-12)
    with pytest.warns(MeshWarning, match=r"0\.001 m by the file itself, but scale=0\.01"):
        assert fem.read_mesh(path, scale=0.01).points.max() == pytest.approx(3.0)
    with pytest.raises(MeshError, match=r"units of 0\.001 m and of 0\.0254 m"):
        fem.read_mesh(written(tmp_path, unit(1000.0), unit(1 / 0.0254), nodes_15(BRICK), brick))
    with pytest.raises(MeshError, match="factor 0 of lengths"):
        fem.read_mesh(written(tmp_path, unit(0.0), nodes_15(BRICK), brick))


def test_binary_measurements_are_passed_over(tmp_path):
    """A dataset 58b whose bytes look like the end of a dataset."""
    noise = b"\n    -1\n" * 3
    head = f"    58b{1:6d}{2:6d}{11:12d}{len(noise):12d}\n".encode()
    body = b"    -1\n" + head + noise + b"\n    -1\n"
    path = tmp_path / "test.uff"
    path.write_bytes(body + (nodes_2411(BRICK) + elements(element(1, 115, *range(1, 9)))).encode())
    assert len(fem.read_mesh(path).points) == 8


def test_numbers_twice(tmp_path):
    one, two = (element(label, 115, *range(1, 9)) for label in (1, 2))
    with pytest.raises(MeshError, match="1 element numbers twice, the first is 1"):
        fem.read_mesh(written(tmp_path, nodes_2411(BRICK), elements(one, one)))
    with pytest.raises(MeshError, match="1 grid points at two places, the first is 1"):
        fem.read_mesh(written(tmp_path, nodes_2411(BRICK), nodes_2411(BRICK[:1] + 5.0), elements(one, two)))


def test_what_cannot_be_read_is_named(tmp_path):
    brick = element(5, 115, *range(1, 9))
    for match, *parts in [
        ("no nodes; the datasets 55", dataset(55, "NONE")),
        ("the node 99, which does not exist", nodes_2411(BRICK), elements(element(5, 115, 99, *range(2, 9)))),
        ("node 1 in the coordinate system 4", nodes_15(BRICK, 4), elements(brick)),
        ("element 5 with the descriptor 31", nodes_2411(BRICK), elements(element(5, 31, 1, 2))),
        ("element 5 with 0 nodes at the end", nodes_2411(BRICK), elements(brick[:1])),
        ("without its end", nodes_2411(BRICK), elements(brick)[:-8]),
        ("the line '1 2 x'", nodes_2411(BRICK), dataset(2412, "1 2 x")),
        ("the set 'a' names the node 77", nodes_2411(BRICK), elements(brick), groups(group(1, "a", (7, 77)))),
        ("8 points, but no cells", nodes_2411(BRICK), elements(element(5, 161, 1))),
        (
            "with 2 members at the end",
            nodes_2411(BRICK),
            elements(brick),
            groups(group(1, "a", (7, 1), (7, 2), (7, 3))[:3]),
        ),
    ]:
        with pytest.raises(MeshError, match=match):
            fem.read_mesh(written(tmp_path, *parts))


def test_elements_and_groups_that_are_not_there_are_told(tmp_path):
    path = written(
        tmp_path,
        nodes_2411(np.vstack([BRICK, [[5, 5, 5]]])),
        elements(element(5, 115, *range(1, 9)), element(6, 136, 1, 2)),
        groups(group(1, "a", (8, 5), (8, 44)), number=2477),
        dataset(2429, "whatever"),
    )
    with pytest.warns(MeshWarning) as told:
        mesh = fem.read_mesh(path)
    text = " ".join(str(one.message) for one in told)
    for part in ("1 springs", "group 'a' names 1 elements that are not in the file, the first is 44", "datasets 2429"):
        assert part in text
    assert len(mesh.points) == 8


@pytest.mark.parametrize(("order", "recombine"), [(1, False), (2, False), (1, True), (2, True)])
def test_the_same_mesh_as_msh_and_unv_of_gmsh(tmp_path, order, recombine):
    gmsh = pytest.importorskip("gmsh")
    gmsh.initialize(interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.option.setNumber("Mesh.SecondOrderIncomplete", 1)
        gmsh.option.setNumber("Mesh.ElementOrder", order)
        gmsh.option.setNumber("Mesh.MeshSizeMin", 1.0)
        box = gmsh.model.occ.addBox(0, 0, 0, 2, 1, 1)
        gmsh.model.occ.synchronize()
        gmsh.model.addPhysicalGroup(3, [box], name="block")
        gmsh.model.addPhysicalGroup(2, [1], name="left")
        gmsh.model.addPhysicalGroup(2, [1, 2], name="ends")
        if recombine:
            for _, curve in gmsh.model.getEntities(1):
                gmsh.model.mesh.setTransfiniteCurve(curve, 3)
            for _, surface in gmsh.model.getEntities(2):
                gmsh.model.mesh.setTransfiniteSurface(surface)
                gmsh.model.mesh.setRecombine(2, surface)
            gmsh.model.mesh.setTransfiniteVolume(box)
        gmsh.model.mesh.generate(3)
        for suffix in ("msh", "unv"):
            gmsh.write(str(tmp_path / f"box.{suffix}"))
    finally:
        gmsh.finalize()
    expected, found = (fem.read_mesh(tmp_path / f"box.{suffix}") for suffix in ("msh", "unv"))
    a, b = fem.solid(expected, STEEL), fem.solid(found, STEEL)
    assert abs(a.K - b.K).max() < 1e-12 * abs(a.K).max()
    for name in ("block", "left", "ends"):
        assert found.node_sets[name].tolist() == expected.node_sets[name].tolist()
    assert np.sort(found.facet_sets["ends"]).tolist() == np.sort(expected.facet_sets["ends"]).tolist()
