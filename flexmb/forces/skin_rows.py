"""The rows of `SkinContact`, and its kernels: points of one skin against the faces of the other."""

from __future__ import annotations

import numpy as np

from flexmb.constraints.marker_blocks import add_to_pair, own_parts, projected
from flexmb.forces.skin_sweep import POINT, keep_paths, sweep_skins
from flexmb.forces.skin_wrench import COLUMNS, SPOT, act_on_skins
from flexmb.math.kernel import inner_kernel, kernel
from flexmb.math.switches import GAP, IDLE, SLIP, sweep_kernel, switch_kernel
from flexmb.math.tables import row_kernel
from flexmb.math.vectors import cross, dot, matvec
from flexmb.surfaces.detection import faced
from flexmb.surfaces.skin_faces import FACET, PLACE, TOUCHING, corner_boxes, nearest_face, signed_place

__all__ = ["ROW", "apply", "find_spot", "moved_corners", "sweep", "switch", "touching_points"]

ROW = np.dtype(
    [
        ("points", np.int64),  # where the points begin in the bulk data, `POINT` numbers each
        ("count", np.int64),
        ("corners", np.int64),  # where the markers of the corners of faces begin, with the group that moves each
        ("n_corners", np.int64),
        ("facets", np.int64),
        ("nodes", np.int64),
        ("n_nodes", np.int64),
        ("spans", np.int64),  # where the places of the blocks begin: four times a pair plus a block of it
        ("n_spans", np.int64),
        ("switches", np.int64),  # gap, slip, and the rows that keep the ways of points and corners
        ("radius", float),  # m, by which the faces are thickened
        ("depth", float),  # m, beyond which a point has passed through
        ("stiffness", float),  # N/m^3
        ("exponent", float),
        ("damping", float),  # s/m
        ("friction", float),
        ("transition", float),  # m/s
    ],
    align=True,
)


@kernel
def moved_corners(row, data, markers, X):
    """Write the places of the corners X (c, 3), and return the boxes (k, 6) of the tree of faces around them."""
    for k in range(row.n_corners):
        marker = markers[int(data[row.corners + 2 * k])]
        for i in range(3):
            X[k, i] = marker.r[i]
    boxes = np.empty((row.n_nodes, 6))
    corner_boxes(data, row.facets, row.nodes, row.n_nodes, X, boxes)
    return boxes


@kernel
def find_spot(row, data, markers, X, boxes, k, within, place, spot):
    """Find the face nearest to point k; return if there is one `within`, m, of its middle, and fill the spot."""
    point = data[row.points + POINT * k : row.points + POINT * (k + 1)]
    marker = markers[int(point[0])]
    z = np.empty(3)
    matvec(marker.R, point[1:4], spot.y)
    for i in range(3):
        z[i] = marker.r[i] + spot.y[i]
    nearest_face(data, row.facets, row.nodes, X, boxes, z, within, place)
    if place.facet < 0:
        return False
    solid = row.radius == 0.0
    signed_place(data, row.facets, X, z, solid, place)
    # beyond the rim of an open skin there is nothing, and in the edge itself no normal
    if (solid and place.free == 1) or (place.where > 0 and abs(place.distance) <= TOUCHING * point[7] ** 0.5):
        return False
    matvec(marker.R, point[4:7], spot.m)
    spot.area, spot.radius = point[7], row.radius
    for c in range(4):
        own = marker
        if c > 0:
            corner = int(data[row.facets + FACET * place.facet + c - 1])
            own = markers[int(data[row.corners + 2 * max(corner, 0)])]
        for i in range(3):
            spot.r[c, i], spot.v[c, i], spot.w[c, i] = own.r[i], own.v[i], own.w[i]
    return True


@inner_kernel
def _spread(row, data, k, place, wrench, K, D, wanted, work):
    """Let the wrenches of a spot act on its markers, and add its derivatives to the iteration matrix."""
    numbers, spans, firsts = np.empty(4, np.int64), np.empty(4, np.int64), np.empty(4, np.int64)
    point = row.points + POINT * k
    numbers[0], spans[0] = int(data[point]), int(data[point + 8])
    for c in range(3):
        corner = max(int(data[row.facets + FACET * place.facet + c]), 0)
        numbers[1 + c], spans[1 + c] = int(data[row.corners + 2 * corner]), int(data[row.corners + 2 * corner + 1])
    for c in range(4):
        marker = work.markers[numbers[c]]
        for i in range(6):
            marker.wrench[i] += wrench[c, i]
    if not wanted:
        return
    total = own_parts(spans, numbers, work.markers, firsts)
    M = projected(numbers, firsts, total, K, D, work)
    for c in range(4):
        for d in range(4):
            again = False
            for e in range(4):
                again = again or (e < c and spans[e] == spans[c]) or (e < d and spans[e] == spans[d])
            code = int(data[row.spans + row.n_spans * spans[c] + spans[d]])
            if code >= 0 and not again:
                add_to_pair(code, M, firsts[c], firsts[d], work)


@row_kernel
def apply(raw, data, state, work):
    """Pressure and friction at every point inside the other skin, eq. (skin-contact)."""
    rows = raw.view(ROW)
    places, spots = np.zeros(1, PLACE), np.zeros(1, SPOT)
    wrench = np.empty((4, 6))
    K = np.zeros((COLUMNS, COLUMNS))
    D = np.zeros((COLUMNS, COLUMNS))
    weights = work.weights[0]
    wanted = weights.wanted == 1 and (weights.stiffness != 0.0 or weights.damping != 0.0)
    for m in range(rows.shape[0]):
        row = rows[m]
        X = np.empty((row.n_corners, 3))
        boxes = moved_corners(row, data, work.markers, X)
        within = row.radius + row.depth
        for k in range(row.count):
            place, spot = places[0], spots[0]  # here: a row does not keep its table alive
            if not find_spot(row, data, work.markers, X, boxes, k, within, place, spot):
                continue
            if place.distance >= row.radius:
                continue
            act_on_skins(row, place, spot, wanted, wrench, K, D, work.energy)
            _spread(row, data, k, place, wrench, K, D, wanted, work)


@switch_kernel
def switch(raw, data, state, work, out):
    """The least gap between the skins, and the slip where they touch."""
    rows = raw.view(ROW)
    places, spots = np.zeros(1, PLACE), np.zeros(1, SPOT)
    u = np.empty(3)
    t = np.empty(3)
    first = 0
    for m in range(rows.shape[0]):
        row = rows[m]
        gap, slip = out[first], out[first + 1]
        keep_paths(row, data, work.markers, out[first + 2 : first + row.switches])
        first += row.switches
        gap[:] = 0.0
        slip[:] = 0.0
        gap[0], slip[0] = IDLE, IDLE
        X = np.empty((row.n_corners, 3))
        boxes = moved_corners(row, data, work.markers, X)
        least = np.inf
        for k in range(row.count):
            place, spot = places[0], spots[0]
            # deeper points of a solid are farther from its faces
            within = max(least + row.radius, row.radius + row.depth)
            if not find_spot(row, data, work.markers, X, boxes, k, within, place, spot):
                continue
            if dot(spot.m, place.n) >= 0.0 or place.distance < -row.depth:
                continue
            if place.distance - row.radius >= least:
                continue
            least = place.distance - row.radius
            for i in range(3):
                u[i] = spot.v[0, i]
                for c in range(3):
                    u[i] -= place.share[c] * spot.v[1 + c, i]
            cross(spot.w[0], spot.y, t)
            for i in range(3):
                u[i] += t[i]
            rate = dot(place.n, u)
            gap[0], gap[1], gap[4], gap[9] = GAP, least, rate, 1.0
            slip[0] = IDLE
            if least < 0.0 and row.friction > 0.0:
                slip[0], slip[8] = SLIP, row.transition
                for i in range(3):
                    slip[4 + i] = u[i] - rate * place.n[i]


@sweep_kernel
def sweep(raw, data, now, then, h, adaptive, limits, part):
    """Points that pass through the other skin within a step; where nothing touches at its ends, those that dip too."""
    rows = raw.view(ROW)
    first = 0
    for m in range(rows.shape[0]):
        row = rows[m]
        a, b, last = now[first], then[first], first + row.switches
        dips = (a[0] != GAP or a[1] > 0.0) and (b[0] != GAP or b[1] > 0.0)
        sweep_skins(row, data, now[first + 2 : last], then[first + 2 : last], h, limits[0].floor, dips, part)
        first = last


@kernel
def touching_points(rows, data, markers, energy):
    """Return number, depth, pressure, slip and area of all points that touch."""
    row = rows[0]
    places, spots = np.zeros(1, PLACE), np.zeros(1, SPOT)
    wrench = np.empty((4, 6))
    unused = np.empty((0, 0))
    point = np.empty(row.count, np.int64)
    found = np.empty((4, row.count))
    X = np.empty((row.n_corners, 3))
    boxes = moved_corners(row, data, markers, X)
    n = 0
    for k in range(row.count):
        place, spot = places[0], spots[0]
        if not find_spot(row, data, markers, X, boxes, k, row.radius + row.depth, place, spot):
            continue
        if place.distance >= row.radius:
            continue
        share, _ = faced(-dot(spot.m, place.n))
        if share > 0.0:
            depth, pressure, slip = act_on_skins(row, place, spot, False, wrench, unused, unused, energy)
            point[n], found[0, n], found[1, n], found[2, n] = k, depth, pressure, slip
            found[3, n] = spot.area * share
            n += 1
    return point[:n], found[0, :n], found[1, :n], found[2, :n], found[3, :n]
