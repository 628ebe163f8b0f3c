"""A motion that grows without bound, as behind a controller of far too high a gain: steps shorten with it for ever.

Errors are kept below a part of the lengths of a model, so a motion of 1e9 of them is followed in steps that become
shorter as it grows: such a run would not end, and not tell why. Speeds count here in lengths of the model by the time
that has passed, and their growth against that time, so units do not matter.
"""

from __future__ import annotations

import dataclasses
from collections import deque
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from flexmb.integrate.extent import extents
from flexmb.integrate.runs.fastest import present_rows, unchanged
from flexmb.model.signal import Signal

__all__ = ["REMEDY", "Runaway", "that_follow"]

FAR, BEYOND = 1e6, 1e9
"""Lengths of the model that the present speed covers in the time that has passed: from which on the growth of a motion
is looked at, and from which on it is named where the run has failed anyhow."""
TENFOLD, LATELY = 10.0, 0.8
"""It runs away if its speed has become so many times larger since that share of the time: as its tenth power."""
REMEDY = "Look at the sign of what is fed back; give lower gains, more damping, or a shorter period of samples"


class _Speed(NamedTuple):
    lengths: float
    """Lengths of the model by a unit of time."""
    value: float
    row: int


class Runaway:
    """The speeds that a slow run had when it was looked at.

    Parameters
    ----------
    begin : float, s
        Time at which the run began.
    """

    def __init__(self, begin: float):
        self.begin = begin
        self._looks: deque[tuple[float, float]] = deque()

    def look(self, integrator, system, work, variables, now: float) -> str | None:
        """Return the words about a motion that grows without bound, or None; the run is not changed."""
        passed = now - self.begin
        speed = _present(integrator, system, work, variables, now)
        if speed is None or not speed.lengths * passed > FAR:
            return None
        self._looks.append((passed, speed.lengths))
        while self._looks[0][0] < LATELY * passed:
            self._looks.popleft()
        if speed.lengths < TENFOLD * min(before for _, before in self._looks):
            return None
        return _words(system, speed, passed)

    def far_gone(self, integrator, system, work, variables, reached: float) -> str | None:
        """Return the words about a motion that a failed run has left far beyond its model, or None: a satellite in its
        orbit goes as far, so something must follow measurements.

        Parameters
        ----------
        reached : float, s
            Time at which the integrator stands; not finite if it does not say.
        """
        speed = _present(integrator, system, work, variables, reached) if np.isfinite(reached) else None
        if speed is None or not speed.lengths * (reached - self.begin) > BEYOND or not that_follow(system):
            return None
        return _words(system, speed, reached - self.begin)


def _present(integrator, system, work, variables, now: float) -> _Speed | None:
    """Return the highest speed at the time that a run has reached."""
    rows = present_rows(integrator, system, work, variables, now)
    if not len(rows["t"]):
        return None
    with unchanged(system, work), np.errstate(all="ignore"):
        q, u = (np.ascontiguousarray(rows[name][-1]) for name in "qu")
        extent, _ = extents(system, system.state(now, q, u), work)
        relative = np.where(system.is_state, 0.0, np.abs(u) * extent) / system.lengths.whole
    if not len(relative) or not np.all(np.isfinite(relative)):
        return None
    row = int(np.argmax(relative))
    return _Speed(float(relative[row]), float(u[row]), row)


def _words(system, speed: _Speed, passed: float) -> str:
    unit = "rad" if system.is_turn(speed.row) else "m"
    follow = that_follow(system)
    loops = f"; what follows measurements: {', '.join(follow)}" if follow else ""
    return (
        f"the motion of {system.owner(speed.row)}, grows without bound: {speed.value:.3g} {unit}/s after "
        f"{passed:.3g} s, {speed.lengths * passed:.1g} times the length of the model in that time{loops}"
    )


def that_follow(system) -> list[str]:
    """Return the titles of the forces that follow measurements."""
    return [part.title for part in system.model.forces if any(one.follows for one in _signals(part))]


def _signals(part: Any) -> Iterator[Signal]:
    """Yield the signals of a part."""
    for field in dataclasses.fields(part):
        value = getattr(part, field.name)
        for one in value if isinstance(value, tuple | list) else (value,):
            if isinstance(one, Signal):
                yield one
