"""`ConstantVelocity`: a homokinetic shaft coupling."""

from __future__ import annotations

from dataclasses import dataclass

from flexmb.constraints import Bend, Coincident, NoTwist
from flexmb.model.kinds import Joint

__all__ = ["ConstantVelocity"]


@dataclass(frozen=True, eq=False)
class ConstantVelocity(Joint):
    """Let two shafts along the z-axes of both markers bend against each other and turn at the same speed.

    Both z-axes point the same way along the straight shaft. The relative rotation stays in the plane that halves the
    angle between the shafts, so one turn of a is one turn of b at any bending angle below 180 degrees, eq. (no-twist).

    Parameters
    ----------
    name : str
    markers : (str, str)
        Marker a and marker b, "body.marker"; reactions are those on the body of marker b.
    """

    forbids = (Coincident(), NoTwist())
    permits = (Bend(),)
