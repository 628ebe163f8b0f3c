"""Scalar points of Nastran decks: chains of springs and masses, turned directions, MPC, supports."""

import numpy as np
import pytest
from scipy.linalg import eigh
from tolerances import MACHINE

from flexmb import fem
from flexmb.errors import MeshError

pytestmark = pytest.mark.filterwarnings("ignore::flexmb.fem.meshes.mesh.MeshWarning")

CONSOLE = """GRID,1,,0.,0.,0.
GRID,2,,1.,0.,0.
CBAR,1,1,1,2,0.,1.,0.
PBAR,1,1,1.-3,1.-8,1.-8,1.-8
MAT1,1,2.1+11,,.3,7850.
SPC1,1,123456,1
"""
TURNED = """CORD2R,7,,0.,0.,0.,1.,1.,1.
,1.,2.,0.
GRID,1,,0.,0.,0.
GRID,2,,1.,0.,0.,7
GRID,3,,0.5,1.,0.3
CBAR,1,1,1,2,0.,0.,1.,BGG
CBAR,2,1,2,3,0.,0.,1.,BGG
PBAR,1,1,1.-3,1.-8,1.-8,1.-8
MAT1,1,2.1+11,,.3,7850.
CONM2,90,2,,1.,,,,,
,.1,,.1,,,.1
SPC1,1,123456,1
"""
TWO = """GRID,1,,0.,0.,0.
GRID,2,,1.,0.,0.
CONM2,11,1,,2.
CONM2,12,2,,5.
CELAS2,21,1000.,1,1
CELAS2,22,3000.,2,1
SPC1,1,23456,1,2
"""


def read(tmp_path, bulk, **options):
    """Read the bulk data of a deck."""
    path = tmp_path / "part.bdf"
    path.write_text(f"SOL 103\nCEND\nSPC = 1\nBEGIN BULK\n{bulk}\nENDDATA\n")
    return fem.read_deck(path, show=False, **options)


def frequencies(K, M):
    """Closed form, Hz."""
    return np.sqrt(eigh(np.array(K), np.array(M))[0]) / (2 * np.pi)


@pytest.mark.parametrize("cards", [("CELAS4,5,1.+4,100,101", "CMASS4"), ("PELAS,6,1.+4\nCELAS3,5,6,100,101", "CMASS2")])
def test_a_chain_of_scalar_points_at_a_console(tmp_path, cards):
    """The tip of a bar, stiffness 3 E I / l^3, and two masses behind it; a lumped bar has half its mass there."""
    spring, mass = cards
    points = f"SPOINT,100,101\nCELAS2,4,2.+4,2,2,100\n{spring}\n{mass},7,3.,100\n{mass},8,1.,101"
    fe = read(tmp_path, CONSOLE + points)
    tip, half = 3 * 2.1e11 * 1e-8, 7850.0 * 1e-3 / 2
    across = frequencies([[tip + 2e4, -2e4, 0], [-2e4, 3e4, -1e4], [0, -1e4, 1e4]], np.diag([half, 3.0, 1.0]))
    other = np.sqrt(tip / half) / (2 * np.pi)
    found = fem.eigenmodes(fe, "spc", 4).frequencies
    np.testing.assert_allclose(found, np.sort([*across, other]), rtol=1e-9)


@pytest.mark.parametrize("component", "123456")
def test_a_point_that_moves_in_a_turned_direction(tmp_path, component):
    """As a second grid point at the same place that follows in all other directions."""
    cards = f"SPOINT,100\nCELAS2,5,1.+4,2,{component},100\nCMASS2,7,3.,100\nCELAS4,9,5.+3,100"
    found = fem.eigenmodes(read(tmp_path, TURNED + cards), "spc", 6).frequencies
    rest = "123456".replace(component, "")
    cards = (
        f"GRID,100,,1.,0.,0.,7\nRBE2,77,2,{rest},100\nCELAS2,5,1.+4,2,{component},100,{component}\n"
        f"CMASS2,7,3.,100,{component}\nCELAS2,9,5.+3,100,{component}"
    )
    expected = fem.eigenmodes(read(tmp_path, TURNED + cards), "spc", 6).frequencies
    np.testing.assert_allclose(found, expected, rtol=MACHINE)


@pytest.mark.parametrize(
    "row", ["MPC,3,100,0,1.,1,1,-.5\n,,2,1,.25", "MPC,3,1,1,1.,100,0,-2.\n,,2,1,-.5"], ids=["follows", "leads"]
)
def test_a_point_in_a_multipoint_constraint(tmp_path, row):
    """u = x_1 / 2 - x_2 / 4, as the follower and as the leader of the constraint."""
    fe = read(tmp_path, f"{TWO}SPOINT,100\n{row}\nCMASS4,7,3.,100\nCELAS4,8,700.,100")
    lever = np.array([0.5, -0.25])
    K = np.diag([1000.0, 3000.0]) + 700.0 * np.outer(lever, lever)
    M = np.diag([2.0, 5.0]) + 3.0 * np.outer(lever, lever)
    np.testing.assert_allclose(fem.eigenmodes(fe, "spc", 2).frequencies, frequencies(K, M), rtol=1e-9)


@pytest.mark.parametrize("card", ["SPC,1,100,0,0.", "SPC1,1,0,100", "SPC1,1,,99,THRU,101"])
def test_a_point_that_is_held_is_ground(tmp_path, card):
    fe = read(tmp_path, f"{TWO}SPOINT,100\nCELAS2,5,500.,1,1,100,0\n{card}")
    expected = frequencies(np.diag([1500.0, 3000.0]), np.diag([2.0, 5.0]))
    np.testing.assert_allclose(fem.eigenmodes(fe, "spc", 2).frequencies, expected, rtol=1e-9)


def test_a_point_between_two_grid_points_lets_a_body_go_free(tmp_path):
    """Rigid motions strain no spring; the point lies on the line of the springs."""
    bar = CONSOLE.replace("SPC1,1,123456,1\n", "").replace(
        "CBAR,1,1,1,2", "GRID,3,,0.,1.,0.\nCBAR,2,1,1,3,1.,0.,0.\nCBAR,1,1,1,2"
    )
    fe = read(tmp_path, f"{bar}CELAS2,5,1.+6,1,1,100\nCELAS2,6,2.+6,100,0,2,1\nCMASS4,7,.5,100", lumped=False)
    motions = fe.rigid_motions()
    assert np.abs(fe.K @ motions).max() < 1e-9 * np.abs(fe.K).max()
    assert fem.eigenmodes(fe, n=7).frequencies[6] > 1.0
    x, y, z = fe.nodes[-1]
    assert (y, z) == (0.0, 0.0)
    assert 0.0 <= x <= 1.0


def test_points_that_no_grid_point_moves_are_left_out_by_name(tmp_path):
    with pytest.warns(match=r"CELAS4 at scalar point 100, which no grid point moves \(1\)"):
        fe = read(tmp_path, f"{TWO}SPOINT,100,101\nCELAS4,5,500.,100,101\nCMASS4,6,1.,101")
    expected = frequencies(np.diag([1000.0, 3000.0]), np.diag([2.0, 5.0]))
    np.testing.assert_allclose(fem.eigenmodes(fe, "spc", 2).frequencies, expected, rtol=1e-9)


@pytest.mark.parametrize(
    ("cards", "words"),
    [
        ("CELAS2,5,500.,1,,2,1", r"part.bdf:\d+.*CELAS2 5.*point 1 without a component"),
        ("CELAS4,5,500.,1,100", r"part.bdf:\d+.*CELAS4 5.*point 1 without a component"),
        ("SPOINT,2", r"part.bdf:\d+.*SPOINT 2.*grid point too"),
        ("SPOINT,100\nCELAS3,5,9,100", r"part.bdf:\d+.*CELAS3 5.*property 9"),
    ],
)
def test_what_cannot_be(tmp_path, cards, words):
    with pytest.raises(MeshError, match=words):
        read(tmp_path, TWO + cards)
