"""`Cuboid`: a box."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from itertools import product
from typing import Any, ClassVar

import numpy as np

from flexmb.model.described import finite_array
from flexmb.surfaces.edges import Edges, edges_of_solid
from flexmb.surfaces.shape import Points, Shape, grid

__all__ = ["Cuboid"]

ROUND = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
"""Corners of the faces in the order of `itertools.product`, round the outward normal."""
FACES = np.array([t for a, b, c, d in ROUND for t in ((a, b, c), (a, c, d))])
"""Triangles."""
ROUNDED = 1e-6
"""Radius of corners, relative to the smallest edge."""


@dataclass(frozen=True, eq=False)
class Cuboid(Shape):
    """A box with the edges `size` (3,), m, along the axes of the marker, which is in its middle."""

    size: Any

    code: ClassVar[int] = 4
    edged: ClassVar[bool] = True

    def __post_init__(self):
        size = finite_array(self.size)
        if size.shape != (3,) or not np.all(size > 0.0):
            self._fail(f"size = {self.size!r}", "three lengths > 0, m", "Write size=(0.4, 0.1, 0.1)")
        object.__setattr__(self, "size", tuple(size.tolist()))

    def numbers(self) -> np.ndarray:
        """Return half the edges."""
        return 0.5 * np.array(self.size)

    @property
    def reach(self) -> float:
        """Half its diagonal, m."""
        return float(np.linalg.norm(self.numbers()))

    def corners(self) -> tuple[np.ndarray, float]:
        """Return the eight corners, rounded so little that it only tells apart the faces of a box they lie on.

        The corner of a box on another one of the same size is on the edge of two faces: with its centre inside, the
        nearer face is the one it rests on.
        """
        half, radius = self.numbers(), ROUNDED * min(self.size)
        return np.array(list(product((-1, 1), repeat=3))) * (half - radius), radius

    @property
    def edges(self) -> Edges:
        """Its twelve edges and six faces: those of a cube, drawn out."""
        cube, size = _cube(), np.array(self.size)
        lines = cube.lines * np.concatenate([size, size, np.ones(6)])
        return Edges(lines, cube.corners * size, cube.ways * self.thickness, [face * size for face in cube.outlines])

    def samples(self, spacing: float) -> Points:
        """Return the centres of equal rectangles on each face."""
        places, normals, areas = [], [], []
        for axis in range(3):
            u, v = (axis + 1) % 3, (axis + 2) % 3
            (x, dx), (y, dy) = grid(self.size[u], spacing), grid(self.size[v], spacing)
            X, Y = (entry.ravel() for entry in np.meshgrid(x, y))
            for side in (-1.0, 1.0):
                at = np.empty((len(X), 3))
                at[:, u], at[:, v], at[:, axis] = X, Y, side * 0.5 * self.size[axis]
                places.append(at)
                normals.append(np.tile(side * np.eye(3)[axis], (len(X), 1)))
                areas.append(np.full(len(X), dx * dy))
        return np.concatenate(places), np.concatenate(normals), np.concatenate(areas)

    def drawing(self) -> tuple[np.ndarray, np.ndarray]:
        """Return corners and faces."""
        return np.array(list(product((-1, 1), repeat=3))) * self.numbers(), FACES


@cache
def _cube() -> Edges:
    """Return the edges of a cube of 1 m, with ways into it for a thickness of 1 m."""
    return edges_of_solid(np.array(list(product((-0.5, 0.5), repeat=3))), FACES, 1.0, True)
