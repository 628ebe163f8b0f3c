"""`Prismatic`: one translation."""

from __future__ import annotations

from dataclasses import dataclass

from flexmb.constraints import InPlane, Perpendicular, Slide
from flexmb.model.kinds import Joint

__all__ = ["Prismatic"]


@dataclass(frozen=True, eq=False)
class Prismatic(Joint):
    """Let marker b slide along the z-axis of marker a without turning.

    Parameters
    ----------
    name : str
    markers : (str, str)
        Marker a and marker b, "body.marker"; reactions are those on the body of marker b.
    """

    forbids = (InPlane("x"), InPlane("y"), Perpendicular("x", "y"), Perpendicular("y", "z"), Perpendicular("z", "x"))
    permits = (Slide("z"),)
