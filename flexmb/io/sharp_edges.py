"""Edges of drawn surfaces: vertices where faces meet at an angle become several, one for each smooth part."""

from __future__ import annotations

import numpy as np

__all__ = ["with_sharp_edges"]

SHARP = np.cos(np.deg2rad(40.0))
"""Cosine between normals of faces at a vertex below which an edge is between them."""


def with_sharp_edges(points: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return points (n, 3) and triangles (m, 3) in which no vertex is shared across a sharp edge.

    Faces at a vertex are gathered to the first one whose normal is within the angle, so a cylinder keeps a smooth side.
    """
    a, b, c = (points[triangles[:, k]] for k in range(3))
    normal = np.cross(b - a, c - a)
    normal /= np.maximum(np.linalg.norm(normal, axis=1), 1e-300)[:, None]
    vertex, face = triangles.ravel(), np.repeat(np.arange(len(triangles)), 3)
    order = np.argsort(vertex, kind="stable")
    starts = np.flatnonzero(np.diff(vertex[order], prepend=-1))
    first = np.repeat(order[starts], np.diff(np.append(starts, len(order))))
    off = np.einsum("ij,ij->i", normal[face[order]], normal[face[first]]) < SHARP
    new, more = triangles.copy().ravel(), []
    for v in np.unique(vertex[order][off]):
        corners = order[vertex[order] == v] if len(order) < 1000 else np.flatnonzero(vertex == v)
        groups: list[tuple[int, np.ndarray]] = []
        for corner in corners:
            n = normal[face[corner]]
            number = next((k for k, m in groups if n @ m >= SHARP), None)
            if number is None:
                number = int(v) if not groups else len(points) + len(more)
                if groups:
                    more.append(points[v])
                groups.append((number, n))
            new[corner] = number
    return np.vstack([points, *more]) if more else points, new.reshape(-1, 3)
