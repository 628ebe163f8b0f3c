"""Elastic bodies that do not fit what they are joined to: they would be bent into place without a word.

A rigid part that does not fit cannot be assembled; an elastic one can, and then carries forces that nobody meant.
"""

from __future__ import annotations

from itertools import combinations
from typing import Any, NamedTuple

import numpy as np

from flexmb.constraints import Coincident
from flexmb.errors import CompileError
from flexmb.model.described import check_kind
from flexmb.model.model import Model

__all__ = ["misfits", "require_fit"]

NOTED = 1e-4
"""Misfit of two interfaces that is told, as a share of the body's size."""
REFUSED = 1e-2
"""The same from which on nothing is computed."""
APART = 0.1
"""Distance in the drawing, as a share of the body's size, at which two fixed markers cannot be meant for each other."""


class _Place(NamedTuple):
    """A joint that holds an elastic body at a marker, and the marker of the other body; both places in body axes, m."""

    joint: Any
    own: str
    other: str
    own_at: np.ndarray
    other_at: np.ndarray


def require_fit(model) -> None:
    """Raise CompileError if an elastic body does not fit the markers that joints put its interfaces to.

    Two interfaces that one rigid body, or the ground, holds must be as far apart as its markers. Two fixed markers must
    lie near each other in the drawing.
    """
    check_kind(model, Model, "Model", "Give a flexmb.Model(bodies=[...]), or flexmb.load_model('file.toml')")
    for body, size, places in _elastic(model):
        for one, two in combinations(places, 2):
            gap, own, other = _misfit(one, two)
            if one.other.partition(".")[0] == two.other.partition(".")[0] and gap > REFUSED * size:
                raise CompileError(
                    body.title,
                    found=f"'{one.own}' and '{two.own}' are {own:.6g} m apart, '{one.other}' and '{two.other}', which "
                    f"{one.joint.title} and {two.joint.title} put there, {other:.6g} m: {gap:.3g} m do not fit",
                    expected=f"the same distance, within {REFUSED:g} of the body's size ({size:.3g} m)",
                    remedy="Correct the places of these markers, or make the body of the parameters that place them",
                )
        for place in places:
            if place.joint.permits:
                continue
            ends = _ends(model, place)
            distance = float(np.linalg.norm(ends[0] - ends[1]))
            if distance > APART * size:
                raise CompileError(
                    body.title,
                    found=f"its '{place.own}' is {distance:.3g} m away from '{place.other}', to which "
                    f"{place.joint.title} fixes it: they are at {_told(ends[0])} m and {_told(ends[1])} m",
                    expected=f"markers that meet in the drawing, within {APART:g} of the body's size ({size:.3g} m)",
                    remedy="Was it made of other parameters? Reduce it again, or describe it in the model file; else "
                    "correct at= and rotation=",
                )


def misfits(model) -> list[str]:
    """Return sentences about elastic bodies that joints bend into place."""
    found = []
    for body, size, places in _elastic(model):
        for one, two in combinations(places, 2):
            gap, own, other = _misfit(one, two)
            if one.other.partition(".")[0] == two.other.partition(".")[0] and gap > NOTED * size:
                found.append(
                    f"{body.title}: '{one.own}' and '{two.own}' are {own:.6g} m apart, '{one.other}' and '{two.other}' "
                    f"{other:.6g} m. {one.joint.title} and {two.joint.title} strain the body by the difference, "
                    f"{gap:.3g} m; expected: the same distance, within {NOTED:g} of its size ({size:.3g} m)."
                )
    return found


def _elastic(model):
    """Yield every elastic body, its size, m, and the places at which joints hold it to rigid bodies or the ground."""
    bodies = {body.name: body for body in model.bodies}
    held = _held(model)
    for body in model.bodies:
        if not (body.has_frame and body.n_vector):
            continue
        size = float(np.linalg.norm(np.ptp(np.array(body.bounds(), float), axis=0)))
        places = []
        for joint in held.get(body.name, ()):
            markers = joint.resolved_markers(model)
            for own, other in (markers[:2], markers[1::-1]):
                partner = bodies.get(other.partition(".")[0])
                if own.partition(".")[0] != body.name or partner is None or partner is body or partner.n_vector:
                    continue
                places.append(_Place(joint, own, other, *(np.asarray(model.marker(m)[1].at) for m in (own, other))))
        yield body, size, places


def _held(model) -> dict[str, list]:
    """Return, by names of bodies, the joints that hold a place of them."""
    held: dict[str, list] = {}
    for joint in model.joints:
        if any(isinstance(equation, Coincident) for equation in joint.forbids):
            for name in dict.fromkeys(marker.partition(".")[0] for marker in joint.resolved_markers(model)[:2]):
                held.setdefault(name, []).append(joint)
    return held


def _misfit(one: _Place, two: _Place) -> tuple[float, float, float]:
    """Return by how much two distances differ, and the distances on the body and on the other one, m."""
    own, other = (float(np.linalg.norm(a - b)) for a, b in ((one.own_at, two.own_at), (one.other_at, two.other_at)))
    return abs(own - other), own, other


def _told(at) -> str:
    """Return a place in words."""
    return f"({', '.join(f'{x:.4g}' for x in at)})"


def _ends(model, place: _Place) -> list[np.ndarray]:
    """Return where two markers are in the drawing, (3,), m, in W."""
    ends = []
    for marker, at in ((place.own, place.own_at), (place.other, place.other_at)):
        body = model.body(marker.partition(".")[0])
        rotation = getattr(body, "rotation", None)
        turn = np.eye(3) if rotation is None else np.asarray(rotation, float)
        ends.append(np.asarray(getattr(body, "at", (0.0, 0.0, 0.0)), float) + turn @ at)
    return ends
