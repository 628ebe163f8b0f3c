"""Curves as pieces of a web page: SVG whose text is text."""

from __future__ import annotations

import io
import re
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from flexmb.view.ranges import LARGEST, factors_in_labels, largest_of, least_range, unit_in, widen

__all__ = ["COLORS", "Line", "drawable", "svg_curves"]

COLORS = ("#1f5fa8", "#d1495b", "#3a8f5c", "#c98a2b", "#6d597a", "#26303a", "#4aa3b5", "#a3554a")
INK, PALE = "#66727e", "#dfe6ee"
POINTS = 1500
"""More samples than a printed line can show are thinned."""


class Line(NamedTuple):
    """A curve: label of the legend ("" for none), abscissae, ordinates, colour, and its dashes."""

    label: str
    x: np.ndarray
    y: np.ndarray
    color: str
    dash: str = "-"


def svg_curves(
    lines: Sequence[Line],
    *,
    y_label: str,
    x_label: str = "time [s]",
    events: Sequence[float] = (),
    size=(5.6, 2.5),
    limits: tuple[float, float] | None = None,
    ordinates: tuple[float, float] | None = None,
    length: float = 0.0,
) -> str:
    """Return curves over one another as an SVG element.

    Parameters
    ----------
    lines : sequence of Line
    y_label, x_label : str
        Quantity with its unit.
    events : sequence of float
        Abscissae of vertical lines.
    size : (float, float), inch
        The page may stretch it.
    limits, ordinates : (float, float), optional
        Range of abscissae and of ordinates; otherwise what there is.
    length : float, m
        Of the model, which says what motion is rounding.
    """
    import matplotlib
    from matplotlib.backends.backend_svg import FigureCanvasSVG
    from matplotlib.figure import Figure

    settings: dict[Any, Any] = {
        "svg.fonttype": "none",
        "svg.hashsalt": "flexmb",
        "font.size": 9.0,
        "axes.unicode_minus": False,
        "text.parse_math": False,  # a dollar sign in the name of a sensor is a dollar sign
    }
    with matplotlib.rc_context(settings):
        figure = Figure(figsize=size, layout="constrained")
        FigureCanvasSVG(figure)
        ax = figure.subplots()
        for line in lines:
            x, y = _thinned(line.x, line.y)
            ax.plot(x, drawable(y), color=line.color, lw=1.3, ls=line.dash, label=line.label or None)
        for event in events:
            ax.axvline(event, color=INK, lw=0.8, ls=":")
        ax.set_xlabel(x_label, color=INK)
        ax.set_ylabel(y_label, color=INK)
        ax.set_xlim(limits or (min(np.nanmin(line.x) for line in lines), max(np.nanmax(line.x) for line in lines)))
        if ordinates is not None:
            ax.set_ylim(*ordinates)
        else:
            widen(ax, least_range(unit_in(y_label), largest_of(line.y for line in lines), length))
        _dress(ax)
        if any(line.label for line in lines):
            _add_legend(ax, max(len(line.label) for line in lines))
        factors_in_labels(figure)
        text = io.StringIO()
        figure.savefig(text, format="svg", metadata={"Date": None, "Creator": None}, transparent=True)
    return _element(text.getvalue())


def _dress(ax) -> None:
    """Give axes a grid and two pale spines."""
    ax.grid(True, color=PALE, lw=0.6)
    ax.tick_params(colors=INK, length=3)
    for side, spine in ax.spines.items():
        spine.set_visible(side in ("left", "bottom"))
        spine.set_color("#b5bfc9")


def _add_legend(ax, longest: int) -> None:
    """Put the legend above the axes, in as many columns as labels of up to `longest` letters leave room for."""
    ax.legend(
        loc="lower left",
        bbox_to_anchor=(0.0, 1.0),
        ncols=max(1, min(4, 80 // (6 + longest))),
        frameon=False,
        fontsize=8,
        labelcolor=INK,
        handlelength=1.6,
        columnspacing=1.2,
        borderaxespad=0.2,
    )


def _element(svg: str) -> str:
    """Return the element of an SVG file, without metadata and a size of its own, in the font of the page."""
    svg = svg[svg.index("<svg") :]
    svg = re.sub(r"<metadata>.*?</metadata>", "", svg, flags=re.DOTALL)
    svg = re.sub(r"'DejaVu Sans'[^;\"]*", "system-ui, sans-serif", svg)
    return re.sub(
        r'(<svg[^>]*?) width="[^"]*"', r"\1", re.sub(r'(<svg[^>]*?) height="[^"]*"', r"\1", svg, count=1), count=1
    )


def drawable(y: np.ndarray) -> np.ndarray:
    """Return values with gaps where they are too large: matplotlib fails at differences beyond all floats."""
    with np.errstate(invalid="ignore"):
        return np.where(np.abs(y) <= LARGEST, y, np.nan)


def _thinned(x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return at most POINTS samples; of each group the least and the greatest, so that no peak is lost."""
    if len(x) <= POINTS:
        return x, y
    groups = np.array_split(np.arange(len(x)), POINTS // 2)
    y_known = np.where(np.isfinite(y), y, 0.0)
    picked = [sorted({int(g[y_known[g].argmin()]), int(g[y_known[g].argmax()])}) for g in groups]
    kept = np.array([0, *(k for pair in picked for k in pair), len(x) - 1])
    kept = np.unique(kept)
    return x[kept], y[kept]
