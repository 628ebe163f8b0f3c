"""`root_locus`: how the poles of a mechanism move with a parameter, and where one becomes unstable."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from flexmb.errors import ModelError
from flexmb.integrate.linear.linearize import linearize
from flexmb.model.described import finite_array
from flexmb.model.model import Model

__all__ = ["RootLocus", "root_locus"]

CLOSE = 1e-12
"""How close limits of stability are found, relative to the values around them."""


@dataclass(frozen=True, kw_only=True, eq=False)
class RootLocus:
    """Poles over a parameter; a column is one pole, followed to the nearest place from value to value.

    Parameters
    ----------
    values : (nv,)
        Of the parameter.
    poles : (nv, n), 1/s, complex
        Both of each conjugate pair.
    """

    values: np.ndarray
    poles: np.ndarray
    _poles: Callable[[float], np.ndarray] = field(repr=False)

    @property
    def stable(self) -> np.ndarray:
        """Does no motion grow, at each value? (nv,)."""
        return self.growth <= 0.0

    @property
    def growth(self) -> np.ndarray:
        """Largest real part at each value, (nv,), 1/s."""
        return self.poles.real.max(axis=1)

    def limits(self) -> list[float]:
        """Return the values at which a motion begins or ceases to grow, each found between two values by new models."""
        return [value for value, _ in self.crossings()]

    def crossings(self) -> tuple[tuple[float, complex], ...]:
        """Return these values, and the pole on the imaginary axis at each, 1/s, with a positive imaginary part."""
        return self._crossings

    @cached_property
    def _crossings(self) -> tuple[tuple[float, complex], ...]:
        free = int(np.min(np.sum(self.poles == 0.0, axis=1)))
        found, growth = [], np.array([_fastest(poles, free).real for poles in self.poles])
        for k in np.flatnonzero((growth[:-1] > 0.0) != (growth[1:] > 0.0)):
            passes = growth[k] * growth[k + 1] < 0.0
            value = self._limit(float(self.values[k]), float(self.values[k + 1]), passes, free)
            pole = _fastest(self._poles(value), free)
            found.append((value, complex(pole.real, abs(pole.imag))))
        return tuple(found)

    def _limit(self, a: float, b: float, passes: bool, free: int) -> float:
        """Return where growth begins or ends between two values: where it passes zero, or leaves it."""
        from scipy.optimize import brentq

        def growth(value: float) -> float:
            return _fastest(self._poles(value), free).real

        close = CLOSE * max(abs(a), abs(b))
        if passes:
            return float(brentq(growth, a, b, xtol=close, rtol=CLOSE))
        grows = growth(a) > 0.0
        while abs(b - a) > close:
            middle = 0.5 * (a + b)
            if (growth(middle) > 0.0) == grows:
                a = middle
            else:
                b = middle
        return b if grows else a


def _fastest(poles: np.ndarray, free: int) -> complex:
    """Return the pole that grows fastest; so many at zero belong to freedoms that nothing holds, at any value."""
    others = np.delete(poles, np.flatnonzero(poles == 0.0)[:free])
    return complex(others[np.argmax(others.real)]) if len(others) else 0j


def root_locus(model: Callable[[float], Model], values, about: Callable[[Model], Any] | None = None) -> RootLocus:
    """Return the poles of a model at the values of a parameter.

    Parameters
    ----------
    model : callable (value) -> Model
        ``lambda gain: arm(kp=gain)``.
    values : (nv,)
    about : callable (model) -> state, optional
        Such as `statics`; by default the assembled start at rest.

    Raises
    ------
    ModelError
        Values that are no finite numbers; models with different numbers of poles.
    """
    from scipy.optimize import linear_sum_assignment

    given = finite_array(values)
    if given.ndim != 1 or len(given) < 2 or not callable(model):
        raise ModelError(
            "root_locus",
            found=f"model = {model!r:.60}, values = {values!r:.60}",
            expected="a function that makes the model of a value, and two values or more",
            remedy="Write root_locus(lambda gain: arm(gain), np.linspace(0, 10, 21))",
        )

    def poles(value: float) -> np.ndarray:
        one = model(value)
        found = linearize(one, None if about is None else about(one)).eigenvalues
        return np.concatenate([found, found[found.imag > 0.0].conj()])

    rows = [poles(float(given[0]))]
    for value in given[1:]:
        now = poles(float(value))
        if len(now) != len(rows[0]):
            raise ModelError(
                "root_locus",
                found=f"{len(rows[0])} poles at {given[0]:g}, {len(now)} at {value:g}",
                expected="the same number at all values",
                remedy="Change numbers only, not the parts of the model; a gain of exactly zero may drop a state",
            )
        _, order = linear_sum_assignment(np.abs(rows[-1][:, None] - now[None, :]))
        rows.append(now[order])
    return RootLocus(values=given, poles=np.array(rows), _poles=poles)
