"""`table2`: a signal over two others through given points."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar

import numpy as np

from flexmb.errors import ModelError
from flexmb.math import operations as op
from flexmb.model.described import finite_array
from flexmb.model.expression import SignalProgram
from flexmb.model.signal import Signal, as_signal

__all__ = ["Table2", "table2"]


@dataclass(frozen=True, eq=False)
class Table2(Signal):
    """A function of two signals through points of a grid; its values at the edges are held outside.

    Parameters
    ----------
    x : (n,) increasing
        Values of the first signal.
    y : (m,) increasing
        Values of the second signal.
    z : (n, m)
        Row i has the values at x[i].
    of : (signal, signal)
        The arguments: airload over flap angle and speed, torque over speed and throttle.
    kind : "cubic" or "linear"
        Cubic: splines with not-a-knot ends along both (de Boor, A Practical Guide to Splines, chapter XVII), which
        reproduce products of cubic polynomials exactly. Linear: bilinear between four points.
    """

    x: tuple[float, ...]
    y: tuple[float, ...]
    z: tuple[tuple[float, ...], ...]
    of: tuple[Any, Any]
    kind: str = "cubic"
    word: ClassVar[str] = "table2"

    def __post_init__(self):
        for name in ("x", "y"):
            points = finite_array(getattr(self, name))
            if points.ndim != 1 or len(points) < 2 or not np.all(np.diff(points) > 0.0):
                raise ModelError(
                    "Signal table2",
                    found=f"{name} = {getattr(self, name)!r:.80}",
                    expected="two or more finite numbers that increase",
                    remedy=f"Write {name} = [0.0, 1.0]",
                )
            object.__setattr__(self, name, tuple(points.tolist()))
        values = finite_array(self.z)
        if values.shape != (len(self.x), len(self.y)):
            raise ModelError(
                "Signal table2",
                found=f"z of the shape {values.shape}" if values.size else "z without finite numbers",
                expected=f"({len(self.x)}, {len(self.y)}): a row for each x, a column for each y",
                remedy="Give one number for every point of the grid",
            )
        object.__setattr__(self, "z", tuple(map(tuple, values.tolist())))
        self._require("kind", self.kind in ("cubic", "linear"), "'cubic' or 'linear'")
        if not isinstance(self.of, list | tuple) or len(self.of) != 2:
            raise ModelError(
                "Signal table2", found=f"of = {self.of!r:.80}", expected="two signals", remedy="Write of=(angle, speed)"
            )
        object.__setattr__(self, "of", tuple(as_signal(one, "Signal table2", "of") for one in self.of))
        self._require_extent()

    def __repr__(self):
        return f"Table2({len(self.x)} x {len(self.y)} points, {self.kind}, of {self.of!r})"

    @cached_property
    def extent(self) -> tuple[int, int]:
        return sum(one.extent[0] for one in self.of) + 1, 1 + max(one.extent[1] for one in self.of)

    def parts(self) -> tuple[Signal, ...]:
        return self.of

    def program_of(self, parts):
        return parts[0].then(parts[1], SignalProgram.of((op.TABLE2, 0.0), tables=(self.numbers(),)))

    def numbers(self) -> np.ndarray:
        """Return counts, knots and coefficients, as `flexmb.math.grids.interpolate_grid` reads them."""
        x, y, z = np.array(self.x), np.array(self.y), np.array(self.z)
        along_y = _pieces(y, z.T, self.kind)  # (4, m - 1, n)
        both = _pieces(x, along_y.transpose(2, 0, 1), self.kind)  # (4, n - 1, 4, m - 1)
        return np.concatenate([[len(x), len(y)], x, y, both.transpose(1, 3, 0, 2).ravel()])


def _pieces(x: np.ndarray, y: np.ndarray, kind: str) -> np.ndarray:
    """Return the coefficients (4, n - 1, ...) of x^3 to x^0 of the pieces through y (n, ...)."""
    if kind == "cubic":
        from scipy.interpolate import CubicSpline

        return CubicSpline(x, y, axis=0, bc_type="not-a-knot").c
    slopes = np.diff(y, axis=0) / np.diff(x).reshape(-1, *[1] * (y.ndim - 1))
    return np.stack([0.0 * slopes, 0.0 * slopes, slopes, y[:-1]])


def table2(x, y, z, of: tuple[Any, Any], kind: str = "cubic") -> Table2:
    """Return the function of two signals through the points (x[i], y[j], z[i][j])."""
    return Table2(x, y, z, of, kind)
