"""Closed meshes that pass through themselves, and shells within shells: where their distances have a wrong sign.

Two triangles cross if an edge of one passes through the other from side to side, or through its rim, as where solids
stand on each other. Triangles with a common edge meet in
it and nowhere else; of those with a common corner only the edges opposite to it are looked at. Boxes in a tree leave
few pairs. Source: Ericson, Real-Time Collision Detection, sections 5.2.10 (triangle against triangle) and 5.3.4 (line
against triangle); Jacobson, Kavan & Sorkine-Hornung, ACM Trans. Graph. 32 (2013) 33 (winding numbers).
"""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from flexmb.math.kernel import inner_kernel, kernel
from flexmb.surfaces.trees import built

__all__ = ["Shells", "crossings", "shells_of"]

MOST_SHELLS = 200
"""Of a mesh whose shells are looked at one by one."""
ROUNDING = 1e-12
"""Distance from a plane, relative to the size of the mesh, on neither of whose sides a corner lies."""
INSIDE = 1e-3
"""How far inside its shell a point lies, in volumes per area: further than places are rounded, behind a wall that is
not much thinner elsewhere."""


@inner_kernel
def _volume(p, q, r, s):
    """Return six times the signed volume of a tetrahedron."""
    a0, a1, a2 = p[0] - s[0], p[1] - s[1], p[2] - s[2]
    b0, b1, b2 = q[0] - s[0], q[1] - s[1], q[2] - s[2]
    c0, c1, c2 = r[0] - s[0], r[1] - s[1], r[2] - s[2]
    return a0 * (b1 * c2 - b2 * c1) + a1 * (b2 * c0 - b0 * c2) + a2 * (b0 * c1 - b1 * c0)


@inner_kernel
def _passes(p, q, a, b, c, least):
    """Does the line from p to q pass through the triangle abc? Both ends are further than `least` from its plane."""
    area = 0.0
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        area += ((b[j] - a[j]) * (c[k] - a[k]) - (b[k] - a[k]) * (c[j] - a[j])) ** 2
    above, below = _volume(a, b, c, p), _volume(a, b, c, q)
    none = least * area**0.5
    if not min(abs(above), abs(below)) > none or (above > 0.0) == (below > 0.0):
        return False
    u, v, w = _volume(p, q, a, b), _volume(p, q, b, c), _volume(p, q, c, a)
    return (u >= 0.0 and v >= 0.0 and w >= 0.0) or (u <= 0.0 and v <= 0.0 and w <= 0.0)


@inner_kernel
def _cross(vertices, triangles, m, n, least):
    """Does an edge of one triangle pass through the other?"""
    common, at_m, at_n = 0, -1, -1
    for i in range(3):
        for j in range(3):
            if triangles[m, i] == triangles[n, j]:
                common, at_m, at_n = common + 1, i, j
    if common > 1:
        return False
    for turn in range(2):
        own, other, at = (m, n, at_m) if turn == 0 else (n, m, at_n)
        a, b, c = vertices[triangles[other, 0]], vertices[triangles[other, 1]], vertices[triangles[other, 2]]
        for i in range(3):  # the edge opposite to corner i
            if common == 1 and i != at:
                continue
            p, q = vertices[triangles[own, (i + 1) % 3]], vertices[triangles[own, (i + 2) % 3]]
            if _passes(p, q, a, b, c, least):
                return True
    return False


@kernel
def _count_crossings(vertices, triangles, low, high, nodes, least):
    """Return how many pairs of triangles cross, and one of the first pair; all in the order of the tree."""
    count, first = 0, -1
    for m in range(len(triangles)):
        k = 0
        while k < len(nodes):
            apart = False
            for i in range(3):
                apart = apart or nodes[k, i] > high[m, i] or nodes[k, 3 + i] < low[m, i]
            code = int(nodes[k, 7])
            if apart:
                k = int(nodes[k, 6])
                continue
            for n in range(code // 16, code // 16 + code % 16):
                near = n > m
                for i in range(3):
                    near = near and low[n, i] <= high[m, i] and high[n, i] >= low[m, i]
                if near and _cross(vertices, triangles, m, n, least):
                    count += 1
                    first = m if first < 0 else first
            k += 1
    return count, first


def crossings(vertices: np.ndarray, triangles: np.ndarray) -> tuple[int, np.ndarray]:
    """Return how many pairs of triangles (m, 3) of a mesh pass through each other, and where one of them is (3,), m."""
    corners = vertices[triangles]
    order, nodes = built(corners.min(axis=1), corners.max(axis=1))
    own = np.ascontiguousarray(triangles[order])
    low, high = (np.ascontiguousarray(f(vertices[own], axis=1)) for f in (np.min, np.max))
    least = ROUNDING * float(np.ptp(vertices, axis=0).max())
    count, first = _count_crossings(np.ascontiguousarray(vertices), own, low, high, nodes, least)
    return int(count), vertices[own[first]].mean(axis=0) if count else np.zeros(3)


class Shells:
    """The closed shells that make up a mesh.

    Parameters
    ----------
    volumes : (n,), m3
        Below zero where the triangles go round the inward normal, as those of a cavity do.
    around : (n,)
        How many of the others go around a point just inside each: the sum of their signs. One that stands on another
        does not lie within it.
    places : (n, 3), m
        A point of each.
    """

    def __init__(self, volumes: np.ndarray, around: np.ndarray, places: np.ndarray):
        self.volumes, self.around, self.places = volumes, around, places

    @property
    def outside_in(self) -> np.ndarray:
        """The numbers of shells that are turned inside out: cavities with no solid around them."""
        return np.flatnonzero((self.volumes < 0.0) & (self.around < 1))

    @property
    def doubled(self) -> np.ndarray:
        """The numbers of shells of solids within solids."""
        return np.flatnonzero((self.volumes > 0.0) & (self.around > 0))


def shells_of(vertices: np.ndarray, triangles: np.ndarray) -> Shells:
    """Return the shells of a closed mesh, triangles (m, 3) of vertices (n, 3), all of which are used.

    Of more than `MOST_SHELLS` nobody looks what is around them: they count as right.
    """
    start, end = triangles.ravel(), np.roll(triangles, -1, axis=1).ravel()
    joined = coo_array((np.ones(len(start), np.int8), (start, end)), shape=(len(vertices),) * 2)
    count, of_vertex = connected_components(joined, directed=False)
    own = of_vertex[triangles[:, 0]]
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    volumes = np.bincount(own, weights=np.einsum("ij,ij->i", a, np.cross(b, c)) / 6.0, minlength=count)
    normals = 0.5 * np.cross(b - a, c - a)
    areas = np.linalg.norm(normals, axis=1)
    order = np.lexsort((-areas, own))
    widest = order[np.searchsorted(own[order], np.arange(count))]  # the largest triangle of each
    deep = INSIDE * volumes / np.bincount(own, weights=areas, minlength=count) / areas[widest]
    places, around = (a + b + c)[widest] / 3.0, np.where(volumes < 0.0, 1, 0)
    if 1 < count <= MOST_SHELLS:
        for k, z in enumerate(places - deep[:, None] * normals[widest]):
            others = own != k
            around[k] = round(_winding(z, a[others], b[others], c[others]))
    elif count == 1:
        around[:] = 0
    return Shells(volumes, around, places)


def _winding(z: np.ndarray, a: np.ndarray, b: np.ndarray, c: np.ndarray) -> float:
    """Return how many times triangles go around a point: the sum of solid angles (van Oosterom & Strackee 1983)."""
    a, b, c = a - z, b - z, c - z
    x, y, w = (np.linalg.norm(v, axis=1) for v in (a, b, c))
    up = np.einsum("ij,ij->i", a, np.cross(b, c))
    dot = lambda p, q: np.einsum("ij,ij->i", p, q)  # noqa: E731
    down = x * y * w + dot(a, b) * w + dot(b, c) * x + dot(c, a) * y
    return float(np.arctan2(up, down).sum() / (2.0 * np.pi))
