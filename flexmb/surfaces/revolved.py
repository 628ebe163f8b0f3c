"""Surfaces of revolution about the z-axis: patches for pictures, sample points of frusta."""

from __future__ import annotations

import numpy as np

from flexmb.surfaces.shape import Points, grid

__all__ = ["frustum", "patches", "rings"]

AROUND = 32
SHARP = 0.3
"""rad, turn between two chords that is a corner."""


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


def rings(line: np.ndarray, spacing: float) -> Points:
    """Return samples of a line (n, 2) of rho and z, m, turned about z; the normal is on its right side, no ring is
    across a corner.
    """
    chords = np.diff(line, axis=0)
    lengths = np.linalg.norm(chords, axis=1)
    t = chords / lengths[:, None]
    turn = np.abs(t[:-1, 0] * t[1:, 1] - t[:-1, 1] * t[1:, 0])
    back = np.einsum("ij,ij->i", t[:-1], t[1:]) < 0.0
    corners = np.flatnonzero((turn > np.sin(SHARP)) | back) + 1
    found = []
    for first, last in zip([0, *corners], [*corners, len(chords)]):
        s = np.concatenate([[0.0], np.cumsum(lengths[first:last])])
        rho = line[first : last + 1, 0]
        area = np.concatenate([[0.0], np.cumsum(np.pi * (rho[:-1] + rho[1:]) * lengths[first:last])])
        count = max(1, round(s[-1] / spacing))
        ends = np.linspace(0.0, s[-1], count + 1)
        for k in range(count):
            part = _area_at(ends[k + 1], s, rho, area) - _area_at(ends[k], s, rho, area)
            middle = 0.5 * (ends[k] + ends[k + 1])
            i = first + min(int(np.searchsorted(s, middle, side="right")) - 1, last - first - 1)
            at = line[i] + (middle - s[i - first]) * t[i]
            n = max(3, round(2.0 * np.pi * at[0] / spacing))
            angle = 2.0 * np.pi * (np.arange(n) + 0.5) / n
            ring = np.column_stack([np.cos(angle), np.sin(angle)])
            found.append(
                (
                    np.column_stack([at[0] * ring, np.full(n, at[1])]),
                    np.column_stack([t[i, 1] * ring, np.full(n, -t[i, 0])]),
                    np.full(n, part / n),
                )
            )
    places, normals, areas = (np.concatenate(entries) for entries in zip(*found))
    return places, normals, areas


def _area_at(s: float, knots: np.ndarray, rho: np.ndarray, area: np.ndarray) -> float:
    """Return the area up to s of a line with the radii `rho` at its knots, m, and the areas up to these."""
    i = min(int(np.searchsorted(knots, s, side="right")) - 1, len(knots) - 2)
    d = s - knots[i]
    slope = (rho[i + 1] - rho[i]) / (knots[i + 1] - knots[i])
    return float(area[i] + 2.0 * np.pi * (rho[i] * d + 0.5 * slope * d * d))
