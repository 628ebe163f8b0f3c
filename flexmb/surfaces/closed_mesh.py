"""Meshes of triangles as surfaces of solids: what is wrong with one, and the normals of faces, edges and corners."""

from __future__ import annotations

from typing import Any

import numpy as np

from flexmb.errors import MeshError
from flexmb.surfaces.mesh_crossings import shells_of

__all__ = ["checked_mesh", "inset", "mean_normals", "twins"]

MOST = 5_000_000
FARTHEST = 1e15
"""m, largest coordinate."""
SAME = 1e-9
"""Distance relative to the size of the mesh within which vertices are one."""
FARTHEST_IN = 10.0
"""Way of a vertex behind faces that meet in a needle, relative to the depth that is asked for."""
SLIVER = 1e-10
"""Area of a triangle relative to the square of its longest side below which it has no normal."""


def _complain(title: str, found: str, expected: str, remedy: str) -> None:
    raise MeshError(title, found=found, expected=expected, remedy=remedy)


def checked_mesh(vertices: Any, triangles: Any, title: str) -> tuple[np.ndarray, np.ndarray]:
    """Return vertices (n, 3) that are used, those at one place joined, and triangles (m, 3) of a closed mesh.

    Raises
    ------
    MeshError
        Numbers that are none, triangles that do not exist, have no area or overlap, an open or inverted surface.
    """
    vertices, triangles = _arrays(vertices, triangles, title)
    size = float(np.ptp(vertices, axis=0).max())
    if not size > 0.0:
        _complain(title, "all vertices at one place", "a surface around a solid", "Export the mesh again")
    _, first, which = np.unique(np.round(vertices / (SAME * size)), axis=0, return_index=True, return_inverse=True)
    vertices, triangles = vertices[first], which.ravel()[triangles]
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    area = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)
    longest = np.max([np.sum((x - y) ** 2, axis=1) for x, y in ((a, b), (b, c), (c, a))], axis=0)
    thin = np.flatnonzero(area <= SLIVER * longest)
    if len(thin):
        k = thin[0]
        _complain(
            title,
            f"{len(thin)} triangle(s) without area, the first is number {k} near {np.round(a[k], 9).tolist()} m",
            "triangles with a normal",
            "Repair the mesh (merge vertices, remove degenerate faces) and export it again",
        )
    _check_edges(vertices, triangles, title)
    volume = np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0
    if volume < 0.0:
        _complain(
            title,
            f"a volume of {volume:.6g} m3: the triangles go round the inward normal",
            "triangles round the outward normal",
            "Flip the normals: triangles[:, ::-1]",
        )
    if 2.0 * volume <= SAME * size * area.sum():
        _complain(
            title,
            f"a volume of {volume:.3g} m3 on an area of {area.sum():.3g} m2: it has no thickness",
            "a surface around a solid",
            "Give the solid its thickness; scale= is metres per unit of the file",
        )
    used = np.unique(triangles)
    number = np.zeros(len(vertices), np.int64)
    number[used] = np.arange(len(used))
    vertices, triangles = vertices[used], number[triangles]
    shells = shells_of(vertices, triangles)
    if len(shells.outside_in):
        k = shells.outside_in[0]
        _complain(
            title,
            f"{len(shells.outside_in)} of {len(shells.volumes)} closed shells turned inside out, one with the volume "
            f"{shells.volumes[k]:.6g} m3 near {np.round(shells.places[k], 9).tolist()} m",
            "triangles round the outward normal, but for cavities within a solid",
            "Flip the normals of this shell and export the mesh again",
        )
    return vertices, triangles


def _arrays(vertices: Any, triangles: Any, title: str) -> tuple[np.ndarray, np.ndarray]:
    try:
        points, cells = np.asarray(vertices, float), np.asarray(triangles)
    except (TypeError, ValueError, OverflowError):
        points, cells = np.empty(0), np.empty(0)
    whole = cells.dtype.kind in "iu" or (cells.dtype.kind == "f" and bool(np.all(cells == np.round(cells))))
    if points.ndim != 2 or points.shape[1:] != (3,) or cells.ndim != 2 or cells.shape[1:] != (3,) or not whole:
        _complain(
            title,
            f"vertices of the shape {points.shape} and triangles of the shape {cells.shape}",
            "vertices (n, 3), m, and triangles (m, 3), numbers of vertices",
            "Divide quadrilaterals into triangles",
        )
    if not 4 <= len(cells) <= MOST:
        _complain(title, f"{len(cells)} triangles", f"4 to {MOST}", "Export the surface of a solid")
    if not np.all(np.isfinite(points)) or np.abs(points).max() > FARTHEST:
        k = int(np.flatnonzero(~np.all(np.isfinite(points) & (np.abs(points) <= FARTHEST), axis=1))[0])
        _complain(title, f"vertex {k} at {points[k].tolist()}", "finite coordinates, m", "Export the mesh again")
    if cells.min() < 0 or cells.max() >= len(points):
        _complain(
            title,
            f"a triangle of the vertices {cells.min()} to {cells.max()}",
            f"numbers 0 to {len(points) - 1}",
            "Count vertices from 0",
        )
    return points, cells.astype(np.int64)


def _check_edges(vertices: np.ndarray, triangles: np.ndarray, title: str) -> None:
    """Raise MeshError unless each edge is passed once in each direction."""
    start, end = triangles.ravel(), np.roll(triangles, -1, axis=1).ravel()
    n = len(vertices)
    there, back = np.sort(start * n + end), np.sort(end * n + start)
    if len(there) == len(back) and np.array_equal(there, back) and np.all(np.diff(there) > 0):
        return
    edges, counts = np.unique(np.minimum(start, end) * n + np.maximum(start, end), return_counts=True)
    at = lambda edge: np.round(0.5 * (vertices[edge // n] + vertices[edge % n]), 9).tolist()  # noqa: E731
    lone, crowded = edges[counts == 1], edges[counts > 2]
    if len(lone):
        _complain(
            title,
            f"{len(lone)} edge(s) of one triangle only, the first near {at(lone[0])} m: the surface is open",
            "a closed surface",
            "Close the holes and export the mesh again",
        )
    if len(crowded):
        _complain(
            title,
            f"{len(crowded)} edge(s) of more than two triangles, the first near {at(crowded[0])} m",
            "a surface around a solid",
            "Remove inner or doubled faces",
        )
    twice = there[:-1][np.diff(there) == 0]
    _complain(
        title,
        f"neighbours of opposite sense at {len(twice)} edge(s), the first near {at(twice[0])} m",
        "triangles round the outward normal everywhere",
        "Make the normals consistent and export the mesh again",
    )


def twins(triangles: np.ndarray, count: int) -> np.ndarray:
    """Return, for each side ab, bc, ca of triangles (m, 3) of a closed mesh of `count` vertices, which side of which
    other triangle runs along it the other way: 3 times its number plus the number of the side (3 m,).
    """
    start, end = triangles.ravel(), np.roll(triangles, -1, axis=1).ravel()
    own, other = start * count + end, end * count + start
    order = np.argsort(own)
    return order[np.searchsorted(own[order], other)]


def inset(vertices: np.ndarray, triangles: np.ndarray, depth: float) -> np.ndarray:
    """Return the ways (n, 3), m, on which the vertices come behind all faces around them by `depth`, m, as well as can
    be; none is longer than `FARTHEST_IN` of it.
    """
    corners = vertices[triangles]
    faces = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    faces /= np.linalg.norm(faces, axis=1, keepdims=True)
    squares, sums = np.zeros((len(vertices), 3, 3)), np.zeros((len(vertices), 3))
    for k in range(3):
        np.add.at(squares, triangles[:, k], faces[:, :, None] * faces[:, None, :])
        np.add.at(sums, triangles[:, k], faces)
    # least squares of n.x = 1 over these faces; in a plane or along an edge the shortest way
    way = np.einsum("nij,nj->ni", np.linalg.pinv(squares, rcond=1e-8, hermitian=True), sums)
    way *= np.minimum(1.0, FARTHEST_IN / np.maximum(np.linalg.norm(way, axis=1), 1.0))[:, None]
    return -depth * way


def mean_normals(vertices: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return unit normals of the faces (m, 3), of their edges ab, bc, ca (m, 3, 3) and of the vertices (n, 3).

    At a vertex each face counts by its angle there, at an edge both by half (Baerentzen & Aanaes 2005).
    """
    corners = vertices[triangles]
    faces = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    faces /= np.linalg.norm(faces, axis=1, keepdims=True)
    tips = np.zeros_like(vertices)
    for k in range(3):
        u, v = corners[:, (k + 1) % 3] - corners[:, k], corners[:, (k + 2) % 3] - corners[:, k]
        angle = np.arctan2(np.linalg.norm(np.cross(u, v), axis=1), np.einsum("ij,ij->i", u, v))
        np.add.at(tips, triangles[:, k], angle[:, None] * faces)
    beside = twins(triangles, len(vertices)) // 3
    edges = faces[:, None, :] + faces[beside].reshape(-1, 3, 3)
    for normals in (tips, edges):
        size = np.linalg.norm(normals, axis=-1, keepdims=True)
        normals /= np.where(size > 1e-12, size, 1.0)
    return faces, edges, tips
