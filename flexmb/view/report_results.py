"""Sections of a report that show what came out: curves, extremes, loads, energy."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from typing import Any, NamedTuple

import numpy as np

from flexmb.io.web_page import table
from flexmb.view.curves import COLORS, Line, svg_curves
from flexmb.view.diagrams import laid_out
from flexmb.view.quantities import number, scaled, shown_columns, sizes
from flexmb.view.ranges import length_of

__all__ = ["Run", "curves", "diagrams", "energy", "event_times", "extremes", "loads"]

AXES = ("energy", "constrainterror")


class Run(NamedTuple):
    """A solution and how it is named and coloured where several are compared."""

    name: str
    solution: Any
    color: str


def event_times(solution) -> list[float]:
    """Return the times at which events changed the model, s."""
    return [float(phase.t[-1]) for phase in solution.phases[:-1]]


def _sensors(runs: Sequence[Run]) -> list[str]:
    """Return the names of the sensors with curves of their own: all but energies, which have one figure together."""
    names = dict.fromkeys(name for run in runs for name in run.solution.sensor_names)
    kinds = {s.name: type(s).__name__.lower() for run in runs if run.solution.model for s in run.solution.model.sensors}
    return [name for name in names if kinds.get(name) not in AXES]


def figure(title: str, svg: str, note: str = "") -> str:
    """Return a figure with its title above it."""
    more = f' <span class="note">{escape(note)}</span>' if note else ""
    return f"<figure><figcaption>{escape(title)}{more}</figcaption>{svg}</figure>"


def diagrams(runs: Sequence[Run], wanted: Sequence[Any]) -> str:
    """Sensors over time or over others that were asked for, of all runs on one scale."""
    named = {run.name: run.solution for run in runs}
    length, figures = length_of(named.values()), []
    for diagram, lines, y_label, x_label, ordinates in laid_out(named, wanted):
        title = diagram.title or f"{', '.join(diagram.y)} over {diagram.x or 'time'}"
        svg = svg_curves(
            lines, y_label=y_label, x_label=x_label, limits=diagram.limits, ordinates=ordinates, length=length
        )
        figures.append(figure(title, svg))
    return f'<h2>Diagrams</h2><div class="figures">{"".join(figures)}</div>' if figures else ""


def curves(runs: Sequence[Run]) -> str:
    """Sensors over time: the components of one run in one figure, or one component of several runs."""
    drawn = []
    for name in _sensors(runs):
        own = [run for run in runs if name in run.solution.sensor_names]
        largest = sizes([run.solution for run in own], name)
        columns = [(run, shown_columns(run.solution, name, largest)) for run in own]
        drawn += _of_one(name, *columns[0]) if len(runs) == 1 else _compared(name, columns)
    if not drawn:
        return '<h2>Curves</h2><p class="note">The model has no sensors.</p>'
    return f'<h2>Curves</h2><div class="figures">{"".join(drawn)}</div>'


def _of_one(name: str, run: Run, columns) -> list[str]:
    """One figure for each unit of a sensor."""
    drawn = []
    for unit in dict.fromkeys(column.unit for column in columns):
        same = [column for column in columns if column.unit == unit]
        lines = [
            Line(column.title if len(columns) > 1 else "", run.solution.t, column.values, color)
            for column, color in zip(same, COLORS * len(same))
        ]
        svg = svg_curves(lines, y_label=_axis(unit), events=event_times(run.solution), length=length_of([run.solution]))
        drawn.append(figure(name, svg, f"[{unit}]" if unit else ""))
    return drawn


def _compared(name: str, columns) -> list[str]:
    """One figure for each component, with all runs."""
    drawn = []
    for title, unit in dict.fromkeys((column.title, column.unit) for _, own in columns for column in own):
        lines = [
            Line(run.name, run.solution.t, column.values, run.color)
            for run, own in columns
            for column in own
            if (column.title, column.unit) == (title, unit)
        ]
        svg = svg_curves(lines, y_label=_axis(unit), length=length_of(run.solution for run, _ in columns))
        drawn.append(figure(f"{name} {title}".strip(), svg, f"[{unit}]" if unit else ""))
    return drawn


def _axis(unit: str) -> str:
    return f"[{unit}]" if unit else "[-]"


def extremes(runs: Sequence[Run]) -> str:
    """Least and greatest value of every sensor with their times, and the last one; several runs one below the other."""
    titles = [("sensor", True), ("unit", True), ("least", False), ("at s", False), ("greatest", False), ("at s", False)]
    titles += [("at the end", False)]
    if len(runs) > 1:
        titles.insert(2, ("run", True))
    rows = []
    for name in _sensors(runs):
        own = [run for run in runs if name in run.solution.sensor_names]
        largest = sizes([run.solution for run in own], name)
        found = {run.name: {c.title: c for c in shown_columns(run.solution, name, largest)} for run in own}
        for title in dict.fromkeys(title for columns in found.values() for title in columns):
            label = escape(f"{name} {title}".strip())
            for run in own:
                column = found[run.name].get(title)
                if column is None or not np.isfinite(column.values).any():
                    continue
                row = [label, escape(column.unit), *_range(run.solution.t, column.values)]
                if len(runs) > 1:
                    row.insert(2, _named(run))
                rows.append(row)
                label = "" if len(runs) > 1 else label
    return "<h2>Extremes</h2>" + table(titles, rows) if rows else ""


def _range(t: np.ndarray, y: np.ndarray) -> list[str]:
    there = np.isfinite(y)
    t, y = t[there], y[there]
    low, high = int(y.argmin()), int(y.argmax())
    size = float(np.abs(y).max())
    cells = [number(y[low], size), f"{t[low]:.4g}", number(y[high], size), f"{t[high]:.4g}"]
    return [*cells, number(y[-1], size)]


def _named(run: Run) -> str:
    return f'<span style="color:{run.color}">&#9632;</span> {escape(run.name)}'


def loads(runs: Sequence[Run]) -> str:
    """Greatest force and moment in every joint and force element, greatest first, with a bar for the force."""
    found: dict[str, dict[str, tuple[str, list[tuple[float, float]]]]] = {}
    for run in runs:
        for name, kind, peaks in _peaks(run.solution):
            found.setdefault(name, {})[run.name] = (kind, peaks)
    if not found:
        return ""
    forces = [own[1][0][0] for by_run in found.values() for own in by_run.values()]
    moments = [own[1][1][0] for by_run in found.values() for own in by_run.values()]
    units = [scaled("N", max(forces)), scaled("N m", max(moments))]
    titles = [("joint or force", True), ("kind", True), (f"force {units[0][1]}", False), ("at s", False)]
    titles += [(f"moment {units[1][1]}", False), ("at s", False), ("", True)]
    if len(runs) > 1:
        titles.insert(2, ("run", True))
    rows = []
    for name in sorted(found, key=lambda name: -max(own[1][0][0] for own in found[name].values())):
        label = escape(name)
        for run in runs:
            if run.name not in found[name]:
                continue
            kind, peaks = found[name][run.name]
            shared = " (not unique)" if name in run.solution.shared_reactions else ""
            cells = [label, escape(kind) + shared]
            if len(runs) > 1:
                cells.append(_named(run))
            for (peak, time), (factor, _), greatest in zip(peaks, units, (max(forces), max(moments))):
                there = peak > 1e-9 * greatest
                cells += [number(factor * peak), f"{time:.4g}"] if there else ["0", ""]
            width = 9.0 * peaks[0][0] / (max(forces) or 1.0)
            rows.append([*cells, f'<span class="bar" style="width:{width:.2f}em"></span>'])
            label = "" if len(runs) > 1 else label
    return (
        '<h2>Loads</h2><p class="note">Greatest magnitudes over time: what a joint, or a force element, exerts on its '
        "second body. Not unique: dependent equations share the load, and the least of all possible reactions are "
        "given.</p>" + table(titles, rows)
    )


def _peaks(solution):
    """Yield (name, kind, [(force N, time s), (moment N m, time s)]) of every joint and force."""
    named: dict[tuple[str, str], list[tuple[np.ndarray, np.ndarray]]] = {}
    for number_, phase in enumerate(solution.phases):
        if phase.model is None:
            return
        series = solution.series(number_)
        for parts, values in ((phase.model.joints, series.reaction), (phase.model.forces, series.force)):
            for part in parts:
                named.setdefault((part.name, type(part).__name__), []).append((phase.t, values(part.name)))
    for (name, kind), pieces in named.items():
        t = np.concatenate([piece[0] for piece in pieces])
        wrench = np.concatenate([piece[1] for piece in pieces])
        sizes_ = [np.linalg.norm(wrench[:, part], axis=1) for part in (slice(0, 3), slice(3, 6))]
        yield name, kind, [(float(size.max()), float(t[size.argmax()])) for size in sizes_]


def energy(runs: Sequence[Run]) -> str:
    """Energies and works over time, and by how much the balance misses."""
    drawn, rows = [], []
    for run in runs:
        if run.solution.model is None:
            continue
        t, stored, works = _energies(run.solution)
        total = stored.sum(axis=1)
        given = works[:, 0] + works[:, 1] - works[:, 2]
        miss = total - total[0] - given
        largest = max(np.abs(stored).max(initial=0.0), np.abs(works).max(initial=0.0))
        factor, unit = scaled("J", largest)
        cells = [number(factor * x, factor * largest) for x in (*stored[:, :2].max(axis=0), *works[-1])]
        title = _named(run) if len(runs) > 1 else escape(run.name)
        rows.append([title, *cells, unit, f"{100.0 * np.abs(miss).max() / (largest or 1.0):.2g} %"])
        named = [*zip(("kinetic", "strain", "potential"), stored.T), ("work of loads", works[:, 0])]
        named += [("work of drives", works[:, 1]), ("dissipated", works[:, 2]), ("total", total)]
        lines = [
            Line(name, t, factor * y, color)
            for (name, y), color in zip(named, COLORS)
            if np.abs(y).max() > 1e-6 * largest
        ]
        if lines:  # a model at rest without gravity has no energy
            svg = svg_curves(lines, y_label=f"[{unit}]", events=event_times(run.solution))
            drawn.append(figure("Energy" + (f", {run.name}" if len(runs) > 1 else ""), svg, f"[{unit}]"))
    if not rows:
        return ""
    titles = [("run", True), ("most kinetic", False), ("most strain", False), ("work of loads", False)]
    titles += [("work of drives", False), ("dissipated", False), ("unit", True), ("balance misses", False)]
    return (
        '<h2>Energy</h2><p class="note">total(t) - total(0) = work of loads + work of drives - dissipated; '
        "what is missing is "
        "the error of the integration, in percent of the largest energy.</p>"
        + table(titles, rows)
        + f'<div class="figures">{"".join(drawn)}</div>'
    )


def _energies(solution):
    """Return t (nt,), stored energies (nt, 3) and works (nt, 3), J, over all phases."""
    series = [solution.series(number_) for number_ in range(len(solution.phases))]
    return (
        solution.t,
        np.concatenate([one.energy for one in series]),
        np.concatenate([one.works for one in series]),
    )
