"""`simulate`: the motion of a model over time."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from flexmb.errors import IntegrationError, ModelError
from flexmb.integrate.generalized_alpha import GeneralizedAlpha
from flexmb.model.model import Model
from flexmb.results import Phase, RunFile, Solution, Status, floating_data
from flexmb.system import assemble

__all__ = ["simulate"]

CHUNK = 0.2
"""Seconds between looks at progress, interruption and the file."""


def sample_times(t_start: float, t_end: float, samples) -> np.ndarray:
    """Return the times at which the state is kept, from a count or from given times."""
    if not np.isfinite(t_end) or t_end <= t_start:
        raise ModelError("simulate", found=f"t_end = {t_end!r} s", expected=f"a time after the start, t = {t_start:g} s",
                         remedy="Give t_end in seconds")
    if np.isscalar(samples):
        count = int(samples)
        if count < 2:
            raise ModelError("simulate", found=f"samples = {samples!r}", expected="at least 2 (start and end), or the times",
                             remedy="samples=1001 gives a sample every thousandth of the time")
        return np.linspace(t_start, t_end, count)
    times = np.asarray(samples, float)
    if times.ndim != 1 or len(times) < 2 or np.any(np.diff(times) <= 0.0) or times[0] < t_start or times[-1] > t_end:
        raise ModelError("simulate", found="sample times that do not increase, or lie outside the run",
                         expected=f"increasing times from {t_start:g} to {t_end:g} s", remedy="Sort the times")
    return times if times[0] == t_start else np.concatenate([[t_start], times])


class _Recorder:
    """Collects rows in memory and, if a path is given, in the run file."""

    def __init__(self, model, system, path, write_model):
        self.model, self.system = model, system
        self.rows: list[dict[str, np.ndarray]] = []
        self.file = None if path is None else RunFile(path, floating_data(model))
        if self.file is not None:
            self.file.begin(write_model(model) if write_model is not None else "")

    def add(self, rows: dict[str, np.ndarray]) -> None:
        """Keep a block of samples."""
        if len(rows["t"]):
            self.rows.append(rows)
            if self.file is not None:
                self.file.append(*rows.values())

    def solution(self, status: Status, statistics: dict[str, Any]) -> Solution:
        """Return the solution of all blocks; finish the file with the values of the sensors."""
        joined = {name: np.concatenate([rows[name] for rows in self.rows]) for name in self.rows[0]}
        phase = Phase(model=self.model, system=self.system, ended=status.kind, **joined)
        solution = Solution(phases=(phase,), status=status, statistics=statistics)
        if self.file is not None:
            names = [sensor.name for sensor in self.model.sensors]
            tables = {name: solution[name] for name in names}
            self.file.end(status.kind, tables, {name: solution.column_titles(name) for name in names})
            self.file.finish(status, statistics)
        return solution


def simulate(
    model: Model,
    t_end: float,
    *,
    integrator: Any = None,
    samples: Any = 201,
    t_start: float = 0.0,
    output: str | Path | None = None,
    write_model: Callable[[Model], str] | None = None,
    progress: Callable[[float, float], None] | None = None,
) -> Solution:
    """Integrate the equations of motion from the assembled start to `t_end`.

    Parameters
    ----------
    model : Model
    t_end : float, s
    integrator : integrator, optional
        `GeneralizedAlpha()` unless given.
    samples : int or (nt,) s
        Number of equally spaced samples including both ends, or their times.
    t_start : float, s
    output : path, optional
        Solution file that is written while the run goes on; a run that is cut off leaves what it had.
    write_model : callable Model -> text, optional
        Makes the text of the model that is stored in the file (`flexmb.io.model_text`).
    progress : callable (t, t_end), optional
        Called a few times per second.

    Returns
    -------
    Solution
        Its ``status`` says how the run ended; Ctrl-C ends it with status "interrupted" and all samples so far.

    Raises
    ------
    ModelError, CompileError
        Before computing starts, if the model or the settings are wrong.
    IntegrationError
        If the integrator cannot go on; ``error.solution`` holds all samples so far.
    """
    integrator = GeneralizedAlpha() if integrator is None else integrator
    times = sample_times(t_start, t_end, samples)
    began = time.perf_counter()
    system, state = assemble(model, t=t_start)
    work = system.workspace()
    variables = integrator.start(system, state, work, t_end)
    recorder = _Recorder(model, system, output, write_model)
    status, outcome = Status.finished(t_end), None
    first, block = 0, 1
    try:
        while first < len(times):
            last = min(len(times), first + block)
            clock = time.perf_counter()
            outcome = integrator.run(system, work, variables, times, first, last)
            recorder.add(outcome.rows)
            if outcome.failure:
                status = Status.failed(outcome.failure, outcome.remedy)
                break
            first = last
            if progress is not None:
                progress(float(times[last - 1]), t_end)
            spent = time.perf_counter() - clock
            block = max(1, int(block * min(4.0, CHUNK / max(spent, 1e-4))))
    except KeyboardInterrupt:
        status = Status.interrupted(float(times[first - 1]) if first else t_start)
    statistics = {**integrator.statistics(variables), "seconds": time.perf_counter() - began}
    solution = recorder.solution(status, statistics)
    if status.kind == "failed" and outcome is not None:
        raise IntegrationError(f"Model '{model.name}'", found=outcome.failure,
                               expected="a motion that the integrator can follow", remedy=outcome.remedy, solution=solution)
    return solution
