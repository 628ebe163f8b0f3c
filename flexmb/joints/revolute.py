"""`Revolute`: one rotation."""

from __future__ import annotations

from dataclasses import dataclass

from flexmb.constraints import Coincident, Perpendicular, Turn
from flexmb.model.kinds import Joint

__all__ = ["Revolute"]


@dataclass(frozen=True, eq=False)
class Revolute(Joint):
    """Let marker b turn about the z-axis of marker a.

    Parameters
    ----------
    name : str
    markers : (str, str)
        Marker a and marker b, "body.marker"; reactions are those on the body of marker b.
    """

    forbids = (Coincident(), Perpendicular("z", "x"), Perpendicular("z", "y"))
    permits = (Turn("z"),)
