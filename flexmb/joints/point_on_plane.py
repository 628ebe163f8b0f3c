"""`PointOnPlane`: a point that stays in a plane, as a ball between two plates or a foot on ice."""

from __future__ import annotations

from dataclasses import dataclass

from flexmb.constraints import Ball, InPlane, Slide
from flexmb.model.kinds import Joint

__all__ = ["PointOnPlane"]


@dataclass(frozen=True, eq=False)
class PointOnPlane(Joint):
    """Let the origin of marker b move in the x-y plane of marker a, and b turn freely: a ball between two plates.

    It holds both ways; what may lift off is a `Contact`. `Planar` keeps the axes parallel too, `InLine` leaves one
    direction only.

    Parameters
    ----------
    name : str
    markers : (str, str)
        Marker a of the plane, marker b of the point, "body.marker"; the reaction is along z of marker a.
    """

    forbids = (InPlane("z"),)
    permits = (Slide("x"), Slide("y"), Ball())
