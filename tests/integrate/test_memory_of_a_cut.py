"""Ctrl-C keeps what the integrator knows: the run goes on with the same steps, also where a contact has just begun.

Begun anew at the same state, the generalized-alpha method has other algorithmic accelerations: behind the first touch
of a compliant contact the motion was off by 1.5e-5 m.
"""

import os
import signal
from dataclasses import replace

import numpy as np
import pytest
from by_turns import slow
from faults.bench import SCENES
from integrate.test_coarse_contacts import falling

import flexmb as fmb
from flexmb.integrate.runs import phases
from flexmb.integrate.runs.coarse_contacts import ENDED, FEWEST
from flexmb.results import RunFile
from flexmb.results.memory import Memory

MAKE, GIVEN, _ = SCENES["press"]
SETTINGS = {**GIVEN.keywords(), "integrator": GIVEN.integrator, "t_end": 0.18, "samples": 181}
TOUCH = 0.1735
"""s: the box reaches the floor."""


@pytest.fixture
def careful(monkeypatch):
    """The run looks up after every mark, and at every step between them."""
    monkeypatch.setattr(phases, "CHUNK", 0.0)
    monkeypatch.setattr(phases, "PATIENCE", 0.0)


def interrupted(model, t: float, **settings) -> fmb.Solution:
    """Run and press Ctrl-C once, when the integrator comes back at the time t or later."""
    waiting = [t]

    def progress(now, end):
        if waiting and now >= waiting[0]:
            waiting.clear()
            os.kill(os.getpid(), signal.SIGINT)

    return fmb.simulate(model, **settings, progress=progress)


@pytest.fixture(scope="module")
def whole():
    return fmb.simulate(MAKE(), **SETTINGS)


@pytest.mark.parametrize("t", [TOUCH - 1e-3, slow(TOUCH + 1e-4), TOUCH + 1.3e-3, slow(TOUCH + 2.1e-3)])
def test_goes_on_with_the_same_steps(t, whole, careful):
    cut = interrupted(MAKE(), t, **SETTINGS)
    assert cut.status.kind == "interrupted"
    assert t <= cut.final.t + 1e-3
    rest = fmb.resume(cut, **SETTINGS)
    np.testing.assert_array_equal(rest.t, whole.t)
    for name in ("box", "ball", "place"):
        np.testing.assert_allclose(rest[name], whole[name], rtol=0, atol=1e-12)
    # what the integrator had counted is not added to what the samples say: the work lost was 1.2 J for 0.62 J
    np.testing.assert_allclose(rest.phases[-1].works, whole.phases[-1].works, rtol=0, atol=1e-3)


@pytest.mark.parametrize("t", [0.1, 0.3, 0.5])
def test_contacts_that_have_ended_are_counted_once(t, careful):
    """They were counted again from what the integrator knows: 5 to 7 contacts of four."""
    model = replace(falling(1e5, 1.0, 0.05), gravity=(0, 0, -9.81))
    settings = {"t_end": 1.0, "samples": 51, "integrator": fmb.GeneralizedAlpha()}
    whole, cut = fmb.simulate(model, **settings), interrupted(model, t, **settings)
    assert cut.phases[-1].memory is not None
    rest = fmb.resume(cut, **settings)
    for name in (ENDED, FEWEST):
        assert rest.statistics[name] == whole.statistics[name]
    assert whole.statistics[ENDED] >= 4


def test_without_what_was_known_the_steps_are_others(whole, careful):
    """The same cut from the state alone: what the memory is there for."""
    cut = interrupted(MAKE(), TOUCH + 2.1e-3, **SETTINGS)
    forgetful = replace(cut, phases=(*cut.phases[:-1], replace(cut.phases[-1], memory=None)))
    rest = fmb.resume(forgetful, **SETTINGS)
    assert 1e-9 < np.abs(rest["box"] - whole["box"]).max() < 1e-4


@pytest.mark.parametrize("way", ["journal", "save"])
def test_it_is_kept_in_the_file(way, whole, careful, tmp_path, monkeypatch):
    """Behind the HDF5 part of a run that is being written, folded into it, and saved from memory."""
    path = tmp_path / "run.h5"
    text = {"write_model": fmb.model_text} if way == "journal" else {}
    cut = interrupted(MAKE(), TOUCH - 1e-3, **SETTINGS, **({"output": path, **text} if text else {}))
    monkeypatch.undo()
    if not text:
        cut.save(path, write_model=fmb.model_text)
    read = fmb.Solution.load(path, read_model=fmb.read_model_text).phases[-1].memory
    assert read.of == repr(SETTINGS["integrator"])
    np.testing.assert_array_equal(read.numbers, cut.phases[-1].memory.numbers)
    rest = fmb.resume(path, **SETTINGS, read_model=fmb.read_model_text, write_model=fmb.model_text)
    np.testing.assert_allclose(rest["box"], whole["box"], rtol=0, atol=1e-12)
    assert fmb.Solution.load(path, read_model=fmb.read_model_text).phases[-1].memory is None


@pytest.mark.parametrize("spoilt", ["of another", "too short", "no numbers"])
def test_a_memory_that_does_not_fit_is_left(spoilt, whole, careful, monkeypatch):
    cut = interrupted(MAKE(), TOUCH - 0.1, **SETTINGS)
    monkeypatch.undo()
    memory = cut.phases[-1].memory
    other = {
        "of another": replace(memory, of="IDA()"),
        "too short": replace(memory, numbers=memory.numbers[1:]),
        "no numbers": replace(memory, numbers=np.full_like(memory.numbers, np.nan)),
    }[spoilt]
    rest = fmb.resume(replace(cut, phases=(replace(cut.phases[-1], memory=other),)), **SETTINGS)
    np.testing.assert_allclose(rest["box"], whole["box"], rtol=0, atol=1e-4)


def test_samples_make_it_void(tmp_path):
    """What was known at an earlier place is nothing that a later one could go on with."""
    path = tmp_path / "run.h5"
    row = (np.zeros(7), np.zeros(6), np.zeros(6), np.zeros(0), np.zeros(3))
    memory = Memory(of="a", numbers=np.arange(3.0))
    with RunFile(path) as run:
        run.begin()
        run.append(0.0, *row)
        run.remember(memory)
        assert fmb.Solution.load(path).phases[0].memory is not None
        run.append(0.1, *row)
        run.flush()
    assert fmb.Solution.load(path).phases[0].memory is None
