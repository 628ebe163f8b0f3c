"""Counts that parameters give: 8, 8.0 and 2*4 from a file, --set, a sweep or Python are one and the same.

Reference: the first frequencies of a clamped-clamped beam, whose number is the count.
"""

import pytest
from cli.test_cache import SHAFT
from parts.flap import FLAP

import flexmb as fmb
from flexmb.cli import main

MAST = (
    SHAFT.replace("GJ = 1.5e6", "GJ = 1.5e6\nmodes = 6\nn = 12\nnumber = 3.0\nshare = 0.5")
    .replace("modes = 2", 'modes = "= modes"\ncompare = "= number - 1"')
    .replace("elements = 6", 'elements = "= n"')
    .replace("samples = 2", 'samples = "= 2*number"')
)


@pytest.fixture
def file(tmp_path, monkeypatch):
    monkeypatch.setenv("FLEXMB_BODIES", str(tmp_path / "bodies"))
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "mast.toml"
    path.write_text(MAST)
    return path


def flap(file, parameters=None) -> fmb.FloatingBody:
    return fmb.load_model(file, parameters).body("flap", "test")


def test_set_is_what_the_file_would_hold(file, capsys):
    assert main(["check", "mast.toml", "--set", "modes=8", "--set", "n=24"]) == 0
    assert "reduced in" in capsys.readouterr().err
    data = flap(file, {"modes": 8.0, "n": 24.0}).data
    assert data.n_modes == flap(file).data.n_modes + 2
    assert data.recipe["part"]["pieces"][0]["elements"] == 24
    file.write_text(MAST.replace("modes = 6", "modes = 8").replace("n = 12", "n = 24"))
    capsys.readouterr()
    assert main(["check", "mast.toml"]) == 0
    assert "reduced in" not in capsys.readouterr().err  # nor is it another body


def test_arithmetic(file, capsys):
    first = flap(file).data
    file.write_text(MAST.replace('modes = "= modes"', 'modes = "= 2*3"').replace('"= n"', '"= 24*share"'))
    assert main(["check", "mast.toml"]) == 0
    assert "reduced in" not in capsys.readouterr().err
    assert flap(file).data.n_modes == first.n_modes
    assert fmb.load_simulation(file).samples == 6


def test_sweep(file, capsys):
    command = ["sweep", "mast.toml", "--over", "modes=6:8:2", "--jobs", "1", "--output", "final(turn)", "--out", "s"]
    assert main(command) == 0, capsys.readouterr()
    assert "2 reduced" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("setting", "words"),
    [("modes=8.5", ("flap", "modes = 8.5", "a count")), ("n=24.5", ("flap", "elements = 24.5", "whole number"))],
)
def test_fractions_are_refused_by_name(file, capsys, setting, words):
    assert main(["check", "mast.toml", "--set", setting]) == 2
    out, err = capsys.readouterr()
    assert all(word in out + err for word in ("mast.toml, [[body]] 'flap', data", *words))
    assert "Leave elements out" not in out + err


LISTS = f"""
[parameters]
first = 2.0
{FLAP}interfaces = {{ root = 0, pair = ["= first", "= first + 2"] }}
stations = {{ seen = ["= 2*first"], all = {{ kind = "Each", of = ["= first", 4, 5, "= 3*first"] }} }}
masses = [{{ kind = "Mass", at = ["= first - 1", 3], mass = 1.5 }}]
links = [{{ kind = "RigidLink", nodes = ["= first + 4"], reference = [1, 0, 0.1], name = "eye" }}]
loads = {{ push = {{ kind = "Forces", on = ["= first + 1"], force = [0, 0, 1] }} }}
modes = 1
[[body.data.pieces]]
kind = "Line"
points = [[0, 0, 0], [1, 0, 0]]
elements = 6
material = "steel"
section = {{ kind = "Section.rectangle", width = 0.02, height = 0.02 }}
"""


def test_lists_of_node_numbers(file):
    """Numbers of nodes from arithmetic: the body is the one of whole numbers; a place stays a place."""
    path = file.with_name("lists.toml")
    path.write_text(LISTS)
    data = flap(path).data
    whole = LISTS.replace('["= first", "= first + 2"]', "[2, 4]").replace('["= 2*first"]', "[4]")
    whole = whole.replace('["= first", 4, 5, "= 3*first"]', "[2, 4, 5, 6]").replace('["= first - 1", 3]', "[1, 3]")
    whole = whole.replace('["= first + 4"]', "[6]").replace('["= first + 1"]', "[3]")
    path.write_text(whole)
    same = flap(path).data
    assert data.marker_names == same.marker_names
    assert data.marker_positions == pytest.approx(same.marker_positions)
    assert data.mass == pytest.approx(same.mass)
    assert data.load_shapes == pytest.approx(same.load_shapes)
    path.write_text(LISTS)
    with pytest.raises(fmb.errors.ModelError, match=r"\(6\.5,\)\. Expected: a set name, node numbers"):
        flap(path, {"first": 2.5})
