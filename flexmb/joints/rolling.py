"""`Rolling`: a wheel or a ball on a plane."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass

from flexmb.constraints import NoSlip, RollAbout, Touching
from flexmb.model.kinds import Joint

__all__ = ["Rolling"]


@dataclass(frozen=True, eq=False)
class Rolling(Joint):
    """Let a disc or sphere around marker b roll without slip on the x-y plane of marker a.

    Contact is a holonomic equation, eq. (touching); the two of rolling are non-holonomic, eq. (no-slip): they restrict
    velocities, not places. The contact never opens: the reaction tells where it would have to. The disc must not lie
    flat.

    Parameters
    ----------
    name : str
    markers : (str, str)
        Marker a of the plane with its normal z; marker b, the centre of the wheel, whose z is the axis of a disc.
    radius : float, m
    disc : bool
        False for a sphere.
    """

    _: KW_ONLY
    radius: float
    disc: bool = True

    def __post_init__(self):
        super().__post_init__()
        self.require_positive("radius")

    @property
    def permits(self):
        """All rotations about the contact point."""
        return (RollAbout(self.radius, self.disc),)

    def equations(self):
        """Return the equation of contact and the two of rolling."""
        return (Touching(self.radius, self.disc), NoSlip(self.radius, self.disc))
