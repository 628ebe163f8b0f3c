"""Ctrl-C during a simulation: at once while nothing is recorded, between two blocks afterwards."""

import os
import signal
import threading

import numpy as np
import pytest

import flexmb as fmb
from flexmb.integrate.interruption import Interruption


@pytest.fixture
def kills_interrupt():
    """Make a polite kill raise KeyboardInterrupt, as the command line does."""

    def interrupt(number, frame):
        raise KeyboardInterrupt

    interrupt.interrupts = True
    before = signal.signal(signal.SIGTERM, interrupt)
    yield
    signal.signal(signal.SIGTERM, before)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_it_waits_for_the_next_look(number, kills_interrupt):
    with Interruption() as interruption:
        interruption.look()
        os.kill(os.getpid(), number)
        with pytest.raises(KeyboardInterrupt):
            interruption.look()


def test_before_the_first_look_it_is_immediate():
    with Interruption(), pytest.raises(KeyboardInterrupt):
        os.kill(os.getpid(), signal.SIGINT)


def test_the_second_time_is_immediate():
    with Interruption() as interruption:
        interruption.look()
        os.kill(os.getpid(), signal.SIGINT)
        with pytest.raises(KeyboardInterrupt):
            os.kill(os.getpid(), signal.SIGINT)


def test_handlers_are_put_back():
    before = [signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)]
    with Interruption():
        pass
    assert [signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)] == before


def test_another_thread_has_no_signals():
    done = []

    def work():
        with Interruption() as interruption:
            interruption.look()
        done.append(True)

    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    assert done == [True]


def test_handlers_of_the_caller_stay():
    noted = []
    before = signal.signal(signal.SIGINT, lambda number, frame: noted.append(number))
    try:
        with Interruption() as interruption:
            interruption.look()
            os.kill(os.getpid(), signal.SIGINT)
            interruption.look()
        assert noted == [signal.SIGINT]
    finally:
        signal.signal(signal.SIGINT, before)


PENDULUM = fmb.Model(
    gravity=(0, 0, -9.81),
    bodies=[fmb.Ground(), fmb.RigidBody.rod("rod", length=1.0, mass=1.0, radius=0.05)],
    joints=[fmb.Revolute("pin", markers=("ground.origin", "rod.start"))],
    sensors=[fmb.Position("end", marker="rod.end")],
)


def test_a_simulation_keeps_its_samples(tmp_path):
    """Ctrl-C at 0.3 s: all samples until then, in memory and in the file, and none torn."""
    sent = []

    def interrupt(t, t_end):
        if t >= 0.3 and not sent:
            sent.append(t)
            os.kill(os.getpid(), signal.SIGINT)

    solution = fmb.simulate(PENDULUM, 1e3, samples=1_000_001, output=tmp_path / "run.h5", progress=interrupt)
    assert solution.status.kind == "interrupted"
    assert solution.t[-1] >= sent[0]
    assert len(solution["end"]) == len(solution.t) < 1_000_001
    stored = fmb.Solution.load(tmp_path / "run.h5", model=PENDULUM)
    assert stored.status.kind == "interrupted"
    assert np.array_equal(stored.t, solution.t)
    assert np.array_equal(stored["end"], solution["end"])
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_before_the_first_sample_nothing_stays_open(tmp_path, monkeypatch):
    def interrupted(*arguments):
        raise KeyboardInterrupt

    monkeypatch.setattr(fmb.GeneralizedAlpha, "start", interrupted)
    with pytest.raises(KeyboardInterrupt):
        fmb.simulate(PENDULUM, 1.0, output=tmp_path / "run.h5")
    monkeypatch.undo()
    assert fmb.simulate(PENDULUM, 0.1, output=tmp_path / "run.h5").status.ok
