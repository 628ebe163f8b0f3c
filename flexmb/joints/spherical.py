"""`Spherical`: three rotations."""

from __future__ import annotations

from dataclasses import dataclass

from flexmb.constraints import Ball, Coincident
from flexmb.model.kinds import Joint

__all__ = ["Spherical"]


@dataclass(frozen=True, eq=False)
class Spherical(Joint):
    """Let marker b turn freely about the origin of marker a.

    Parameters
    ----------
    name : str
    markers : (str, str)
        Marker a and marker b, "body.marker"; reactions are those on the body of marker b.
    """

    forbids = (Coincident(),)
    permits = (Ball(),)
