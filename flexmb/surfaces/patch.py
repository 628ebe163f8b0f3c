"""`Patch`: a piece of the skin of a deforming body, points without a solid of their own."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from flexmb.surfaces.records import PATCH
from flexmb.surfaces.shape import Points, Shape

__all__ = ["Patch"]


@dataclass(frozen=True, eq=False)
class Patch(Shape):
    """Points with normals and areas in the axes of a marker; other surfaces tell their distance from them.

    Parameters
    ----------
    patch : SkinPatch
    behind : float, m
        Twice the volume per area of the body behind it.
    """

    patch: Any
    behind: float

    code: ClassVar[int] = PATCH
    convex: ClassVar[bool] = False

    def numbers(self) -> np.ndarray:
        """Return none."""
        return np.zeros(0)

    @property
    def reach(self) -> float:
        """Distance of its farthest point, m; of a single one, the radius of its area."""
        p = self.patch
        far = float(np.linalg.norm(p.places, axis=1).max())
        return max(far, p.radius, float(np.sqrt(p.areas.max() / np.pi)))

    @property
    def extent(self) -> float:
        """Thickness of the body, m."""
        return self.behind

    @property
    def thickness(self) -> float:
        """Twice the volume per area of the body, m."""
        return self.behind

    def corners(self) -> tuple[np.ndarray, float]:
        """Return the place of the marker, and the radius."""
        return np.zeros((1, 3)), self.patch.radius

    def samples(self, spacing: float) -> Points:
        """Return its points, whatever the spacing."""
        return self.patch.places, self.patch.normals, self.patch.areas

    def drawing(self) -> tuple[np.ndarray, np.ndarray]:
        """Return nothing: the body is drawn."""
        return np.zeros((0, 3)), np.zeros((0, 3), int)
