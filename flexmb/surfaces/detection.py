"""Where two surfaces touch: points of one against the signed distance from the other.

A point fixed to b at y lies at z = d + Q y in the axes of a. With the distance g(z) from a, n = grad g and H its second
derivative, n changes by H dz, dz = dd + dpsi x (z - d). A point fixed to a at y lies at z = Q^T (y - d) in the axes of
b; there the distance from b decreases along the normal towards b, n = -Q grad g.
"""

from __future__ import annotations

import numpy as np

from flexmb.math.kernel import inner_kernel, kernel
from flexmb.math.vectors import cross, dot, matvec, matvec_t
from flexmb.surfaces.distances import signed_distance
from flexmb.surfaces.records import (
    CODE,
    CONVEX,
    CORNERS,
    CORNERS_AT,
    FAR,
    PATCH,
    REACH,
    ROUNDED,
    SAMPLES,
    SAMPLES_AT,
    TREE_AT,
)
from flexmb.surfaces.trees import DEPTH, SLAB

__all__ = ["bound_gap", "faced", "find_areas", "find_closest", "find_points", "nearest_sample"]

FACING = 0.5
"""Cosine of the angle between opposed normals up to which a sample counts with its full area; behind, it fades out."""


@kernel
def bound_gap(data, at_a, at_b, d, Q):
    """Return a lower bound of the gap of two surfaces, m, from the balls that hold them."""
    a, b = data[at_a + REACH], data[at_b + REACH]
    if a < FAR and b < FAR:
        return dot(d, d) ** 0.5 - a - b
    if a < FAR:  # the marker of a above the plane of b
        return -(Q[0, 2] * d[0] + Q[1, 2] * d[1] + Q[2, 2] * d[2]) - a
    return d[2] - b if b < FAR else -np.inf


@inner_kernel
def _point_of_b(data, at_a, y, radius, d, Q, within, margin, contact):
    """Write the contact of a point of b, rounded by `radius`, with a; return if the gap is below the margin."""
    z = np.empty(3)
    n = np.empty(3)
    H = np.empty((3, 3))
    matvec(Q, y, z)
    for i in range(3):
        z[i] += d[i]
    gap = signed_distance(data, at_a, z, within, n, H) - radius
    if not gap < margin:
        return False
    contact.gap, contact.area = gap, 1.0
    _columns(H, z, d, 1.0, contact.N)
    contact.A[:] = 0.0
    for i in range(3):
        contact.n[i] = n[i]
        contact.x[i] = z[i] - radius * n[i]
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        for m in range(6):
            contact.X[i, m] = (1.0 if m == i else 0.0) - radius * contact.N[i, m]
        contact.X[i, 3 + j] += z[k] - d[k]
        contact.X[i, 3 + k] -= z[j] - d[j]
    return True


@inner_kernel
def _columns(H, z, d, sign, out):
    """Write sign H (dd + dpsi x (z - d)) to `out` (3, 6)."""
    for i in range(3):
        for j in range(3):
            k, m = (j + 1) % 3, (j + 2) % 3
            out[i, j] = sign * H[i, j]
            # e_j x r has the component r_k at m and -r_m at k
            out[i, 3 + j] = sign * (H[i, m] * (z[k] - d[k]) - H[i, k] * (z[m] - d[m]))


@inner_kernel
def _point_of_a(data, at_b, y, radius, d, Q, within, margin, contact):
    """Write the contact of a point of a, rounded by `radius`, with b; return if the gap is below the margin."""
    t = np.empty(3)
    z = np.empty(3)
    n = np.empty(3)
    own = np.empty((3, 3))
    for i in range(3):
        t[i] = y[i] - d[i]
    matvec_t(Q, t, z)
    gap = signed_distance(data, at_b, z, within, n, own) - radius
    if not gap < margin:
        return False
    contact.gap, contact.area = gap, 1.0
    contact.A[:] = 0.0
    matvec(Q, n, t)
    H = np.zeros((3, 3))
    for i in range(3):
        contact.n[i] = -t[i]
        contact.x[i] = y[i] - (gap + radius) * t[i]
        for j in range(3):
            for k in range(3):
                for m in range(3):
                    H[i, j] += Q[i, k] * own[k, m] * Q[j, m]
    _columns(H, y, d, 1.0, contact.N)
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        contact.N[i, 3 + k] -= contact.n[j]
        contact.N[i, 3 + j] += contact.n[k]
    lever = np.empty(3)
    for i in range(3):
        t[i] = contact.x[i] - d[i]
    cross(t, contact.n, lever)
    for i in range(3):
        for j in range(3):
            contact.X[i, j] = contact.n[i] * contact.n[j] + (gap + radius) * contact.N[i, j]
            contact.X[i, 3 + j] = contact.n[i] * lever[j] + (gap + radius) * contact.N[i, 3 + j]
    return True


@kernel
def faced(cosine):
    """Return how much of its area a sample counts, and the derivative by the cosine between the opposed normals."""
    s = cosine / FACING
    if s <= 0.0:
        return 0.0, 0.0
    if s >= 1.0:
        return 1.0, 0.0
    return s * s * (3.0 - 2.0 * s), 6.0 * s * (1.0 - s) / FACING


@inner_kernel
def _weigh_b(contact, area, normal, Q):
    """Give a sample of b its area, by how it faces a; return if any of it counts."""
    m = np.empty(3)
    matvec(Q, normal, m)
    share, slope = faced(-dot(m, contact.n))
    contact.area = area * share
    turn = np.empty(3)
    cross(m, contact.n, turn)
    for j in range(6):
        change = 0.0
        for i in range(3):
            change -= m[i] * contact.N[i, j]
        contact.A[j] = area * slope * (change - (turn[j - 3] if j >= 3 else 0.0))
    return share > 0.0


@inner_kernel
def _weigh_a(contact, area, normal):
    """Give a sample of a its area, by how it faces b; return if any of it counts."""
    share, slope = faced(dot(normal, contact.n))
    contact.area = area * share
    for j in range(6):
        change = 0.0
        for i in range(3):
            change += normal[i] * contact.N[i, j]
        contact.A[j] = area * slope * change
    return share > 0.0


@inner_kernel
def _to_other(y, d, Q, forward, z):
    """Write a point of b in the axes of a to z, or (not `forward`) a point of a in the axes of b."""
    if forward:
        matvec(Q, y, z)
        for i in range(3):
            z[i] += d[i]
        return
    t = np.empty(3)
    for i in range(3):
        t[i] = y[i] - d[i]
    matvec_t(Q, t, z)


@inner_kernel
def _push(stack, bounds, top, node, bound):
    stack[top], bounds[top] = node, bound
    return top + 1


@inner_kernel
def _along(data, first, second, e):
    """Return how far along e (3,) a first place in the data lies beyond a second."""
    return (
        e[0] * (data[first] - data[second])
        + e[1] * (data[first + 1] - data[second + 1])
        + e[2] * (data[first + 2] - data[second + 2])
    )


@inner_kernel
def _depth(data, node, e):
    """Return how far the samples of a node reach from their middle against a direction e (3,)."""
    along = e[0] * data[node + 4] + e[1] * data[node + 5] + e[2] * data[node + 6]
    return data[node + 7] * abs(along) + data[node + 3] * max(1.0 - along * along, 0.0) ** 0.5


@inner_kernel
def _samples(data, at, other, d, Q, of_b, share, margin, found, nearest, contacts):
    """Write the contacts of the samples of one surface with the other; return how many there are then.

    A node of the tree whose ball is farther than the margin is left out: distances change by no more than the way. Of a
    convex surface its slab need only be beyond the plane through the point nearest to its middle. With `nearest`,
    contacts[0] becomes the sample with the least gap below the margin, and contacts[1] is written.
    """
    n = int(data[at + SAMPLES])
    if n == 0 or int(data[other + CODE]) == PATCH:
        return found
    table, nodes = at + int(data[at + SAMPLES_AT]), at + int(data[at + TREE_AT])
    convex = data[other + CONVEX] == 1.0
    stack = np.empty(DEPTH, np.int64)
    bounds = np.empty(DEPTH)
    z = np.empty(3)
    g = np.empty(3)
    e = np.empty(3)  # the same in the axes of the samples
    H = np.empty((3, 3))
    top = _push(stack, bounds, 0, 0, np.inf)
    while top > 0:
        top -= 1
        k = stack[top]
        node = nodes + SLAB * k
        radius = data[node + 3]
        _to_other(data[node : node + 3], d, Q, of_b, z)
        gap = signed_distance(data, other, z, bounds[top], g, H)
        if of_b:
            matvec_t(Q, g, e)
        else:
            matvec(Q, g, e)
        if gap - (_depth(data, node, e) if convex else radius) >= margin:
            continue
        within = abs(gap) + radius
        code = int(data[node + 9])
        if code == 0:
            left = k + 1
            right = int(data[nodes + SLAB * left + 8])
            if _along(data, nodes + SLAB * right, nodes + SLAB * left, e) < 0.0:
                left, right = right, left
            for child in (right, left):
                own = nodes + SLAB * child
                if not convex or gap + _along(data, own, node, e) - _depth(data, own, e) < margin:
                    top = _push(stack, bounds, top, child, within)
            continue
        for m in range(code // 16, code // 16 + code % 16):
            if convex and gap + _along(data, table + 7 * m, node, e) >= margin:
                continue
            own = data[table + 7 * m : table + 7 * m + 7]
            contact = contacts[1] if nearest else contacts[found]
            if of_b:
                near = _point_of_b(data, other, own[0:3], 0.0, d, Q, within, margin, contact)
            else:
                near = _point_of_a(data, other, own[0:3], 0.0, d, Q, within, margin, contact)
            if near and nearest:
                margin = contact.gap
                contacts[0] = contact
                found = 1
            elif near:
                counts = (
                    _weigh_b(contact, share * own[6], own[3:6], Q)
                    if of_b
                    else _weigh_a(contact, share * own[6], own[3:6])
                )
                contact.sample = 1 + m if of_b else -1 - m
                found += 1 if counts else 0
    return found


@kernel
def find_areas(data, at_a, at_b, margin, d, Q, contacts):
    """Write contacts of the samples with a gap below the margin, m; return how many.

    Where both surfaces are sampled, the samples of each count with half their areas; samples of a patch count alone.
    """
    if bound_gap(data, at_a, at_b, d, Q) >= margin:
        return 0
    both = data[at_a + SAMPLES] > 0.0 and data[at_b + SAMPLES] > 0.0
    share = 0.5 if both and int(data[at_a + CODE]) != PATCH and int(data[at_b + CODE]) != PATCH else 1.0
    found = _samples(data, at_b, at_a, d, Q, True, share, margin, 0, False, contacts)
    return _samples(data, at_a, at_b, d, Q, False, share, margin, found, False, contacts)


@kernel
def find_points(data, at_a, at_b, margin, d, Q, contacts):
    """Write contacts of corners with a gap below the margin, m; return how many.

    Corners of both surfaces are tried, but of two balls only one centre.
    """
    found = 0
    if bound_gap(data, at_a, at_b, d, Q) >= margin:
        return found
    radius = data[at_b + ROUNDED]
    first = at_b + int(data[at_b + CORNERS_AT])
    for k in range(int(data[at_b + CORNERS])):
        y = data[first + 3 * k : first + 3 * k + 3]
        if _point_of_b(data, at_a, y, radius, d, Q, np.inf, margin, contacts[found]):
            found += 1
    if int(data[at_b + CODE]) == 1 and int(data[at_a + CODE]) != PATCH:
        return found
    radius = data[at_a + ROUNDED]
    first = at_a + int(data[at_a + CORNERS_AT])
    for k in range(int(data[at_a + CORNERS])):
        y = data[first + 3 * k : first + 3 * k + 3]
        if _point_of_a(data, at_b, y, radius, d, Q, np.inf, margin, contacts[found]):
            found += 1
    return found


@kernel
def find_closest(data, at_a, at_b, margin, d, Q, contacts):
    """Write the one contact of a ball with another surface, if its gap is below the margin, m; return 1 or 0."""
    if bound_gap(data, at_a, at_b, d, Q) >= margin:
        return 0
    center = np.zeros(3)
    if int(data[at_b + CODE]) == 1:
        return 1 if _point_of_b(data, at_a, center, data[at_b + ROUNDED], d, Q, np.inf, margin, contacts[0]) else 0
    return 1 if _point_of_a(data, at_b, center, data[at_a + ROUNDED], d, Q, np.inf, margin, contacts[0]) else 0


@kernel
def nearest_sample(data, at_a, at_b, margin, d, Q, contacts):
    """Write to contacts[0] the sample with the least gap below the margin, m, and something to contacts[1]; return 1,
    or 0 if there is none.
    """
    found = _samples(data, at_b, at_a, d, Q, True, 1.0, margin, 0, True, contacts)
    if found == 1:
        margin = contacts[0].gap
    return _samples(data, at_a, at_b, d, Q, False, 1.0, margin, found, True, contacts)
