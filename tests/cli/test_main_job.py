"""The main job on the command line: mesh in, reduced body, mechanism, motion, ParaView out."""

from pathlib import Path

import numpy as np
import pytest

from flexmb.cli import main
from flexmb.cli.run_folder import open_run

MESH = str(Path(__file__).parents[2] / "meshes" / "bracket_hex8.msh")

MODEL = """
gravity = [0, 0, -9.81]
[parameters]
load = -200.0
[[body]]
kind = "Ground"
markers = { foot = "= place" }
[[body]]
kind = "FloatingBody"
name = "bracket"
data = "bracket.h5"
at = [1, 0, 0]
damping = 0.5
[[joint]]
kind = "Fixed"
name = "bolts"
markers = ["ground.foot", "bracket.foot"]
[[force]]
kind = "PointLoad"
name = "load"
marker = "bracket.load"
force = ["= load*smooth(t/0.01)", 0, 0]
[[sensor]]
kind = "Deflection"
name = "bow"
marker = "bracket.load"
[[sensor]]
kind = "Reaction"
name = "bolts"
joint = "bolts"
[simulation]
t_end = 0.02
samples = 21
"""


@pytest.fixture
def bracket(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert (
        main(
            [
                "reduce",
                MESH,
                "--material",
                "steel",
                "--interface",
                "foot=foot",
                "--interface",
                "load=load",
                "--modes",
                "2",
                "-o",
                "bracket.h5",
            ]
        )
        == 0
    )
    import flexmb as fmb

    data = fmb.ModalNeutralData.load("bracket.h5")
    at = data.marker_positions[data.marker_names.index("foot")] + [1, 0, 0]
    (tmp_path / "wall.toml").write_text(MODEL.replace("[parameters]", f"[parameters]\nplace = {at.tolist()}"))
    return data


def test_mesh_to_paraview(bracket, tmp_path):
    """At rest the bolts carry load and weight: F = (-load, 0, m g)."""
    import pyvista

    assert main(["check", "wall.toml"]) == 0
    assert main(["run", "wall.toml", "--out", "run"]) == 0
    solution = open_run("run")
    assert solution["bolts"][-1, :3] == pytest.approx([200.0, 0.0, bracket.mass * 9.81], rel=1e-3, abs=1e-3)
    assert np.abs(solution["bow"][-1]).max() > 1e-6
    assert main(["export", "run", "--vtk"]) == 0
    reader = pyvista.get_reader("run/run.pvd")
    assert len(reader.time_values) == 21
    # the run folder is complete in itself, with the body once: it runs without the files it came from
    assert sorted(path.name for path in Path("run").glob("*.h5")) == ["solution.h5"]
    (tmp_path / "bracket.h5").unlink()
    assert main(["run", "run/model.toml", "--out", "again"]) == 0
    assert (tmp_path / "again" / "sensors.csv").read_bytes() == (tmp_path / "run" / "sensors.csv").read_bytes()


def test_a_body_of_a_run(bracket, tmp_path, capsys):
    """In another model: "<solution file>#<body>"; the message for a wrong body lists those of the run."""
    assert main(["run", "wall.toml", "--out", "run"]) == 0
    text = (tmp_path / "wall.toml").read_text()
    (tmp_path / "other.toml").write_text(text.replace("bracket.h5", "run/solution.h5#bracket"))
    assert main(["check", "other.toml"]) == 0
    (tmp_path / "other.toml").write_text(text.replace("bracket.h5", "run/solution.h5#brackt"))
    capsys.readouterr()
    assert main(["check", "other.toml"]) == 2
    told = capsys.readouterr().err
    assert "there is no body 'brackt'" in told
    assert "Did you mean 'bracket'?" in told


def test_a_run_that_cannot_begin_keeps_its_body(bracket, tmp_path):
    """Without a solution file the reduced body is written beside the model."""
    text = (tmp_path / "wall.toml").read_text()
    twice = text[text.index("[[joint]]") : text.index("[[force]]")].replace('"bolts"', '"more"')
    far = twice.replace('"ground.foot"', '"ground.far"')
    text = text.replace('foot = "= place"', 'foot = "= place", far = [9, 9, 9]').replace("[[force]]", far + "[[force]]")
    (tmp_path / "wrong.toml").write_text(text)
    assert main(["run", "wrong.toml", "--out", "run"]) == 2
    assert [path.name for path in Path("run").glob("*.h5")] == ["model.bracket_hex8.h5"]
    assert "solution.h5" not in Path("run/model.toml").read_text()


def test_a_truncated_body_is_named(bracket, tmp_path, capsys):
    whole = (tmp_path / "bracket.h5").read_bytes()
    (tmp_path / "bracket.h5").write_bytes(whole[: whole.index(b"FLEXSEAL") // 2])
    assert main(["check", "wall.toml"]) == 2
    assert "bracket.h5" in capsys.readouterr().err
