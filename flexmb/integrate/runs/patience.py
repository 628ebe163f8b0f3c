"""How long an integrator may run before it returns, however far the next sample is: the user may want to stop."""

from __future__ import annotations

import time

import numpy as np

__all__ = ["PAUSED", "ROUNDINGS", "UNCUT", "Patience", "smallest_step"]

PAUSED = -1
"""What a compiled loop returns when it has used up its steps."""
SLICE = 0.1
"""s: length of a call of a compiled loop that is aimed at."""
ROUNDINGS, UNCUT = 4.0 * float(np.finfo(float).eps), 1e4
"""A step is no shorter than this part of the time, four roundings; below so many of such steps it is not cut at
contacts."""
ENDLESS, MOST = np.iinfo(np.int64).max, 10**9


class Patience:
    """Divides a run of compiled steps, which cannot look at a clock, into calls that are short.

    Where they are divided changes nothing in the steps.

    Parameters
    ----------
    seconds : float
        After so long `used_up` is true; infinite: never, and one call does all.
    """

    def __init__(self, seconds: float):
        self._until = time.perf_counter() + seconds
        self._clock = 0.0
        self._steps = 1 if seconds < np.inf else ENDLESS

    def steps(self, *, used: bool = True) -> int:
        """Return how many steps the next call may try, by the time that the call before has taken.

        Where its steps were not `used` up, as a sample came first, its time is no reason to allow more of them.
        """
        now = time.perf_counter()
        if self._clock and self._steps < ENDLESS:
            factor = min(4.0 if used else 1.0, SLICE / max(now - self._clock, 1e-6))
            self._steps = int(np.clip(self._steps * factor, 1, MOST))
        self._clock = now
        return self._steps

    @property
    def used_up(self) -> bool:
        """Shall the integrator come back?"""
        return time.perf_counter() >= self._until


def smallest_step(t: float, goal: float) -> float:
    """Return the step size at which a run ends, s: a few roundings of the time that it shall reach.

    Added to such a time, a shorter one would not move it, and steps would be taken for ever.
    """
    return ROUNDINGS * max(abs(t), abs(goal))
