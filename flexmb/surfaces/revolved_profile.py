"""`RevolvedProfile`: a plane profile turned about the z-axis. `Cone` and `Torus`: two that are often needed."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar

import numpy as np

from flexmb.model.described import is_number
from flexmb.profiles import Disc, Line, Outline, Profile
from flexmb.surfaces.revolved import patches, rings
from flexmb.surfaces.shape import Points, Shape

__all__ = ["Cone", "RevolvedProfile", "Torus"]

FINE, COARSE = 0.02, 0.2
"""rad, turn over a chord where it is sampled, and drawn."""
SAME = 1e-9
"""Distance, relative to the size, at which a profile counts as symmetric."""


class _Revolved(Shape):
    """What shapes from a profile in the (rho, z) plane share; the profile may go on symmetrically to rho < 0."""

    code: ClassVar[int] = 21

    @cached_property
    def _profile(self) -> Profile:
        raise TypeError(f"{type(self).__name__} has no profile")

    def numbers(self) -> np.ndarray:
        """Return the table of the profile after its size."""
        table = self._profile.table
        return np.concatenate([[table.size], table])

    @property
    def reach(self) -> float:
        """Distance beyond the farthest point, m: of the corners of boxes around segments."""
        boxes = self._profile.table[2:].reshape(int(self._profile.table[0]), -1)[:, 1:5]
        return float(np.hypot(np.abs(boxes[:, :2]).max(axis=1), np.abs(boxes[:, 2:]).max(axis=1)).max())

    def _meridian(self, chord: float) -> list[np.ndarray]:
        """Return the lines (n, 2) of rho and z between axis or start and end, the material on their left."""
        p = self._profile.points(chord)
        inside = p[:, 0] >= -SAME * self.reach
        if np.all(inside):
            return [np.column_stack([np.maximum(p[:, 0], 0.0), p[:, 1]])]
        lines: list[list[tuple[float, float]]] = []
        line: list[tuple[float, float]] = []
        for a, b, here, there in zip(p[:-1], p[1:], inside[:-1], inside[1:]):
            if here:
                line.append((max(a[0], 0.0), a[1]))
            if here != there:
                share = a[0] / (a[0] - b[0]) if a[0] != b[0] else 0.0
                line.append((0.0, a[1] + share * (b[1] - a[1])))
            if here and not there:
                lines.append(line)
                line = []
        lines.append([*line, *([tuple(p[-1])] if inside[-1] else [])])
        if len(lines) > 1 and inside[0]:  # it began in the middle of a line
            lines[0] = lines.pop()[:-1] + lines[0]
        found = [_without_copies(line) for line in lines if len(line) > 1]
        return [points for points in found if len(points) > 1]

    def samples(self, spacing: float) -> Points:
        """Return points on rings."""
        found = [rings(line, spacing) for line in self._meridian(FINE)]
        places, normals, areas = (np.concatenate(entries) for entries in zip(*found))
        return places, normals, areas

    def drawing(self) -> tuple[np.ndarray, np.ndarray]:
        """Return patches."""
        vertices, triangles, count = [], [], 0
        for line in self._meridian(COARSE):
            points, faces = patches(line[:, 0], line[:, 1])
            vertices.append(points)
            triangles.append(faces + count)
            count += len(points)
        return np.concatenate(vertices), np.concatenate(triangles)


def _without_copies(line) -> np.ndarray:
    """Return the points (n, 2) of a line, each that repeats the one before left out."""
    points = np.array(line)
    return points[np.append(True, np.linalg.norm(np.diff(points, axis=0), axis=1) > SAME * np.ptp(points))]


@dataclass(frozen=True, eq=False)
class RevolvedProfile(_Revolved):
    """A closed profile turned about the z-axis of the marker: its x is the distance from this axis, y runs along it.

    It lies at x >= 0 (a ring), or crosses the axis and is symmetric to it (a solid): write both halves of an `Outline`.
    Lines, arcs and splines keep their exact distance.
    """

    profile: Any

    convex: ClassVar[bool] = False

    def __post_init__(self):
        if not isinstance(self.profile, Profile):
            self._fail(f"profile = {self.profile!r:.60}", "a Profile", "Write profile=fmb.Disc(radius=0.03)")
        if not self.profile.closed or self.profile.area <= 0.0:
            found = "a profile around a hole" if self.profile.closed else "an open profile"
            self._fail(found, "a closed profile around its material", "Walk it counter-clockwise, and close it")
        points = self.profile.points(FINE)
        size = self.reach
        if points[:, 0].min() < -SAME * size:
            off = max(abs(self.profile.distance((-x, y))[0]) for x, y in points)
            if off > 1e-6 * size:
                self._fail(
                    f"a profile on both sides of the axis whose halves differ by {off:.3g} m",
                    "x >= 0, or halves that are symmetric",
                    "Move it to x >= 0, or write both halves",
                )

    @property
    def _profile(self) -> Profile:  # type: ignore[override]
        return self.profile


@dataclass(frozen=True, eq=False)
class Cone(_Revolved):
    """A cone or frustum along the z-axis of the marker, which is in its middle.

    Parameters
    ----------
    radius : float, m
        At z = -length/2.
    length : float, m
    top : float, m
        Radius at z = length/2; 0 for a tip.
    """

    radius: float
    length: float
    top: float = 0.0

    def __post_init__(self):
        self._require_lengths("radius", "length")
        if not is_number(self.top) or self.top < 0.0:
            self._fail(f"top = {self.top!r}", "a radius >= 0, m", "Write top=0.0 for a tip")

    @cached_property
    def _profile(self) -> Profile:  # type: ignore[override]
        r, t, h = self.radius, self.top, 0.5 * self.length
        above = [(t, h), (-t, h)] if t > 0.0 else [(0.0, h)]
        return Outline(start=(-r, -h), pieces=[Line(to=to) for to in ((r, -h), *above)])


@dataclass(frozen=True, eq=False)
class Torus(_Revolved):
    """A ring about the z-axis of the marker: all points within `tube`, m, of a circle of the `radius`, m."""

    radius: float
    tube: float

    convex: ClassVar[bool] = False

    def __post_init__(self):
        self._require_lengths("radius", "tube")
        if self.tube >= self.radius:
            self._fail(f"tube = {self.tube} m", f"less than the radius, {self.radius} m", "Use a Sphere without a hole")

    @cached_property
    def _profile(self) -> Profile:  # type: ignore[override]
        return Disc(radius=self.tube, center=(self.radius, 0.0))
