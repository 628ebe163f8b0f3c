"""Points of a skin that pass through the faces of another one within a step: continuous detection.

Every point and every corner of a face follows the cubic through its places and velocities at both ends of the step,
seen from the mean of the corners. A cubic lies in the hull of its four control points, so the tree of faces, with boxes
around the control points, names the faces that a point may meet. From a distance g to one of them the step is free for
g / L, L being the longest way between the point and a corner: conservative advancement, as in
`flexmb.surfaces.advancement`.

Source: Mirtich 1996, Impulse-based Dynamic Simulation, section 3.3; Ericson, Real-Time Collision Detection, section
5.5.5; Farin, Curves and Surfaces for CAGD, ch. 5 (hulls of cubics).
"""

from __future__ import annotations

import numpy as np

from flexmb.math.kernel import inner_kernel, kernel
from flexmb.math.switches import IDLE
from flexmb.math.vectors import cross, dot, matvec
from flexmb.surfaces.skin_faces import FACET, KNOT, PLACE, corner_boxes, facing, nearest_face, nearest_on, signed_place
from flexmb.surfaces.trees import DEPTH

__all__ = ["POINT", "keep_paths", "rows_of_paths", "sweep_skins"]

POINT = 9
"""Marker, place from it (3), normal (3), area of a point, and the group that moves it."""
POSE, OF_POINT, OF_CORNER = 10, 9, 6
"""Column of a row of switches where places begin; numbers of a point (place, velocity, normal) and of a corner."""
FINEST, COARSEST, STEEPEST = 1e-3, 0.05, 0.25
"""Ways, in thicknesses of the second skin: not resolved further; resolved at least; of a point inside, in a step."""
MOST = 2000
"""Distances that are computed of a point and a face; what is left of the step is for the next one."""
NEVER = 2.0


def rows_of_paths(points: int, corners: int) -> int:
    """Return the number of rows of switches that hold the places of points and corners."""
    return -(-points // 2) - (-corners // 3)


@kernel
def keep_paths(row, data, markers, out):
    """Write places, velocities and normals of the points, and places and velocities of the corners, to idle rows."""
    y = np.empty(3)
    t = np.empty(3)
    for k in range(len(out)):
        out[k, 0] = IDLE
    for k in range(row.count):
        point = data[row.points + POINT * k : row.points + POINT * (k + 1)]
        marker = markers[int(point[0])]
        at = POSE + OF_POINT * (k % 2)
        own = out[k // 2, at : at + OF_POINT]
        matvec(marker.R, point[1:4], y)
        cross(marker.w, y, t)
        for i in range(3):
            own[i], own[3 + i] = marker.r[i] + y[i], marker.v[i] + t[i]
        matvec(marker.R, point[4:7], own[6:9])
    first = (row.count + 1) // 2
    for c in range(row.n_corners):
        marker = markers[int(data[row.corners + 2 * c])]
        at = POSE + OF_CORNER * (c % 3)
        own = out[first + c // 3, at : at + OF_CORNER]
        for i in range(3):
            own[i], own[3 + i] = marker.r[i], marker.v[i]


@inner_kernel
def _control(now, then, at, h, j, i):
    """Return component i of control point j of the cubic of what is kept at column `at`."""
    if j == 0:
        return now[at + i]
    if j == 1:
        return now[at + i] + h / 3.0 * now[at + 3 + i]
    if j == 2:
        return then[at + i] - h / 3.0 * then[at + 3 + i]
    return then[at + i]


@inner_kernel
def _read_paths(row, now, then, h, points, corners):
    """Write the control points of all points (n, 4, 3) and corners (4, c, 3), seen from the mean of the corners."""
    mean = np.zeros((4, 3))
    first = (row.count + 1) // 2
    for c in range(row.n_corners):
        k, at = first + c // 3, POSE + OF_CORNER * (c % 3)
        for j in range(4):
            for i in range(3):
                corners[j, c, i] = _control(now[k], then[k], at, h, j, i)
                mean[j, i] += corners[j, c, i] / row.n_corners
    for j in range(4):
        for i in range(3):
            for c in range(row.n_corners):
                corners[j, c, i] -= mean[j, i]
            for k in range(row.count):
                at = POSE + OF_POINT * (k % 2)
                points[k, j, i] = _control(now[k // 2], then[k // 2], at, h, j, i) - mean[j, i]


@inner_kernel
def _grow(box, x):
    """Let a box (6,) hold a place too."""
    for i in range(3):
        box[i], box[3 + i] = min(box[i], x[i]), max(box[3 + i], x[i])


@inner_kernel
def _apart(a, b, by):
    """Are two boxes farther from each other than `by`, m?"""
    most = -np.inf
    for i in range(3):
        most = max(most, a[i] - b[3 + i], b[i] - a[3 + i])
    return most > by


@inner_kernel
def _swept_boxes(row, data, corners, begin, end, swept):
    """Write the boxes (k, 6) of the tree of faces at both ends of the step, and around all of their ways."""
    between = np.empty((row.n_nodes, 6))
    corner_boxes(data, row.facets, row.nodes, row.n_nodes, corners[0], begin)
    corner_boxes(data, row.facets, row.nodes, row.n_nodes, corners[3], end)
    for k in range(row.n_nodes):
        for i in range(6):
            swept[k, i] = begin[k, i]
        _grow(swept[k], end[k, 0:3])
        _grow(swept[k], end[k, 3:6])
    for j in range(1, 3):
        corner_boxes(data, row.facets, row.nodes, row.n_nodes, corners[j], between)
        for k in range(row.n_nodes):
            _grow(swept[k], between[k, 0:3])
            _grow(swept[k], between[k, 3:6])


@inner_kernel
def _pressed(row, data, X, boxes, z, m, place):
    """Does a point with the normal m press on the faces as they lie?"""
    nearest_face(data, row.facets, row.nodes, X, boxes, z, row.radius + row.depth, place)
    if place.facet < 0:
        return False
    solid = row.radius == 0.0
    signed_place(data, row.facets, X, z, solid, place)
    return not (solid and place.free == 1) and place.distance < row.radius and dot(m, place.n) < 0.0


@inner_kernel
def _free_inside(row, data, place, path, corners, thick):
    """Return the part of a step within which a point that presses at its beginning gets no deeper than it may."""
    deeper = 0.0
    facet = row.facets + FACET * place.facet
    for i in range(3):
        foot = 0.0
        for c in range(3):
            corner = int(data[facet + c])
            if corner >= 0:
                foot += place.share[c] * (corners[3, corner, i] - corners[0, corner, i])
        deeper -= place.n[i] * (path[3, i] - path[0, i] - foot)
    return STEEPEST * thick / deeper if deeper > STEEPEST * thick else NEVER


@inner_kernel
def _at(path, corners, own, s, z, X):
    """Write the places of a point and of the corners of a face at the part s of the step."""
    r = 1.0 - s
    b0, b1, b2, b3 = r * r * r, 3.0 * r * r * s, 3.0 * r * s * s, s * s * s
    for i in range(3):
        z[i] = b0 * path[0, i] + b1 * path[1, i] + b2 * path[2, i] + b3 * path[3, i]
        for c in range(3):
            k = own[c]
            X[c, i] = b0 * corners[0, k, i] + b1 * corners[1, k, i] + b2 * corners[2, k, i] + b3 * corners[3, k, i]


@inner_kernel
def _ways(path, corners, own):
    """Return a bound of the way between a point and any corner of a face in a step."""
    most = 0.0
    for j in range(3):
        for c in range(3):
            square = 0.0
            for i in range(3):
                way = path[j + 1, i] - path[j, i] - corners[j + 1, own[c], i] + corners[j, own[c], i]
                square += way * way
            most = max(most, 3.0 * square**0.5)
    return most


@inner_kernel
def _parted(path, corners, own, e, by):
    """Does a plane with the normal e (3,) part a point and a face, by a distance, all through the step?"""
    least, most = np.inf, -np.inf
    for j in range(4):
        least = min(least, dot(e, path[j]))
        for c in range(3):
            most = max(most, dot(e, corners[j, own[c]]))
    return least - most > by


@inner_kernel
def _look(face, s, radius, path, corners, own, z, X, triangle, p, e):
    """Write the way e from the nearest place of a face to a point at the part s; return its length and its side."""
    _at(path, corners, own, s, z, X)
    nearest_on(face, 0, X, triangle, z, p)
    for i in range(3):
        e[i] = z[i] - p[i]
    return dot(e, e) ** 0.5, facing(triangle, z, p) if radius == 0.0 else 1.0


@inner_kernel
def _meets(row, data, facet, path, corners, m, finest, dips):
    """Return the part of a step at which a point first meets a face from outside, looking at it, if it passes through
    it in this step, or, with `dips`, comes back too; else `NEVER`.

    `m` (2, 3) is its normal at both ends.
    """
    z, p, e, first = np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    X, triangle = np.empty((3, 3)), np.empty(9)
    face, own = np.empty(3), np.empty(3, np.int64)
    line = data[facet + 2] < 0.0
    for c in range(3):
        own[c] = int(data[facet + (1 if line and c == 2 else c)])
        face[c] = -1.0 if line and c == 2 else c
    radius = row.radius
    distance, side = _look(face, 0.0, radius, path, corners, own, z, X, triangle, p, first)
    if side <= 0.0 or distance <= radius or _parted(path, corners, own, first, radius * distance):
        return NEVER
    if not dips:
        _, side = _look(face, 1.0, radius, path, corners, own, z, X, triangle, p, e)
        if side >= 0.0 and (radius == 0.0 or dot(first, e) >= 0.0):
            return NEVER
        side = 1.0
    most, s = _ways(path, corners, own), 0.0
    for _ in range(MOST):
        gap = distance - radius
        if gap >= most * (1.0 - s):
            return NEVER
        s += max(gap, finest) / most
        if s >= 1.0:
            return NEVER
        before = side
        distance, side = _look(face, s, radius, path, corners, own, z, X, triangle, p, e)
        inside = distance <= radius if radius > 0.0 else before > 0.0 and side <= 0.0 and distance <= 1.001 * finest
        if not inside:
            continue
        if radius == 0.0:  # outward of the face
            for i in range(3):
                j, k = (i + 1) % 3, (i + 2) % 3
                e[i] = (X[1, j] - X[0, j]) * (X[2, k] - X[0, k]) - (X[1, k] - X[0, k]) * (X[2, j] - X[0, j])
        return s if (1.0 - s) * dot(m[0], e) + s * dot(m[1], e) < 0.0 else NEVER
    return s


@inner_kernel
def _passes(row, data, swept, path, corners, m, box, finest, dips, best):
    """Return the part of a step at which a point first meets one of the faces whose ways come near its own."""
    stack = np.empty(DEPTH, np.int64)
    stack[0], top = 0, 1
    while top > 0:
        top -= 1
        k = stack[top]
        if _apart(swept[k], box, row.radius):
            continue
        code = int(data[row.nodes + KNOT * k + 1])
        if code == 0:
            stack[top], stack[top + 1] = int(data[row.nodes + KNOT * (k + 1)]), k + 1
            top += 2
            continue
        for f in range(code // 16, code // 16 + code % 16):
            best = min(best, _meets(row, data, row.facets + FACET * f, path, corners, m, finest, dips))
    return best


@kernel
def sweep_skins(row, data, now, then, h, floor, dips, part):
    """Lower part[0] to where in a step a point of the first skin begins to pass through the second one unseen.

    `now` and `then` are the rows of `keep_paths` at both ends of the step, `floor` a way, m, that does not matter. A
    point that presses at the end is seen. With `dips` one that comes back within the step is looked for too.
    """
    n = row.count
    points, corners = np.empty((n, 4, 3)), np.empty((4, row.n_corners, 3))
    _read_paths(row, now, then, h, points, corners)
    own, whole = np.empty(6), np.empty(6)
    for i in range(3):
        own[i], whole[i], own[3 + i], whole[3 + i] = np.inf, np.inf, -np.inf, -np.inf
    for j in range(4):
        for k in range(n):
            _grow(own, points[k, j])
        for c in range(row.n_corners):
            _grow(whole, corners[j, c])
    if _apart(own, whole, row.radius):
        return
    begin, end, swept = np.empty((row.n_nodes, 6)), np.empty((row.n_nodes, 6)), np.empty((row.n_nodes, 6))
    _swept_boxes(row, data, corners, begin, end, swept)
    thick = row.radius if row.radius > 0.0 else row.depth
    finest = max(min(floor, COARSEST * thick), FINEST * thick)
    m = np.empty((2, 3))
    places = np.zeros(1, PLACE)
    for k in range(n):
        path = points[k]
        for i in range(3):
            own[i], own[3 + i] = path[0, i], path[0, i]
            at = POSE + OF_POINT * (k % 2) + 6 + i
            m[0, i], m[1, i] = now[k // 2, at], then[k // 2, at]
        for j in range(1, 4):
            _grow(own, path[j])
        if _apart(own, swept[0], row.radius):
            continue
        place = places[0]  # here: a row does not keep its table alive
        if _pressed(row, data, corners[3], end, path[3], m[1], place):
            continue
        if _pressed(row, data, corners[0], begin, path[0], m[0], place):
            part[0] = min(part[0], _free_inside(row, data, place, path, corners, thick))
            continue
        part[0] = min(part[0], _passes(row, data, swept, path, corners, m, own, finest, dips, part[0]))
