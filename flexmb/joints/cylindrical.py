"""`Cylindrical`: one rotation and one translation."""

from __future__ import annotations

from dataclasses import dataclass

from flexmb.constraints import InPlane, Perpendicular, Slide, Turn
from flexmb.model.kinds import Joint

__all__ = ["Cylindrical"]


@dataclass(frozen=True, eq=False)
class Cylindrical(Joint):
    """Let marker b turn about and slide along the z-axis of marker a.

    Parameters
    ----------
    name : str
    markers : (str, str)
        Marker a and marker b, "body.marker"; reactions are those on the body of marker b.
    """

    forbids = (Perpendicular("z", "x"), Perpendicular("z", "y"), InPlane("x"), InPlane("y"))
    permits = (Slide("z"), Turn("z"))
