"""`Drive`: a prescribed motion of a freedom that a joint permits."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from typing import Any, ClassVar

from flexmb.constraints import Angle, InPlane, joint_coordinate
from flexmb.errors import ModelError
from flexmb.model.kinds import Joint
from flexmb.model.signal import as_signal

__all__ = ["Drive"]


@dataclass(frozen=True, eq=False)
class Drive(Joint):
    """Prescribe a turn (rad) or a slide (m) that a joint permits; other freedoms of the joint stay free.

    The reaction of the drive is the force or moment that enforces the motion, on the body of the second marker.

    Parameters
    ----------
    name : str
    joint : str
        Name of the joint that permits the motion.
    angle : signal, rad, optional
        Angle from the x-axis of marker a to the x-axis of marker b about z of a (to the z-axis of b in a universal
        joint); any number of turns.
    displacement : signal, m, optional
        Position of marker b along an axis of marker a. Give either angle or displacement.
    freedom : str, optional
        Which one: "turn" about z of marker a or "turn_b" about z of marker b (from the x-axis of b to the z-axis of
        a, counted against the sense of z of b: positive if b turns forwards); "slide" along z of marker a, "slide_x" or
        "slide_y". By default "turn" and "slide".
    """

    _: KW_ONLY
    joint: str
    angle: Any = None
    displacement: Any = None
    freedom: str | None = None
    markers: tuple[str, str] = ("", "")

    prescribes: ClassVar[bool] = True
    works: ClassVar[bool] = True

    def __post_init__(self):
        super().__post_init__()
        if (self.angle is None) == (self.displacement is None):
            raise ModelError(
                self.title,
                found="both" if self.angle is not None else "neither angle nor displacement",
                expected="exactly one of angle= (rad) and displacement= (m)",
                remedy="Give the signal of the one freedom to drive",
            )
        for field in ("angle", "displacement"):
            value = getattr(self, field)
            if value is not None:
                object.__setattr__(self, field, as_signal(value, self.title, field))

    def check(self, model) -> None:
        """Raise ModelError if the joint does not exist or forbids the driven motion."""
        self.equations_in(model)

    def resolved_markers(self, model) -> tuple[str, ...]:
        """Return the markers of the driven joint."""
        return model.joint(self.joint, self.title).markers

    def equations_in(self, model):
        """Return the one rheonomic equation."""
        kind = "turn" if self.angle is not None else "slide"
        coordinate = joint_coordinate(model.joint(self.joint, self.title), self.title, self.freedom or kind, kind)
        if kind == "turn":
            return (Angle(self.angle, coordinate),)
        return (InPlane(coordinate.axis, self.displacement),)
