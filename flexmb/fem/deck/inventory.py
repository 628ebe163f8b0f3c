"""`Inventory` in words: what of a deck was read, approximated, left out and not needed, and what it weighs."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from flexmb.fem.deck.contents import Deck
from flexmb.fem.fe_model import FEModel

__all__ = ["inventory_text", "mass_and_center", "numbers", "source_of"]


def inventory_text(deck: Deck, fe: FEModel) -> str:
    """Return the inventory of a deck as lines of text."""
    kept, moved = len(deck.labels), fe.ndof
    lines = [f"{deck.source} deck '{deck.name}': {kept} nodes, {moved} freedoms"]
    found = deck.inventory
    read = ", ".join(f"{count} {name}" for name, count in sorted(found.read.items()) if count)
    lines.append(f"  read          {read or 'nothing'}")
    for title, counter in (("approximated", found.approximated), ("left out", found.left_out)):
        for text, count in sorted(counter.items()):
            if count:
                lines.append(f"  {title:<13} {text} ({count})")
    if found.weightless:
        lines.append(f"  no density    {_few(sorted(found.weightless))}")
    unused = ", ".join(f"{count} {name}" for name, count in sorted(found.unused.items()) if count)
    if unused:
        lines.append(f"  not needed    {unused}")
    mass, centre = mass_and_center(fe)
    at = ", ".join(numbers(centre))
    lines.append(f"  mass          {mass:.8g}{' kg' if deck.units else ''} at ({at}){' m' if deck.units else ''}")
    if not deck.units:
        lines.append("  units         as in the deck: not known; read_deck(..., units='mm, t, s') converts to SI")
    if fe.reference_points:
        lines.append(f"  interfaces    {_few(sorted(fe.reference_points))}")
    if fe.supports:
        lines.append(f"  supports      {_few(sorted(fe.supports))}, kept but not applied")
    return "\n".join(lines)


def source_of(deck: Deck, path: Path) -> dict[str, Any]:
    """Return where a model comes from and what became of it, as JSON can hold it: `FEModel.source`."""
    found = deck.inventory
    counters = {"read": found.read, "approximated": found.approximated, "left_out": found.left_out}
    counters["not_needed"] = found.unused
    listed = {name: {text: int(n) for text, n in sorted(c.items()) if n} for name, c in counters.items()}
    return {
        "program": deck.source,
        "file": path.name,
        "units": deck.units,
        "nodes": len(deck.labels),
        **listed,
        "without_density": sorted(found.weightless),
    }


def mass_and_center(fe: FEModel) -> tuple[float, np.ndarray]:
    """Return mass and centre of mass (3,) by rigid motions of the model, held freedoms left out."""
    motions = fe.rigid_motions()
    inertia = motions.T @ (fe.M @ motions)
    mass = float(np.trace(inertia[:3, :3]) / 3.0)
    if not mass > 0.0:
        return 0.0, np.full(3, np.nan)
    lever = inertia[:3, 3:] / mass  # minus the cross-product matrix of the centre
    return mass, np.array([lever[1, 2] - lever[2, 1], lever[2, 0] - lever[0, 2], lever[0, 1] - lever[1, 0]]) * 0.5


ROUNDING = 1e-12
"""Relative to the largest of some numbers: what is less is printed as zero."""


def numbers(values: np.ndarray) -> list[str]:
    """Return numbers of one kind as texts of six digits, those that are rounding as 0."""
    return [f"{0.0 if abs(x) <= ROUNDING * np.abs(values).max() else x:.6g}" for x in np.ravel(values)]


def _few(names: list[str], most: int = 12) -> str:
    shown = ", ".join(names[:most])
    return shown if len(names) <= most else f"{shown} and {len(names) - most} more"
