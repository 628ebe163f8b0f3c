"""How far the answers of two runs of one problem lie apart, sensor by sensor."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from flexmb.results import Solution

__all__ = ["Difference", "Quantity", "column_scales", "differences", "quantities", "turned_over"]

ROUNDING = 1e-9
"""Of the largest value of the same unit: what is less is rounding, and no answer."""
PLACE = 1e-5
"""Of the largest place or angle, whose zero is a choice: a smaller motion counts as this much of one."""
RIPPLE = 1e-3
"""Of the largest value of another unit, whose zero has a meaning: a smaller ripple counts as this much of one."""
ASIDE = 1e-3
"""Of the largest variation among the columns: a component that varies less counts as this much of it."""
EULER = 4
"""Columns without unit that are the Euler parameters of an orientation."""
SAME = 1e-9
"""Times that differ by less, relative to the run, are one."""


class Quantity(NamedTuple):
    """The columns of one unit of a sensor: name, unit, (nt,) times, (nt, k) values, and the largest value.

    `titles` (k) are the columns' names; `scales` (k,) is what differences of each are measured against, in the unit.
    """

    name: str
    unit: str
    t: np.ndarray
    values: np.ndarray
    largest: float
    titles: tuple[str, ...]
    scales: np.ndarray


class Difference(NamedTuple):
    """Largest difference over time, and of the largest values, as shares; the column that is furthest apart.

    Every column is compared with its own scale, which is given with its title.
    """

    course: float
    peak: float
    title: str
    scale: float


def quantities(solution: Solution) -> list[Quantity]:
    """Return the answers of a run: its sensors, by unit; the places of the bodies if the model has no sensors.

    Errors of constraints are no answers, and columns that hold nothing but rounding are left out.
    """
    found = []
    slow = _slow(solution)
    for name, unit, titles, values in _columns(solution):
        size = float(np.abs(values[np.isfinite(values)]).max(initial=0.0))
        scales = np.maximum(column_scales(values, unit), slow.get(unit, 0.0))
        if unit == "J":  # a sum that stays near zero is compared with what it is the sum of
            turned = turned_over(solution)
            size, scales = max(size, turned), np.maximum(scales, turned)
        if size > 0.0:
            found.append(Quantity(name, unit, solution.t, values, size, titles, scales))
    greatest: dict[str, float] = {}
    for quantity in found:
        greatest[quantity.unit] = max(greatest.get(quantity.unit, 0.0), quantity.largest)
    moments = greatest.get("N", 0.0) * _size(solution)
    greatest["N m"] = max(greatest.get("N m", 0.0), moments)
    return [quantity for quantity in found if quantity.largest > ROUNDING * greatest[quantity.unit]]


def column_scales(values: np.ndarray, unit: str) -> np.ndarray:
    """Return what the differences of each column are measured against, (k,).

    It is what the column varies by over the run, peak to peak, or its largest value where that is smaller: a deflection
    of 2 mm is no small part of a place 0.4 m from the origin. Two floors keep rounding from being an answer. Components
    that a symmetry holds at zero vary by rounding only, so the floor is a share of what the other components vary by.
    An answer that stands still varies by what the integrator tolerates, so the floor is a share of its value.
    The four Euler parameters of an orientation have one scale, as none of them has a meaning of its own.
    """
    known = np.where(np.isfinite(values), values, np.nan)
    there = np.isfinite(values).any(axis=0)
    low, high = np.zeros(len(there)), np.zeros(len(there))
    low[there], high[there] = np.nanmin(known[:, there], axis=0), np.nanmax(known[:, there], axis=0)
    sizes, spans = np.maximum(np.abs(low), np.abs(high)), high - low
    largest, widest = sizes.max(initial=0.0), spans.max(initial=0.0)
    if len(there) == EULER and unit == "":
        sizes, spans = np.full(EULER, largest), np.full(EULER, widest)
    still = (PLACE if unit in ("m", "rad", "") else RIPPLE) * largest
    return np.maximum(np.minimum(sizes, spans), max(still, ASIDE * min(widest, largest)))


def _slow(solution: Solution) -> dict[str, float]:
    """Return speeds that would not move anything by more than `PLACE` in the whole run: the model is at rest."""
    duration = float(solution.t[-1] - solution.t[0])
    if duration <= 0.0:
        return {}
    reach = float(np.abs(solution.series(0).observation.r).max(initial=0.0))
    return {"m/s": PLACE * reach / duration, "rad/s": PLACE / duration}


def turned_over(solution: Solution, number: int | None = None) -> float:
    """Return how much energy a run, or a phase of it, moves from one form to another, J."""
    numbers = range(len(solution.phases)) if number is None else (number,)
    found = [0.0]
    for k in numbers:
        series = solution.series(k)
        found += [np.ptp(series.energy, axis=0).max(), np.ptp(series.works, axis=0).max(), series.energy[:, 0].max()]
    return float(max(found))


def _columns(solution: Solution) -> Iterator[tuple[str, str, tuple[str, ...], np.ndarray]]:
    """Yield sensor, unit, titles without unit (k) and values (nt, k)."""
    kinds = {s.name: type(s).__name__ for phase in solution.phases if phase.model for s in phase.model.sensors}
    names = [name for name in solution.sensor_names if kinds.get(name) != "ConstraintError"]
    if not names:
        yield from _places(solution)
    for name in names:
        values = np.asarray(solution[name], float).reshape(len(solution.t), -1)
        titles = list(solution.column_titles(name))
        titles += [""] * (values.shape[1] - len(titles))
        units = [_unit(title) for title in titles]
        for unit in dict.fromkeys(units):
            own = [k for k, other in enumerate(units) if other == unit]
            yield name, unit, tuple(titles[k].partition("[")[0].strip() for k in own), values[:, own]


def _unit(title: str) -> str:
    return title.rpartition("[")[2].rstrip("]") if "[" in title else ""


def _places(solution: Solution) -> Iterator[tuple[str, str, tuple[str, ...], np.ndarray]]:
    for body in solution.model.bodies:
        lasts = all(any(other.name == body.name for other in p.model.bodies) for p in solution.phases)
        if body.n_velocities and lasts:
            found = [solution.series(k).coordinates(body.name)[0][:, :3] for k in range(len(solution.phases))]
            yield f"place of {body.name}", "m", ("x", "y", "z"), np.concatenate(found)


def _size(solution: Solution) -> float:
    r = solution.series(0).observation.r
    return float(np.linalg.norm(np.ptp(r.reshape(-1, 3), axis=0))) if r.size else 1.0


def differences(solution: Solution, other: Solution) -> dict[tuple[str, str], Difference]:
    """Return how far another run is apart, by (sensor, unit).

    Times that both runs have are compared. Between the time of an event in one run and the time of the same event in
    the other, values belong to different models; they are left out.
    """
    theirs = {(name, unit): values for name, unit, _, values in _columns(other)}
    mine, yours = _common(solution, other)
    found = {}
    for quantity in quantities(solution):
        values = theirs.get((quantity.name, quantity.unit))
        if values is None or values.shape != (len(other.t), quantity.values.shape[1]):
            continue
        a, b = quantity.values[mine], values[yours]
        there = np.isfinite(a).all(axis=1) & np.isfinite(b).all(axis=1)
        if not there.any():
            continue
        a, b = a[there], b[there]
        if a.shape[1] == EULER and quantity.unit == "":  # p and -p are one orientation
            b = np.where((np.abs(a + b).max(axis=1) < np.abs(a - b).max(axis=1))[:, None], -b, b)
        shares = np.abs(a - b).max(axis=0) / quantity.scales
        peaks = np.abs(np.abs(a).max(axis=0) - np.abs(b).max(axis=0)) / quantity.scales
        worst = int(np.argmax(shares))
        found[quantity.name, quantity.unit] = Difference(
            float(shares[worst]), float(peaks.max()), quantity.titles[worst], float(quantity.scales[worst])
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
