"""Elements that collapse or turn inside out: where that begins, no later sample means anything."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from flexmb.model.kinds import Body

__all__ = ["EXPECTED", "REMEDY", "Inversion", "first_inversion", "may_invert"]

EXPECTED = "elements with a positive length and volume"
REMEDY = "Check the loads against the stiffness; use more elements, or a smaller step where they hit fast"


class Inversion(NamedTuple):
    """sample : number of the first sample; title : of the body; found : which element, and how."""

    sample: int
    title: str
    found: str


def may_invert(model) -> bool:
    """Has a model bodies whose elements can turn inside out?"""
    return any(map(_inverts, model.bodies))


def _inverts(body: Body) -> bool:
    return type(body).inversion is not Body.inversion


def first_inversion(system, q: np.ndarray) -> Inversion | None:
    """Return the first inversion of an element in the samples q (nt, nq), or None."""
    found = []
    for body in filter(_inverts, system.model.bodies):
        one = body.inversion(q[:, system.body_slices[body.name][0]]) if len(q) else None
        if one is not None:
            found.append(Inversion(one[0], body.title, one[1]))
    return min(found, default=None)
