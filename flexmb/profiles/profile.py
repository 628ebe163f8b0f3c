"""`Profile`: a plane curve that bounds material: what a cam, a track, a tooth or a rack looks like from the side."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar

import numpy as np

from flexmb.errors import ModelError
from flexmb.model.described import Described, is_number
from flexmb.profiles.feet import FOOT, MOST_FEET, find_feet
from flexmb.profiles.segments import INVOLUTE, LARGEST, evaluate_segment, pack_segments, place_of

__all__ = ["Profile"]

CLOSE = 1e-9
"""Gaps and lengths below this part of the size of a profile are rounding."""
CHORD = 0.1
"""rad, turn of the curve over a chord where it is drawn and checked."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Profile(metaclass=Described):
    """A plane curve of lines, arcs, cubics and involutes. Walking along it, the material lies to the left."""

    name: ClassVar[str] = "Profile"

    @property
    def title(self) -> str:
        """What messages call it."""
        return type(self).__name__

    def segments(self) -> tuple[list[tuple[float, np.ndarray]], bool]:
        """Return the segments, each with its kind and numbers (see `segments`), and whether the curve is closed."""
        raise TypeError(f"{type(self).__name__} does not say what its segments are")

    def __post_init__(self):
        _check(self)

    @cached_property
    def table(self) -> np.ndarray:
        """The numbers that kernels read, see `flexmb.profiles.segments`."""
        return pack_segments(*self.segments())

    @property
    def closed(self) -> bool:
        """Does the curve return to its start?"""
        return bool(self.table[1])

    def points(self, chord: float = CHORD) -> np.ndarray:
        """Return points (n, 2), m, of the curve, with at most `chord` rad of turn from one to the next."""
        pieces = [self._points_of(i, chord) for i in range(int(self.table[0]))]
        last = self._at(int(self.table[0]) - 1, 1.0)[:1]
        return np.concatenate([*pieces, last])

    def _points_of(self, i: int, chord: float) -> np.ndarray:
        """Return points of a segment, without its end."""
        segment = self.table[place_of(i) :]
        rolled = abs(segment[11] - segment[10]) if segment[0] == INVOLUTE else 0.0
        places = np.linspace(0.0, 1.0, 9 + int(rolled))  # an angle is told from its neighbour up to half a turn
        tangents = np.array([self._at(i, h)[1] for h in places])
        angles = np.unwrap(np.arctan2(tangents[:, 1], tangents[:, 0]))
        count = 1 + int(np.abs(np.diff(angles)).sum() / chord)
        return np.array([self._at(i, h)[0] for h in np.arange(count) / count])

    def _at(self, i: int, h: float) -> np.ndarray:
        out = np.empty((3, 2))
        evaluate_segment(self.table, i, h, out)
        return out

    def distance(self, point: Any) -> tuple[float, np.ndarray, float]:
        """Return the distance of a point (2,), m, negative inside the material, the outward normal (2,) there, and the
        curvature of the profile at the nearest place, 1/m (positive: convex; infinite: a corner).

        Raises
        ------
        ModelError
            If the point lies beyond the ends of an open profile, where no place of it is nearest.
        """
        feet = np.empty((MOST_FEET, FOOT))
        x, y = (float(v) for v in point)
        if find_feet(self.table, x, y, 0.0, feet) == 0:
            raise ModelError(
                self.title,
                found=f"the point ({x:.6g}, {y:.6g}) m beyond the ends",
                expected="a point beside the profile",
                remedy="Continue the profile",
            )
        return float(feet[0, 4]), feet[0, 2:4].copy(), float(feet[0, 6])

    @property
    def area(self) -> float:
        """Area inside a closed profile, m2; negative if the material lies around a hole."""
        x, y = self.points(1e-3).T
        return 0.5 * float(x[:-1] @ y[1:] - y[:-1] @ x[1:])

    def require_positive(self, *names: str, zero: bool = False) -> None:
        """Raise ModelError if a field is not a positive (or, with `zero`, non-negative) finite number."""
        for name in names:
            value = getattr(self, name)
            if not is_number(value) or not 0.0 <= value <= LARGEST or (value == 0.0 and not zero):
                raise ModelError(
                    self.title,
                    found=f"{name} = {value!r:.100}",
                    expected="a number " + (">= 0" if zero else "> 0") + " in SI units",
                    remedy=f"Give {name} in m and rad",
                )


def _check(profile: Profile) -> None:
    """Raise ModelError for a curve with a segment without length, a gap, or one that crosses itself."""
    title, n = profile.title, int(profile.table[0])
    boxes = profile.table[2:].reshape(n, -1)[:, 1:5]
    size = float(max(np.ptp(boxes[:, :2]), np.ptp(boxes[:, 2:])))
    ends = np.array([[profile._at(i, h) for h in (0.0, 1.0)] for i in range(n)])
    for i in range(n):
        if not np.ptp(boxes[i, :2]) + np.ptp(boxes[i, 2:]) > CLOSE * size:
            x, y = ends[i, 0, 0]
            raise ModelError(
                title,
                found=f"segment {i + 1} at ({x:.6g}, {y:.6g}) m has no length",
                expected="segments of some length",
                remedy="Remove it, or a point that is given twice",
            )
    for i in range(n if profile.closed else n - 1):
        gap = float(np.linalg.norm(ends[(i + 1) % n, 0, 0] - ends[i, 1, 0]))
        if gap > CLOSE * size:
            x, y = ends[i, 1, 0]
            raise ModelError(
                title,
                found=f"a gap of {gap:.3g} m at ({x:.6g}, {y:.6g}) m, between segments {i + 1} and {(i + 1) % n + 1}",
                expected="segments that begin where the one before ends",
                remedy="Correct the end of one of them",
            )
    crossing = _crossing(profile.points(), profile.closed)
    if crossing is not None:
        raise ModelError(
            title,
            found=f"it crosses itself near ({crossing[0]:.6g}, {crossing[1]:.6g}) m",
            expected="a curve without crossings",
            remedy="Look at its points and radii; two curves that cross are two profiles",
        )


def _crossing(points: np.ndarray, closed: bool) -> np.ndarray | None:
    """Return a point (2,) at which chords that are not neighbours cross, or None."""
    a, b = points[:-1], points[1:]
    n = len(a)
    low, high = np.minimum(a, b), np.maximum(a, b)
    cross = lambda u, v: u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0]  # noqa: E731
    for i in range(n):
        j = np.arange(i + 2, n - (closed and i == 0))
        near = np.all((low[j] <= high[i]) & (high[j] >= low[i]), axis=1)
        j = j[near]
        if not len(j):
            continue
        own = b[i] - a[i]
        one, two = cross(own, a[j] - a[i]), cross(own, b[j] - a[i])
        other = b[j] - a[j]
        three, four = cross(other, a[i] - a[j]), cross(other, b[i] - a[j])
        met = (one * two < 0.0) & (three * four < 0.0)
        if np.any(met):
            k = int(np.argmax(met))
            share = three[k] / (three[k] - four[k])
            return a[i] + share * own
    return None
