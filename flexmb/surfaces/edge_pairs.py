"""Where edges of two surfaces cross, and their corners: points at which solids meet that have no plane between them.

Two edges that cross part the bodies by a plane along both. Its normal, at right angles to both, must lead out of each
body: into none of the two faces at its edge. Between the points of the edges that are nearest to each other stands the
gap, which is below zero where the edges have passed each other. Ends of edges are corners, which are looked at by
their distance from the other solid.

Source: Ericson, Real-Time Collision Detection, sections 5.1.9 (two segments) and 6.3 (descent of two trees); the
condition on the normal is that the arcs of both edges on the Gauss map cross (Gregorius 2013, The separating axis test
between convex polyhedra).
"""

from __future__ import annotations

import numpy as np

from flexmb.math.kernel import inner_kernel, kernel
from flexmb.math.vectors import cross, dot, matvec, matvec_t
from flexmb.surfaces.distances import signed_distance
from flexmb.surfaces.edges import CORNERS, CORNERS_AT, EDGES, EDGES_AT, LINE, NODES_AT, ROUND, WAYS_AT
from flexmb.surfaces.records import THICKNESS
from flexmb.surfaces.trees import DEPTH, NODE

__all__ = [
    "PARALLEL",
    "find_corners",
    "find_crossings",
    "have_edges",
    "place_edge",
    "points_of_crossing",
    "seen_from_b",
]

PARALLEL = 1e-4
"""Square of the sine between edges up to which they do not cross."""
LEANS = 1e-3
"""Sine by which the normal may lead into a face: of bodies that lie on each other it is in the plane of a face."""
ON = 1e-9
"""Distance, relative to the thinner body, of a place that counts as on a surface."""
BEYOND = 10.0
"""How far beyond an end, relative to the depth, edges may cross: those that end in a groove of their solid go on in it
where the other one has sunk a little below its bottom, by the depth times the tangent of the slope."""
DEEPEST = 0.5
"""Depth, in thicknesses of the thinner body, beyond which two edges are on far sides and have not passed each other."""


@kernel
def seen_from_b(d, Q):
    """Return the place and the axes of a in the axes of b."""
    back, turned = np.empty(3), np.empty((3, 3))
    for i in range(3):
        back[i] = -(Q[0, i] * d[0] + Q[1, i] * d[1] + Q[2, i] * d[2])
        for j in range(3):
            turned[i, j] = Q[j, i]
    return back, turned


@kernel
def have_edges(edges, at_a, at_b):
    """Have both surfaces edges that may cross?"""
    return edges[at_a + EDGES] > 0.0 and edges[at_b + EDGES] > 0.0


@kernel
def points_of_crossing(first, second, p, q):
    """Write the points (3,) of two lines that are nearest to each other; return if both lie between their ends.

    `first` and `second` begin with the ends, 3 numbers each, of lines that are not parallel.
    """
    ee, ef, ff, er, fr = 0.0, 0.0, 0.0, 0.0, 0.0
    for i in range(3):
        e, f, r = first[3 + i] - first[i], second[3 + i] - second[i], second[i] - first[i]
        ee += e * e
        ef += e * f
        ff += f * f
        er += e * r
        fr += f * r
    size = ee * ff - ef * ef
    s, t = (ff * er - ef * fr) / size, (ef * er - ee * fr) / size
    for i in range(3):
        p[i] = first[i] + s * (first[3 + i] - first[i])
        q[i] = second[i] + t * (second[3 + i] - second[i])
    return 0.0 <= s <= 1.0 and 0.0 <= t <= 1.0


@inner_kernel
def _along(line, at, n):
    return line[at] * n[0] + line[at + 1] * n[1] + line[at + 2] * n[2]


@inner_kernel
def _normal_of_crossing(first, second, n):
    """Write the unit normal (3,) of two edges that cross, out of the first body; return if it leads out of both."""
    e, f = np.empty(3), np.empty(3)
    out = 0.0
    for i in range(3):
        e[i], f[i] = first[3 + i] - first[i], second[3 + i] - second[i]
    cross(e, f, n)
    square = dot(n, n)
    if not square > PARALLEL * dot(e, e) * dot(f, f):
        return False
    for i in range(3):
        out += n[i] * (second[6 + i] + second[9 + i] - first[6 + i] - first[9 + i])
    if out == 0.0:  # lines of two capsules lead into nothing
        for i in range(3):
            out += n[i] * (second[i] - first[i])
    size = square**0.5 if out > 0.0 else -(square**0.5)
    for i in range(3):
        n[i] /= size
    return max(_along(first, 6, n), _along(first, 9, n), -_along(second, 6, n), -_along(second, 9, n)) <= LEANS


@inner_kernel
def _beyond(line, p):
    """Return how far, m, a point of an edge is beyond its ends."""
    ee, ep = 0.0, 0.0
    for i in range(3):
        e = line[3 + i] - line[i]
        ee += e * e
        ep += e * (p[i] - line[i])
    return max(0.0, -ep, ep - ee) / ee**0.5


@inner_kernel
def _write_crossing(first, second, radius_a, radius_b, margin, contact):
    """Write place, normal and gap of two edges (12,) that cross; return 0 if the gap is not below the margin, else 1,
    or 2 or 3 if they do so beyond an end of the first or the second, which must then go on within its solid.
    """
    p, q, n = np.empty(3), np.empty(3), np.empty(3)
    if not _normal_of_crossing(first, second, n):
        return 0
    gap, how = -radius_a - radius_b, 1
    for i in range(3):
        gap += n[i] * (second[i] - first[i])
    if not gap < margin:
        return 0
    if not points_of_crossing(first, second, p, q):
        of_a, of_b, most = _beyond(first, p), _beyond(second, q), -BEYOND * gap
        if radius_a + radius_b > 0.0 or min(of_a, of_b) > 0.0 or max(of_a, of_b) > most:
            return 0
        how = 2 if of_a > 0.0 else 3
    contact.gap, contact.area = gap, 1.0
    for i in range(3):
        contact.n[i] = n[i]
        contact.x[i] = q[i] - radius_b * n[i]
    return how


@inner_kernel
def _move_into_wedge(own, other, p, q):
    """Move q, on the other edge, along it to where it cuts the wedge of faces at the own edge, on which p is: at sharp
    ones that may be beside the nearest point. Return if it is between the ends of the other edge.
    """
    e, f, m, along = np.empty(3), np.empty(3), np.empty(3), 0.0
    for i in range(3):
        e[i], f[i] = own[3 + i] - own[i], other[3 + i] - other[i]
    for side in range(2):
        cross(e, own[6 + 3 * side : 9 + 3 * side], m)
        above, rate = 0.0, dot(m, f)
        for i in range(3):
            above += m[i] * (q[i] - p[i])
        if side == 1:
            above, rate = -above, -rate
        if above > 0.0 and rate != 0.0:
            along = -above / rate
    ff, at = 0.0, 0.0
    for i in range(3):
        at += f[i] * (q[i] - other[i])
        ff += f[i] * f[i]
        q[i] += along * f[i]
    return along == 0.0 or 0.0 <= at / ff + along <= 1.0


@inner_kernel
def _pass_each_other(data, at_a, at_b, first, second, d, Q, contact, how):
    """Does each of two edges with a gap below zero lie within the other body? They may be on far sides instead. One
    that crosses beyond its end lies within its own.
    """
    thickness = min(data[at_a + THICKNESS], data[at_b + THICKNESS])
    if contact.gap < -DEEPEST * thickness:
        return False
    near = ON * thickness
    p, q, z, n, H = np.empty(3), np.empty(3), np.empty(3), np.empty(3), np.empty((3, 3))
    own, other = np.empty(3), np.empty(3)
    for i in range(3):
        q[i] = other[i] = contact.x[i]
        p[i] = own[i] = q[i] - contact.gap * contact.n[i]
    if how != 3:
        between = _move_into_wedge(first, second, p, other)
        if not between or signed_distance(data, at_a, other, np.inf, n, H) > near:
            return False
    if how == 2:
        return signed_distance(data, at_a, p, np.inf, n, H) <= near
    if not _move_into_wedge(second, first, q, own):
        return False
    for i in range(3):
        own[i] -= d[i]
        q[i] -= d[i]
    matvec_t(Q, own, z)
    if signed_distance(data, at_b, z, np.inf, n, H) > near:
        return False
    if how == 1:
        return True
    matvec_t(Q, q, z)
    return signed_distance(data, at_b, z, np.inf, n, H) <= near


@kernel
def place_edge(edges, at, d, Q, out):
    """Write an edge of b in the axes of a to `out` (12,)."""
    for k in range(0, LINE, 3):
        for i in range(3):
            x = Q[i, 0] * edges[at + k] + Q[i, 1] * edges[at + k + 1] + Q[i, 2] * edges[at + k + 2]
            out[k + i] = x + d[i] if k < 6 else x


@inner_kernel
def _corner_of_b(edges, box, other, m, data, at_a, d, Q, margin, wide, contact):
    """Write the contact of a corner of b with a; return if its gap is below the margin.

    Its distance is that of a place a little behind, along the normal there: on the rim of a face it rests on that face.
    `box` is the place of the box around the edges of a, `wide` (m) the way from it beyond which nothing is looked for.
    """
    corner, way = other + int(edges[other + CORNERS_AT]) + 3 * m, other + int(edges[other + WAYS_AT]) + 3 * m
    z, back, n, H = np.empty(3), np.empty(3), np.empty(3), np.empty((3, 3))
    matvec(Q, edges[corner : corner + 3], z)
    matvec(Q, edges[way : way + 3], back)
    for i in range(3):
        z[i] += d[i] + back[i]
        if max(edges[box + i] - z[i], z[i] - edges[box + 3 + i]) >= wide:
            return False
    gap = signed_distance(data, at_a, z, np.inf, n, H) - dot(n, back) - edges[other + ROUND]
    if not gap < margin:
        return False
    contact.gap, contact.area = gap, 1.0
    for i in range(3):
        contact.n[i] = n[i]
        contact.x[i] = z[i] - back[i] - edges[other + ROUND] * n[i]
    return True


@kernel
def find_corners(edges, own, other, data, at_a, at_b, margin, d, Q, contacts):
    """Write contacts of the corners of both surfaces with a gap below the margin, m; return how many. Those for which
    there is no room are counted, not written. Arguments as those of `find_crossings`.
    """
    found, last = 0, len(contacts) - 1
    wide = margin + edges[own + ROUND] + edges[other + ROUND]
    box_a, box_b = own + int(edges[own + NODES_AT]), other + int(edges[other + NODES_AT])
    for m in range(int(edges[other + CORNERS])):
        if _corner_of_b(edges, box_a, other, m, data, at_a, d, Q, margin, wide, contacts[min(found, last)]):
            found += 1
    back, turned = seen_from_b(d, Q)
    at, n = np.empty(3), np.empty(3)
    for m in range(int(edges[own + CORNERS])):
        contact = contacts[min(found, last)]
        if not _corner_of_b(edges, box_b, own, m, data, at_b, back, turned, margin, wide, contact):
            continue
        found += 1
        matvec(Q, contact.n, n)
        matvec(Q, contact.x, at)
        for i in range(3):  # from the other side: the place on b is beyond the gap
            contact.x[i] = d[i] + at[i] - contact.gap * n[i]
            contact.n[i] = -n[i]
    return found


@inner_kernel
def _boxes_apart(edges, own, other, d, Q):
    """Return a lower bound, m, of the distance between the boxes of two nodes, along the axes of a."""
    middle, z = np.empty(3), np.empty(3)
    for i in range(3):
        middle[i] = 0.5 * (edges[other + i] + edges[other + 3 + i])
    matvec(Q, middle, z)
    apart = -np.inf
    for i in range(3):
        half = 0.0
        for j in range(3):
            half += abs(Q[i, j]) * 0.5 * (edges[other + 3 + j] - edges[other + j])
        at = z[i] + d[i]
        apart = max(apart, edges[own + i] - at - half, at - half - edges[own + 3 + i])
    return apart


@inner_kernel
def _longest(edges, node):
    return max(edges[node + 3] - edges[node], edges[node + 4] - edges[node + 1], edges[node + 5] - edges[node + 2])


@inner_kernel
def _children(edges, nodes, k):
    """Return the numbers of both children of a node."""
    return k + 1, int(edges[nodes + NODE * (k + 1) + 6])


@kernel
def find_crossings(edges, own, other, data, at_a, at_b, margin, nearest, d, Q, contacts, found):
    """Write contacts where edges cross with a gap below the margin, m, after the `found` ones; return how many there
    are then: more than `contacts` has are counted, not written. With `nearest` only the one with the least gap.

    `own` and `other` are the places of the surfaces among the edges, `at_a` and `at_b` in the bulk data.
    """
    radius_a, radius_b = edges[own + ROUND], edges[other + ROUND]
    nodes_a, nodes_b = own + int(edges[own + NODES_AT]), other + int(edges[other + NODES_AT])
    lines_a, lines_b = own + int(edges[own + EDGES_AT]), other + int(edges[other + EDGES_AT])
    begun, at = found, np.empty(LINE)
    stack = np.zeros((2 * DEPTH, 2), np.int64)
    top = 1
    while top > 0:
        top -= 1
        i, j = stack[top, 0], stack[top, 1]
        a, b = nodes_a + NODE * i, nodes_b + NODE * j
        if _boxes_apart(edges, a, b, d, Q) - radius_a - radius_b >= margin:
            continue
        code_a, code_b = int(edges[a + 7]), int(edges[b + 7])
        if code_a == 0 or code_b == 0:
            # the larger one is divided
            if code_b > 0 or (code_a == 0 and _longest(edges, a) >= _longest(edges, b)):
                for child in _children(edges, nodes_a, i):
                    stack[top, 0], stack[top, 1] = child, j
                    top += 1
            else:
                for child in _children(edges, nodes_b, j):
                    stack[top, 0], stack[top, 1] = i, child
                    top += 1
            continue
        for m in range(code_b // 16, code_b // 16 + code_b % 16):
            place_edge(edges, lines_b + LINE * m, d, Q, at)
            for k in range(code_a // 16, code_a // 16 + code_a % 16):
                line = lines_a + LINE * k
                to = begun if nearest else min(found, len(contacts) - 1)
                contact = contacts[-1] if nearest else contacts[to]
                first = edges[line : line + LINE]
                how = _write_crossing(first, at, radius_a, radius_b, margin, contact)
                if how == 0:
                    continue
                # one for which there is no room is in the place of the last that was found: it counts unseen
                seen = nearest or found < len(contacts)
                if seen and contact.gap < 0.0 and not _pass_each_other(data, at_a, at_b, first, at, d, Q, contact, how):
                    continue
                if nearest:
                    margin = contact.gap
                    contacts[begun] = contact
                    found = begun + 1
                else:
                    found += 1
    return found
