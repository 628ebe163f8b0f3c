"""What stands in a study folder or beside a run may be damaged, or be no file at all: a message, no waiting."""

import csv
import json
import os
import shutil
from dataclasses import replace

import pytest
from fuzz.mutation import generator, mutant

import flexmb as fmb
from flexmb.errors import DataFileError
from flexmb.lock import Lock, holder
from flexmb.study.folder import ROWS, SETTINGS, StudyFolder
from flexmb.study.plan import Plan
from flexmb.study.table import Results, Row

PLAN = Plan(names=("length",), rows=((1.0,), (2.0,)))
ROW = Row(number=1, parameters={"length": 1.0}, status="done", values={"max(place)": 0.3}, seconds=0.1)


@pytest.fixture
def folder(tmp_path):
    study = StudyFolder(tmp_path / "study", PLAN, {"model": "m"})
    study.add(ROW)
    study.close()
    return tmp_path / "study"


def test_continued(folder):
    study = StudyFolder(folder, PLAN, {"model": "m"})
    study.close()
    assert study.rows == {1: ROW}


@pytest.mark.parametrize(
    "line",
    [
        b'{"number": "1", "parameters": {}, "status": "done"}',
        b'{"number": [1], "parameters": {}, "status": "done"}',
        b'{"number": 1, "parameters": {}, "status": 3}',
        b'{"number": 1, "parameters": {}, "status": "done", "values": {"a": "b"}}',
        b'{"number": 1, "parameters": [], "status": "done"}',
        b"\xff\xfe",
        b"[" * 5000,
        b"3",
    ],
)
def test_a_row_of_another_kind(folder, line):
    with (folder / ROWS).open("ab") as stream:
        stream.write(line + b"\n")
    with pytest.raises(DataFileError, match=f"line 2 of {ROWS} is damaged.*Remove this line"):
        StudyFolder(folder, PLAN, {"model": "m"})


@pytest.mark.parametrize("name", [SETTINGS, ROWS])
def test_damaged_in_many_ways(folder, name):
    """200 mutants of each file: continued, or refused by name; the folder is not locked afterwards."""
    sound, refused = (folder / name).read_bytes(), 0
    for k in range(200):
        (folder / name).write_bytes(b"[" * 100_000 + b"\n" if k == 0 else mutant(sound, generator(5, k), values=True))
        try:
            StudyFolder(folder, PLAN, {"model": "m"}).close()
        except DataFileError:
            refused += 1
    assert 20 < refused < 200


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="named pipes")
def test_pipes_are_not_waited_for(tmp_path, folder):
    """Opening a pipe waits for its other end, a device has no end: neither is opened."""
    os.mkfifo(tmp_path / ".run.h5.lock")
    assert holder(tmp_path / "run.h5") == ""
    with pytest.raises(OSError, match="no regular file"):
        Lock(tmp_path / "run.h5", "Solution")
    os.mkfifo(tmp_path / "verification.json")
    os.symlink("/dev/zero", tmp_path / "endless.json")
    for name in ("verification.json", "endless.json"):
        with pytest.raises(DataFileError, match="no regular file"):
            fmb.Verification.load(tmp_path / name)
    (folder / SETTINGS).unlink()
    os.mkfifo(folder / SETTINGS)
    with pytest.raises(DataFileError, match="it holds"):
        StudyFolder(folder, PLAN, {"model": "m"})


def test_a_lock_with_a_number_that_no_process_has(tmp_path):
    (tmp_path / ".run.h5.lock").write_text(json.dumps({"pid": 10**30, "host": "x"}))
    lock = Lock(tmp_path / "run.h5", "Solution")
    assert json.loads((tmp_path / ".run.h5.lock").read_text())["pid"] == os.getpid()
    lock.release()
    assert not (tmp_path / ".run.h5.lock").exists()


@pytest.mark.skipif(os.name == "nt", reason="no open file can be removed there")
@pytest.mark.parametrize("how", ["removed", "moved", "removed, and a variant has made its own folder", "replaced"])
def test_a_folder_that_loses_its_place(tmp_path, how):
    """A cleaning script takes the folder of a study that runs: all of its rows are found in the morning."""
    study = StudyFolder(tmp_path / "study", PLAN, {"model": "m"})
    study.add(ROW)
    if how == "moved":
        os.rename(tmp_path / "study", tmp_path / "other")
    else:
        shutil.rmtree(tmp_path / "study")
    if "variant" in how:
        (tmp_path / "study" / "runs" / "0002").mkdir(parents=True)
    if how == "replaced":
        (tmp_path / "study").mkdir()
        (tmp_path / "study" / "mine.txt").write_text("mine")
    with pytest.warns(UserWarning, match=f"was {'moved' if how == 'moved' else 'removed'} during the study"):
        study.add(replace(ROW, number=2))
    study.close()
    place = tmp_path / {"moved": "other", "replaced": "study-kept"}.get(how, "study")
    again = StudyFolder(place, PLAN, {"model": "m"})
    again.close()
    assert again.rows == {1: ROW, 2: replace(ROW, number=2)}
    if how == "replaced":
        assert [p.name for p in (tmp_path / "study").iterdir()] == ["mine.txt"]


@pytest.mark.skipif(os.name == "nt", reason="no open file can be removed there")
def test_rows_are_tried_again_where_the_folder_could_not_be_written(tmp_path, monkeypatch):
    """The disk is full while the rows of a removed folder are written again: the next row writes all of them."""
    study = StudyFolder(tmp_path / "study", PLAN, {"model": "m"})
    study.add(ROW)
    shutil.rmtree(tmp_path / "study")

    def full(stream, row):
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as patch:
        patch.setattr("flexmb.study.folder._add_line", full)
        with pytest.raises(DataFileError, match="No space left"):
            study.add(replace(ROW, number=2))
    with pytest.warns(UserWarning, match="was removed during the study"):
        study.add(replace(ROW, number=2))
    study.close()
    again = StudyFolder(tmp_path / "study", PLAN, {"model": "m"})
    again.close()
    assert again.rows == {1: ROW, 2: replace(ROW, number=2)}


@pytest.mark.filterwarnings("error")
def test_a_changed_working_folder_is_no_moved_study(tmp_path, monkeypatch):
    """What a variant calls may leave another working folder behind."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "elsewhere").mkdir()
    study = StudyFolder("study", PLAN, {"model": "m"})
    os.chdir(tmp_path / "elsewhere")
    study.add(ROW)
    study.close()
    assert list((tmp_path / "elsewhere").iterdir()) == []
    assert (tmp_path / "study" / "results.csv").is_file()


def test_no_cell_of_the_table_is_a_formula(tmp_path):
    """A spreadsheet would compute it, and may start programs; negative numbers stay numbers."""
    text = "=HYPERLINK(1)"
    row = Row(number=1, parameters={"length": text}, status="failed", values={"@x": -0.5}, seconds=0.1, error="-1+cmd")
    Results(("length",), [row, replace(row, number=2, parameters={"length": "-1.5"})]).write_csv(tmp_path / "t.csv")
    table = list(csv.reader((tmp_path / "t.csv").open(newline="")))
    assert table[0][:4] == ["number", "length", "status", "'@x"]
    assert [line[1] for line in table[1:]] == [f"'{text}", "-1.5"]
    assert [line[3] for line in table[1:]] == ["-0.5", "-0.5"]
    assert table[1][-1] == "'-1+cmd"
