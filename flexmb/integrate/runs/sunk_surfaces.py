"""Surfaces that have sunk into each other further than a law of contact means anything: a body that falls through."""

from __future__ import annotations

from typing import Any

import numpy as np

from flexmb.math.switches import GAP

__all__ = ["SunkSurfaces"]

FAR_IN = 0.75
"""Share of the way to the deepest point of a surface, which samples of another one have gone: within a quarter of its
thickness, the longest way of a step, they are behind its middle and are pushed out on the other side."""


class SunkSurfaces:
    """Looks how deep pairs of surfaces with a law of elastic contact have been, and tells once of each contact."""

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
            now = np.where(switching.now[rows, 0] == GAP, -switching.now[rows, 1], 0.0)
            depths = np.maximum(now, switching.spells["deepest"][rows])
            switching.spells["deepest"][rows] = 0.0
            beyond = depths / most
            if force.title not in self.told and np.any(beyond > 1.0):
                self.told.add(force.title)
                found.append(_sentence(system, force, int(np.argmax(beyond)), depths, most))
        return found

    def _begin(self, system: Any) -> None:
        self._system, self._known = system, []
        owners = np.array(system.switch_owners)
        for force in system.model.forces:
            if not hasattr(force, "crowded") or force.impulsive or force.crowded(system.model):
                continue
            layer = getattr(force.law, "thickness", np.inf)
            sizes = [_deepest(force, a, b) for a, b in force.pairs(system.model)]
            rows = np.flatnonzero(owners == force.title)[::2]  # gap and slip of each pair
            if len(rows) == len(sizes):
                self._known.append((force, rows, np.minimum(np.array(sizes), layer)))


def _deepest(force: Any, a: Any, b: Any) -> float:
    """Return the depth, m, at which two surfaces begin to pass through each other.

    Samples of one turn back at the middle of the other; a ball does so where its centre is there, by its reach deeper.
    """
    inside = [solid.depth for solid, other in ((a, b), (b, a)) if force.law.sampled and other.spacing is not None]
    return min(a.shape.extent, b.shape.extent, *(FAR_IN * depth for depth in inside))


def _sentence(system: Any, force: Any, pair: int, depths: np.ndarray, most: np.ndarray) -> str:
    a, b = force.pairs(system.model)[pair]
    if most[pair] == getattr(force.law, "thickness", None):
        what = "the thickness of the layer"
    elif most[pair] == min(a.shape.extent, b.shape.extent):
        what = "the reach of the smaller one"
    else:
        what = f"{FAR_IN:g} of the way to the middle of one of them"
    finer = ", or a smaller spacing" if force.law.sampled else ""
    return (
        f"{force.title}: '{a.name}' and '{b.name}' have sunk into each other by {depths[pair]:.3g} m; "
        f"expected: less than {what}, {most[pair]:.3g} m, beyond which no law of contact holds. "
        f"They pass through each other: look at the units of shape and law, or give a stiffer law{finer}."
    )
