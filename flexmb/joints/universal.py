"""`Universal`: two rotations."""

from __future__ import annotations

from dataclasses import dataclass

from flexmb.constraints import Coincident, Perpendicular, Turn, TurnOfSecond
from flexmb.model.kinds import Joint

__all__ = ["Universal"]


@dataclass(frozen=True, eq=False)
class Universal(Joint):
    """Let marker b turn about the z-axis of a and about its own z-axis; the two stay perpendicular (cross shaft).

    Parameters
    ----------
    name : str
    markers : (str, str)
        Marker a and marker b, "body.marker"; reactions are those on the body of marker b.
    """

    forbids = (Coincident(), Perpendicular("z", "z"))
    permits = (Turn("z", to="z"), TurnOfSecond("z"))
