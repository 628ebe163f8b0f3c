"""Cubic splines through points in space: the numbers that kernels read, and their evaluation."""

from __future__ import annotations

import numpy as np

from flexmb.math.kernel import kernel
from flexmb.math.plain_loops import knots_until

__all__ = ["cardinal_splines", "evaluate_cardinal", "evaluate_spline", "nearest_parameter", "pack_spline"]


def pack_spline(points: np.ndarray, closed: bool, across: np.ndarray | None = None) -> np.ndarray:
    """Return [n, knots (n,), coefficients (n - 1, 4, 6)] of the curve and of a normal that varies smoothly along it.

    The parameter is the length of the chords; the spline has not-a-knot ends (de Boor) or is periodic. The normals at
    the knots minimise rotation (Wang et al. 2008, double reflection) and are interpolated like the points.

    Parameters
    ----------
    points : (n, 3), m
        For a closed curve the first point is repeated at the end.
    across : (3,), optional
        The first normal is across this direction; by default the normal of a plane curve lies in its plane.
    """
    from scipy.interpolate import CubicSpline

    knots = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    ends = "periodic" if closed else "not-a-knot" if len(points) > 3 else "natural"
    curve = CubicSpline(knots, points, bc_type=ends)
    tangents = curve(knots, 1)
    tangents /= np.linalg.norm(tangents, axis=1)[:, None]
    normals = _normals(points, tangents, across)
    if closed:  # the twist that is left after one round is spread evenly
        b = np.cross(tangents[0], normals[0])
        twist = np.arctan2(normals[-1] @ b, normals[-1] @ normals[0])
        for k, t in enumerate(tangents):
            angle = -twist * knots[k] / knots[-1]
            normals[k] = np.cos(angle) * normals[k] + np.sin(angle) * np.cross(t, normals[k])
        normals[-1] = normals[0]
    both = np.concatenate([curve.c, CubicSpline(knots, normals, bc_type=ends).c], axis=2)
    return np.concatenate([[len(knots)], knots, both.transpose(1, 0, 2).ravel()])


def _normals(points, tangents, across) -> np.ndarray:
    """Return normals (n, 3) at the points; normals of a plane curve lie in its plane."""
    binormal = np.linalg.svd(points - points.mean(axis=0))[2][2] if across is None else across
    first = np.cross(binormal, tangents[0])
    if np.linalg.norm(first) < 1e-8:
        first = np.cross(np.eye(3)[np.argmin(np.abs(tangents[0]))], tangents[0])
    normals = [first / np.linalg.norm(first)]
    for k in range(len(points) - 1):
        step = points[k + 1] - points[k]
        r = normals[k] - 2.0 / (step @ step) * (step @ normals[k]) * step
        t = tangents[k] - 2.0 / (step @ step) * (step @ tangents[k]) * step
        turn = tangents[k + 1] - t
        square = turn @ turn
        normals.append(r if square < 1e-30 else r - 2.0 / square * (turn @ r) * turn)
    return np.array(normals)


def cardinal_splines(points: np.ndarray) -> np.ndarray:
    """Return [n, knots (n,), coefficients (n - 1, 4, n)] of the splines B_k that are 1 at point k and 0 at the others.

    The spline through points that have moved is sum_k B_k r_k: knots remain the lengths of the chords of `points`
    (n, 3). Ends as in `pack_spline`.
    """
    from scipy.interpolate import CubicSpline

    knots = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    n = len(knots)
    splines = CubicSpline(knots, np.eye(n), bc_type="not-a-knot" if n > 3 else "natural")
    return np.concatenate([[n], knots, splines.c.transpose(1, 0, 2).ravel()])


@kernel
def evaluate_cardinal(table, s, out):
    """Write the cardinal splines and their first, second and third derivatives to `out` (4, n).

    Beyond the ends they go on straight.
    """
    n = int(table[0])
    length = table[n]
    inside = min(max(s, 0.0), length)
    i = min(max(knots_until(table[1 : n + 1], inside) - 1, 0), n - 2)
    h, at = inside - table[1 + i], n + 1 + 4 * n * i
    for k in range(n):
        a, b, c, d = table[at + k], table[at + n + k], table[at + 2 * n + k], table[at + 3 * n + k]
        out[0, k] = ((a * h + b) * h + c) * h + d
        out[1, k] = (3.0 * a * h + 2.0 * b) * h + c
        out[2, k] = 6.0 * a * h + 2.0 * b
        out[3, k] = 6.0 * a
        if s != inside:
            out[0, k] += (s - inside) * out[1, k]
            out[2, k] = 0.0
            out[3, k] = 0.0


@kernel
def evaluate_spline(table, s, closed, out):
    """Write curve and normal, their first, second and third derivatives, to `out` (4, 6).

    Beyond the ends an open curve goes on straight; a closed one repeats.
    """
    n = int(table[0])
    knots, coefficients = table[1 : n + 1], table[n + 1 :]
    length = knots[n - 1]
    if closed:
        s -= length * np.floor(s / length)
    inside = min(max(s, 0.0), length)
    i = min(max(knots_until(knots, inside) - 1, 0), n - 2)
    h = inside - knots[i]
    for k in range(6):
        a, b = coefficients[24 * i + k], coefficients[24 * i + 6 + k]
        c, d = coefficients[24 * i + 12 + k], coefficients[24 * i + 18 + k]
        out[0, k] = ((a * h + b) * h + c) * h + d
        out[1, k] = (3.0 * a * h + 2.0 * b) * h + c
        out[2, k] = 6.0 * a * h + 2.0 * b
        out[3, k] = 6.0 * a
    if s != inside:
        for k in range(6):
            if k < 3:
                out[0, k] += (s - inside) * out[1, k]
            else:
                out[1, k] = 0.0
            out[2, k] = 0.0
            out[3, k] = 0.0


@kernel
def nearest_parameter(table, p, start, closed, axis, out):
    """Return the parameter of the point of the curve nearest to `p` (3,), near `start`; `out` is evaluated there.

    Newton's method on c' . (p - c) = 0; where the distance bends down (a point beyond the centre of curvature) Gauss'
    approximation leads away from the maximum. Steps that lead farther away are halved. With `axis` >= 0 the distance
    along that axis is left out.
    """
    s, step, least = start, 0.0, np.inf
    limit = 0.1 * table[int(table[0])]
    for _ in range(100):
        evaluate_spline(table, s, closed, out)
        along, square, bent, far = 0.0, 0.0, 0.0, 0.0
        for i in range(3):
            if i != axis:
                e = p[i] - out[0, i]
                along += out[1, i] * e
                square += out[1, i] ** 2
                bent += out[2, i] * e
                far += e * e
        if far > least * (1.0 + 1e-12):
            step *= 0.5
            s -= step
        else:
            least = far
            slope = square - bent
            if slope <= 0.0:
                slope = square
            step = min(max(along / slope, -limit), limit)
            s += step
        if abs(step) <= 1e-14 * limit:
            break
    evaluate_spline(table, s, closed, out)
    return s
