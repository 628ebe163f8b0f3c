"""`viewpoint`: from where a mechanism is seen best, by its extent and its motion."""

from __future__ import annotations

from itertools import product

import numpy as np

from flexmb.io.scene import Scene

__all__ = ["best_direction", "viewpoint"]

FRAMES = 9
"""Frames by which the motion is judged."""
HEIGHTS = ((15.0, 1.0), (30.0, 0.85), (50.0, 0.55), (70.0, 0.45))
"""Angles of sight above the horizon, degrees, and how much each is liked: pictures from the side are read most easily.
"""
GOOD = 0.93
"""Share of the best score at which a direction is good enough:
then it counts what is in front, and a little obliqueness.
"""


def viewpoint(scene: Scene, up) -> np.ndarray:
    """Return the direction (3,) from which a scene is seen best, all its motion regarded; `up` is up in the picture."""
    last = len(scene.times) - 1
    frames = np.unique(np.linspace(0, last, FRAMES).round().astype(int))
    outer = []
    for part in scene.parts:
        points = scene.points(part, 0, np.arange(len(part.points)))
        outer.append((part, np.unique([*points.argmin(axis=0), *points.argmax(axis=0)])))
    return best_direction(
        np.stack([np.vstack([scene.points(part, int(k), ids) for part, ids in outer]) for k in frames]), up
    )


def best_direction(places, up) -> np.ndarray:
    """Return the direction to look from that shows most of extent and motion.

    The extent is the area over which the points spread in the picture. The motion is the root mean square of their
    paths in it. The product is largest across the plane of a planar mechanism. For a long wing whose flaps move across
    the span it is largest from the side at some 45 degrees. Of directions that are about as good it is the one that has
    what moves in front, or else an axis that goes to the right, and not quite straight on.

    Parameters
    ----------
    places : (nt, n, 3), m
        Points of the mechanism at several times.
    up : (3,)
        Direction that is up in the picture.

    Returns
    -------
    (3,), of length 1
    """
    up = np.asarray(up, float) / np.linalg.norm(up)
    first = np.eye(3)[int(np.argmin(np.abs(up)))]
    first = first - (first @ up) * up
    first /= np.linalg.norm(first)
    second = np.cross(up, first)
    middle = places.mean(axis=0)
    spread = _moments(places - places.mean(axis=(0, 1)))
    paths = _moments(places - middle)
    still = np.trace(paths) <= 1e-8 * np.trace(spread)
    moved = np.linalg.norm(places - middle, axis=2).mean(axis=0)

    def score(angle: float, height: float) -> float:
        axes = _picture(turned(angle), up, np.radians(height))
        area, motion = np.linalg.det(axes @ spread @ axes.T), np.trace(axes @ paths @ axes.T)
        return np.sqrt(max(area, 0.0) * (1.0 if still else motion))

    def turned(angle: float) -> np.ndarray:
        return np.cos(angle) * first + np.sin(angle) * second

    angles = np.radians(np.arange(0.0, 360.0, 5.0))
    best, (height, _) = max(product(angles, HEIGHTS), key=lambda c: round(c[1][1] * score(c[0], c[1][0]), 12))
    good = [angle for angle in angles if score(angle, height) >= GOOD * score(best, height)]
    angle = max(good, key=lambda a: (*_front(turned(a), up, middle, moved), round(abs(np.sin(a - best)), 6)))
    return np.cos(np.radians(height)) * turned(angle) + np.sin(np.radians(height)) * up


def _moments(points) -> np.ndarray:
    """Return the mean of x x^T over all points, (3, 3)."""
    flat = points.reshape(-1, 3)
    return flat.T @ flat / len(flat)


def _picture(ahead, up, height: float) -> np.ndarray:
    """Return the two axes (2, 3) of the picture seen from `ahead`, raised by an angle."""
    return np.stack([np.cross(up, ahead), np.cos(height) * up - np.sin(height) * ahead])


def _front(ahead, up, middle, moved) -> tuple[float, bool]:
    """Return how far in front what moves is, in tenths, and whether an axis goes to the right in the picture.

    Of a mechanism that is flat in this direction neither side is the front.
    """
    centred = middle - middle.mean(axis=0)
    depth, front = centred @ ahead, 0.0
    if depth.std() > 0.5 * np.sqrt(np.mean(np.sum(centred**2, axis=1))):
        front = (moved @ depth) / max(moved.sum() * depth.std(), 1e-300)
    right = np.cross(up, ahead)
    return round(front, 1), bool(right[int(np.argmax(np.abs(right)))] > 0.0)
