"""The times of a phase: of its samples and its end, and those at which its integrator comes back or begins anew."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from flexmb.integrate.runs.marks import SAME, marks_to
from flexmb.model.model import Model

__all__ = ["PhaseTimes", "times_of_phase"]


class PhaseTimes(NamedTuple):
    """When a phase ends, and what happens on the way.

    due : Event, or None
        The event at a given time that ends the phase, if no other does before.
    end : float, s
    samples : (n,), s
        From the beginning to the end, both among them.
    marks, breaks : (m,) and (k,), s
        Of `marks_to`.
    """

    due: Any
    end: float
    samples: np.ndarray
    marks: np.ndarray
    breaks: np.ndarray


def times_of_phase(
    model: Model,
    system,
    t: float,
    times: np.ndarray,
    planned: np.ndarray,
    begun: float,
    remembers: bool,
    longest: float | None,
) -> PhaseTimes:
    """Return the times of a phase from t on.

    Parameters
    ----------
    times, planned : (n,), s
        The samples that are asked for, and those of the whole run.
    begun, remembers, longest
        As in `marks_to`.
    """
    due = _due(model, times[-1])
    end = max(due.at, t) if due is not None else float(times[-1])
    marks, breaks = marks_to(system, end, t, planned, begun, remembers, longest)
    return PhaseTimes(due=due, end=end, samples=_samples(times, t, end), marks=marks, breaks=breaks)


def _due(model: Model, last: float):
    """Return the first event at a given time until the last one, or None."""
    timed = sorted((e for e in model.events if e.sensor is None), key=lambda e: e.at)
    return timed[0] if timed and timed[0].at <= last else None


def _samples(times: np.ndarray, t: float, end: float) -> np.ndarray:
    """Return the times of the samples of a phase from t to its end."""
    # 0.7 and 0.7000000000000001, an event and a sample, are one time: no step is that short
    same = SAME * max(abs(t), abs(end))
    within = times[(times > t + same) & (times < end - same)]
    return np.concatenate([[t], within, [end] if end > t + same else []])
