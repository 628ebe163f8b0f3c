"""`RackAndPinion`: a wheel that turns drives a rack."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from typing import ClassVar

from flexmb.constraints import Coupled, joint_coordinate
from flexmb.errors import ModelError
from flexmb.model.described import entries_of, is_number
from flexmb.model.kinds import Joint

__all__ = ["RackAndPinion"]


@dataclass(frozen=True, eq=False)
class RackAndPinion(Joint):
    """Let a rack slide by ``s - s0 = radius (theta - theta0)`` while its pinion turns, eq. (coupled).

    The reaction is the force of the teeth along the slide, on the second marker of the rack's joint.

    Parameters
    ----------
    name : str
    joints : (str, str)
        Name of the pinion's joint, which turns, and of the rack's joint, which slides.
    radius : float, m
        Pitch radius of the pinion; negative if a positive turn moves the rack backwards.
    """

    _: KW_ONLY
    joints: tuple[str, str]
    radius: float
    markers: tuple[str, str] = ("", "")

    couples: ClassVar[bool] = True

    def __post_init__(self):
        super().__post_init__()
        if len(entries_of(self.joints)) != 2 or not all(isinstance(name, str) for name in self.joints):
            raise ModelError(
                self.title,
                found=f"joints = {self.joints!r}",
                expected="two names, pinion and rack",
                remedy='Write joints=("pinion axis", "rack guide")',
            )
        object.__setattr__(self, "joints", tuple(self.joints))
        if not is_number(self.radius) or self.radius == 0.0:
            raise ModelError(
                self.title,
                found=f"radius = {self.radius!r}",
                expected="a length other than 0 m",
                remedy="Give the pitch radius: half of module times teeth",
            )

    def check(self, model) -> None:
        """Raise ModelError if a joint does not exist, the first does not turn or the second does not slide."""
        self.equations_in(model)

    def resolved_markers(self, model) -> tuple[str, ...]:
        """Return the markers of the rack's joint, then of the pinion's."""
        return tuple(m for name in self.joints[::-1] for m in model.joint(name, self.title).markers)

    def equations_in(self, model):
        """Return the one equation between slide and turn."""
        pinion, rack = (model.joint(name, self.title) for name in self.joints)
        return (
            Coupled(
                joint_coordinate(rack, self.title, kind="slide"),
                joint_coordinate(pinion, self.title, kind="turn"),
                self.radius,
            ),
        )
