"""`tie_rows`: nodes of one surface follow the faces of another on which they lie, by projection."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from flexmb.fem.deck.links import LinkRows

__all__ = ["tie_rows"]

DEFAULT_TOLERANCE = 0.05
"""Largest distance of a tied node from its face, in mean edge lengths, where none is given."""
ITERATIONS = 30
"""Newton steps of the projection onto a bilinear face; four suffice where the face is not folded."""
OUTSIDE = 0.1
"""How far outside of a face, in its own coordinates, a node may project: meshes of round surfaces leave gaps."""


def tie_rows(
    name: str, points: np.ndarray, nodes: np.ndarray, faces: np.ndarray, tolerance: float | None, rotations: bool
) -> tuple[LinkRows, int]:
    """Return rows ``u_node = sum N_i u_i`` of nodes on faces (nf, 4; -1 behind triangles), and how many were too far.

    A node that is itself a corner of the faces is not tied. With `rotations` they follow as well.
    """
    link, far = LinkRows(name), 0
    corners = np.where(faces >= 0, faces, faces[:, :1])
    centres = points[corners].mean(axis=1)
    sizes = np.linalg.norm(points[corners[:, 1]] - points[corners[:, 0]], axis=1)
    allowed = DEFAULT_TOLERANCE * float(np.median(sizes)) if tolerance is None else tolerance
    tree, own = cKDTree(centres), set(faces[faces >= 0].tolist())
    for node in nodes.tolist():
        if node in own:
            continue
        _, near = tree.query(points[node], k=min(12, len(faces)))
        best = None
        for face in np.atleast_1d(near):
            row = faces[face][faces[face] >= 0]
            weights, distance, outside = _projected(points[row], points[node])
            key = (max(outside - 1e-9, 0.0), distance)
            if outside <= OUTSIDE and (best is None or key < best[0]):
                best = (key, row, weights, distance)
        if best is None or best[3] > allowed:
            far += 1
            continue
        _, row, weights, _ = best
        for k in range(6 if rotations else 3):
            link.add([6 * node + k], 6 * row + k, weights[None, :])
    return link, far


def _projected(corners: np.ndarray, point: np.ndarray) -> tuple[np.ndarray, float, float]:
    """Return the weights of the corners at the nearest place of a face, the distance, and how far it is outside."""
    if len(corners) == 3:
        edges = np.stack([corners[1] - corners[0], corners[2] - corners[0]], axis=1)
        place, *_ = np.linalg.lstsq(edges, point - corners[0], rcond=None)
        weights = np.array([1.0 - place.sum(), *place])
        outside = float(max(-weights.min(), 0.0))
    else:
        place = np.zeros(2)
        for _ in range(ITERATIONS):
            value, slope = _bilinear(place)
            gap, along = point - value @ corners, slope @ corners
            step = np.linalg.lstsq(along.T, gap, rcond=None)[0]
            place = np.clip(place + step, -3.0, 3.0)
            if np.abs(step).max() < 1e-12:
                break
        weights = _bilinear(place)[0]
        outside = float(max(np.abs(place).max() - 1.0, 0.0))
    return weights, float(np.linalg.norm(point - weights @ corners)), outside


def _bilinear(place: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    x, y = np.array([[-1.0, 1.0, 1.0, -1.0], [-1.0, -1.0, 1.0, 1.0]])
    a, b = 1.0 + x * place[0], 1.0 + y * place[1]
    return 0.25 * a * b, 0.25 * np.stack([x * b, y * a])
