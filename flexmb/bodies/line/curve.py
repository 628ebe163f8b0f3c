"""The initial curve of a cable or beam: a smooth curve through points, and nodes at equal distances along it."""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np

from flexmb.errors import ModelError
from flexmb.model.described import finite_array

__all__ = ["Curve", "curve_through", "minimal_rotation"]

FOLD = 0.0
"""An element is folded if the cosine between the directions of its ends is below this."""


class Curve(NamedTuple):
    """Nodes of an initial curve.

    r : (n, 3), m, positions. t : (n, 3), unit tangents. length : m, of the whole curve.
    """

    r: np.ndarray
    t: np.ndarray
    length: float


def checked_points(points, title: str) -> np.ndarray:
    """Return the points (n, 3) of a curve; ModelError if there are less than two, or two neighbours coincide."""
    p = finite_array(points)
    if p.ndim != 2 or p.shape[1] != 3 or len(p) < 2:
        raise ModelError(
            title,
            found=f"points of the shape {p.shape}",
            expected="two or more points (n, 3), m, in W",
            remedy="Write points=((0, 0, 0), (1, 0, 0))",
        )
    step = np.linalg.norm(np.diff(p, axis=0), axis=1)
    if step.min() <= 1e-9 * max(step.max(), np.abs(p).max() * 1e-3):
        k = int(np.argmin(step))
        raise ModelError(
            title,
            found=f"zero length between points {k} and {k + 1} at {p[k].tolist()} m",
            expected="a distance between neighbouring points",
            remedy="Remove one of the two points",
        )
    return p


def curve_through(points, elements: int, title: str, *, tangents=None, closed: bool = False) -> Curve:
    """Return the nodes of the cubic spline through points, at equal arc lengths.

    Parameters
    ----------
    points : (n, 3), m, in W
        Two points make a straight line.
    elements : int
    title : str
        Whose curve it is, for messages.
    tangents : (2, 3), optional
        Directions at both ends; by default the spline's own (no change of the third derivative near the ends).
    closed : bool
        The curve returns to its first point, smoothly.
    """
    from scipy.interpolate import CubicSpline

    p = checked_points(points, title)
    if closed:
        p = np.vstack([p, p[:1]])
    knots = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(p, axis=0), axis=1))])
    ends: str | tuple[tuple[int, np.ndarray], tuple[int, np.ndarray]]
    if closed:
        ends = "periodic"
    elif tangents is not None:
        t = finite_array(tangents)
        if t.shape != (2, 3) or np.linalg.norm(t, axis=1).min() == 0.0:
            raise ModelError(
                title,
                found=f"tangents = {tangents!r}",
                expected="two directions (2, 3)",
                remedy="Write tangents=((1, 0, 0), (0, 1, 0))",
            )
        t = t / np.linalg.norm(t, axis=1)[:, None]
        ends = ((1, t[0]), (1, t[1]))
    else:
        ends = "not-a-knot" if len(p) > 3 else "natural"
    spline = CubicSpline(knots, p, bc_type=ends)
    x, s = _arc_length(spline, knots)
    nodes = np.linspace(0.0, s[-1], elements + 1)[: elements if closed else None]
    at = np.interp(nodes, s, x)
    for _ in range(3):  # Newton: the table gives the start, the integral between its rows the rest
        k = np.clip(np.searchsorted(s, nodes, side="right") - 1, 0, len(s) - 2)
        half = 0.5 * (at - x[k])
        points_in = x[k][:, None] + half[:, None] * (1.0 + GAUSS[0])
        speed = np.linalg.norm(spline(points_in, 1), axis=2)
        miss = s[k] + half * (speed @ GAUSS[1]) - nodes
        at = np.clip(at - miss / np.linalg.norm(spline(at, 1), axis=1), x[0], x[-1])
    tangent = spline(at, 1)
    tangent /= np.linalg.norm(tangent, axis=1)[:, None]
    _refuse_folds(tangent, closed, title)
    return Curve(spline(at), tangent, float(s[-1]))


GAUSS = np.polynomial.legendre.leggauss(8)


def _arc_length(spline, knots, pieces: int = 32):
    """Return parameters and arc lengths at the ends of small pieces."""
    x = np.unique(np.concatenate([np.linspace(a, b, pieces + 1) for a, b in pairwise(knots)]))
    half = 0.5 * np.diff(x)
    inside = 0.5 * (x[1:] + x[:-1])[:, None] + half[:, None] * GAUSS[0]
    speed = np.linalg.norm(spline(inside, 1), axis=2)
    return x, np.concatenate([[0.0], np.cumsum(half * (speed @ GAUSS[1]))])


def _refuse_folds(t, closed, title) -> None:
    cosines = np.sum(t * np.roll(t, -1, axis=0), axis=1)[: None if closed else -1]
    if len(cosines) and cosines.min() < FOLD:
        k = int(np.argmin(cosines))
        angle = np.degrees(np.arccos(np.clip(cosines[k], -1.0, 1.0)))
        raise ModelError(
            title,
            found=f"the curve turns by {angle:.0f} degrees within element {k}",
            expected="less than 90 degrees in an element",
            remedy="Use more elements, or smoother points; a sharp corner is a joint between two bodies",
        )


def minimal_rotation(a, b) -> np.ndarray:
    """Return the rotation (3, 3) that turns the unit vector a into b by the smallest angle (about z if opposite)."""
    c, d = np.cross(a, b), float(np.dot(a, b))
    sine = float(np.linalg.norm(c))
    if d < 0.0 and sine < 1e-9:
        axis = np.array([0.0, 0.0, 1.0]) if abs(a[2]) < 0.9 else np.array([0.0, 1.0, 0.0])
        axis = axis - a * np.dot(a, axis)
        axis /= np.linalg.norm(axis)
        return 2.0 * np.outer(axis, axis) - np.eye(3)
    x, y, z = c / max(sine, 1e-300)
    angle = np.arctan2(sine, d)
    skew = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + np.sin(angle) * skew + (1.0 - np.cos(angle)) * skew @ skew
