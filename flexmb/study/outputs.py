"""What a study keeps of a simulation: reductions of sensors over time, such as ``max(strut force fx)``."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from flexmb.errors import ModelError, did_you_mean
from flexmb.model.sensor_columns import columns_named, sensor_columns, titles_of, unknown

__all__ = ["REDUCTIONS", "Column", "columns"]

_FORM = re.compile(r"\s*(?:(?P<title>[^=()]*[^=()\s])\s*=)?\s*(?P<reduction>\w+)\s*\((?P<sensor>.+)\)\s*")
_USUAL = ("max", "min", "final")


def _mean(t: np.ndarray, y: np.ndarray) -> float:
    duration = t[-1] - t[0]
    return float(np.trapezoid(y, t) / duration if duration > 0.0 else y[-1])


def _rms(t: np.ndarray, y: np.ndarray) -> float:
    """Root of the mean square of the polygon through the samples, exact also where y changes sign."""
    duration = t[-1] - t[0]
    if duration == 0.0:
        return float(abs(y[-1]))
    squares = (y[:-1] ** 2 + y[:-1] * y[1:] + y[1:] ** 2) / 3.0
    return float(np.sqrt(np.sum(squares * np.diff(t)) / duration))


REDUCTIONS: dict[str, Callable[[np.ndarray, np.ndarray], float]] = {
    "max": lambda t, y: float(y.max()),
    "min": lambda t, y: float(y.min()),
    "peak": lambda t, y: float(np.abs(y).max()),
    "final": lambda t, y: float(y[-1]),
    "mean": _mean,
    "rms": _rms,
    "time_of_max": lambda t, y: float(t[y.argmax()]),
    "time_of_min": lambda t, y: float(t[y.argmin()]),
    "time_of_peak": lambda t, y: float(t[np.abs(y).argmax()]),
}
"""Name to f(t, y): ``peak`` is the largest magnitude; mean and rms refer to the polygon through the samples."""


class Column(NamedTuple):
    """One number of a study: a reduction of one component of a sensor."""

    title: str
    reduction: str
    sensor: str
    component: int

    def value(self, solution) -> float:
        """Return the number for a solution; NaN where the sensor never had a value."""
        values = np.asarray(solution[self.sensor], float).reshape(len(solution.t), -1)[:, self.component]
        there = np.isfinite(values)
        if not there.any():
            return float("nan")
        return REDUCTIONS[self.reduction](solution.t[there], values[there])


def columns(outputs: Sequence[str] | None, model) -> list[Column]:
    """Return the numbers that a study keeps of a model's simulation.

    Parameters
    ----------
    outputs : sequence of str, or None
        ``"max(strut force fx)"`` names one component, ``"max(strut force)"`` all of them; ``"load = peak(strut force
        fx)"`` gives the column a title. None keeps max, min and final of all sensors.
    model : Model

    Raises
    ------
    ModelError
        The model has no such sensor, or there is no such reduction.
    """
    parts = sensor_columns(titles_of(model))
    if outputs is None:
        outputs = [f"{reduction}({sensor.name})" for sensor in model.sensors for reduction in _USUAL]
    found = [column for text in outputs for column in _parsed(text, parts)]
    if not found:
        raise ModelError(
            f"Study of '{model.name}'",
            found="there is nothing to keep: the model has no sensor",
            expected="at least one sensor",
            remedy="Add [[sensor]] to the model",
        )
    titles = [column.title for column in found]
    twice = next((title for title in titles if titles.count(title) > 1), None)
    if twice is not None:
        raise ModelError(
            f"Output '{twice}'",
            found="two outputs have this title",
            expected="different titles",
            remedy='Give them titles: "largest = max(...)"',
        )
    return found


def _parsed(text: str, parts) -> list[Column]:
    form = _FORM.fullmatch(text) if isinstance(text, str) else None
    if form is None or form["reduction"] not in REDUCTIONS:
        near = did_you_mean(form["reduction"], REDUCTIONS) if form else ""
        raise ModelError(
            f"Output '{text}'",
            found=f"there is no reduction '{form['reduction']}'" if form else "no reduction and sensor",
            expected=f"REDUCTION(SENSOR) with one of: {', '.join(REDUCTIONS)}",
            remedy=near or 'Write "max(strut force fx)" or "load = peak(strut force fx)"',
        )
    asked = form["sensor"].strip()
    own = columns_named(asked, parts)
    if not own:
        said = unknown(asked, parts)
        raise ModelError(f"Output '{text}'", found=said.found, expected=said.expected, remedy=said.remedy)
    found = []
    for column in own:
        title = form["title"] or f"{form['reduction']}({column.name})"
        if form["title"] and len(own) > 1:
            title += f" {column.component}"
        unit = "s" if form["reduction"].startswith("time_of") else column.unit
        title = f"{title} [{unit}]" if unit else title
        found.append(Column(title, form["reduction"], column.sensor, column.number))
    return found
