"""Where two convex solids of flat faces touch: all points share the normal of the plane that tells them apart.

As for boxes (`flexmb.surfaces.box_pairs`), for any number of faces: the normal is a face's, or at right angles to an
edge of each whose arcs on the Gauss map cross, and the one with the largest gap counts. With the normal of a face, the
face of the other solid that looks at it is cut to its outline; with two edges there is one point.

Source: Gregorius 2013, The separating axis test between convex polyhedra; Sutherland & Hodgman 1974.
"""

from __future__ import annotations

import numpy as np

from flexmb.math.kernel import inner_kernel, kernel
from flexmb.math.vectors import cross, dot
from flexmb.surfaces.edge_pairs import PARALLEL, points_of_crossing, seen_from_b
from flexmb.surfaces.edges import CORNERS, CORNERS_AT, EDGES, EDGES_AT, FACE, FACES, FACES_AT, LINE, OUTLINES_AT
from flexmb.surfaces.polygons import cut_polygon

__all__ = ["find_between_hulls", "have_faces", "plane_between_hulls"]

MOST_PAIRS = 40_000
"""Pairs of edges that are looked at; solids with more of them are round rather than flat."""
ON = 1e-9
"""Distance from an edge, relative to its length, of a corner that counts as on it."""
OF_A, OF_B, OF_EDGES = 0, 1, 2
"""Whose face gives the normal, or that edges do."""


@kernel
def have_faces(edges, at_a, at_b):
    """Are both surfaces convex solids of so few flat faces that all pairs of edges are looked at?"""
    few = edges[at_a + EDGES] * edges[at_b + EDGES] <= MOST_PAIRS
    return few and edges[at_a + FACES] > 0.0 and edges[at_b + FACES] > 0.0


@inner_kernel
def _placed(edges, first, count, d, Q):
    """Return points (count, 3) of the other body in the axes of this one."""
    out = np.empty((count, 3))
    for m in range(count):
        at = first + 3 * m
        for i in range(3):
            out[m, i] = d[i] + Q[i, 0] * edges[at] + Q[i, 1] * edges[at + 1] + Q[i, 2] * edges[at + 2]
    return out


@inner_kernel
def _lowest(points, n):
    """Return the least of n.x over points (m, 3)."""
    least = np.inf
    for m in range(len(points)):
        least = min(least, dot(n, points[m]))
    return least


@inner_kernel
def _corners(edges, at, d, Q):
    return _placed(edges, at + int(edges[at + CORNERS_AT]), int(edges[at + CORNERS]), d, Q)


@inner_kernel
def _best_face(edges, at, points, best, slack):
    """Return the largest gap, m, of a face of the solid to points of the other one, and its number; -1 if no gap is
    beyond the best one so far, by the slack.
    """
    number = -1
    first = at + int(edges[at + FACES_AT])
    for k in range(int(edges[at + FACES])):
        face = edges[first + FACE * k : first + FACE * k + 4]
        gap = _lowest(points, face) - face[3]
        if gap > best + slack:
            best, number = gap, k
    return best, number


@inner_kernel
def _edges_of_b(edges, at, Q):
    """Return directions of the edges (m, 3, 3) of b in the axes of a, and f x t for both directions t into faces."""
    count = int(edges[at + EDGES])
    out, f, t = np.empty((count, 3, 3)), np.empty(3), np.empty(3)
    for m in range(count):
        line = at + int(edges[at + EDGES_AT]) + LINE * m
        for i in range(3):
            f[i] = 0.0
            for j in range(3):
                f[i] += Q[i, j] * (edges[line + 3 + j] - edges[line + j])
        out[m, 0] = f
        for side in range(2):
            for i in range(3):
                t[i] = 0.0
                for j in range(3):
                    t[i] += Q[i, j] * edges[line + 6 + 3 * side + j]
            cross(f, t, out[m, 1 + side])
    return out


@inner_kernel
def _best_edges(edges, at_a, at_b, d, Q, best, slack, n):
    """Return the largest gap between two edges whose arcs on the Gauss map cross, and their numbers, as `_best_face`;
    write the normal.
    """
    i, j = -1, -1
    e, t, c, into = np.empty(3), np.empty(3), np.empty(3), np.empty((2, 3))
    others = _edges_of_b(edges, at_b, Q)
    first_b = at_b + int(edges[at_b + EDGES_AT])
    for k in range(int(edges[at_a + EDGES])):
        line = at_a + int(edges[at_a + EDGES_AT]) + LINE * k
        for x in range(3):
            e[x] = edges[line + 3 + x] - edges[line + x]
        for side in range(2):
            for x in range(3):
                t[x] = edges[line + 6 + 3 * side + x]
            cross(t, e, into[side])
        for m in range(len(others)):
            f = others[m, 0]
            # (e x f).t = f.(t x e) = e.(f x t): towards both faces of a, and away from both of b, or the other way
            a, b = dot(f, into[0]), dot(f, into[1])
            if a * b <= 0.0:
                continue
            p, q = dot(e, others[m, 1]), dot(e, others[m, 2])
            if p * q <= 0.0 or a * p >= 0.0:
                continue
            cross(e, f, c)
            square = dot(c, c)
            if square < PARALLEL * dot(e, e) * dot(f, f):
                continue
            size, gap = square**0.5 if a < 0.0 else -(square**0.5), 0.0
            at = first_b + LINE * m
            for x in range(3):
                place = d[x] + Q[x, 0] * edges[at] + Q[x, 1] * edges[at + 1] + Q[x, 2] * edges[at + 2]
                gap += c[x] / size * (place - edges[line + x])
            if gap > best + slack:
                best, i, j = gap, k, m
                for x in range(3):
                    n[x] = c[x] / size
    return best, i, j


@kernel
def plane_between_hulls(edges, at_a, at_b, slack, enough, d, Q, n):
    """Write the normal n (3,) from a to b of the plane between two solids; return the gap along it, m, whose normal it
    is, and the numbers of face or edges.

    The gap is at most the distance of the solids, and negative where they overlap. A normal must be better by `slack`,
    m, than those before it; faces come first. A gap of `enough`, m, ends the search.
    """
    gap, i = _best_face(edges, at_a, _corners(edges, at_b, d, Q), -np.inf, slack)
    kind, j = OF_A, -1
    face = at_a + int(edges[at_a + FACES_AT]) + FACE * i
    n[:] = edges[face : face + 3]
    if gap >= enough:
        return gap, kind, i, j
    back, turned = seen_from_b(d, Q)
    better, number = _best_face(edges, at_b, _corners(edges, at_a, back, turned), gap, slack)
    if number >= 0:
        gap, kind, i = better, OF_B, number
        face = at_b + int(edges[at_b + FACES_AT]) + FACE * i
        for x in range(3):
            n[x] = -(Q[x, 0] * edges[face] + Q[x, 1] * edges[face + 1] + Q[x, 2] * edges[face + 2])
    if gap >= enough:
        return gap, kind, i, j
    better, k, m = _best_edges(edges, at_a, at_b, d, Q, gap, slack, n)
    if k >= 0:
        gap, kind, i, j = better, OF_EDGES, k, m
    return gap, kind, i, j


@inner_kernel
def _facing(edges, at, corners, n, d, Q, slack):
    """Return the face of the other solid that looks at a plane with the normal n: of those that reach its lowest corner
    the one most opposed to n.
    """
    low, best, steepest = _lowest(corners, n), 0, np.inf
    first, outlines = at + int(edges[at + FACES_AT]), at + int(edges[at + OUTLINES_AT])
    m = np.empty(3)
    for k in range(int(edges[at + FACES])):
        face = first + FACE * k
        for i in range(3):
            m[i] = Q[i, 0] * edges[face] + Q[i, 1] * edges[face + 1] + Q[i, 2] * edges[face + 2]
        along = dot(m, n)
        if along < steepest:
            outline = _placed(edges, outlines + 3 * int(edges[face + 4]), int(edges[face + 5]), d, Q)
            if _lowest(outline, n) <= low + slack:
                best, steepest = k, along
    return best


@inner_kernel
def _cut(polygon, count, u, w, n, out):
    """Write the part of a polygon (count, 3) on the inner side of the edge from u to w of a face with the normal n to
    `out`; return its number of corners.
    """
    side, edge = np.empty(3), np.empty(3)
    for i in range(3):
        edge[i] = w[i] - u[i]
    cross(edge, n, side)
    return cut_polygon(polygon, count, side, dot(side, u), ON * dot(edge, edge), out)


@inner_kernel
def _points_over(edges, at_own, number, at_other, slack, margin, d, Q):
    """Return the corners (m, 3), in the axes of this solid, of the face of the other one that looks at a face of this
    one, cut to its outline, that are nearer than the margin.
    """
    face = at_own + int(edges[at_own + FACES_AT]) + FACE * number
    n, offset = edges[face : face + 3], edges[face + 3]
    corners = _corners(edges, at_other, d, Q)
    looking = at_other + int(edges[at_other + FACES_AT]) + FACE * _facing(edges, at_other, corners, n, d, Q, slack)
    first = at_other + int(edges[at_other + OUTLINES_AT]) + 3 * int(edges[looking + 4])
    count, sides = int(edges[looking + 5]), int(edges[face + 5])
    polygon, cut = np.empty((2 * (count + sides), 3)), np.empty((2 * (count + sides), 3))
    polygon[:count] = _placed(edges, first, count, d, Q)
    outline = at_own + int(edges[at_own + OUTLINES_AT]) + 3 * int(edges[face + 4])
    for k in range(sides):
        u, w = outline + 3 * k, outline + 3 * ((k + 1) % sides)
        count = _cut(polygon, count, edges[u : u + 3], edges[w : w + 3], n, cut)
        polygon, cut = cut, polygon
    found = 0
    for m in range(count):
        if dot(n, polygon[m]) - offset < margin:
            polygon[found] = polygon[m]
            found += 1
    return polygon[:found]


@kernel
def find_between_hulls(edges, at_a, at_b, slack, margin, d, Q, contacts):
    """Write the points at which two convex solids are nearer than the margin, m: places, normals and gaps; return how
    many, of which those that `contacts` does not hold are counted and not written.
    """
    n, p, q = np.empty(3), np.empty(3), np.empty(3)
    gap, kind, i, j = plane_between_hulls(edges, at_a, at_b, slack, margin, d, Q, n)
    if not gap < margin:
        return 0
    found, most = 0, len(contacts)
    if kind == OF_EDGES:
        line, first = at_a + int(edges[at_a + EDGES_AT]) + LINE * i, at_b + int(edges[at_b + EDGES_AT]) + LINE * j
        ends = _placed(edges, first, 2, d, Q)
        if points_of_crossing(edges[line : line + 6], ends.ravel(), p, q):
            found = 1
            contacts[0].gap = gap
            contacts[0].x[:] = q
    elif kind == OF_A:
        face = at_a + int(edges[at_a + FACES_AT]) + FACE * i
        points = _points_over(edges, at_a, i, at_b, slack, margin, d, Q)
        found = len(points)
        for m in range(min(found, most)):
            contacts[m].gap = dot(n, points[m]) - edges[face + 3]
            contacts[m].x[:] = points[m]
    else:
        back, turned = seen_from_b(d, Q)
        face = at_b + int(edges[at_b + FACES_AT]) + FACE * i
        points = _points_over(edges, at_b, i, at_a, slack, margin, back, turned)
        found = len(points)
        for m in range(min(found, most)):
            away = dot(edges[face : face + 3], points[m]) - edges[face + 3]
            contacts[m].gap = away
            for k in range(3):
                at = Q[k, 0] * points[m, 0] + Q[k, 1] * points[m, 1] + Q[k, 2] * points[m, 2]
                contacts[m].x[k] = d[k] + at + away * n[k]
    for m in range(min(found, most)):
        contacts[m].n[:] = n
        contacts[m].area = 1.0
    return found
