"""`Solution`: samples, phases, states in between; its file."""

from dataclasses import replace

import numpy as np
import pytest
from results.spinning import angle_at, observe, spinning_model, spinning_phase, split
from tolerances import MACHINE

from flexmb import sensors
from flexmb.errors import DataFileError, FlexmbError
from flexmb.results import Phase, RunFile, Solution, Status

SENSORS = (
    sensors.Position("tip", marker="rod.end"),
    sensors.JointCoordinate("angle", joint="hinge"),
    sensors.Reaction("weld force", joint="weld"),
    sensors.Energy("E", kind="total"),
)


@pytest.fixture(autouse=True)
def _closed_form(monkeypatch):
    monkeypatch.setattr("flexmb.system.observe", observe, raising=False)


def make(phases=None, **fields):
    return Solution(phases=(spinning_phase(spinning_model(SENSORS)),) if phases is None else phases, **fields)


def test_sensors_are_evaluated_once():
    solution = make()
    assert solution.sensor_names == ("tip", "angle", "weld force", "E")
    assert solution["tip"] is solution["tip"]
    assert solution["tip"].shape == (11, 3)


def test_unknown_sensor_is_named():
    with pytest.raises(FlexmbError, match=r"sensor 'tipp' does not exist.*One of: tip, angle.*Did you mean 'tip'\?"):
        make()["tipp"]


def test_a_number_is_no_sensor():
    with pytest.raises(FlexmbError, match=r"-1 asked for\. Expected: the name of a sensor.*`final` is the last sample"):
        make()[-1]


def test_a_foreign_sensor_is_checked():
    with pytest.raises(FlexmbError, match=r"marker 'rod.tip' does not exist"):
        make()[sensors.Position("x", marker="rod.tip")]


def test_phases_join():
    """The angle goes on counting, a joint that is gone carries no load, an unknown quantity is not a number."""
    phase = spinning_phase(spinning_model(SENSORS))
    later = spinning_model((SENSORS[0], SENSORS[1]), name="without weld").without("weld")
    first, second = split(phase, 6, model=later, system=None)
    from results.spinning import spinning_system

    object.__setattr__(second, "system", spinning_system(later))
    solution = Solution(phases=(first, second))
    t = solution.t
    assert len(t) == 12
    assert t[6] == t[7]
    np.testing.assert_allclose(solution["angle"], angle_at(t)[0], rtol=MACHINE, atol=MACHINE)
    assert np.all(solution["weld force"][:7, 1:] > 0)
    assert np.all(solution["weld force"][7:] == 0.0)
    assert np.isnan(solution["E"][7:]).all()


def test_state_at_a_sample_and_between():
    """Between samples h apart a rotation with constant acceleration is met to fourth order."""
    t = np.linspace(0.0, 0.01, 3)
    solution = make((spinning_phase(t=t),))
    exact = solution.state(0.005)
    np.testing.assert_array_equal(exact.q, solution.phases[0].q[1])
    errors = []
    for h in (0.004, 0.002):
        middle = Solution(phases=(spinning_phase(t=[0.1, 0.1 + h]),)).state(0.1 + h / 2)
        true = spinning_phase(t=[0.1 + h / 2]).instant(0)
        errors.append(np.abs(middle.q - true.q).max())
        np.testing.assert_allclose(middle.u, true.u, rtol=1e-12)
        assert abs(np.linalg.norm(middle.q[3:7]) - 1) < MACHINE
    assert errors[0] < 1e-5
    assert 12 < errors[0] / errors[1] < 20
    assert solution.final.t == 0.01


def test_state_outside_is_refused():
    with pytest.raises(FlexmbError, match=r"t = 1.5 s is outside.*0 to 1 s"):
        make().state(1.5)


def test_state_at_an_event_is_the_one_after():
    first, second = split(spinning_phase(), 5)
    assert Solution(phases=(first, second)).state(first.t[-1]).model is second.model


def test_shapes_are_checked():
    with pytest.raises(FlexmbError, match=r"u has the shape \(2, 4\).*\(3, ...\)"):
        Phase(
            model=None,
            t=np.zeros(3),
            q=np.zeros((3, 2)),
            u=np.zeros((2, 4)),
            a=np.zeros((3, 4)),
            lam=np.zeros((3, 0)),
            works=np.zeros((3, 3)),
        )
    with pytest.raises(FlexmbError, match=r"without samples"):
        Solution(phases=())


def test_status_says_what_to_do():
    assert Status.finished(1.0).ok
    assert Status.stopped("contact", 0.5).ok
    failed = Status.failed("the step fell below 1e-12 s", "Smooth the load")
    assert not failed.ok
    assert str(failed) == "failed: the step fell below 1e-12 s. Smooth the load."
    assert Status.from_text(failed.to_text()) == failed
    assert not Status.interrupted(0.2).ok


def test_saved_and_loaded(tmp_path):
    """Samples and sensor tables without the model; everything with it."""
    solution = make(status=Status.stopped("end", 1.0), statistics={"steps": np.int64(12), "seconds": 0.5})
    path = solution.save(tmp_path / "run.h5", write_model=lambda model: f"name = '{model.name}'")
    bare = Solution.load(path)
    assert bare.model is None
    assert bare.status == solution.status
    assert bare.statistics == {"steps": 12, "seconds": 0.5}
    assert bare.sensor_names == solution.sensor_names
    assert bare.column_titles("tip") == ("x [m]", "y [m]", "z [m]")
    for name in solution.sensor_names:
        np.testing.assert_array_equal(bare[name], solution[name])
    for name in ("t", "q", "u", "a", "lam", "works"):
        np.testing.assert_array_equal(getattr(bare.phases[0], name), getattr(solution.phases[0], name))
    with pytest.raises(FlexmbError, match=r"the model is not known.*read_model"):
        bare.series(0).energy  # noqa: B018


def test_what_was_saved_before_is_there_until_the_new_file_is_complete(tmp_path, monkeypatch):
    """A program that saves again and again what it has reached, and is ended while it does."""
    path, solution = tmp_path / "run.h5", make(status=Status.stopped("end", 1.0))
    solution.save(path)
    before = path.read_bytes()
    monkeypatch.setattr(RunFile, "append", lambda *_: (_ for _ in ()).throw(KeyboardInterrupt))
    with pytest.raises(KeyboardInterrupt):
        solution.save(path)
    assert path.read_bytes() == before
    assert [p.name for p in tmp_path.iterdir()] == ["run.h5"]


def test_a_state_that_is_no_sample_stays_one_that_is_none(tmp_path):
    """The last row of a run that was cut off between two samples: a resumed run forgets it."""
    solution = make()
    cut = replace(solution, phases=(replace(solution.phases[0], cut_off=True),))
    loaded = Solution.load(cut.save(tmp_path / "run.h5"))
    assert loaded.phases[0].cut_off
    for name in ("t", "q", "u", "a", "lam", "works"):
        np.testing.assert_array_equal(getattr(loaded.phases[0], name), getattr(solution.phases[0], name))
    for name in solution.sensor_names:
        np.testing.assert_array_equal(loaded[name], solution[name])


def test_the_model_comes_back_through_a_reader(tmp_path):
    solution = make()
    solution.save(tmp_path / "run.h5", write_model=lambda model: model.name)
    asked = []

    def read_model(text, bodies):
        asked.append((text, bodies["block"].shapes.shape))
        return solution.model

    loaded = Solution.load(tmp_path / "run.h5", read_model=read_model)
    assert asked == [("spinning", (9, 3, 2))]
    assert loaded.model is solution.model
    assert Solution.load(tmp_path / "run.h5", model=solution.model).model is solution.model


def test_a_file_of_two_phases(tmp_path):
    first, second = split(spinning_phase(spinning_model(SENSORS)), 4)
    solution = Solution(phases=(first, second))
    loaded = Solution.load(solution.save(tmp_path / "run.h5"))
    assert [len(phase.t) for phase in loaded.phases] == [5, 7]
    assert [phase.ended for phase in loaded.phases] == ["break", "finished"]
    np.testing.assert_array_equal(loaded["angle"], solution["angle"])


def test_files_that_are_none(tmp_path):
    path = make().save(tmp_path / "run.h5")
    content = path.read_bytes()
    (tmp_path / "cut.h5").write_bytes(content[: len(content) // 2])
    with pytest.raises(DataFileError, match=r"truncated or damaged"):
        Solution.load(tmp_path / "cut.h5")
    (tmp_path / "text.h5").write_text("t, q")
    with pytest.raises(DataFileError, match=r"not an HDF5 file.*flexmb.solution"):
        Solution.load(tmp_path / "text.h5")
    spinning_model().body("block").data.save(tmp_path / "block.h5")
    with pytest.raises(DataFileError, match=r"schema 'flexmb.modal_neutral_data'.*'flexmb.solution'"):
        Solution.load(tmp_path / "block.h5")
    with pytest.raises(DataFileError, match=r"does not exist"):
        Solution.load(tmp_path / "no.h5")


def test_sensors_keep_the_order_of_the_model(tmp_path):
    """Also when they are read from a file, which knows no order."""
    names = ["z last", "a first", "m middle"]
    asked = [sensors.Position(name, marker="rod.end") for name in names]
    solution = Solution(phases=(spinning_phase(spinning_model(asked)),))
    stored = Solution.load(solution.save(tmp_path / "s.h5"), model=solution.model)
    assert stored.sensor_names == solution.sensor_names == tuple(names)
