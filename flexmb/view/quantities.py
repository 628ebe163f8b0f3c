"""Numbers as a page shows them: units an engineer reads, columns that are zero left out."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

__all__ = ["Shown", "number", "scaled", "shown_columns", "sizes"]

ZERO = 1e-5  # of the largest component of a sensor: what is less cannot be seen beside it
_LARGE = {"N": ("kN", 1e3), "N m": ("kN m", 1e3), "J": ("kJ", 1e3), "Pa": ("MPa", 1e6)}
_FROM = {"N": 1e3, "N m": 1e3, "J": 1e3, "Pa": 1e5}


class Shown(NamedTuple):
    """One column of a sensor: title without unit, unit, values (nt,) in this unit."""

    title: str
    unit: str
    values: np.ndarray


def scaled(unit: str, largest: float) -> tuple[float, str]:
    """Return (factor, unit) in which a quantity up to `largest` (SI) is shown: kN, MPa, deg, mm."""
    if unit in _LARGE and largest >= _FROM[unit]:
        name, size = _LARGE[unit]
        return 1.0 / size, name
    if unit in ("rad", "rad/s"):
        return 180.0 / np.pi, unit.replace("rad", "deg")
    if unit == "m" and 0.0 < largest < 0.05:
        return 1e3, "mm"
    return 1.0, unit


def sizes(solutions: Sequence, name: str) -> dict[str, float]:
    """Return unit -> largest magnitude (SI) of a sensor's columns over several solutions."""
    found: dict[str, float] = {}
    for solution in solutions:
        if name in solution.sensor_names:
            for _, unit, column in _columns(solution, name):
                found[unit] = max(found.get(unit, 0.0), float(np.nanmax(np.abs(column), initial=0.0)))
    return found


def shown_columns(solution, name: str, largest: Mapping[str, float] | None = None) -> list[Shown]:
    """Return the columns of a sensor that are not zero throughout; of one that is zero altogether the first.

    `largest`, from `sizes`, gives several solutions the same units.
    """
    largest = sizes([solution], name) if largest is None else largest
    columns = _columns(solution, name)
    known = {entry[1]: largest[entry[1]] for entry in columns}
    size = max(known.values(), default=0.0)
    kept = [entry for entry in columns if np.nanmax(np.abs(entry[2]), initial=0.0) > ZERO * size] or columns[:1]
    shown = []
    for label, unit, column in kept:
        factor, name_of_unit = scaled(unit, known[unit])
        shown.append(Shown(label if len(columns) > 1 else "", name_of_unit, factor * column))
    return shown


def _columns(solution, name: str) -> list[tuple[str, str, np.ndarray]]:
    """Return (label, unit, values) of all columns of a sensor."""
    values = np.asarray(solution[name], float).reshape(len(solution.t), -1)
    titles = [str(title).partition("[") for title in solution.column_titles(name)]
    return [(label.strip(), unit.rstrip("]"), column) for (label, _, unit), column in zip(titles, values.T)]


def number(x: float, beside: float = 0.0) -> str:
    """Return four digits, without an exponent where a reader does not need one; "0" for what is rounding `beside`."""
    if not np.isfinite(x):
        return "-"
    if x == 0.0 or abs(x) < 1e-6 * beside:
        return "0"
    size = abs(x)
    if 1e-3 <= size < 1e6:
        digits = max(0, 3 - int(np.floor(np.log10(size))))
        return f"{x:.{digits}f}"
    return f"{x:.3e}"
