"""`Bar`: what round shapes along the z-axis share."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flexmb.surfaces.shape import Shape

__all__ = ["Bar"]


@dataclass(frozen=True, eq=False)
class Bar(Shape):
    """A shape of a `radius` and a `length`, m, along the z-axis of the marker, which is in its middle."""

    radius: float
    length: float

    def __post_init__(self):
        self._require_lengths("radius", "length")

    def numbers(self) -> np.ndarray:
        """Return the radius and half the length."""
        return np.array([self.radius, 0.5 * self.length])
