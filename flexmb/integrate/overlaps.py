"""Surfaces that overlap when a run begins."""

from __future__ import annotations

import numpy as np

from flexmb.integrate.runs.switches import new_switching
from flexmb.system.program import evaluate

__all__ = ["overlaps"]

DEEP = 0.01
"""Penetration, in radii of the smaller surface, that a load at rest hardly explains."""
LISTED = 6


def overlaps(system, state) -> list[str]:
    """Return a sentence for each contact whose surfaces overlap far at a state."""
    model = system.model
    touching = [force for force in model.forces if hasattr(force, "pairs") and not force.impulsive]
    if not touching:
        return []
    work = system.workspace()
    evaluate(system.program, state, work)
    now = new_switching(system, state, work, floor=0.0).now
    owners = np.array(system.switch_owners)
    told = []
    for force in touching:
        gaps = now[owners == force.title][::2, 1]
        found = []
        for (a, b), gap in zip(force.pairs(model), gaps):
            size = min(a.shape.extent, b.shape.extent)
            if gap < -DEEP * size:
                found.append(f"'{a.name}' and '{b.name}' by {-gap:.4g} m")
        if found:
            more = f" and {len(found) - LISTED} more" if len(found) > LISTED else ""
            told.append(
                f"{force.title}: at the start {', '.join(found[:LISTED])}{more} overlap; expected: surfaces that are "
                "apart or lightly pressed. Move the bodies apart, or let them come to rest with statics first"
            )
    return told
