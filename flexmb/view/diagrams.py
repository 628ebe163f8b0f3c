"""`Diagram`: any sensors over time or over another sensor, of several runs, on one scale.

A text says it as on the command line: ``"t1_strut force fx, t2_strut force fx / t1_strut force fx at 0.645"``,
``"flap angle over lever angle"``.
"""

from __future__ import annotations

import re
import textwrap
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from flexmb.errors import FlexmbError, did_you_mean
from flexmb.files import replacing
from flexmb.model.sensor_columns import SensorColumn, columns_named, sensor_columns, unknown, without_unit
from flexmb.view.curves import COLORS, Line, drawable
from flexmb.view.endings import require_ending
from flexmb.view.quantities import ZERO, scaled
from flexmb.view.ranges import factors_in_labels, largest_of, least_range, length_of, unit_in, widen

__all__ = ["Diagram", "as_diagram", "draw_diagrams", "laid_out", "of_one_unit"]

_TEXT = re.compile(r"(?:(?P<title>[^=]+?)\s*=\s*)?(?P<y>.+?)(?:\s+over\s+(?P<x>.+?))?(?:\s+/\s+(?P<per>.+))?")
DASHES = ("-", "--", ":", "-.")
"""Of the runs, one after another; colours tell the sensors apart."""
DPI = 150
CLOSE, MOSTLY = 0.01, 0.9
"""Part of the height within which a curve hides another, and part of the samples at which it does."""
FINAL = "final"
WIDTH = 36
"""Characters of a label along the ordinate."""
FEW, LINE = 2, 0.08
"""Labels that find a place between curves; height of one, relative to the diagram's."""


@dataclass(frozen=True, kw_only=True)
class Diagram:
    """Curves in one frame.

    Parameters
    ----------
    y : sequence of str
        Sensors with their component, "strut force fx", or whole sensors; all have the same unit.
    x : str, optional
        A sensor, instead of time.
    per : float or str, optional
        What the ordinates are divided by: a number in SI units, "SENSOR at TIME" of the run that has it first, or
        "final", each curve by its own last value.
    title : str
    limits : (float, float), optional
        Of the abscissa, as it is shown.
    of : sequence of str
        Names of the runs it shows; empty: all that have the sensors.
    scale : str
        Diagrams with the same word have the same range of ordinates.
    """

    y: Sequence[str]
    x: str | None = None
    per: float | str | None = None
    title: str = ""
    limits: tuple[float, float] | None = None
    of: Sequence[str] = ()
    scale: str = ""

    def curves(self, runs: Mapping[str, Any]) -> tuple[list[Line], str, str]:
        """Return the curves of all runs that have the sensors, and the labels of ordinate and abscissa."""
        runs = self._of_these(runs)
        y = _single_columns(runs, self.y)
        found = self._found(runs, y)
        units = {unit for *_, (_, unit), _ in found}
        if len(units) > 1 and self.per != FINAL:
            raise FlexmbError(
                f"Diagram '{self.title or ', '.join(self.y)}'",
                found=f"ordinates in {' and '.join(sorted(u or '-' for u in units))}",
                expected="one unit",
                remedy="Make a diagram for each unit",
            )
        size = max(float(np.nanmax(np.abs(values), initial=0.0)) for *_, (values, _), _ in found)
        factor, unit = scaled(units.pop(), size)
        if self.per == FINAL:
            found = [(run, wanted, (self._per_final(y, wanted), ""), x) for run, wanted, (y, _), x in found]
            factor, unit = 1.0, ""
        elif self.per is not None:
            factor, unit = 1.0 / self._divisor(runs), ""
        x_size = max(float(np.nanmax(np.abs(x), initial=0.0)) for *_, (x, _) in found)
        x_factor, x_unit = scaled(found[0][3][1], x_size)
        order = list(runs)
        lines = [
            _line(y, order, wanted, run, x_factor * x, factor * values) for run, wanted, (values, _), (x, _) in found
        ]
        x_label = f"{without_unit(self.x or 'time')} [{x_unit or '-'}]"
        return _seen(lines) if len(runs) == 1 else lines, self._label(unit), x_label

    def _found(self, runs: Mapping[str, Any], y: Sequence[str]) -> list[tuple[str, str, Any, Any]]:
        """Return run, column, ordinates and abscissae of every curve; a column that no run has is an error."""
        found = [
            (run, wanted, _values(solution, wanted), _abscissa(solution, self.x))
            for run, solution in runs.items()
            for wanted in y
            if _has(solution, wanted)
        ]
        missing = [wanted for wanted in y if all(entry[1] != wanted for entry in found)]
        if missing:
            _refuse(next(iter(runs.values())), missing[0])
        return found

    def _label(self, unit: str) -> str:
        """Return the label of the ordinate."""
        what = without_unit(self.y[0]) if len(self.y) == 1 else ""
        per = "its last value" if self.per == FINAL else self.per
        label = f"{what} / {per}" if self.per is not None else f"{what} [{unit or '-'}]"
        return "\n".join(textwrap.wrap(label.strip(), WIDTH))

    def _of_these(self, runs: Mapping[str, Any]) -> Mapping[str, Any]:
        """Return the runs that the diagram shows."""
        for name in self.of:
            if name not in runs:
                raise FlexmbError(
                    f"Diagram '{self.title or ', '.join(self.y)}'",
                    found=f"there is no run '{name}'",
                    expected=f"One of: {', '.join(runs)}",
                    remedy=did_you_mean(name, runs) or "Name runs as they are named in the report",
                )
        return {name: runs[name] for name in self.of} if self.of else runs

    def _per_final(self, values: np.ndarray, name: str) -> np.ndarray:
        """Return values over the last of them."""
        if values[-1] == 0.0 or not np.isfinite(values[-1]):
            raise FlexmbError(
                f"Diagram '{self.title or ', '.join(self.y)}'",
                found=f"'{name}' ends with {values[-1]:g}",
                expected="a last value other than zero",
                remedy="Divide by a number, or by a sensor at a time",
            )
        return values / values[-1]

    def _divisor(self, runs: Mapping[str, Any]) -> float:
        """Return what the ordinates are divided by, SI."""
        value: Any = self.per
        if isinstance(value, str):
            name, _, time = value.partition(" at ")
            solution = next((s for s in runs.values() if _has(s, name)), None) or _refuse(
                next(iter(runs.values())), name
            )
            try:
                value = float(np.interp(float(time), solution.t, _values(solution, name)[0]))
            except ValueError:
                value = np.nan
        if not np.isfinite(value) or value == 0.0:
            raise FlexmbError(
                f"Diagram '{self.title or ', '.join(self.y)}'",
                found=f"a divisor {self.per!r}",
                expected='a number other than zero, or "SENSOR at TIME"',
                remedy='Write "strut force fx / strut force fx at 0.645"',
            )
        return float(value)


def _line(y: Sequence[str], order: list[str], wanted: str, run: str, x: np.ndarray, values: np.ndarray) -> Line:
    """Return the curve of a column in one of several runs: colours are of columns, and dashes of runs, or colours."""
    label = ", ".join(part for part in (wanted if len(y) > 1 else "", run if len(order) > 1 else "") if part)
    color = y.index(wanted) if len(y) > 1 else order.index(run)
    dash = DASHES[order.index(run) % len(DASHES)] if len(y) > 1 else "-"
    return Line(label, x, values, COLORS[color % len(COLORS)], dash)


def _seen(lines: list[Line]) -> list[Line]:
    """Return the curves of one run; one that lies on an earlier one is dashed, or the earlier would be hidden."""
    finite = [line.y[np.isfinite(line.y)] for line in lines]
    height = max((float(np.ptp(y)) for y in finite if len(y)), default=0.0)
    found: list[Line] = []
    for line in lines:
        under = sum(float(np.mean(np.abs(line.y - other.y) <= CLOSE * height)) > MOSTLY for other in found)
        found.append(line._replace(dash=DASHES[under % len(DASHES)]))
    return found


def as_diagram(text: str | Diagram) -> Diagram:
    """Return the diagram of a text, "TITLE = SENSOR, SENSOR over SENSOR / DIVISOR"; one SENSOR is enough."""
    if isinstance(text, Diagram):
        return text
    match = _TEXT.fullmatch(text.strip())
    if match is None:
        raise FlexmbError(
            f"Diagram '{text}'",
            found="no sensor",
            expected="SENSOR, SENSOR over SENSOR / DIVISOR",
            remedy='Write "flap angle over lever angle"',
        )
    per: float | str | None = match["per"]
    with suppress(ValueError):  # the name of a sensor
        per = None if per is None else float(per)
    y = tuple(piece.strip() for piece in match["y"].split(",") if piece.strip())
    return Diagram(y=y, x=match["x"], per=per, title=match["title"] or "")


class LaidOut(NamedTuple):
    """A diagram with its curves: labels of the axes, range of the ordinates where several diagrams have one."""

    diagram: Diagram
    lines: list[Line]
    y_label: str
    x_label: str
    ordinates: tuple[float, float] | None


def laid_out(runs: Mapping[str, Any], diagrams: Sequence[str | Diagram]) -> list[LaidOut]:
    """Return the curves of diagrams; curves of one `scale` share the range of ordinates."""
    made = [(diagram, *diagram.curves(runs)) for diagram in map(as_diagram, diagrams)]
    return [LaidOut(*entry, _ordinates(entry[0].scale, made)) for entry in made]


def _ordinates(scale: str, made) -> tuple[float, float] | None:
    """Return what holds all curves of the diagrams of a scale, with a margin; only what their limits show."""
    if not scale:
        return None
    values = [
        line.y[_within(line.x, diagram.limits)]
        for diagram, lines, *_ in made
        if diagram.scale == scale
        for line in lines
    ]
    low = min(float(np.nanmin(y, initial=0.0)) for y in values)
    high = max(float(np.nanmax(y, initial=0.0)) for y in values)
    margin = 0.04 * (high - low) or 1.0
    return low - margin, high + margin


def _within(x: np.ndarray, limits) -> np.ndarray:
    return np.ones(len(x), bool) if limits is None else (x >= limits[0]) & (x <= limits[1])


def of_one_unit(runs: Mapping[str, Any], names: Sequence[str] = ()) -> list[list[str]]:
    """Return the columns of sensors, those of each unit together: what may be one diagram each.

    Without names, all sensors of the runs, each by itself. Of a whole sensor, columns that are zero are left out.
    """
    if not names:
        every = dict.fromkeys(name for run in runs.values() for name in run.sensor_names)
        return [group for name in every for group in of_one_unit(runs, [name])]
    groups: dict[str, list[str]] = {}
    for name in _single_columns(runs, names):
        if name not in names and _is_zero(runs, name):
            continue
        run = next((run for run in runs.values() if _has(run, name)), None)
        groups.setdefault("" if run is None else _named(run, name)[0].unit, []).append(name)
    return list(groups.values())


def _is_zero(runs: Mapping[str, Any], name: str) -> bool:
    """Is a column of a sensor nothing beside the others of its unit, in all runs?"""
    for run in runs.values():
        if not _has(run, name):
            continue
        own = _named(run, name)[0]
        beside = [one.name for one in _known(run)[own.sensor] if one.unit == own.unit]
        largest = max(largest_of([_values(run, one)[0]]) for one in beside)
        if largest_of([_values(run, name)[0]]) > ZERO * largest or (largest == 0.0 and name == beside[0]):
            return False
    return True


def draw_diagrams(
    runs: Mapping[str, Any], diagrams: Sequence[str | Diagram], path: str | Path, *, columns: int = 1, size=(6.0, 3.4)
) -> Path:
    """Draw diagrams of several runs into one picture and return its path.

    Parameters
    ----------
    runs : mapping of name to Solution
        The first is drawn in full lines.
    diagrams : sequence of Diagram or text
        See `as_diagram`.
    path : path
        The ending chooses the format: .png (150 dpi), .svg, .pdf.
    columns : int
    size : (float, float), inch
        Of each diagram.
    """
    import matplotlib
    from matplotlib.figure import Figure

    made, path = laid_out(runs, diagrams), Path(path)
    rows = -(-len(made) // columns)
    with matplotlib.rc_context({"text.parse_math": False, "axes.unicode_minus": False}):
        figure = Figure(figsize=(columns * size[0], rows * size[1]), layout="constrained", dpi=DPI)
        require_ending(figure, path, "Plot")
        axes = figure.subplots(rows, columns, squeeze=False).ravel()
        for ax, (diagram, lines, y_label, x_label, ordinates) in zip(axes, made):
            for line in lines:
                ax.plot(drawable(line.x), drawable(line.y), color=line.color, lw=1.4, ls=line.dash, label=line.label)
            ax.set(xlabel=x_label, ylabel=y_label)
            ax.set_title(diagram.title, loc="left", fontsize=10, fontweight="bold")
            ax.grid(color="#dfe6ee", lw=0.8)
            if diagram.limits is not None:
                ax.set_xlim(*diagram.limits)
            if ordinates is not None:
                ax.set_ylim(*ordinates)
            else:
                widen(ax, least_range(unit_in(y_label), largest_of(line.y for line in lines), length_of(runs.values())))
            labels = sum(1 for line in lines if line.label)
            if ordinates is None and labels > FEW:  # room for them, or they would lie on curves
                low, high = ax.get_ylim()
                ax.set_ylim(low, high + LINE * labels * (high - low))
            if labels:
                ax.legend(fontsize=8, framealpha=0.85, edgecolor="none")
        for ax in axes[len(made) :]:
            ax.set_visible(False)
        factors_in_labels(figure)
        with replacing(path, f"Plot '{path}'", folder=True) as file:
            figure.savefig(file)
    return path


def _single_columns(runs: Mapping[str, Any], names: Sequence[str]) -> list[str]:
    """Return names of single columns: a sensor of several stands for all of them."""
    found: dict[str, None] = {}
    for name in names:
        known = next((own for own in (_named(run, name) for run in runs.values()) if own), None)
        found |= dict.fromkeys([name] if known is None or len(known) == 1 else [one.name for one in known])
    return list(found)


def _known(solution) -> dict[str, tuple[SensorColumn, ...]]:
    return sensor_columns({name: solution.column_titles(name) for name in solution.sensor_names})


def _named(solution, name: str) -> tuple[SensorColumn, ...]:
    return columns_named(name, _known(solution))


def _has(solution, name: str) -> bool:
    return len(_named(solution, name)) == 1


def _values(solution, name: str) -> tuple[np.ndarray, str]:
    """Return values (nt,) and unit of a component of a sensor."""
    (column,) = _named(solution, name)
    values = np.asarray(solution[column.sensor], float).reshape(len(solution.t), -1)[:, column.number]
    return values, "" if column.unit == "-" else column.unit


def _abscissa(solution, name: str | None) -> tuple[np.ndarray, str]:
    if name is None:
        return np.asarray(solution.t), "s"
    if not _has(solution, name):
        _refuse(solution, name)
    return _values(solution, name)


def _refuse(solution, name: str):
    said, own = unknown(name, _known(solution)), _named(solution, name)
    if own:
        raise FlexmbError(
            "Diagram",
            found=f"sensor '{name}' has {len(own)} columns",
            expected=said.expected,
            remedy="Name one of them",
        )
    raise FlexmbError("Diagram", found=said.found, expected=said.expected, remedy=said.remedy)
