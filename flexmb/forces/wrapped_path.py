"""The way of a string, a tendon or a muscle: straight from marker to marker, and around cylinders in between.

The length L of the way and its gradient G by the displacements and rotations of all its markers make a tension T the
wrenches ``-T G``, whose tangent is ``dT/dL G G^T + T dG``. Around a cylinder the way is a geodesic: unrolled, straight
lines and helix are one straight line, so that its length is closed, eq. (wrapped-path).
"""

from __future__ import annotations

import numpy as np

from flexmb.math.kernel import inner_kernel, kernel
from flexmb.math.switches import KINK
from flexmb.math.vectors import cross, matvec, matvec_t, norm

__all__ = [
    "MOST",
    "PATH",
    "add_path_curvature",
    "around_cylinder",
    "contact_angle",
    "passes_behind",
    "path_length",
    "pull",
    "write_kinks",
]

MOST = 12
"""Markers of a way."""

PATH = np.dtype(
    [
        ("n", np.int64),  # markers
        ("markers", np.int64, MOST),
        ("radii", float, MOST),  # m; 0: the way goes through the marker; negative: around its z-axis the other way
        ("branches", np.int64, MOST),  # of the angles around the cylinders, or -1
        ("cylinders", np.int64),
        ("pairs", np.int64),  # of `pair_blocks` of the markers and of the states, in the bulk data
    ],
    align=True,
)


@inner_kernel
def _between(work, c, p, d):
    """Write the place of marker p from the marker c of a cylinder to `d` (2, 3): in W and in the axes of c."""
    cylinder = work.markers[c]
    for i in range(3):
        d[0, i] = work.markers[p].r[i] - cylinder.r[i]
    matvec_t(cylinder.R, d[0], d[1])


@inner_kernel
def _angle(row, k, state, work, P, S):
    """Return by how much the way turns from P to S about the axis of cylinder k, followed through full turns, rad."""
    sense = 1.0 if row.radii[k] > 0.0 else -1.0
    x = sense * np.arctan2(P[0] * S[1] - P[1] * S[0], P[0] * S[0] + P[1] * S[1])
    near = state.q[len(state.q) - len(work.branches) + row.branches[k]]
    x += 2.0 * np.pi * np.round((near - x) / (2.0 * np.pi))
    work.branches[row.branches[k]] = x
    return x


@kernel
def contact_angle(radius, P, S, angle):
    """Return the angle over which the way lies on a cylinder, rad; where it is negative the way does not touch."""
    r = abs(radius)
    return angle - np.arccos(r / (P[0] ** 2 + P[1] ** 2) ** 0.5) - np.arccos(r / (S[0] ** 2 + S[1] ** 2) ** 0.5)


@kernel
def passes_behind(radius, P, S, angle):
    """Does the straight line from P to S cut the cylinder on the side around which the way does not go?"""
    x, y = S[0] - P[0], S[1] - P[1]
    share = -(P[0] * x + P[1] * y) / max(x * x + y * y, 1e-300)
    across = (P[0] * y - P[1] * x) ** 2
    return -np.pi < angle < 0.0 and 0.0 < share < 1.0 and across < radius * radius * (x * x + y * y)


@kernel
def around_cylinder(radius, P, S, contact, g, H):
    """Return the length of the way from P to S around the cylinder, write gradient (2, 3) and second derivative (6, 6).

    In the plane across the axis the length s is that of two tangents a and an arc; ds is the unit vector u along the
    tangent, and moving P across it turns the tangent: d2s = n n^T / a. With the height z, L = sqrt(s^2 + z^2).
    """
    r, sense = abs(radius), (1.0 if radius > 0.0 else -1.0)
    H[:] = 0.0
    ds = np.zeros(6)
    s = r * contact
    for side in range(2):
        x = P if side == 0 else S
        rho = (x[0] * x[0] + x[1] * x[1]) ** 0.5
        a = (rho * rho - r * r) ** 0.5
        s += a
        # towards the other end, from P with the sense of the way and from S against it
        way = sense if side == 0 else -sense
        cosine, sine = a / rho, way * r / rho
        u = (cosine * x[0] + sine * x[1]) / rho, (cosine * x[1] - sine * x[0]) / rho
        n = (-u[1], u[0])
        for i in range(2):
            ds[3 * side + i] = u[i]
            for j in range(2):
                H[3 * side + i, 3 * side + j] = n[i] * n[j] / a
    z = S[2] - P[2]
    length = (s * s + z * z) ** 0.5
    for i in range(6):
        rise = (1.0 if i == 5 else -1.0 if i == 2 else 0.0) * z
        g[i // 3, i % 3] = (s * ds[i] + rise) / length
    for i in range(6):
        for j in range(6):
            rises = (1.0 if i == j else -1.0) if i % 3 == 2 and j % 3 == 2 else 0.0
            own = ds[i] * ds[j] + s * H[i, j] + rises - g[i // 3, i % 3] * g[j // 3, j % 3]
            H[i, j] = own / length
    return length


@kernel
def path_length(row, state, work, G):
    """Return the length of the way, m, and write its gradient by displacement and rotation of each marker to G (n, 6).

    NaN where a marker is inside a cylinder, or the way would have to go through one.
    """
    markers = work.markers
    dp, ds, g, H = np.empty((2, 3)), np.empty((2, 3)), np.empty((2, 3)), np.empty((6, 6))
    d, t = np.empty(3), np.empty(3)
    G[:] = 0.0
    total = 0.0
    k = 0
    while k < row.n - 1:
        c, end = k + 1, k + 1
        contact = -1.0
        if row.radii[c] != 0.0:
            end = k + 2
            _between(work, row.markers[c], row.markers[k], dp)
            _between(work, row.markers[c], row.markers[end], ds)
            angle = _angle(row, c, state, work, dp[1], ds[1])
            contact = contact_angle(row.radii[c], dp[1], ds[1], angle)
            if passes_behind(row.radii[c], dp[1], ds[1], angle):
                contact = np.nan
        if contact <= 0.0:
            for i in range(3):
                d[i] = markers[row.markers[end]].r[i] - markers[row.markers[k]].r[i]
            length = max(norm(d), 1e-150)
            total += length
            for i in range(3):
                G[end, i] += d[i] / length
                G[k, i] -= d[i] / length
        else:
            total += around_cylinder(row.radii[c], dp[1], ds[1], contact, g, H)
            for side in range(2):
                other, place = (k, dp) if side == 0 else (end, ds)
                matvec(markers[row.markers[c]].R, g[side], d)
                cross(place[0], d, t)
                for i in range(3):
                    G[other, i] += d[i]
                    G[c, i] -= d[i]
                    G[c, 3 + i] -= t[i]
        k = end
    return total


@kernel
def pull(row, work, G, tension):
    """Let a tension act on all markers."""
    for k in range(row.n):
        for i in range(6):
            work.markers[row.markers[k]].wrench[i] -= tension * G[k, i]


@inner_kernel
def _add_straight(r_one, r_two, one, two, tension, K):
    """Add the change of direction of a straight piece to K."""
    d = np.empty(3)
    for i in range(3):
        d[i] = r_two[i] - r_one[i]
    length = max(norm(d), 1e-150)
    for i in range(3):
        for j in range(3):
            x = tension / length * ((1.0 if i == j else 0.0) - d[i] * d[j] / length**2)
            K[6 * one + i, 6 * one + j] += x
            K[6 * two + i, 6 * two + j] += x
            K[6 * one + i, 6 * two + j] -= x
            K[6 * two + i, 6 * one + j] -= x


@inner_kernel
def _add_wrapped(R, d, g, H, ends, c, tension, K):
    """Add how gradients of a way around cylinder c change: d (2, 3) the ends from it in W, g and H in its axes."""
    e, moved, turned, t = np.zeros(3), np.empty((2, 3)), np.empty(3), np.empty(3)
    gW, local, change = np.empty((2, 3)), np.empty((2, 3)), np.empty(3)
    for side in range(2):
        matvec(R, g[side], gW[side])
    for column in range(12):  # the cylinder is moved and turned, then its ends are moved
        j = column % 3
        e[:] = 0.0
        e[j] = 1.0
        turns = 3 <= column < 6
        at = 6 * c + column if column < 6 else 6 * ends[(column - 6) // 3] + j
        for side in range(2):
            if turns:
                cross(e, d[side], moved[side])
            for i in range(3):
                if turns:
                    moved[side, i] = -moved[side, i]
                elif column < 3:
                    moved[side, i] = -e[i]
                else:
                    moved[side, i] = e[i] if side == (column - 6) // 3 else 0.0
            matvec_t(R, moved[side], local[side])
        for side in range(2):
            for i in range(3):
                t[i] = 0.0
                for m in range(6):
                    t[i] += H[3 * side + i, m] * local[m // 3, m % 3]
            matvec(R, t, change)
            if turns:
                cross(e, gW[side], turned)
                for i in range(3):
                    change[i] += turned[i]
            cross(d[side], change, t)
            if not turns:
                cross(moved[side], gW[side], turned)
                for i in range(3):
                    t[i] += turned[i]
            for i in range(3):
                K[6 * ends[side] + i, at] += tension * change[i]
                K[6 * c + i, at] -= tension * change[i]
                K[6 * c + 3 + i, at] -= tension * t[i]


@kernel
def add_path_curvature(row, state, work, tension, K):
    """Add ``tension dG``, what the directions of the way change with the places of its markers, to K (6 n, 6 n)."""
    dp, ds, g, H, d = np.empty((2, 3)), np.empty((2, 3)), np.empty((2, 3)), np.empty((6, 6)), np.empty((2, 3))
    k = 0
    while k < row.n - 1:
        c, end = k + 1, k + 1
        contact = -1.0
        if row.radii[c] != 0.0:
            end = k + 2
            _between(work, row.markers[c], row.markers[k], dp)
            _between(work, row.markers[c], row.markers[end], ds)
            contact = contact_angle(row.radii[c], dp[1], ds[1], _angle(row, c, state, work, dp[1], ds[1]))
        if contact <= 0.0:
            _add_straight(work.markers[row.markers[k]].r, work.markers[row.markers[end]].r, k, end, tension, K)
        else:
            around_cylinder(row.radii[c], dp[1], ds[1], contact, g, H)
            d[0], d[1] = dp[0], ds[0]
            _add_wrapped(work.markers[row.markers[c]].R, d, g, H, (k, end), c, tension, K)
        k = end


@inner_kernel
def _angle_rate(work, c, p, d):
    """Return the rates of the angle of marker p about the axis of a cylinder and of its distance from the axis."""
    swept, v, V = np.empty(3), np.empty(3), np.empty(3)
    cylinder = work.markers[c]
    cross(cylinder.w, d[0], swept)
    for i in range(3):
        v[i] = work.markers[p].v[i] - cylinder.v[i] - swept[i]
    matvec_t(cylinder.R, v, V)
    rho2 = d[1, 0] ** 2 + d[1, 1] ** 2
    return (d[1, 0] * V[1] - d[1, 1] * V[0]) / rho2, (d[1, 0] * V[0] + d[1, 1] * V[1]) / rho2**0.5


@kernel
def write_kinks(row, state, work, out, first):
    """Write from row `first` of `out` where the way begins to touch its cylinders; return the row behind."""
    dp, ds = np.empty((2, 3)), np.empty((2, 3))
    for c in range(1, row.n - 1):
        r = abs(row.radii[c])
        if r == 0.0:
            continue
        _between(work, row.markers[c], row.markers[c - 1], dp)
        _between(work, row.markers[c], row.markers[c + 1], ds)
        kink = out[first]
        kink[:] = 0.0
        kink[0], kink[8], kink[9] = KINK, 1.0, 1.0
        kink[1] = contact_angle(row.radii[c], dp[1], ds[1], _angle(row, c, state, work, dp[1], ds[1]))
        turn_p, away_p = _angle_rate(work, row.markers[c], row.markers[c - 1], dp)
        turn_s, away_s = _angle_rate(work, row.markers[c], row.markers[c + 1], ds)
        rate = (1.0 if row.radii[c] > 0.0 else -1.0) * (turn_s - turn_p)
        for side in range(2):
            x, away = (dp[1], away_p) if side == 0 else (ds[1], away_s)
            rho = (x[0] ** 2 + x[1] ** 2) ** 0.5
            rate -= r * away / (rho * (rho * rho - r * r) ** 0.5)
        kink[4] = rate
        first += 1
    return first
