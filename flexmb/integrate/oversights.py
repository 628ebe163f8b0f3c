"""What is worth knowing about a model before it runs: loose bodies, no gravity, laws that steps do not see.

It may be meant, so it is a note.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from flexmb.model.connections import places_of
from flexmb.model.model import Model

__all__ = ["oversights"]

LISTED = 12
MOST_PAIRS = 5000
"""Of a contact in which each pair of surfaces is looked at."""


def oversights(model: Model) -> list[str]:
    """Return sentences about what is perhaps not meant."""
    held = {place.rpartition(".")[0] for part in (*model.joints, *model.forces) for place in places_of(part, model)}
    loose = [body for body in model.bodies if body.n_velocities and body.name not in held]
    found = []
    if loose:
        names = ", ".join(f"'{body.name}'" for body in loose[:LISTED]) + (", ..." if len(loose) > LISTED else "")
        found.append(f"nothing holds {names}: no joint and no force acts on a marker there; it moves freely")
    falls = np.any(model.gravity) or any(force.lasting for force in model.forces)
    if not falls and any(body.n_velocities for body in model.bodies):
        found.append("there is no gravity; gravity=(0, 0, -9.81) gives weight")
    unseen: dict[str, list[str]] = {}
    for force in model.forces:
        if passed_over := force.unseen_in(model):
            unseen.setdefault(passed_over, []).append(force.title)
    found += [f"{', '.join(titles[:LISTED])}: {why}" for why, titles in unseen.items()]
    doubted: dict[str, list[str]] = {}
    for sensor in model.sensors:
        if why := sensor.doubt(model):
            doubted.setdefault(why, []).append(sensor.title)
    found += [f"{', '.join(titles[:LISTED])}: {why}" for why, titles in doubted.items()]
    found += [f"{surface.title}: {why}" for surface, why in _doubted(model)[:LISTED]]
    found += _twice(model)[:LISTED]
    return found


def _doubted(model: Model) -> list[tuple[Any, str]]:
    """Return surfaces with what is perhaps not meant by their shapes."""
    shapes = [(surface, getattr(surface, "shape", None)) for surface in model.surfaces]
    return [(surface, shape.doubt) for surface, shape in shapes if shape is not None and shape.doubt]


def _twice(model: Model) -> list[str]:
    """Return sentences about surfaces that press twice: two at one place, and pairs that two contacts share."""
    told, places, of_pair = [], {}, {}
    for surface in model.surfaces:
        shape = getattr(surface, "shape", None)
        if shape is not None:
            own = (surface.marker, type(shape), shape.numbers().tobytes())
            other = places.setdefault(own, surface.name)
            if other != surface.name:
                told.append(
                    f"surfaces '{other}' and '{surface.name}' are the same: what touches both is pressed twice; remove "
                    "one of them"
                )
    for force in model.forces:
        if not hasattr(force, "pairs") or force.crowded(model):
            continue
        if force.impulsive and len(force.groups[0]) * len(force.groups[1]) > MOST_PAIRS:
            continue
        for a, b in force.pairs(model):
            other = of_pair.setdefault(frozenset((a.name, b.name)), force.title)
            if other != force.title:
                told.append(
                    f"{other} and {force.title} both join surfaces '{a.name}' and '{b.name}': their forces add; name "
                    "each pair in one contact alone"
                )
                break
    return told
