"""Equations that a Python function computes, with all derivatives that `Formula` needs.

First derivatives by scalars come from the given Jacobian, or are exact by complex steps: f(z + i h) = f + i h f' with h
so small that nothing else is left (Squire & Trapp 1998). That by time is a complex step too, wherever the function
passes a complex time. Second derivatives, along the motion and for the tangent, are differences of fourth order of
these, with steps of about 1e-5 m, rad or s, whatever the place and the time are: a function of the wave number or
frequency k has an error of (1e-5 k)^4 / 30 of its own, and rounding leaves about 1e-10. Only beside a Jacobian, of a
function that passes no complex time, are derivatives by time differences of values, of sixth order with steps of
2e-4 s: errors (2e-4 k)^6 / 140, and rounding of 1e-8 of its terms per s2.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from flexmb.math.callbacks import callback

__all__ = ["FunctionOfScalars", "answer_size"]

TINY = 1e-30
"""Complex step, relative."""
STEP = 2.0**-17
"""Step of the differences of first derivatives, m, rad or s; a power of two, so that times differ by it exactly."""
TIME_STEP = 2.0**-12
"""Step, s, of differences of values by time."""
LOOK = 1e-6
"""Step of the differences by which derivatives are looked at, m, rad or s."""
ASIDE = 1e-3
"""How far from the first point they are looked at again, m, rad or s: at zero the slope of a square says nothing."""
STENCIL = {-2: 1.0 / 12.0, -1: -8.0 / 12.0, 1: 8.0 / 12.0, 2: -1.0 / 12.0}
FIRST = {1: 0.75, 2: -0.15, 3: 1.0 / 60.0}
"""Of f(t + k h) - f(t - k h): the first derivative, of sixth order."""
SECOND = {1: 1.5, 2: -0.15, 3: 1.0 / 90.0}
"""Of f(t + k h) - 2 f(t) + f(t - k h): the second one."""


def answer_size(n: int) -> int:
    """Return how many numbers the C function returns for n scalars."""
    return 4 + n + n * n


class FunctionOfScalars:
    """The C function of an equation f(t, x) of positions, or f(t, x, v) of positions and velocities.

    It takes t, whether second derivatives are wanted, and the jets of all scalars (n, 3), and returns f, its first and
    second derivative along the motion, its derivative by explicit time along the signals, by every scalar, and by
    every two (n, n). What goes wrong is kept in `failure`, because no exception can pass through compiled code.

    Parameters
    ----------
    function, jacobian : callable; jacobian may be None
    positions : int
        How many of the scalars are positions; they come first.
    n : int
    level : int
    """

    def __init__(self, function: Any, jacobian: Any, positions: int, n: int, level: int):
        self.function, self.jacobian, self.positions, self.n, self.level = function, jacobian, positions, n, level
        self.failure, self.looked = "", False
        self.passes_complex_time = True
        self.pointer, self.address = callback(self._run)

    def _split(self, z):
        return (z[: self.positions], z[self.positions :]) if self.level else (z,)

    def value(self, t, z):
        """Return f, a real or complex number."""
        return self.function(t, *self._split(z))

    def by_time(self, t: float, z: np.ndarray) -> float:
        """Return df/dt at scalars that stay."""
        if self.jacobian is None:
            return float(np.imag(self.value(t + 1j * TINY, z.astype(complex)))) / TINY
        if self.passes_complex_time:
            found = self.value(t + 1j * TINY, z)
            if np.iscomplexobj(found):  # or it does not depend on time, or drops imaginary parts
                return float(np.imag(found)) / TINY
        h = TIME_STEP
        return sum(w * self._real(t + k * h, z) - w * self._real(t - k * h, z) for k, w in FIRST.items()) / h

    def _real(self, t: float, z: np.ndarray) -> float:
        return float(np.real(self.value(t, z)))

    def along(self, t: float, z: np.ndarray, rate: np.ndarray) -> float:
        """Return the second derivative along z + s rate and t + s."""
        s = STEP * 2.0 ** -np.ceil(np.log2(max(1.0, float(np.max(np.abs(rate), initial=0.0)))))
        places = [(t + k * s, z + k * s * rate, weight / s) for k, weight in STENCIL.items()]
        if self.jacobian is None:
            step = TINY / max(1.0, float(np.max(np.abs(rate), initial=0.0)))
            return sum(
                weight * float(np.imag(self.value(then + 1j * step, there + 1j * step * rate))) / step
                for then, there, weight in places
            )
        found = sum(weight * float(self.by_scalars(then, there) @ rate) for then, there, weight in places)
        if self.passes_complex_time and np.iscomplexobj(self.value(t + 1j * TINY, z)):
            return found + sum(weight * self.by_time(then, there) for then, there, weight in places)
        # f_tz rate, of the Jacobian; f_tt, of values
        found += sum(w * float(self.by_scalars(t + k * STEP, z) @ rate) for k, w in STENCIL.items()) / STEP
        h, now = TIME_STEP, self._real(t, z)
        ends = {k: self._real(t + k * h, z) - 2.0 * now + self._real(t - k * h, z) for k in SECOND}
        return found + sum(w * ends[k] for k, w in SECOND.items()) / h**2

    def by_scalars(self, t: float, z: np.ndarray) -> np.ndarray:
        """Return df/dz (n,)."""
        if self.jacobian is not None:
            return np.array(self.jacobian(t, *self._split(z)), float).reshape(self.n)
        found, moved = np.empty(self.n), z.astype(complex)
        for k in range(self.n):
            h = TINY * max(1.0, abs(z[k]))
            moved[k] += 1j * h
            found[k] = np.imag(self.value(t, moved)) / h
            moved[k] = z[k]
        return found

    def _look(self, t: float, z: np.ndarray) -> None:
        """Raise ValueError where first derivatives contradict differences: a function that drops imaginary parts.

        At the first point, and to both sides of it, where the function may have no value.
        """
        try:
            self.by_time(t, z)
        except Exception:  # whatever a user's function raises that takes real times only
            if self.jacobian is None:
                raise
            self.passes_complex_time = False
        self._compare(t, z)
        aside = ASIDE * (1.0 + np.arange(self.n) / (self.n + 1.0))
        for side in (1.0, -1.0):
            with np.errstate(all="ignore"):
                try:
                    there = self._real(t + side * ASIDE, z + side * aside)
                    slopes = self.by_scalars(t + side * ASIDE, z + side * aside)
                except Exception:  # beyond the end of what the function knows
                    continue
                if np.isfinite(there) and np.all(np.isfinite(slopes)):
                    self._compare(t + side * ASIDE, z + side * aside)
        self.looked = True

    def _compare(self, t: float, z: np.ndarray) -> None:
        """Raise ValueError if derivatives at a point contradict differences."""
        slopes, how = self.by_scalars(t, z), "its Jacobian" if self.jacobian else "a complex step"
        terms = abs(self._real(t, z)) + float(np.abs(slopes) @ np.abs(z))
        for k in range(self.n):
            step = LOOK * (np.arange(self.n) == k)
            difference = (self._real(t, z + step) - self._real(t, z - step)) / (2.0 * LOOK)
            if _contradict(difference, slopes[k], terms):
                raise ValueError(
                    f"the derivative by argument {k} is {slopes[k]:.6g} by {how} and {difference:.6g} by a difference"
                    + ("" if self.jacobian else "; give jacobian=, or use functions that pass complex numbers")
                )
        by_time = self.by_time(t, z)
        difference = (self._real(t + LOOK, z) - self._real(t - LOOK, z)) / (2.0 * LOOK)
        if not _contradict(difference, by_time, terms):
            return
        if self.jacobian is None or not self.passes_complex_time:
            raise ValueError(
                f"the derivative by time is {by_time:.6g} by {how if self.jacobian is None else 'steps of 2e-4 s'} and "
                f"{difference:.6g} by a shorter difference; "
                + ("give jacobian=, or use functions that pass complex numbers" if self.jacobian is None else "")
                + ("" if self.jacobian is None else "write the function so that it passes a complex t")
            )
        self.passes_complex_time = False
        self._compare(t, z)

    def _run(self, inputs, outputs) -> None:
        given = np.ctypeslib.as_array(inputs, (2 + 3 * self.n,)).copy()
        out = np.ctypeslib.as_array(outputs, (answer_size(self.n),))
        try:
            out[:] = self.derivatives(float(given[0]), given[2:].reshape(self.n, 3), bool(given[1]))
            if not np.all(np.isfinite(out)):
                self.failure = self.failure or f"it has no finite value or derivative at t = {given[0]:.6g} s"
        except Exception as error:  # whatever a user's function raises: it cannot pass through compiled code
            self.failure = self.failure or f"{type(error).__name__}: {error} at t = {given[0]:.6g} s"
            out[:] = np.nan

    def derivatives(self, t: float, jets: np.ndarray, second: bool) -> np.ndarray:
        """Return what the C function returns, at the jets (n, 3) of the scalars."""
        z, rate = jets[:, 0], jets[:, 1]
        if not self.looked:
            self._look(t, z)
        slopes, by_time, along = self.by_scalars(t, z), self.by_time(t, z), 0.0
        if self.level == 0:
            along = self.along(t, z, rate) + float(slopes @ jets[:, 2])
        twice = np.zeros((self.n, self.n))
        for k in range(self.n if second else 0):
            for m, weight in STENCIL.items():
                twice[k] += weight * self.by_scalars(t, z + m * STEP * (np.arange(self.n) == k)) / STEP
        value = float(np.real(self.value(t, z)))
        return np.concatenate(
            [[value, slopes @ rate + by_time, along, by_time], slopes, (0.5 * (twice + twice.T)).ravel()]
        )


def _contradict(difference: float, found: float, terms: float) -> bool:
    """Do a central difference and a derivative differ by more than errors of the difference? `terms` is their size."""
    rounding = 8.0 * np.finfo(float).eps * terms / LOOK
    return bool(abs(difference - found) > 1e-4 * max(abs(difference), abs(found), 1e-3) + rounding)
