"""`Cylinder`: a round bar with flat ends."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import ClassVar

import numpy as np

from flexmb.surfaces.bar import Bar
from flexmb.surfaces.revolved import frustum, patches
from flexmb.surfaces.shape import Points

__all__ = ["Cylinder"]


@dataclass(frozen=True, eq=False)
class Cylinder(Bar):
    """A bar of `radius` and `length`, m, along the z-axis of the marker, which is in its middle."""

    code: ClassVar[int] = 2

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
