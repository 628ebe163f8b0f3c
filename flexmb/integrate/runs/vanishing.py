"""Equations of the user whose gradient vanishes on the way: there they restrict nothing, and the motion may branch.

``x**2 + y**2 = R(t)**2`` is one when R passes zero. No integrator notices if it steps over the place.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from flexmb.constraints.formula import Formula
from flexmb.errors import IntegrationError
from flexmb.math.weights import no_matrix
from flexmb.results import Status
from flexmb.system.program import advance, evaluate

__all__ = ["Gradients"]

SMALL = 1e-2
"""Part of its size at both ends of an interval that a gradient is below, where it vanishes between."""
NOTHING = 1e-9
"""Part of its size at the other end that a gradient is below, where it vanishes at a row."""
PLACES = np.linspace(0.0, 1.0, 101)[:, None]
PROBE = 1e-6
"""Of the time between two rows, over which rates are taken."""
SHRUNK = 0.05
"""Part of the square of a gradient that is left along its tangent, below which it vanishes where a run failed."""
RESOLVED = 2.0
"""rad, by which a gradient may turn between two rows if what it does between them is to be known."""
LOOK = 1.0
"""rad, after which the run is looked at between samples that are farther apart."""
LOOKS = 2000
"""Most looks between two of them."""
TOGETHER = 16
"""Times of the run between which looks are planned at once: not as many as the clock lets blocks have, because the
integrator comes back at every look.
"""

REMEDY = (
    "Write it so that it does not become singular (a Distance in the place of a sum of squares), or end the run before "
    "by an event"
)


class _Row(NamedTuple):
    """t : s; values, rates : of each equation, (legs * 6,)."""

    t: float
    values: list[np.ndarray]
    rates: list[np.ndarray]


class Gradients:
    """Looks at the gradients of the user's equations at the rows of one phase, one after another."""

    def __init__(self, system):
        self.system, self.work = system, None
        self.numbers = [n for n, (_, kind) in enumerate(system.equation_owners) if isinstance(kind, Formula)]
        self.last: _Row | None = None
        self.until = 0
        """Number of the time from which on looks are not planned yet."""

    @property
    def reached(self) -> float:
        """Time of the last row that was looked at, s."""
        return -np.inf if self.last is None else self.last.t

    def look(self, rows: dict[str, Any]) -> None:
        """Raise IntegrationError if a gradient has vanished before one of these rows, since the row before."""
        if not self.numbers:
            return
        for k in range(len(rows["t"])):
            t = float(rows["t"][k])
            if self.last is not None and t <= self.last.t:
                continue
            span = t - self.last.t if self.last is not None else 1.0
            now = self._row(t, rows["q"][k], rows["u"][k], PROBE * span)
            if self.last is not None:
                self._compare(self.last, now)
            self.last = now

    def ending(self, outcome) -> Status | None:
        """Return why a run failed, if the gradient of an equation shrinks to nothing there, else None.

        Its square is followed from the last row along the tangent: ``x**2 + y**2 = R**2 - t`` has one that is linear
        in time, while x and y become infinitely fast and no row comes near the end.
        """
        if self.last is None or not outcome.reached > self.last.t:
            return None
        h = outcome.reached - self.last.t
        for number, value, rate in zip(self.numbers, self.last.values, self.last.rates, strict=True):
            square = float(value @ value)
            if square + 2.0 * h * float(value @ rate) < SHRUNK * square:
                title = self.system.joints[self.system.equation_owners[number][0]].title
                found = f"the gradient of its equation shrinks to nothing towards t = {outcome.reached:.6g} s"
                return Status.failed(f"{title}: {found}, where it restricts nothing; {outcome.failure}", REMEDY)
        return None

    def planned(self, times: np.ndarray, first: int) -> np.ndarray:
        """Return the times of a phase, with others as in `resolved` until `until`, which is beyond `first`."""
        if not self.numbers:
            self.until = len(times)
        if first < self.until:
            return times
        count = 1 if self.last is None else TOGETHER
        found = self.resolved(times, first, count)
        self.until = min(first + count, len(times)) + len(found) - len(times)
        return found

    def resolved(self, times: np.ndarray, first: int, count: int) -> np.ndarray:
        """Return increasing times with others before the next `count` ones from `first` on, at which gradients that
        turn as fast as at the last row have turned so little that they can be judged.
        """
        if self.last is None or not first:
            return times
        turning = max(map(_turning, self.last.values, self.last.rates))
        near = times[first - 1 : first + count]
        counts = np.diff(near) * turning / LOOK
        if not np.any((counts > 1.0) & (counts <= LOOKS)):
            return times
        counts = np.where(counts <= LOOKS, np.maximum(np.ceil(counts), 1.0), 1.0).astype(int)
        parts = [np.linspace(a, b, n + 1)[:-1] for a, b, n in zip(near[:-1], near[1:], counts, strict=True)]
        return np.concatenate([times[: first - 1], *parts, times[first + min(count, len(near) - 1) - 1 :]])

    def _row(self, t: float, q: np.ndarray, u: np.ndarray, probe: float) -> _Row:
        later = np.array(q, float)
        advance(self.system.program, np.ascontiguousarray(q), np.ascontiguousarray(u), probe, later)
        values, then = self._gradients(t, q, u), self._gradients(t + probe, later, u)
        return _Row(t, values, [(b - a) / probe for a, b in zip(values, then, strict=True)])

    def _gradients(self, t: float, q: np.ndarray, u: np.ndarray) -> list[np.ndarray]:
        if self.work is None:
            self.work = self.system.workspace()
            no_matrix(self.work.weights)
        evaluate(self.system.program, self.system.state(t, q, u), self.work)
        legs = self.work.legs
        return [legs["gradient"][legs["equation"] == n].ravel() for n in self.numbers]

    def _compare(self, one: _Row, two: _Row) -> None:
        h = two.t - one.t
        for k, number in enumerate(self.numbers):
            (a, b), (da, db) = (one.values[k], two.values[k]), (one.rates[k], two.rates[k])
            sizes = np.linalg.norm(a), np.linalg.norm(b)
            size = min(sizes)
            if size <= NOTHING * max(sizes):
                self._raise(number, one.t if sizes[0] < sizes[1] else two.t)
            turned = max(_turning(a, da), _turning(b, db)) * h
            if not turned < RESOLVED:
                continue
            s = PLACES
            between = (1 + 2 * s) * (1 - s) ** 2 * a + s * (1 - s) ** 2 * h * da
            between = between + s * s * (3 - 2 * s) * b - s * s * (1 - s) * h * db
            length = np.linalg.norm(between, axis=1)
            # the smallest of three neighbours and the line through them: places are a hundredth apart
            least = int(np.argmin(length))
            step = np.linalg.norm(np.diff(between, axis=0), axis=1).max()
            if length[least] < max(SMALL * size, 0.5 * step * (a @ b < 0.0)) and length[least] < 0.1 * size:
                self._raise(number, one.t + float(s[least, 0]) * h)

    def _raise(self, number: int, t: float) -> None:
        joint = self.system.joints[self.system.equation_owners[number][0]]
        raise IntegrationError(
            joint.title,
            found=f"the gradient of its equation vanishes near t = {t:.6g} s, where it restricts nothing",
            expected="an equation that changes with the motion at all times",
            remedy=REMEDY,
        )


def _turning(value: np.ndarray, rate: np.ndarray) -> float:
    """Return how fast a vector turns, rad/s."""
    square = float(value @ value)
    if square == 0.0:
        return np.inf
    across = rate - value * (value @ rate) / square
    return float(np.linalg.norm(across) / np.sqrt(square))
