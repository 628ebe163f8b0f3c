"""Abaqus and CalculiX decks beside runs of CalculiX and the blocks of `fem`."""

import re
import subprocess
import warnings

import numpy as np
import pytest
from fem.structured import structured

from flexmb import fem, reduction
from flexmb.errors import MeshError
from flexmb.fem.deck.inventory import mass_and_center

pytestmark = pytest.mark.filterwarnings("ignore::flexmb.fem.meshes.mesh.MeshWarning")

STEEL = "*MATERIAL, NAME=STEEL\n*ELASTIC\n210e9, .3\n*DENSITY\n7850.\n"


def read(tmp_path, text, **options):
    path = tmp_path / "part.inp"
    path.write_text(text)
    return fem.read_deck(path, show=False, **options)


def bricks(counts, sizes, origin=(0.0, 0.0, 0.0), first=1, sets="ALL"):
    """Return *NODE and *ELEMENT of C3D8 bricks."""
    grids = [np.linspace(0, s, c + 1) + o for s, c, o in zip(sizes, counts, origin, strict=True)]
    number = {}
    lines = [f"*NODE, NSET=N{sets}"]
    for k, z in enumerate(grids[2]):
        for j, y in enumerate(grids[1]):
            for i, x in enumerate(grids[0]):
                number[i, j, k] = first + len(number)
                lines.append(f"{number[i, j, k]}, {x:.12g}, {y:.12g}, {z:.12g}")
    lines.append(f"*ELEMENT, TYPE=C3D8, ELSET={sets}")
    label = first
    for k in range(counts[2]):
        for j in range(counts[1]):
            for i in range(counts[0]):
                low = [number[i + a, j + b, k] for a, b in ((0, 0), (1, 0), (1, 1), (0, 1))]
                high = [number[i + a, j + b, k + 1] for a, b in ((0, 0), (1, 0), (1, 1), (0, 1))]
                lines.append(", ".join(map(str, [label, *low, *high])))
                label += 1
    return "\n".join(lines) + "\n"


def calculix(program, folder, text, count):
    """Return the frequencies, Hz, of a deck with a frequency step."""
    (folder / "job.inp").write_text(f"{text}*STEP\n*FREQUENCY\n{count}\n*END STEP\n")
    subprocess.run([program, "job"], cwd=folder, capture_output=True, check=True, timeout=60)
    found = (folder / "job.dat").read_text().split("P A R T I C I P A T I O N")[0]
    rows = re.findall(r"^\s+\d+\s+(\S+)\s+(\S+)\s+(\S+)\s+(\S+)\s*$", found, re.MULTILINE)
    return np.array([float(row[2]) for row in rows])


def test_instances_are_placed_and_turned(tmp_path):
    part = f"*PART, NAME=BLOCK\n{bricks((1, 1, 1), (1, 2, 3))}*SOLID SECTION, ELSET=ALL, MATERIAL=STEEL\n*END PART\n"
    text = (
        f"{part}*ASSEMBLY, NAME=A\n*INSTANCE, NAME=ONE, PART=BLOCK\n*END INSTANCE\n"
        "*INSTANCE, NAME=TWO, PART=BLOCK\n5., 0., 0.\n5., 0., 0., 5., 0., 1., 90.\n*END INSTANCE\n"
        f"*NSET, NSET=TIPS\nONE.8, TWO.8\n*END ASSEMBLY\n{STEEL}"
    )
    fe = read(tmp_path, text)
    # the second block lies at x = 5 - 2 .. 5, y = 0 .. 1
    np.testing.assert_allclose(fe.nodes[8:].min(axis=0), [3, 0, 0], atol=1e-12)
    np.testing.assert_allclose(fe.nodes[8:].max(axis=0), [5, 1, 3], atol=1e-12)
    np.testing.assert_allclose(fe.nodes[fe.node_set("TIPS")], [[1, 2, 3], [3, 1, 3]], atol=1e-12)
    assert mass_and_center(fe)[0] == pytest.approx(2 * 6 * 7850)
    assert {"ONE.ALL", "TWO.NALL"} <= set(fe.node_sets) | {name.upper() for name in fe.node_sets}


def test_tie_carries_constant_strain(tmp_path):
    """Two blocks whose meshes do not match, tied by projection: constant strain goes through both."""
    text = (
        bricks((1, 2, 2), (1, 1, 1), sets="LEFT")
        + bricks((1, 3, 3), (1, 1, 1), (1, 0, 0), 101, "RIGHT")
        + "*SOLID SECTION, ELSET=LEFT, MATERIAL=STEEL\n*SOLID SECTION, ELSET=RIGHT, MATERIAL=STEEL\n"
        + "*SURFACE, NAME=MASTER\nLEFT, S4\n*SURFACE, NAME=SLAVE, TYPE=NODE\nGLUED\n"
        + "*NSET, NSET=GLUED\n101, 103, 105, 107, 109, 111, 113, 115, 117, 119, 121, 123, 125, 127, 129, 131\n"
        + f"*TIE, NAME=SEAM\nSLAVE, MASTER\n{STEEL}"
    )
    fe = read(tmp_path, text)
    strain = np.diag([1e-3, -3e-4, -3e-4])  # uniaxial stress along x
    field = np.zeros((len(fe.nodes), 6, 1))
    field[:, :3, 0] = fe.nodes @ strain
    u = fe.vectors(field)
    np.testing.assert_allclose(fe.field(u), field, atol=1e-15)  # the tied nodes follow
    assert 0.5 * float((u.T @ fe.K @ u)[0, 0]) == pytest.approx(0.5 * 210e9 * 1e-6 * 2.0, rel=1e-9)
    modes = fem.eigenmodes(fe, n=7).frequencies
    assert modes[5] < 1e-3 * modes[6]  # six rigid motions: the blocks are one


def test_coupling_is_a_rigid_link(tmp_path):
    base = bricks((3, 1, 1), (3, 1, 1)).replace("C3D8", "C3D8I") + f"*SOLID SECTION, ELSET=ALL, MATERIAL=STEEL\n{STEEL}"
    tip = "*NODE\n900, 3., .5, .5\n*SURFACE, NAME=TIP, TYPE=NODE\n4\n8\n12\n16\n"
    coupled = read(
        tmp_path, base + tip + "*COUPLING, CONSTRAINT NAME=END, REF NODE=900, SURFACE=TIP\n*KINEMATIC\n1, 6\n"
    )
    plain = read(tmp_path, base)
    linked = fem.with_rigid_link(plain, (3.0, 0.5, 0.5), [3, 7, 11, 15], "END")
    a, b = (fem.eigenmodes(fe, n=10).frequencies[6:] for fe in (coupled, linked))
    np.testing.assert_allclose(a, b, rtol=1e-9)
    assert set(coupled.reference_points) == {"END"}
    data = reduction.reduce(coupled, interfaces=["END"], modes=3, compare=0)
    np.testing.assert_allclose(data.marker_positions, [[3, 0.5, 0.5]])
    spread = read(
        tmp_path, base + tip + "*COUPLING, CONSTRAINT NAME=END, REF NODE=900, SURFACE=TIP\n*DISTRIBUTING\n1, 6\n"
    )
    np.testing.assert_allclose(
        fem.eigenmodes(spread, n=10).frequencies[6:], fem.eigenmodes(plain, n=10).frequencies[6:], rtol=1e-9
    )


def test_equation_and_transform(tmp_path):
    text = bricks((1, 1, 1), (1, 1, 1)) + f"*SOLID SECTION, ELSET=ALL, MATERIAL=STEEL\n{STEEL}"
    turned = (
        "*NSET, NSET=T\n2\n*TRANSFORM, NSET=T, TYPE=R\n0., 1., 0., -1., 0., 0.\n*EQUATION\n2\n2, 1, 1., 3, 2, -2.\n"
    )
    fe = read(tmp_path, text + turned)
    field = fe.field(np.random.default_rng(3).standard_normal((fe.ndof, 1)))[:, :, 0]
    assert field[1, 1] == pytest.approx(2 * field[2, 1])  # direction 1 of the turned node is the basic y


def test_solid_with_orientation_beside_calculix(ccx, tmp_path):
    """An orthotropic block whose axes are turned: frequencies to the digits that CalculiX prints."""
    mesh = structured("hexahedron20", (3, 1, 1), (0.3, 0.05, 0.07), skew=0.1)
    ((_, cells),) = mesh.cells
    lines = ["*NODE, NSET=NALL", *(f"{k},{x:.16g},{y:.16g},{z:.16g}" for k, (x, y, z) in enumerate(mesh.points, 1))]
    lines.append("*ELEMENT, TYPE=C3D20, ELSET=ALL")
    for k, row in enumerate(cells + 1, 1):
        lines += [", ".join(map(str, [k, *row[:10]])) + ",", ", ".join(map(str, row[10:]))]
    foot = np.flatnonzero(mesh.points[:, 0] < 1e-9) + 1
    text = (
        "\n".join(lines)
        + "\n*MATERIAL, NAME=PLY\n*ELASTIC, TYPE=ENGINEERING CONSTANTS\n"
        + "135e9, 10e9, 9e9, .3, .28, .4, 5e9, 4.5e9,\n3.4e9\n*DENSITY\n1600.\n"
        + "*ORIENTATION, NAME=O, SYSTEM=RECTANGULAR\n1., .3, 0., -.2, 1., 0.\n"
        + "*SOLID SECTION, ELSET=ALL, MATERIAL=PLY, ORIENTATION=O\n*NSET, NSET=FOOT\n"
        + ",\n".join(map(str, foot))
        + "\n*BOUNDARY\nFOOT, 1, 3\n"
    )
    fe = read(tmp_path, text)
    assert set(fe.supports) == {"boundary"}
    ours = fem.eigenmodes(fe, "boundary", 4).frequencies
    np.testing.assert_allclose(ours, calculix(ccx, tmp_path, text, 4)[:4], rtol=1e-6)


@pytest.mark.parametrize(("kind", "tolerance"), [("S4", 2e-2), ("S8R", 2e-2)])
def test_shell_beside_calculix(ccx, tmp_path, kind, tolerance):
    """A clamped plate 1.0 x 0.5 m, 20 mm thick, first four frequencies."""
    nx, ny = (24, 12) if kind == "S4" else (8, 4)
    step = 1 if kind == "S4" else 2
    number, lines = {}, ["*NODE, NSET=NALL"]
    for j in range(step * ny + 1):
        for i in range(step * nx + 1):
            if step == 2 and i % 2 and j % 2:
                continue
            number[i, j] = len(number) + 1
            lines.append(f"{number[i, j]}, {i / (step * nx):.12g}, {0.5 * j / (step * ny):.12g}, 0.")
    lines.append(f"*ELEMENT, TYPE={kind}, ELSET=ALL")
    corners = ((0, 0), (1, 0), (1, 1), (0, 1)) if step == 1 else (
        (0, 0), (2, 0), (2, 2), (0, 2), (1, 0), (2, 1), (1, 2), (0, 1))  # fmt: skip
    for j in range(0, step * ny, step):
        for i in range(0, step * nx, step):
            lines.append(", ".join(map(str, [i * 1000 + j + 1, *(number[i + a, j + b] for a, b in corners)])))
    foot = [n for (i, _), n in number.items() if i == 0]
    text = "\n".join(lines) + f"\n{STEEL}*SHELL SECTION, ELSET=ALL, MATERIAL=STEEL\n.02\n*NSET, NSET=FOOT\n"
    text += ",\n".join(map(str, foot)) + "\n*BOUNDARY\nFOOT, 1, 6\n"
    ours = fem.eigenmodes(read(tmp_path, text), "boundary", 4).frequencies
    theirs = calculix(ccx, tmp_path, text, 4)
    np.testing.assert_allclose(ours, theirs[:4], rtol=tolerance)


def test_beam_beside_calculix(ccx, tmp_path):
    """A clamped beam of rectangular section by elements of three nodes."""
    count = 16
    lines = ["*NODE"] + [f"{k + 1}, {2.0 * k / (2 * count):.12g}, 0., 0." for k in range(2 * count + 1)]
    lines.append("*ELEMENT, TYPE=B32R, ELSET=ALL")
    lines += [f"{k + 1}, {2 * k + 1}, {2 * k + 2}, {2 * k + 3}" for k in range(count)]
    text = "\n".join(lines) + f"\n{STEEL}*BEAM SECTION, ELSET=ALL, MATERIAL=STEEL, SECTION=RECT\n.05, .08\n0., 1., 0.\n"
    text += "*BOUNDARY\n1, 1, 6\n"
    fe = read(tmp_path, text)
    ours = fem.eigenmodes(fe, "boundary", 4).frequencies
    np.testing.assert_allclose(ours, calculix(ccx, tmp_path, text, 4)[:4], rtol=1e-2)
    # width .05 along the 1-axis (y), .08 along z: the softer bending is in the x-y plane
    assert ours[0] == pytest.approx(
        (1.8751040687 / 2) ** 2 * np.sqrt(210e9 * 0.05**2 / 12 / 7850) / (2 * np.pi), rel=2e-3
    )


def beams_with_a_node_of_direction(place: str, ends: str = "{a}, {b}, 99") -> str:
    """Return a clamped beam of B31 whose elements name node 99 for the direction of their width."""
    lines = [
        "*NODE",
        f"99, {place}",
        *(f"{k + 1}, {k / 8}, 0., 0." for k in range(17)),
        "*ELEMENT, TYPE=B31, ELSET=ALL",
    ]
    lines += [f"{k}, " + ends.format(a=k, b=k + 1) for k in range(1, 17)]
    text = "\n".join(lines) + f"\n{STEEL}*BEAM SECTION, ELSET=ALL, MATERIAL=STEEL, SECTION=RECT\n.05, .08\n"
    return text + "0., 1., 0.\n*BOUNDARY\n1, 1, 6\n"


@pytest.mark.parametrize(("place", "softer"), [("0., 1., 0.", 1), ("0., 0., 1.", 2)])
def test_a_third_node_of_a_beam_gives_its_direction(tmp_path, place, softer):
    """Bernoulli's cantilever: the softer bending is along the width of 0.05, towards the node."""
    fe = read(tmp_path, beams_with_a_node_of_direction(place))
    modes = fem.eigenmodes(fe, "boundary", 2)
    height = {softer: 0.05, 3 - softer: 0.08}
    tip = int(np.argmax(fe.nodes[:, 0]))
    for k, direction in enumerate((softer, 3 - softer)):
        exact = (1.8751040687 / 2) ** 2 * np.sqrt(210e9 * height[direction] ** 2 / 12 / 7850) / (2 * np.pi)
        assert modes.frequencies[k] == pytest.approx(exact, rel=3e-3)
        moved = np.abs(fe.field(modes.shapes[:, [k]])[tip, :3, 0])
        assert int(np.argmax(moved)) == direction


def test_a_beam_with_one_node_is_named(tmp_path):
    with pytest.raises(MeshError, match="element 1 of type B31 with 1 nodes"):
        read(tmp_path, beams_with_a_node_of_direction("0., 1., 0.", "{a}"))


def test_sets_and_surfaces_of_all_kinds(tmp_path):
    text = (
        bricks((2, 1, 1), (2, 1, 1))
        + "*NSET, NSET=ODD, GENERATE\n1, 11, 2\n*NSET, NSET=GAPS, GENERATE\n1, 100, 1\n*NSET, NSET=BOTH\nODD, 2\n"
        + "*ELSET, ELSET=E1\n1\n*NSET, NSET=OFE, ELSET=E1\n*SURFACE, NAME=SKIN\nALL\n*SURFACE, NAME=TOP\nALL, S2\n"
        + f"*SURFACE, NAME=POINTS, TYPE=NODE\nODD\n*SOLID SECTION, ELSET=ALL, MATERIAL=STEEL\n{STEEL}"
    )
    fe = read(tmp_path, text)
    np.testing.assert_array_equal(fe.node_set("BOTH"), [0, 1, 2, 4, 6, 8, 10])
    assert len(fe.node_set("GAPS")) == 12
    assert len(fe.node_set("OFE")) == 8
    np.testing.assert_array_equal(fe.node_set("POINTS"), fe.node_set("ODD"))
    assert len(fe.facet_sets["SKIN"]) == 10  # without the face between the two
    area = fem.pressure_load(fe, "TOP").reshape(-1, 3).sum(axis=0)
    np.testing.assert_allclose(np.abs(area), [0, 0, 2], atol=1e-12)


def test_springs_masses_and_dampers(tmp_path):
    text = (
        "*NODE\n1, 0., 0., 0.\n2, 1., 0., 0.\n*ELEMENT, TYPE=SPRINGA, ELSET=S\n1, 1, 2\n*SPRING, ELSET=S\n\n500.\n"
        "*ELEMENT, TYPE=MASS, ELSET=M\n2, 1\n3, 2\n*MASS, ELSET=M\n2.\n*ELEMENT, TYPE=DASHPOTA, ELSET=D\n4, 1, 2\n"
        "*DASHPOT, ELSET=D\n\n.5\n"
    )
    fe = read(tmp_path, text)
    free = np.flatnonzero(fe.dofs[:, 1] == 0)
    np.testing.assert_allclose(fe.K[free][:, free].toarray(), [[500, -500], [-500, 500]])
    np.testing.assert_allclose(fe.M[free][:, free].toarray(), np.diag([2, 2]))
    np.testing.assert_allclose(fe.C[free][:, free].toarray(), [[0.5, -0.5], [-0.5, 0.5]])


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (("MATERIAL=STEEL", "MATERIAL=STEAL"), "the material 'steal', which does not exist"),
        (
            ("ELSET=ALL, MATERIAL", "ELSET=NONE, MATERIAL"),
            r"part.inp:\d+, \*SOLID SECTION.*'NONE', which does not exist",
        ),
        (("1, 1, 2, 4", "1, 1, 2, 77"), "node 77, which does not exist"),
        (("210e9, .3", "210e9, .6"), "nu = 0.6"),
        (("210e9, .3", "nan, .3"), "'nan'"),
        (("*DENSITY\n7850.", "*DENSITY\nheavy"), "'heavy'"),
        (("TYPE=C3D8", "TYPE=C3D20"), "with 8 nodes. Expected: 20 nodes"),
        (("*ELASTIC\n", "*PLASTIC\n"), r"without \*ELASTIC"),
        (("*SOLID SECTION", "*INCLUDE, INPUT=part.inp\n*SOLID SECTION"), "include each other"),
        (("*SOLID SECTION", "*NGEN\n1, 5\n*SOLID SECTION"), "NGEN.*Write the deck expanded"),
        (("*SOLID", "*EQUATION\n2\n1, 1, 0., 2, 1, 1.\n*SOLID"), r"\*EQUATION: a first term with the factor 0"),
        (("*SOLID", "*EQUATION\n2\n1, 1, 1., 1, 1, -1.\n*SOLID"), r"\*EQUATION: a first term .* whose factors cancel"),
    ],
)
def test_bad_decks(tmp_path, change, words):
    text = bricks((1, 1, 1), (1, 1, 1)) + f"*SOLID SECTION, ELSET=ALL, MATERIAL=STEEL\n{STEEL}"
    assert change[0] in text
    with pytest.raises(MeshError, match=f"(?s){words}"):
        read(tmp_path, text.replace(*change, 1))


@pytest.mark.filterwarnings("default::flexmb.fem.meshes.mesh.MeshWarning")
def test_elements_without_section_are_told(tmp_path):
    """And left out: the block keeps its own mass. With a section for all there is nothing to tell."""
    text = bricks((1, 1, 1), (1, 1, 1)).replace("C3D8", "C3D8I") + f"*SOLID SECTION, ELSET=ALL, MATERIAL=STEEL\n{STEEL}"
    with pytest.warns(fem.MeshWarning, match=r"S3: no section \(1\)"):
        with_foil = read(tmp_path, text + "*ELEMENT, TYPE=S3, ELSET=FOIL\n77, 1, 2, 3\n")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        plain = read(tmp_path, text)
    assert mass_and_center(with_foil)[0] == pytest.approx(mass_and_center(plain)[0], rel=1e-12)
    assert mass_and_center(plain)[0] == pytest.approx(7850.0, rel=1e-9)


def test_mutated_decks_never_end_in_a_traceback(tmp_path):
    """400 decks with changed, lost and repeated bytes: read, or refused by name."""
    random = np.random.default_rng(20261122)
    seed = bricks((2, 1, 1), (2, 1, 1)) + f"*SOLID SECTION, ELSET=ALL, MATERIAL=STEEL\n{STEEL}"
    seed += "*NODE\n900, 2., .5, .5\n*SURFACE, NAME=TIP\nALL, S4\n*COUPLING, REF NODE=900, SURFACE=TIP\n*KINEMATIC\n"
    seed += "*EQUATION\n2\n1, 1, 1., 2, 2, -2.\n*NSET, NSET=G, GENERATE\n1, 9, 2\n*BOUNDARY\nG, 1, 3\n"
    refused = 0
    for _ in range(400):
        data = bytearray(seed.encode())
        for _ in range(int(random.integers(1, 4))):
            at, kind = int(random.integers(0, len(data))), random.integers(4)
            if kind == 0:
                data[at] = int(random.integers(32, 127))
            elif kind == 1:
                del data[at : at + int(random.integers(1, 12))]
            elif kind == 2:
                data[at:at] = data[at : at + int(random.integers(1, 30))]
            else:
                data[at:at] = random.choice([b"-1", b"9" * 20, b"1e308", b",,,", b"nan", b"*"])
        path = tmp_path / "part.inp"
        path.write_bytes(bytes(data))
        try:
            fem.read_deck(path, show=False)
        except MeshError:
            refused += 1
    assert 30 < refused < 395


SECOND = [(0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7)]


def bricks20(grids, first, name):
    """Return *NODE and *ELEMENT of C3D20 bricks on the grids of three coordinates, and the points by number."""
    number, points, rows = {}, {}, []

    def node(at):
        if at not in number:
            number[at] = first + len(number)
            points[number[at]] = at
        return number[at]

    unit = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]
    for k in range(len(grids[2]) - 1):
        for j in range(len(grids[1]) - 1):
            for i in range(len(grids[0]) - 1):
                own = [
                    tuple(float(g[n + s]) for g, n, s in zip(grids, (i, j, k), shift, strict=True)) for shift in unit
                ]
                middles = [tuple((np.array(own[a]) + own[b]) / 2) for a, b in SECOND]
                rows.append([node(at) for at in own] + [node(at) for at in middles])
    nodes = "".join(f"{k}, {x:.12g}, {y:.12g}, {z:.12g}\n" for k, (x, y, z) in points.items())
    cells = "".join(
        f"{first + k}, {', '.join(map(str, row[:10]))},\n{', '.join(map(str, row[10:]))}\n"
        for k, row in enumerate(rows)
    )
    return f"*NODE\n{nodes}*ELEMENT, TYPE=C3D20, ELSET={name}\n{cells}", points


def moved(fe, displacement):
    """Return the field (n, 3) that free freedoms give if they move by a function of the position."""
    field = np.zeros((len(fe.nodes), 6, 1))
    field[:, :3, 0] = displacement(fe.nodes)
    return fe.field(fe.vectors(field))[:, :3, 0]


def test_later_steps_do_not_hold_the_model(tmp_path):
    """Supports of the second and third step belong to them; only those of the first are kept."""
    text = (
        bricks((2, 1, 1), (2, 1, 1))
        + f"{STEEL}*SOLID SECTION, ELSET=ALL, MATERIAL=STEEL\n"
        + "*STEP\n*STATIC\n*BOUNDARY\n1, 1, 3\n*END STEP\n*STEP\n*STATIC\n*BOUNDARY\n2, 1, 3\n*END STEP\n"
        + "*STEP\n*STATIC\n*BOUNDARY\n3, 1, 3\n*END STEP\n"
    )
    assert read(tmp_path, text).supports["boundary"].tolist() == [[0, 0], [0, 1], [0, 2]]


def test_tie_of_second_order_follows_the_midside_nodes(tmp_path):
    """Layers of two and three C3D20 bend together: the tied nodes reproduce a parabola, which bending is."""
    low, _ = bricks20(([0, 0.4, 1], [0, 0.5], [0, 0.1]), 1, "LOW")
    high, points = bricks20(([0, 0.3, 0.8, 1], [0, 0.3, 0.5], [0.1, 0.2]), 1001, "HIGH")
    glued = ",\n".join(str(k) for k, at in points.items() if at[2] < 0.11)
    text = (
        f"{low}{high}{STEEL}*SOLID SECTION, ELSET=LOW, MATERIAL=STEEL\n*SOLID SECTION, ELSET=HIGH, MATERIAL=STEEL\n"
        f"*NSET, NSET=GLUED\n{glued}\n*SURFACE, NAME=S, TYPE=NODE\nGLUED\n*SURFACE, NAME=M\nLOW, S2\n"
        "*TIE, NAME=T\nS, M\n"
    )
    fe = read(tmp_path, text)

    def bending(x):
        return np.stack([x[:, 0] * x[:, 2], 0.0 * x[:, 0], -0.5 * x[:, 0] ** 2], axis=1)

    np.testing.assert_allclose(moved(fe, bending), bending(fe.nodes), atol=1e-12)
    assert fe.ndof < 3 * len(fe.nodes)


@pytest.mark.parametrize("second", [False, True])
def test_distributing_coupling_weighs_by_area(tmp_path, second):
    """The mean of y^2 over a unit face with uneven elements: by the trapezoidal rule, and exactly for second order."""
    y = [0.0, 0.1, 0.4, 1.0]
    if second:
        mesh, expected = bricks20(([0, 1], y, [0, 0.5, 1]), 1, "ALL")[0], 1.0 / 3.0
    else:
        mesh, expected = bricks((1, 3, 2), (1, 3, 1)), np.trapezoid(np.square(y), y)
        for k in (3, 2, 1):
            mesh = re.sub(rf"(?m)^(\d+, \d+), {k}, ([\d.]+)$", rf"\1, {y[k]}, \2", mesh)
    text = (
        f"{mesh}*NODE\n9000, 1.2, 0.5, 0.5\n*SURFACE, NAME=S\nALL, S4\n{STEEL}"
        "*SOLID SECTION, ELSET=ALL, MATERIAL=STEEL\n*COUPLING, REF NODE=9000, SURFACE=S, CONSTRAINT NAME=C\n"
        "*DISTRIBUTING\n1, 6\n"
    )
    fe = read(tmp_path, text)
    node = int(np.flatnonzero(fe.labels == 9000)[0])
    # y^2 along x: the least-squares rigid motion; about z it turns round the centre of the area, where the node is
    field = moved(fe, lambda x: np.stack([x[:, 1] ** 2, 0.0 * x[:, 0], 0.0 * x[:, 0]], axis=1))
    assert field[node, 0] == pytest.approx(expected, rel=1e-9)
    data = reduction.reduce(fe, interfaces="all", modes=2)
    assert data.marker_names == ("C",)


def test_distributing_coupling_of_an_element_takes_its_weights(tmp_path):
    text = (
        bricks((1, 1, 1), (1, 1, 1))
        + "*NODE\n50, 1., .5, .9\n*ELEMENT, TYPE=DCOUP3D, ELSET=E1\n33, 50\n*DISTRIBUTING COUPLING, ELSET=E1\n"
        + f"2, 3.\n4, 1.\n6, 3.\n8, 1.\n{STEEL}*SOLID SECTION, ELSET=ALL, MATERIAL=STEEL\n"
    )
    fe = read(tmp_path, text)
    at = fe.reference_points["E1"]
    assert at.weights.tolist() == [3, 1, 3, 1]
    node = int(np.flatnonzero(fe.labels == 50)[0])
    # u_x = y z: the best plane through it, with y weighed 3 : 1 and z 1 : 1, is 1/8 + (y - 1/4) / 2 + (z - 1/2) / 4
    field = moved(fe, lambda x: np.stack([x[:, 1] * x[:, 2], 0.0 * x[:, 0], 0.0 * x[:, 0]], axis=1))
    assert field[node, 0] == pytest.approx(0.35)


def test_nodal_thickness(tmp_path):
    """One shell of 1 m2, 10, 10, 30 and 30 mm thick at its nodes, weighs as one of 20 mm if its section asks for it.

    CalculiX passes over the thicknesses otherwise; they were taken.
    """
    text = (
        "*NODE\n1, 0, 0, 0\n2, 1, 0, 0\n3, 1, 1, 0\n4, 0, 1, 0\n*ELEMENT, TYPE=S4, ELSET=ALL\n1, 1, 2, 3, 4\n"
        f"{STEEL}*SHELL SECTION, ELSET=ALL, MATERIAL=STEEL, NODAL THICKNESS\n0.01\n"
        "*NODAL THICKNESS\n3, 0.03\n4, 0.03\n"
    )
    assert mass_and_center(read(tmp_path, text))[0] == pytest.approx(7850 * 0.02)
    other = read(tmp_path, text.replace(", NODAL THICKNESS\n0.01", "\n0.01"))
    assert mass_and_center(other)[0] == pytest.approx(7850 * 0.01)
    assert any("NODAL THICKNESS" in words for words in other.source["left_out"])


@pytest.mark.filterwarnings("default::flexmb.fem.meshes.mesh.MeshWarning")
def test_misspelt_density_is_told(tmp_path, capsys):
    """One of two materials has no density: the warning names it and the keyword that nobody knows."""
    rows = bricks((1, 1, 1), (1, 1, 1), sets="A") + bricks((1, 1, 1), (1, 1, 1), (1, 0, 0), first=20, sets="B")
    foam = STEEL.replace("STEEL", "Foam").replace("*DENSITY", "*Densty")
    sections = "*SOLID SECTION, ELSET=A, MATERIAL=STEEL\n*SOLID SECTION, ELSET=B, MATERIAL=foam\n"
    text = f"*HEADING\nx\n{rows}{sections}{STEEL}{foam}"
    path = tmp_path / "two.inp"
    path.write_text(text)
    with pytest.warns(fem.MeshWarning) as told:
        fe = fem.read_deck(path, units="m, kg, s")
    words = " ".join(str(w.message) for w in told)
    assert "materials without density, whose elements weigh nothing: Foam" in words
    assert re.search(r"left out: \*DENSTY, a keyword that is not known: .*DENSITY", words)
    assert fe.source["without_density"] == ["Foam"]
    assert fe.source["not_needed"] == {"*HEADING": 1}
    assert "no density    Foam" in capsys.readouterr().out
    assert fem.deck_checks(fe).mass == pytest.approx(7850.0)


@pytest.mark.parametrize(
    ("constants", "words"), [("-1., .3", "Young's modulus E = -1"), ("7e10, .51", "ratio nu = 0.51")]
)
def test_constants_of_elasticity_are_named(tmp_path, constants, words):
    text = f"{bricks((1, 1, 1), (1, 1, 1))}*SOLID SECTION, ELSET=ALL, MATERIAL=STEEL\n{STEEL}"
    with pytest.raises(MeshError, match=words):
        read(tmp_path, text.replace("210e9, .3", constants))


@pytest.mark.filterwarnings("error::flexmb.fem.meshes.mesh.MeshWarning")
def test_poissons_ratio_of_a_half_is_named(tmp_path):
    """Rubber of E = 5 MPa: its modulus is no reason to doubt the units, and its ratio is told."""
    text = f"{bricks((1, 1, 1), (1, 1, 1))}*SOLID SECTION, ELSET=ALL, MATERIAL=STEEL\n{STEEL}"
    fe = read(tmp_path, text.replace("210e9, .3", "5e6, .5").replace("7850.", "1100."), units="m, kg, s")
    assert list(fe.source["approximated"]) == ["STEEL: Poisson's ratio near 0.5, taken as 0.4999"]


def test_coupling_without_kind(tmp_path):
    mesh = f"{bricks((1, 1, 1), (1, 1, 1))}*SURFACE, NAME=TOP\nALL, S2\n*NODE, NSET=REF\n99, .5, .5, 2.\n"
    text = f"{mesh}*SOLID SECTION, ELSET=ALL, MATERIAL=STEEL\n{STEEL}*COUPLING, REFNODE=REF, SURFACE=TOP\n"
    with pytest.raises(MeshError, match=r"neither \*KINEMATIC nor \*DISTRIBUTING follows it.*one of them"):
        read(tmp_path, text)


@pytest.mark.parametrize("kind", ["SPRINGA", "SPRING2"])
def test_a_spring_between_two_nodes_with_one_is_refused(tmp_path, kind):
    text = f"*NODE\n1, 0., 0., 0.\n2, 1., 0., 0.\n*ELEMENT, TYPE={kind}, ELSET=S\n7, 2\n*SPRING, ELSET=S\n1, 1\n5.\n"
    with pytest.raises(MeshError, match=rf"element 7 of type {kind} with 1 nodes"):
        read(tmp_path, text)


def test_a_surface_on_an_element_of_too_few_nodes_is_refused(tmp_path):
    text = bricks((1, 1, 1), (1, 1, 1)) + "*ELEMENT, TYPE=C3D8, ELSET=BAD\n9, 1, 2, 3\n*SURFACE, NAME=S\nBAD, S2\n"
    with pytest.raises(MeshError, match=r"Element 9 of type C3D8: 3 nodes, of which a surface asks for face S2"):
        read(tmp_path, text + STEEL + "*SOLID SECTION, ELSET=ALL, MATERIAL=STEEL\n")
