"""How far the answers of two runs of one problem lie apart, sensor by sensor."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from flexmb.results import Solution

__all__ = ["Difference", "Quantity", "differences", "quantities", "turned_over"]

ROUNDING = 1e-9
"""Of the largest value of the same unit: what is less is rounding, and no answer."""
SAME = 1e-9
"""Times that differ by less, relative to the run, are one."""


class Quantity(NamedTuple):
    """The columns of one unit of a sensor: name, unit, (nt, k) values and times, and the largest value."""

    name: str
    unit: str
    t: np.ndarray
    values: np.ndarray
    largest: float


class Difference(NamedTuple):
    """Largest difference over time, and of the largest values, relative to the largest value of the answer."""

    course: float
    peak: float


def quantities(solution: Solution) -> list[Quantity]:
    """Return the answers of a run: its sensors, by unit; the places of the bodies if the model has no sensors.

    Errors of constraints are no answers, and columns that hold nothing but rounding are left out.
    """
    found = []
    for name, unit, values in _columns(solution):
        size = np.abs(values[np.isfinite(values)]).max(initial=0.0)
        if unit == "J":  # a sum that stays near zero is compared with what it is the sum of
            size = max(size, turned_over(solution))
        if size > 0.0:
            found.append(Quantity(name, unit, solution.t, values, float(size)))
    greatest: dict[str, float] = {}
    for quantity in found:
        greatest[quantity.unit] = max(greatest.get(quantity.unit, 0.0), quantity.largest)
    moments = greatest.get("N", 0.0) * _size(solution)
    greatest["N m"] = max(greatest.get("N m", 0.0), moments)
    return [quantity for quantity in found if quantity.largest > ROUNDING * greatest[quantity.unit]]


def turned_over(solution: Solution, number: int | None = None) -> float:
    """Return how much energy a run, or a phase of it, moves from one form to another, J."""
    numbers = range(len(solution.phases)) if number is None else (number,)
    found = [0.0]
    for k in numbers:
        series = solution.series(k)
        found += [np.ptp(series.energy, axis=0).max(), np.ptp(series.works, axis=0).max(), series.energy[:, 0].max()]
    return float(max(found))


def _columns(solution: Solution) -> Iterator[tuple[str, str, np.ndarray]]:
    kinds = {s.name: type(s).__name__ for phase in solution.phases if phase.model for s in phase.model.sensors}
    names = [name for name in solution.sensor_names if kinds.get(name) != "ConstraintError"]
    if not names:
        yield from _places(solution)
    for name in names:
        values = np.asarray(solution[name], float).reshape(len(solution.t), -1)
        units = [_unit(title) for title in solution.column_titles(name)]
        units += [""] * (values.shape[1] - len(units))
        for unit in dict.fromkeys(units):
            yield name, unit, values[:, [k for k, own in enumerate(units) if own == unit]]


def _unit(title: str) -> str:
    return title.rpartition("[")[2].rstrip("]") if "[" in title else ""


def _places(solution: Solution) -> Iterator[tuple[str, str, np.ndarray]]:
    for body in solution.model.bodies:
        lasts = all(any(other.name == body.name for other in p.model.bodies) for p in solution.phases)
        if body.n_velocities and lasts:
            found = [solution.series(k).coordinates(body.name)[0][:, :3] for k in range(len(solution.phases))]
            yield f"place of {body.name}", "m", np.concatenate(found)


def _size(solution: Solution) -> float:
    r = solution.series(0).observation.r
    return float(np.linalg.norm(np.ptp(r.reshape(-1, 3), axis=0))) if r.size else 1.0


def differences(solution: Solution, other: Solution) -> dict[tuple[str, str], Difference]:
    """Return how far another run is apart, by (sensor, unit).

    Times that both runs have are compared. Between the time of an event in one run and the time of the same event in
    the other, values belong to different models; they are left out.
    """
    theirs = {(name, unit): values for name, unit, values in _columns(other)}
    mine, yours = _common(solution, other)
    found = {}
    for quantity in quantities(solution):
        values = theirs.get((quantity.name, quantity.unit))
        if values is None or values.shape[1] != quantity.values.shape[1]:
            continue
        a, b = quantity.values[mine], values[yours]
        there = np.isfinite(a).all(axis=1) & np.isfinite(b).all(axis=1)
        if not there.any():
            continue
        a, b = a[there], b[there]
        apart = np.abs(a - b).max(axis=1)
        if quantity.values.shape[1] == 4 and quantity.unit == "":  # p and -p are one orientation
            apart = np.minimum(apart, np.abs(a + b).max(axis=1))
        peaks = [np.abs(x).max() for x in (a, b)]
        found[quantity.name, quantity.unit] = Difference(
            float(apart.max() / quantity.largest), float(abs(peaks[0] - peaks[1]) / quantity.largest)
        )
    return found


def _common(solution: Solution, other: Solution) -> tuple[np.ndarray, np.ndarray]:
    """Return the numbers of the samples at common times outside the shifts of events, in both runs."""
    t, s = solution.t, other.t
    near = SAME * max(abs(t[0]), abs(t[-1]), t[-1] - t[0])
    place = np.clip(np.searchsorted(s, t - near), 0, len(s) - 1)
    both = np.abs(s[place] - t) <= near
    events = [[float(p.t[-1]) for p in run.phases[:-1]] for run in (solution, other)]
    for a, b in zip(*events):
        both &= ~((t >= min(a, b) - near) & (t <= max(a, b) + near))
    mine = np.flatnonzero(both)
    return mine, place[mine]
