"""Where two solids with edges touch, by the way that fits both: boxes, convex solids of flat faces, other meshes.

Compiled on demand: balls, and bodies that touch planes alone, need nothing of it.
"""

from __future__ import annotations

import numpy as np

from flexmb.math.kernel import inner_kernel
from flexmb.math.kernel_on_demand import kernel_on_demand
from flexmb.math.structures import array_type
from flexmb.math.tables import COUNT, FLOATS, NUMBER
from flexmb.math.vectors import dot
from flexmb.surfaces.box_pairs import are_boxes, find_between_boxes, plane_between_boxes
from flexmb.surfaces.edge_pairs import find_corners, find_crossings
from flexmb.surfaces.hull_pairs import find_between_hulls, have_faces, plane_between_hulls
from flexmb.surfaces.parallel_edges import find_along_edges
from flexmb.surfaces.records import CONTACT, THICKNESS

__all__ = ["found_between_solids", "gap_of_solids"]

SAME, ALIKE = 1e-5, 1e-6
"""Distance, relative to the thinner body, between places that are one, and 1 - cosine of normals that are."""
BETTER = 1e-6
"""By how much, relative to the thinner body, an edge must be farther than a face to give the normal of convex ones."""

PLACES = (array_type(FLOATS), COUNT, COUNT)
OF_SOLIDS = (*PLACES, *PLACES, NUMBER, array_type(FLOATS), array_type(FLOATS, 2), array_type(CONTACT))
"""Arguments of both kernels: bulk data and edges with two places each, a gap, d and Q of b, contacts."""


@inner_kernel
def _slack(data, at_a, at_b):
    return BETTER * min(data[at_a + THICKNESS], data[at_b + THICKNESS])


@inner_kernel
def _once(contacts, count, near):
    """Keep one contact, that with the least gap, of those at one place (within `near`, m) with one normal: a corner on
    a corner, or on an edge, is found by both. Return how many are left.
    """
    kept = 0
    for c in range(count):
        one, same = contacts[c], -1
        for k in range(kept):
            other = contacts[k]
            if dot(one.n, other.n) > 1.0 - ALIKE and abs(one.gap - other.gap) <= near:
                far = 0.0
                for i in range(3):
                    far = max(far, abs(one.x[i] - other.x[i]))
                if far <= near:
                    same = k
                    break
        if same < 0:
            contacts[kept] = one
            kept += 1
        elif one.gap < contacts[same].gap:
            contacts[same] = one
    return kept


@inner_kernel
def _found_between(data, at_a, at_b, edges, own, other, margin, d, Q, contacts):
    """Write the contacts of corners, edges and faces, some of them twice; return how many, as
    `found_between_solids`."""
    slack, boxes = _slack(data, at_a, at_b), are_boxes(data, at_a, at_b)
    if boxes or have_faces(edges, own, other):
        if boxes:
            count = find_between_boxes(data, at_a, at_b, margin, d, Q, contacts)
        else:
            count = find_between_hulls(edges, own, other, slack, margin, d, Q, contacts)
        if count == 0 or count > len(contacts):
            return count
        best, n = np.inf, np.empty(3)
        n[:] = contacts[0].n
        for c in range(count):
            best = min(best, contacts[c].gap)
        along = find_along_edges(edges, own, other, best, slack, n, d, Q, contacts)
        return along if along > 0 else count
    count = find_corners(edges, own, other, data, at_a, at_b, margin, d, Q, contacts)
    return find_crossings(edges, own, other, data, at_a, at_b, margin, False, d, Q, contacts, count)


@kernel_on_demand(COUNT, *OF_SOLIDS)
def found_between_solids(data, at_a, at_b, edges, own, other, margin, d, Q, contacts):
    """Write the contacts of two solids with a gap below the margin, m; return how many, those for which there is no
    room included.

    `at_a` and `at_b` are the places of the surfaces in the bulk data, `own` and `other` among the edges; d (3,) and
    Q (3, 3) place and axes of b in the axes of a.
    """
    count = _found_between(data, at_a, at_b, edges, own, other, margin, d, Q, contacts)
    if count > len(contacts):
        return count
    return _once(contacts, count, SAME * min(data[at_a + THICKNESS], data[at_b + THICKNESS]))


@kernel_on_demand(NUMBER, *OF_SOLIDS, array_type(FLOATS))
def gap_of_solids(data, at_a, at_b, edges, own, other, enough, d, Q, contacts, n):
    """Return the gap of two solids, m, but none below zero, and none above `enough` (m) that is looked for; write its
    normal (3,). Arguments as those of `found_between_solids`.
    """
    if are_boxes(data, at_a, at_b):
        return max(plane_between_boxes(data, at_a, at_b, d, Q, n)[0], 0.0)
    if have_faces(edges, own, other):
        slack = _slack(data, at_a, at_b)
        return max(plane_between_hulls(edges, own, other, slack, np.inf, d, Q, n)[0], 0.0)
    least = enough
    count = find_corners(edges, own, other, data, at_a, at_b, enough, d, Q, contacts)
    for c in range(count):
        if contacts[c].gap < least:
            least = contacts[c].gap
            n[:] = contacts[c].n
    if find_crossings(edges, own, other, data, at_a, at_b, least, True, d, Q, contacts, 0) > 0:
        least = contacts[0].gap
        n[:] = contacts[0].n
    return max(least, 0.0)
