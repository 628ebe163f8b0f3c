"""A run whose folder or file is removed, moved or replaced while it is written: nothing is lost, and it is said."""

import os
import shutil

import numpy as np
import pytest

import flexmb as fmb
from flexmb.cli import main
from flexmb.results import STORED, RunFile, Status

pytestmark = pytest.mark.skipif(os.name == "nt", reason="no open file can be removed there")

MODEL = """
name = "drop"
gravity = [0.0, 0.0, -9.81]
[[body]]
kind = "PointMass"
name = "stone"
mass = 2.0
[[sensor]]
kind = "Position"
name = "place"
marker = "stone.center"
[simulation]
t_end = 1.0
samples = 11
"""


def rows(t):
    one = np.array([t])
    return one, np.array([[1.0, 2.0, t]]), np.ones((1, 3)), np.zeros((1, 3)), np.zeros((1, 0)), np.zeros((1, 3))


def at_sample(number, monkeypatch, do):
    """Let `do` happen when so many samples have been handed to the file."""
    append, seen = RunFile.append, []

    def told(self, t, *others):
        seen.extend(np.atleast_1d(t))
        append(self, t, *others)
        if len(seen) >= number and do not in seen:
            seen.append(do)
            self.flush()
            do()

    monkeypatch.setattr(RunFile, "append", told)


@pytest.fixture
def ran(tmp_path, monkeypatch, capsys):
    """Return a function that runs the model into ``run`` while something happens to that; code, and what was said."""

    def run(do):
        monkeypatch.chdir(tmp_path)
        (tmp_path / "drop.toml").write_text(MODEL)
        at_sample(3, monkeypatch, do)
        code = main(["run", "drop.toml", "--out", "run"])
        said = capsys.readouterr()
        return code, " ".join((said.out + said.err).split())

    return run


def fallen(folder):
    solution = fmb.Solution.load(folder / "solution.h5", read_model=fmb.read_model_text)
    assert solution.status.kind == "finished"
    np.testing.assert_allclose(solution["place"][:, 2], -9.81 / 2 * solution.t**2, atol=1e-9)
    np.testing.assert_allclose(solution.t, np.linspace(0, 1, 11), rtol=1e-15)


def test_a_removed_run_folder_is_written_again(ran, tmp_path):
    code, said = ran(lambda: shutil.rmtree("run"))
    assert code == 2
    assert "was removed while it was written: it was written again, with every sample" in said
    fallen(tmp_path / "run")
    assert {p.name for p in (tmp_path / "run").iterdir()} == {"solution.h5", "sensors.csv", "model.toml", "log.txt"}
    assert main(["export", str(tmp_path / "run"), "--vtk"]) == 0


def test_a_folder_removed_while_the_table_is_written(tmp_path, monkeypatch, capsys):
    """The solution file is closed by then."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "drop.toml").write_text(MODEL)
    write, removed = fmb.write_table, []

    def remove(solution, path):
        if not removed:
            removed.append(shutil.rmtree("run"))
            os.mkdir("run")
        return write(solution, path)

    monkeypatch.setattr(fmb, "write_table", remove)
    assert main(["run", "drop.toml", "--out", "run"]) == 2
    assert "was removed when it was complete: it was written again" in capsys.readouterr().err
    fallen(tmp_path / "run")
    assert {p.name for p in (tmp_path / "run").iterdir()} == {"solution.h5", "sensors.csv", "model.toml", "log.txt"}


def test_a_moved_run_folder_is_completed_where_it_is(ran, tmp_path):
    code, said = ran(lambda: os.rename("run", "moved"))
    assert code == 2
    assert "was moved while it was written: it is" in said
    assert f"flexmb export {tmp_path / 'moved'} --vtk" in said
    assert not (tmp_path / "run").exists()
    fallen(tmp_path / "moved")
    assert {p.name for p in (tmp_path / "moved").iterdir()} == {"solution.h5", "sensors.csv", "model.toml", "log.txt"}


def test_another_folder_of_the_name_is_left_alone(ran, tmp_path):
    def replace():
        shutil.rmtree("run")
        os.mkdir("run")
        (tmp_path / "run" / "mine.txt").write_text("mine")

    code, said = ran(replace)
    assert code == 2
    assert "run-kept" in said
    fallen(tmp_path / "run-kept")
    assert [p.name for p in (tmp_path / "run").iterdir()] == ["mine.txt"]


def test_another_file_of_the_name_is_left_alone(ran, tmp_path):
    def replace():
        os.remove("run/solution.h5")
        (tmp_path / "run" / "solution.h5").write_text("mine")

    code, said = ran(replace)
    assert code == 2
    assert "solution-kept.h5" in said
    assert (tmp_path / "run" / "solution.h5").read_text() == "mine"
    kept = fmb.Solution.load(tmp_path / "run" / "solution-kept.h5", read_model=fmb.read_model_text)
    assert len(kept.t) == 11
    assert (tmp_path / "run" / "solution-kept.csv").is_file()


def test_a_file_without_samples_in_another_folder_is_left_alone(tmp_path, monkeypatch, capsys):
    """A run that fails before its first sample removes its own empty file, not that of a run that began meanwhile."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "drop.toml").write_text(MODEL)

    def replace_and_fail(model, **settings):
        shutil.rmtree("run")
        os.mkdir("run")
        with RunFile(tmp_path / "run" / "solution.h5") as theirs:
            theirs.begin()
        raise fmb.errors.IntegrationError("Model 'drop'", found="no start")

    monkeypatch.setattr(fmb, "simulate", replace_and_fail)
    assert main(["run", "drop.toml", "--out", "run"]) == 2
    assert "no start" in capsys.readouterr().err
    assert [p.name for p in (tmp_path / "run").iterdir()] == ["solution.h5"]


def test_a_folder_that_cannot_be_made_again_is_told(ran, tmp_path, monkeypatch):
    """The message must not say that a file keeps what is lost."""

    def remove():
        shutil.rmtree("run")
        monkeypatch.setattr("flexmb.results.journal.Journal.copy_to", full)

    def full(self, path):
        raise OSError(28, "No space left on device")

    code, said = ran(remove)
    assert code == 2
    assert "its samples are in this process alone" in said
    assert "Nothing is stored" in said
    assert "export" not in said
    assert not (tmp_path / "run" / "solution.h5").exists()


def test_a_second_run_keeps_its_lock(tmp_path, monkeypatch):
    """The first one's folder was moved, and a second run has begun in a folder of that name."""
    first = RunFile(_made(tmp_path / "run") / "solution.h5")
    first.begin()
    first.append(*rows(0.0))
    os.rename(tmp_path / "run", tmp_path / "moved")
    _made(tmp_path / "run").joinpath(".solution.h5.lock").write_text("theirs")
    with pytest.warns(UserWarning, match="was moved while it was written"):
        first.finish(Status.finished(0.0))
    assert (tmp_path / "run" / ".solution.h5.lock").read_text() == "theirs"
    assert [p.name for p in (tmp_path / "moved").iterdir()] == ["solution.h5"]


def test_a_removed_file_is_safe_again_before_the_end(tmp_path):
    """What was written again survives the end of the process: it is read before the run is closed."""
    file = RunFile(tmp_path / "run.h5", rows=1)
    file.begin()
    file.append(*rows(0.0))
    os.remove(tmp_path / "run.h5")
    with pytest.warns(UserWarning, match="was removed while it was written"):
        file.append(*rows(1.0))
    file.append(*rows(2.0))
    assert list(fmb.Solution.load(tmp_path / "run.h5").t) == [0.0, 1.0, 2.0]
    file.finish(Status.finished(2.0))
    assert list(fmb.Solution.load(tmp_path / "run.h5").t) == [0.0, 1.0, 2.0]


def test_what_a_network_file_system_does_with_a_removed_file(tmp_path):
    """It only hides an open file under such a name, and removes it when it is closed: it must be written again."""
    file = RunFile(tmp_path / "run.h5", rows=1)
    file.begin()
    file.append(*rows(0.0))
    os.rename(tmp_path / "run.h5", tmp_path / ".nfs000000012345")
    with pytest.warns(UserWarning, match="was removed while it was written: it was written again"):
        file.finish(Status.finished(0.0))
    os.remove(tmp_path / ".nfs000000012345")
    assert list(fmb.Solution.load(tmp_path / "run.h5").t) == [0.0]


def _made(folder):
    folder.mkdir()
    return folder


@pytest.mark.filterwarnings("error")
def test_a_changed_working_folder_is_no_moved_file(tmp_path, monkeypatch):
    """A callback of the user may change it: the path was given relative to the former one."""
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path)
    file = RunFile("run.h5", rows=1)
    file.begin()
    os.chdir(tmp_path / "elsewhere")
    file.append(*rows(0.0))
    assert file.finish(Status.finished(0.0)) == tmp_path / "run.h5"
    assert not file.lost_its_place
    assert list((tmp_path / "elsewhere").iterdir()) == []
    assert list(fmb.Solution.load(tmp_path / "run.h5").t) == [0.0]


def test_a_saved_copy_does_not_say_where_the_run_was_left(tmp_path):
    """Else a command that reads the copy takes it for one that has lost its place."""
    file = RunFile(tmp_path / "run.h5")
    file.begin()
    file.append(*rows(0.0))
    file.finish(Status.finished(0.0))
    moved = fmb.Solution.load(tmp_path / "run.h5")
    moved.statistics[STORED] = str(tmp_path / "moved.h5")
    moved.save(tmp_path / "copy.h5")
    assert STORED not in fmb.Solution.load(tmp_path / "copy.h5").statistics
    assert STORED in moved.statistics


def test_a_run_whose_model_changes_the_working_folder(ran, tmp_path):
    """Everything is written where it was asked for, and nothing is said to have moved."""
    (tmp_path / "elsewhere").mkdir()
    code, said = ran(lambda: os.chdir(tmp_path / "elsewhere"))
    assert code == 0
    assert "moved" not in said
    assert "removed" not in said
    assert list((tmp_path / "elsewhere").iterdir()) == []
    fallen(tmp_path / "run")
    assert {p.name for p in (tmp_path / "run").iterdir()} == {"solution.h5", "sensors.csv", "model.toml", "log.txt"}
