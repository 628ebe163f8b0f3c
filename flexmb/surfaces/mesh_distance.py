"""Signed distance from a closed mesh of triangles: the nearest triangle by a tree, the sign by mean normals.

A mesh in the bulk data: number of triangles and of nodes, place of the triangles and of the nodes (from here), then
the triangles, `TRIANGLE` numbers each (corners a, b, c; normals of the face, of the edges ab, bc, ca and of the
corners), and the nodes of the tree.

Source: Ericson, Real-Time Collision Detection, section 5.1.5 (nearest point of a triangle); Baerentzen & Aanaes 2005
(the mean normal of an edge or a corner, weighted by angles, tells the side of a point whose nearest point lies there).
"""

from __future__ import annotations

import numpy as np

from flexmb.math.kernel import inner_kernel, kernel
from flexmb.math.vectors import dot
from flexmb.surfaces.trees import DEPTH, NODE

__all__ = ["TRIANGLE", "mesh_distance", "nearest_on_triangle"]

TRIANGLE = 30
TOUCHING = 1e-12
"""Distance, relative to the size of the triangle, below which the mesh gives the normal."""


@kernel
def nearest_on_triangle(data, t, z, p):
    """Write the nearest point of the triangle at t; return 0 on the face, 1 to 3 on ab, bc, ca, 4 to 6 at a, b, c."""
    d1, d2, d3, d4, d5, d6 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for i in range(3):
        a, b, c = data[t + i], data[t + 3 + i], data[t + 6 + i]
        ab, ac = b - a, c - a
        d1 += ab * (z[i] - a)
        d2 += ac * (z[i] - a)
        d3 += ab * (z[i] - b)
        d4 += ac * (z[i] - b)
        d5 += ab * (z[i] - c)
        d6 += ac * (z[i] - c)
    where, v, w = 0, 0.0, 0.0
    va, vb, vc = d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2
    if d1 <= 0.0 and d2 <= 0.0:
        where = 4
    elif d3 >= 0.0 and d4 <= d3:
        where, v = 5, 1.0
    elif vc <= 0.0 and d1 >= 0.0 and d3 <= 0.0:
        where, v = 1, d1 / (d1 - d3)
    elif d6 >= 0.0 and d5 <= d6:
        where, w = 6, 1.0
    elif vb <= 0.0 and d2 >= 0.0 and d6 <= 0.0:
        where, w = 3, d2 / (d2 - d6)
    elif va <= 0.0 and d4 - d3 >= 0.0 and d5 - d6 >= 0.0:
        w = (d4 - d3) / ((d4 - d3) + (d5 - d6))
        where, v = 2, 1.0 - w
    else:
        v, w = vb / (va + vb + vc), vc / (va + vb + vc)
    for i in range(3):
        a = data[t + i]
        p[i] = a + v * (data[t + 3 + i] - a) + w * (data[t + 6 + i] - a)
    return where


@inner_kernel
def _to_box(data, node, z):
    """Return the square of the distance of a point from the box of the node at `node`."""
    square = 0.0
    for i in range(3):
        beyond = max(data[node + i] - z[i], z[i] - data[node + 3 + i], 0.0)
        square += beyond * beyond
    return square


@inner_kernel
def _search(data, at, z, within, best):
    """Return the triangle nearest to z, -1 if none is nearer than `within`; write the nearest point to `best`."""
    triangles, nodes = at + int(data[at + 2]), at + int(data[at + 3])
    stack = np.empty(DEPTH, np.int64)
    bounds = np.empty(DEPTH)
    p = np.empty(3)
    least, found = within * within, -1
    stack[0], bounds[0], top = 0, 0.0, 1
    while top > 0:
        top -= 1
        if bounds[top] > least:
            continue
        k = stack[top]
        code = int(data[nodes + NODE * k + 7])
        if code > 0:
            for m in range(code // 16, code // 16 + code % 16):
                nearest_on_triangle(data, triangles + TRIANGLE * m, z, p)
                square = (z[0] - p[0]) ** 2 + (z[1] - p[1]) ** 2 + (z[2] - p[2]) ** 2
                if square < least or (found < 0 and square <= least):
                    least, found = square, m
                    best[0], best[1], best[2] = p[0], p[1], p[2]
            continue
        left = k + 1
        right = int(data[nodes + NODE * left + 6])
        first = _to_box(data, nodes + NODE * left, z)
        second = _to_box(data, nodes + NODE * right, z)
        if first > second:
            left, right, first, second = right, left, second, first
        if second <= least:
            stack[top], bounds[top] = right, second
            top += 1
        if first <= least:
            stack[top], bounds[top] = left, first
            top += 1
    return found


@kernel
def mesh_distance(data, at, z, within, n, H):
    """Return the signed distance of z (3,) from the mesh at `at`, with gradient and second derivative.

    `within` is an upper bound of its absolute value, m, infinite if unknown.
    """
    p = np.empty(3)
    m = _search(data, at, z, within * (1.0 + 1e-9), p)
    if m < 0:
        m = _search(data, at, z, np.inf, p)
    first = at + int(data[at + 2]) + TRIANGLE * m
    tri = data[first : first + TRIANGLE]
    where = nearest_on_triangle(data, first, z, p)
    mean = tri[9 + 3 * where : 12 + 3 * where]
    H[:] = 0.0
    side, square, size = 0.0, 0.0, 0.0
    for i in range(3):
        x = z[i] - p[i]
        side += x * mean[i]
        square += x * x
        size = max(size, abs(tri[3 + i] - tri[i]), abs(tri[6 + i] - tri[i]))
        n[i] = x
    gap = square**0.5 if side >= 0.0 else -(square**0.5)
    if where == 0:
        for i in range(3):
            n[i] = mean[i]
        return side
    if abs(gap) <= TOUCHING * size:
        for i in range(3):
            n[i] = mean[i]
        return gap
    for i in range(3):
        n[i] /= gap
    e = np.zeros(3)
    if where <= 3:
        a, b = 3 * (where - 1), 3 * (where % 3)
        for i in range(3):
            e[i] = tri[b + i] - tri[a + i]
        length = dot(e, e) ** 0.5
        for i in range(3):
            e[i] /= length
    for i in range(3):
        for j in range(3):
            H[i, j] = ((1.0 if i == j else 0.0) - n[i] * n[j] - e[i] * e[j]) / gap
    return gap
