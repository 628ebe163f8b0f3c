"""Surfaces that overlap when a run begins."""

from __future__ import annotations

import numpy as np

from flexmb.forces.crowd import gaps_in_crowd
from flexmb.integrate.runs.switches import new_switching
from flexmb.math.switches import GAP
from flexmb.surfaces.advancement import POSE
from flexmb.surfaces.neighbours import near_among
from flexmb.surfaces.records import REACH
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
    now = new_switching(system, state, work, floor=0.0).now
    owners = np.array(system.switch_owners)
    told = []
    for force in touching:
        rows = now[owners == force.title]
        if not hasattr(force, "crowded"):
            told += _overlap_of_skins(force, system, work, *rows[0, :2])
            continue
        found = []
        for (a, b), gap in _gaps_in_crowd(force, model, rows) if force.crowded(model) else _gaps(force, model, rows):
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


def _gaps(force, model, rows):
    """Return pairs of surfaces, each with its gap, m, of which the first of two rows of switches tells."""
    return zip(force.pairs(model), rows[::2, 1])


def _gaps_in_crowd(force, model, rows):
    """Return the same for those surfaces of a crowd that are near each other; a row has the place of a surface."""
    surfaces, side, body = force.members(model)
    packed = [s.packed for s in surfaces]
    reach = np.array([numbers[REACH] for numbers in packed])
    pairs = near_among(np.ascontiguousarray(rows[:, POSE : POSE + 3]), reach, side, body)
    gaps = np.zeros(len(pairs))
    starts = np.concatenate([[0], np.cumsum([len(numbers) for numbers in packed])])
    gaps_in_crowd(np.concatenate(packed), starts, int(force.law.sampled), rows, pairs, gaps)
    return [((surfaces[i], surfaces[j]), gap) for (i, j), gap in zip(pairs, gaps)]


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
