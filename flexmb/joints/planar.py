"""`Planar`: two translations and one rotation."""

from __future__ import annotations

from dataclasses import dataclass

from flexmb.constraints import InPlane, Perpendicular, Slide, Turn
from flexmb.model.kinds import Joint

__all__ = ["Planar"]


@dataclass(frozen=True, eq=False)
class Planar(Joint):
    """Let marker b move in the x-y plane of marker a and turn about its normal z.

    Parameters
    ----------
    name : str
    markers : (str, str)
        Marker a and marker b, "body.marker"; reactions are those on the body of marker b.
    """

    forbids = (InPlane("z"), Perpendicular("z", "x"), Perpendicular("z", "y"))
    permits = (Slide("x"), Slide("y"), Turn("z"))
