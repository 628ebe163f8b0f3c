"""Surfaces that have sunk into each other further than a law of contact means anything: a body that falls through."""

from __future__ import annotations

from typing import Any

import numpy as np

from flexmb.math.switches import GAP

__all__ = ["SunkSurfaces"]


class SunkSurfaces:
    """Looks at the gaps of pairs of surfaces with a law of elastic contact, and tells once of each contact."""

    def __init__(self) -> None:
        self._system: Any = None
        self._known: list[tuple[Any, np.ndarray, np.ndarray]] = []
        self.told: set[str] = set()

    def look(self, system: Any, switching: Any) -> list[str]:
        """Return a sentence for each contact that is new, at the state reached last."""
        if switching is None or not len(switching.now):
            return []
        if system is not self._system:
            self._begin(system)
        found = []
        for force, rows, most in self._known:
            kinds, gaps = switching.now[rows, 0], switching.now[rows, 1]
            beyond = np.where(kinds == GAP, -gaps / most, 0.0)
            if force.title not in self.told and np.any(beyond > 1.0):
                self.told.add(force.title)
                found.append(_sentence(system, force, int(np.argmax(beyond)), gaps, most))
        return found

    def _begin(self, system: Any) -> None:
        self._system, self._known = system, []
        owners = np.array(system.switch_owners)
        for force in system.model.forces:
            if not hasattr(force, "crowded") or force.impulsive or force.crowded(system.model):
                continue
            layer = getattr(force.law, "thickness", np.inf)
            sizes = [min(a.shape.extent, b.shape.extent) for a, b in force.pairs(system.model)]
            rows = np.flatnonzero(owners == force.title)[::2]  # gap and slip of each pair
            if len(rows) == len(sizes):
                self._known.append((force, rows, np.minimum(np.array(sizes), layer)))


def _sentence(system: Any, force: Any, pair: int, gaps: np.ndarray, most: np.ndarray) -> str:
    a, b = force.pairs(system.model)[pair]
    layer = most[pair] == getattr(force.law, "thickness", None)
    what = "thickness of the layer" if layer else "reach of the smaller one"
    finer = ", or a smaller spacing" if force.law.sampled else ""
    return (
        f"{force.title}: '{a.name}' and '{b.name}' have sunk into each other by {-gaps[pair]:.3g} m; "
        f"expected: less than the {what}, {most[pair]:.3g} m, beyond which no law of contact holds. "
        f"They pass through each other: look at the units of shape and law, or give a stiffer law{finer}."
    )
