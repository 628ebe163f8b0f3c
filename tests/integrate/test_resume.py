"""Continuing a run: the motion of the uninterrupted one to the tolerance of the integrator, in memory and on disk."""

import os
import signal
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

import flexmb as fmb
from flexmb.cli import main
from flexmb.results import RunFile

CLOSE = 3e-4
"""Two runs of an integrator at rtol = 1e-7 that take different steps, over two seconds of a double pendulum."""


def pendulum(**options):
    """A double pendulum in a plane with a damper at its tip."""
    a = fmb.RigidBody.rod("a", length=1.0, mass=1.0, radius=0.02)
    b = fmb.RigidBody.rod("b", length=1.0, mass=1.0, radius=0.02)
    return fmb.Model(
        name="double pendulum",
        gravity=(0, -9.81, 0),
        bodies=[fmb.Ground(markers={"far": (4, 0, 0)}), a, replace(b, at=(1, 0, 0))],
        joints=[
            fmb.Revolute("A", markers=("ground.origin", "a.start")),
            fmb.Revolute("B", markers=("a.end", "b.start")),
        ],
        forces=[fmb.SpringDamper("damper", markers=("ground.far", "b.end"), stiffness=0.0, damping=0.2, length=1.0)],
        sensors=[fmb.Position("tip", marker="b.end"), fmb.JointCoordinate("angle", joint="A"), fmb.Energy("energy")],
        **options,
    )


def simulate(model, t_end, **options):
    return fmb.simulate(model, t_end, integrator=fmb.GeneralizedAlpha(rtol=1e-7), **options)


def resume(run, t_end, **options):
    return fmb.resume(run, t_end, integrator=fmb.GeneralizedAlpha(rtol=1e-7), **options)


def assert_same(found, expected):
    np.testing.assert_allclose(found.t, expected.t, rtol=0, atol=1e-12)
    assert [phase.ended for phase in found.phases] == [phase.ended for phase in expected.phases]
    for name in expected.sensor_names:
        scale = np.abs(expected[name]).max()
        np.testing.assert_allclose(found[name], expected[name], rtol=0, atol=CLOSE * scale)
    for ours, theirs in zip(found.phases, expected.phases):
        np.testing.assert_allclose(ours.works, theirs.works, rtol=0, atol=CLOSE * np.abs(theirs.works).max())


@pytest.fixture(scope="module")
def whole():
    return simulate(pendulum(), 2.0, samples=101)


def test_a_solution_goes_on(whole):
    part = simulate(pendulum(), 0.8, samples=41)
    assert_same(resume(part, 2.0, samples=101), whole)


def test_events_before_and_after():
    """The second rod is let go at 0.3 s; the run is cut off in the second phase, and an event ends it in the third."""
    events = [
        fmb.Event("break", at=0.3, then=[fmb.Release("B")]),
        fmb.Event("far", sensor="angle", below=-2.0, then=[fmb.Stop()]),
    ]
    model = pendulum(events=events)
    expected = simulate(model, 2.0, samples=101)
    assert expected.status.kind == "stopped"
    part = simulate(model, 0.5, samples=26)
    assert len(part.phases) == 2
    found = resume(part, 2.0, samples=101)
    assert found.status.kind == "stopped"
    assert found.t[-1] == pytest.approx(expected.t[-1], abs=1e-4)
    np.testing.assert_allclose(found["tip"][-1], expected["tip"][-1], rtol=0, atol=1e-3)


def test_file_goes_on_in_place(whole, tmp_path):
    path = tmp_path / "run.h5"
    simulate(pendulum(), 0.8, samples=41, output=path, write_model=fmb.model_text)
    found = resume(path, 2.0, samples=101, read_model=fmb.read_model_text, write_model=fmb.model_text)
    assert_same(found, whole)
    assert path.stat().st_size < 1_000_000  # what was reserved while it ran is given back
    assert_same(fmb.Solution.load(path, read_model=fmb.read_model_text), whole)


KILLED = """
import os, signal
from flexmb.cli import main
from flexmb.results import RunFile
from flexmb.cli.progress import ProgressBar

def kill(bar, task, fraction):
    if fraction > 0.2:
        os.kill(os.getpid(), signal.SIGKILL)

ProgressBar.__call__ = kill
main(["run", "swing.toml", "--out", "killed"])
"""


def test_killed_run_folder(tmp_path, monkeypatch):
    """kill -9 in mid-run: `flexmb resume` completes the run folder; the result is that of a run in one go."""
    monkeypatch.chdir(tmp_path)
    settings = fmb.Simulation(t_end=0.8, samples=8001, integrator=fmb.GeneralizedAlpha(step=1e-5))
    fmb.save_model(pendulum(), tmp_path / "swing.toml", settings)
    child = subprocess.run([sys.executable, "-c", KILLED], capture_output=True, text=True, check=False)
    assert child.returncode == -signal.SIGKILL, child.stderr
    found = fmb.Solution.load(tmp_path / "killed" / "solution.h5")
    assert found.status.kind == "interrupted"
    assert 256 <= len(found.t) < 8001
    assert main(["resume", "killed"]) == 0
    assert main(["run", "swing.toml", "--out", "whole"]) == 0
    resumed, expected = (fmb.Solution.load(tmp_path / name / "solution.h5") for name in ("killed", "whole"))
    assert resumed.status.kind == "finished"
    assert len(resumed.phases) == 1
    np.testing.assert_allclose(resumed.t, expected.t, rtol=0, atol=1e-12)
    np.testing.assert_allclose(resumed["tip"], expected["tip"], rtol=0, atol=1e-6)
    assert (tmp_path / "killed" / "sensors.csv").read_text().count("\n") == 8002


def test_messages(whole):
    with pytest.raises(fmb.ModelError, match=r"has reached t = 2 s already.*Give a later t_end"):
        fmb.resume(whole, 2.0)
    stopped = fmb.Solution(phases=whole.phases, status=fmb.Status.stopped("hit", 2.0))
    with pytest.raises(fmb.ModelError, match=r"event 'hit'.*simulate again"):
        fmb.resume(stopped, 3.0)
    nameless = fmb.Solution(phases=[replace(whole.phases[0], model=None)])
    with pytest.raises(fmb.ModelError, match=r"model of the run is not known.*read_model"):
        fmb.resume(nameless, 3.0)


LIMITED = """
import resource, sys
import flexmb as fmb
sys.path.insert(0, {tests!r})
from integrate.test_resume import pendulum
resource.setrlimit(resource.RLIMIT_FSIZE, (3_000_000, 3_000_000))
try:
    fmb.simulate(pendulum(), 20.0, samples=200_001, output="full.h5", write_model=fmb.model_text,
                 integrator=fmb.GeneralizedAlpha(step=1e-4))
except fmb.DataFileError as error:
    print(error)
"""


def test_full_disk(tmp_path):
    """A file that may not grow stands for a full disk: a message says what to do, what was written stays readable."""
    code = LIMITED.format(tests=str(os.path.dirname(os.path.dirname(__file__))))
    child = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=tmp_path, check=False)
    assert "cannot write it" in child.stdout, child.stderr
    assert "Free space" in child.stdout
    kept = fmb.Solution.load(tmp_path / "full.h5", read_model=fmb.read_model_text)
    assert kept.status.kind == "interrupted"
    assert len(kept.t) > 1000


def test_read_only_folder(tmp_path, monkeypatch):
    import h5py

    def refuse(*arguments, **options):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(h5py, "File", refuse)
    with pytest.raises(fmb.DataFileError, match=r"cannot create it .*Permission denied.*choose another folder"):
        simulate(pendulum(), 0.1, output=tmp_path / "run.h5")


def cut(run, path, number):
    """Write the file of a finished run as it stands when a kill comes after so many of its last records."""
    file = RunFile(path)
    file.begin(fmb.model_text(run.model))
    phase = run.phases[0]
    file.append(phase.t, phase.q, phase.u, phase.a, phase.lam, phase.works)
    file.flush()
    if number > 0:
        file.end(phase.ended)
    file.close()


@pytest.mark.parametrize("number", [0, 1])
def test_a_run_cut_off_after_its_last_sample_is_completed(whole, tmp_path, number):
    """Before or after the end of its phase was noted: nothing is computed, and it is finished."""
    path = tmp_path / "run.h5"
    cut(whole, path, number)
    assert fmb.Solution.load(path).status.kind == "interrupted"
    found = resume(path, 2.0, samples=101, read_model=fmb.read_model_text, write_model=fmb.model_text)
    assert found.status.kind == fmb.Solution.load(path).status.kind == "finished"
    assert np.array_equal(found.t, whole.t)
    for name in whole.sensor_names:
        np.testing.assert_allclose(fmb.Solution.load(path)[name], whole[name], rtol=0, atol=1e-12)


def test_a_run_cut_off_after_the_event_that_stops_it_is_completed(tmp_path):
    event = fmb.Event("far", sensor="angle", below=-0.5, then=[fmb.Stop()])
    stopped = simulate(pendulum(events=[event]), 2.0, samples=101)
    assert stopped.status.kind == "stopped"
    path = tmp_path / "run.h5"
    cut(stopped, path, 1)
    found = resume(path, 2.0, samples=101, read_model=fmb.read_model_text)
    for one in (found, fmb.Solution.load(path)):
        assert one.status == stopped.status
        assert np.array_equal(one.t, stopped.t)


def test_killed_before_the_table_was_written(tmp_path, monkeypatch):
    """`flexmb resume` writes the sensor table of a run that has its solution; with its table, it is complete."""
    monkeypatch.chdir(tmp_path)
    fmb.save_model(pendulum(), tmp_path / "swing.toml", fmb.Simulation(t_end=0.1, samples=11))
    assert main(["run", "swing.toml", "--out", "run"]) == 0
    table = (tmp_path / "run" / "sensors.csv").read_text()
    (tmp_path / "run" / "sensors.csv").unlink()
    assert main(["resume", "run"]) == 0
    assert (tmp_path / "run" / "sensors.csv").read_text() == table
    assert main(["resume", "run"]) == 2


def test_a_run_that_lost_samples_from_its_middle_is_computed_again_from_there(whole, tmp_path):
    """Without a word the run would go on behind its last sample, with a hole of ten samples."""
    path, phase = tmp_path / "run.h5", whole.phases[0]
    file = RunFile(path, rows=10)
    file.begin(fmb.model_text(whole.model))
    places = []
    for k in range(0, 60, 10):
        places.append(path.stat().st_size)
        file.append(*(getattr(phase, name)[k : k + 10] for name in ("t", "q", "u", "a", "lam", "works")))
    file._journal.close()  # a kill
    file._lock.release()
    content = path.read_bytes()
    path.write_bytes(content[: places[3]] + content[places[4] :])
    with pytest.warns(UserWarning, match=r"behind t = 0\.58 s, and 20 samples that follow there are left out"):
        found = resume(path, 2.0, samples=101, read_model=fmb.read_model_text, write_model=fmb.model_text)
    assert_same(found, whole)
    assert_same(fmb.Solution.load(path, read_model=fmb.read_model_text), whole)


@pytest.mark.parametrize("order", [0, 1], ids=["then unknown", "unknown first"])
def test_errors_that_one_part_does_not_know_are_not_known(order):
    """IDA does not tell what its errors add up to."""
    integrators = [fmb.GeneralizedAlpha(), fmb.IDA()]
    first, second = integrators[:: -1 if order else 1]
    part = fmb.simulate(pendulum(), 0.1, samples=3, integrator=first)
    whole = fmb.resume(part, 0.2, samples=5, integrator=second)
    assert whole.statistics["errors added up"] == "not estimated"
    assert whole.statistics["steps"] > part.statistics["steps"]
