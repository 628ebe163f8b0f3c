"""`Cylinder`: a round bar with flat ends."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import ClassVar

import numpy as np

from flexmb.surfaces.revolved import frustum, patches
from flexmb.surfaces.shape import Points, Shape

__all__ = ["Cylinder"]


@dataclass(frozen=True, eq=False)
class Cylinder(Shape):
    """A bar of `radius` and `length`, m, along the z-axis of the marker, which is in its middle."""

    radius: float
    length: float

    code: ClassVar[int] = 2

    def __post_init__(self):
        self._require_lengths("radius", "length")

    def numbers(self) -> np.ndarray:
        """Return the radius and half the length."""
        return np.array([self.radius, 0.5 * self.length])

    @property
    def reach(self) -> float:
        """Distance of its rims, m."""
        return float(np.hypot(self.radius, 0.5 * self.length))

    def samples(self, spacing: float) -> Points:
        """Return points of the side and the ends."""
        r, h = self.radius, 0.5 * self.length
        rims = [(0.0, -h), (r, -h), (r, h), (0.0, h)]
        parts = [frustum(start, end, spacing) for start, end in pairwise(rims)]
        places, normals, areas = (np.concatenate(entries) for entries in zip(*parts))
        return places, normals, areas

    def drawing(self) -> tuple[np.ndarray, np.ndarray]:
        """Return side and ends."""
        r, h = self.radius, 0.5 * self.length
        return patches(np.array([0.0, r, r, 0.0]), np.array([-h, -h, h, h]))
