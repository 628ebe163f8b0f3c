"""Where two boxes touch: all points share the normal of the plane that tells the boxes apart.

Between convex bodies that do not overlap stands a plane. For two boxes its normal is a face's, or is at right angles
to an edge of each: 15 directions, of which the one with the largest gap counts. With the normal of a face, the face of
the other box that looks at it is cut to its outline, so edges that cross are seen, and one box may hang over the other.
With two edges there is one point.

Source: Gottschalk, Lin & Manocha 1996 (separating axes of boxes); Sutherland & Hodgman 1974 (cutting polygons).
"""

from __future__ import annotations

import numpy as np

from flexmb.math.kernel import inner_kernel, kernel
from flexmb.math.vectors import dot
from flexmb.surfaces.polygons import cut_polygon
from flexmb.surfaces.records import CODE, HEADER

__all__ = ["BOX", "are_boxes", "find_between_boxes", "plane_between_boxes"]

BOX = 4
"""Code of a cuboid."""
BETTER = 1e-6
"""By how much, relative to the smallest half edge, an edge must be farther than a face to give the normal."""
PARALLEL = 1e-4
"""Square of the sine between edges up to which a face gives their normal."""
MOST = 12
"""Corners of a rectangle cut by a rectangle, at most 8, and some more."""


@kernel
def are_boxes(data, at_a, at_b):
    """Are both surfaces cuboids?"""
    return int(data[at_a + CODE]) == BOX and int(data[at_b + CODE]) == BOX


@kernel
def plane_between_boxes(data, at_a, at_b, d, Q, n):
    """Write the normal n (3,) from a to b of the plane between two boxes; return the gap along it, m, and its kind.

    The kind is i of the face i of a, 3 + j of b, or 6 + 3 i + j of the edges i of a and j of b. The gap is at most the
    distance of the boxes, and negative where they overlap.
    """
    a, b = data[at_a + HEADER : at_a + HEADER + 3], data[at_b + HEADER : at_b + HEADER + 3]
    best, kind = -np.inf, 0
    slack = np.inf
    e = np.empty(3)
    for i in range(3):
        slack = min(slack, BETTER * a[i], BETTER * b[i])
    for i in range(3):
        gap = abs(d[i]) - a[i]
        for j in range(3):
            gap -= abs(Q[i, j]) * b[j]
        if gap > best + (slack if i > 0 else 0.0):
            best, kind = gap, i
    for j in range(3):
        gap = abs(d[0] * Q[0, j] + d[1] * Q[1, j] + d[2] * Q[2, j]) - b[j]
        for i in range(3):
            gap -= abs(Q[i, j]) * a[i]
        if gap > best + slack:
            best, kind = gap, 3 + j
    for i in range(3):
        k, m = (i + 1) % 3, (i + 2) % 3
        for j in range(3):
            square = Q[k, j] ** 2 + Q[m, j] ** 2
            if square < PARALLEL:
                continue
            # e_i x Q_j
            size = square**0.5
            e[i], e[k], e[m] = 0.0, -Q[m, j] / size, Q[k, j] / size
            gap = abs(dot(d, e)) - a[k] * abs(e[k]) - a[m] * abs(e[m])
            for x in range(3):
                if x != j:
                    gap -= b[x] * abs(e[0] * Q[0, x] + e[1] * Q[1, x] + e[2] * Q[2, x])
            if gap > best + slack:
                best, kind = gap, 6 + 3 * i + j
                n[:] = e
    if kind < 3:
        n[:] = 0.0
        n[kind] = 1.0
    elif kind < 6:
        n[:] = Q[:, kind - 3]
    if dot(n, d) < 0.0:
        for i in range(3):
            n[i] = -n[i]
    return best, kind


@inner_kernel
def _face_points(own, other, d, Q, n, face, margin, points):
    """Write the corners (n, 3) of the other box's face that looks at the face `face` of a box, cut to its outline.

    All in the axes of the box with the half edges `own`, n (3,) is the outward normal of its face; the other one lies
    at d with the axes Q. Returns how many are nearer than the margin.
    """
    axis, steepest = 0, -1.0
    for j in range(3):
        along = abs(n[0] * Q[0, j] + n[1] * Q[1, j] + n[2] * Q[2, j])
        if along > steepest:
            axis, steepest = j, along
    along = n[0] * Q[0, axis] + n[1] * Q[1, axis] + n[2] * Q[2, axis]
    side = -1.0 if along > 0.0 else 1.0
    u, w = (axis + 1) % 3, (axis + 2) % 3
    polygon, cut, wall = np.empty((MOST, 3)), np.empty((MOST, 3)), np.empty(3)
    for m in range(4):
        s = 1.0 if m == 0 or m == 3 else -1.0
        t = 1.0 if m < 2 else -1.0
        for i in range(3):
            polygon[m, i] = d[i] + side * other[axis] * Q[i, axis] + s * other[u] * Q[i, u] + t * other[w] * Q[i, w]
    count = 4
    for step in range(1, 3):
        border = (face + step) % 3
        wall[:] = 0.0
        wall[border] = 1.0
        count = cut_polygon(polygon, count, wall, own[border], 0.0, cut)
        wall[border] = -1.0
        count = cut_polygon(cut, count, wall, own[border], 0.0, polygon)
    found = 0
    for m in range(count):
        if dot(n, polygon[m]) - own[face] < margin:
            points[found] = polygon[m]
            found += 1
    return found


@inner_kernel
def _edge_points(a, b, d, Q, n, i, j, p, q):
    """Write the points of the edges i of a and j of b that are nearest to each other; return if they lie on both."""
    r = np.empty(3)
    for k in range(3):
        p[k] = 0.0 if k == i else (a[k] if n[k] > 0.0 else -a[k])
        q[k] = d[k]
    for k in range(3):
        if k != j:
            along = n[0] * Q[0, k] + n[1] * Q[1, k] + n[2] * Q[2, k]
            for m in range(3):
                q[m] -= (b[k] if along > 0.0 else -b[k]) * Q[m, k]
    for k in range(3):
        r[k] = q[k] - p[k]
    c, on_b = Q[i, j], r[0] * Q[0, j] + r[1] * Q[1, j] + r[2] * Q[2, j]
    s = (r[i] - c * on_b) / (1.0 - c * c)
    t = s * c - on_b
    p[i] += s
    for k in range(3):
        q[k] += t * Q[k, j]
    return abs(s) <= a[i] and abs(t) <= b[j]


@kernel
def find_between_boxes(data, at_a, at_b, margin, d, Q, contacts):
    """Write the points at which two boxes are nearer than the margin, m; return how many: places, normals and gaps."""
    a, b = data[at_a + HEADER : at_a + HEADER + 3], data[at_b + HEADER : at_b + HEADER + 3]
    n = np.empty(3)
    gap, kind = plane_between_boxes(data, at_a, at_b, d, Q, n)
    if not gap < margin:
        return 0
    points, found = np.empty((MOST, 3)), 0
    if kind < 3:
        found = _face_points(a, b, d, Q, n, kind, margin, points)
        for m in range(found):
            contacts[m].gap = dot(n, points[m]) - a[kind]
            contacts[m].x[:] = points[m]
    elif kind < 6:
        back, turned, facing = np.empty(3), np.empty((3, 3)), np.empty(3)
        for i in range(3):
            back[i] = -(Q[0, i] * d[0] + Q[1, i] * d[1] + Q[2, i] * d[2])
            facing[i] = -(Q[0, i] * n[0] + Q[1, i] * n[1] + Q[2, i] * n[2])
            for j in range(3):
                turned[i, j] = Q[j, i]
        found = _face_points(b, a, back, turned, facing, kind - 3, margin, points)
        for m in range(found):
            contacts[m].gap = dot(facing, points[m]) - b[kind - 3]
            for i in range(3):
                contacts[m].x[i] = (
                    d[i]
                    + Q[i, 0] * points[m, 0]
                    + Q[i, 1] * points[m, 1]
                    + Q[i, 2] * points[m, 2]
                    + contacts[m].gap * n[i]
                )
    else:
        i, j = (kind - 6) // 3, (kind - 6) % 3
        if _edge_points(a, b, d, Q, n, i, j, points[0], points[1]):
            found = 1
            contacts[0].gap = gap
            contacts[0].x[:] = points[1]
    for m in range(found):
        contacts[m].n[:] = n
        contacts[m].area = 1.0
    return found
