"""`HeightField`: ground over a rectangle, from heights on a grid."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from flexmb.model.described import finite_array
from flexmb.surfaces.closed_mesh import checked_mesh
from flexmb.surfaces.triangle_mesh import Meshed

__all__ = ["HeightField"]


@dataclass(frozen=True, eq=False)
class HeightField(Meshed):
    """Ground whose upper side has heights z on a grid over a rectangle, with upright sides and a flat bottom.

    Parameters
    ----------
    heights : (n, k), m
        At equal steps of x (first index) and y, in the axes of the marker, which is in the middle of the rectangle.
    size : (2,), m
        Its edges along x and y.
    depth : float, m
        Of the bottom below the lowest height: the deepest penetration that is told apart from one through the bottom.
    """

    heights: Any
    size: Any
    depth: float

    def __post_init__(self):
        heights, size = finite_array(self.heights), finite_array(self.size)
        if heights.ndim != 2 or min(heights.shape) < 2:
            self._fail(
                f"heights of the shape {np.shape(self.heights)}", "numbers (n, k), 2 or more each", "Give a grid, m"
            )
        if size.shape != (2,) or not np.all(size > 0.0):
            self._fail(f"size = {self.size!r}", "two lengths > 0, m", "Write size=(4.0, 2.0)")
        self._require_lengths("depth")
        object.__setattr__(self, "heights", heights)
        object.__setattr__(self, "size", tuple(size.tolist()))
        object.__setattr__(self, "_mesh", checked_mesh(*_solid(heights, size, self.depth), "Shape HeightField"))


def _solid(heights, size, depth):
    """Return vertices and triangles of upper side, bottom and sides."""
    n, k = heights.shape
    x, y = (np.linspace(-0.5 * edge, 0.5 * edge, count) for edge, count in zip(size, (n, k)))
    X, Y = np.meshgrid(x, y, indexing="ij")
    low = np.full_like(heights, heights.min() - depth)
    vertices = np.concatenate([np.stack([X, Y, Z], axis=-1).reshape(-1, 3) for Z in (heights, low)])
    number = np.arange(n * k).reshape(n, k)
    a, b, c, d = (g.ravel() for g in (number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]))
    upper = np.concatenate([np.column_stack([a, b, c]), np.column_stack([a, c, d])])
    rim = np.concatenate([number[:, 0], number[-1, 1:], number[-2::-1, -1], number[0, -2:0:-1]])
    after = np.roll(rim, -1)
    sides = np.concatenate(
        [np.column_stack([rim, rim + n * k, after + n * k]), np.column_stack([rim, after + n * k, after])]
    )
    return vertices, np.concatenate([upper, upper[:, ::-1] + n * k, sides])
