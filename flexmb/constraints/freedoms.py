"""Primitive freedoms: what a joint permits, as unit twists of marker b relative to marker a."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from flexmb.constraints.coordinate import Coordinate
from flexmb.model.primitives import Freedom

__all__ = ["Ball", "Bend", "Helix", "RollAbout", "Slide", "Turn", "TurnOfSecond"]


@dataclass(frozen=True)
class Slide(Freedom):
    """Translation along the named axis of marker a."""

    axis: str

    role: ClassVar[str] = "slide"
    turns: ClassVar[bool] = False

    @property
    def word(self) -> str:
        """Return "slide", "slide_x" or "slide_y"."""
        return "slide" if self.axis == "z" else f"slide_{self.axis}"

    @property
    def coordinate(self) -> Coordinate:
        """Return the slide along the axis of a."""
        return Coordinate("slide", self.axis)

    def __str__(self) -> str:
        return f"a slide along {self.axis}"

    def twists(self, R_a: np.ndarray, R_b: np.ndarray, d: np.ndarray) -> np.ndarray:
        """Return the relative unit twists (k, 6) of marker b in W: velocity of b's origin, angular velocity."""
        return np.concatenate([R_a[:, "xyz".index(self.axis)], np.zeros(3)])[None]


@dataclass(frozen=True)
class Turn(Freedom):
    """Rotation about the named axis of marker a, through its origin; its angle goes to the axis `to` of marker b."""

    axis: str
    to: str = "x"

    @property
    def word(self) -> str:
        """Return "turn", or nothing for an axis that is not followed."""
        return "turn" if self.axis == "z" else ""

    role = word

    @property
    def coordinate(self) -> Coordinate:
        """Return the turn of the followed axis of b about z of a."""
        return Coordinate("turn", self.to)

    def __str__(self) -> str:
        return f"a turn about {self.axis}"

    def twists(self, R_a: np.ndarray, R_b: np.ndarray, d: np.ndarray) -> np.ndarray:
        """Return the relative unit twists (k, 6) of marker b in W; `d` = r_b - r_a."""
        axis = R_a[:, "xyz".index(self.axis)]
        return np.concatenate([np.cross(axis, d), axis])[None]


@dataclass(frozen=True)
class TurnOfSecond(Freedom):
    """Rotation about the named axis of marker b, through its origin."""

    axis: str

    @property
    def word(self) -> str:
        """Return "turn_b", or nothing for an axis that is not followed."""
        return "turn_b" if self.axis == "z" else ""

    role = word

    @property
    def coordinate(self) -> Coordinate:
        """Return the turn about z of b."""
        return Coordinate("turn", "z", swapped=True)

    def __str__(self) -> str:
        return f"a turn about {self.axis} of the second marker"

    def twists(self, R_a: np.ndarray, R_b: np.ndarray, d: np.ndarray) -> np.ndarray:
        """Return the relative unit twists (k, 6) of marker b in W."""
        return np.concatenate([np.zeros(3), R_b[:, "xyz".index(self.axis)]])[None]


@dataclass(frozen=True)
class Ball(Freedom):
    """All three rotations about the origin of marker b."""

    role: ClassVar[str] = "ball"
    labels: ClassVar[tuple[str, ...]] = ("ball_0", "ball_1", "ball_2", "ball_3")
    rate_labels: ClassVar[tuple[str, ...]] = ("ball_0", "ball_1", "ball_2")

    def __str__(self) -> str:
        return "all turns"

    def twists(self, R_a: np.ndarray, R_b: np.ndarray, d: np.ndarray) -> np.ndarray:
        """Return the relative unit twists (3, 6) of marker b in W."""
        return np.hstack([np.zeros((3, 3)), np.eye(3)])


@dataclass(frozen=True)
class Helix(Freedom):
    """Rotation about the z-axis of marker a with a translation of `pitch` (m) per turn along it."""

    pitch: float

    word: ClassVar[str] = "turn"
    role: ClassVar[str] = "screw"

    @property
    def coordinate(self) -> Coordinate:
        """Return the turn about z of a."""
        return Coordinate("turn", "x")

    def __str__(self) -> str:
        return f"a turn about z that slides {self.pitch:g} m per turn"

    def twists(self, R_a: np.ndarray, R_b: np.ndarray, d: np.ndarray) -> np.ndarray:
        """Return the relative unit twists (k, 6) of marker b in W; `d` = r_b - r_a."""
        axis = R_a[:, 2]
        return np.concatenate([np.cross(axis, d) + self.pitch / (2.0 * np.pi) * axis, axis])[None]


@dataclass(frozen=True)
class Bend(Freedom):
    """Two shafts bend against each other: rotations in the plane that halves the angle between their z-axes."""

    def __str__(self) -> str:
        return "a bend between the two shafts"

    def twists(self, R_a: np.ndarray, R_b: np.ndarray, d: np.ndarray) -> np.ndarray:
        """Return the relative unit twists (2, 6) of marker b in W."""
        middle = R_a[:, 2] + R_b[:, 2]
        first = np.cross(middle, R_a[:, 0])
        return np.hstack([np.zeros((2, 3)), np.stack([first, np.cross(middle, first)])])


@dataclass(frozen=True)
class RollAbout(Freedom):
    """All three rotations about the point where a disc or sphere of `radius` (m) touches the x-y plane of marker a."""

    radius: float
    disc: bool

    def __str__(self) -> str:
        return "rolling"

    def twists(self, R_a: np.ndarray, R_b: np.ndarray, d: np.ndarray) -> np.ndarray:
        """Return the relative unit twists (3, 6) of marker b in W."""
        n = R_a[:, 2]
        toward = n - (R_b[:, 2] @ n) * R_b[:, 2] if self.disc else n
        rho = -self.radius * toward / np.linalg.norm(toward)
        return np.hstack([np.cross(rho, np.eye(3)), np.eye(3)])
