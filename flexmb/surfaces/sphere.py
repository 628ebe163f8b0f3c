"""`Sphere`: a ball around the marker."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from flexmb.surfaces.revolved import patches
from flexmb.surfaces.shape import Points, Shape

__all__ = ["Sphere", "on_unit_sphere"]


def on_unit_sphere(n: int) -> np.ndarray:
    """Return n directions (n, 3) of equal shares of the sphere, on a spiral of the golden angle."""
    k = np.arange(n) + 0.5
    z = 1.0 - 2.0 * k / n
    turn = np.pi * (3.0 - 5.0**0.5) * k
    rho = np.sqrt(1.0 - z * z)
    return np.column_stack([rho * np.cos(turn), rho * np.sin(turn), z])


@dataclass(frozen=True, eq=False)
class Sphere(Shape):
    """A ball of the `radius`, m, around the marker."""

    radius: float

    code: ClassVar[int] = 1
    edged: ClassVar[bool] = True

    def __post_init__(self):
        self._require_lengths("radius")

    def numbers(self) -> np.ndarray:
        """Return the radius."""
        return np.array([self.radius])

    @property
    def reach(self) -> float:
        """Its radius, m."""
        return self.radius

    @property
    def thickness(self) -> float:
        """Twice its volume per area, m: of its drawing it would take a millisecond, of which heaps have thousands."""
        return 2.0 / 3.0 * self.radius

    def corners(self) -> tuple[np.ndarray, float]:
        """Return the centre, and the radius."""
        return np.zeros((1, 3)), self.radius

    def samples(self, spacing: float) -> Points:
        """Return points of equal areas."""
        area = 4.0 * np.pi * self.radius**2
        normals = on_unit_sphere(max(4, round(area / spacing / spacing)))
        return self.radius * normals, normals, np.full(len(normals), area / len(normals))

    def drawing(self) -> tuple[np.ndarray, np.ndarray]:
        """Return a ball of patches."""
        angle = np.linspace(-0.5 * np.pi, 0.5 * np.pi, 17)
        return patches(self.radius * np.cos(angle), self.radius * np.sin(angle))
