"""`GearPair`: two toothed wheels, or a pinion and a circular rack, whose axes may move."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from typing import ClassVar

from flexmb.constraints import Meshing
from flexmb.errors import ModelError
from flexmb.model.described import finite_array
from flexmb.model.kinds import Joint

__all__ = ["GearPair"]


@dataclass(frozen=True, eq=False)
class GearPair(Joint):
    """Let the pitch circles around the z-axes of two markers roll on each other, eq. (meshing).

    The force of the teeth acts at the pitch point, across the line of centres, so the bearings of both wheels feel it;
    a `Coupler` between their joints makes the same motion with torques only. Nothing else holds the wheels: their axes
    may be guided by joints, rollers or elastic bodies, and one may travel round the other (a planet needs no carrier).
    The force that the pressure angle adds along the line of centres is left out.

    Parameters
    ----------
    name : str
    markers : (str, str)
        Markers a and b on the axes of the wheels, both z-axes the same way. The reaction is that on the body of b.
    radii : (float, float), m
        Pitch radii of the wheels.
    inside : bool
        The smaller wheel runs inside the larger: a ring, or a rack with its teeth on the inner side.
    """

    _: KW_ONLY
    radii: tuple[float, float]
    inside: bool = False

    drawn: ClassVar[str] = "shapes"

    def __post_init__(self):
        super().__post_init__()
        given = finite_array(self.radii)
        radii = tuple(given.tolist()) if given.shape == (2,) else ()
        if not radii or min(radii) <= 0.0:
            raise ModelError(
                self.title,
                found=f"radii = {self.radii!r}",
                expected="two lengths > 0 m",
                remedy="Give the pitch radii of both wheels: half of module times teeth",
            )
        if self.inside and radii[0] == radii[1]:
            raise ModelError(
                self.title,
                found=f"radii = {self.radii!r} of wheels that mesh inside",
                expected="two radii that differ",
                remedy="The ring is larger than the wheel inside it",
            )
        object.__setattr__(self, "radii", radii)

    def equations(self):
        """Return the one equation of the teeth."""
        return (Meshing(self.radii[0], -self.radii[1] if self.inside else self.radii[1]),)
