"""A run that is given a limit of clock time ends there with what it has reached, and can be continued."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest

import flexmb as fmb
from flexmb.cli import main
from flexmb.integrate.runs import interruption, phases

INTEGRATORS = {
    "GeneralizedAlpha": fmb.GeneralizedAlpha(step=1e-4),
    "IDA": fmb.IDA(),
    "Explicit": fmb.Explicit(),
    "Implicit": fmb.Implicit(),
}


def stone(**more) -> fmb.Model:
    """A stone on a spring: x = cos(10 t) / 10."""
    return fmb.Model(
        name="stone",
        bodies=[fmb.Ground(), fmb.PointMass("stone", mass=1.0, at=(1.1, 0, 0))],
        forces=[fmb.SpringDamper("spring", markers=("ground.origin", "stone.center"), stiffness=100.0, length=1.0)],
        sensors=[fmb.Position("place", marker="stone.center")],
        **more,
    )


class Clock:
    """A clock of which every look takes a second: a limit of 3.5 s is over at the fifth."""

    def __init__(self):
        self.t = 0.0

    def monotonic(self) -> float:
        self.t += 1.0
        return self.t


@pytest.fixture
def slow_clock(monkeypatch):
    monkeypatch.setattr(interruption, "time", Clock())
    monkeypatch.setattr(phases, "CHUNK", 1e-6)  # a look after every sample


@pytest.mark.parametrize("name", INTEGRATORS)
def test_it_ends_there_and_goes_on(name, slow_clock):
    run = partial(fmb.simulate, stone(), 1.0, integrator=INTEGRATORS[name], samples=41)
    whole = run()
    part = run(time_limit=3.5)
    assert part.status.kind == "limited"
    assert "limit of 3.5 s" in str(part.status)
    assert not part.status.ok
    assert 2 <= len(part.t) < 41
    np.testing.assert_array_equal(part["place"], whole["place"][: len(part.t)])
    rest = fmb.resume(part, 1.0, integrator=INTEGRATORS[name], samples=41)
    assert rest.status.kind == "finished"
    np.testing.assert_allclose(rest["place"], whole["place"], rtol=0, atol=1e-5)


def test_a_run_without_samples_between_keeps_its_state(tmp_path):
    """Two samples a million seconds apart: the state that was reached is the last row, and is gone on from."""
    path = tmp_path / "run.h5"
    model = stone()
    part = fmb.simulate(
        model, 1e6, integrator=fmb.GeneralizedAlpha(step=1e-3), samples=2, output=path, write_model=fmb.model_text,
        time_limit=0.3,
    )  # fmt: skip
    assert part.status.kind == "limited"
    assert len(part.t) == 2
    assert 0.0 < part.t[-1] < 1e6
    stored = fmb.Solution.load(path, read_model=fmb.read_model_text)
    assert stored.status.kind == "limited"
    rest = fmb.resume(path, 1e6, integrator=fmb.GeneralizedAlpha(step=1e-3), samples=2,
                      read_model=fmb.read_model_text, time_limit=0.3)  # fmt: skip
    assert rest.status.kind == "limited"
    assert rest.t[-1] > part.t[-1]


def test_enough_time_changes_nothing():
    runs = [fmb.simulate(stone(), 0.5, time_limit=limit) for limit in (None, 1000.0)]
    assert runs[1].status.kind == "finished"
    np.testing.assert_array_equal(runs[0]["place"], runs[1]["place"])


def test_what_is_complete_when_the_time_is_over_is_not_cut_off(slow_clock):
    """The last look at the clock comes after the last sample."""
    run = partial(fmb.simulate, stone(), 1.0, integrator=INTEGRATORS["GeneralizedAlpha"], samples=11)
    clock = interruption.time
    before = clock.t
    run()
    looks = clock.t - before
    assert run(time_limit=looks - 1.0).status.kind == "limited"
    whole = run(time_limit=looks)
    assert whole.status.kind == "finished"
    assert len(whole.t) == 11


@pytest.mark.parametrize("limit", [0.0, -1.0, np.nan, "5", True])
def test_what_is_no_limit_is_refused(limit):
    for ask in (
        lambda: fmb.simulate(stone(), 1.0, time_limit=limit),
        lambda: fmb.Simulation(t_end=1.0, time_limit=limit),
        lambda: fmb.sweep(stone, {"gravity": [0.0]}, t_end=1.0, time_limit=limit),
    ):
        with pytest.raises(fmb.ModelError, match="time_limit"):
            ask()


def test_the_command_line_has_it(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    settings = fmb.Simulation(t_end=1e6, samples=3, integrator=fmb.GeneralizedAlpha(step=1e-3))
    fmb.save_model(stone(), tmp_path / "stone.toml", settings)
    assert main(["run", "stone.toml", "--out", "run", "--time-limit", "0.3"]) == 124
    assert "limited: the limit of 0.3 s" in capsys.readouterr().out
    assert (tmp_path / "run" / "sensors.csv").is_file()
    first = fmb.Solution.load(tmp_path / "run" / "solution.h5").t[-1]
    assert main(["resume", "run", "--time-limit", "0.3"]) == 124
    assert fmb.Solution.load(tmp_path / "run" / "solution.h5").t[-1] > first
    fmb.save_model(stone(), tmp_path / "stone.toml", replace(settings, time_limit=0.25))
    assert fmb.load_simulation(tmp_path / "stone.toml").time_limit == 0.25
    assert main(["run", "stone.toml", "--out", "other"]) == 124


def long_or_short(far: float) -> fmb.Solution | fmb.Model:
    """Return a model whose run takes long if its spring is stiff."""
    return replace(stone(), forces=(replace(stone().forces[0], stiffness=far),))


@pytest.mark.parametrize("engine", [pytest.param("processes", marks=pytest.mark.slow), "compiled"])
def test_a_variant_that_takes_too_long_is_a_row_with_this_error(tmp_path, engine):
    more = {"folder": tmp_path / "study"} if engine == "processes" else {}
    table = fmb.sweep(
        long_or_short, {"far": [1.0, 1e18]}, t_end=5.0, samples=3, time_limit=1.0, jobs=1, engine=engine, **more
    )
    rows = sorted(table.rows, key=lambda row: row.number)
    assert [row.status for row in rows] == ["done", "failed"]
    assert "limit of 1 s" in rows[1].error
