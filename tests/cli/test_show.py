"""`flexmb show`, and the report that `flexmb reduce` writes."""

import json
from dataclasses import replace
from pathlib import Path

import pytest

import flexmb as fmb
from flexmb.cli import main
from flexmb.view import graphics

MESH = str(Path(__file__).parents[2] / "meshes" / "bracket_hex8.msh")


@pytest.fixture
def bracket(tmp_path, monkeypatch, capsys):
    """A reduced bracket in the working folder, and what was printed."""
    monkeypatch.chdir(tmp_path)
    assert (
        main(["reduce", MESH, "--material", "steel", "--interface", "a=foot", "--interface", "b=load", "--modes", "4"])
        == 0
    )
    return capsys.readouterr().out


def test_reduce_writes_and_prints_the_report(bracket):
    data = fmb.ModalNeutralData.load("bracket_hex8.h5")
    assert data.report() in bracket
    assert "Report: bracket_hex8.html, bracket_hex8.json" in bracket
    assert len(json.loads(Path("bracket_hex8.json").read_text())["coordinates"]) == data.n_modes
    assert "Modal coordinates" in Path("bracket_hex8.html").read_text(encoding="utf-8")


def test_report_can_be_left_out(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert (
        main(
            [
                "reduce",
                MESH,
                "--material",
                "steel",
                "--interface",
                "a=foot",
                "--modes",
                "2",
                "--no-report",
                "-o",
                "x.h5",
            ]
        )
        == 0
    )
    assert [path.name for path in tmp_path.iterdir()] == ["x.h5"]


@pytest.mark.render
def test_show(bracket, capsys, tmp_path):
    assert main(["show", "bracket_hex8.h5", "--modes", "2", "--vtk", "--html"]) == 0
    printed = capsys.readouterr().out
    assert fmb.ModalNeutralData.load("bracket_hex8.h5").report() in printed
    assert Path("bracket_hex8_modes.png").stat().st_size > 5000
    assert Path("bracket_hex8_modes.pvd").read_text().count("<DataSet") == 2 * 6 + 4 - 6
    assert "data:image/png;base64," in Path("bracket_hex8.html").read_text(encoding="utf-8")


def test_no_picture_is_no_error_unless_asked_for(bracket, capsys, monkeypatch):
    monkeypatch.setattr(graphics, "_outcome", lambda: -11)
    assert main(["show", "bracket_hex8.h5"]) == 0
    assert "No picture. Rendering: a trial picture ended with code -11" in capsys.readouterr().out
    assert main(["show", "bracket_hex8.h5", "-o", "x.png"]) == 2
    assert "flexmb show: Rendering: a trial picture ended with code -11" in capsys.readouterr().err
    assert main(["show", "bracket_hex8.h5", "--modes", "0"]) == 0
    assert "picture" not in capsys.readouterr().out.lower()


def test_data_without_a_mesh(bracket, capsys):
    replace(fmb.ModalNeutralData.load("bracket_hex8.h5"), cells=()).save("bare.h5")
    assert main(["show", "bare.h5"]) == 0
    assert "No picture. Modes of 'bracket_hex8': there is no mesh" in capsys.readouterr().out


def test_missing_file(tmp_path, capsys):
    assert main(["show", str(tmp_path / "none.h5")]) == 2
    assert "none.h5" in capsys.readouterr().err


def test_a_run_folder_is_no_body(tmp_path, capsys):
    assert main(["show", str(tmp_path)]) == 2
    assert f"For a run folder: flexmb render {tmp_path}" in capsys.readouterr().err


def test_groups_of_a_mesh_are_listed(tmp_path, monkeypatch, capsys):
    """What `flexmb reduce` asks for by name: counts and places are those of meshes/make_meshes.py."""
    monkeypatch.chdir(tmp_path)
    mesh = str(Path(MESH).with_name("conrod.msh"))
    assert main(["show", mesh]) == 0
    printed = capsys.readouterr().out.splitlines()
    assert printed[0] == "Mesh 'conrod': 4676 nodes, 651 triangle6, 2312 tetra10"
    assert "0.372 x 0.06 x 0.016: in metres, or in the unit that --scale" in printed[1]
    rows = {line.split()[0]: line.split() for line in printed[4:]}
    assert set(rows) == {"mid", "bore_a", "bore_b", "upper_skin", "conrod"}
    assert rows["bore_b"] == ["bore_b", "312", "140", "triangle6", "(0.32,", "0,", "0)"]
    assert rows["mid"] == ["mid", "1", "0", "nodes", "alone", "(0.16,", "0,", "0)"]
    assert not list(tmp_path.iterdir())
    assert main(["show", mesh, "--vtk"]) == 2
    assert capsys.readouterr().err.startswith("flexmb show: --vtk for a mesh. ")
