"""Decks on the command line: what is in one, and a body from one without a material."""

import numpy as np
import pytest

import flexmb as fmb
from flexmb.cli import main

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


def test_options_of_meshes_and_decks_do_not_mix(deck, capsys):
    assert main(["reduce", deck, "--scale", "0.001"]) != 0
    assert "--units with a deck" in capsys.readouterr().err
