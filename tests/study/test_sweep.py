"""`sweep`: rows, failures, dying workers, resuming."""

import csv
import json
import os
import re
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from types import SimpleNamespace

import numpy as np
import pytest
from study import formulas
from tolerances import SOLVER

import flexmb as fmb
from flexmb import study
from flexmb.errors import DataFileError, FlexmbError, ModelError
from flexmb.study.worker import Worker

FALL = """
gravity = [0, 0, "= -g"]
[parameters]
g = 9.81
duration = 1.0
[[body]]
kind = "Ground"
[[body]]
kind = "PointMass"
name = "stone"
mass = "= 1 + 0*sqrt(g)"
[[sensor]]
kind = "Position"
name = "place"
marker = "stone.center"
[simulation]
t_end = "= duration"
samples = 3
"""


@pytest.fixture
def fall(tmp_path):
    path = tmp_path / "fall.toml"
    path.write_text(FALL)
    return path


@pytest.fixture
def threads():
    """Run variants in this process: tests of what is asked and stored need no others."""
    with ThreadPoolExecutor(1) as executor:
        yield executor


def test_a_model_file_on_processes(fall, tmp_path):
    """Free fall: z = -g t^2/2; a parameter that the model refuses is a row with its error."""
    steps = []
    results = fmb.sweep(
        fall,
        {"g": [1.6, -1.0, 9.81], "duration": [1.0, 2.0]},
        outputs=["depth = final(place z)"],
        folder=tmp_path / "out",
        jobs=2,
        keep_runs=True,
        progress=steps.append,
    )
    assert [row.number for row in results.rows] == [1, 2, 3, 4, 5, 6]
    good = results["g"] > 0.0
    expected = -results["g"] * results["duration"] ** 2 / 2
    assert results["depth"][good] == pytest.approx(expected[good], rel=SOLVER)
    assert np.isnan(results["depth"][~good]).all()
    assert [row.status for row in results.failed] == ["failed", "failed"]
    assert all("sqrt" in row.error for row in results.failed)
    assert [(step.done, step.total) for step in steps] == [(k, 6) for k in range(7)]
    assert steps[-1].failed == 2
    assert steps[-1].seconds_left == 0.0
    assert not (tmp_path / "out" / "runs" / "0003" / "solution.h5").exists()
    run = tmp_path / "out" / "runs" / "0006"
    assert sorted(entry.name for entry in run.iterdir()) == ["model.toml", "sensors.csv", "solution.h5"]
    kept = fmb.Solution.load(run / "solution.h5", read_model=fmb.read_model_text)
    assert kept["place"][-1, 2] == results["depth [m]"][5]
    with (tmp_path / "out" / "results.csv").open(newline="") as file:
        table = list(csv.DictReader(file))
    assert list(table[0]) == [
        "number",
        "g",
        "duration",
        "status",
        "depth [m]",
        "seconds",
        "warnings",
        "error",
    ]
    assert float(table[0]["depth [m]"]) == results["depth"][0]
    assert table[2]["depth [m]"] == ""
    assert table[2]["status"] == "failed"


def test_a_process_that_dies_costs_its_row(tmp_path):
    results = fmb.sweep(formulas.square, {"x": [2, 13, -1, 3, 4]}, jobs=2, folder=tmp_path / "out")
    assert [row.status for row in results.rows] == ["done", "died", "failed", "done", "done"]
    assert results["y"][[0, 3, 4]] == pytest.approx([4.0, 9.0, 16.0])
    assert results.rows[1].error == "the worker process was ended by SIGKILL, often because memory ran out"
    assert results.rows[2].error == "ValueError: no root of -1"
    assert "2: died: the worker process was ended by SIGKILL" in str(results)


@pytest.mark.slow
def test_a_variant_that_takes_too_long_is_ended():
    results = fmb.sweep(formulas.slow, {"x": [99, 1]}, jobs=1, timeout=2.0)
    assert results.rows[0].error == "it took longer than 2 s"
    assert results["slow"][1] == 1.0


@pytest.mark.slow
def test_kernels_are_compiled_once(tmp_path, monkeypatch):
    """The second worker waits until the first has stopped compiling, and finds the kernel in the cache."""
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    results = fmb.sweep(formulas.compiled, {"x": [10, 20, 30, 40]}, jobs=2)
    assert results["compiled"].sum() == 1.0


@pytest.mark.skipif(not os.path.exists("/proc/self/stat"), reason="the system does not tell")
def test_processor_time_of_a_worker_is_what_it_computed():
    """Not the time that passed, in which the first worker may have waited."""
    worker = SimpleNamespace(process=SimpleNamespace(pid=os.getpid()))
    before = time.process_time()
    found = Worker.spent(worker)
    tick = 2.0 / os.sysconf("SC_CLK_TCK")  # user and system mode are rounded
    assert before - tick <= found <= time.process_time() + tick


def test_rows_that_are_there_are_not_computed_again(tmp_path):
    calls = tmp_path / "calls"
    calls.mkdir()
    settings = {"parameters": {"folder": str(calls)}, "folder": tmp_path / "out", "jobs": 1}
    first = fmb.sweep(formulas.counted, {"x": [1, 13, 2]}, **settings)
    assert [row.status for row in first.rows] == ["done", "died", "done"]
    stored = tmp_path / "out" / "rows.jsonl"
    whole = stored.read_text().splitlines(keepends=True)
    stored.write_text("".join(whole[:2]) + whole[2][:20])  # cut off while the third row was written
    second = fmb.sweep(formulas.counted, {"x": [1, 13, 2]}, **settings)
    assert [row.status for row in second.rows] == ["done"] * 3
    assert {entry.name: entry.read_text() for entry in calls.iterdir()} == {"1": "1", "13": "2", "2": "2"}
    fmb.sweep(formulas.counted, {"x": [1, 13, 2]}, **settings)
    assert (calls / "2").read_text() == "2"


def test_failures_are_repeated_when_asked(tmp_path, threads, monkeypatch):
    settings = {"folder": tmp_path / "out", "executor": threads}
    assert len(fmb.sweep(formulas.square, {"x": [-2, 3]}, **settings).failed) == 1
    computed = []
    again = {"progress": lambda step: computed.append(step.done)}
    assert len(fmb.sweep(formulas.square, {"x": [-2, 3]}, **settings, **again).failed) == 1
    assert computed == [2]
    computed.clear()
    fmb.sweep(formulas.square, {"x": [-2, 3]}, **settings, **again, retry=True)
    assert computed == [1, 2]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"over": {"g": [1.0, 3.0]}}, "the parameters or their values have changed"),
        ({"outputs": ["max(place z)"]}, "other outputs are requested"),
        (
            {"parameters": {"duration": 2.0}},
            "the model file, its fixed parameters or its reduced bodies have changed",
        ),
        ({"samples": 5}, "samples was 3, now 5"),
        ({"source": formulas.square, "over": {"x": [1.0]}}, "the function has changed"),
    ],
)
def test_another_study_in_the_folder_is_refused(fall, tmp_path, threads, change, message):
    settings = {"source": fall, "over": {"g": [1.0, 2.0]}, "folder": tmp_path / "out", "executor": threads}
    fmb.sweep(**settings)
    before = (tmp_path / "out" / "rows.jsonl").read_text()
    expected = rf"Study folder '.*out': it holds another study: .*{message}.*the same settings.*Give another folder"
    with pytest.raises(DataFileError, match=expected):
        fmb.sweep(**{**settings, **change})
    assert (tmp_path / "out" / "rows.jsonl").read_text() == before


def test_folders_that_cannot_be_used(tmp_path, threads):
    def tried(folder):
        return fmb.sweep(formulas.square, {"x": [1.0]}, folder=folder, executor=threads)

    (tmp_path / "notes.txt").write_text("mine")
    with pytest.raises(DataFileError, match=r"it holds notes\.txt\. Expected: a new or empty folder.*Give another one"):
        tried(tmp_path)
    with pytest.raises(
        DataFileError, match=r"it cannot be used \(File exists\)\. Expected: a folder that can be written"
    ):
        tried(tmp_path / "notes.txt")
    (tmp_path / "foreign").mkdir()
    (tmp_path / "foreign" / "study.json").write_text(
        json.dumps({"schema": "other", "schema_version": 1, "settings": {}})
    )
    with pytest.raises(DataFileError, match=r"study\.json has the schema other 1\. Expected: flexmb\.study 1"):
        tried(tmp_path / "foreign")
    (tmp_path / "foreign" / "study.json").write_text("{")
    with pytest.raises(DataFileError, match=r"study\.json is damaged .*what flexmb wrote"):
        tried(tmp_path / "foreign")
    tried(tmp_path / "good")
    (tmp_path / "good" / "rows.jsonl").write_text("{}\n")
    with pytest.raises(DataFileError, match=r"line 1 of rows\.jsonl is damaged .*Remove this line"):
        tried(tmp_path / "good")


def test_unknown_parameters_and_sensors_show_at_once(fall):
    with pytest.raises(ModelError, match=r"there is no parameter 'duratoin' to vary\. .*Did you mean 'duration'\?"):
        fmb.sweep(fall, {"duratoin": [1.0]})
    with pytest.raises(ModelError, match=r"'g' is varied and set to 1\.0\. Expected: one or the other"):
        fmb.sweep(fall, {"g": [1.0]}, parameters={"g": 1.0})
    with pytest.raises(ModelError, match=r"no sensor or component 'plac'.*Did you mean 'place'\?"):
        fmb.sweep(fall, {"g": [1.0]}, outputs=["max(plac)"])
    with pytest.raises(ModelError, match=r"jobs = 0\. Expected: a whole number of at least 1"):
        fmb.sweep(fall, {"g": [1.0]}, jobs=0)
    with pytest.raises(ModelError, match=r"timeout = -1\.0 s\. Expected: a positive time"):
        fmb.sweep(fall, {"g": [1.0]}, timeout=-1.0)
    with pytest.raises(ModelError, match=r"run folders are to be kept, but no folder is given"):
        fmb.sweep(fall, {"g": [1.0]}, keep_runs=True)


def test_what_a_function_may_return(threads, tmp_path):
    model = fmb.sweep(formulas.stone, {"g": [2.0]}, outputs=["final(place z)"], t_end=1.0, executor=threads)
    assert model["final(place z)"] == pytest.approx([-1.0], rel=SOLVER)
    solution = fmb.sweep(
        formulas.thrown,
        {"g": [2.0]},
        outputs=["final(place z)"],
        executor=threads,
        folder=tmp_path / "out",
        keep_runs=True,
    )
    assert solution["final(place z)"] == pytest.approx([-1.0], rel=SOLVER)
    assert (tmp_path / "out" / "runs" / "0001" / "solution.h5").is_file()
    assert "no end time is given" in fmb.sweep(formulas.stone, {"g": [2.0]}, executor=threads).rows[0].error
    assert (
        "it returns str. Expected: a Model, a Solution"
        in fmb.sweep(formulas.wrong, {"x": [1]}, executor=threads).rows[0].error
    )


def test_functions_that_cannot_be_varied():
    with pytest.raises(ModelError, match=r"Function 'square': there is no parameter 'offest'.*Did you mean 'offset'\?"):
        fmb.sweep(formulas.square, {"offest": [1.0]})
    with pytest.raises(ModelError, match=r"its argument 'x' has no value.*Vary x, or set it"):
        fmb.sweep(formulas.square, {"offset": [1.0]})
    with pytest.raises(ModelError, match=r"it cannot be sent to another process .*Give it a name with def"):
        fmb.sweep(lambda x: x, {"x": [1.0]})


def test_columns_by_name(threads):
    results = fmb.sweep(formulas.square, {"x": [1, 2]}, executor=threads)
    assert results["x"].tolist() == [1, 2]
    assert results["y [m2]"].tolist() == results["y"].tolist() == [1.0, 4.0]
    with pytest.raises(FlexmbError, match=r"there is no column 'z'\. One of: x, y \[m2\]"):
        results["z"]


def test_parquet(threads, tmp_path):
    parquet = pytest.importorskip("pyarrow.parquet")
    fmb.sweep(
        formulas.square,
        study.listed([{"x": 1}, {"x": 2.5}, {"x": -1}]),
        executor=threads,
        folder=tmp_path / "out",
    )
    table = parquet.read_table(tmp_path / "out" / "results.parquet")
    assert table.column("x").to_pylist() == [1.0, 2.5, -1.0]
    assert table.column("y [m2]").to_pylist() == [1.0, 6.25, None]


def test_a_study_that_is_cut_off_does_not_wait_for_parquet(threads, tmp_path):
    """Its package took seconds to load after Ctrl-C; the study that is continued has the file."""
    pytest.importorskip("pyarrow.parquet")

    def stop(step):
        if step.done == 1:
            raise KeyboardInterrupt

    out = tmp_path / "out"
    with pytest.raises(KeyboardInterrupt):
        fmb.sweep(formulas.square, {"x": [1, 2, 3]}, executor=threads, folder=out, progress=stop)
    assert (out / "results.csv").exists()
    assert not (out / "results.parquet").exists()
    fmb.sweep(formulas.square, {"x": [1, 2, 3]}, executor=threads, folder=out)
    assert (out / "results.parquet").exists()


def test_without_pyarrow_there_is_the_csv(threads, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    fmb.sweep(formulas.square, {"x": [1]}, executor=threads, folder=tmp_path / "out")
    assert sorted(p.name for p in (tmp_path / "out").iterdir()) == ["results.csv", "rows.jsonl", "study.json"]


def test_a_script_without_guard_is_told(tmp_path):
    script = tmp_path / "unguarded.py"
    script.write_text("import flexmb as fmb\ndef f(x):\n    return x\nfmb.sweep(f, {'x': [1, 2]}, jobs=1)\n")
    child = subprocess.run([sys.executable, script], capture_output=True, text=True, check=False)
    assert child.returncode == 1
    assert "worker processes cannot start: the worker process ended with code 1" in child.stderr
    assert "call the study below 'if __name__ == \"__main__\":'" in child.stderr


def test_a_function_that_is_not_found(tmp_path, monkeypatch):
    (tmp_path / "vanishing.py").write_text("def f(x):\n    return x\n")
    function = study.function_in(f"{tmp_path}/vanishing.py:f")
    (tmp_path / "vanishing.py").unlink()
    with pytest.raises(FlexmbError, match=r"the worker does not find the function to compute: ModuleNotFoundError"):
        fmb.sweep(function, {"x": [1]}, jobs=1)
    with pytest.raises(ModelError, match=r"there is no file '.*vanishing\.py'"):
        study.function_in(f"{tmp_path}/vanishing.py:f")
    (tmp_path / "present.py").write_text("def force(x):\n    return x\n")
    with pytest.raises(ModelError, match=re.escape("The file has: force. Did you mean 'force'?")):
        study.function_in(f"{tmp_path}/present.py:forse")
