"""`tie_rows`: nodes of one surface follow the faces of another on which they lie, by projection."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flexmb.fem.deck.links import LinkRows

__all__ = ["Tie", "tie_rows"]

DEFAULT_TOLERANCE = 0.05
"""Largest distance of a tied node from its face, in mean edge lengths, where none is given."""
ITERATIONS = 30
"""Newton steps of the projection onto a face; four suffice where the face is not folded."""
TOUCHING = 1e-6
"""Gaps below this share of an edge are rounding."""
OUTSIDE = 0.1
"""How far outside of a face, in its own coordinates, a node may project: meshes of round surfaces leave gaps."""


@dataclass(frozen=True)
class Tie:
    """Nodes tied to faces: their link, how many were too far, and the places (k, 3) of those moved onto their face."""

    link: LinkRows
    far: int
    moved: np.ndarray
    places: np.ndarray
    widest: float


def tie_rows(
    name: str,
    points: np.ndarray,
    nodes: np.ndarray,
    faces: np.ndarray,
    tolerance: float | None,
    rotations: bool,
    turning: bool,
) -> Tie:
    """Return rows ``u_node = sum N_i u_i`` of nodes on faces, and the places of those nodes on the faces.

    `faces` (nf, 8): corners, then midside nodes along the ring, -1 behind; N are the functions of 3, 4, 6 or 8 nodes. A
    node that is itself one of the faces is not tied. With `rotations` they follow as well. Over a gap g the rows
    hold in rigid rotations only where the faces turn (`turning`, shells): there
    ``u_node = sum N_i (u_i + t_i x g)`` and no node moves. Widest is the largest gap.
    """
    from scipy.spatial import cKDTree

    link, far, moved, widest = LinkRows(name), 0, {}, 0.0
    every = np.where(faces >= 0, faces, faces[:, :1])
    centres = points[every[:, :3]].mean(axis=1)
    sizes = np.linalg.norm(points[every[:, 1]] - points[every[:, 0]], axis=1)
    allowed = DEFAULT_TOLERANCE * float(np.median(sizes)) if tolerance is None else tolerance
    tree, own = cKDTree(centres), set(faces[faces >= 0].tolist())
    for node in nodes.tolist():
        if node in own:
            continue
        found = _nearest(points, node, faces, np.atleast_1d(tree.query(points[node], k=min(12, len(faces)))[1]))
        if found is None or found[2] > allowed:
            far += 1
            continue
        row, weights, distance = found
        gap = points[node] - weights @ points[row]
        for k in range(6 if rotations else 3):
            columns, values = 6 * row + k, weights
            if turning and k < 3 and distance > TOUCHING * sizes.mean():
                across = np.cross(np.eye(3), gap)[:, k]  # (t x g)_k, by t
                columns = np.concatenate([columns, *(6 * row + 3 + a for a in range(3))])
                values = np.concatenate([weights, *(across[a] * weights for a in range(3))])
            link.add([6 * node + k], columns, values[None, :])
        if not turning and distance > TOUCHING * sizes.mean():
            moved[node] = points[node] - gap
            widest = max(widest, distance)
    return Tie(link, far, np.array(list(moved), np.int64), np.array(list(moved.values())).reshape(-1, 3), widest)


def _nearest(points: np.ndarray, node: int, faces: np.ndarray, near: np.ndarray):
    """Return the nodes (k,) of the face a node lies on, their weights and the distance; None beside all faces."""
    best = None
    for face in near:
        row = faces[face][faces[face] >= 0]
        weights, distance, outside = _projected(points[row], points[node])
        key = (max(outside - 1e-9, 0.0), distance)
        if outside <= OUTSIDE and (best is None or key < best[0]):
            best = (key, row, weights, distance)
    return None if best is None else best[1:]


def _projected(nodes: np.ndarray, point: np.ndarray) -> tuple[np.ndarray, float, float]:
    """Return the weights of the nodes at the nearest place of a face, the distance, and how far it is outside."""
    triangle = len(nodes) in (3, 6)
    functions = _triangle if triangle else _quadrilateral
    place = np.full(2, 1.0 / 3.0) if triangle else np.zeros(2)
    for _ in range(ITERATIONS):
        value, slope = functions(place, len(nodes))
        gap, along = point - value @ nodes, slope @ nodes
        step = np.linalg.lstsq(along.T, gap, rcond=None)[0]
        place = np.clip(place + step, -3.0, 3.0)
        if np.abs(step).max() < 1e-12:
            break
    weights = functions(place, len(nodes))[0]
    outside = max(-place.min(), place.sum() - 1.0, 0.0) if triangle else max(np.abs(place).max() - 1.0, 0.0)
    return weights, float(np.linalg.norm(point - weights @ nodes)), float(outside)


def _triangle(place: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Return functions (count,) and slopes (2, count) of a triangle of 3 or 6 nodes in area coordinates."""
    area = np.array([1.0 - place.sum(), *place])
    slope = np.array([[-1.0, 1.0, 0.0], [-1.0, 0.0, 1.0]])
    if count == 3:
        return area, slope
    after = area[[1, 2, 0]]
    value = np.concatenate([area * (2.0 * area - 1.0), 4.0 * area * after])
    return value, np.hstack([slope * (4.0 * area - 1.0), 4.0 * (slope * after + area * slope[:, [1, 2, 0]])])


def _quadrilateral(place: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Return functions (count,) and slopes (2, count) of a quadrilateral of 4 or 8 (serendipity) nodes."""
    x, y = np.array([[-1.0, 1.0, 1.0, -1.0], [-1.0, -1.0, 1.0, 1.0]])
    a, b = 1.0 + x * place[0], 1.0 + y * place[1]
    value, slope = 0.25 * a * b, 0.25 * np.stack([x * b, y * a])
    if count == 4:
        return value, slope
    u, v = place
    bubble_u, bubble_v = 1.0 - u * u, 1.0 - v * v
    middle = 0.5 * np.array([bubble_u * (1.0 - v), (1.0 + u) * bubble_v, bubble_u * (1.0 + v), (1.0 - u) * bubble_v])
    along_u = np.array([-u * (1.0 - v), 0.5 * bubble_v, -u * (1.0 + v), -0.5 * bubble_v])
    along_v = np.array([-0.5 * bubble_u, -(1.0 + u) * v, 0.5 * bubble_u, -(1.0 - u) * v])
    middles = np.stack([along_u, along_v])
    share = 0.5 * (np.eye(4) + np.roll(np.eye(4), 1, axis=1))  # a midside takes half of itself from both its corners
    return np.concatenate([value - middle @ share, middle]), np.hstack([slope - middles @ share, middles])
