"""Sweeps on executors: threads, a pool whose process dies, a Dask cluster."""

import os
import subprocess
import sys

import pytest
from by_turns import slow
from study import formulas

import flexmb as fmb
from flexmb import study
from flexmb.errors import FlexmbError

BROKEN = """
import sys
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
import flexmb as fmb
from study import formulas
if __name__ == "__main__":
    if len(sys.argv) > 1:
        import gmsh
        gmsh.initialize(interruptible=False)
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as executor:
        results = fmb.sweep(formulas.square, {"x": [13, 2]}, executor=executor)
    print(results.rows[0].status, results.rows[0].error)
"""


@pytest.mark.parametrize("before", [(), slow(("gmsh",))])
def test_a_broken_pool_leaves_rows_with_its_error(tmp_path, before):
    """In a process of its own: Gmsh gives SIGPIPE back its default, by which a broken pipe ends the process."""
    if before:
        pytest.importorskip("gmsh")
    script = tmp_path / "broken.py"
    script.write_text(BROKEN)
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    child = subprocess.run(
        [sys.executable, script, *before], env=environment, capture_output=True, text=True, timeout=120
    )
    assert child.returncode == 0, child.stderr
    assert child.stdout.startswith("died BrokenProcessPool")


@pytest.fixture
def scheduler():
    distributed = pytest.importorskip("distributed")
    with distributed.LocalCluster(
        n_workers=1, threads_per_worker=1, processes=False, dashboard_address=None
    ) as cluster:
        yield cluster.scheduler_address


def test_dask(scheduler):
    with study.dask_executor(scheduler) as executor:
        results = fmb.sweep(formulas.square, {"x": [2, -1, 3]}, executor=executor)
    assert [row.status for row in results.rows] == ["done", "failed", "done"]
    assert results["y"][[0, 2]].tolist() == [4.0, 9.0]


def test_a_scheduler_without_workers():
    distributed = pytest.importorskip("distributed")
    with (
        distributed.LocalCluster(n_workers=0, processes=False, dashboard_address=None) as cluster,
        pytest.raises(
            FlexmbError, match=r"no worker after 0\.3 s\. Expected: at least one\. Start workers: dask worker"
        ),
        study.dask_executor(cluster.scheduler_address, timeout=0.3),
    ):
        pass


def test_a_scheduler_that_does_not_answer():
    pytest.importorskip("distributed")
    message = r"Dask scheduler 'tcp://127\.0\.0\.1:1': it cannot be reached .*Start one with 'dask scheduler'"
    with pytest.raises(FlexmbError, match=message), study.dask_executor("tcp://127.0.0.1:1", timeout=0.5):
        pass


def test_without_dask(monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    message = r"the package distributed is not installed\. Expected: the extra 'dask'\. pip install 'flexmb\[dask\]'"
    with pytest.raises(FlexmbError, match=message), study.dask_executor("tcp://host:8786"):
        pass
