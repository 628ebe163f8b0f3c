"""`Outline`, `Disc` and `SmoothOutline`: profiles from pieces, a circle, and a smooth curve through points."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from flexmb.errors import ModelError
from flexmb.model.described import finite_array
from flexmb.profiles.pieces import Arc, Involute, Line, Segments, Spline, cubics, point_of
from flexmb.profiles.profile import Profile
from flexmb.profiles.segments import ARC, LINE

__all__ = ["Disc", "Outline", "SmoothOutline"]


@dataclass(frozen=True, kw_only=True, eq=False)
class Outline(Profile):
    """A profile from lines, arcs, splines and involutes, one after another.

    Walking along it the material lies to the left: counter-clockwise around a part, clockwise around a hole or along
    the walls of a slot. An open profile is a wall; it ends where it ends.

    Parameters
    ----------
    start : (2,), m
    pieces : list of Line, Arc, Spline and Involute
    ends : bool
        The profile ends where its last piece does; by default a line closes it if it has not returned to its start.
    """

    start: Any
    pieces: Any
    ends: bool = False

    def __post_init__(self):
        object.__setattr__(self, "start", tuple(point_of(self.start, self.title, "start").tolist()))
        pieces = self.pieces
        if not isinstance(pieces, list | tuple) or not all(
            isinstance(p, Line | Arc | Spline | Involute) for p in pieces
        ):
            raise ModelError(
                self.title,
                found=f"pieces = {pieces!r:.60}",
                expected="a list of Line, Arc, Spline and Involute",
                remedy="Write pieces=[Line(to=(0.1, 0)), Arc(center=(0.1, 0.05), sweep=3.14)]",
            )
        object.__setattr__(self, "pieces", tuple(pieces))
        if not pieces:
            raise ModelError(self.title, found="no pieces", expected="one piece or more", remedy="Add a Line")
        super().__post_init__()

    def segments(self) -> tuple[Segments, bool]:
        """Return the segments of all pieces."""
        at = np.array(self.start)
        found: Segments = []
        for piece in self.pieces:
            more, at = piece.segments(at)
            found.extend(more)
        back = np.array(self.start) - at
        size = max(float(np.abs(numbers).max()) for _, numbers in found)
        if not self.ends and float(np.hypot(*back)) > 1e-9 * size:
            found.append((LINE, np.concatenate([at, back])))
        return found, not self.ends


@dataclass(frozen=True, kw_only=True, eq=False)
class Disc(Profile):
    """A circle: a roller, or an eccentric where the centre is not the axis.

    Parameters
    ----------
    radius : float, m
    center : (2,), m
    hollow : bool
        The material lies around it: a bore.
    """

    radius: float
    center: Any = (0.0, 0.0)
    hollow: bool = False

    def __post_init__(self):
        object.__setattr__(self, "center", tuple(point_of(self.center, self.title, "center").tolist()))
        self.require_positive("radius")
        super().__post_init__()

    def segments(self) -> tuple[Segments, bool]:
        """Return the circle in two halves."""
        half = -np.pi if self.hollow else np.pi
        return [(ARC, np.array([*self.center, self.radius, start, half])) for start in (0.0, half)], True


@dataclass(frozen=True, kw_only=True, eq=False)
class SmoothOutline(Profile):
    """A smooth curve through points: the cubic spline over the lengths of its chords, periodic where it is closed.

    Walking along it the material lies to the left.

    Parameters
    ----------
    through : (n, 2), m
    ends : bool
        The profile ends at the last point; by default it returns to the first one smoothly.
    """

    through: Any
    ends: bool = False

    def __post_init__(self):
        through = finite_array(self.through)
        if through.ndim != 2 or through.shape[1:] != (2,) or len(through) < 3:
            raise ModelError(
                self.title,
                found=f"through = {self.through!r:.60}",
                expected="three points (n, 2) or more, m",
                remedy="Write through=[(0.1, 0), (0, 0.1), (-0.1, 0), (0, -0.1)]",
            )
        object.__setattr__(self, "through", tuple(map(tuple, through.tolist())))
        super().__post_init__()

    def segments(self) -> tuple[Segments, bool]:
        """Return the cubics."""
        points = np.array(self.through)
        if self.ends:
            return cubics(points, "not-a-knot" if len(points) > 3 else "natural", self.title), False
        return cubics(np.vstack([points, points[:1]]), "periodic", self.title), True
