"""`ExtrudedProfile`: a plane profile as a solid of constant length: a cam, a gear, a rail."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from flexmb.profiles import Profile
from flexmb.surfaces.shape import Points, Shape, grid

__all__ = ["ExtrudedProfile"]


@dataclass(frozen=True, eq=False)
class ExtrudedProfile(Shape):
    """A closed profile in the x-y plane of the marker, extruded by `length`, m, along z, half to either side.

    Lines, arcs, splines and involutes keep their exact distance. Pictures leave out its flat ends.
    """

    profile: Any
    length: float

    code: ClassVar[int] = 20
    convex: ClassVar[bool] = False

    def __post_init__(self):
        if not isinstance(self.profile, Profile):
            self._fail(f"profile = {self.profile!r:.60}", "a Profile", "Write profile=fmb.Disc(radius=0.03)")
        if not self.profile.closed or self.profile.area <= 0.0:
            found = "a profile around a hole" if self.profile.closed else "an open profile"
            self._fail(found, "a closed profile around its material", "Walk it counter-clockwise, and close it")
        self._require_lengths("length")

    def numbers(self) -> np.ndarray:
        """Return half the length, and the table of the profile after its size."""
        table = self.profile.table
        return np.concatenate([[0.5 * self.length, table.size], table])

    @property
    def reach(self) -> float:
        """Distance beyond the farthest rim, m: of the corners of boxes around segments."""
        boxes = self.profile.table[2:].reshape(int(self.profile.table[0]), -1)[:, 1:5]
        far = np.hypot(np.abs(boxes[:, :2]).max(axis=1), np.abs(boxes[:, 2:]).max(axis=1)).max()
        return float(np.hypot(far, 0.5 * self.length))

    @property
    def thickness(self) -> float:
        """Twice its volume per area, with the ends that are not drawn, m."""
        rim = np.linalg.norm(np.diff(self.profile.points(0.02), axis=0), axis=1).sum()
        return float(2.0 * self.profile.area * self.length / (2.0 * self.profile.area + rim * self.length))

    def corners(self) -> tuple[np.ndarray, float]:
        """Return points of both rims, which are sharp."""
        rim = self.profile.points(0.05)[:-1]
        return np.vstack([np.column_stack([rim, np.full(len(rim), z)]) for z in self._ends()]), 0.0

    def _ends(self) -> tuple[float, float]:
        return -0.5 * self.length, 0.5 * self.length

    def samples(self, spacing: float) -> Points:
        """Return points of the side, equally far apart, and of the ends, on a grid."""
        rim = self.profile.points(min(0.05, spacing / self.reach))
        chords = np.diff(rim, axis=0)
        lengths = np.linalg.norm(chords, axis=1)
        s = np.concatenate([[0.0], np.cumsum(lengths)])
        at, step = grid(s[-1], spacing)
        at += 0.5 * s[-1]
        k = np.clip(np.searchsorted(s, at, side="right") - 1, 0, len(lengths) - 1)
        t = chords[k] / lengths[k][:, None]
        middle = rim[k] + (at - s[k])[:, None] * t
        z, dz = grid(self.length, spacing)
        side = np.column_stack([np.repeat(middle, len(z), axis=0), np.tile(z, len(middle))])
        normal = np.repeat(np.column_stack([t[:, 1], -t[:, 0], np.zeros(len(t))]), len(z), axis=0)
        inside = self._inside(spacing)
        area = self.profile.area / len(inside)
        ends = [np.column_stack([inside, np.full(len(inside), z)]) for z in self._ends()]
        ups = [np.tile([0.0, 0.0, sign], (len(inside), 1)) for sign in (-1.0, 1.0)]
        return (
            np.vstack([side, *ends]),
            np.vstack([normal, *ups]),
            np.concatenate([np.full(len(side), step * dz), np.full(2 * len(inside), area)]),
        )

    def _inside(self, spacing: float) -> np.ndarray:
        """Return the points (n, 2) of a grid that lie inside the profile; one at least."""
        rim = self.profile.points(0.02)
        a, b = rim[:-1], rim[1:]
        low, high = rim.min(axis=0), rim.max(axis=0)
        for finer in range(12):
            x, y = (0.5 * (m + n) + grid(n - m, spacing / 2**finer)[0] for m, n in zip(low, high))
            found = []
            for level in y:  # a point is inside if an odd number of chords pass on its left
                over = (a[:, 1] > level) != (b[:, 1] > level)
                share = (level - a[over, 1]) / (b[over, 1] - a[over, 1])
                crossed = np.sort(a[over, 0] + share * (b[over, 0] - a[over, 0]))
                inside = x[np.searchsorted(crossed, x) % 2 == 1]
                found.append(np.column_stack([inside, np.full(len(inside), level)]))
            points = np.concatenate(found)
            if len(points):
                return points
        return rim[:1]

    def drawing(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the side."""
        rim = self.profile.points()[:-1]
        n = len(rim)
        vertices = np.vstack([np.column_stack([rim, np.full(n, z)]) for z in self._ends()])
        k = np.arange(n)
        after = (k + 1) % n
        return vertices, np.vstack([np.column_stack([k, after, n + after]), np.column_stack([k, n + after, n + k])])
