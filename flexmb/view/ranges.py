"""Ranges of axes: what is rounding is drawn flat, and a factor of the ticks stands in the label of its axis."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

__all__ = ["LARGEST", "factors_in_labels", "largest_of", "least_range", "length_of", "unit_in", "widen"]

LARGEST = 1e300
"""Of what is drawn."""

PLACES = {"m": 1.0, "mm": 1e3, "rad": 0.0, "deg": 0.0, "": 0.0, "-": 0.0}
"""Units whose zero is a choice, and how many of them are a metre: a small motion far from zero is no rounding."""
SMALL, PLACE = 1e-6, 1e-8
"""Of the largest value drawn: what is less is drawn flat. `PLACE` for places and angles."""
ROUNDING = 1e-9
"""Of the largest value of the same unit in a run."""
FINEST = 1e-12
"""Of the length of the model: less than rounding of its coordinates adds up to."""


def length_of(solutions: Iterable[Any]) -> float:
    """Return the length of the models of solutions, m; zero where it is not known."""
    known = (getattr(phase.system, "lengths", None) for solution in solutions for phase in solution.phases)
    return max((float(lengths.whole) for lengths in known if lengths is not None), default=0.0)


def largest_of(values: Iterable[np.ndarray]) -> float:
    """Return the largest magnitude that is drawn."""
    found = 0.0
    for column in values:
        sizes = np.abs(np.asarray(column, float))
        found = max(found, float(sizes[sizes <= LARGEST].max(initial=0.0)))
    return found


def least_range(unit: str, largest: float, length: float = 0.0) -> float:
    """Return the range, in the unit, that an axis shows at the least.

    Parameters
    ----------
    unit : str
        "N", "m", "mm", ...
    largest : float, in the unit
        Magnitude of what is drawn.
    length : float, m
        Of the model.
    """
    if unit not in PLACES:
        return SMALL * largest
    return max(PLACE * largest, FINEST * length * PLACES[unit])


def unit_in(label: str) -> str:
    """Return the unit in the label of an axis, "place z [mm]"."""
    return label.rpartition("[")[2].rstrip("]") if label.endswith("]") else ""


def widen(ax, least: float) -> None:
    """Show a range of `least`, so that rounding is flat."""
    low, high = ax.get_ylim()
    if high - low < least:
        middle = 0.5 * (low + high)
        ax.set_ylim(middle - 0.5 * least, middle + 0.5 * least)


def factors_in_labels(figure) -> None:
    """Move factors and offsets of ticks ("1e-5") from the corners, where titles and legends are, to the labels."""
    figure.draw_without_rendering()
    for ax in figure.axes:
        for axis in (ax.xaxis, ax.yaxis):
            text = axis.get_offset_text()
            said = text.get_text().replace("\N{MINUS SIGN}", "-")
            if said and text.get_visible():
                axis.set_label_text(f"{axis.get_label_text()} ({_in_words(said)})".strip())
                text.set_visible(False)


def _in_words(said: str) -> str:
    """Return "x 1e-5", "x 1e-13 - 2.8e-4" or "+ 1e3" of what matplotlib writes: 1e-5, 1e-13-2.8e-4, +1e3."""
    at = next((k for k in range(len(said)) if said[k] in "+-" and (k == 0 or said[k - 1] != "e")), None)
    factor, offset = (said, "") if at is None else (said[:at], f"{said[at]} {said[at + 1 :]}")
    return " ".join(part for part in (f"x {factor}" if factor else "", offset) if part)
