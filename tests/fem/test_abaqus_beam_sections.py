"""Sections, places and directions of Abaqus and CalculiX beams beside closed forms; keywords whose parameters count."""

import re

import numpy as np
import pytest

from flexmb import fem
from flexmb.errors import MeshError

pytestmark = pytest.mark.filterwarnings("ignore::flexmb.fem.meshes.mesh.MeshWarning")
E, G, LENGTH = 210e9, 210e9 / 2.6, 4.0
HEAD = "*NODE\n1, 0., 0., 0.\n2, 4., 0., 0.\n*ELEMENT, TYPE=B31, ELSET=B\n1, 1, 2\n*BOUNDARY\n1, 1, 6\n"
STEEL = "*MATERIAL, NAME=S\n*ELASTIC\n210e9, .3\n*DENSITY\n7850.\n"


def read(tmp_path, text):
    path = tmp_path / "part.inp"
    path.write_text(text)
    return fem.read_deck(path, show=False)


def tip(fe, direction, node=1):
    """Return the motion (6,) of a node under a unit force or moment."""
    load = np.zeros((len(fe.nodes), 6, 1))
    load[node, direction] = 1.0
    return fe.field(fem.static(fe, fe.forces(load)[:, 0], fem.fixed_freedoms(fe, "boundary")))[node, :, 0]


def rectangles(parts):
    """Return area, centre and (int x1^2, int x2^2, int x1 x2) about it of rectangles (x1 from, to, x2 from, to)."""
    p = np.array(parts)
    a = (p[:, 1] - p[:, 0]) * (p[:, 3] - p[:, 2])
    c = np.stack([p[:, 0] + p[:, 1], p[:, 2] + p[:, 3]], axis=1) / 2
    centre = a @ c / a.sum()
    d = c - centre
    own = a[:, None] * np.stack([p[:, 1] - p[:, 0], p[:, 3] - p[:, 2]], axis=1) ** 2 / 12
    return a.sum(), centre, *(own + a[:, None] * d**2).sum(axis=0), float(a @ (d[:, 0] * d[:, 1]))


SECTIONS = {
    "RECT": (".05, .08", [(-0.025, 0.025, -0.04, 0.04)]),
    "BOX": (
        ".06, .04, .002, .006, .004, .003",
        [(0.028, 0.03, -0.02, 0.02), (-0.03, -0.026, -0.02, 0.02), (-0.026, 0.028, 0.014, 0.02)]
        + [(-0.026, 0.028, -0.02, -0.017)],
    ),
    "I": (
        ".03, .1, .06, .04, .004, .006, .005",
        [(-0.03, 0.03, -0.03, -0.026), (-0.02, 0.02, 0.064, 0.07), (-0.0025, 0.0025, -0.026, 0.064)],
    ),
    "L": (".06, .05, .004, .003", [(0.0, 0.06, 0.0, 0.004), (0.0, 0.003, 0.004, 0.05)]),
}


@pytest.mark.parametrize("shape", SECTIONS)
def test_bending_and_place_of_sections(tmp_path, shape):
    """w = l^3 / 3 E of the inertias about the area centre; an axial force bends with the centre's place as its arm."""
    words, parts = SECTIONS[shape]
    area, centre, i22, i11, i12 = rectangles(parts)
    if shape == "L":
        centre = 0.0 * centre  # told: its area centre lies at the nodes
    fe = read(tmp_path, f"{HEAD}{STEEL}*BEAM SECTION, ELSET=B, MATERIAL=S, SECTION={shape}\n{words}\n0., 1., 0.\n")
    soft = np.linalg.inv(E * np.array([[i22, i12], [i12, i11]]))
    for k in range(2):
        np.testing.assert_allclose(tip(fe, 1 + k)[1:3], LENGTH**3 / 3 * soft[k], atol=4e-3 * LENGTH**3 / 3 * soft[k, k])
    along = tip(fe, 0)
    assert along[0] == pytest.approx(LENGTH / E / area + LENGTH * centre @ soft @ centre, rel=1e-6)
    # a force at the nodes is a moment -centre about the area centre: curvature soft @ centre, deflection -l^2 / 2 of it
    expected = LENGTH**2 / 2 * soft @ centre
    np.testing.assert_allclose(np.abs(along[1:3]), np.abs(expected), atol=1e-3 * np.abs(expected).max() + 1e-18)
    np.testing.assert_allclose(np.sign(along[1:3][np.abs(centre) > 0]), np.sign(expected[np.abs(centre) > 0]))


def test_pipe_and_closed_box(tmp_path):
    """A pipe of radius r and wall t; torsion of a box by Bredt: 4 A_m^2 / sum(s / t)."""
    fe = read(tmp_path, f"{HEAD}{STEEL}*BEAM SECTION, ELSET=B, MATERIAL=S, SECTION=PIPE\n.03, .002\n0., 1., 0.\n")
    inertia = np.pi / 4 * (0.03**4 - 0.028**4)
    assert tip(fe, 1)[1] == pytest.approx(LENGTH**3 / 3 / E / inertia, rel=1e-3)
    assert tip(fe, 3)[3] == pytest.approx(LENGTH / G / (2 * inertia), rel=1e-9)
    walls = ".06, .04, .002, .002, .002, .002"
    fe = read(tmp_path, f"{HEAD}{STEEL}*BEAM SECTION, ELSET=B, MATERIAL=S, SECTION=BOX\n{walls}\n0., 1., 0.\n")
    constant = 4 * (0.058 * 0.038) ** 2 / (2 * (0.058 + 0.038) / 0.002)
    assert tip(fe, 3)[3] == pytest.approx(LENGTH / G / constant, rel=1e-9)


def test_an_ellipse(tmp_path):
    """CIRC of CalculiX has two thicknesses: I = pi a b^3 / 4, J = pi a^3 b^3 / (a^2 + b^2)."""
    fe = read(tmp_path, f"{HEAD}{STEEL}*BEAM SECTION, ELSET=B, MATERIAL=S, SECTION=CIRC\n.06, .04\n0., 1., 0.\n")
    a, b = 0.03, 0.02
    assert tip(fe, 1)[1] == pytest.approx(LENGTH**3 / 3 / E / (np.pi / 4 * a**3 * b), rel=1e-3)
    assert tip(fe, 2)[2] == pytest.approx(LENGTH**3 / 3 / E / (np.pi / 4 * a * b**3), rel=1e-3)
    assert tip(fe, 3)[3] == pytest.approx(LENGTH / G / (np.pi * (a * b) ** 3 / (a**2 + b**2)), rel=1e-9)


@pytest.mark.parametrize(
    ("shape", "more", "behind", "words"),
    [
        ("I", ", OFFSET1=.5", "", "OFFSET1, OFFSET2 of a section I"),
        ("L", ", OFFSET2=.5", "", "OFFSET1, OFFSET2 of a section L"),
        ("RECT", "", "*CENTROID\n.01, 0.\n", "CENTROID behind a section RECT"),
    ],
)
def test_places_that_a_section_does_not_take_are_told(tmp_path, shape, more, behind, words):
    section = f"*BEAM SECTION, ELSET=B, MATERIAL=S, SECTION={shape}{more}\n{SECTIONS[shape][0]}\n0., 1., 0.\n"
    assert words in "; ".join(read(tmp_path, HEAD + STEEL + section + behind).source["left_out"])


def test_offsets_of_beams(tmp_path):
    """OFFSET1 = 0.5: the nodes lie on the face towards 1, the axis half the thickness beneath (CalculiX)."""
    words = "*BEAM SECTION, ELSET=B, MATERIAL=S, SECTION=RECT, OFFSET1=0.5, OFFSET2=-1.\n.05, .08\n0., 1., 0.\n"
    along = tip(read(tmp_path, HEAD + STEEL + words), 0)
    b = E * 0.05 * 0.08 / 12
    expected = LENGTH**2 / 2 * np.array([-0.025 / (b * 0.05**2), 0.08 / (b * 0.08**2)])
    np.testing.assert_allclose(along[1:3], expected, rtol=1e-6)


def test_centroid_of_a_general_section(tmp_path):
    along = tip(read(tmp_path, f"{HEAD}{STEEL}{GENERAL}*CENTROID\n.02, -.03\n"), 0)
    np.testing.assert_allclose(along[1:3], LENGTH**2 / 2 / E * np.array([0.02 / 2e-6, -0.03 / 1e-6]), rtol=1e-6)


GENERAL = "*BEAM GENERAL SECTION, ELSET=B, SECTION=GENERAL, MATERIAL=S\n1e-3, 1e-6, 0., 2e-6, 1e-6\n0., 1., 0.\n"


@pytest.mark.parametrize(("behind", "place"), [("", (0.0, 0.0)), ("*SHEAR CENTER\n.01, .04\n", (0.01, 0.04))])
def test_shear_centre_of_a_general_section(tmp_path, behind, place):
    """A force at the nodes twists by its arm about the shear centre, which is not the area centre."""
    fe = read(tmp_path, f"{HEAD}{STEEL}{GENERAL}*CENTROID\n.02, -.03\n{behind}")
    assert tip(fe, 1)[3] == pytest.approx(place[1] * LENGTH / G / 1e-6, rel=1e-6)
    assert tip(fe, 2)[3] == pytest.approx(-place[0] * LENGTH / G / 1e-6, rel=1e-6)


def test_height_of_a_general_section_of_shape_i(tmp_path):
    words = SECTIONS["I"][0]
    kinds = ("BEAM SECTION", "BEAM GENERAL SECTION")
    own = [
        tip(read(tmp_path, f"{HEAD}{STEEL}*{k}, ELSET=B, MATERIAL=S, SECTION=I\n{words}\n0., 1., 0.\n"), 0)
        for k in kinds
    ]
    assert abs(own[0][2]) > 1e-9
    np.testing.assert_allclose(own[1], own[0], rtol=1e-9)


@pytest.mark.parametrize(("words", "first", "second"), [("1e6, 2e6", 2e6, 1e6), ("3e6", 3e6, 3e6), (", 3e6", 3e6, 3e6)])
@pytest.mark.parametrize("general", [False, True])
def test_transverse_shear_stiffness_of_beams(tmp_path, words, first, second, general):
    """K23 and K13: l^3 / 3 E I + l / K along 2 and 1."""
    rect = "*BEAM SECTION, ELSET=B, MATERIAL=S, SECTION=RECT\n.05, .08\n0., 1., 0.\n"
    section = GENERAL if general else rect
    inertias = (2e-6, 1e-6) if general else (0.08 * 0.05**3 / 12, 0.05 * 0.08**3 / 12)
    fe = read(tmp_path, f"{HEAD}{STEEL}{section}*TRANSVERSE SHEAR STIFFNESS\n{words}\n")
    for k, (inertia, stiff) in enumerate(zip(inertias, (first, second), strict=True)):
        assert tip(fe, 1 + k)[1 + k] == pytest.approx(LENGTH**3 / 3 / E / inertia + LENGTH / stiff, rel=1e-6)


def test_a_direction_along_the_beam_is_refused(tmp_path):
    with pytest.raises(MeshError, match=r"element 1 along its direction n1.*across the beam"):
        read(tmp_path, f"{HEAD}{STEEL}*BEAM SECTION, ELSET=B, MATERIAL=S, SECTION=RECT\n.05, .08\n1., 0., 0.\n")


@pytest.mark.parametrize("angle", [0.0, 35.0])
def test_orientation_of_springs_and_inertias(tmp_path, angle):
    """A spring along 1 of its ORIENTATION, an inertia in the axes of its own."""
    c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    text = (
        f"{HEAD}{STEEL}*BEAM SECTION, ELSET=B, MATERIAL=S, SECTION=CIRC\n.01\n0., 1., 0.\n*NODE\n3, 5., 0., 0.\n"
        f"*ORIENTATION, NAME=O\n0., {c}, {s}, 0., {-s}, {c}\n*ELEMENT, TYPE=SPRING1, ELSET=K\n2, 2\n"
        "*SPRING, ELSET=K, ORIENTATION=O\n1\n1e6\n*ELEMENT, TYPE=ROTARYI, ELSET=R\n3, 2\n"
        "*ROTARY INERTIA, ELSET=R, ORIENTATION=O\n3., 4., 5.\n"
    )
    fe = read(tmp_path, text)
    bare = read(tmp_path, text.replace("1e6", "0.").replace("3., 4., 5.", "0., 0., 0."))
    row = {(int(n), int(k)): i for i, (n, k) in enumerate(fe.dofs)}
    at = [row[1, k] for k in range(6)]
    stiff, mass = ((a - b).toarray()[np.ix_(at, at)] for a, b in ((fe.K, bare.K), (fe.M, bare.M)))
    first, second = np.array([0, c, s]), np.array([0, -s, c])
    np.testing.assert_allclose(stiff[:3, :3], 1e6 * np.outer(first, first), atol=1e-3)
    expected = 3 * np.outer(first, first) + 4 * np.outer(second, second) + 5 * np.diag([1, 0, 0])
    np.testing.assert_allclose(mass[3:, 3:], expected, atol=1e-9)


SHELL = (
    "*NODE\n1, 0., 0., 0.\n2, .1, 0., 0.\n3, .1, .1, 0.\n4, 0., .1, 0.\n*ELEMENT, TYPE=S4, ELSET=P\n1, 1, 2, 3, 4\n"
    f"{STEEL}*SHELL SECTION, ELSET=P, MATERIAL=S{{more}}\n.01\n{{behind}}*BOUNDARY\n1, 1, 6\n4, 1, 6\n"
)


def test_transverse_shear_stiffness_of_shells(tmp_path):
    """K11, K22, K12 are the shear stiffness of the section."""
    fe = read(tmp_path, SHELL.format(more="", behind="*TRANSVERSE SHEAR STIFFNESS\n2e8, 3e8, 1e8\n"))
    block = fe.blocks[0]
    np.testing.assert_allclose(np.linalg.inv(block.shear[0]), [[2e8, 1e8], [1e8, 3e8]], rtol=1e-9)
    with pytest.raises(MeshError, match=r"K11, K22, K12 = 2e\+08, 3e\+08, 3e\+08.*K12\^2 < K11 K22"):
        read(tmp_path, SHELL.format(more="", behind="*TRANSVERSE SHEAR STIFFNESS\n2e8, 3e8, 3e8\n"))


@pytest.mark.parametrize(
    ("more", "behind", "words"),
    [
        (", DENSITY=5.", "", r"\*SHELL SECTION: the parameter DENSITY = 5. \(1\)"),
        ("", "*COUPLING, REF NODE=9, SURFACE=U, INFLUENCE RADIUS=.05\n*KINEMATIC\n", r"the parameter INFLUENCERADIUS"),
        (", SECTION INTEGRATION=GAUSS", "", None),
        (", POISSON=0.3", "", None),
    ],
)
def test_parameters_are_used_told_or_without_effect(tmp_path, more, behind, words):
    surface = "*NODE\n9, .1, .05, .05\n*SURFACE, NAME=U, TYPE=NODE\n2\n3\n" if behind else ""
    fe = read(tmp_path, SHELL.format(more=more, behind=surface + behind))
    told = "; ".join(f"{what} ({count})" for what, count in fe.source["left_out"].items())
    if words is None:
        assert not told
    else:
        assert re.search(words, told), told


TABLE = "*NODE\n1, 0., 0., 0.\n2, 1., 0., 0.\n*ELEMENT, TYPE=SPRINGA, ELSET=K\n1, 1, 2\n*SPRING, ELSET=K, NONLINEAR\n"


@pytest.mark.parametrize(
    ("table", "expected"),
    [
        ("0., 0.\n10., 1.\n100., 20.", 10.0),
        ("-6., -2.\n-4., -1.\n6., 1.\n9., 4.", 5.0),
        ("-3., -1.\n0., 0.\n5., 1.", 4.0),
    ],
)
def test_springs_with_tables_have_the_slope_at_rest(tmp_path, table, expected):
    """*SPRING, NONLINEAR: rows of force and elongation; the force of the last row was taken for the stiffness."""
    fe = read(tmp_path, f"{TABLE}\n{table}\n*ELEMENT, TYPE=MASS, ELSET=M\n2, 2\n*MASS, ELSET=M\n1.\n")
    assert fe.K.toarray().max() == pytest.approx(expected)
    assert "slope at rest" in "; ".join(fe.source["approximated"])


def test_springs_with_tables_of_nothing_are_refused(tmp_path):
    with pytest.raises(MeshError, match=r"a table of 2 rows.*rising, about 0"):
        read(tmp_path, f"{TABLE}\n5., 1.\n6., 2.\n")
