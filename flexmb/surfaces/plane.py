"""`Plane`: a half-space."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from flexmb.surfaces.shape import Shape

__all__ = ["Plane"]

DRAWN = 1.0
"""m, half the side of the square that is drawn."""


@dataclass(frozen=True, eq=False)
class Plane(Shape):
    """The x-y plane of the marker, with the solid below it (z < 0)."""

    code: ClassVar[int] = 0
    edged: ClassVar[bool] = True

    def numbers(self) -> np.ndarray:
        """Return nothing: the marker tells all."""
        return np.zeros(0)

    @property
    def reach(self) -> float:
        """Infinite."""
        return np.inf

    def drawing(self) -> tuple[np.ndarray, np.ndarray]:
        """Return a square of 2 m."""
        corners = np.array([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)], float)
        return DRAWN * corners, np.array([(0, 1, 2), (0, 2, 3)])
