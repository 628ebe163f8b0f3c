"""`table`: a signal through given points."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar

import numpy as np

from flexmb.errors import ModelError
from flexmb.math import operations as op
from flexmb.model.expression import SignalProgram
from flexmb.model.input_signal import Input
from flexmb.model.signal import Constant, Expression, Product, Signal, Sum, as_signal
from flexmb.model.simple_signals import Harmonic, Ramp, Step
from flexmb.told import tell

__all__ = ["SIGNALS", "Table", "table"]

SWINGS, LEAVES = 0.5, 10.0
"""How far a spline may go beyond its points, relative to their range, before it warns, and before it is refused.

Sparse points of a smooth function give up to 0.4; a ramp of three or four points between constants gives more.
"""
ROUNDING = 1e-6
"""Range of points, relative to the largest, below which they are one constant."""


@dataclass(frozen=True, eq=False)
class Table(Signal):
    """A function through points; its first and last values are held outside, or it goes on periodically.

    Parameters
    ----------
    x : (n,) increasing
        Time in s, or values of the signal `of`. In a model file ``file = "load.csv", columns = ["t", "F"]`` stands for
        x and y that are in a text file; in Python `flexmb.io.read_columns` reads them.
    y : (n,)
    of : signal or joint's name, optional
        Argument of the function; time unless given. An airload over flap angle is a table of the angle's signal, or of
        the joint whose angle it is: such a table can be a component of a `PointLoad`, the amount of a `Pressure` or the
        effort of an `Actuator`.
    kind : "cubic" or "linear"
        Cubic: the spline with two continuous derivatives and not-a-knot ends (de Boor, A Practical Guide to Splines,
        chapter IV), which reproduces cubic polynomials exactly. Three points give the parabola, two the line. Where
        steep and gentle slopes meet it swings beyond its points: by more than half of their range warns, by more than
        ten times is an error.
    periodic : bool
        The function goes on with the period from the first x to the last, where y must be the same: a gas force over
        the crank angle. The cubic spline is smooth there too.
    """

    x: tuple[float, ...]
    y: tuple[float, ...]
    of: Any = None
    kind: str = "cubic"
    periodic: bool = False
    word: ClassVar[str] = "table"

    def __post_init__(self):
        for name in ("x", "y"):
            try:
                points = np.asarray(getattr(self, name), float)
            except (TypeError, ValueError, OverflowError):
                points = np.empty(0)
            found = "no list of numbers" if points.size == 0 else f"the shape {points.shape}"
            if points.ndim == 1 and points.size >= 2 and not np.all(np.isfinite(points)):
                wrong = int(np.argmin(np.isfinite(points)))
                found = f"the entry {points[wrong]} at place {wrong} (counted from 0)"
            if points.ndim != 1 or points.size < 2 or not np.all(np.isfinite(points)):
                raise ModelError(
                    "Signal table",
                    found=f"{name} has {found}",
                    expected="two or more finite numbers",
                    remedy=f"Write {name} = [0.0, 1.0]",
                )
            object.__setattr__(self, name, tuple(points.tolist()))
        if len(self.x) != len(self.y):
            raise ModelError(
                "Signal table",
                found=f"{len(self.x)} values x and {len(self.y)} values y",
                expected="as many x as y",
                remedy="Give each x its y",
            )
        steps = np.diff(self.x)
        if steps.min() <= 0.0:
            k = int(np.argmin(steps > 0.0))
            raise ModelError(
                "Signal table",
                found=f"x goes from {self.x[k]} to {self.x[k + 1]}",
                expected="increasing x",
                remedy="Sort the points by x and remove repeated ones",
            )
        self._require("kind", self.kind in ("cubic", "linear"), "'cubic' or 'linear'")
        self._require("periodic", isinstance(self.periodic, bool), "true or false")
        if self.periodic and self.y[0] != self.y[-1]:
            raise ModelError(
                "Signal table",
                found=f"a periodic table with y = {self.y[0]:g} at its begin and {self.y[-1]:g} at its end",
                expected="the same value at both, where a period begins and ends",
                remedy="Repeat the first value one period after the first x",
            )
        if self.of is not None and self.joint is None:
            object.__setattr__(self, "of", as_signal(self.of, "Signal table", "of"))
            self._require_extent()
        if self.kind == "cubic":
            self._look_for_swings()

    def __repr__(self):
        of = "" if self.of is None else f", of {self.of!r}"
        return (
            f"Table({len(self.x)} points, x {self.x[0]:.4g} to {self.x[-1]:.4g}, y {min(self.y):.4g} to "
            f"{max(self.y):.4g}, {self.kind}{of})"
        )

    def _look_for_swings(self) -> None:
        """Warn of a spline that goes far beyond its points, or raise ModelError.

        Source of the extremes: the derivative of a piece, 3 a h^2 + 2 b h + c = 0.
        """
        x, y = np.array(self.x), np.array(self.y)
        with np.errstate(all="ignore"):
            a, b, c, d = self._coefficients().T
            root = np.sqrt(b * b - 3.0 * a * c)
            places = np.array([c / (-b - root), c / (root - b)])  # without cancellation where a vanishes
            values = ((a * places + b) * places + c) * places + d
        values = np.where((places > 0.0) & (places < np.diff(x)), values, y[:-1])
        beyond = np.maximum(values - y.max(), y.min() - values)
        side, k = np.unravel_index(np.argmax(beyond), beyond.shape)
        across = max(np.ptp(y), ROUNDING * np.abs(y).max())
        if not beyond[side, k] > SWINGS * across:
            return
        complaint = ModelError(
            "Signal table",
            found=f"between x = {x[k]:.6g} and {x[k + 1]:.6g} its cubic spline reaches {values[side, k]:.4g}, "
            f"but its points go from {y.min():.4g} to {y.max():.4g}",
            expected="a curve that stays near its points",
            remedy="Write kind='linear', give more points where the slope changes, or use fmb.step or fmb.ramp",
        )
        if beyond[side, k] > LEAVES * across:
            raise complaint
        tell(str(complaint))

    @property
    def joint(self) -> str | None:
        """Name of the joint whose coordinate is the argument, if it is one."""
        return self.of if isinstance(self.of, str) and not self.of.lstrip().startswith("=") else None

    @cached_property
    def extent(self) -> tuple[int, int]:
        operations, depth = self.of.extent if isinstance(self.of, Signal) else (1, 0)
        return operations + 1, depth + 1

    def numbers(self) -> np.ndarray:
        """Return number of knots, knots, and coefficients, as `flexmb.math.jets.interpolate` reads them."""
        count = -len(self.x) if self.periodic else len(self.x)
        return np.concatenate([[count], self.x, self._coefficients().ravel()])

    def program(self) -> SignalProgram:
        if self.joint is not None:
            raise ModelError(
                "Signal table",
                found=f"it is a table over the coordinate of joint '{self.joint}'",
                expected="a function of time",
                remedy="PointLoad, Pressure and Actuator may depend on a joint, by a table alone or times a signal",
            )
        return super().program()

    def parts(self) -> tuple[Signal, ...]:
        return () if self.of is None or self.joint is not None else (self.of,)

    def program_of(self, parts):
        argument = parts[0] if parts else SignalProgram.of((op.TIME, 0.0))
        return argument.then(SignalProgram.of((op.TABLE, 0.0), tables=(self.numbers(),)))

    def _coefficients(self) -> np.ndarray:
        """Coefficients of x^3 ... x^0 of each piece, (n - 1, 4)."""
        x, y = np.array(self.x), np.array(self.y)
        with np.errstate(over="ignore", invalid="ignore"):
            slopes = np.diff(y) / np.diff(x)
            found = np.column_stack([np.zeros((len(slopes), 2)), slopes, y[:-1]])
            if self.kind == "cubic" and np.isfinite(slopes).all():
                found = _spline(x, y, "periodic" if self.periodic and len(x) > 2 else "not-a-knot")
        if not np.isfinite(found).all():
            raise ModelError(
                "Signal table",
                found=f"x from {x[0]:g} to {x[-1]:g} with gaps from {np.diff(x).min():g}, "
                f"y from {y.min():g} to {y.max():g}, whose slopes no number of 64 bits can hold",
                expected="slopes and curvatures below 1e308",
                remedy="Check the exponents of the points",
            )
        return found


def _spline(x: np.ndarray, y: np.ndarray, ends: str) -> np.ndarray:
    """Return the coefficients of the cubic spline, not a number where they are too large."""
    from scipy.interpolate import CubicSpline

    try:
        return CubicSpline(x, y, bc_type=ends).c.T.copy()
    except ValueError:  # scipy refuses what overflows on the way
        return np.full((len(x) - 1, 4), np.nan)


def table(x, y, of: Any = None, kind: str = "cubic", periodic: bool = False) -> Table:
    """Return the function through the points (x, y) of time or of another signal."""
    return Table(x, y, of, kind, periodic)


SIGNALS: dict[str, type[Signal]] = {
    kind.word: kind for kind in (Constant, Input, Ramp, Step, Harmonic, Table, Expression, Sum, Product)
}
"""Kinds of signals of time by the word that makes them."""
