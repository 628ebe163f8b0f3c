"""`flexmb sweep`: options, table, exit codes, Ctrl-C."""

import csv
import os
import signal
import subprocess
import sys
import time

import numpy as np
import pytest
from tolerances import SOLVER

from flexmb.cli import main


def rows(folder):
    with (folder / "results.csv").open(newline="") as file:
        return list(csv.DictReader(file))


def test_grid(fall, tmp_path, capsys):
    """z = -g t^2/2."""
    arguments = ["--over", "g=1:2:2", "--over", "duration=0.5,2*0.5", "--output", "depth = final(place z)"]
    assert main(["sweep", "fall.toml", *arguments, "--jobs", "1"]) == 0
    table = rows(tmp_path / "runs" / "fall_sweep")
    expected = {(1.0, 0.5): -0.125, (1.0, 1.0): -0.5, (2.0, 0.5): -0.25, (2.0, 1.0): -1.0}
    found = {(float(row["g"]), float(row["duration"])): float(row["depth [m]"]) for row in table}
    assert found == pytest.approx(expected, rel=SOLVER)
    printed = capsys.readouterr().out
    assert "4 variants, 0 without a result" in printed
    assert "Table: runs/fall_sweep/results.csv" in printed


@pytest.mark.slow
def test_latin_hypercube_and_kept_runs(fall, tmp_path, capsys):
    arguments = ["--latin", "2", "--over", "g=1:2", "--seed", "3", "--keep", "--out", "out", "--t-end", "0.5"]
    assert main(["sweep", "fall.toml", *arguments, "--samples", "3", "--jobs", "1"]) == 0
    g = np.array([float(row["g"]) for row in rows(tmp_path / "out")])
    assert sorted(np.floor((g - 1.0) * 2)) == [0.0, 1.0]
    assert main(["plot", "out/runs/0002", "place"]) == 0
    assert "Run folders: out/runs" in capsys.readouterr().out


def test_list_with_a_failure(fall, tmp_path, capsys):
    (tmp_path / "variants.csv").write_text("g,duration\n1.0,1.0\n2.0,-1.0\n")
    assert main(["sweep", "fall.toml", "--list", "variants.csv", "--out", "out", "--jobs", "1"]) == 2
    assert [row["status"] for row in rows(tmp_path / "out")] == ["done", "failed"]
    assert "t_end = -1.0" in rows(tmp_path / "out")[1]["error"]
    assert "2: failed: fall.toml, [simulation]: Simulation: t_end = -1.0" in capsys.readouterr().out


def test_a_function(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "area_of_square.py").write_text("def area(side, count=1):\n    return count * side**2\n")
    arguments = ["--over", "side=1,2,3", "--set", "count=2", "--jobs", "1"]
    assert main(["sweep", "area_of_square.py:area", *arguments]) == 0
    assert [float(row["area"]) for row in rows(tmp_path / "runs" / "area_sweep")] == [2.0, 8.0, 18.0]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--over", "g"], "--over g: no name and values. Expected: NAME=start:stop:count or NAME=a,b,c"),
        (["--over", "g=1:2"], "Range of 'g': '1:2'. Expected: start:stop:count. Write g=3e3:6e3:7; without the count"),
        (["--over", "g=1:x:3"], "Range of 'g': start 1.0, stop x, count 3.0"),
        (["--over", "g="], "Plan, g: the list of values is empty"),
        (["--over", "g=1", "--over", "g=2"], "--over g: the parameter is given twice"),
        (["--over", "h=1,2"], "there is no parameter 'h' to vary. The file has: g, duration. Add h to [parameters]"),
        (["--over", "g=1", "--list", "x.csv"], "--list: --over or --latin beside it"),
        (["--latin", "3", "--over", "g=2:1"], "Range of 'g': (2.0, 1.0). Expected: two numbers, the lower one first"),
        ([], "Plan: it has no parameter"),
        (["--over", "g=1", "--output", "max(palce)"], "there is no sensor or component 'palce'"),
        (["--over", "g=1", "--out", "."], "it holds fall.toml. Expected: a new or empty folder"),
    ],
)
def test_wrong_arguments(fall, capsys, arguments, message):
    assert main(["sweep", "fall.toml", *arguments]) == 2
    assert message in capsys.readouterr().err


SLOW = """
import os, time
def slow(x):
    open(f"{os.getpid()}.pid", "w").close()
    time.sleep(0.2 if x < 3 else 60.0)
    return x
"""


def test_an_interrupted_sweep_goes_on(tmp_path):
    """Ctrl-C reaches all processes of a terminal: the rows so far stay, no worker stays behind."""
    (tmp_path / "sleeper.py").write_text(SLOW)
    command = [sys.executable, "-m", "flexmb", "sweep", "sleeper.py:slow", "--over", "x=1,2,3,4", "--jobs", "2"]
    child = subprocess.Popen(
        [*command, "--out", "out"], cwd=tmp_path, start_new_session=True, stderr=subprocess.PIPE, text=True
    )
    stored = tmp_path / "out" / "rows.jsonl"
    deadline = time.monotonic() + 300.0  # kernels may have to be compiled first
    while time.monotonic() < deadline and (not stored.exists() or stored.read_text().count("\n") < 2):
        time.sleep(0.1)
    os.killpg(child.pid, signal.SIGINT)
    error = child.communicate(timeout=30.0)[1]
    assert child.returncode == 130
    assert "The rows so far are in out; the same command continues from there" in error
    assert "Traceback" not in error
    workers = [int(path.stem) for path in tmp_path.glob("*.pid")]
    assert workers
    for worker in workers:
        with pytest.raises(ProcessLookupError):
            os.kill(worker, 0)
    assert [row["slow"] for row in rows(tmp_path / "out")] == ["1.0", "2.0"]
