"""Surfaces of the shapes that bodies are given for drawing."""

from __future__ import annotations

import numpy as np

from flexmb import bodies
from flexmb.io.solids import Surface, box, sphere, tube

__all__ = ["cut_into_triangles", "extruded", "shape_surface"]


def shape_surface(shape) -> Surface:
    """Return the surface of a shape, in the axes in which it is given."""
    if isinstance(shape, bodies.Box):
        return box(shape.size).moved(at=shape.at)
    if isinstance(shape, bodies.Ball):
        return sphere(shape.radius, shape.at)
    if isinstance(shape, bodies.Tube):
        return tube(shape.start, shape.end, shape.radius)
    return extruded(shape.outline, shape.depth, "xyz".index(shape.axis))


def extruded(outline, depth, axis: int) -> Surface:
    """Return an outline (n, 2), m, drawn out over `depth` (2,), m, along an axis; the ends have their own points."""
    outline = np.asarray(outline, float)
    # (x, z) for y is a left-handed pair: seen against the axis, the outline then runs the other way round
    clockwise = (_area(outline) < 0.0) != (axis == 1)
    outline = outline[::-1] if clockwise else outline
    n = len(outline)
    across = [k for k in range(3) if k != axis]
    points = np.zeros((4, n, 3))
    points[:, :, across] = outline
    points[:, :, axis] = np.array([depth[0], depth[1], depth[0], depth[1]])[:, None]
    i = np.arange(n)
    j = (i + 1) % n
    quads = np.stack([i, j, n + j, n + i], 1)
    turned = -1.0 if axis == 1 else 1.0
    caps = cut_into_triangles(outline * np.array([turned, 1.0]))
    return Surface(points.reshape(-1, 3), np.vstack([caps[:, ::-1] + 2 * n, caps + 3 * n]), quads)


def _area(outline) -> float:
    """Return the area of an outline, positive if it runs from the first axis to the second."""
    x, y = outline.T
    return 0.5 * float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y))


def cut_into_triangles(outline) -> np.ndarray:
    """Cut a polygon (n, 2) that runs counter-clockwise into triangles (n - 2, 3) by taking off ears."""
    left, triangles = list(range(len(outline))), []
    while len(left) > 3:
        ears = [k for k in range(len(left)) if _is_ear(outline, left, k)]
        # the roundest ear first, so that no slivers remain; a crossed outline has none and is cut anyhow
        k = max(ears, key=lambda k: _roundness(outline[_corner(left, k)])) if ears else 0
        triangles.append(_corner(left, k))
        del left[k]
    return np.array([*triangles, left])


def _corner(left, k):
    return [left[k - 1], left[k], left[(k + 1) % len(left)]]


def _cross(a, b, c) -> float:
    return float((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))


def _roundness(triangle) -> float:
    """Return twice the area by the square of the longest side."""
    a, b, c = triangle
    longest = max(float(np.sum((p - q) ** 2)) for p, q in ((a, b), (b, c), (c, a)))
    return _cross(a, b, c) / longest if longest > 0.0 else 0.0


def _is_ear(outline, left, k) -> bool:
    """Does the corner bulge outwards, with no other corner in its triangle?"""
    corner = _corner(left, k)
    a, b, c = outline[corner]
    if _cross(a, b, c) <= 0.0:
        return False
    others = outline[[n for n in left if n not in corner]]
    inside = [min(_cross(a, b, p), _cross(b, c, p), _cross(c, a, p)) >= 0.0 for p in others]
    return not any(inside)
