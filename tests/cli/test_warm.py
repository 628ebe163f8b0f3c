"""Kernels are compiled ahead: those with a declared signature, and what the small analyses need."""

import os
import time
from concurrent.futures.process import BrokenProcessPool

import numpy as np
import pytest

import flexmb as fmb
from flexmb.cli import main, warm
from flexmb.cli.warm_models import ANALYSES
from flexmb.math import declared_kernels


def test_declared_kernels_are_those_of_all_kinds():
    functions = [getattr(k, "function", None) or k.py_func for k in declared_kernels("flexmb")]  # entries are compiled
    found = {f"{function.__module__}.{function.__name__}" for function in functions}
    assert {"flexmb.bodies.rigid.inertia", "flexmb.system.program.evaluation"} <= found
    assert len(found) > 40


@pytest.mark.parametrize("name", ANALYSES)
def test_every_analysis_runs(name):
    """To its end, with numbers: motions that move, equilibria and frequencies that are there."""
    found = ANALYSES[name]()
    if isinstance(found, fmb.Solution):
        assert found.status.ok
        q = found.phases[0].q
        assert np.all(np.isfinite(q))
        assert name == "statics" or np.ptp(q, axis=0).max() > 1e-6
    elif name == "linearize":
        assert found.frequencies.max() > 0.0
    elif name == "check":
        assert found.mobility > 0
    elif name == "joint torques":  # along the axis, upright: m (g + a)
        assert found == pytest.approx([9.81 + 0.3])
    elif name == "contact of skins":  # a force on an area at a pressure
        assert np.all(found[:, :3] > 0.0)
    elif name == "orbit":  # near the height where it began
        assert np.linalg.norm(found[:, :3], axis=1) == pytest.approx(7e6, rel=0.01)
    else:
        assert name == "accelerations"


def test_processes_compile_for_what_was_asked(tmp_path, monkeypatch):
    monkeypatch.setenv("NUMBA_CACHE_DIR", "before")
    monkeypatch.delenv("NUMBA_CPU_NAME", raising=False)
    with warm._environment(str(tmp_path), "x86-64-v3"):
        assert os.environ["NUMBA_CACHE_DIR"] == str(tmp_path)
        assert (os.environ["NUMBA_CPU_NAME"], os.environ["NUMBA_CPU_FEATURES"]) == ("x86-64-v3", "")
    assert os.environ["NUMBA_CACHE_DIR"] == "before"
    assert "NUMBA_CPU_NAME" not in os.environ


def test_jobs_are_at_least_one(capsys):
    assert main(["warm", "--jobs", "0"]) == 2
    assert "--jobs 0. Expected: a number of processes, 1 or more. Omit it" in capsys.readouterr().err


def test_kernels_to_ship_have_one_place(capsys):
    assert main(["warm", "--ship", "--into", "elsewhere"]) == 2
    assert "--into or --processor. Expected: one of x86_64, aarch64, and no other folder" in capsys.readouterr().err


def test_a_folder_that_cannot_be_written_is_named_before_compiling(tmp_path, capsys):
    (tmp_path / "file").write_text("")
    assert main(["warm", "--into", str(tmp_path / "file")]) == 2
    assert "cannot write into it" in capsys.readouterr().err


def test_an_interruption_does_not_wait_for_what_is_compiled():
    began = time.monotonic()
    tasks = []

    def interrupted():
        with warm._pool(1) as pool:
            with warm.ctrl_c_ignored():
                tasks.extend(pool.submit(time.sleep, 60.0) for _ in range(2))
            while not tasks[0].running():
                time.sleep(0.01)
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert time.monotonic() - began < 40.0
    assert all(task.done() for task in tasks)


def test_a_process_that_is_ended_while_it_compiles(monkeypatch, capsys):
    class Broken:
        def __init__(self, *_, **__):
            raise BrokenProcessPool

    monkeypatch.setattr(warm, "ProcessPoolExecutor", Broken)
    assert main(["warm", "--jobs", "1"]) == 2
    assert "a process that compiles was ended" in capsys.readouterr().err
