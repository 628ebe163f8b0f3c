"""`Shape`: the form of a surface, in the axes of its marker."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from flexmb.errors import ModelError
from flexmb.model.described import Described, is_number
from flexmb.surfaces.edges import NO_EDGES, Edges

__all__ = ["Points", "Shape", "grid"]

Points = tuple[np.ndarray, np.ndarray, np.ndarray]
"""Places (n, 3), m, outward normals (n, 3) and areas (n,), m2."""


@dataclass(frozen=True, eq=False)
class Shape(metaclass=Described):
    """A closed surface around a solid, or the surface of a half-space, in the axes of a marker."""

    code: ClassVar[int] = -1
    """Its number in the kernels, see `flexmb.surfaces.distances`."""
    convex: ClassVar[bool] = True
    edged: ClassVar[bool] = False
    """Are its edges known, or has it none?"""

    def _fail(self, found: str, expected: str, remedy: str) -> None:
        raise ModelError(f"Shape {type(self).__name__}", found=found, expected=expected, remedy=remedy)

    def _require_lengths(self, *names: str) -> None:
        """Raise ModelError unless the fields are positive lengths."""
        for name in names:
            value = getattr(self, name)
            if not is_number(value) or value <= 0.0:
                self._fail(f"{name} = {value!r}", "a length > 0, m", f"Write {name}=0.1")
            object.__setattr__(self, name, float(value))

    def numbers(self) -> np.ndarray:
        """Return its geometry as the kernels read it."""
        raise TypeError(f"{type(self).__name__} has no numbers")

    @property
    def reach(self) -> float:
        """Radius of the ball about the marker that holds it, m; infinite for a half-space."""
        raise TypeError(f"{type(self).__name__} does not say how far it reaches")

    @property
    def extent(self) -> float:
        """Length, m, beside which a penetration is deep or not."""
        return self.reach

    @property
    def thickness(self) -> float:
        """Twice its volume per area, m; infinite for a half-space.

        It is exact for a sheet, a third of the width of a cube or ball, and too much for thin parts of thick bodies.
        """
        if not np.isfinite(self.reach):
            return np.inf
        cross, at = self._drawn_triangles()
        return float(abs(np.einsum("ij,ij->", at, cross)) / 1.5 / np.linalg.norm(cross, axis=1).sum())

    @property
    def area(self) -> float:
        """Its area as it is drawn, m2; infinite for a half-space."""
        if not np.isfinite(self.reach):
            return np.inf
        return 0.5 * float(np.linalg.norm(self._drawn_triangles()[0], axis=1).sum())

    def _drawn_triangles(self) -> tuple[np.ndarray, np.ndarray]:
        """Return twice the areas as outward vectors (n, 3), m2, and a corner of each triangle (n, 3), m."""
        vertices, triangles = (np.asarray(x) for x in self.drawing())
        a, b, c = (vertices[triangles[:, k]] for k in range(3))
        return np.cross(b - a, c - a), a

    @property
    def doubt(self) -> str:
        """What is perhaps not meant; "" if nothing."""
        return ""

    def corners(self) -> tuple[np.ndarray, float]:
        """Return the points (n, 3) of its core that may touch singly, and the radius by which it is rounded, m."""
        return np.zeros((0, 3)), 0.0

    @property
    def edges(self) -> Edges:
        """Its edges and flat faces, by which it meets others where no corner does."""
        return NO_EDGES

    def samples(self, spacing: float) -> Points:
        """Return points about `spacing`, m, apart with normals and areas, which sum up to the surface's area."""
        self._fail(f"spacing = {spacing!r} m", "a surface of finite area", "Give the spacing to the other surface")
        raise AssertionError

    def drawing(self) -> tuple[np.ndarray, Any]:
        """Return vertices (n, 3), m, and triangles (m, 3) for pictures."""
        raise TypeError(f"{type(self).__name__} is not drawn")


def grid(length: float, spacing: float) -> tuple[np.ndarray, float]:
    """Return the centres of equal intervals from -length/2 to length/2, and the interval, m."""
    n = max(1, round(length / spacing))
    return (np.arange(n) + 0.5) * (length / n) - 0.5 * length, length / n
