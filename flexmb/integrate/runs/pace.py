"""How fast a run gets on: what is left of it at its pace, and whether it gets on at all.

The pace covers the latest seconds of work, not the whole run: steps that suddenly become very short would hide
behind a quick begin for as long again.
"""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable, Mapping
from typing import NamedTuple

import numpy as np

from flexmb.errors import YEAR, duration

__all__ = ["REMEDY", "Pace"]

WINDOW, STEPS = 10.0, 10_000
"""A run ends if in so many seconds of work and so many steps it does not come as far as to need less than a year."""
FIRST, FEW, LONG = 4.0, 20, 600.0
"""After so many seconds of work and so many steps it is told when more than so many seconds are left."""
SOON, SLOW = 1.0, 60.0
"""After so many seconds of work, when more than so many are left, it is looked whether a motion grows without bound."""
WORSE = 10.0
"""It is told once more when the end is so many times farther away."""
REMEDY = "Look at the end time (s) and at stiffness, mass and loads: are all in SI units?"
TRIALS = ("rejected by error", "rejected by iteration", "cut at contacts", "rejected")
"""Steps that were tried in vain, in the statistics of integrators."""


class _Look(NamedTuple):
    work: float
    t: float
    steps: int
    vain: int


class Pace:
    """The latest seconds of a run, from the first look on: what is compiled before is not its pace.

    Parameters
    ----------
    begin, end : float, s
        Of the simulated time.
    clock : callable, optional
        Seconds of work: of the processor, since others may use it too.
    """

    def __init__(self, begin: float, end: float, clock: Callable[[], float] = time.process_time):
        self.end, self._clock = end, clock
        self._looks: deque[_Look] = deque()
        self._before = _Look(0.0, begin, 0, 0)
        self._told = LONG

    def new_phase(self) -> None:
        """Count steps on from here: an integrator begins anew, and its counts at zero."""
        self._before = self._looks[-1] if self._looks else self._before

    def look(self, t: float, counts: Mapping[str, int]) -> None:
        """Take note of the time that is reached, and of the counts of the integrator since the phase began."""
        steps = self._before.steps + counts.get("steps", 0)
        vain = self._before.vain + sum(counts.get(name, 0) for name in TRIALS)
        self._looks.append(_Look(self._clock(), t, steps, vain))
        while len(self._looks) > 2 and self._looks[-1].work - self._looks[1].work >= WINDOW:
            self._looks.popleft()

    @property
    def left(self) -> float:
        """Seconds of work that are left at the pace of the latest ones; infinite if it stands still."""
        first, last = self._looks[0], self._looks[-1]
        gone, left = last.t - first.t, self.end - last.t
        return 0.0 if left <= 0.0 else left / gone * (last.work - first.work) if gone > 0.0 else np.inf

    @property
    def hopeless(self) -> bool:
        """Will it take years?"""
        return self._known(WINDOW, STEPS) and self.left > YEAR

    @property
    def slow(self) -> bool:
        """Is so much left that a motion without bound would be its cause?"""
        return self._known(SOON, FEW) and self.left > SLOW

    def long(self) -> bool:
        """Is it to be told that much is left? Once, and again when it has become much more."""
        if not self._known(FIRST, FEW) or self.left <= self._told:
            return False
        self._told = WORSE * self.left
        return True

    def _known(self, seconds: float, steps: int) -> bool:
        """Do the latest looks span so many seconds of work, and so many steps?"""
        first, last = self._looks[0], self._looks[-1]
        tried = last.steps + last.vain - first.steps - first.vain
        return last.work - first.work >= seconds and tried >= steps

    def sentence(self) -> str:
        """Return how far the run has come, its steps, and what is left."""
        first, last = self._looks[0], self._looks[-1]
        steps, vain = last.steps - first.steps, last.vain - first.vain
        tried = f"{steps} steps" + (f" of about {(last.t - first.t) / steps:.2g} s" if steps else "")
        tried += f", {vain} in vain" if vain > 0.1 * steps else ""
        return (
            f"{last.steps} steps have reached t = {last.t:.9g} s of {self.end:.9g} s; at the pace of the latest "
            f"{last.work - first.work:.0f} s of work ({tried}) the end would take {duration(self.left)}"
        )
