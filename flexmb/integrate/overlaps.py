"""Surfaces that overlap when a run begins."""

from __future__ import annotations

import numpy as np

from flexmb.integrate.runs.switching import PassedOver, new_switching
from flexmb.math.switches import GAP
from flexmb.system.program import evaluate

__all__ = ["overlaps"]

DEEP = 0.01
"""Penetration, in radii of the smaller surface, that a load at rest hardly explains."""
LISTED = 6


def overlaps(system, state) -> list[str]:
    """Return a sentence for each contact whose surfaces overlap far at a state."""
    model = system.model
    touching = [force for force in model.forces if hasattr(force, "spots") and not force.impulsive]
    if not touching:
        return []
    work = system.workspace()
    evaluate(system.program, state, work)
    now = new_switching(system, state, work, PassedOver()).now
    owners = np.array(system.switch_owners)
    told = []
    for force in touching:
        rows = now[owners == force.title]
        if not hasattr(force, "crowded"):
            told += _overlap_of_skins(force, system, work, *rows[0, :2])
            continue
        found = []
        for (a, b), gap in force.gaps(model, rows):
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


def _overlap_of_skins(force, system, work, kind: float, gap: float) -> list[str]:
    """Return a sentence if the deepest point of one skin lies far below the faces of the other."""
    sizes = []
    for body, skin in force.sides(system.model):
        names = [f"{body.name}.{patch.marker}" for patch in body.skin_patches[skin]]
        places = work.markers["r"][[system.marker_index[name] for name in names]]
        sizes.append(0.5 * float(np.linalg.norm(np.ptp(places, axis=0))))
    if kind != GAP or gap >= -DEEP * min(sizes):
        return []
    return [
        f"{force.title}: at the start '{force.surfaces[0]}' lies in '{force.surfaces[1]}' by {-gap:.4g} m; expected: "
        "skins that are apart or lightly pressed. Move the bodies apart, or let them come to rest with statics first"
    ]
