"""Equations that a Python function computes, with all derivatives that `Formula` needs.

First derivatives come from the given Jacobian, or are exact by complex steps: f(z + i h) = f + i h f' with h so small
that nothing else is left (Squire & Trapp 1998). Second derivatives, along the motion and for the tangent, are
differences of first ones.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from flexmb.math.callbacks import callback

__all__ = ["FunctionOfScalars", "answer_size"]

TINY = 1e-30
"""Complex step, relative."""
STEP = 1e-3
"""Step of the differences of first derivatives, relative; of fourth order, their error is of the order of 1e-12."""
LOOK = 1e-6
"""Step of the differences by which a complex step is looked at."""
STENCIL = {-2: 1.0 / 12.0, -1: -8.0 / 12.0, 1: 8.0 / 12.0, 2: -1.0 / 12.0}


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
        h = STEP * max(1.0, abs(t))
        return sum(w * float(self.value(t + k * h, z)) for k, w in STENCIL.items()) / h

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

    def _look(self, t: float, z: np.ndarray, slopes: np.ndarray) -> None:
        """Raise ValueError where first derivatives contradict differences: a function that drops imaginary parts."""
        for k in range(self.n):
            h = LOOK * max(1.0, abs(z[k]))
            step = h * (np.arange(self.n) == k)
            difference = float(np.real(self.value(t, z + step)) - np.real(self.value(t, z - step))) / (2.0 * h)
            if abs(difference - slopes[k]) > 1e-4 * max(abs(difference), abs(slopes[k]), 1e-3):
                how = "its Jacobian" if self.jacobian else "a complex step"
                raise ValueError(
                    f"the derivative by argument {k} is {slopes[k]:.6g} by {how} and {difference:.6g} by a difference"
                    + ("" if self.jacobian else "; give jacobian=, or use functions that pass complex numbers")
                )
        self.looked = True

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
        slopes = self.by_scalars(t, z)
        if not self.looked:
            self._look(t, z, slopes)
        by_time, along = self.by_time(t, z), 0.0
        if self.level == 0:
            s = STEP * max(1.0, float(np.max(np.abs(z)))) / max(1.0, float(np.max(np.abs(rate), initial=0.0)))
            for k, weight in STENCIL.items():
                there, then = z + k * s * rate, t + k * s
                along += weight * (self.by_scalars(then, there) @ rate + self.by_time(then, there)) / s
            along += slopes @ jets[:, 2]
        twice = np.zeros((self.n, self.n))
        for k in range(self.n if second else 0):
            h = STEP * max(1.0, abs(z[k]))
            for m, weight in STENCIL.items():
                twice[k] += weight * self.by_scalars(t, z + m * h * (np.arange(self.n) == k)) / h
        value = float(np.real(self.value(t, z)))
        return np.concatenate(
            [[value, slopes @ rate + by_time, along, by_time], slopes, (0.5 * (twice + twice.T)).ravel()]
        )
