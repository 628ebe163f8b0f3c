"""`simulate`: the motion of a model over time."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from flexmb.errors import ModelError, did_you_mean
from flexmb.integrate.equilibria.statics import equilibrium
from flexmb.integrate.explicit.explicit import Explicit
from flexmb.integrate.impulsive import require_method, rigid_contacts
from flexmb.integrate.nonsmooth.apart import require_drawn_apart
from flexmb.integrate.orbital import default_integrator, far_from_origin, unless_stiff
from flexmb.integrate.overlaps import overlaps
from flexmb.integrate.oversights import oversights
from flexmb.integrate.runs.ahead_of_run import compile_ahead_of_run, ready_for_kinks
from flexmb.integrate.runs.interruption import lost_interrupts
from flexmb.integrate.runs.phases import Phases
from flexmb.integrate.runs.prescribed_jumps import require_no_jumps
from flexmb.integrate.runs.reasons import require_end
from flexmb.integrate.runs.record import Recorder
from flexmb.integrate.runs.watch import carried
from flexmb.model.described import check_kind, is_number
from flexmb.model.methods import Integrator, is_integrator, require_time_limit
from flexmb.model.model import Model
from flexmb.model.orbit import require_orbit
from flexmb.model.registered import kinds_of
from flexmb.results import Solution
from flexmb.results.phase import MOST_SAMPLES
from flexmb.system import assemble, assemble_as_drawn
from flexmb.system import compile as compile_model
from flexmb.system.branching import require_motion_to_begin
from flexmb.told import listening

__all__ = ["chosen_integrator", "run_assembled", "sample_times", "simulate", "state_at"]

ROUNDED = 8.0 * float(np.finfo(float).eps)
"""Sample times this close to the ends of a run, relative to its times, are the ends."""


def sample_times(t_start: float, t_end: float, samples) -> np.ndarray:
    """Return the times at which the state is kept, from a count or from given times."""
    if not is_number(t_end) or t_end <= t_start:
        raise ModelError(
            "simulate",
            found=f"t_end = {t_end!r} s",
            expected=f"a time after the start, t = {t_start:g} s",
            remedy="Give t_end in seconds",
        )
    if np.ndim(samples) == 0:
        whole = is_number(samples) and samples == int(samples)
        count = int(samples) if whole else 0
        if not 2 <= count <= MOST_SAMPLES:
            raise ModelError(
                "simulate",
                found=f"samples = {samples!r}",
                expected=f"a whole number of at least 2 (start and end) and at most {MOST_SAMPLES}, or the times",
                remedy="samples=1001 gives a sample every thousandth of the time",
            )
        return np.linspace(t_start, t_end, count)
    try:
        times = np.asarray(samples, float)
    except (TypeError, ValueError, OverflowError):
        times = np.empty(0)
    # sums and products of steps miss the ends by rounding
    close = ROUNDED * max(abs(t_start), abs(t_end))
    times = np.where(np.abs(times - t_end) <= close, t_end, np.where(np.abs(times - t_start) <= close, t_start, times))
    if times.ndim != 1 or len(times) < 2 or np.any(np.diff(times) <= 0.0) or times[0] < t_start or times[-1] > t_end:
        raise ModelError(
            "simulate",
            found="sample times that do not increase, or lie outside the run",
            expected=f"increasing times from {t_start:g} to {t_end:g} s",
            remedy="Sort the times",
        )
    return times if times[0] == t_start else np.concatenate([[t_start], times])


def state_at(start, model: Model, t: float):
    """Return the state by body name of an instant (or the last instant of a solution), for another start of a model."""
    if isinstance(start, str):
        if start != "equilibrium":
            raise ModelError(
                "simulate",
                found=f"start = {start!r}",
                expected="'equilibrium', a Solution or an instant of one",
                remedy="Leave it out to begin as described",
            )
        start = equilibrium(model, t)
    start = getattr(start, "final", start)
    if not all(hasattr(start, name) for name in ("q", "u")):
        raise ModelError(
            "simulate",
            found=f"a start of the class {type(start).__name__}",
            expected="'equilibrium', a Solution or an instant of one, or a state of JointTree.absolute",
            remedy="Leave it out to begin as described",
        )
    system = compile_model(getattr(start, "model", None) or model)
    if len(start.q) != system.nq or len(start.u) != system.nu:
        raise ModelError(
            "simulate",
            found=f"a start with {len(start.q)} coordinates and {len(start.u)} velocities",
            expected=f"{system.nq} and {system.nu}, as in model '{system.model.name}'",
            remedy="Give a solution of this model, or an Instant that names its own model",
        )
    return carried(system, model, start.q, start.u)


def chosen_integrator(model: Model, integrator, formulation):
    """Return the integrator that is meant by the arguments of `simulate`."""
    check_kind(model, Model, "Model", "Give a flexmb.Model(bodies=[...]), or flexmb.load_model('file.toml')")
    if formulation is None:
        integrator = default_integrator(model) if integrator is None else integrator
        if not is_integrator(integrator):
            name = integrator.__name__ if isinstance(integrator, type) else str(integrator)
            known = sorted(kinds_of(Integrator))
            near = did_you_mean(name, known)
            proposed = near.split("'")[1] if near else "GeneralizedAlpha"
            raise ModelError(
                "simulate",
                found=f"integrator = {name if isinstance(integrator, type) else integrator!r}",
                expected=f"one of {', '.join(f'{kind}(...)' for kind in known)}",
                remedy=f"Give the object itself: integrator=flexmb.{proposed}()",
            )
        return integrator
    if integrator is not None:
        raise ModelError(
            "simulate",
            found=f"both an integrator, {integrator!r}, and a formulation, {formulation!r}",
            expected="one of them",
            remedy="Write integrator=Explicit(..., formulation=...) or Implicit(...); GeneralizedAlpha and IDA "
            "have no use for a formulation, they solve for positions and reactions together",
        )
    return Explicit(formulation=formulation)


@lost_interrupts()
def simulate(
    model: Model,
    t_end: float,
    *,
    integrator: Any = None,
    formulation: Any = None,
    samples: Any = 201,
    t_start: float = 0.0,
    start: Any = None,
    output: str | Path | None = None,
    write_model: Callable[[Model], str] | None = None,
    progress: Callable[[float, float], None] | None = None,
    time_limit: float | None = None,
) -> Solution:
    """Integrate the equations of motion from the assembled start to `t_end`.

    Parameters
    ----------
    model : Model
    t_end : float, s
    integrator : integrator, optional
        `GeneralizedAlpha()` unless given; for rigid bodies and points in orbit (`CentralGravity`, `ThirdBody`), unless
        springs are too stiff, `Explicit(rtol=1e-11, atol=1e-13, drift=1e-12)`: errors add up over the revolutions.
    formulation : Augmented, NullSpace, UdwadiaPhohomsiri, Recursive or Baumgarte, optional
        How accelerations are found, by `Explicit(formulation=...)`; `Recursive` integrates the coordinates of the
        joints, as `Implicit` does for stiff bodies. `GeneralizedAlpha` and `IDA` do not ask for accelerations.
    samples : int or (nt,) s
        Number of equally spaced samples including both ends, or their times.
    t_start : float, s
    start : Solution, Instant, state of `JointTree.absolute` or "equilibrium", optional
        Where the motion begins, if not as described: the result of `statics` (its last sample), an instant of
        another solution, bodies found by name, or joint coordinates; "equilibrium": that at `t_start`, where elastic
        bodies do not ring.
    output : path, optional
        Solution file, written during the run; an interrupted run keeps its samples so far.
    write_model : callable Model -> text, optional
        Makes the text of the model that is stored in the file (`flexmb.io.model_text`).
    progress : callable (t, t_end), optional
        Called a few times per second.
    time_limit : float, s, optional
        Clock time after which the run ends with the status "limited" and what it has reached; compiling before the
        first sample does not count. `resume` goes on from there.

    Returns
    -------
    Solution
        Its ``status`` says how the run ended. Ctrl-C ends it at the next sample with status "interrupted" and all
        samples so far, in memory and in the file; before the first sample, and the second time, it raises
        KeyboardInterrupt. If `output` is removed or moved meanwhile, a warning says so, and the statistic
        "solution file" where it is now; it is empty if the samples are in memory alone.

    Raises
    ------
    ModelError, CompileError
        Before computing starts, if the model or the settings are wrong.
    IntegrationError
        If the integrator cannot continue; ``error.solution`` holds all samples so far.
    """
    integrator = chosen_integrator(model, integrator, formulation)
    require_method(model, integrator, "simulate")
    require_time_limit(time_limit, "simulate")
    times, told = sample_times(t_start, t_end, samples), []
    require_orbit(model, float(times[-1]))
    compile_ahead_of_run(model, integrator)
    clock = time.perf_counter()
    state = None if start is None else state_at(start, model, t_start)
    with listening() as heard:  # whatever is wrong shows before a file is made
        assembled = _assembled(model, integrator, t_start, state, told)
    return run_assembled(
        integrator, assembled, times, told, clock, output, write_model, progress, time_limit=time_limit, heard=heard
    )


def _assembled(model: Model, integrator: Any, t: float, state: Any, told: list[str]):
    """Return system and start, from a state by body name, or (None) as described: then rigid contacts must be open."""
    if state is not None:
        return assemble(model, t=t, state=state)
    assembled = assemble_as_drawn(model, t=t, tell=told.extend)
    if rigid_contacts(model):
        require_drawn_apart(*assembled, integrator.step)
    return assembled


def run_assembled(
    integrator,
    assembled,
    times: np.ndarray,
    told: list[str],
    clock: float,
    output=None,
    write_model=None,
    progress=None,
    regular=False,
    time_limit=None,
    heard=(),
) -> Solution:
    """Integrate from an assembled start to the last of `times`; see `simulate`.

    Parameters
    ----------
    assembled : System, State
    told : list of str
        What assembly had to say.
    heard : sequence of Told
        What it has said.
    clock : float, s
        When the computation began.
    regular : bool
        Is it known that the motion goes on from there, as in other variants? They are over before anyone looks:
        all samples are asked for at once.
    """
    system, begin = assembled
    model = system.model
    require_no_jumps(system, begin, float(times[-1]))
    told += [] if regular else require_motion_to_begin(system, begin, system.workspace())
    integrator, stiff = unless_stiff(integrator, system, begin, float(times[-1] - times[0]))
    told += [*stiff, *far_from_origin(system), *overlaps(system, begin)]
    recorder = Recorder(model, output, write_model)
    ready_for_kinks(system)
    phases = Phases(integrator, recorder, times, progress, whole=regular, time_limit=time_limit)
    phases.validity.keep(heard)
    phases.validity.tell(told)
    phases.validity.note([*oversights(model), *system.unlocated])
    try:
        status = phases.run(model, assembled)
    except BaseException:  # interrupted before the first sample, or out of memory: the file must not stay open
        recorder.close()
        raise
    phases.validity.tell_of_tracks()
    known = {"integrator": repr(integrator), "seconds": time.perf_counter() - clock, **phases.validity.statistics}
    solution: Any = None  # where not even the accelerations at the start were found
    if recorder.phases:
        solution = recorder.solution(status, {**phases.statistics, **known})
    else:
        recorder.close()
    require_end(status, model, solution)
    return solution
