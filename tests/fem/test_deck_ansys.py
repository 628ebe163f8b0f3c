"""Ansys archives beside runs of CalculiX, closed forms, and another reader of the same blocks."""

import re
import subprocess
import warnings

import numpy as np
import pytest
from fem.ansys_archive import STEEL, archive, brick20, cmblock, eblock, material, nblock, rlblock

from flexmb import fem, reduction
from flexmb.errors import FlexmbError, MeshError
from flexmb.fem.deck.ansys_text import read_archive
from flexmb.fem.deck.inventory import mass_and_center

pytestmark = pytest.mark.filterwarnings("ignore::flexmb.fem.meshes.mesh.MeshWarning")


def read(tmp_path, text, **options):
    path = tmp_path / "part.cdb"
    path.write_text(text)
    return fem.read_deck(path, show=False, **options)


def solids(cells, kind=1, mat=1, system=0):
    return eblock([(k, kind, mat, 1, 1, system, nodes) for k, nodes in enumerate(cells, 1)])


def calculix(program, folder, points, cells, text, count):
    """Return free frequencies, Hz, of C3D20 with the same nodes."""
    nodes = "".join(f"{k}, {x:.14g}, {y:.14g}, {z:.14g}\n" for k, (x, y, z) in points.items())
    rows = "".join(
        f"{k}, {', '.join(map(str, c[:10]))},\n{', '.join(map(str, c[10:]))}\n" for k, c in enumerate(cells, 1)
    )
    deck = f"*NODE\n{nodes}*ELEMENT, TYPE=C3D20, ELSET=ALL\n{rows}{text}*STEP\n*FREQUENCY\n{count}\n*END STEP\n"
    (folder / "job.inp").write_text(deck)
    subprocess.run([program, "job"], cwd=folder, capture_output=True, check=True, timeout=60)
    out = (folder / "job.dat").read_text().split("P A R T I C I P A T I O N")[0]
    rows = [line.split() for line in out.splitlines()]
    return np.array([float(row[3]) for row in rows if len(row) == 5 and row[0].isdigit()])


def test_bricks_vibrate_as_in_calculix(tmp_path, ccx):
    """SOLID186 of an orthotropic material in a turned system, beside C3D20 with *ORIENTATION."""
    points, cells = brick20((3, 2, 1), (0.3, 0.1, 0.05))
    e, nu, g = (150e9, 9e9, 12e9), (0.3, 0.4, 0.25), (5e9, 3e9, 4e9)
    given = dict(zip(("EX", "EY", "EZ"), e, strict=True)) | dict(zip(("PRXY", "PRYZ", "PRXZ"), nu, strict=True))
    given |= dict(zip(("GXY", "GYZ", "GXZ"), g, strict=True)) | {"DENS": 1600.0}
    local = "LOCAL,R5.0,LOC,       11,  0,  0.1,  0.2,  0.3\nLOCAL,R5.0,ANG,       11,  0,  30.0,  20.0,  0.0\n"
    text = archive({1: ("SOLID186", (2, 1))}, nblock(points), local, solids(cells, system=11), material(1, **given))
    fe = read(tmp_path, text)
    # THXY = 30 about z, then THYZ = 20 about the new x: columns are the local axes
    a, b = np.radians([30.0, 20.0])
    about_z = np.array([[np.cos(a), -np.sin(a), 0], [np.sin(a), np.cos(a), 0], [0, 0, 1]])
    about_x = np.array([[1, 0, 0], [0, np.cos(b), -np.sin(b)], [0, np.sin(b), np.cos(b)]])
    axes = about_z @ about_x
    constants = (*e, nu[0], nu[2], nu[1], g[0], g[2])
    words = (
        "*MATERIAL, NAME=M\n*ELASTIC, TYPE=ENGINEERING CONSTANTS\n"
        + ", ".join(f"{x:.14g}" for x in constants)
        + f"\n{g[1]:.14g}\n*DENSITY\n1600.\n*ORIENTATION, NAME=O\n"
        + ", ".join(f"{x:.14g}" for x in (*axes[:, 0], *axes[:, 1]))
        + "\n*SOLID SECTION, ELSET=ALL, MATERIAL=M, ORIENTATION=O\n"
    )
    theirs = calculix(ccx, tmp_path, points, cells, words, 12)
    np.testing.assert_allclose(fem.eigenmodes(fe, n=12).frequencies[6:], theirs[6:], rtol=1e-5)


def test_bricks_with_coinciding_nodes_are_other_shapes(tmp_path):
    """A brick as wedge, pyramid and tetrahedron: volumes of the unit cube's parts, first and second order."""
    corner = {1: (0, 0, 0), 2: (1, 0, 0), 3: (1, 1, 0), 4: (0, 1, 0), 5: (0, 0, 1), 6: (1, 0, 1), 7: (1, 1, 1)}
    shapes = {
        "wedge": ([1, 2, 3, 3, 5, 6, 7, 7], 0.5),
        "pyramid": ([1, 2, 3, 4, 5, 5, 5, 5], 1 / 3),
        "tetra": ([1, 2, 3, 3, 5, 5, 5, 5], 1 / 6),
    }
    edges = [(0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7)]
    for nodes, volume in shapes.values():
        fe = read(tmp_path, archive({1: (185,)}, nblock(corner), solids([nodes]), STEEL))
        assert mass_and_center(fe)[0] == pytest.approx(7850 * volume, rel=1e-12)
        points, middles = dict(corner), {}
        for a, b in edges:
            pair = tuple(sorted((nodes[a], nodes[b])))
            if pair[0] == pair[1]:
                middles[pair] = pair[0]
            elif pair not in middles:
                middles[pair] = len(points) + 1
                points[middles[pair]] = tuple(np.mean([corner[pair[0]], corner[pair[1]]], axis=0))
        full = [*nodes, *(middles[tuple(sorted((nodes[a], nodes[b])))] for a, b in edges)]
        fe = read(tmp_path, archive({1: (186,)}, nblock(points), solids([full]), STEEL))
        assert mass_and_center(fe)[0] == pytest.approx(7850 * volume, rel=1e-12)
        assert fem.eigenmodes(fe, n=7).frequencies[6] > 100.0  # all midside nodes are held together: six rigid modes
        assert fem.eigenmodes(fe, n=7).frequencies[5] < 1e-2


def test_omitted_midside_nodes(tmp_path):
    points, cells = brick20((2, 1, 1), (0.2, 0.1, 0.1))
    cells[0][8] = 0  # on an edge of its own
    fe = read(tmp_path, archive({1: (186,)}, nblock(points), solids(cells), STEEL))
    assert mass_and_center(fe)[0] == pytest.approx(7850 * 0.002, rel=1e-12)


def cantilever(options, section, ends=(), angles=None, direction=(0.0, 0.0, 2.0), extra="", steps=20):
    """Return an archive of a beam along x of length 2 with an orientation node, clamped at node 1."""
    points = {k + 1: (2.0 * k / steps, 0.0, 0.0) for k in range(steps + 1)} | {999: direction}
    rows = [(k, 1, 1, 1, 1, 0, (k, k + 1, 999)) for k in range(1, steps + 1)]
    held = "".join(f"D,{1:9d},{d:<4},  0.00000000    ,  0.00000000    \n" for d in ("UX", "UY", "UZ", "ROTX", "ROTY"))
    held += "D,        1,ROTZ,  0.00000000    ,  0.00000000    \n"
    return archive(options, section, nblock(points, angles), eblock([*rows, *ends]), STEEL, held, extra)


def test_beams_bend_about_the_right_axes(tmp_path):
    """BEAM188 of 20 by 40 mm with z towards the orientation node: Euler-Bernoulli's cantilever, beta_1 l = 1.87510."""
    section = "SECTYPE,        1,BEAM,RECT,slim,   0\nSECOFFSET, CENT\nSECDATA, 0.02, 0.04\n"
    fe = read(tmp_path, cantilever({1: (188,)}, section))
    speed = 1.8751040687**2 / (2 * np.pi * 4.0) * np.sqrt(210e9 / 7850.0)
    expected = [speed * h / np.sqrt(12.0) for h in (0.02, 0.04)]
    modes = fem.eigenmodes(fe, "d", n=2)
    np.testing.assert_allclose(modes.frequencies, expected, rtol=2e-3)
    flat = [np.abs(modes.shapes[fe.dofs[:, 1] == d]).max(axis=0) for d in (1, 2)]
    assert flat[0][0] > 100 * flat[1][0]  # soft along y, where the section is 20 mm
    assert flat[1][1] > 100 * flat[0][1]


@pytest.mark.parametrize(
    ("words", "area", "iyy", "izz"),
    [
        ("CSOLID\nSECDATA, 0.01", np.pi * 1e-4, np.pi / 4 * 1e-8, np.pi / 4 * 1e-8),
        ("CTUBE\nSECDATA, 0.008, 0.01", np.pi * 3.6e-5, np.pi / 4 * 5.904e-9, np.pi / 4 * 5.904e-9),
        # outer 40 (y) by 60 (z), walls 2 at the sides, 3 at bottom and top
        (
            "HREC\nSECDATA, .04, .06, .002, .002, .003, .003",
            0.04 * 0.06 - 0.036 * 0.054,
            (0.04 * 0.06**3 - 0.036 * 0.054**3) / 12,
            (0.06 * 0.04**3 - 0.054 * 0.036**3) / 12,
        ),
        # flanges 50 by 4, height 80 along z, web 3
        (
            "I\nSECDATA, .05, .05, .08, .004, .004, .003",
            2 * 0.05 * 0.004 + 0.072 * 0.003,
            (0.05 * 0.08**3 - 0.047 * 0.072**3) / 12,
            (2 * 0.004 * 0.05**3 + 0.072 * 0.003**3) / 12,
        ),
        ("ASEC\nSECDATA, 1e-3, 2e-7, 0, 3e-7, 0, 1e-7, 0, 0, 0, 0", 1e-3, 2e-7, 3e-7),
    ],
)
def test_sections(tmp_path, words, area, iyy, izz):
    shape, data = words.split("\n")
    fe = read(tmp_path, cantilever({1: (188,)}, f"SECTYPE, 1, BEAM, {shape}\n{data}\n"))
    load = {axis: fe_force(fe, 21, axis) for axis in range(3)}
    for axis, stiffness in ((0, 210e9 * area / 2.0), (1, 3 * 210e9 * izz / 8.0), (2, 3 * 210e9 * iyy / 8.0)):
        tip = fem.static(fe, load[axis], "d")[freedom(fe, 21, axis)]
        assert 1.0 / tip == pytest.approx(stiffness, rel=1e-2)  # transverse shear: up to 0.8 % of the deflection


def freedom(fe, label, direction):
    node = int(np.flatnonzero(fe.labels == label)[0])
    return int(np.flatnonzero((fe.dofs == (node, direction)).all(axis=1))[0])


def fe_force(fe, label, direction):
    load = np.zeros(fe.ndof)
    load[freedom(fe, label, direction)] = 1.0
    return load


def strip(place, kind=181, layers="SECBLOCK,           1\n  0.1000E-01,         1,  0.0000    ,         3\n"):
    """Return a strip 1 by 0.1 of ten shells, one of them two triangles."""
    points = {}
    for i in range(11):
        points |= {2 * i + 1: (0.1 * i, 0.0, 0.0), 2 * i + 2: (0.1 * i, 0.1, 0.0)}
    rows = [(i, 1, 1, 1, 1, 0, (2 * i - 1, 2 * i + 1, 2 * i + 2, 2 * i)) for i in range(1, 10)]
    rows += [(10, 1, 1, 1, 1, 0, (19, 21, 22, 22)), (11, 1, 1, 1, 1, 0, (19, 22, 20, 20))]
    section = f"SECTYPE,        1,SHEL,    ,strip\nSECOFFSET, {place}\n{layers}SECCONTROL, 0, 0, 0, 5.0\n"
    return archive({1: (kind,)}, section, nblock(points), eblock(rows), STEEL)


@pytest.mark.parametrize(("place", "height"), [("MID", 0.0), ("TOP", -0.005), ("BOT", 0.005)])
def test_shells_with_offset_and_added_mass(tmp_path, place, height):
    fe = read(tmp_path, strip(place))
    mass, centre = mass_and_center(fe)
    assert mass == pytest.approx(0.1 * (7850 * 0.01 + 5.0), rel=1e-12)
    np.testing.assert_allclose(centre, [0.5, 0.05, height], atol=1e-12)


@pytest.mark.parametrize(("given", "mean"), [((0.01,), 0.01), ((0.01, 0.02, 0.02, 0.0), 0.015)])
def test_thickness_by_real_constants(tmp_path, given, mean):
    """SHELL181 without a section, as HyperMesh writes it: TK(I) to TK(L), THETA, ADMSUA; equal to the section of it."""
    real = (*given, *(0.0,) * (5 - len(given)), 5.0)
    text = strip("MID", layers=f"SECDATA, {mean}, 1, 0.0, 3\n")
    start, stop = text.index("SECTYPE"), text.index("NBLOCK")
    fe = read(tmp_path, text[:start] + rlblock({1: real}) + text[stop:])
    assert mass_and_center(fe)[0] == pytest.approx(0.1 * (7850 * mean + 5.0), rel=1e-12)
    np.testing.assert_allclose(fe.K.toarray(), read(tmp_path, text).K.toarray(), atol=1e-12 * fe.K.max())


def test_nodes_with_integers_of_two_widths(tmp_path):
    """(1i7,2i9,6e21.13) of Workbench is the block of (3i9,6e21.13e3)."""
    text = strip("MID")
    lines, block = [], False
    for line in text.split("\n"):
        block = (block or line.startswith("(3i9")) and not line.startswith("N,R5.3")
        lines.append("(1i7,2i9,6e21.13)" if line.startswith("(3i9") else line[2:] if block else line)
    other = read(tmp_path, "\n".join(lines))
    whole = read(tmp_path, text)
    np.testing.assert_array_equal(other.nodes, whole.nodes)
    np.testing.assert_array_equal(other.labels, whole.labels)


def test_layers_lie_from_bottom_to_top(tmp_path):
    """A soft heavy layer on a stiff light one: the free strip has its neutral axis in the stiff layer."""
    layers = "SECDATA, 0.006, 2, 0.0, 3\nSECDATA, 0.004, 1, 0.0, 3\n"
    fe = read(tmp_path, strip("MID", layers=layers) + material(2, EX=70e9, NUXY=0.3, DENS=2700.0))
    assert mass_and_center(fe)[0] == pytest.approx(0.1 * (7850 * 0.004 + 2700 * 0.006 + 5.0), rel=1e-12)
    bottom, top = 70e9 * 0.006, 210e9 * 0.004
    neutral = (bottom * -0.002 + top * 0.003) / (bottom + top)
    ends = [node for node in range(len(fe.nodes)) if fe.nodes[node, 0] > 0.99]
    pull = sum(fe_force(fe, int(fe.labels[n]), 0) + neutral * fe_force(fe, int(fe.labels[n]), 4) for n in ends)
    held = [n for n in range(len(fe.nodes)) if fe.nodes[n, 0] < 0.01]
    u = fem.static(fe, pull, held)
    lift = [abs(u[freedom(fe, int(fe.labels[n]), 2)]) / u[freedom(fe, int(fe.labels[n]), 0)] for n in ends]
    assert max(lift) < 0.2  # a pull at the neutral axis does not bend; at the middle of the plate: 25 times the stretch


def test_mass_on_a_spring(tmp_path):
    """COMBIN14 along its line carries MASS21: sqrt(k / m); a second one in a nodal direction turned by 90 degrees."""
    points = {1: (0, 0, 0), 2: (3, 4, 0), 3: (1, 0, 0), 4: (1, 0, 0)}
    rows = [(1, 1, 1, 1, 1, 0, (1, 2)), (2, 2, 1, 2, 1, 0, (2,)), (3, 3, 1, 3, 1, 0, (3, 4)), (4, 2, 1, 4, 1, 0, (4,))]
    types = {1: (14,), 2: (21, (3, 2)), 3: (14, (2, 1))}
    sets = {1: [8000.0, 3.0], 2: [2.0], 3: [500.0, 0.0], 4: [5.0]}
    held = "".join(f"D,{n},{d}\n" for n in (1, 3) for d in ("UX", "UY", "UZ"))
    fe = read(
        tmp_path, archive(types, rlblock(sets), nblock(points, {3: (90, 0, 0), 4: (90, 0, 0)}), eblock(rows), held)
    )
    found = np.sort(fem.eigenmodes(fe, "d", n=6).frequencies)[-2:]
    np.testing.assert_allclose(found, np.sqrt([500 / 5.0, 8000 / 2.0]) / (2 * np.pi), rtol=1e-6)
    assert abs(fe.K[freedom(fe, 4, 1), freedom(fe, 4, 1)]) == pytest.approx(500.0)  # nodal x lies along global y
    assert fe.C is not None


def test_rigid_beams_and_constraint_equations_are_the_same(tmp_path):
    """A lever at the tip: MPC184 rigid beams, and the six equations of CERIG, beside the formula for a rigid arm."""
    section = "SECTYPE, 1, BEAM, CSOLID\nSECDATA, 0.01\n"
    types = {1: (188,), 2: (184, (1, 1)), 3: (21, (3, 2))}
    lever = (
        "NBLOCK,3\n(1i9,3e20.9e3)\n" + f"{500:9d}" + "".join(f"{x:20.9E}" for x in (2.0, 0.5, 0.25)) + "\n       -1\n"
    )
    reals = rlblock({7: [4.0]})
    mass = (31, 3, 1, 7, 1, 0, (500,))
    rigid = read(tmp_path, cantilever(types, section + reals + lever, [(30, 2, 1, 1, 1, 0, (21, 500)), mass]))
    assert rigid.reference_points.keys() == {"mpc184_21"}
    arm = {"UX": ("ROTY", 0.25, "ROTZ", -0.5), "UY": ("ROTX", -0.25, "ROTZ", 0.0), "UZ": ("ROTX", 0.5, "ROTY", 0.0)}
    text = ""
    for k, d in enumerate(("UX", "UY", "UZ", "ROTX", "ROTY", "ROTZ"), 1):
        terms = [(500, d, -1.0), (21, d, 1.0), *((21, r, c) for r, c in zip(*[iter(arm.get(d, ()))] * 2) if c)]
        text += f"CE,R5.0,DEFI,{len(terms):8d},{k:8d},  0.00000000    \n"
        for at in range(0, len(terms), 2):
            text += "CE,R5.0,NODE," + ",".join(f"{n:10d},{d:<4},{c:14.8f}" for n, d, c in terms[at : at + 2]) + "\n"
    tied = read(tmp_path, cantilever(types, section + reals + lever, [mass], extra=text))
    np.testing.assert_allclose(
        fem.eigenmodes(rigid, "d", n=6).frequencies, fem.eigenmodes(tied, "d", n=6).frequencies, rtol=1e-7
    )
    total, centre = mass_and_center(rigid)
    beam = 7850 * np.pi * 1e-4 * 2.0
    assert total == pytest.approx(beam + 4.0)
    np.testing.assert_allclose(centre, (beam * np.array([1, 0, 0]) + 4.0 * np.array([2, 0.5, 0.25])) / total)
    data = reduction.reduce(rigid, interfaces="all", modes=4)
    assert "mpc184_21" in data.marker_names


def test_coupled_sets(tmp_path):
    """Two cubes joined by CP at their common face are one bar: k = E A / l without Poisson's ratio."""
    corners = [(0, 0), (1, 0), (1, 1), (0, 1)]
    points = {10 * side + k + 1: (x, *c) for side, x in enumerate((0, 1, 1, 2)) for k, c in enumerate(corners)}
    cells = [[*range(1, 5), *range(11, 15)], [*range(21, 25), *range(31, 35)]]
    words = "".join(
        f"CP,{3 * k + d},{u},{11 + k},{21 + k}\n" for k in range(4) for d, u in enumerate(("UX", "UY", "UZ"), 1)
    )
    steel = material(1, EX=210e9, NUXY=0.0, DENS=7850.0)
    text = archive({1: (185,)}, nblock(points), solids(cells), steel, words, cmblock("LEFT", "NODE", [1, -4]))
    fe = read(tmp_path, text)
    assert fe.node_set("LEFT").tolist() == [0, 1, 2, 3]
    load = sum(0.25 * fe_force(fe, k, 0) for k in range(31, 35))
    assert fem.static(fe, load, "LEFT")[freedom(fe, 31, 0)] == pytest.approx(2.0 / 210e9, rel=1e-9)


@pytest.mark.parametrize("angles", [None, (30.0, 20.0, 10.0)])
def test_equations_in_turned_axes(tmp_path, angles):
    """The same cubes joined by CE in axes that both nodes share: each freedom could be the one of each equation."""
    corners = [(0, 0), (1, 0), (1, 1), (0, 1)]
    points = {10 * side + k + 1: (x, *c) for side, x in enumerate((0, 1, 1, 2)) for k, c in enumerate(corners)}
    cells = [[*range(1, 5), *range(11, 15)], [*range(21, 25), *range(31, 35)]]
    pairs = [(k, d, u) for k in range(4) for d, u in enumerate(("UX", "UY", "UZ"), 1)]
    words = "".join(f"CE,{3 * k + d},0,{11 + k},{u},1,{21 + k},{u},-1\n" for k, d, u in pairs)
    steel = material(1, EX=210e9, NUXY=0.0, DENS=7850.0)
    turned = dict.fromkeys((*range(11, 15), *range(21, 25)), angles) if angles else {}
    text = archive({1: (185,)}, nblock(points, turned), solids(cells), steel, words, cmblock("LEFT", "NODE", [1, -4]))
    fe = read(tmp_path, text)
    load = sum(0.25 * fe_force(fe, k, 0) for k in range(31, 35))
    assert fem.static(fe, load, "LEFT")[freedom(fe, 31, 0)] == pytest.approx(2.0 / 210e9, rel=1e-9)
    with pytest.raises(MeshError, match=r"CE 1: a first term with the factor 0, or whose factors cancel"):
        read(tmp_path, text.replace(words, "CE,1,0,11,UX,1,11,UX,-1\n"))


def test_blocks_as_another_reader_reads_them(tmp_path):
    other = pytest.importorskip("mapdl_archive")
    points, cells = brick20((3, 2, 2), (0.3, 0.1, 0.05))
    points = {7 * k: np.add(p, 1 / 3) for k, p in points.items()}
    cells = [[7 * n for n in cell] for cell in cells]
    text = archive(
        {1: (186,), 4: (21,)}, nblock(points, {14: (10, 20, 30)}), solids(cells), rlblock({3: list(range(1, 10))})
    )
    path = tmp_path / "part.cdb"
    path.write_text(text + cmblock("SOME", "NODE", [7, 21, 28]))
    ours, theirs = read_archive(path), other.Archive(path, parse_vtk=False)
    np.testing.assert_array_equal(ours.labels, theirs.nnum)
    np.testing.assert_allclose(ours.points, theirs.nodes, rtol=1e-15)  # theirs is one last digit off
    np.testing.assert_array_equal(ours.angles, theirs.node_angles)
    for head, nodes, element in zip(ours.head, ours.nodes, theirs.elem, strict=True):
        np.testing.assert_array_equal([*head[:9], *nodes[: head[8]]], [*element[:8], len(element) - 10, *element[10:]])
        assert head[10] == element[8]
    assert ours.reals == {int(n): list(map(float, r)) for n, r in zip(theirs.rlblock_num, theirs.rlblock, strict=True)}
    np.testing.assert_array_equal(ours.components["SOME"][1], theirs.node_components["SOME"])


def whole():
    """Return an archive with every kind of block."""
    points, cells = brick20((1, 1, 1), (0.1, 0.1, 0.1))
    rows = [(1, 1, 1, 1, 1, 0, cells[0]), (2, 2, 1, 2, 1, 0, (1,)), (3, 3, 1, 1, 2, 0, (1, 2, 3, 4))]
    types = {1: (186,), 2: (21, (3, 2)), 3: (181,)}
    section = "SECTYPE,2,SHEL\nSECBLOCK,1\n 0.01, 1, 0.0, 3\n"
    return archive(
        types, rlblock({2: [2.0]}), section, nblock(points), eblock(rows), STEEL, cmblock("A", "ELEM", [1, -3])
    )


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("MPDATA,R5.0, 1,EX  ,       1", "MPDATA,R5.0, 1,EX  ,       9", ("material 1", "no EX")),
        ("SECTYPE,2", "SECTYPE,5", ("SHELL181", "section")),
        ("ET,        1,186", "ET,        7,186", ("type 1", "ET")),
        ("(3i9,6e21.13e3)", "(somehow)", ("NBLOCK", "format")),
        (" 1.0000000000000E-01", " 1.00x0000000000E-01", ("NBLOCK", "1.00x", ".cdb:")),
        ("EBLOCK,19,SOLID,         3,         3", "EBLOCK,19,SOLID,         3,         4", ("EBLOCK", "4")),
        ("N,R5.3,LOC,       -1,", "N,5,1.0,2.0,3.0", ("single commands", "BLOCKED")),
        ("TB,", "TB,", ("",)),
    ],
)
def test_bad_archives(tmp_path, old, new, words):
    text = whole()
    if old == "TB,":
        text, words = text + "TB,ANEL,1\n", ("material 1", "TB,ANEL")
    assert old == "TB," or old in text
    with pytest.raises(MeshError) as error:
        read(tmp_path, text.replace(old, new, 1))
    assert all(word in str(error.value) for word in words)


def test_a_mesh_without_materials_says_how_to_give_one(tmp_path):
    """The lines that the message names, put behind everything, are the material."""
    points, cells = brick20((1, 1, 1), (0.1, 0.2, 0.3))
    text = archive({1: ("SOLID186", (2, 1))}, nblock(points), solids(cells))
    with pytest.raises(MeshError, match=r"the material 1, which does not exist.*lines MP,EX,1,2\.1E11") as told:
        read(tmp_path, text)
    lines = re.findall(r"MP,\w+,1,[\d.E]+", told.value.remedy)
    assert lines == ["MP,EX,1,2.1E11", "MP,PRXY,1,0.3", "MP,DENS,1,7850"]
    fe = read(tmp_path, text + "\n".join(lines) + "\n")
    assert mass_and_center(fe)[0] == pytest.approx(7850 * 0.1 * 0.2 * 0.3)


def test_abbreviated_commands_are_the_same(tmp_path):
    masses = [mass_and_center(read(tmp_path, text))[0] for text in (whole(), whole().replace("SECBLOCK", "SECBLO"))]
    assert masses[0] == pytest.approx(masses[1])


def test_what_is_not_known_is_named(tmp_path):
    points, cells = brick20((1, 1, 1), (0.1, 0.1, 0.1))
    rows = [(1, 1, 1, 1, 1, 0, cells[0]), (2, 2, 1, 1, 1, 0, cells[0][:4])]
    text = archive({1: (186,), 2: (174,)}, nblock(points), eblock(rows), STEEL, "CERIG,1,2,ALL\n")
    with pytest.warns(fem.MeshWarning, match=r"CERIG.*CONTA174"):
        fe = read(tmp_path, text)
    plain = archive({1: (186,)}, nblock(points), eblock(rows[:1]), STEEL)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        alone = read(tmp_path, plain)
    assert abs(fe.K - alone.K).max() == 0.0
    assert fe.M.nnz > 0


def test_mutated_archives_end_with_words(tmp_path, rng):
    """Lines lost, doubled, cut, and characters changed: a model or an error of ours."""
    source = whole().split("\n")
    ends = {"read": 0, "refused": 0}
    for _ in range(150):
        lines = list(source)
        for _ in range(int(rng.integers(1, 4))):
            at, kind = int(rng.integers(len(lines))), int(rng.integers(4))
            if kind == 0:
                del lines[at]
            elif kind == 1:
                lines.insert(at, lines[int(rng.integers(len(lines)))])
            elif kind == 2:
                lines[at] = lines[at][: int(rng.integers(len(lines[at]) + 1))]
            elif lines[at]:
                k = int(rng.integers(len(lines[at])))
                lines[at] = lines[at][:k] + str(rng.choice(list("09-.,abE "))) + lines[at][k + 1 :]
        try:
            read(tmp_path, "\n".join(lines))
            ends["read"] += 1
        except FlexmbError:
            ends["refused"] += 1
    assert min(ends.values()) > 10


def test_a_node_number_beyond_64_bits_is_refused(tmp_path):
    """A support (D) whose node has thirty digits ended in an overflow."""
    points, cells = brick20((1, 1, 1), (0.1, 0.1, 0.1))
    text = archive({1: (186,)}, nblock(points), solids(cells), STEEL, f"D,{10**30},UX  ,  0.0,  0.0\n")
    with pytest.raises(MeshError, match=f"names the node {10**30}, which does not exist"):
        read(tmp_path, text)
