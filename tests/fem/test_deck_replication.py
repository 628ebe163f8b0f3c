"""Nastran decks: replicated lines, more than eight free fields in a line, blanks between commas, stations of beams."""

import numpy as np
import pytest

from flexmb import fem
from flexmb.errors import MeshError

pytestmark = pytest.mark.filterwarnings("ignore::flexmb.fem.meshes.mesh.MeshWarning")
REST = "PBARL,1,1,,TUBE,,,,,+\n+,.05,.04\nMAT1,1,2.1+11,,.3,7850.\n"


def read(tmp_path, bulk, **options):
    path = tmp_path / "part.bdf"
    path.write_text(f"BEGIN BULK\n{bulk}\nENDDATA\n")
    return fem.read_deck(path, show=False, **options)


def test_replicated_cards_are_those_written_out(tmp_path):
    """= copies, == copies the rest, *(x) adds, =(n) repeats: MSC Nastran Quick Reference Guide, Replication."""
    nodes = "".join(f"GRID,{k},,{0.5 * (k - 1):.1f},0.,0.,,123\n" for k in range(1, 6))
    bars = "".join(f"CBAR,{k},1,{k},{k + 1},0.,1.,0.\n" for k in range(1, 5))
    short = "GRID,1,,0.,0.,0.,,123\n=,*(1),=,*(0.5),==\n=(3)\n"
    short += "CBAR    1       1       1       2       0.      1.      0.\n=,*(1),=,*(1),*(1),==\n=2\n"
    plain, copied = read(tmp_path, nodes + bars + REST), read(tmp_path, short + REST)
    np.testing.assert_array_equal(plain.labels, copied.labels)
    np.testing.assert_allclose(plain.nodes, copied.nodes)
    np.testing.assert_allclose(plain.K.toarray(), copied.K.toarray())


def test_copies_inside_named_lines(tmp_path):
    """The name may stand before = and ==; a case control with blanks about its = is none of them."""
    head = "SOL 103\nCEND\nSPC     =       1\nSPC     =       1\nDISP = ALL\n"
    nodes = "".join(f"GRID,{k},,{0.5 * (k - 1):.1f},0.,0.,,123\n" for k in range(1, 5))
    bars = "".join(f"CBAR,{k},1,{k},{k + 1},0.,1.,0.\n" for k in range(1, 4))
    short = "GRID,1,,0.,0.,0.,,123\nGRID,2,=,0.5,==\nGRID    *(1)    =       *(.5)   ==\nGRID,4,,1.5,==\n"
    short += "CBAR,1,1,1,2,0.,1.,0.\nCBAR,*(1),=,*(1),*(1),==\nCBAR,3,=,3,4,0.,=,=\n"
    plain = read(tmp_path, nodes + bars + REST)
    path = tmp_path / "short.bdf"
    path.write_text(f"{head}BEGIN BULK\n{short}{REST}ENDDATA\n")
    copied = fem.read_deck(path, show=False)
    np.testing.assert_allclose(plain.nodes, copied.nodes)
    np.testing.assert_allclose(plain.K.toarray(), copied.K.toarray())


@pytest.mark.parametrize("line", ["=,*(1),=,*(x),==", "=(2)"])
def test_copies_of_nothing_are_refused(tmp_path, line):
    with pytest.raises(MeshError, match=r"begin with '='|lines that"):
        read(tmp_path, f"{line}\nGRID,1,,0.,0.,0.\nGRID,2,,1.,0.,0.\nCBAR,1,1,1,2,0.,1.,0.\n{REST}")


def test_one_line_of_eleven_fields(tmp_path):
    """CORD2C with its three points in one line, and blanks that separate fields between commas."""
    bulk = "GRID,2,,1.,0.,0.\nCBAR,1,1,1,2,0.,1.,0.\n" + REST
    cord = "CORD2C,1,0,0.,0.,1.,0.,0.,2.,1.,0.,1."
    one = read(tmp_path, f"{cord}\nGRID,1,1,2.,30.,3.\n{bulk}")
    two = read(tmp_path, f"CORD2C,1,0, 0. 0.   1.,0.,0.,2.,+\n+,1.,0.,1.\nGRID,1,1,2.,30.,3.\n{bulk}")
    expected = [2.0 * np.cos(np.pi / 6), 2.0 * np.sin(np.pi / 6), 4.0]
    np.testing.assert_allclose(one.nodes[0], expected)
    np.testing.assert_allclose(two.nodes[0], expected)


@pytest.mark.parametrize("places", [(1, "-1.25000000000000E+02"), (4001, "-125.0000000000000000000e0")])
def test_long_numbers_between_commas_keep_their_exponents(tmp_path, places):
    """A field between commas may have more than 16 characters, in the first of many grid points or in the last."""
    number, word = places
    nodes = "".join(f"GRID,{k},,{k}.,0.,0.\n" if k != number else f"GRID,{k},,{word},0.,0.\n" for k in range(1, 4003))
    bars = "CBAR,1,1,1,2,0.,1.,0.\nCBAR,2,1,2,4001,0.,1.,0.\n"
    fe = read(tmp_path, nodes + bars + REST)
    assert fe.nodes[np.flatnonzero(fe.labels == number)[0], 0] == -125.0


def test_endless_words_between_commas_are_refused(tmp_path):
    with pytest.raises(MeshError, match=r"card GRID 1: a field of 70 characters"):
        read(tmp_path, f"GRID,1,,{'1' * 70},0.,0.\nGRID,2,,1.,0.,0.\nCBAR,1,1,1,2,0.,1.,0.\n{REST}")


def deflection(fe):
    load = np.zeros((len(fe.nodes), 6, 1))
    tip = int(np.flatnonzero(fe.labels == 2)[0])
    load[tip, 1] = 1.0
    return fe.field(fem.static(fe, fe.forces(load)[:, 0], fem.fixed_freedoms(fe, "spc_1")))[tip, 1, 0]


BEAM = "GRID,1,,0.,0.,0.\nGRID,2,,2.,0.,0.\nCBEAM,7,1,1,2,0.,1.,0.\nMAT1,1,2.1+11,,.3,7850.\nSPC1,1,123456,1\n"


def test_stations_between_the_ends(tmp_path):
    """Strong to the middle, then weak: int (l - x)^2 / E I dx, and the mass of all pieces."""
    blank = "+\n+,,,,,,,,,+\n+"
    rows = [f"YES,{x},{a}-4,{i}-8,{i}-8,,1.-7,,{blank}" for x, a, i in ((".49", "4.", "8."), (".51", "1.", "1."))]
    bulk = f"PBEAM,1,1,4.-4,8.-8,8.-8,,1.-7,,{blank},{','.join(rows)},YES,1.,1.-4,1.-8,1.-8,,1.-7,,{blank},0.,0."
    fe = read(tmp_path, BEAM + bulk)
    x = np.linspace(0.0, 2.0, 200_001)
    share = np.interp(x, [0.0, 0.98, 1.02, 2.0], [1.0, 1.0, 0.0, 0.0])
    bent = np.trapezoid((2.0 - x) ** 2 / (2.1e11 * (1e-8 + 7e-8 * share)), x)
    assert deflection(fe) == pytest.approx(bent, rel=1e-3)
    mass = 7850.0 * np.trapezoid(1e-4 + 3e-4 * share, x)
    assert fe.M.diagonal()[fe.dofs[:, 1] == 0].sum() == pytest.approx(mass, rel=1e-6)


def test_end_b_left_out_is_as_end_a(tmp_path):
    """PBEAML with a station at the middle alone."""
    bar = "PBEAML,1,1,,BAR,,,,,+\n+,.04,.03,,NO,.5,.02,.03"
    fe = read(tmp_path, BEAM + bar)
    x = np.linspace(0.0, 2.0, 200_001)
    height = np.where(x < 1.0, 1.0 - 0.5 * x, 0.5 * x)  # of the width: I and A are proportional to it
    inertia = 0.04 * 0.03**3 / 12 * height
    assert deflection(fe) == pytest.approx(np.trapezoid((2.0 - x) ** 2 / (2.1e11 * inertia), x), rel=1e-2)
    mass = 7850.0 * 0.03 * 0.04 * np.trapezoid(height, x)
    assert fe.M.diagonal()[fe.dofs[:, 1] == 0].sum() == pytest.approx(mass, rel=1e-6)


def test_stations_at_one_place_are_refused(tmp_path):
    with pytest.raises(MeshError, match=r"stations at 0, 0\.5, 0\.5, 1"):
        read(tmp_path, BEAM + "PBEAML,1,1,,BAR,,,,,+\n+,.04,.03,,NO,.5,.02,.03,+\n+,NO,.5,.02,.03")
