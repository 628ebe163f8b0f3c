"""Decks on the command line: what is in one, and a body from one without a material."""

import json
from pathlib import Path

import numpy as np
import pytest
import pyvista

import flexmb as fmb
from flexmb import fem
from flexmb.cli import main
from flexmb.fem.deck.inventory import numbers

DECK = """BEGIN BULK
GRID,1,,0.,0.,0.
GRID,2,,1000.,0.,0.
GRID,3,,2000.,0.,0.
GRID,9,,2000.,0.,200.
GRID,10,,0.,0.,200.
CBAR,1,1,1,2,0.,1.,0.
CBAR,2,1,2,3,0.,1.,0.
PBARL,1,1,,TUBE,,,,,+
+,50.,40.
MAT1,1,2.1+5,,.3,7.85-9
CONM2,5,9,,.012
RBE2,7,9,123456,3
RBE2,8,10,123456,1
PARAM,COUPMASS,1
ENDDATA
"""

UNITS = "mm, t, s"


@pytest.fixture
def deck(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mast.bdf").write_text(DECK)
    return "mast.bdf"


def test_show(deck, capsys):
    assert main(["show", deck, "--units", UNITS]) == 0
    text = capsys.readouterr().out
    assert "2 CBAR" in text
    assert "one connected part" in text
    assert "rbe2_7, rbe2_8" in text


def test_reduce_takes_materials_and_interfaces_from_the_deck(deck, tmp_path):
    assert main(["reduce", deck, "--units", UNITS, "--modes", "4", "--no-report"]) == 0
    data = fmb.ModalNeutralData.load(tmp_path / "mast.h5")
    assert data.marker_names == ("rbe2_7", "rbe2_8")
    np.testing.assert_allclose(data.mass, 12 + 7850 * 2 * np.pi * (0.05**2 - 0.04**2), rtol=1e-9)
    np.testing.assert_allclose(data.marker_positions, [[2, 0, 0.2], [0, 0, 0.2]], atol=1e-12)


def test_side_of_stress(deck, tmp_path):
    """A plate on the mast: its faces bend against each other, as far as they are from the middle."""
    plate = "GRID,4,,1000.,500.,0.\nGRID,5,,2000.,500.,0.\nCQUAD4,9,9,2,3,5,4\nPSHELL,9,1,10.,1\nENDDATA"
    (tmp_path / "mast.bdf").write_text(DECK.replace("ENDDATA", plate))
    sides = {}
    for side in ("0", "1", "-1"):
        words = ["--stress-side", side, "--modes", "2", "--no-report", "--overwrite"]
        assert main(["reduce", deck, "--units", UNITS, *words]) == 0
        sides[side] = fmb.ModalNeutralData.load(tmp_path / "mast.h5").stress_modes
    bending = sides["1"] - sides["0"]
    assert np.abs(bending).max() > 0.0
    np.testing.assert_allclose(sides["-1"] - sides["0"], -bending, atol=1e-6 * np.abs(bending).max())


def test_side_of_stress_needs_shells(tmp_path, capsys):
    assert main(["reduce", str(tmp_path / "a.msh"), "--material", "steel", "--stress-side", "1"]) != 0
    assert "--stress-side for solids" in capsys.readouterr().err


def test_options_of_meshes_and_decks_do_not_mix(deck, capsys):
    assert main(["reduce", deck, "--scale", "0.001"]) != 0
    assert "--units and --consistent-mass with a deck" in capsys.readouterr().err


@pytest.mark.render
def test_show_draws_and_reports(deck, capsys, tmp_path):
    """What the page says of the deck: inventory, mass, parts, interfaces by their nodes; the picture marks them."""
    assert main(["show", deck, "--units", UNITS, "--html"]) == 0
    text = capsys.readouterr().out
    assert "Picture: mast_model.png" in text
    assert (tmp_path / "mast_model.png").stat().st_size > 10_000
    page = (tmp_path / "mast_model.html").read_text()
    assert "node 9 of the deck" in page
    assert "data:image/png" in page
    numbers = json.loads((tmp_path / "mast_model.json").read_text())
    assert numbers["interfaces"]["rbe2_7"]["position"] == [2.0, 0.0, 0.2]
    assert numbers["source"]["read"]["CBAR"] == 2
    assert numbers["checks"]["mass"] == pytest.approx(12 + 7850 * 2 * np.pi * (0.05**2 - 0.04**2), rel=1e-9)
    colours = pyvista.read(tmp_path / "mast_model.png").active_scalars[:, :3].astype(int)
    red = np.abs(colours - np.array([0xB3, 0x26, 0x3D])).max(axis=1) < 40
    assert 50 < red.sum() < 20_000  # two balls and a square of the legend


def test_what_hangs_apart_is_named(tmp_path):
    """Two plates side by side that share an edge in space only, a hinge, and a node that nothing uses."""
    path = tmp_path / "two.bdf"
    grids = [(1, 0, 0), (2, 1, 0), (3, 1, 1), (4, 0, 1), (12, 1, 0), (5, 2, 0), (6, 2, 1), (13, 1, 1), (77, 5, 5)]
    path.write_text(
        "BEGIN BULK\n"
        + "\n".join(f"GRID,{k},,{x}.,{y}.,0." for k, x, y in grids)
        + "\nCQUAD4,1,1,1,2,3,4\nCQUAD4,2,1,12,5,6,13\nPSHELL,1,1,.01,1,,1\nMAT1,1,7.+10,,.3,2700.\nENDDATA\n"
    )
    checks = fem.deck_checks(fem.read_deck(path, show=False))
    found = checks.numbers()
    assert [part["nodes"] for part in found["parts"]] == [4, 4]
    assert sorted(map(sorted, found["unmerged"])) == [[2, 12], [3, 13]]
    assert found["free_edges"] == 8
    assert found["unused_nodes"] == [77]
    np.testing.assert_allclose(checks.center, [1.0, 0.5, 0.0], atol=1e-12)
    bush = "CBUSH,9,3,2,12,,,,0\nPBUSH,3,K,1.+6,1.+6,1.+6,1.+2,1.+2,1.+2\nENDDATA"
    path.write_text(path.read_text().replace("ENDDATA", bush))
    checks = fem.deck_checks(fem.read_deck(path, show=False))
    assert len(checks.parts) == 1
    assert checks.numbers()["unmerged"] == [[3, 13]]
    assert checks.joined == 1


def test_numbers_on_the_command_line_are_those_of_the_deck(deck, tmp_path):
    assert (
        main(["reduce", deck, "--units", UNITS, "--interface", "tip=2", "--interface", "rbe2_8", "--modes", "2"]) == 0
    )
    data = fmb.ModalNeutralData.load(tmp_path / "mast.h5")
    np.testing.assert_allclose(data.marker_positions, [[1, 0, 0], [0, 0, 0.2]], atol=1e-12)
    assert main(["reduce", deck, "--interface", "tip=4", "--overwrite"]) != 0


def test_supports_of_the_deck_are_places(deck, tmp_path, capsys):
    """A mast that the deck clamps at its foot and at a node half way, and no links."""
    text = DECK.replace("RBE2,7,9,123456,3\nRBE2,8,10,123456,1\n", "SPC1,4,123456,1\nSPC1,5,123,2\n")
    (tmp_path / "held.bdf").write_text(text.replace("CONM2,5,9,,.012", "CONM2,5,3,,.012"))
    assert main(["reduce", "held.bdf", "--units", UNITS]) != 0
    assert "supports of the file: spc_4, spc_5" in capsys.readouterr().err
    assert main(["reduce", "held.bdf", "--units", UNITS, "--interface", "foot=spc_4", "--no-report"]) == 0
    data = fmb.ModalNeutralData.load(tmp_path / "held.h5")
    np.testing.assert_allclose(data.marker_positions, [[0, 0, 0]], atol=1e-12)


def test_lumped_masses_have_a_way_out(deck, tmp_path, capsys):
    (tmp_path / "lumped.bdf").write_text(DECK.replace("PARAM,COUPMASS,1\n", ""))
    assert (
        main(["reduce", "lumped.bdf", "--units", UNITS, "--interface", "a=2", "--interface", "rbe2_8", "--modes", "2"])
        != 0
    )
    assert "--consistent-mass" in capsys.readouterr().err
    arguments = ["--units", UNITS, "--interface", "a=2", "--interface", "rbe2_8", "--modes", "2", "--consistent-mass"]
    assert main(["reduce", "lumped.bdf", *arguments, "--no-report"]) == 0


def test_rounding_is_printed_as_zero():
    assert numbers(np.array([1.5, -3.7e-20, 2e-9])) == ["1.5", "0", "2e-09"]
    assert numbers(np.full(3, np.nan)) == ["nan"] * 3


def test_a_mesh_without_properties_is_told_from_a_deck(capsys):
    """Gmsh writes elements without a section: what can be done with them is said."""
    mesh = str(Path(__file__).parents[2] / "meshes" / "bracket_hex8.inp")
    assert main(["show", mesh, "--units", "m, kg, s"]) == 2
    told = capsys.readouterr().err
    assert "no section" in told
    assert "a mesh without properties: " in told
    assert "flexmb reduce ... --material steel" in told
