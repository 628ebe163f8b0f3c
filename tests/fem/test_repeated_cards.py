"""Cards that give a number twice, that nobody knows, and thicknesses of zero at corners: no wrong mass in silence."""

import pytest

from flexmb import fem
from flexmb.errors import MeshError
from flexmb.fem.deck.inventory import mass_and_center

PLATE = """GRID,1,,0.,0.,0.
GRID,2,,1.,0.,0.
GRID,3,,1.,1.,0.
GRID,4,,0.,1.,0.
CQUAD4,1,1,1,2,3,4
PSHELL,1,1,.01,1,,1
MAT1,1,2.1+11,,.3,7850.
CONM2,7,1,,2.
"""
MASS = 7850.0 * 0.01 + 2.0


def read(tmp_path, bulk):
    """Read the bulk data of a deck."""
    path = tmp_path / "part.bdf"
    path.write_text(f"BEGIN BULK\n{bulk}ENDDATA\n")
    return fem.read_deck(path, show=False)


@pytest.mark.parametrize("card", ["CQUAD4,1,1,1,2,3,4", "CONM2,7,1,,2.", "PSHELL,1,1,.01,1,,1,,,"])
def test_a_card_that_is_written_twice_counts_once(tmp_path, card):
    """Elements and masses weighed twice."""
    fe = read(tmp_path, f"{PLATE}{card}\n")
    assert mass_and_center(fe)[0] == pytest.approx(MASS, rel=1e-12)
    name = card.split(",")[0]
    assert fe.source["approximated"] == {f"{name} written twice, taken once": 1}


@pytest.mark.parametrize(
    "card",
    [
        "CQUAD4,1,1,1,2,4,3",
        "CONM2,7,1,,3.",
        "PSHELL,1,1,.02,1,,1",
        "PCOMP,1\n,1,.01",
        "RBE2,3,2,123456,4\nRBE2,3,1,123456,4",
        "CELAS2,3,5.,1,1,2,1\nCELAS2,3,6.,1,1,2,1",
    ],
)
def test_two_cards_of_one_number_that_differ_are_refused(tmp_path, card):
    """Elements weighed twice; of two properties the last one won."""
    with pytest.raises(MeshError, match=r"part\.bdf:\d+, card \w+ \d+: the number \d a second time .*part\.bdf:\d+\)"):
        read(tmp_path, f"{PLATE}{card}\n")


@pytest.mark.parametrize(
    ("given", "mean"), [("0.,0.,.04,.04", 0.02), (",,.04,.04", 0.025), ("0.,,,", 0.0075), (".01,.02,.03,.04", 0.025)]
)
def test_a_zero_at_a_corner_is_no_blank(tmp_path, given, mean):
    """A leading edge of thickness 0 had the thickness of the property: 14 % too heavy in a wing of that kind."""
    bulk = PLATE.replace("1,2,3,4\n", f"1,2,3,4,,,+\n+,,,{given}\n")
    assert mass_and_center(read(tmp_path, bulk))[0] == pytest.approx(7850.0 * mean + 2.0, rel=1e-12)


@pytest.mark.parametrize("given", ["0.,0.,0.,0.", ".01,-.01,.01,.01"])
def test_thicknesses_that_cannot_be(tmp_path, given):
    with pytest.raises(MeshError, match=r"part\.bdf:6, card CQUAD4 1: thicknesses .* at the corners"):
        read(tmp_path, PLATE.replace("1,2,3,4\n", f"1,2,3,4,,,+\n+,,,{given}\n"))


def test_a_corner_that_is_blank_is_named(tmp_path):
    with pytest.raises(MeshError, match=r"part\.bdf:6, card CQUAD4 1: field 6 reads ''.*grid point"):
        read(tmp_path, PLATE.replace("1,2,3,4\n", "1,2\n"))


def test_a_card_that_nobody_knows_is_told(tmp_path):
    """It stood among those that are not needed, with the loads."""
    with pytest.warns(match=r"XYZZY: a card that is not known \(the first at .*part\.bdf:10\)"):
        fe = read(tmp_path, f"{PLATE}XYZZY,1,2\nFORCE,1,1,,1.,1.,0.,0.\n")
    assert fe.source["not_needed"] == {"FORCE": 1}


def test_junk_in_a_text_is_named_by_its_line(tmp_path):
    (tmp_path / "part.bdf").write_bytes(f"BEGIN BULK\n{PLATE}".encode() + b"$ \x01\x02\nENDDATA\n")
    with pytest.raises(MeshError, match=r"part\.bdf', line 10: bytes of a binary file"):
        fem.read_deck(tmp_path / "part.bdf", show=False)


def test_files_that_include_each_other_are_listed(tmp_path):
    (tmp_path / "a.inc").write_text("INCLUDE 'part.bdf'\n")
    with pytest.raises(MeshError, match=r"include each other: part\.bdf -> a\.inc -> part\.bdf"):
        read(tmp_path, f"{PLATE}INCLUDE 'a.inc'\n")


INPUT = """*NODE
1, 0., 0., 0.
2, 1., 0., 0.
3, 1., 1., 0.
4, 0., 1., 0.
9, 2., 0., 0.
*ELEMENT, TYPE=S4, ELSET=P
1, 1, 2, 3, 4
*ELEMENT, TYPE=MASS, ELSET=M
7, 9
*MATERIAL, NAME=STEEL
*ELASTIC
2.1E11, 0.3
*DENSITY
7850.
*SHELL SECTION, ELSET=P, MATERIAL=STEEL
0.01
*MASS, ELSET=M
2.
"""


def read_input(tmp_path, text):
    """Read an Abaqus deck."""
    (tmp_path / "part.inp").write_text(text)
    return fem.read_deck(tmp_path / "part.inp", show=False)


def test_the_last_of_two_sections_holds(tmp_path):
    """As in CalculiX 2.20, where a cube of E = 1e6, then of 4e6, is pulled by 1e-6 under 4 N; the first one held."""
    fe = read_input(tmp_path, INPUT + "*SHELL SECTION, ELSET=P, MATERIAL=STEEL\n0.02\n")
    assert mass_and_center(fe)[0] == pytest.approx(2 * 78.5 + 2.0, rel=1e-12)
    assert any("two sections, by the last" in text for text in fe.source["approximated"])


def test_a_node_at_two_places_is_told(tmp_path):
    with pytest.warns(match=r"first places of nodes that have a second one \(.*part\.inp:1\) \(1\)"):
        fe = read_input(tmp_path, INPUT.replace("9, 2., 0., 0.", "9, 5., 0., 0.\n9, 2., 0., 0."))
    assert mass_and_center(fe)[1][0] == pytest.approx((78.5 * 0.5 + 2.0 * 2.0) / 80.5, rel=1e-12)


@pytest.mark.parametrize(
    ("more", "words"),
    [
        (
            "*MATERIAL, NAME=Steel\n*ELASTIC\n7.E10, .3\n",
            r"inp:20, \*MATERIAL: the material 'steel' a second time .*:11\)",
        ),
        ("*MASS, ELSET=M\n3.\n", r"inp:20, \*MASS: element 7 a second time .*:18\)"),
    ],
)
def test_values_that_are_given_twice(tmp_path, more, words):
    """The last material won, masses were added."""
    with pytest.raises(MeshError, match=words):
        read_input(tmp_path, INPUT + more)


def test_a_keyword_that_is_left_out_may_name_what_does_not_exist(tmp_path):
    """`*MEMBRANE` is no keyword of CalculiX; its material and set made the deck unreadable."""
    with pytest.warns(match=r"\*MEMBRANE"):
        fe = read_input(tmp_path, INPUT + "*MEMBRANE, ELSET=P1, MATERIAL=STEEL\n0.\n")
    assert mass_and_center(fe)[0] == pytest.approx(80.5, rel=1e-12)
