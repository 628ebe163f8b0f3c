"""`flexmb run`, `check` and `export`: from a model file to a run folder and its files."""

import csv
import os
import signal
import subprocess
import sys
import time
from dataclasses import replace

import numpy as np
import pytest
from tolerances import SOLVER

import flexmb as fmb
from flexmb import io
from flexmb.cli import main
from flexmb.cli.run_folder import open_run
from flexmb.errors import IntegrationError


def table(path):
    with path.open(newline="") as file:
        titles, *rows = csv.reader(file)
    return titles, np.array(rows, float)


def test_run_folder(fall, tmp_path, capsys):
    """z = -g t^2/2, x = F' t^3/(6 m) with F' = 4 N/s, m = 2 kg."""
    assert main(["run", "fall.toml", "--out", "runs/a"]) == 0
    folder = tmp_path / "runs" / "a"
    assert sorted(p.name for p in folder.iterdir()) == ["log.txt", "model.toml", "sensors.csv", "solution.h5"]
    titles, values = table(folder / "sensors.csv")
    assert titles == ["t [s]", "place x [m]", "place y [m]", "place z [m]"]
    t = np.linspace(0, 1, 11)
    assert values[:, 0] == pytest.approx(t)
    assert values[:, 3] == pytest.approx(-9.81 * t**2 / 2, abs=1e-3)
    assert values[:, 1] == pytest.approx(t**3 / 3, abs=1e-3)
    printed = capsys.readouterr().out
    assert "finished" in printed
    assert "place z [m]" in printed
    assert "runs/a" in printed
    log = (folder / "log.txt").read_text()
    assert "g = 9.81" in log
    assert "finished" in log


def test_events_are_told(fall, tmp_path, capsys):
    """The ball passes z = -1 m at sqrt(2/g)."""
    model = tmp_path / "fall.toml"
    passes = """
[[event]]
kind = "Event"
name = "passes"
sensor = "place"
column = 2
below = -1.0
then = [{ kind = "Release", part = "wind" }]

"""
    model.write_text(model.read_text().replace("[simulation]", passes + "[simulation]"))
    assert main(["run", "fall.toml", "--out", "runs/a"]) == 0
    told = f"event at t = {np.sqrt(2 / 9.81):.4f}"
    for text in (capsys.readouterr().out, (tmp_path / "runs" / "a" / "log.txt").read_text()):
        assert told in text
        assert "passes" in text


def test_settings(fall, tmp_path):
    arguments = ["run", "fall.toml", "--set", "g=2*3", "--set", "duration=0.5", "--samples", "6"]
    assert main(arguments) == 0
    _, values = table(tmp_path / "runs" / "fall" / "sensors.csv")
    assert values[:, 0] == pytest.approx(np.linspace(0, 0.5, 6))
    assert values[-1, 3] == pytest.approx(-0.75, abs=1e-3)
    assert main([*arguments, "--t-end", "0.25", "--overwrite"]) == 0
    assert table(tmp_path / "runs" / "fall" / "sensors.csv")[1][-1, 0] == 0.25


def test_a_run_can_be_run_again(fall, tmp_path):
    main(["run", "fall.toml", "--set", "g=1.6", "--out", "one"])
    assert main(["run", "one/model.toml", "--out", "two"]) == 0
    assert (tmp_path / "one" / "sensors.csv").read_bytes() == (tmp_path / "two" / "sensors.csv").read_bytes()
    assert (tmp_path / "one" / "model.toml").read_bytes() == (tmp_path / "two" / "model.toml").read_bytes()


def test_the_solution_of_a_run_has_its_model(fall):
    main(["run", "fall.toml", "--out", "one"])
    solution = open_run("one")
    assert solution.model.parameters["g"] == 9.81
    assert solution[fmb.Velocity("v", marker="stone.center")][-1] == pytest.approx((1.0, 0, -9.81), rel=1e3 * SOLVER)
    assert io.model_text(solution.model) == io.model_text(io.load_model("one/model.toml"))


def test_check(fall, capsys):
    assert main(["check", "fall.toml"]) == 0
    printed = capsys.readouterr().out
    assert "mobility 3" in printed
    assert "frequencies about the start: 3 without oscillation" in printed


def test_check_tells_frequencies(fall, capsys):
    """A mass of 2 kg between springs of 2 * 400 N/m: 3.183 Hz along them; a second model is fully driven."""
    springs = """
[[body]]
kind = "Ground"
markers = { left = [-1, 0, 0], right = [1, 0, 0] }
[[body]]
kind = "PointMass"
name = "m"
mass = 2.0
[[force]]
kind = "SpringDamper"
name = "a"
markers = ["ground.left", "m.center"]
stiffness = 400.0
[[force]]
kind = "SpringDamper"
name = "b"
markers = ["ground.right", "m.center"]
stiffness = 400.0
"""
    fall.write_text(springs)
    assert main(["check", "fall.toml"]) == 0
    assert "3.183 Hz" in capsys.readouterr().out
    fall.write_text(springs + '[[joint]]\nkind = "Spherical"\nname = "s"\nmarkers = ["ground.origin", "m.center"]\n')
    assert main(["check", "fall.toml"]) == 0
    assert "frequencies" not in capsys.readouterr().out


def test_export(fall, tmp_path, capsys):
    main(["run", "fall.toml", "--out", "one"])
    capsys.readouterr()
    assert main(["export", "one", "--csv", "--to", "files"]) == 0
    assert (tmp_path / "files" / "sensors.csv").read_bytes() == (tmp_path / "one" / "sensors.csv").read_bytes()
    assert main(["export", "one"]) == 0
    assert (tmp_path / "one" / "one.pvd").is_file()
    assert main(["export", "one", "--vtkhdf", "--to", "files"]) == 0
    printed = capsys.readouterr().out
    assert "Open in ParaView: one/one.pvd" in printed
    assert list((tmp_path / "files").glob("*.vtkhdf"))
    assert "paraview --script=one/one_paraview.py" in printed
    assert (tmp_path / "files" / "one_paraview.py").is_file()


def test_run_with_vtk(fall, tmp_path):
    assert main(["run", "fall.toml", "--out", "one", "--vtk"]) == 0
    assert (tmp_path / "one" / "fall.pvd").is_file()


@pytest.mark.parametrize(
    ("arguments", "messages"),
    [
        (
            ["run", "fal.toml"],
            ("flexmb run: Model file 'fal.toml': the file does not exist", "The folder holds: fall.toml"),
        ),
        (
            ["check", "fall.toml", "--set", "G=1"],
            ("flexmb check: fall.toml, [parameters]: there is no parameter 'G' to set",),
        ),
        (["check", "fall.toml", "--set", "g"], ("Setting 'g': no name and value",)),
        (
            ["check", "fall.toml", "--set", "g=1/0"],
            ("fall.toml, gravity: Expression '-g': the parameter 'g' is '1/0'",),
        ),
        (["run", "fall.toml", "--t-end", "-1"], ("Simulation: t_end = -1.0", "a positive duration")),
        (
            ["run", "fall.toml", "--out", "fall.toml"],
            ("Run folder 'fall.toml': it cannot be made", "Give another one with --out"),
        ),
        (["export", "none"], ("Run folder 'none': it does not exist", "run the model first")),
        (["export", "."], ("Run folder '.': there is no solution.h5", "Correct the path")),
    ],
)
def test_errors_are_messages(fall, capsys, arguments, messages):
    assert main(arguments) == 2
    written = capsys.readouterr().err
    assert "Traceback" not in written
    for message in messages:
        assert message in written


def test_a_similar_run_folder_is_proposed(fall, capsys):
    main(["run", "fall.toml", "--out", "runs/p55"])
    assert main(["export", "runs/p5"]) == 2
    assert "beside it: p55. Did you mean 'p55'?" in capsys.readouterr().err


def test_the_model_file_is_not_overwritten(fall, tmp_path, capsys):
    main(["run", "fall.toml", "--out", "one"])
    assert main(["run", "one/model.toml", "--out", "one"]) == 2
    assert "Run folder 'one': the model file lies in it" in capsys.readouterr().err
    assert (tmp_path / "one" / "model.toml").is_file()


def test_a_run_is_replaced_only_on_demand(fall, tmp_path, capsys):
    assert main(["run", "fall.toml", "--out", "one"]) == 0
    before = (tmp_path / "one" / "sensors.csv").read_bytes()
    assert main(["run", "fall.toml", "--out", "one", "--set", "g=1.6"]) == 2
    assert "Run folder 'one': it holds a run. Expected: a new folder." in capsys.readouterr().err
    assert (tmp_path / "one" / "sensors.csv").read_bytes() == before
    assert main(["run", "fall.toml", "--out", "one", "--set", "g=1.6", "--overwrite"]) == 0
    assert (tmp_path / "one" / "sensors.csv").read_bytes() != before


def test_damaged_solution(fall, tmp_path, capsys):
    main(["run", "fall.toml", "--out", "one"])
    (tmp_path / "one" / "solution.h5").write_bytes(b"nothing")
    assert main(["export", "one"]) == 2
    assert "solution.h5" in capsys.readouterr().err


def test_a_failed_simulation_keeps_what_it_had(fall, tmp_path, capsys, monkeypatch):
    simulate = fmb.simulate

    def fail(model, t_end, **settings):
        solution = replace(
            simulate(model, t_end, **settings), status=fmb.Status.failed("too small a step", "Look at it")
        )
        raise IntegrationError(
            "Model 'fall'", found="the step became too small", remedy="Look at the start", solution=solution
        )

    monkeypatch.setattr(fmb, "simulate", fail)
    assert main(["run", "fall.toml", "--out", "one"]) == 2
    captured = capsys.readouterr()
    assert "Model 'fall': the step became too small. Look at the start." in captured.err
    assert "11 samples" in captured.out
    assert (tmp_path / "one" / "sensors.csv").is_file()
    assert "too small" in (tmp_path / "one" / "log.txt").read_text()


def test_a_failure_without_samples(fall, tmp_path, monkeypatch, capsys):
    def fail(model, t_end, **settings):
        raise IntegrationError("Model 'fall'", found="no start")

    monkeypatch.setattr(fmb, "simulate", fail)
    assert main(["run", "fall.toml", "--out", "one"]) == 2
    assert capsys.readouterr().err.count("no start") == 1
    assert (tmp_path / "one" / "log.txt").read_text().count("no start") == 1


@pytest.mark.parametrize("when", ["loading", "before the first sample", "writing the table"])
def test_an_interruption_says_what_is_stored(fall, tmp_path, monkeypatch, capsys, when):
    def strike(*given, **more):
        raise KeyboardInterrupt

    if when == "loading":
        monkeypatch.setattr("flexmb.io.OpenModelFile", strike)
    elif when == "before the first sample":
        monkeypatch.setattr("flexmb.integrate.runs.phases.Phases.run", strike)
    else:
        monkeypatch.setattr(fmb, "write_table", strike)
    assert main(["run", "fall.toml", "--out", "one"]) == 130
    said = capsys.readouterr().err
    if when == "writing the table":
        assert "interrupted: its samples are stored" in said
        assert "flexmb resume one" in said
        assert len(open_run(tmp_path / "one").t) > 3
        monkeypatch.undo()
        monkeypatch.chdir(tmp_path)
        assert main(["resume", "one"]) == 0  # as the message says
        assert (tmp_path / "one" / "sensors.csv").is_file()
    else:
        assert said == "flexmb run: interrupted: nothing is stored, since there was no sample yet\n"
        assert not (tmp_path / "one" / "solution.h5").exists()
        monkeypatch.undo()
        monkeypatch.chdir(tmp_path)
        assert main(["run", "fall.toml", "--out", "one"]) == 0  # no --overwrite is needed


def test_steps_of_a_search_for_equilibrium_are_no_samples(tmp_path, monkeypatch, capsys):
    """Nothing holds this body: 400 iterates were stored as samples at t = 0."""
    monkeypatch.chdir(tmp_path)
    model = fmb.Model(
        gravity=(0, 0, -9.81),
        bodies=[fmb.Ground(), fmb.PointMass("stone", mass=1.0)],
        sensors=[fmb.Position("place", marker="stone.center")],
    )
    fmb.save_model(model, "loose.toml", fmb.Simulation(t_end=1.0, samples=11, start="equilibrium"))
    assert main(["run", "loose.toml", "--out", "one"]) == 2
    captured = capsys.readouterr()
    assert "the run cannot begin, nothing of it was computed: no equilibrium" in captured.err
    assert "samples" not in captured.out
    assert {p.name for p in (tmp_path / "one").iterdir()} == {"log.txt", "model.toml"}
    with pytest.raises(IntegrationError) as caught:
        fmb.simulate(model, 1.0, samples=11, start="equilibrium")
    assert caught.value.solution is None


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupted_run_stays_readable(fall, tmp_path, number):
    command = [
        sys.executable,
        "-m",
        "flexmb",
        "run",
        "fall.toml",
        "--t-end",
        "1e5",
        "--samples",
        "200001",
        "--out",
        "one",
    ]
    process = subprocess.Popen(
        command,
        cwd=tmp_path,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)},
    )
    solution, deadline = tmp_path / "one" / "solution.h5", time.monotonic() + 120
    while not (solution.is_file() and solution.stat().st_size > 100_000) and time.monotonic() < deadline:
        assert process.poll() is None, process.stderr.read()
        time.sleep(0.05)
    process.send_signal(number)
    written, errors = process.communicate(timeout=60)
    assert process.returncode == 130, errors
    assert "Traceback" not in errors
    assert "interrupted" in written
    found = open_run(tmp_path / "one")
    assert found.status.kind == "interrupted"
    assert len(found.t) > 1
    assert len(table(tmp_path / "one" / "sensors.csv")[1]) == len(found.t)
