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

from flexmb import hdf5, hdf5_seal
from flexmb.errors import DataFileError, FlexmbError
from flexmb.files import replacing
from flexmb.results import RunFile, Solution, Status, journal
from flexmb.results.hdf5_part import SCHEMA, VERSION
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
    """A reader in another process sees what has been flushed, and that the run goes on."""
    phase = spinning_phase(system=False)
    with RunFile(tmp_path / "run.h5", rows=4) as run:
        run.begin()
        fill(run, phase, slice(0, 5))
        fill(run, phase, slice(5, 7))  # waits in memory
        code = (
            f"from flexmb.results import Solution; s = Solution.load({str(tmp_path / 'run.h5')!r}); "
            "print(len(s.t), s.status.kind)"
        )
        child = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert child.stdout.split() == ["5", "running"]


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
        with hdf5.writing(tmp_path / "run.h5", schema=SCHEMA, version=version):
            pass
        with pytest.raises(DataFileError, match=rf"schema version {version}.*version {VERSION}.*{remedy}"):
            Solution.load(tmp_path / "run.h5")


def test_no_folder(tmp_path):
    with pytest.raises(DataFileError, match=r"folder '.*nowhere' does not exist"):
        RunFile(tmp_path / "nowhere" / "run.h5")


def test_a_name_with_a_zero_byte(tmp_path):
    with pytest.raises(DataFileError, match=r"its name holds a zero byte\. Expected: a name without one"):
        RunFile(tmp_path / "run\0.h5")
    for folder in (False, True):
        with pytest.raises(DataFileError, match="holds a zero byte"), replacing(tmp_path / "a\0" / "b", folder=folder):
            pass


def test_a_place_that_cannot_be_written(tmp_path):
    (tmp_path / "run.h5").mkdir()
    with pytest.raises(DataFileError, match=r"cannot create it.*a writable folder.*choose another folder"):
        RunFile(tmp_path / "run.h5")


FULL = """
import resource, sys
import numpy as np
from flexmb.errors import DataFileError
from flexmb.results import RunFile
run = RunFile(sys.argv[1], rows=4)
run.begin("text")
def fill(first, last):
    k = np.arange(float(first), last)
    run.append(k, *(np.outer(k, np.ones(n)) for n in (9, 8, 8, 5, 3)))
fill(0, 5)
resource.setrlimit(resource.RLIMIT_FSIZE, (run.path.stat().st_size + int(sys.argv[2]), -1))
try:
    fill(5, 10)
except DataFileError as error:
    print(error)
try:
    run.close()
except DataFileError:
    print("closed")
"""


@pytest.mark.parametrize("room", [0, 1, 100, 1000])
def test_full_disk(tmp_path, room):
    """What was written before the disk was full stays readable, wherever in a record it came to its end."""
    command = [sys.executable, "-c", FULL, str(tmp_path / "run.h5"), str(room)]
    child = subprocess.run(command, capture_output=True, text=True, check=True)
    for words in ("cannot write it", "File too large", "before stays readable", "Free space", "closed"):
        assert words in child.stdout
    np.testing.assert_array_equal(Solution.load(tmp_path / "run.h5").t, np.arange(5.0))


def test_a_block_that_did_not_fit_is_written_when_the_file_is_closed(tmp_path, monkeypatch):
    phase = spinning_phase(system=False)
    run = RunFile(tmp_path / "run.h5", rows=4)
    run.begin()
    fill(run, phase, slice(0, 5))

    def full(*arguments):
        raise OSError(errno.ENOSPC, "No space left on device")

    with monkeypatch.context() as patch:
        patch.setattr(run._journal, "add", full)
        with pytest.raises(DataFileError, match=r"cannot write it.*No space left.*before stays readable.*Free space"):
            fill(run, phase, slice(5, 10))
    run.close()
    np.testing.assert_array_equal(Solution.load(tmp_path / "run.h5").t, phase.t[:10])


def test_a_cut_at_any_byte_leaves_whole_records(tmp_path):
    """Cut off behind every third byte, and around the ends of records: all records that are whole are read."""
    phase = spinning_phase(system=False)
    path, ends = tmp_path / "run.h5", []
    run = RunFile(path, rows=1)
    run.begin("model")
    for k in range(3):
        fill(run, phase, k)
        ends.append(path.stat().st_size)
    whole, first = path.read_bytes(), ends[0]
    for size in {*range(first, len(whole), 3), *ends, *(end - 1 for end in ends[1:])}:
        (tmp_path / "cut.h5").write_bytes(whole[:size])
        assert len(Solution.load(tmp_path / "cut.h5").t) == sum(end <= size for end in ends)
    run.close()


@pytest.mark.parametrize("at", [0, 7, 12, 30, 70])
def test_a_changed_byte_ends_the_records(tmp_path, at):
    phase = spinning_phase(system=False)
    path = tmp_path / "run.h5"
    run = RunFile(path, rows=1)
    run.begin("model")
    fill(run, phase, 0)
    start = path.stat().st_size
    fill(run, phase, 1)
    content = bytearray(path.read_bytes())
    content[start + at] ^= 0xFF
    (tmp_path / "bad.h5").write_bytes(content)
    assert len(Solution.load(tmp_path / "bad.h5").t) == 1
    run.close()


def test_a_second_writer_is_refused(tmp_path):
    """In this process and in another one, before anything is changed."""
    path = tmp_path / "run.h5"
    with RunFile(path, rows=1) as run:
        run.begin("model")
        run.append(0.0, np.zeros(1), np.zeros(1), np.zeros(1), np.zeros(0), np.zeros(3))
        with pytest.raises(DataFileError, match=r"this process is writing it already.*one writer at a time"):
            RunFile(path)
        before = path.read_bytes()
        code = f"from flexmb.results import RunFile; RunFile({str(path)!r})"
        child = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
        assert f"process {os.getpid()} on host" in child.stderr
        assert path.read_bytes() == before
        assert Solution.load(path).status.kind == "running"
    assert Solution.load(path).status.kind == "interrupted"
    assert [entry.name for entry in tmp_path.iterdir()] == ["run.h5"]
    RunFile(path).close()


def test_a_file_that_another_program_has_locked(tmp_path):
    """It is not called damaged."""
    path = tmp_path / "run.h5"
    RunFile(path).close()
    held = h5py.File(path, "r+")
    code = f"from flexmb.results import Solution; Solution.load({str(path)!r})"
    child = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    held.close()
    assert "another program has locked it" in child.stderr
    assert "damaged" not in child.stderr


def test_rows_of_an_older_release_that_a_kill_left_incomplete(tmp_path):
    """Older releases wrote samples into HDF5 datasets that grow, and took space in advance."""
    phase = spinning_phase(system=False)
    path = tmp_path / "run.h5"
    with hdf5.writing(path, schema=SCHEMA, version=VERSION) as file:
        file.create_group("data")
        file.attrs["bodies"] = "{}"
        group = file.create_group("phases/0")
        group.attrs["model"] = ""
        for name in ("t", "q", "u", "a", "lam", "works"):
            rows = getattr(phase, name)[: 7 if name == "t" else 6]
            if rows.shape[1:] != (0,):
                group.create_dataset(name, data=rows, maxshape=(None, *rows.shape[1:]))
    path.write_bytes(path.read_bytes() + bytes(5000))
    np.testing.assert_array_equal(Solution.load(path).t, phase.t[:6])
    with RunFile.continued(path) as run:
        fill(run, phase, slice(6, 9))
    loaded = Solution.load(path).phases[0]
    for name in ("t", "q", "u", "a", "lam", "works"):
        np.testing.assert_array_equal(getattr(loaded, name), getattr(phase, name)[:9])


def test_the_state_reached_is_read_until_the_next_sample(tmp_path):
    phase = spinning_phase(system=False)
    path = tmp_path / "run.h5"

    def row(k):
        return [getattr(phase, name)[k] for name in ("t", "q", "u", "a", "lam", "works")]

    with RunFile(path) as run:
        run.begin("model")
        run.append(*row(0))
        run.reached(*row(1))
        run.reached(*row(2))
        assert list(Solution.load(path).t) == [phase.t[0], phase.t[2]]
        assert Solution.load(path).phases[0].cut_off
    assert Solution.load(path).phases[0].cut_off
    with RunFile.continued(path) as run:
        assert list(Solution.load(path).t) == [phase.t[0], phase.t[2]]
        run.append(*row(3))
        run.end("finished")
        run.finish(Status.finished())
    loaded = Solution.load(path)
    assert list(loaded.t) == [phase.t[0], phase.t[3]]
    assert not loaded.phases[0].cut_off


@pytest.mark.parametrize(
    ("kind", "says"),
    [
        ("SA", {"n": 10**12, "widths": [9, 8, 8, 5, 3]}),
        ("SA", {"n": -1, "widths": [9, 8, 8, 5, 3]}),
        ("SA", {"n": 1}),
        ("SA", {"n": 0, "widths": [1, 1, 1, 1, 1]}),
        ("EN", {"reason": "finished", "tables": [{"name": "a", "shape": [10**9, 10**9], "columns": []}]}),
        ("EN", {"reason": "finished", "tables": 3}),
        ("RE", {"n": "many"}),
        ("FI", {}),
    ],
)
def test_a_whole_record_that_makes_no_sense(tmp_path, kind, says):
    """Its checksum is right, but no run has written it: an error with a remedy, and nothing is allocated for it."""
    phase, path = spinning_phase(system=False), tmp_path / "run.h5"
    run = RunFile(path)
    run.begin("model")
    fill(run, phase, 0)
    run.flush()
    run._journal.add(kind, says)
    with pytest.raises(DataFileError, match=r"truncated or damaged \(a record .*makes no sense"):
        Solution.load(path)
    run._journal.close()
    run._lock.release()


def test_the_disk_has_content_and_seal_before_the_name(tmp_path, monkeypatch):
    """A power cut at any moment leaves the old file or the whole new one: what is asked for last is the whole file."""
    sealed, moved = [], []
    sync, replace = os.fsync, os.replace

    def synced(handle):
        sync(handle)
        (part,) = tmp_path.glob(".flexmb.*")
        sealed.append(hdf5_seal.state_of(part))

    def named(old, new):
        moved.append(len(sealed))
        replace(old, new)

    monkeypatch.setattr(os, "fsync", synced)
    monkeypatch.setattr(os, "replace", named)
    with RunFile(tmp_path / "run.h5") as run:
        run.begin("text")
    assert sealed == [hdf5_seal.WHOLE] * 2  # when it is made, and when it ends
    assert moved == [1, 2]


def test_the_disk_is_asked_now_and_then_while_samples_come(tmp_path, monkeypatch):
    asked, clock = [], [0.0]
    with RunFile(tmp_path / "run.h5", rows=1) as run:
        run.begin("text")
        sync = os.fsync
        monkeypatch.setattr(os, "fsync", lambda handle: asked.append(clock[0]) or sync(handle))
        monkeypatch.setattr(journal.time, "monotonic", lambda: clock[0])
        run._journal._synced = 0.0
        for k in range(1, 31):
            clock[0] = float(k)
            run.append(clock[0], np.ones(9), np.ones(8), np.ones(8), np.ones(5), np.ones(3))
        monkeypatch.undo()
    assert asked == [11.0, 22.0]
    assert len(Solution.load(tmp_path / "run.h5").t) == 30


def test_records_that_have_changed_places(tmp_path):
    """Each is whole, but they are not in the order of time: refused, never a solution whose time runs back."""
    path = tmp_path / "run.h5"
    run = RunFile(path, rows=1)
    run.begin("text")
    ends = [run._journal._end]
    for k in range(4):
        run.append(float(k), np.ones(9), np.ones(8), np.ones(8), np.ones(5), np.ones(3))
        ends.append(run._journal._end)
    run.flush()
    whole = path.read_bytes()
    first, second, *_, last = (whole[a:b] for a, b in zip(ends, [*ends[1:], len(whole)]))
    for order in ([second, first], [first, first], [second, last, first]):
        path.write_bytes(whole[: ends[0]] + b"".join(order))
        with pytest.raises(DataFileError, match=r"makes no sense: samples at t = \S+ s that do not follow"):
            Solution.load(path)
    path.write_bytes(whole)
    assert Solution.load(path).t.tolist() == [0.0, 1.0, 2.0, 3.0]
    run._journal.close()
    run._lock.release()


def one_by_one(path, count=6, continued=False):
    """Return the content of a file that is being written, and where its samples begin and end."""
    run = RunFile.continued(path) if continued else RunFile(path, rows=1)
    if not continued:
        run.begin("text")
    ends = [run._journal._end]
    first = 10.0 if continued else 0.0
    for k in range(count):
        run.append(first + k, np.ones(9), np.ones(8), np.ones(8), np.ones(5), np.ones(3))
        run.flush()
        ends.append(run._journal._end)
    run._journal.close()
    run._lock.release()
    return path.read_bytes(), ends


@pytest.mark.parametrize(
    ("dropped", "read", "lost"),
    [((3, 4), 3, 2), ((2, 5), 2, 1), ((4, 5), 4, 1), ((5, 6), 5, 0)],
)
def test_records_that_are_missing_from_the_middle(tmp_path, dropped, read, lost):
    """Those behind a gap are left out and counted; what is missing at the end cannot be told from a kill."""
    path = tmp_path / "run.h5"
    whole, ends = one_by_one(path)
    first, last = dropped
    path.write_bytes(whole[: ends[first]] + whole[ends[last] :])
    if not lost:
        assert len(Solution.load(path).t) == read
        return
    with pytest.warns(
        UserWarning, match=rf"missing or damaged behind t = {read - 1} s, and {lost} samples that follow"
    ):
        solution = Solution.load(path)
    assert solution.t.tolist() == [float(k) for k in range(read)]
    assert solution.status.kind == "interrupted"
    assert f"{lost} samples" in solution.status.message


@pytest.mark.parametrize("at", [0, 7, 12, 30, 70])
def test_a_changed_byte_in_the_middle_tells_what_follows(tmp_path, at):
    path = tmp_path / "run.h5"
    whole, ends = one_by_one(path)
    content = bytearray(whole)
    content[ends[2] + at] ^= 0xFF
    path.write_bytes(content)
    with pytest.warns(UserWarning, match=r"behind t = 1 s, and 3 samples that follow"):
        assert Solution.load(path).t.tolist() == [0.0, 1.0]


def test_a_run_goes_on_before_the_gap(tmp_path):
    path = tmp_path / "run.h5"
    whole, ends = one_by_one(path)
    path.write_bytes(whole[: ends[2]] + whole[ends[3] :])
    with RunFile.continued(path) as run:
        run.append(10.0, np.ones(9), np.ones(8), np.ones(8), np.ones(5), np.ones(3))
    assert Solution.load(path).t.tolist() == [0.0, 1.0, 10.0]


def test_a_run_without_its_first_record(tmp_path):
    path = tmp_path / "run.h5"
    run = RunFile(path, rows=1)
    start = run._journal._end
    run.begin("text")
    second = run._journal._end
    run.append(0.0, np.ones(9), np.ones(8), np.ones(8), np.ones(5), np.ones(3))
    run.flush()
    whole = path.read_bytes()
    path.write_bytes(whole[:start] + whole[second:])
    with pytest.raises(DataFileError, match=r"no samples \(part of the file is missing .* its start, and 1 samples"):
        Solution.load(path)
    path.write_bytes(whole)
    run.close()


def test_a_file_that_is_damaged_while_it_is_written_stays_as_it_is(tmp_path):
    path = tmp_path / "run.h5"
    run = RunFile(path, rows=1)
    run.begin("text")
    for k in range(3):
        place = run._journal._end
        run.append(float(k), np.ones(9), np.ones(8), np.ones(8), np.ones(5), np.ones(3))
        if k == 1:
            damaged = place + 70
    with path.open("r+b") as stream:
        stream.seek(damaged)
        stream.write(b"\xff")
    with pytest.warns(UserWarning, match="records that were written during the run are missing or damaged"):
        run.close()
    with pytest.warns(UserWarning, match=r"behind t = 0 s, and 1 samples that follow"):
        assert Solution.load(path).t.tolist() == [0.0]


def test_records_without_numbers_are_read(tmp_path, monkeypatch):
    """Files of earlier states, also when a run goes on in them; a gap behind them is noticed from then on."""
    path, dumps = tmp_path / "run.h5", journal.json.dumps

    def plain(says):
        left = {key: value for key, value in says.items() if key != "serial"} if isinstance(says, dict) else says
        return dumps(left)

    with monkeypatch.context() as patch:
        patch.setattr(journal.json, "dumps", plain)
        whole, _ = one_by_one(path)
    assert b"serial" not in whole
    assert len(Solution.load(path).t) == 6
    whole, ends = one_by_one(path, 3, continued=True)
    assert Solution.load(path).t.tolist() == [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 10.0, 11.0, 12.0]
    path.write_bytes(whole[: ends[1]] + whole[ends[2] :])
    with pytest.warns(UserWarning, match=r"behind t = 10 s, and 1 samples that follow"):
        assert len(Solution.load(path).t) == 7


@pytest.mark.parametrize("name", ["warnings", "notes", "reactions not unique"])
@pytest.mark.parametrize("value", [None, 1, "text", [1, 2], {"a": 1}])
def test_statistics_of_another_kind_are_refused(tmp_path, name, value):
    """Lists of sentences and names are read later, by reports and resumed runs, which would end in a traceback."""
    with RunFile(tmp_path / "run.h5") as run:
        run.begin("")
        run.append(0.0, [1.0], [0.0], [0.0], [], [0.0, 0.0, 0.0])
        run.end("finished")
        run.finish(Status.finished(0.0), {name: value})
    with pytest.raises(DataFileError, match="damaged"):
        Solution.load(tmp_path / "run.h5")


def test_what_was_not_counted_is_left_out(tmp_path):
    with RunFile(tmp_path / "run.h5") as run:
        run.begin("")
        run.append(0.0, [1.0], [0.0], [0.0], [], [0.0, 0.0, 0.0])
        run.end("finished")
        run.finish(Status.finished(0.0), {"steps": None, "seconds": 2.0})
    assert Solution.load(tmp_path / "run.h5").statistics == {"seconds": 2.0}


@pytest.mark.parametrize(
    "value", [None, 1.0, "text", [0.1], {"Joint 'a'": "text"}, {"Joint 'a'": None}, {"Joint 'a'": {}}]
)
def test_errors_of_reactions_that_are_no_numbers_are_left_out(tmp_path, value):
    """A resumed run compares them with its own."""
    with RunFile(tmp_path / "run.h5") as run:
        run.begin("")
        run.append(0.0, [1.0], [0.0], [0.0], [], [0.0, 0.0, 0.0])
        run.end("finished")
        run.finish(Status.finished(0.0), {"errors of reactions": value, "seconds": 2.0})
    assert Solution.load(tmp_path / "run.h5").statistics == {"seconds": 2.0}
