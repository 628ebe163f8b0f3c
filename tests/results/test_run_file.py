"""The file of a running simulation: complete at every flush, whatever happens to the process."""

import errno
import os
import signal
import subprocess
import sys
import time

import h5py
import numpy as np
import pytest
from results.spinning import block_data, spinning_phase

from flexmb import hdf5
from flexmb.errors import DataFileError, FlexmbError
from flexmb.results import RunFile, Solution, Status
from flexmb.results.run_file import SCHEMA, VERSION
from flexmb.sensors import Position

WRITER = """
import sys, numpy as np
from flexmb.results import RunFile
run = RunFile(sys.argv[1], rows=16)
run.begin("text")
print("go", flush=True)
k = 0.0
while True:
    run.append(k, np.full(9, k), np.full(8, k), np.full(8, k), np.full(5, k), np.full(3, k))
    k += 1.0
"""


def fill(run, phase, rows=slice(None)):
    run.append(*(getattr(phase, name)[rows] for name in ("t", "q", "u", "a", "lam", "works")))


def test_samples_one_by_one_and_in_blocks(tmp_path):
    phase = spinning_phase(system=False)
    with RunFile(tmp_path / "run.h5", {"block": block_data()}, rows=4) as run:
        run.begin("model")
        for k in range(6):
            fill(run, phase, k)
        fill(run, phase, slice(6, None))
        run.finish(Status.finished(1.0))
    loaded = Solution.load(tmp_path / "run.h5")
    for name in ("t", "q", "u", "a", "lam", "works"):
        np.testing.assert_array_equal(getattr(loaded.phases[0], name), getattr(phase, name))


def test_a_sensor_that_is_not_stored_needs_the_model(tmp_path):
    """One phase or several: what the file does not hold cannot be read without the model."""
    zero = np.zeros(0)
    with RunFile(tmp_path / "run.h5") as run:
        for _ in range(2):
            run.begin("model")
            run.append(0.0, zero, zero, zero, zero, np.zeros(3))
            run.end("event")
    with pytest.raises(FlexmbError, match="'tip' asked of a file that was read without its model") as caught:
        Solution.load(tmp_path / "run.h5")[Position("tip", marker="beam.tip")]
    assert "Solution.load(path, model=" in str(caught.value)


def test_arrays_may_be_reused(tmp_path):
    q = np.zeros(2)
    with RunFile(tmp_path / "run.h5") as run:
        run.begin()
        for k in range(3):
            q[:] = k
            run.append(float(k), q, q, q, np.zeros(0), np.zeros(3))
    np.testing.assert_array_equal(Solution.load(tmp_path / "run.h5").phases[0].q[:, 0], [0, 1, 2])


def test_no_constraints_is_a_width_of_zero(tmp_path):
    with RunFile(tmp_path / "run.h5") as run:
        run.begin()
        run.append(0.0, np.zeros(7), np.zeros(6), np.zeros(6), np.zeros(0), np.zeros(3))
        run.finish(Status.finished())
    assert Solution.load(tmp_path / "run.h5").phases[0].lam.shape == (1, 0)


def test_a_body_used_twice_is_stored_once(tmp_path):
    data = block_data()
    RunFile(tmp_path / "run.h5", {"left": data, "right": data, "other": block_data()}).close()
    with h5py.File(tmp_path / "run.h5") as file:
        assert len(file["data"]) == 2


def test_readable_while_it_is_written(tmp_path):
    """A reader in another process sees what has been flushed."""
    phase = spinning_phase(system=False)
    with RunFile(tmp_path / "run.h5", rows=4) as run:
        run.begin()
        fill(run, phase, slice(0, 5))
        fill(run, phase, slice(5, 7))  # waits in memory
        code = (
            f"from flexmb.results import Solution; s = Solution.load({str(tmp_path / 'run.h5')!r}); "
            "print(len(s.t), s.status.kind)"
        )
        environment = {**os.environ, "HDF5_USE_FILE_LOCKING": "FALSE"}
        command = [sys.executable, "-c", code]
        child = subprocess.run(command, capture_output=True, text=True, env=environment, check=True)
    assert child.stdout.split() == ["5", "interrupted"]


def test_a_killed_process_keeps_what_was_flushed(tmp_path):
    for k, delay in enumerate((0.05, 0.1, 0.2)):
        path = tmp_path / f"run{k}.h5"
        child = subprocess.Popen([sys.executable, "-c", WRITER, str(path)], stdout=subprocess.PIPE)
        child.stdout.readline()
        time.sleep(delay)
        child.send_signal(signal.SIGKILL)
        child.wait()
        child.stdout.close()
        solution = Solution.load(path)
        assert solution.status.kind == "interrupted"
        n = len(solution.t)
        assert n >= 16
        assert n % 16 == 0
        for name, width in (("q", 9), ("u", 8), ("a", 8), ("lam", 5), ("works", 3)):
            np.testing.assert_array_equal(getattr(solution.phases[0], name), np.arange(n)[:, None] * np.ones(width))


def test_killed_before_the_first_sample(tmp_path):
    run = RunFile(tmp_path / "run.h5")
    run.begin()
    run.close()
    with pytest.raises(DataFileError, match=r"there are no samples.*run it again"):
        Solution.load(tmp_path / "run.h5")


def test_other_schema_versions(tmp_path):
    for version, remedy in ((VERSION + 1, "Update flexmb"), (VERSION - 1, "Make the file again")):
        hdf5.streaming(tmp_path / "run.h5", schema=SCHEMA, version=version).close()
        with pytest.raises(DataFileError, match=rf"schema version {version}.*version {VERSION}.*{remedy}"):
            Solution.load(tmp_path / "run.h5")


def test_no_folder(tmp_path):
    with pytest.raises(DataFileError, match=r"folder '.*nowhere' does not exist"):
        RunFile(tmp_path / "nowhere" / "run.h5")


def test_a_place_that_cannot_be_written(tmp_path):
    (tmp_path / "run.h5").mkdir()
    with pytest.raises(DataFileError, match=r"cannot create it.*a writable folder.*choose another folder"):
        RunFile(tmp_path / "run.h5")


def test_full_disk(tmp_path, monkeypatch):
    """What was flushed before the disk was full stays readable."""
    phase = spinning_phase(system=False)
    run = RunFile(tmp_path / "run.h5", rows=4)
    run.begin()
    fill(run, phase, slice(0, 5))

    def full(self):
        raise OSError(errno.ENOSPC, "No space left on device")

    with monkeypatch.context() as patch:
        patch.setattr(h5py.File, "flush", full)
        with pytest.raises(DataFileError, match=r"cannot write it.*No space left.*before stays readable.*Free space"):
            fill(run, phase, slice(5, 10))
    run.close()
    assert len(Solution.load(tmp_path / "run.h5").t) >= 5
