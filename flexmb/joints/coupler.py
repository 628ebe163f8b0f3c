"""`Coupler`: gears, belts, levers: two joints move with a ratio."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from typing import ClassVar

from flexmb.constraints import Coupled, joint_coordinate
from flexmb.errors import ModelError
from flexmb.model.described import entries_of, is_number
from flexmb.model.kinds import Joint

__all__ = ["Coupler"]


@dataclass(frozen=True, eq=False)
class Coupler(Joint):
    """Let the coordinates of two joints keep the ratio ``x_A - x_A0 = ratio (x_B - x_B0)``, eq. (coupled).

    Coordinates are turns (rad, counted through full turns) and slides (m); x_A0 and x_B0 are their values in the
    configuration as described. Gears on parallel axes with radii r_A and r_B, joined to one frame, have the ratio
    -r_B/r_A if they mesh outside, +r_B/r_A if one is a ring. For a planetary gear take the joints between the wheels
    and the carrier; for a right-angle gearbox two revolute joints on its casing. The reaction is that on the second
    marker of the first joint; the casing carries the difference of the torques.

    Parameters
    ----------
    name : str
    joints : (str, str)
        Names of the joints A and B.
    ratio : float, - (m/rad for a slide and a turn)
        Speed of A over speed of B.
    freedoms : (str, str), optional
        Which freedoms, where a joint has several: "turn", "slide", "turn_b" (about the z-axis of its second marker),
        "slide_x", "slide_y". By default the turn of joints that turn, the slide of others.
    """

    _: KW_ONLY
    joints: tuple[str, str]
    ratio: float
    freedoms: tuple[str | None, str | None] | None = None
    markers: tuple[str, str] = ("", "")

    couples: ClassVar[bool] = True

    def __post_init__(self):
        super().__post_init__()
        for field in ("joints", "freedoms"):
            value = getattr(self, field)
            if value is None and field == "freedoms":
                continue
            if len(entries_of(value)) != 2 or not all(isinstance(name, str | None) for name in value):
                raise ModelError(
                    self.title, found=f"{field} = {value!r}", expected="two names", remedy='Write joints=("A", "B")'
                )
            object.__setattr__(self, field, tuple(value))
        if not is_number(self.ratio) or self.ratio == 0.0:
            raise ModelError(
                self.title,
                found=f"ratio = {self.ratio!r}",
                expected="a finite number other than 0",
                remedy="ratio is the speed of the first joint divided by the speed of the second",
            )

    def check(self, model) -> None:
        """Raise ModelError if a joint does not exist or has no such coordinate, or both are the same."""
        first, second = self.joints
        if first == second and (self.freedoms is None or self.freedoms[0] == self.freedoms[1]):
            raise ModelError(
                self.title,
                found=f"joint '{first}' is coupled with itself",
                expected="two joints, or two freedoms of one",
                remedy="Name another joint, or freedoms=",
            )
        self._coordinates(model)

    def _coordinates(self, model):
        wanted = self.freedoms or (None, None)
        return tuple(
            joint_coordinate(model.joint(name, self.title), self.title, freedom)
            for name, freedom in zip(self.joints, wanted, strict=True)
        )

    def resolved_markers(self, model) -> tuple[str, ...]:
        """Return the four markers of both joints."""
        return tuple(m for name in self.joints for m in model.joint(name, self.title).markers)

    def equations_in(self, model):
        """Return the one equation between the coordinates of the joints."""
        return (Coupled(*self._coordinates(model), self.ratio),)
