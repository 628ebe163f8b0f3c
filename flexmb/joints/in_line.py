"""`InLine`: a ball that slides in a tube."""

from __future__ import annotations

from dataclasses import dataclass

from flexmb.constraints import Ball, InPlane, Slide
from flexmb.model.kinds import Joint

__all__ = ["InLine"]


@dataclass(frozen=True, eq=False)
class InLine(Joint):
    """Let marker b slide along the z-axis of marker a and turn freely: a ball in a straight tube.

    A telescopic strut between two ball ends is a body with `Universal` at one end and `InLine` at the other; a
    `SpringDamper` between the ends gives it its axial stiffness. For a curved track take `PointOnCurve`.

    Parameters
    ----------
    name : str
    markers : (str, str)
        Marker a and marker b, "body.marker"; reactions are those on the body of marker b.
    """

    forbids = (InPlane("x"), InPlane("y"))
    permits = (Slide("z"), Ball())
