"""The initial surface of a plate: splines through a grid of points, nodes, tangents, and elements that are in order."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from flexmb.errors import ModelError
from flexmb.model.described import finite_array, whole

__all__ = ["EDGES", "Surface", "checked_elements", "checked_points", "checked_thickness", "surface_through"]

MOST = 40_000
"""Elements of one plate: 200 x 200 take minutes to check, and 10 GB."""

EDGES = ((0, 1), (3, 2), (0, 3), (1, 2))
"""Edges of an element by its nodes: two along s, two along t."""
WARPED = 0.5
"""Smallest cosine between the normals at a corner and in the middle of an element: 60 degrees."""
GAUSS = np.polynomial.legendre.leggauss(8)


@dataclass(frozen=True, eq=False)
class Surface:
    """Nodes and elements of a grid.

    Parameters
    ----------
    r : (n, 3), m
        Nodes.
    tangents : (n, 2, 3)
        Unit vectors along s and t.
    cells : (ne, 4) int
        Nodes of the elements, counter-clockwise in (s, t); elements of one s follow each other.
    lengths : (ne, 4), m
        Arc lengths of the edges.
    shape : (2,) int
        Elements along s and t.
    """

    r: np.ndarray
    tangents: np.ndarray
    cells: np.ndarray
    lengths: np.ndarray
    shape: tuple[int, int]

    @property
    def normals(self) -> np.ndarray:
        """Unit normals at the nodes (n, 3)."""
        n = np.cross(self.tangents[:, 0], self.tangents[:, 1])
        return n / np.linalg.norm(n, axis=1)[:, None]


def checked_points(given: Any, title: str) -> np.ndarray:
    """Return a grid of points (p, q, 3); ModelError for anything else."""
    points = finite_array(given)
    if points.ndim != 3 or points.shape[2] != 3 or min(points.shape[:2]) < 2:
        raise ModelError(
            title,
            found=f"points of shape {np.shape(points)}",
            expected="a grid (p, q, 3) of finite numbers, m, at least 2 x 2",
            remedy="Write points=[[(0, 0, 0), (0, 1, 0)], [(2, 0, 0), (2, 1, 0)]]",
        )
    return points


def checked_elements(given: Any, points: np.ndarray, title: str) -> tuple[int, int]:
    """Return the numbers of elements along s and t, by default one between neighbouring points."""
    pair = (points.shape[0] - 1, points.shape[1] - 1) if given is None else whole(_listed(given))
    if (
        not isinstance(pair, tuple | list)
        or len(pair) != 2
        or not all(isinstance(n, int | np.integer) and n >= 1 for n in pair)
        or int(pair[0]) * int(pair[1]) > MOST
    ):
        raise ModelError(
            title,
            found=f"elements = {given!r}",
            expected=f"two whole numbers >= 1, along s and t, and at most {MOST} elements",
            remedy="Write elements=(16, 4)",
        )
    return int(pair[0]), int(pair[1])


def _listed(given: Any) -> Any:
    return given.tolist() if isinstance(given, np.ndarray) else given


def checked_thickness(given: Any, title: str) -> np.ndarray:
    """Return the thickness as a grid of at least 2 x 2 values, m; ModelError if one is not positive."""
    h = finite_array(given)
    if h.ndim not in (0, 2) or h.size == 0 or h.min() <= 0.0:
        raise ModelError(
            title,
            found=f"thickness = {given!r}",
            expected="a number > 0, m, or a grid (a, b) of them",
            remedy="Write thickness=0.002, or [[0.002, 0.002], [0.001, 0.001]] for a taper along s",
        )
    h = np.atleast_2d(h)
    return np.pad(h, [(0, int(n == 1)) for n in h.shape], mode="edge")


def _spline(points, s, t, ds=0, dt=0):
    """Return a tensor-product cubic spline through the grid, or its derivatives, at s x t, (ns, nt, 3)."""
    from scipy.interpolate import CubicSpline

    rows = CubicSpline(np.linspace(0.0, 1.0, points.shape[0]), points, axis=0)(s, ds)
    return CubicSpline(np.linspace(0.0, 1.0, points.shape[1]), rows, axis=1)(t, dt)


def _lengths(points, s, t):
    """Return the arc lengths of the grid lines along s between neighbouring s, at all t, (ns - 1, nt)."""
    half = 0.5 * np.diff(s)
    inside = (s[:-1] + half)[:, None] + half[:, None] * GAUSS[0]
    speed = np.linalg.norm(_spline(points, inside.ravel(), t, ds=1), axis=2).reshape(*inside.shape, len(t))
    return half[:, None] * np.einsum("egt,g->et", speed, GAUSS[1])


def _unit(vectors, title, along):
    size = np.linalg.norm(vectors, axis=-1, keepdims=True)
    if size.min() <= 1e-9 * size.max():
        raise ModelError(
            title,
            found=f"the surface has no tangent along {along} in some node",
            expected="points of a grid whose neighbours are apart",
            remedy="Take out repeated points; where lines meet in a point leave a small hole",
        )
    return vectors / size


def surface_through(points, elements, title: str) -> Surface:
    """Return the nodes at equal steps of the grid's numbers, on a cubic spline surface through the points.

    Parameters
    ----------
    points : (p, q, 3), m
        At least 2 x 2: straight between two, a parabola through three.
    elements : (2,) int
        Along s (first index) and t.

    Raises
    ------
    ModelError
        Elements without area, folded or warped.
    """
    ns, nt = elements
    s, t = np.linspace(0.0, 1.0, ns + 1), np.linspace(0.0, 1.0, nt + 1)
    r = _spline(points, s, t)
    ts, tt = _spline(points, s, t, ds=1), _spline(points, s, t, dt=1)
    i, j = np.meshgrid(np.arange(ns + 1), np.arange(nt + 1), indexing="ij")
    number = i * (nt + 1) + j if nt <= ns else j * (ns + 1) + i  # narrow band: the shorter side runs first
    corners = np.stack([number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]], axis=-1)
    along_s, along_t = _lengths(points, s, t), _lengths(points.swapaxes(0, 1), t, s).T
    lengths = np.stack([along_s[:, :-1], along_s[:, 1:], along_t[:-1], along_t[1:]], axis=-1)
    order = np.argsort(number.ravel())
    nodes = r.reshape(-1, 3)[order]
    tangents = np.stack([_unit(ts, title, "s"), _unit(tt, title, "t")], axis=2).reshape(-1, 2, 3)[order]
    _refuse_bad(nodes, corners.reshape(-1, 4), nt, title)
    return Surface(nodes, tangents, corners.reshape(-1, 4), lengths.reshape(-1, 4), (ns, nt))


def _refuse_bad(r, cells, nt, title) -> None:
    """Raise ModelError if the corners of an element do not face the same way, or it has no area."""
    x = r[cells]
    sides = np.roll(x, -1, axis=1) - x
    normals = np.cross(np.roll(sides, 1, axis=1), sides)
    mean = normals.mean(axis=1)
    area = np.linalg.norm(mean, axis=1)
    longest = np.linalg.norm(sides, axis=2).max(axis=1)
    for e in np.flatnonzero(area <= 1e-9 * longest**2)[:1]:
        raise ModelError(
            title,
            found=f"element ({e // nt}, {e % nt}) without area, {area[e]:.3g} m2",
            expected="four corners that span a surface",
            remedy="Take out repeated points, or points on one line",
        )
    facing = np.einsum("eki,ei->ek", normals, mean) / area[:, None]
    size = np.linalg.norm(normals, axis=2)
    for e in np.flatnonzero(facing.min(axis=1) <= 1e-9 * area)[:1]:
        k = int(np.argmin(facing[e]))
        raise ModelError(
            title,
            found=f"element ({e // nt}, {e % nt}) is folded at its corner {np.array2string(x[e, k], precision=4)} m",
            expected="corners with angles below 180 degrees",
            remedy="Put the points of the grid in order: neighbours beside each other",
        )
    cosine = facing / np.maximum(size, 1e-300)
    for e in np.flatnonzero(cosine.min(axis=1) < WARPED)[:1]:
        angle = np.degrees(np.arccos(np.clip(cosine[e].min(), -1.0, 1.0)))
        raise ModelError(
            title,
            found=f"element ({e // nt}, {e % nt}) is warped: a corner faces {angle:.0f} degrees away from the middle",
            expected="less than 60 degrees",
            remedy="Use more elements where the surface is twisted",
        )
