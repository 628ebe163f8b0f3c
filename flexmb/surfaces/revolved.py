"""Surfaces of revolution about the z-axis: patches for pictures, sample points of frusta."""

from __future__ import annotations

import numpy as np

from flexmb.surfaces.shape import Points, grid

__all__ = ["frustum", "patches"]

AROUND = 32


def patches(rho: np.ndarray, z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return vertices and triangles of a meridian (n,), m, from below to above, turned about z."""
    angle = 2.0 * np.pi * np.arange(AROUND) / AROUND
    ring = np.column_stack([np.cos(angle), np.sin(angle)])
    vertices = [np.column_stack([r * ring, np.full(AROUND, h)]) for r, h in zip(rho, z)]
    k = np.arange(AROUND)
    after = (k + 1) % AROUND
    triangles = []
    for n in range(len(rho) - 1):
        below, above = n * AROUND, (n + 1) * AROUND
        triangles += [
            np.column_stack([below + k, below + after, above + after]),
            np.column_stack([below + k, above + after, above + k]),
        ]
    return np.concatenate(vertices), np.concatenate(triangles)


def frustum(start: tuple[float, float], end: tuple[float, float], spacing: float) -> Points:
    """Return samples of the line from (rho, z) to (rho, z), m, turned about z; the normal is on its right side."""
    (r0, z0), (r1, z1) = start, end
    length = np.hypot(r1 - r0, z1 - z0)
    s, ds = grid(length, spacing)
    s = s / length + 0.5
    places, normals, areas = [], [], []
    normal = np.array([z1 - z0, r0 - r1]) / length
    for part in s:
        rho, z = r0 + part * (r1 - r0), z0 + part * (z1 - z0)
        n = max(3, round(2.0 * np.pi * rho / spacing))
        angle = 2.0 * np.pi * (np.arange(n) + 0.5) / n
        ring = np.column_stack([np.cos(angle), np.sin(angle)])
        places.append(np.column_stack([rho * ring, np.full(n, z)]))
        normals.append(np.column_stack([normal[0] * ring, np.full(n, normal[1])]))
        areas.append(np.full(n, 2.0 * np.pi * rho * ds / n))
    return np.concatenate(places), np.concatenate(normals), np.concatenate(areas)
