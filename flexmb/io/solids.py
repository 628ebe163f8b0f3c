"""Surfaces of simple solids for drawing: points, and cells as (meshio cell type, connectivity)."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

__all__ = ["Surface", "box", "coil", "joined", "sphere", "tube"]

SIDES = 24


class Surface(NamedTuple):
    """A surface: points (n, 3), m; triangles (nt, 3) and quads (nq, 4), node numbers, outward normals."""

    points: np.ndarray
    triangles: np.ndarray
    quads: np.ndarray

    def moved(self, matrix=None, at=(0.0, 0.0, 0.0)) -> Surface:
        """Return the surface turned (and stretched) by a matrix (3, 3), then shifted."""
        points = self.points if matrix is None else self.points @ np.asarray(matrix, float).T
        return self._replace(points=points + np.asarray(at, float))

    @property
    def cells(self):
        """The cells as (cell type, connectivity), empty types left out."""
        blocks = (("triangle", self.triangles), ("quad", self.quads))
        return tuple((name, cells) for name, cells in blocks if len(cells))


def joined(surfaces) -> Surface:
    """Return several surfaces as one."""
    surfaces = list(surfaces)
    starts = np.cumsum([0] + [len(s.points) for s in surfaces])
    return Surface(
        np.vstack([s.points for s in surfaces]),
        np.vstack([s.triangles + start for s, start in zip(surfaces, starts)]),
        np.vstack([s.quads + start for s, start in zip(surfaces, starts)]),
    )


def _ring(radius, sides):
    angle = 2.0 * np.pi * np.arange(sides) / sides
    return radius * np.stack([np.cos(angle), np.sin(angle), np.zeros(sides)], 1)


def tube(a, b, radius: float, sides: int = SIDES, end_radius: float | None = None) -> Surface:
    """Return a closed round tube from a to b (3,), m; with `end_radius` it is conical."""
    a, b = np.asarray(a, float), np.asarray(b, float)
    axes = _axes(b - a)
    end = radius if end_radius is None else end_radius
    # caps have their own rings, so that viewers which smooth normals keep the edge sharp
    rings = [a + _ring(radius, sides) @ axes.T, b + _ring(end, sides) @ axes.T]
    points = np.vstack([*rings, *rings, a[None], b[None]])
    i = np.arange(sides)
    j = (i + 1) % sides
    quads = np.stack([i, j, sides + j, sides + i], 1)
    bottom = np.stack([np.full(sides, 4 * sides), 2 * sides + j, 2 * sides + i], 1)
    top = np.stack([np.full(sides, 4 * sides + 1), 3 * sides + i, 3 * sides + j], 1)
    return Surface(points, np.vstack([bottom, top]), quads)


def box(size) -> Surface:
    """Return a box with edges `size` (3,), m, about the origin; faces have their own corners."""
    points, quads = [], []
    half = 0.5 * np.asarray(size, float)
    for axis in range(3):
        for sign in (-1.0, 1.0):
            corners = np.zeros((4, 3))
            corners[:, axis] = sign
            corners[:, (axis + 1) % 3] = (-1, 1, 1, -1)
            corners[:, (axis + 2) % 3] = (-1, -1, 1, 1)
            quads.append(4 * len(points) + (np.arange(4) if sign > 0 else np.arange(4)[::-1]))
            points.append(corners * half)
    return Surface(np.vstack(points), np.zeros((0, 3), int), np.array(quads))


def sphere(radius: float, at=(0.0, 0.0, 0.0), sides: int = SIDES) -> Surface:
    """Return a sphere: rings of quads, triangles at the poles."""
    rows = sides // 2
    polar = np.pi * np.arange(1, rows) / rows
    ring = _ring(1.0, sides)
    body = [np.sin(p) * ring + (0.0, 0.0, np.cos(p)) for p in polar]
    points = radius * np.vstack([*body, [[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]]]) + np.asarray(at, float)
    i = np.arange(sides)
    j = (i + 1) % sides
    quads = [
        np.stack([k * sides + i, (k + 1) * sides + i, (k + 1) * sides + j, k * sides + j], 1) for k in range(rows - 2)
    ]
    north, south, last = (rows - 1) * sides, (rows - 1) * sides + 1, (rows - 2) * sides
    caps = [
        np.stack([np.full(sides, north), i, j], 1),
        np.stack([np.full(sides, south), last + j, last + i], 1),
    ]
    return Surface(points, np.vstack(caps), np.vstack(quads))


def coil(radius: float, wire: float, turns: int = 6, sides: int = 8) -> Surface:
    """Return a helical spring along z from 0 to 1 (stretch it to its length), wire radius in x and y."""
    s = np.linspace(0.0, 1.0, 16 * turns + 1)
    angle = 2.0 * np.pi * turns * s
    across = np.stack([np.cos(angle), np.sin(angle), 0.0 * s], 1)
    ends = np.minimum(1.0, 12.0 * np.minimum(s, 1.0 - s))[:, None]  # the wire runs to the axis at both ends
    around = 2.0 * np.pi * np.arange(sides) / sides
    center = radius * ends * across + np.stack([0.0 * s, 0.0 * s, s], 1)
    # the length is not known here, so the wire's thickness along z is a fifth of the pitch
    points = [center + wire * np.cos(x) * across + (0.0, 0.0, 0.2 / turns * np.sin(x)) for x in around]
    grid = np.arange(len(s) * sides).reshape(sides, len(s))
    i, j = grid[:, :-1], np.roll(grid, -1, axis=0)[:, :-1]
    quads = np.stack([i, i + 1, j + 1, j], -1).reshape(-1, 4)
    return Surface(np.vstack(points), np.zeros((0, 3), int), quads)


def _axes(direction):
    """Return a right-handed matrix whose third column is the direction (z if there is none)."""
    length = np.linalg.norm(direction)
    z = direction / length if length > 0.0 else np.array([0.0, 0.0, 1.0])
    x = np.cross(np.eye(3)[int(np.argmin(np.abs(z)))], z)
    x /= np.linalg.norm(x)
    return np.stack([x, np.cross(z, x), z], 1)
