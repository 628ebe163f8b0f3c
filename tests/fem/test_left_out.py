"""What a deck holds besides its mesh is named, and what cannot be meant is doubted: masses, links, units, numbers."""

import re
import warnings
from contextlib import contextmanager

import numpy as np
import pytest
from fem.beams import plate, straight

from flexmb import fem
from flexmb.errors import MeshError
from flexmb.model.material import Material

STEEL = Material(young=210e9, poisson=0.3, density=7850.0)

NASTRAN = """BEGIN BULK
GRID,1,,0.,0.,0.
GRID,2,,1.,0.,0.
GRID,3,,1.,1.,0.
GRID,4,,0.,1.,0.
GRID,5,,1.,.5,0.
GRID,6,,0.,.5,0.
CQUAD4,1,1,1,2,3,4
RBE2    11      5       123456  2       3       1.2-5
RBE3,12,,6,123456,1.0,123,1,+
+,4,UM,1,123
CONM2,20,5,,2.5
CONM2,21,3,,1.5+0
CELAS2,22,1000.,1,1
ENDDATA
"""

ABAQUS = """*NODE
1, 0., 0., 0.
2, 1., 0., 0.
3, 1., 1., 0.
4, 0., 1., 0.
*ELEMENT, TYPE=S4
1, 1, 2, 3, 4
*ELEMENT, TYPE=MASS, ELSET=m
2, 3
*MASS, ELSET=m
2.5
*ELEMENT, TYPE=SpringA, ELSET=s
3, 1, 3
*TIE, NAME=glue
a, b
*RIGID BODY, REF NODE=1, TIE NSET=x
"""


@contextmanager
def warned_once(match):
    """The mesh is warned of in these words, and only once."""
    with pytest.warns(fem.MeshWarning, match=match) as told:
        yield
    assert sum(re.search(match, str(warning.message)) is not None for warning in told) == 1


def mass_of(fe) -> float:
    """kg, as translations along x see it"""
    along = (fe.dofs[:, 1] == 0).astype(float)
    return float(along @ (fe.M @ along))


@pytest.fixture
def write(tmp_path):
    """``write("a.bdf", text)`` writes a file and returns its path."""

    def file(name, text):
        (tmp_path / name).write_text(text)
        return tmp_path / name

    return file


def test_nastran_masses_and_rigid_elements(write):
    """The nodes of a spider are a set; the reader says what it left out, with the total mass."""
    with warned_once(r"1 CELAS2, 2 CONM2 \(mass 4\), 1 RBE2, 1 RBE3; .*fem\.with_mass"):
        mesh = fem.read_mesh(write("a.bdf", NASTRAN))
    assert mesh.node_sets["rbe2_11"].tolist() == [1, 2]
    assert mesh.node_sets["rbe3_12"].tolist() == [0, 3]


@pytest.mark.parametrize(
    ("card", "kind", "nodes"),
    [
        ("CQUAD4,1,1,1,2,3,4,0.0,.001", "quad", [0, 1, 2, 3]),
        ("CQUAD4  1       1       1       2       3       4       30.     0.001", "quad", [0, 1, 2, 3]),
        (
            "CTRIA3* 1               1               1               2\n*       3               30.",
            "triangle",
            [0, 1, 2],
        ),
        ("CTRIA3,1,,1,2,3,30.", "triangle", [0, 1, 2]),
        (
            "CTRIA6  1       1       1       2       3       5       6       7       30.",
            "triangle6",
            [0, 1, 2, 3, 4, 5],
        ),
        ("CQUAD8,1,1,1,2,3,4,5,6\n,7,8,.01,.01,.01,.01,0.", "quad8", list(range(8))),
        ("CTUBE,1,1,1,2", "line", [0, 1]),
        ("CONROD,1,1,2,1,.1", "line", [0, 1]),
        ("CBEAM,1,1,1,2,0.,0.,1.", "line", [0, 1]),
        ("CBEAM3,1,1,1,2,5,0.,0.,1.", "line3", [0, 1, 2]),
    ],
)
def test_elements_with_angles_and_offsets(write, card, kind, nodes):
    """What follows the nodes of an element is not one of them, in every field format."""
    places = ["0.,0.", "1.,0.", "1.,1.", "0.,1.", ".5,0.", "1.,.5", ".5,1.", "0.,.5"]
    grids = "".join(f"GRID,{number},,{place},0.\n" for number, place in enumerate(places, 1))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        mesh = fem.read_mesh(write("a.bdf", f"BEGIN BULK\n{grids}{card}\nENDDATA\n"))
    assert [(found, cells.tolist()) for found, cells in mesh.cells] == [(kind, [nodes])]
    assert set(mesh.cell_sets) == {"pid_0" if card.startswith("CONROD") else "pid_1"}


@pytest.mark.parametrize("card", ["CQUAD4,1,1,1,2,3", "CTRIA3,1,1,1,x,3", "CQUAD8,1,1,1,2,3,4,5,,7,8"])
def test_elements_that_cannot_be_read(write, card):
    grids = "".join(f"GRID,{number},,{number}.,0.,0.\n" for number in range(1, 9))
    with pytest.raises(MeshError, match=r"a\.bdf'.*the card C(QUAD|TRIA)\d 1 1 1"):
        fem.read_mesh(write("a.bdf", f"BEGIN BULK\n{grids}{card}\n"))


def test_elements_of_other_kinds_are_named(write):
    with warned_once("1 CTRIAX6"):
        mesh = fem.read_mesh(write("a.bdf", NASTRAN.replace("RBE2", "CTRIAX6,9,1,1,2,3,4,5,6\nRBE2")))
    assert [(kind, cells.tolist()) for kind, cells in mesh.cells] == [("quad", [[0, 1, 2, 3]])]


def test_offsets_of_beams_and_plates(write):
    """W1A..W3B of CBAR and ZOFFS of CQUAD4; zeros and blanks are none."""
    bars = "CBAR,7,2,1,2,0.,0.,1.\n,,,0.,0.,0.02,0.,0.,.02\nCBAR,8,2,2,3,0.,0.,1.\n,,,0.,0.,0.,,,\n"
    plate = "CQUAD4,1,1,1,2,3,4,,.001\n"
    text = (
        "BEGIN BULK\n" + "".join(f"{line}\n" for line in NASTRAN.splitlines() if line.startswith("GRID")) + bars + plate
    )
    with warned_once("left out were 1 offsets of CBAR, 1 offsets of CQUAD4;"):
        mesh = fem.read_mesh(write("a.bdf", text))
    assert len(mesh.cells_of("line")) == 2


def test_abaqus_masses_and_links(write):
    with warned_once(r"1 \*RIGID BODY, 1 \*TIE, 1 elements MASS, 1 elements SPRINGA"):
        mesh = fem.read_mesh(write("a.inp", ABAQUS))
    assert len(mesh.cells_of("quad")) == 1


def test_abaqus_nodes_with_normals_and_data_in_other_files(write):
    plain = ABAQUS.split("*ELEMENT, TYPE=MASS")[0]
    points = fem.read_mesh(write("a.inp", plain)).points
    normals = plain.replace("1, 0., 0., 0.", "1, 0., 0., 0., 0., 0., 1.").replace("2, 1., 0., 0.", "2, 1., 0.,")
    assert np.array_equal(fem.read_mesh(write("b.inp", normals)).points, points)
    write("nodes.txt", "".join(f"{line}\n" for line in plain.splitlines()[1:5]))
    apart = "*NODE, INPUT=nodes.txt\n" + plain[plain.index("*ELEMENT") :]
    assert np.array_equal(fem.read_mesh(write("c.inp", apart)).points, points)
    with pytest.raises(MeshError, match=r"\*NODE, INPUT=none: no such file"):
        fem.read_mesh(write("d.inp", apart.replace("nodes.txt", "none")))


@pytest.mark.parametrize("keyword", ["NGEN", "ELGEN"])
def test_abaqus_generators_are_refused(write, keyword):
    with pytest.raises(MeshError, match=rf"\*{keyword}, which makes nodes or elements.*Write the mesh out"):
        fem.read_mesh(write("a.inp", ABAQUS + f"*{keyword}\n1, 3, 1\n"))


def test_plain_meshes_leave_nothing_out(write):
    text = "\n".join(line for line in NASTRAN.splitlines() if line.startswith(("BEGIN", "GRID", "CQUAD4", "END")))
    with warnings.catch_warnings():
        warnings.filterwarnings("error", message=".*left out were.*")
        meshes = [
            fem.read_mesh(write("a.bdf", text + "\n")),
            fem.read_mesh(write("a.inp", ABAQUS.split("*ELEMENT, TYPE=MASS")[0])),
        ]
    assert [[(kind, len(cells)) for kind, cells in mesh.cells] for mesh in meshes] == 2 * [[("quad", 1)]]


def test_included_files(write):
    """Grid points in one file, elements in another; names with and without quotes."""
    lines = NASTRAN.splitlines()
    write("grids.bdf", "\n".join(line for line in lines if line.startswith("GRID")) + "\n")
    write("rest.bdf", "\n".join(line for line in lines if line.startswith(("CQUAD4", "CONM2"))) + "\n")
    with warned_once(r"2 CONM2 \(mass 4\)"):
        mesh = fem.read_mesh(write("whole.bdf", "BEGIN BULK\nINCLUDE 'grids.bdf'\ninclude rest.bdf\nENDDATA\n"))
    assert len(mesh.points) == 4
    with pytest.raises(MeshError, match=r"INCLUDE 'none\.bdf': no such file"):
        fem.read_mesh(write("bad.bdf", "BEGIN BULK\nINCLUDE 'none.bdf'\n"))
    with pytest.raises(MeshError, match=r"INCLUDE 'self\.bdf': files include each other"):
        fem.read_mesh(write("self.bdf", "INCLUDE 'self.bdf'\n"))


@pytest.mark.parametrize("card", ["GRDSET,,3", "GRDSET                 3"])
def test_default_coordinate_system(write, card):
    with pytest.raises(MeshError, match=r"coordinate system 3: GRDSET,,3.*basic"):
        fem.read_mesh(write("a.bdf", NASTRAN.replace("BEGIN BULK", f"BEGIN BULK\n{card}")))


def test_grid_points_at_two_places(write):
    twice = NASTRAN.replace("CQUAD4,", "GRID,2,,7.,0.,0.\nCQUAD4,")
    with pytest.raises(MeshError, match=r"1 grid points at two places, the first is 2.*Renumber"):
        fem.read_mesh(write("a.bdf", twice))
    with warned_once("left out"):
        mesh = fem.read_mesh(write("a.bdf", NASTRAN.replace("CQUAD4,", "GRID,2,,1.,0.,0.\nCQUAD4,")))
    assert mesh.points.tolist() == [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]]


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("a.bdf", NASTRAN.replace("1,1,1,2,3,4", "1,1,1,2,3,77")),
        ("a.inp", ABAQUS.replace("1, 1, 2, 3, 4", "1, 1, 2, 3, 77")),
    ],
)
def test_missing_nodes_are_named(write, name, text):
    with pytest.raises(MeshError, match="names the node 77, which does not exist"):
        fem.read_mesh(write(name, text))


@pytest.mark.parametrize(
    "make",
    [
        lambda material: fem.shell(plate(1, 1, 1.0, 1.0, "quad"), material, 0.01),
        lambda material: fem.frame(straight(2), section=fem.Section.tube(0.05, 0.002), material=material),
    ],
)
@pytest.mark.parametrize(("young", "density", "speed"), [(210e3, 7850.0, "5.2"), (210e9, 7.85e-9, "5.2e+09")])
def test_materials_in_other_units(make, young, density, speed):
    """MPa beside kg/m3, t/mm3 beside Pa: the speed of sound tells, and the numbers are taken as they are."""
    with warned_once(rf"speed of sound of {speed.replace('+', '.')} m/s.*1 MPa = 1e6 Pa"):
        told = make(Material(young=young, poisson=0.3, density=density))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        steel = make(STEEL)
    assert told.M.sum() == pytest.approx(density / STEEL.density * steel.M.sum())
    assert told.K.diagonal() == pytest.approx(young / STEEL.young * steel.K.diagonal())


def test_frames_and_matrices_in_millimetres():
    section = fem.Section.tube(50.0, 2.0)
    with warned_once(r"the diagonal is 1000 m"):
        fe = fem.frame(1000.0 * straight(2), section=section, material=STEEL)
    with warned_once(r"the diagonal is 1000 m.*length_unit=1e-3"):
        same = fem.from_matrices(fe.K, fe.M, np.array(fe.nodes))
    for found in (fe, same):
        assert found.nodes[:, 0].tolist() == [0.0, 500.0, 1000.0]


@pytest.mark.parametrize(
    ("name", "instead"),
    [
        ("CBEND", "divide it into CBAR along its arc"),
        ("CBEAM3", "write two CBEAM with the properties at its ends"),
        ("CWELD", "a CBUSH between two RBE3"),
    ],
)
def test_what_to_write_instead_of_elements(tmp_path, name, instead):
    """Elements that are left out are named with a way around."""
    path = tmp_path / "part.bdf"
    bulk = f"GRID,1,,0.,0.,0.\nGRID,2,,1.,0.,0.\nGRID,3,,.5,.1,0.\n{name},7,2,1,2,3,0.,1.,0.\nCROD,1,1,1,2\n"
    path.write_text(f"BEGIN BULK\n{bulk}PROD,1,1,1.-4\nMAT1,1,2.1+11,,.3,7850.\nENDDATA\n")
    with warned_once(rf"left out: {name}: .*{instead} \(1\)"):
        fe = fem.read_deck(path, show=False)
    assert mass_of(fe) == pytest.approx(7850.0 * 1e-4 * 1.0)  # of the rod


def test_layered_solids_are_refused_with_a_way_around(tmp_path):
    path = tmp_path / "part.bdf"
    points = [(x, y, z) for z in (0, 1) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))]
    rows = [f"GRID,{k + 1},,{x}.,{y}.,{z}." for k, (x, y, z) in enumerate(points)]
    bulk = "\n".join([*rows, "CHEXA,1,1,1,2,3,4,5,6,+", "+,7,8", "PCOMPS,1", "MAT1,1,2.1+11,,.3,7850."])
    path.write_text(f"BEGIN BULK\n{bulk}\nENDDATA\n")
    with pytest.raises(MeshError, match=r"card PCOMPS 1: a property PCOMPS.*one layer of solids with a PSOLID per ply"):
        fem.read_deck(path, show=False)


def test_shells_of_second_order_warn(tmp_path):
    """An S8R becomes flat elements on its eight nodes: coarse meshes of them differ, so a warning says it."""
    path = tmp_path / "part.inp"
    places = [(0, 0), (1, 0), (1, 1), (0, 1), (0.5, 0), (1, 0.5), (0.5, 1), (0, 0.5)]
    rows = ["*NODE", *(f"{k}, {x}, {y}, 0." for k, (x, y) in enumerate(places, 1))]
    rows += ["*ELEMENT, TYPE=S8R, ELSET=P", "1, 1, 2, 3, 4, 5, 6, 7, 8", "*SHELL SECTION, ELSET=P, MATERIAL=S", ".01"]
    path.write_text("\n".join([*rows, "*MATERIAL, NAME=S", "*ELASTIC", "210e9, .3", "*DENSITY", "7850.", ""]))
    with warned_once(r"S8R of second order, divided into flat elements .*\(1\): where few"):
        fe = fem.read_deck(path, show=False)
    assert len(fe.nodes) == 8
    assert mass_of(fe) == pytest.approx(7850.0 * 0.01)  # of a square metre


def test_what_turns_or_moves_beam_sections_of_abaqus_is_told(tmp_path):
    """*NORMAL turns the second axis of beams; it was called not needed."""
    (tmp_path / "part.inp").write_text(
        "*NODE\n1, 0., 0., 0.\n2, 1., 0., 0.\n*ELEMENT, TYPE=B31, ELSET=B\n1, 1, 2\n*NORMAL\n1, 1, 0., .5, 1.\n"
        "*BEAM SECTION, ELSET=B, MATERIAL=S, SECTION=RECT\n.1, .2\n0., 1., 0.\n*BEAM SECTION OFFSET\n.01, .02\n"
        "*MATERIAL, NAME=S\n*ELASTIC\n2e11, .3\n*DENSITY\n7800.\n"
    )
    with warned_once(r"\*BEAM SECTION OFFSET \(1\); \*NORMAL \(1\)"):
        fe = fem.read_deck(tmp_path / "part.inp", show=False)
    assert mass_of(fe) == pytest.approx(7800.0 * 0.1 * 0.2 * 1.0)
