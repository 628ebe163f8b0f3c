"""`resume`: continue a simulation that was cut off, or past its end, from its last sample."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from flexmb.errors import ModelError
from flexmb.integrate.impulsive import require_method
from flexmb.integrate.orbital import default_integrator, unless_stiff
from flexmb.integrate.runs.after_event import assembled_after
from flexmb.integrate.runs.counts import together
from flexmb.integrate.runs.impact import velocities_after
from flexmb.integrate.runs.interruption import lost_interrupts
from flexmb.integrate.runs.phases import Phases
from flexmb.integrate.runs.reaction_errors import OF_REACTIONS
from flexmb.integrate.runs.reasons import require_end
from flexmb.integrate.runs.record import Recorder
from flexmb.integrate.runs.simulate import sample_times
from flexmb.integrate.runs.watch import carried, next_phase
from flexmb.math.tables import State
from flexmb.model.described import is_number
from flexmb.model.methods import require_time_limit
from flexmb.model.model import Model
from flexmb.model.orbit import require_orbit
from flexmb.results import RunFile, Series, Solution, Status
from flexmb.system import System, assemble
from flexmb.system import compile as compile_model
from flexmb.told import listening

__all__ = ["resume"]

CONTINUES = ("finished", "interrupted", "limited", "failed")
"""What ends a phase without a change of the model."""


@lost_interrupts()
def resume(
    run: Solution | str | Path,
    t_end: float,
    *,
    integrator: Any = None,
    samples: Any = 201,
    read_model: Callable[[str, dict], Any] | None = None,
    write_model: Callable[[Model], str] | None = None,
    progress: Callable[[float, float], None] | None = None,
    time_limit: float | None = None,
) -> Solution:
    """Continue a simulation from its last sample, or the state that it had reached since, to `t_end`.

    A run that was cut off after its last sample is completed. Configuration, velocity, works and the model after the
    events so far are taken over; accelerations and reactions follow from them, so the motion equals an uninterrupted
    run to the tolerance of the integrator. Where the run was interrupted, `GeneralizedAlpha` with the same settings
    goes on with what it knew, and takes the same steps.

    Parameters
    ----------
    run : Solution, or path of a solution file
        A file is continued in place: what it holds stays, also if the continued run is cut off in turn.
    t_end : float, s
        That of the run, or later.
    integrator : integrator, optional
        As `simulate`; a failed run may be continued with another one.
    samples : int or (nt,) s
        As `simulate`, over the whole run from its first start; those that are there already are not computed again.
    read_model : callable (text, {body name: ModalNeutralData}) -> Model
        Makes the model from the text in the file (`flexmb.read_model_text`); needed with a path.
    write_model, progress, time_limit
        As `simulate`; the limit counts for the continued part.

    Raises
    ------
    ModelError
        The run has reached `t_end` and its end, was stopped by an event, or its model is not known.
    IntegrationError, DataFileError
        As `simulate`.
    """
    path, before = (None, run) if isinstance(run, Solution) else (Path(run), Solution.load(run, read_model=read_model))
    clock = time.perf_counter()
    last, model, state, event = _where(before, t_end)
    merge = event is None
    if model is None:
        return _ended(before, path)
    integrator = _allowed(model, integrator)
    require_time_limit(time_limit, "resume")
    planned = sample_times(float(before.t[0]), t_end, samples)
    require_orbit(model, float(planned[-1]))
    times = np.concatenate([[last.t], planned[planned > last.t * (1.0 + 1e-14)]])
    with listening() as heard:
        assembled = _assembled_again(before, event, model, last.t, state)
    integrator, stiff = unless_stiff(integrator, *assembled, float(times[-1]) - last.t)
    file = None if path is None else RunFile.continued(path, new_phase=not merge)
    recorder = Recorder(model, file, write_model, before=before, merge=merge)
    phases = Phases(integrator, recorder, times, progress, before.statistics, planned=planned, time_limit=time_limit)
    phases.validity.keep(heard)
    phases.validity.tell(stiff)
    try:
        status = phases.run(model, assembled, last.works, goes_on=before.phases[-1] if merge else None)
    except BaseException:
        recorder.close()
        raise
    phases.validity.tell_of_tracks()
    known = {"integrator": repr(integrator), "seconds": _seconds(before, clock), **phases.validity.statistics}
    counts = together(_told(before.statistics, phases.statistics), phases.statistics)
    solution = recorder.solution(status, {**counts, **known})
    require_end(status, model, solution)
    return solution


def _allowed(model: Model, integrator: Any):
    """Return the integrator that goes on, which can integrate the model: the given one, or the usual one."""
    integrator = default_integrator(model) if integrator is None else integrator
    require_method(model, integrator, "resume")
    return integrator


def _assembled_again(before: Solution, event, model: Model, t: float, state) -> tuple[System, State]:
    """Return the model assembled at the state of the run, or behind the event that has ended its last phase."""
    if event is None:
        return assemble(model, t=t, state=state)
    return assembled_after(event, before.phases[-1].model, model, t, state)


def _seconds(before: Solution, clock: float) -> float:
    """Return the clock time that the run has taken so far, with the part that began at `clock`."""
    spent = before.statistics.get("seconds", 0.0)
    return (spent if is_number(spent) else 0.0) + time.perf_counter() - clock


def _told(before: Mapping[str, Any], after: Mapping[str, Any]) -> dict[str, Any]:
    """Return what the part before told of what the other tells, and its errors of reactions: numbers, words, and
    numbers by joint."""
    names = [*after, *(name for name in (OF_REACTIONS,) if name not in after)]
    found = {name: before[name] for name in names if name in before}
    return {name: value for name, value in found.items() if is_number(value) or isinstance(value, str | Mapping)}


def _ended(before: Solution, path: Path | None) -> Solution:
    """Return a run that an event has stopped, with the status that it could not write any more."""
    status = Status.stopped(before.phases[-1].ended, float(before.t[-1]))
    if path is not None:
        RunFile.continued(path, new_phase=True).finish(status, before.statistics)
    return replace(before, status=status)


def _require_described_inputs(part: str, phase) -> None:
    """Raise ModelError if the run ended with inputs that were set from outside: its model knows nothing of them."""
    if phase.inputs is None or not phase.inputs.size:
        return
    system = phase.system or compile_model(phase.model)
    described = compile_model(phase.model).program.signals.args
    for (name, places), value in zip(system.inputs.items(), phase.inputs[-1], strict=True):
        if value != described[places[0]]:
            raise ModelError(
                part,
                found=f"input '{name}' was set to {value:g} from outside, and its model says {described[places[0]]:g}",
                expected="a run whose loads are all described",
                remedy="Go on with flexmb.stepper(model, start=solution.final, t_start=...), and set the inputs",
            )


def _where(before: Solution, t_end: float):
    """Return the last instant, the model that continues (None: an event has stopped the run), its state by body name,
    and the event after which a new phase begins (None: the last one goes on).
    """
    phase, last = before.phases[-1], before.final
    part = f"Run of model '{getattr(phase.model, 'name', '?')}'"
    if phase.model is None:
        raise ModelError(
            "resume",
            found="the model of the run is not known",
            expected="a solution with its model",
            remedy="Give read_model=flexmb.read_model_text, or a Solution loaded with its model",
        )
    _require_described_inputs(part, phase)
    over = not t_end > last.t
    if over and (before.status.ok or before.status.kind == "failed"):
        raise ModelError(
            part,
            found=f"it has reached t = {last.t:.9g} s already",
            expected=f"a run that ended before t_end = {t_end:g} s",
            remedy="Give a later t_end to continue",
        )
    if before.status.kind == "stopped":
        raise ModelError(
            part,
            found=str(before.status),
            expected="a run that was cut off, or reached its end",
            remedy="Take the event out of the model and simulate again",
        )
    if over and last.t > t_end * (1.0 + 1e-12):
        raise ModelError(
            part,
            found=f"it has gone beyond t_end = {t_end:g} s, to {last.t:.9g} s",
            expected="the end time of the run, or a later one",
            remedy="Give a later t_end to continue",
        )
    system = phase.system or compile_model(phase.model)
    model, event = phase.model, None
    if phase.ended not in CONTINUES:  # cut off between an event and the first sample after it
        event = next((event for event in model.events if event.name == phase.ended), None)
        if event is None:
            raise ModelError(
                part,
                found=f"a phase that ended by '{phase.ended:.60}', which is no event of its model",
                expected=f"One of: {', '.join(event.name for event in model.events) or 'none'}",
                remedy="Simulate again: the file was changed after it was written",
            )
        model = next_phase(model, event, Series(phase))
        if model is None:  # cut off between its last sample and the word that it has ended
            return last, None, {}, event
        last = replace(last, u=velocities_after(system, event, last.t, last.q, last.u))
    return last, model, carried(system, model, last.q, last.u), event
