"""`Screw`: turning advances."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass

import numpy as np

from flexmb.constraints import Coordinate, Coupled, Helix, InPlane, Perpendicular, Slide, Turn
from flexmb.errors import ModelError
from flexmb.model.described import is_number
from flexmb.model.kinds import Joint

__all__ = ["Screw"]


@dataclass(frozen=True, eq=False)
class Screw(Joint):
    """Let marker b turn about the z-axis of marker a and advance along it by `pitch` per turn.

    With the turn theta (counted through full turns) and the slide s: ``s - s0 = pitch / (2 pi) (theta - theta0)``,
    eq. (coupled), from the configuration as described.

    Parameters
    ----------
    name : str
    markers : (str, str)
        Marker a and marker b, "body.marker"; reactions are those on the body of marker b.
    pitch : float, m
        Advance along z per turn; positive for a right-handed screw.
    """

    _: KW_ONLY
    pitch: float

    forbids = (Perpendicular("z", "x"), Perpendicular("z", "y"), InPlane("x"), InPlane("y"))

    def __post_init__(self):
        super().__post_init__()
        if not is_number(self.pitch) or self.pitch == 0.0:
            raise ModelError(
                self.title,
                found=f"pitch = {self.pitch!r}",
                expected="a length per turn other than 0 m",
                remedy="Use Revolute for a joint that turns without advancing",
            )

    @property
    def permits(self):
        """One freedom, the screw motion; its turn and its slide are coordinates."""
        return (Helix(self.pitch),)

    @property
    def coordinates(self):
        """What drives and forces may act on."""
        return (Turn("z"), Slide("z"))

    def equations(self):
        """Return the equations of a cylindrical joint, and the ratio of slide and turn (derivatives: `coupled.py`)."""
        return (*self.forbids, Coupled(Coordinate("slide", "z"), Coordinate("turn", "x"), self.pitch / (2.0 * np.pi)))
