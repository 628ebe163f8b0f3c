"""Ctrl-C during a simulation: at once while nothing is recorded, between two blocks afterwards."""

import os
import signal
import sys
import threading
from dataclasses import replace

import numpy as np
import pytest
import scipy.integrate

import flexmb as fmb
from flexmb.integrate.runs import interruption as interruptions
from flexmb.integrate.runs import phases, watch
from flexmb.integrate.runs.interruption import Interruption, look_within_step
from flexmb.integrate.runs.patience import Patience


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


def test_a_step_gets_a_moment_to_end_by_itself(monkeypatch):
    clock = [100.0]
    monkeypatch.setattr(interruptions.time, "monotonic", lambda: clock[0])
    with Interruption() as interruption:
        interruption.look()
        look_within_step()
        os.kill(os.getpid(), signal.SIGINT)
        clock[0] += 0.9 * interruptions.GRACE
        look_within_step()
        clock[0] += 0.2 * interruptions.GRACE
        with pytest.raises(KeyboardInterrupt):
            look_within_step()
    look_within_step()


@pytest.mark.parametrize("method", ["RK45", "Radau"])
def test_a_step_that_does_not_end_is_cut_off(method, monkeypatch):
    """Ctrl-C within a step of SciPy that never returns: it tries on and on. What was kept before stays."""
    begun = []

    def endless(solver):
        if solver.t > 0.2:
            begun.append(solver.t)
            os.kill(os.getpid(), signal.SIGINT)
            for _ in range(10_000_000):
                solver.fun(solver.t, solver.y)
        return step(solver)

    solver = getattr(scipy.integrate, method)
    step = solver.step
    monkeypatch.setattr(interruptions, "GRACE", 0.05)
    monkeypatch.setattr(solver, "step", endless)
    run = fmb.simulate(PENDULUM, 1.0, samples=1001, integrator=fmb.Explicit(method=method))
    assert run.status.kind == "interrupted"
    assert 0.0 < run.t[-1] <= begun[0]
    assert len(begun) == 1


def struck_while_called() -> None:
    """What Python makes of Ctrl-C in the first call of a compiled function."""
    try:
        raise KeyboardInterrupt
    except KeyboardInterrupt as struck:
        raise SystemError("<built-in method> returned a result with an exception set") from struck


@pytest.mark.parametrize("where", ["assemble_as_drawn", "Phases"])
@pytest.mark.parametrize("lost", [True, False])
def test_ctrl_c_in_the_first_call_of_a_compiled_function(where, lost, monkeypatch):
    """Before the first sample there is nothing to keep; any other SystemError stays one."""

    def called(*arguments, **more):
        if lost:
            struck_while_called()
        raise SystemError("another")

    simulate = sys.modules["flexmb.integrate.runs.simulate"]
    place = (simulate, where) if where != "Phases" else (phases.Phases, "_phase")
    monkeypatch.setattr(*place, called)
    with pytest.raises(KeyboardInterrupt if lost else SystemError):
        fmb.simulate(PENDULUM, 0.1)


def test_ctrl_c_lost_behind_samples_keeps_them(monkeypatch):
    """As a kernel that is called for the first time late in a run: the samples before are there."""
    monkeypatch.setattr(phases, "CHUNK", 0.0)
    run, calls = fmb.GeneralizedAlpha.run, []

    def called(*arguments, **more):
        calls.append(None)
        if len(calls) == 5:
            struck_while_called()
        return run(*arguments, **more)

    monkeypatch.setattr(fmb.GeneralizedAlpha, "run", called)
    cut = fmb.simulate(PENDULUM, 0.1, samples=101, integrator=fmb.GeneralizedAlpha(step=1e-3))
    assert cut.status.kind == "interrupted"
    assert len(cut.t) == 4


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


SWINGING = replace(PENDULUM, gravity=(0, -9.81, 0))
HEIGHT = fmb.JointCoordinate("height", joint="pin")
INTEGRATORS = [
    fmb.GeneralizedAlpha(),
    fmb.GeneralizedAlpha(step=1e-3),
    fmb.IDA(),
    fmb.Explicit(),
    fmb.Explicit(method="RK45"),
    fmb.Explicit(formulation=fmb.Recursive()),
    fmb.Implicit(),
]


@pytest.mark.parametrize("integrator", INTEGRATORS, ids=repr)
def test_far_from_the_next_sample_a_run_can_be_stopped_and_goes_on(integrator, tmp_path, monkeypatch):
    """Two samples a week apart: Ctrl-C is looked for in between, what was reached is kept, and `resume` begins there
    without a sample at that time. It is stopped after a few swings: errors grow with time, however fast the machine."""
    monkeypatch.setattr(phases, "PATIENCE", 0.002)
    path, week = tmp_path / "run.h5", 604_800.0
    times = []

    def interrupt(t, t_end):
        times.append(t)
        if t > 0.2:
            os.kill(os.getpid(), signal.SIGINT)

    options = {"integrator": integrator, "write_model": fmb.model_text, "progress": interrupt}
    solution = fmb.simulate(SWINGING, week, samples=2, output=path, **options)
    assert solution.status.kind == "interrupted"
    assert list(solution.t) == [0.0, times[-1]]
    assert 0.2 < times[-1] < week
    stored = fmb.Solution.load(path, read_model=fmb.read_model_text)
    assert np.array_equal(stored.t, solution.t)
    assert np.array_equal(stored["end"], solution["end"])
    goal = times[-1] + 0.1
    reference = fmb.simulate(SWINGING, goal, samples=[0.0, goal], integrator=fmb.Explicit(rtol=1e-11, atol=1e-12))
    for found in (
        fmb.resume(solution, goal, samples=[0.0, goal], integrator=fmb.Explicit()),
        fmb.resume(path, goal, samples=[0.0, goal], integrator=fmb.Explicit(), read_model=fmb.read_model_text),
        fmb.Solution.load(path),
    ):
        assert list(found.t) == [0.0, goal]
        assert found.status.kind == "finished"
        np.testing.assert_allclose(found["end"][-1], reference["end"][-1], rtol=0, atol=2e-3)


@pytest.mark.parametrize("integrator", INTEGRATORS, ids=repr)
def test_to_be_looked_after_changes_nothing(integrator, monkeypatch):
    """Called back as often as can be, its state kept each time, a run gives the same numbers to the last bit."""
    alone = fmb.simulate(SWINGING, 1.0, samples=3, integrator=integrator).phases[0]
    monkeypatch.setattr(phases, "PATIENCE", 0.0)
    monkeypatch.setattr(phases, "HOLD", -1.0)
    watched = fmb.simulate(SWINGING, 1.0, samples=3, integrator=integrator).phases[0]
    for name in ("t", "q", "u", "a", "lam", "works"):
        assert np.array_equal(getattr(alone, name), getattr(watched, name)), name


def test_the_state_is_kept_by_time(tmp_path, monkeypatch):
    """A run that is killed before its second sample goes on from the last state that was kept."""
    monkeypatch.setattr(phases, "PATIENCE", 0.0)
    monkeypatch.setattr(phases, "HOLD", 0.0)
    path, seen = tmp_path / "run.h5", []

    def look(t, t_end):
        if t > 1.0:
            seen.append(fmb.Solution.load(path))
            raise MemoryError  # the process has no time to write anything more

    with pytest.raises(MemoryError):
        fmb.simulate(SWINGING, 1e6, samples=2, output=path, write_model=fmb.model_text, progress=look)
    assert seen[0].status.kind == "running"
    assert seen[0].phases[0].cut_off
    assert 0.0 < seen[0].t[-1] <= 1.0


def test_where_events_are_waited_for_the_state_is_that_of_the_last_look(tmp_path, monkeypatch):
    """Beyond it an event may have happened that nobody has seen yet: it must not be skipped by going on from there."""
    monkeypatch.setattr(phases, "PATIENCE", 0.0)
    event = fmb.Event("passes", sensor="height", below=-0.5, then=[fmb.Stop()])
    model = replace(SWINGING, sensors=[fmb.Position("end", marker="rod.end"), HEIGHT], events=[event])
    whole = fmb.simulate(model, 1.0, samples=2)

    def interrupt(t, t_end):
        if t > 0.1:
            os.kill(os.getpid(), signal.SIGINT)

    part = fmb.simulate(model, 1.0, samples=2, progress=interrupt)
    assert part.status.kind == "interrupted"
    assert part.phases[0].cut_off
    found = fmb.resume(part, 1.0, samples=2)
    assert found.status.kind == "stopped"
    assert found.t[-1] == pytest.approx(whole.t[-1], abs=1e-4)


def test_kinematics_keeps_its_samples(monkeypatch):
    """Ctrl-C between two calls of the compiled loop: the samples until then, those of an undivided run bit by bit."""
    model = PENDULUM.with_parts(
        joints=[fmb.Drive("motor", joint="pin", angle=fmb.ramp(rate=30.0, rise=0.2))],
        sensors=[fmb.JointCoordinate("turn", joint="pin"), fmb.Energy("work", kind="total")],
    )
    with monkeypatch.context() as undivided:
        undivided.setattr(Patience, "steps", lambda pace: 2000)
        whole = fmb.kinematics(model, 2.0, samples=2000)
    look, looks = Interruption.look, []

    def pressed(interruption):
        looks.append(True)
        if len(looks) == 5:
            os.kill(os.getpid(), signal.SIGINT)
        look(interruption)

    monkeypatch.setattr(Patience, "steps", lambda pace: 100)
    monkeypatch.setattr(Interruption, "look", pressed)
    part = fmb.kinematics(model, 2.0, samples=2000)
    assert part.status.kind == "interrupted"
    assert len(part.t) == 500
    for name in ("turn", "work"):
        np.testing.assert_array_equal(part[name], whole[name][:500])
    for name in ("q", "u", "a", "lam", "works"):
        np.testing.assert_array_equal(getattr(part.phases[0], name), getattr(whole.phases[0], name)[:500])
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_a_run_can_be_stopped_while_an_event_is_located(monkeypatch):
    """Between two looks at a sensor there may be minutes of steps, taken dozens of times to find the place."""
    monkeypatch.setattr(watch, "PATIENCE", 0.0)
    event = fmb.Event("passes", sensor="height", below=-0.05, then=[fmb.Stop()])
    model = replace(SWINGING, sensors=[fmb.Position("end", marker="rod.end"), HEIGHT], events=[event])
    run = {"samples": 11, "integrator": fmb.GeneralizedAlpha(step=2e-5)}
    whole = fmb.simulate(model, 0.2, **run)
    assert whole.status.kind == "stopped"
    again = watch.Watch._again

    def interrupted(watched, before, t):
        os.kill(os.getpid(), signal.SIGINT)
        return again(watched, before, t)

    with monkeypatch.context() as patched:
        patched.setattr(watch.Watch, "_again", interrupted)
        part = fmb.simulate(model, 0.2, **run)
    assert part.status.kind == "interrupted"
    assert 0.0 < part.t[-1] < whole.t[-1]
    found = fmb.resume(part, 0.2, **run)
    assert found.status.kind == "stopped"
    np.testing.assert_allclose(found["end"][-1], whole["end"][-1], rtol=0, atol=1e-9)
