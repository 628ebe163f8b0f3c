"""`Line`, `Arc`, `Spline` and `Involute`: the pieces of an `Outline`, each from where the one before ends."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from flexmb.errors import ModelError
from flexmb.model.described import Described, finite_array, is_number
from flexmb.profiles.segments import ARC, CUBIC, INVOLUTE, LARGEST, LINE

__all__ = ["Arc", "Involute", "Line", "Spline", "cubics", "point_of"]

Segments = list[tuple[float, np.ndarray]]
MOST_ROLL = 628.0
"""rad: roll of the string over a piece of an involute, 100 turns; of a tooth it is below 1, of a scroll below 40."""


def point_of(value: Any, title: str, field: str) -> np.ndarray:
    """Return a point (2,); ModelError unless it is two numbers."""
    point = finite_array(value)
    if point.shape != (2,) or np.abs(point).max() > LARGEST:
        raise ModelError(
            title, found=f"{field} = {value!r:.60}", expected="two numbers (x, y), m", remedy=f"Write {field}=(0.1, 0)"
        )
    return point


@dataclass(frozen=True, kw_only=True, eq=False)
class Line(metaclass=Described):
    """A straight piece.

    Parameters
    ----------
    to : (2,), m
        Where it ends.
    """

    to: Any

    def __post_init__(self):
        object.__setattr__(self, "to", tuple(point_of(self.to, "Line", "to").tolist()))

    def segments(self, start: np.ndarray) -> tuple[Segments, np.ndarray]:
        """Return the segments from `start` (2,), and where they end."""
        end = np.array(self.to)
        return [(LINE, np.concatenate([start, end - start]))], end


@dataclass(frozen=True, kw_only=True, eq=False)
class Arc(metaclass=Described):
    """A piece of a circle around a centre.

    Parameters
    ----------
    center : (2,), m
    sweep : float, rad
        Positive: counter-clockwise, around material; negative: clockwise, around a hollow.
    """

    center: Any
    sweep: float

    def __post_init__(self):
        object.__setattr__(self, "center", tuple(point_of(self.center, "Arc", "center").tolist()))
        if not is_number(self.sweep) or not 0.0 < abs(self.sweep) <= 2.0 * np.pi * (1.0 + 1e-12):
            raise ModelError(
                "Arc",
                found=f"sweep = {self.sweep!r} rad",
                expected="an angle up to a full turn, not zero",
                remedy="Positive is counter-clockwise",
            )

    def segments(self, start: np.ndarray) -> tuple[Segments, np.ndarray]:
        """Return the segments from `start` (2,), and where they end."""
        center = np.array(self.center)
        ray = start - center
        radius, angle = float(np.hypot(*ray)), float(np.arctan2(ray[1], ray[0]))
        end = center + radius * np.array([np.cos(angle + self.sweep), np.sin(angle + self.sweep)])
        return [(ARC, np.array([*center, radius, angle, self.sweep]))], end


@dataclass(frozen=True, kw_only=True, eq=False)
class Spline(metaclass=Described):
    """A smooth piece through points: the cubic spline over the lengths of its chords.

    Parameters
    ----------
    through : (n, 2), m
        The points after the start; the last one is the end.
    tangents : ((2,), (2,)), optional
        Directions at start and end; by default the ends are not-a-knot.
    """

    through: Any
    tangents: Any = None

    def __post_init__(self):
        through = finite_array(self.through)
        if through.ndim != 2 or through.shape[1:] != (2,) or not len(through):
            raise ModelError(
                "Spline",
                found=f"through = {self.through!r:.60}",
                expected="points (n, 2), m",
                remedy="Write through=[(0.1, 0.02), (0.2, 0)]",
            )
        object.__setattr__(self, "through", tuple(map(tuple, through.tolist())))
        if self.tangents is not None:
            tangents = finite_array(self.tangents)
            if tangents.shape != (2, 2) or not np.all(np.linalg.norm(tangents, axis=1) > 0.0):
                raise ModelError(
                    "Spline",
                    found=f"tangents = {self.tangents!r:.60}",
                    expected="two directions, at start and end",
                    remedy="Write tangents=[(1, 0), (0, 1)]",
                )
            object.__setattr__(self, "tangents", tuple(map(tuple, tangents.tolist())))

    def segments(self, start: np.ndarray) -> tuple[Segments, np.ndarray]:
        """Return the segments from `start` (2,), and where they end."""
        points = np.vstack([start, self.through])
        if self.tangents is None:
            ends: Any = "not-a-knot" if len(points) > 3 else "natural"
        else:
            unit = [np.array(t) / np.linalg.norm(t) for t in self.tangents]
            ends = ((1, unit[0]), (1, unit[1]))
        return cubics(points, ends, "Spline"), points[-1]


@dataclass(frozen=True, kw_only=True, eq=False)
class Involute(metaclass=Described):
    """A piece of the involute of a circle, from the start to where it has another radius.

    Parameters
    ----------
    base_radius : float, m
    radius : float, m
        Of the end, from the centre.
    side : 1 or -1
        1: outwards, the involute turns counter-clockwise (the right flank of a tooth); -1: clockwise.
    center : (2,), m
    """

    base_radius: float
    radius: float
    side: int
    center: Any = (0.0, 0.0)

    def __post_init__(self):
        object.__setattr__(self, "center", tuple(point_of(self.center, "Involute", "center").tolist()))
        for field in ("base_radius", "radius"):
            if not is_number(getattr(self, field)) or not 0.0 < getattr(self, field) <= LARGEST:
                raise ModelError(
                    "Involute",
                    found=f"{field} = {getattr(self, field)!r}",
                    expected="a number > 0, m",
                    remedy="Give radii in m",
                )
        if self.side not in (1, -1) or isinstance(self.side, bool):
            raise ModelError(
                "Involute", found=f"side = {self.side!r}", expected="1 or -1", remedy="1 turns counter-clockwise"
            )

    def segments(self, start: np.ndarray) -> tuple[Segments, np.ndarray]:
        """Return the segments from `start` (2,), and where they end."""
        ray = start - np.array(self.center)
        radii = float(np.hypot(*ray)), float(self.radius)
        if min(radii) < self.base_radius * (1.0 - 1e-9):
            raise ModelError(
                "Involute",
                found=f"a piece from radius {radii[0]:.6g} to {radii[1]:.6g} m",
                expected=f"radii of at least {self.base_radius:.6g} m, the base circle",
                remedy="An involute begins on its base circle",
            )
        first, last = (max((r / self.base_radius) ** 2 - 1.0, 0.0) ** 0.5 for r in radii)
        if abs(last - first) > MOST_ROLL:
            raise ModelError(
                "Involute",
                found=f"a piece from radius {radii[0]:.6g} to {radii[1]:.6g} m that winds "
                f"{abs(last - first) / 6.28:.3g} times around its base circle of {self.base_radius:.6g} m",
                expected=f"at most {MOST_ROLL / 6.28:.0f} turns",
                remedy="Are all radii and points in m?",
            )
        root = float(np.arctan2(ray[1], ray[0])) - self.side * (first - np.arctan(first))
        angle = root + self.side * (last - np.arctan(last))
        end = np.array(self.center) + radii[1] * np.array([np.cos(angle), np.sin(angle)])
        numbers = np.array([*self.center, self.base_radius, root, self.side, first, last])
        return [(INVOLUTE, numbers)], end


def cubics(points: np.ndarray, ends: Any, title: str) -> Segments:
    """Return the cubics of the spline through points (n, 2) over the lengths of its chords."""
    from scipy.interpolate import CubicSpline

    chords = np.linalg.norm(np.diff(points, axis=0), axis=1)
    if np.any(chords <= 1e-12 * np.ptp(points, axis=0).max()):
        k = int(np.argmin(chords))
        raise ModelError(
            title,
            found=f"points {k + 1} and {k + 2} both at ({points[k][0]:.6g}, {points[k][1]:.6g}) m",
            expected="points that differ",
            remedy="Remove one of them",
        )
    knots = np.concatenate([[0.0], np.cumsum(chords)])
    spline = CubicSpline(knots, points, bc_type=ends)
    powers = spline.c[::-1] * chords[None, :, None] ** np.arange(4)[:, None, None]  # (4, n - 1, 2), of h
    return [(CUBIC, powers[:, i, :].T.ravel()) for i in range(len(chords))]
