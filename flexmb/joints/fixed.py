"""`Fixed`: no relative motion."""

from __future__ import annotations

from dataclasses import dataclass

from flexmb.constraints import Coincident, Perpendicular
from flexmb.model.kinds import Joint

__all__ = ["Fixed"]


@dataclass(frozen=True, eq=False)
class Fixed(Joint):
    """Let nothing move between the two markers.

    Parameters
    ----------
    name : str
    markers : (str, str)
        Marker a and marker b, "body.marker"; reactions are those on the body of marker b.
    """

    forbids = (Coincident(), Perpendicular("x", "y"), Perpendicular("y", "z"), Perpendicular("z", "x"))
    permits = ()
