"""Times at which an integrator comes back: samples, what is not smooth between them, and looks at events."""

from __future__ import annotations

import numpy as np

from flexmb.integrate.runs.breaks import beside, refined, with_breaks, with_fine

__all__ = ["SAME", "marks_to", "meets_at_once"]

SAME = 1e-13
"""Times that differ by less, relative to them, are the same."""


def marks_to(
    system, end: float, t: float, samples: np.ndarray, begun: float, remembers: bool, longest: float | None
) -> tuple[np.ndarray, np.ndarray]:
    """Return the times from t to the end of a phase at which an integrator comes back, and those at which it begins
    anew.

    They follow from the samples of the whole run and from when the phase began: a run that was cut off anywhere meets
    the same ones afterwards. Steps end there, so others would have other errors.

    Parameters
    ----------
    samples : (n,), s
        Of the whole run.
    begun : float, s
        When the phase began, at t or before.
    remembers : bool
        Does the method use rates of earlier steps?
    longest : float, s, optional
        Between two looks at events.
    """
    same = SAME * max(abs(t), abs(end))
    passed = samples[(samples > begun + same) & (samples <= t + same)]
    latest = float(passed[-1]) if len(passed) else begun
    latest = latest if t - latest > same else t
    within = samples[(samples > latest + same) & (samples < end - same)]
    times = np.concatenate([[latest], within, [end] if end > latest + same else []])
    marks, anew = with_breaks(system, times, remembers)
    marks = with_fine(system, marks)
    marks = marks if longest is None else refined(marks, longest)
    if latest == t:
        return marks, anew
    return np.concatenate([[t], marks[marks > t + same]]), anew[anew > t + same]


def meets_at_once(marks: np.ndarray, first: int, t: float) -> bool:
    """Is the next mark, `marks[first]`, as near to the time t as a time just before it?

    Nothing moves until then, but what jumps there is not known yet, and the mark may be a sample.
    """
    return first < len(marks) and 0.0 < marks[first] - t <= 2.0 * float(beside(marks[first]))
