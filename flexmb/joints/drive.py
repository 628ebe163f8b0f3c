"""`Drive`: a prescribed motion of a freedom that a joint permits."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from typing import Any, ClassVar

from flexmb.constraints import Angle, InPlane, Slide, Turn
from flexmb.errors import ModelError
from flexmb.model.kinds import Joint, Part
from flexmb.model.signal import as_signal

__all__ = ["Drive"]


@dataclass(frozen=True, eq=False)
class Drive(Joint):
    """Prescribe the turn (rad) or the slide (m) of a joint along or about the z-axis of its first marker.

    The reaction of the drive is the force or moment that enforces the motion, on the body of the second marker.

    Parameters
    ----------
    name : str
    joint : str
        Name of the joint that permits the motion.
    angle : signal, rad, optional
        Angle from the x-axis of marker a to the x-axis of marker b about z of a; any number of turns.
    displacement : signal, m, optional
        Position of marker b along z of marker a. Give either angle or displacement.
    """

    _: KW_ONLY
    joint: str
    angle: Any = None
    displacement: Any = None
    markers: tuple[str, str] = ("", "")

    prescribes: ClassVar[bool] = True

    def __post_init__(self):
        Part.__post_init__(self)
        if (self.angle is None) == (self.displacement is None):
            raise ModelError(self.title, found="both" if self.angle is not None else "neither angle nor displacement",
                             expected="exactly one of angle= (rad) and displacement= (m)",
                             remedy="Give the signal of the one freedom to drive")
        for field in ("angle", "displacement"):
            value = getattr(self, field)
            if value is not None:
                object.__setattr__(self, field, as_signal(value, self.title, field))

    def check(self, model) -> None:
        """Raise ModelError if the joint does not exist or forbids the driven motion."""
        joint = model.joint(self.joint, self.title)
        wanted = Turn("z") if self.angle is not None else Slide("z")
        if wanted not in joint.permits:
            motion = "turn" if self.angle is not None else "slide"
            permitted = ", ".join(str(f) for f in joint.permits) or "nothing"
            kind = type(joint).__name__
            raise ModelError(self.title,
                             found=f"joint '{self.joint}' ({kind}) forbids the {motion} about or along z",
                             expected=f"a motion that the joint permits: {permitted}",
                             remedy="Drive another joint, or give the other of angle= and displacement=")

    def resolved_markers(self, model) -> tuple[str, str]:
        """Return the markers of the driven joint."""
        return model.joint(self.joint, self.title).markers

    def equations(self):
        """Return the one rheonomic equation."""
        return (Angle(self.angle),) if self.angle is not None else (InPlane("z", self.displacement),)
