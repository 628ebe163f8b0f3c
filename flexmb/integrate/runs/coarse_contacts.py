"""Contacts that close and open again within a few steps: steps that resolve an impact badly give a wrong rebound."""

from __future__ import annotations

from typing import Any

import numpy as np

from flexmb.integrate.runs.spells import POWER
from flexmb.math.switches import FORMULA, HELD, KINK, TURN_GAP

__all__ = ["CoarseContacts"]

WITHIN = 0.01
"""Error of a rebound, relative to the change of speed in the contact, for which an integrator names the steps that it
takes (`steps_in_contact`); from there on it is told."""
ENDED, FEWEST = "contacts ended", "fewest steps in a contact"
"""Names in the statistics."""


class CoarseContacts:
    """The contacts of a run that are resolved worst, by owner.

    Parameters
    ----------
    integrator
        What has resolved them: with `steps_in_contact`, if it follows displacements only.
    """

    def __init__(self, integrator: Any):
        self.integrator = integrator
        self.needed: float = getattr(integrator, "steps_in_contact", 0.0)
        self.worst: dict[str, dict[str, float]] = {}
        self.largest = {"m/s": 0.0, "rad/s": 0.0}
        self.told: set[str] = set()

    def look(self, system: Any, switching: Any) -> dict[str, Any]:
        """Take the contacts that have ended since the last look; return their number, and the fewest steps in one.

        What a relay or a quantiser looks at passes zero as a gap does, and is none: its values are found from outside.
        """
        if switching is None:
            return {}
        spells, limits, now = switching.spells, switching.limits[0], switching.now
        gone = (spells["ended"] > 0.0) & ~((now[:, 0] == KINK) & (now[:, FORMULA] == HELD))
        if not np.any(gone):
            return {}
        ended, fewest = int(spells["ended"][gone].sum()), float(spells["worst_steps"][gone].min())
        for n in np.flatnonzero(gone):
            angle, spell, owner = switching.now[n, 0] == TURN_GAP, spells[n], system.switch_owners[n]
            unit, floor = ("rad/s", limits.share) if angle else ("m/s", limits.floor)
            self.largest[unit] = max(self.largest[unit], float(spell.largest_change))
            found = {"steps": spell.worst_steps, "span": spell.worst_span, "change": spell.worst_change}
            found = {**{name: float(x) for name, x in found.items()}, "floor": float(floor), "angle": float(angle)}
            if owner not in self.worst or _loss(found) > _loss(self.worst[owner]):
                self.worst[owner] = found
        for name in ("ended", "worst_steps", "worst_span", "worst_change"):
            spells[name] = 0.0
        return {ENDED: ended, FEWEST: round(fewest, 2)}

    def sentences(self, duration: float) -> list[str]:
        """Return a warning for each owner that is new, of a run that has lasted so long (s)."""
        if not self.needed:
            return []
        told = []
        for owner, found in self.worst.items():
            unit = "rad/s" if found["angle"] else "m/s"
            error = min(1.0, WITHIN * (self.needed / found["steps"]) ** POWER)
            lost = error * found["change"]
            if owner in self.told or error <= WITHIN or lost <= WITHIN * self.largest[unit]:
                continue
            if lost * duration <= found["floor"]:
                continue
            self.told.add(owner)
            told.append(self._sentence(owner, found, error, unit))
        return told

    def _sentence(self, owner: str, found: dict[str, float], error: float, unit: str) -> str:
        name = type(self.integrator).__name__
        span = found["span"] * max(0.5, 1.0 - 0.5 / found["steps"])  # few steps see an impact too long
        step = 0.9 * span / self.needed
        fixed = getattr(self.integrator, "step", None) is not None
        less = (
            f"Give step={step:.2g}, or leave it out: the step then follows the impact"
            if fixed
            else f"Give a smaller rtol than {self.integrator.rtol:g}, or largest={step:.2g}"
        )
        return (
            f"{owner}: it closed and opened again within {found['steps']:.2g} steps of {name}, in "
            f"{found['span']:.3g} s, with a change of speed of {found['change']:.3g} {unit}, of which up to "
            f"{100.0 * error:.3g} % is wrong; expected: {self.needed:g} steps or more in a contact, "
            f"for {100.0 * WITHIN:g} %. {less}."
        )


def _loss(found: dict[str, float]) -> float:
    return found["change"] / found["steps"] ** POWER
