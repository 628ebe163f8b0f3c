"""Times at which steps of an integration end because loads or prescribed motions are not smooth there."""

from __future__ import annotations

import numpy as np

from flexmb.math.jets import sample_signals

__all__ = ["jumps_at", "jumps_at_once", "just_after", "just_before", "refined", "with_breaks", "with_fine"]

APART = 1e-11
"""Times that are nearer to each other than this part of the run are one."""
JUMP = 1e-6
"""Change of a value, relative to its size, that is a jump."""
NEXT = 1e-3
"""Distance, relative to the run, at which values tell what size is."""


def beside(t):
    """Return how far from a time one is just before or after it, whatever is rounded, s; from t = 0 it is 1e-18 s."""
    return 1e-12 * np.maximum(np.abs(t), 1e-6)


def just_before(t):
    """Return times at which signals still have the values on the left of `t`."""
    return t - beside(t)


def just_after(t):
    """Return times at which signals have the values on the right of `t`."""
    return t + beside(t)


def with_breaks(system, times: np.ndarray, remembers: bool) -> tuple[np.ndarray, np.ndarray]:
    """Return increasing times with those between at which signals are not smooth, and those at which to begin anew.

    The error of a step across a kink is of low order, and what happens within a step is lost: a pulse between two
    evaluations would not have been. Where accelerations jump every method begins anew, where their rates do those that
    remember what was before (Hairer, Nørsett & Wanner 1993, II.6). The step before ends just before such a time.

    Parameters
    ----------
    times : (n,), s
        Samples, with start and end; all of them stay as they are.
    remembers : bool
        Does the method use rates of earlier steps?

    Returns
    -------
    marks, anew : (m,), (k,), s
        The latter are among the marks.
    """
    begin, end = times[0], times[-1]
    near = APART * max(abs(begin), abs(end), end - begin)
    known = system.signal_times.between(begin, end)
    breaks = known.breaks
    within = breaks[(breaks > begin + near) & (breaks <= end + near)]
    if not len(within):
        return times, np.empty(0)
    within = within[np.concatenate([[True], np.diff(within) > near])]
    closest = np.clip(np.searchsorted(times, within), 1, len(times) - 1)
    closest = np.where(within - times[closest - 1] < times[closest] - within, times[closest - 1], times[closest])
    held = _among(within, known.sampled, near)
    within = np.where(np.abs(within - closest) <= near, closest, within)
    jumps = [h or _jumps(system, t, NEXT * (end - begin), remembers) for t, h in zip(within, held)]
    anew = within[np.array(jumps, bool)]
    return np.unique(np.concatenate([times, within, just_before(anew)])), anew


def _among(times: np.ndarray, known: np.ndarray, near: float) -> np.ndarray:
    """Return which times are among known ones, increasing."""
    if not len(known):
        return np.zeros(len(times), bool)
    after = np.minimum(np.searchsorted(known, times), len(known) - 1)
    before = np.maximum(after - 1, 0)
    return np.minimum(np.abs(times - known[before]), np.abs(times - known[after])) <= near


def with_fine(system, marks: np.ndarray) -> np.ndarray:
    """Return the marks with those times between at which signals begin to change faster than before: a method that
    goes from mark to mark meets what lasts a small part of the run.
    """
    begin, end = marks[0], marks[-1]
    fine = system.signal_times.between(begin, end).fine
    near = APART * max(abs(begin), abs(end), end - begin)
    fine = fine[(fine > begin) & (fine < end)]
    at = np.clip(np.searchsorted(marks, fine), 1, len(marks) - 1)
    apart = np.minimum(np.abs(fine - marks[at - 1]), np.abs(fine - marks[at])) > near
    return np.unique(np.concatenate([marks, fine[apart]]))


def jumps_at_once(system, t: float) -> bool:
    """Have signals other values at `t` than just after it, or other rates where these are read: is a start there none
    on the right side of a jump?
    """
    now, then = _sampled(system, t), _sampled(system, just_after(t))
    size = np.fmax(np.abs(now), np.abs(then))
    jumps = np.abs(then - now)[:, :2] > JUMP * size[:, :2] + 4.0 * (just_after(t) - t) * size[:, 1:]
    return bool(np.any(jumps[:, 0]) or np.any(jumps[system.rates_read]))


def jumps_at(system, t: float) -> bool:
    """Do values or rates of signals of time jump at a time?"""
    return _jumps(system, t, 1e3 * beside(t), True)


def _jumps(system, t: float, nearby: float, rates: bool) -> bool:
    """Do accelerations (or their rates) jump at a time: loads (or their rates), or rates that are read: of prescribed
    motions, of targets of motors with damping?
    """
    left, right, before, after = (
        _sampled(system, at) for at in (just_before(t), just_after(t), t - nearby, t + nearby)
    )
    size = np.fmax.reduce(np.abs([left, right, before, after]))  # what grows from zero does not jump
    between = 4.0 * (t - just_before(t)) * np.column_stack([size[:, 1:], np.zeros(len(size))])  # by the rates
    jumps = np.abs(right - left) > JUMP * size + between
    return bool(np.any(jumps[:, : 2 if rates else 1]) or np.any(jumps[system.rates_read]))


def _sampled(system, t: float) -> np.ndarray:
    """Return value, rate and second rate of all signals, (ns, 3)."""
    program, out = system.program, np.zeros((system.n_signals, 3))
    sample_signals(
        t,
        program.signals,
        out,
    )
    return out


def refined(times: np.ndarray, longest: float) -> np.ndarray:
    """Return the times with more between them, so that no gap is longer than `longest`; millions of them at once."""
    pieces = np.ceil(np.diff(times) / longest).astype(np.int64)
    steps = np.diff(times) / np.maximum(pieces, 1)
    number = np.arange(pieces.sum()) - np.repeat(np.cumsum(pieces) - pieces, pieces)
    return np.append(number * np.repeat(steps, pieces) + np.repeat(times[:-1], pieces), times[-1])
