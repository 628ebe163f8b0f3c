"""Which bodies of a model joints and forces connect."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from flexmb.model.model import Model

__all__ = ["beside", "held_by_ground", "places_of", "reached"]


def places_of(part, model: Model) -> tuple[str, ...]:
    """Return the markers on which a joint or force acts, "body.marker"; its joint's where it names one."""
    places = [*(getattr(part, "markers", None) or ()), getattr(part, "marker", None)]
    if hasattr(part, "touching_markers"):
        places += part.touching_markers(model)
    if part.family == "Joint":
        places += part.resolved_markers(model)
    joint, body = getattr(part, "joint", None), getattr(part, "body", None)
    if isinstance(joint, str):
        places += getattr(model.joint(joint, part.title), "markers", ()) or ()
    if isinstance(body, str):
        places.append(f"{body}.")
    return tuple(place for place in places if isinstance(place, str) and place)


def beside(model: Model) -> dict[str, set[str]]:
    """Return by the name of each body those that a joint or a force connects with it; of a part that acts on many
    bodies one is connected with all others."""
    found: dict[str, set[str]] = {body.name: set() for body in model.bodies}
    for part in (*model.joints, *model.forces):
        together = {place.rpartition(".")[0] for place in places_of(part, model)} & found.keys()
        first = next(iter(together), "")
        for name in together - {first}:
            found[first].add(name)
            found[name].add(first)
    return found


def reached(connected: Mapping[str, set[str]], start: Iterable[str], without: str = "") -> set[str]:
    """Return the bodies that connections lead to from some bodies, these included, and never through `without`."""
    known = set(start) - {without}
    ahead = list(known)
    while ahead:
        new = connected[ahead.pop()] - known - {without}
        known |= new
        ahead += new
    return known


def held_by_ground(model: Model) -> set[str]:
    """Return the names of the bodies that joints and forces connect, directly or not, to a body that does not move."""
    return reached(beside(model), (body.name for body in model.bodies if not body.n_velocities))
