"""`plot`: sensors over time."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from flexmb.errors import FlexmbError
from flexmb.files import replacing
from flexmb.view.curves import drawable
from flexmb.view.endings import require_ending
from flexmb.view.ranges import LARGEST, ROUNDING, factors_in_labels, largest_of, least_range, length_of, widen

__all__ = ["plot"]

COLORS = ("#1f5fa8", "#d1495b", "#3a8f5c", "#c98a2b", "#6d597a", "#26303a")


def plot(solution, names: str | Sequence[str] | None, path: str | Path, *, size=(9.0, 2.6)) -> Path:
    """Plot sensors over time, one below the other, and return the path.

    Parameters
    ----------
    solution : Solution
    names : str, sequence of str, or None
        Sensors; None plots all.
    path : path
        The ending chooses the format: .png, .svg, .pdf.
    size : (float, float), inch
        Width of the figure and height per sensor.
    """
    import matplotlib

    names = solution.sensor_names if names is None else (names,) if isinstance(names, str) else tuple(names)
    if not names:
        raise FlexmbError(
            "Plot", found="there is no sensor to plot", expected="at least one", remedy="Add sensors to the model"
        )
    with matplotlib.rc_context({"text.parse_math": False}):  # a dollar sign in a name is a dollar sign
        return _plotted(solution, names, Path(path), size)


def _plotted(solution, names: tuple[str, ...], path: Path, size: tuple[float, float]) -> Path:
    """Write the plot of some sensors."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(size[0], size[1] * len(names)), layout="constrained", dpi=130)
    require_ending(figure, path, "Plot")
    axes = figure.subplots(len(names), 1, sharex=True, squeeze=False)[:, 0]
    least, length = _least_ranges(solution), length_of([solution])
    for name, ax in zip(names, axes, strict=True):
        _draw(ax, solution.t, solution[name], name, solution.column_titles(name))
        for axis in (ax, getattr(ax, "second", None)):
            if axis is not None:
                unit = axis.get_ylabel()
                own = largest_of(line.get_ydata() for line in axis.lines)
                widen(axis, max(least.get(unit, 0.0), least_range(unit.strip("[]"), own, length)))
    axes[-1].set_xlabel("time [s]")
    factors_in_labels(figure)
    with replacing(path, f"Plot '{path}'", folder=True) as file:
        figure.savefig(file)
    return path


def _draw(ax, t, values, name, titles):
    """Draw one sensor; columns with different units (force and moment) share the axis only if they are one."""
    values = values.reshape(len(t), -1)
    units = [title[title.index("[") :] if "[" in title else "" for title in titles]
    for k, title in enumerate(titles):
        other = units[k] != units[0]
        target = _second_axis(ax, units[k]) if other else ax
        label = title.replace(units[k], "").strip() if units[k] else title
        target.plot(
            t, drawable(values[:, k]), color=COLORS[k % len(COLORS)], lw=1.4, ls="--" if other else "-", label=label
        )
    ax.set_title(name, loc="left", fontsize=10, fontweight="bold", color="#26303a")
    ax.set_ylabel(units[0] or titles[0])
    ax.grid(color="#dfe6ee", lw=0.8)
    ax.set_axisbelow(True)
    for side in ("top", "right"):
        ax.spines[side].set_visible(False)
    if len(titles) > 1:
        pairs = [ax.get_legend_handles_labels()]
        if getattr(ax, "second", None) is not None:
            pairs.append(ax.second.get_legend_handles_labels())
        ax.legend(
            [h for p in pairs for h in p[0]],
            [x for p in pairs for x in p[1]],
            frameon=False,
            fontsize=8,
            ncols=len(titles),
            loc="lower right",
            bbox_to_anchor=(1.0, 0.98),
            borderaxespad=0.1,
        )
    ax.margins(x=0)


def _least_ranges(solution) -> dict[str, float]:
    """Return by unit the range that an axis shows at the least: less of it is rounding of the largest values.

    Moments are compared with forces at the length of the model too.
    """
    largest: dict[str, float] = {}
    for name in solution.sensor_names:
        values = np.abs(np.asarray(solution[name], float).reshape(len(solution.t), -1))
        for title, column in zip(solution.column_titles(name), values.T, strict=True):
            unit = title[title.index("[") :] if "[" in title else title
            known = column[column <= LARGEST]
            largest[unit] = max(largest.get(unit, 0.0), float(known.max(initial=0.0)))
    length = length_of([solution])
    if length > 0.0 and {"[N]", "[N m]"} & largest.keys():
        force, moment = largest.get("[N]", 0.0), largest.get("[N m]", 0.0)
        largest |= {"[N]": max(force, moment / length), "[N m]": max(moment, force * length)}
    return {unit: ROUNDING * value for unit, value in largest.items()}


def _second_axis(ax, unit):
    if getattr(ax, "second", None) is None:
        ax.second = ax.twinx()
        ax.second.set_ylabel(unit)
        ax.second.spines["top"].set_visible(False)
    return ax.second
