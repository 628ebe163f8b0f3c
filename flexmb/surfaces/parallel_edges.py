"""Edge along edge: cards that lean on each other, a blade on a blade.

Where two edges are parallel and touch, every normal between those of both is as good as the others. A face of convex
solids would give one that tips to a side; the middle one is taken instead, at both ends of what they have in common.
"""

from __future__ import annotations

import numpy as np

from flexmb.math.kernel import inner_kernel, kernel
from flexmb.math.vectors import cross, dot, matvec_t
from flexmb.surfaces.edge_pairs import PARALLEL, place_edge
from flexmb.surfaces.edges import EDGES, EDGES_AT, LINE

__all__ = ["find_along_edges"]

BETWEEN = 1e-2
"""Sine by which the normal must stay out of all four faces: solids that lie on each other have only one."""
ALIKE = 0.5
"""Difference of the gap along the middle normal from the largest one, relative to it: wedges of 120 degrees."""


@inner_kernel
def _middle_normal(a, b, n):
    """Write the unit normal (3,) in the middle of those of two edges (12,); return if they are parallel and it leads
    out of both bodies.
    """
    e, f = np.empty(3), np.empty(3)
    for i in range(3):
        e[i], f[i] = a[3 + i] - a[i], b[3 + i] - b[i]
    cross(e, f, n)
    if dot(n, n) > PARALLEL * dot(e, e) * dot(f, f):
        return False
    own, other, along = 0.0, 0.0, 0.0
    for i in range(3):
        own += (a[6 + i] + a[9 + i]) ** 2
        other += (b[6 + i] + b[9 + i]) ** 2
    for i in range(3):
        n[i] = (b[6 + i] + b[9 + i]) / other**0.5 - (a[6 + i] + a[9 + i]) / own**0.5
        along += n[i] * e[i]
    for i in range(3):
        n[i] -= along / dot(e, e) * e[i]
    size = dot(n, n) ** 0.5
    for i in range(3):
        n[i] /= size
    return max(dot(n, a[6:9]), dot(n, a[9:12]), -dot(n, b[6:9]), -dot(n, b[9:12])) < -BETWEEN


@inner_kernel
def _in_common(a, b, parts):
    """Write where b begins and ends along a, and what they have in common, as parts of a, to `parts` (4,); return if it
    is anything.
    """
    ee, begin, end = 0.0, 0.0, 0.0
    for i in range(3):
        e = a[3 + i] - a[i]
        ee += e * e
        begin += e * (b[i] - a[i])
        end += e * (b[3 + i] - a[i])
    parts[0], parts[1] = begin / ee, end / ee
    parts[2], parts[3] = max(0.0, min(parts[0], parts[1])), min(1.0, max(parts[0], parts[1]))
    return parts[3] > parts[2]


@inner_kernel
def _write_ends(a, b, n, parts, contacts):
    """Write the contacts at both ends of what two edges have in common."""
    for k in range(2):
        s = parts[2 + k]
        t = (s - parts[0]) / (parts[1] - parts[0])
        contact, gap = contacts[k], 0.0
        for i in range(3):
            x = b[i] + t * (b[3 + i] - b[i])
            gap += n[i] * (x - a[i] - s * (a[3 + i] - a[i]))
            contact.x[i], contact.n[i] = x, n[i]
        contact.gap, contact.area = gap, 1.0


@inner_kernel
def _outermost(edges, at, n, sign, within, chosen):
    """Write the numbers of the edges whose ends both are the outermost along n, up to `within`, m; return how many."""
    count, first = int(edges[at + EDGES]), at + int(edges[at + EDGES_AT])
    far, found = -np.inf, 0
    for turn in range(2):
        for m in range(count):
            line = first + LINE * m
            p, q = sign * dot(n, edges[line : line + 3]), sign * dot(n, edges[line + 3 : line + 6])
            if turn == 0:
                far = max(far, p, q)
            elif min(p, q) >= far - within:
                chosen[found] = m
                found += 1
    return found


@kernel
def find_along_edges(edges, own, other, best, slack, normal, d, Q, contacts):
    """Write the two contacts of edges that lie along each other, if such are as near as two convex solids are along
    their best `normal` (3,): by the gap `best`, m, up to `slack`. Return 2, or 0 if there are none.
    """
    b, n, parts = np.empty(LINE), np.empty(3), np.empty(4)
    matvec_t(Q, normal, n)
    within = 2.0 * (slack + abs(best))
    above = np.empty(int(edges[own + EDGES]), np.int64)
    below = np.empty(int(edges[other + EDGES]), np.int64)
    count_a = _outermost(edges, own, normal, 1.0, within, above)
    count_b = _outermost(edges, other, n, -1.0, within, below)
    first_a, first_b = own + int(edges[own + EDGES_AT]), other + int(edges[other + EDGES_AT])
    found, least = 0, slack + ALIKE * abs(best)
    for m in range(count_b):
        place_edge(edges, first_b + LINE * below[m], d, Q, b)
        for k in range(count_a):
            line = first_a + LINE * above[k]
            a = edges[line : line + LINE]
            if not _middle_normal(a, b, n) or not _in_common(a, b, parts):
                continue
            gap = 0.0
            for i in range(3):
                gap += n[i] * (b[i] - a[i])
            if abs(gap - best) <= least:
                least, found = abs(gap - best), 2
                _write_ends(a, b, n, parts, contacts)
    return found
