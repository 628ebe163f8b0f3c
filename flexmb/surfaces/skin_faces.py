"""Points against the faces of a deforming skin: the nearest place on triangles or lines between markers.

The tree over the faces is built once, on the undeformed skin; in each evaluation its boxes are refitted to where the
corners are, from the leaves up. Source: Ericson, Real-Time Collision Detection, sections 6.6.2 and 13.1.2 (refitting);
van den Bergen 1997, Efficient collision detection of complex deformable models using AABB trees.
"""

from __future__ import annotations

import numpy as np

from flexmb.math.kernel import inner_kernel, kernel
from flexmb.math.vectors import dot
from flexmb.surfaces.mesh_distance import nearest_on_triangle
from flexmb.surfaces.trees import DEPTH, built

__all__ = [
    "FACET",
    "KNOT",
    "PLACE",
    "TOUCHING",
    "corner_boxes",
    "facing",
    "nearest_face",
    "nearest_on",
    "packed_faces",
    "signed_place",
]

FACET, KNOT = 9, 2
"""Numbers of a face and of a node of the tree.

A face has three corners, then 1 where the edges ab, bc, ca, and where a, b, c, are on a rim of the skin; a node the one
that follows when it is passed over, and 16 times the first face plus their number, or 0 if it is no leaf.
"""

PLACE = np.dtype(
    [
        ("facet", np.int64),  # -1: none is near
        ("where", np.int64),  # 0 on the face, 1 to 3 on ab, bc, ca, 4 to 6 at a, b, c
        ("free", np.int64),  # 1 where the skin ends
        ("distance", float),  # m, with a sign: negative behind a face of a solid
        ("share", float, 3),  # of the corners
        ("p", float, 3),  # m, in W
        ("n", float, 3),  # unit vector from there to the point
    ],
    align=True,
)
"""The place of a skin that is nearest to a point."""

SAME = 1e-10
"""Relative difference of squares of distances up to which two faces meet at the nearest place."""
TOUCHING = 1e-12
"""Distance, relative to the size of a face, below which its normal is taken."""


def packed_faces(places: np.ndarray, facets: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return faces (n, 9) in the order of their tree, its nodes (k, 2), and the order (n,).

    Parameters
    ----------
    places : (c, 3), m
        Of the corners of the undeformed skin.
    facets : (n, 3)
        Corners of the faces, -1 in the last column for lines.
    """
    solid = facets[:, 2] >= 0
    own = np.where(facets < 0, facets[:, 1:2], facets)
    corners = places[own]
    order, nodes = built(np.ascontiguousarray(corners.min(axis=1)), np.ascontiguousarray(corners.max(axis=1)))
    edges = np.sort(np.stack([own, np.roll(own, -1, axis=1)], axis=2), axis=2)
    _, which, counts = np.unique(edges.reshape(-1, 2), axis=0, return_inverse=True, return_counts=True)
    free = (counts[which.reshape(-1, 3)] == 1) & solid[:, None]
    rim = np.isin(own, edges[free])
    return np.hstack([facets, free, rim]).astype(float)[order], nodes[:, 6:8].copy(), order


@kernel
def corner_boxes(data, facets, nodes, count, X, boxes):
    """Write the boxes (count, 6) of all nodes around the corners X (c, 3) of their faces, from the leaves up."""
    for k in range(count - 1, -1, -1):
        box = boxes[k]
        code = int(data[nodes + KNOT * k + 1])
        if code == 0:
            left, right = boxes[k + 1], boxes[int(data[nodes + KNOT * (k + 1)])]
            for i in range(3):
                box[i], box[3 + i] = min(left[i], right[i]), max(left[3 + i], right[3 + i])
            continue
        box[0:3], box[3:6] = np.inf, -np.inf
        for m in range(code // 16, code // 16 + code % 16):
            for c in range(3):
                corner = int(data[facets + FACET * m + c])
                if corner >= 0:
                    for i in range(3):
                        box[i], box[3 + i] = min(box[i], X[corner, i]), max(box[3 + i], X[corner, i])


@inner_kernel
def _apart(box, z):
    """Return the square of the distance of a point from a box."""
    square = 0.0
    for i in range(3):
        beyond = max(box[i] - z[i], z[i] - box[3 + i], 0.0)
        square += beyond * beyond
    return square


@kernel
def facing(triangle, z, p):
    """Return the cosine, times the distance, between the normal of a triangle and the way from p to z."""
    N = np.empty(3)
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        N[i] = (triangle[3 + j] - triangle[j]) * (triangle[6 + k] - triangle[k])
        N[i] -= (triangle[3 + k] - triangle[k]) * (triangle[6 + j] - triangle[j])
    along = 0.0
    for i in range(3):
        along += N[i] * (z[i] - p[i])
    return along / max(dot(N, N) ** 0.5, 1e-300)


@kernel
def nearest_on(data, facet, X, triangle, z, p):
    """Write the corners and the nearest point of a face or line; return where on it that is."""
    line = data[facet + 2] < 0.0
    for c in range(3):
        corner = int(data[facet + (1 if line and c == 2 else c)])
        for i in range(3):
            triangle[3 * c + i] = X[corner, i]
    if not line:
        return nearest_on_triangle(triangle, 0, z, p)
    along, square = 0.0, 0.0
    for i in range(3):
        e = triangle[3 + i] - triangle[i]
        along += e * (z[i] - triangle[i])
        square += e * e
    s = along / square
    where = 4 if s <= 0.0 else 5 if s >= 1.0 else 1
    s = min(max(s, 0.0), 1.0)
    for i in range(3):
        p[i] = triangle[i] + s * (triangle[3 + i] - triangle[i])
    return where


@kernel
def nearest_face(data, facets, nodes, X, boxes, z, within, place):
    """Write which face is nearest to z (3,), m, in W, where on it, and the nearest point; -1 if none is `within`.

    Where several meet there, it is the one that z looks at most steeply: it tells on which side z is.
    """
    stack = np.empty(DEPTH, np.int64)
    triangle = np.empty(9)
    p = np.empty(3)
    least, steepest = within * within, 0.0
    place.facet = -1
    stack[0], top = 0, 1
    while top > 0:
        top -= 1
        k = stack[top]
        if _apart(boxes[k], z) > least * (1.0 + SAME):
            continue
        code = int(data[nodes + KNOT * k + 1])
        if code == 0:
            left = k + 1
            right = int(data[nodes + KNOT * left])
            if _apart(boxes[left], z) > _apart(boxes[right], z):
                left, right = right, left
            stack[top], stack[top + 1] = right, left
            top += 2
            continue
        for m in range(code // 16, code // 16 + code % 16):
            facet = facets + FACET * m
            where = nearest_on(data, facet, X, triangle, z, p)
            square = (z[0] - p[0]) ** 2 + (z[1] - p[1]) ** 2 + (z[2] - p[2]) ** 2
            if square > least * (1.0 + SAME):
                continue
            steep = abs(facing(triangle, z, p)) if data[facet + 2] >= 0.0 else 0.0
            if square < least * (1.0 - SAME) or place.facet < 0 or steep > steepest:
                least, steepest = min(square, least), steep
                place.facet, place.where = m, where
                place.p[:] = p


@kernel
def signed_place(data, facets, X, z, solid, place):
    """Complete a place that was found: distance, normal and shares of the corners; `solid`: with a side inside."""
    triangle = np.empty(9)
    p = np.empty(3)
    N = np.empty(3)
    facet = facets + FACET * place.facet
    where = nearest_on(data, facet, X, triangle, z, p)
    line = data[facet + 2] < 0.0
    size, square = 0.0, 0.0
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        N[i] = (triangle[3 + j] - triangle[j]) * (triangle[6 + k] - triangle[k])
        N[i] -= (triangle[3 + k] - triangle[k]) * (triangle[6 + j] - triangle[j])
        place.n[i] = z[i] - p[i]
        square += place.n[i] ** 2
        size = max(size, abs(triangle[3 + i] - triangle[i]), abs(triangle[6 + i] - triangle[i]))
    area, distance = dot(N, N) ** 0.5, square**0.5
    along = 0.0 if line else dot(N, place.n) / area
    if not line and (where == 0 or distance <= TOUCHING * size):
        sign = 1.0 if solid or along >= 0.0 else -1.0
        place.distance = sign * along
        for i in range(3):
            place.n[i] = sign * N[i] / area
    else:
        sign = -1.0 if solid and along < 0.0 else 1.0
        place.distance = sign * distance
        for i in range(3):
            place.n[i] *= sign / max(distance, 1e-300)
    place.share[:] = 0.0
    place.free = 0
    if where >= 4:
        place.share[where - 4] = 1.0
        place.free = 1 if data[facet + 6 + where - 4] > 0.0 else 0
    elif where >= 1:
        a, b = where - 1, where % 3
        s, square = 0.0, 0.0
        for i in range(3):
            e = triangle[3 * b + i] - triangle[3 * a + i]
            s += e * (p[i] - triangle[3 * a + i])
            square += e * e
        place.share[b] = s / square
        place.share[a] = 1.0 - s / square
        place.free = 1 if data[facet + 3 + a] > 0.0 else 0
    else:
        d00, d01, d11, d20, d21 = 0.0, 0.0, 0.0, 0.0, 0.0
        for i in range(3):
            u, v, w = triangle[3 + i] - triangle[i], triangle[6 + i] - triangle[i], p[i] - triangle[i]
            d00 += u * u
            d01 += u * v
            d11 += v * v
            d20 += w * u
            d21 += w * v
        place.share[1] = (d11 * d20 - d01 * d21) / (d00 * d11 - d01 * d01)
        place.share[2] = (d00 * d21 - d01 * d20) / (d00 * d11 - d01 * d01)
        place.share[0] = 1.0 - place.share[1] - place.share[2]
    place.p[:] = p
    place.where = where
