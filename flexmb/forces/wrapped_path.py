"""The way of a string, a tendon or a muscle: straight from marker to marker, and around cylinders in between.

The length L of the way and its gradient G by the displacements and rotations of all its markers make a tension T the
wrenches ``-T G``, whose tangent is ``dT/dL G G^T + T dG``. Around a cylinder the way is a geodesic: unrolled, straight
lines and helix are one straight line, so that its length is closed, eq. (wrapped-path). Where cylinders follow each
other, the places X between them (`cylinders_in_a_row`) are nodes like the markers; they follow the markers, and
``dX = -L_XX^-1 L_Xq dq`` gives the tangent of the whole.
"""

from __future__ import annotations

import numpy as np

from flexmb.forces.cylinders_in_a_row import (
    around_cylinder,
    contact_angle,
    eliminate,
    passes_behind,
    places_between,
    turn_about,
)
from flexmb.math.kernel import inner_kernel, kernel
from flexmb.math.switches import IDLE, KINK
from flexmb.math.vectors import cross, matvec, matvec_t, norm

__all__ = ["MOST", "PATH", "add_path_curvature", "path_length", "pull", "write_kinks"]

MOST = 12
"""Markers of a way."""

PATH = np.dtype(
    [
        ("n", np.int64),  # markers
        ("markers", np.int64, MOST),
        ("radii", float, MOST),  # m; 0: the way goes through the marker; negative: around its z-axis the other way
        ("branches", np.int64, MOST),  # of the angles around the cylinders, or -1
        ("between", np.int64, MOST),  # first of three, of the place between this cylinder and the next, or -1
        ("cylinders", np.int64),
        ("pairs", np.int64),  # of `pair_blocks` of the markers and of the states, in the bulk data
    ],
    align=True,
)


@inner_kernel
def _from_cylinder(work, c, place, d):
    """Write a place from the marker c of a cylinder to `d` (2, 3): in W and in the axes of c."""
    cylinder = work.markers[c]
    for i in range(3):
        d[0, i] = place[i] - cylinder.r[i]
    matvec_t(cylinder.R, d[0], d[1])


@inner_kernel
def _held(row, k, state, work):
    """Return the angle around cylinder k that was accepted last."""
    return state.q[len(state.q) - len(work.branches) + row.branches[k]]


@inner_kernel
def _find_between(row, first, m, state, work, P, S, X):
    """Write the places between m cylinders from marker `first` on to X; return if there is a way."""
    radii, near, centers, frames = np.empty(m), np.empty(m), np.empty((m, 3)), np.empty((m, 3, 3))
    for j in range(m):
        cylinder = work.markers[row.markers[first + j]]
        radii[j], near[j] = row.radii[first + j], _held(row, first + j, state, work)
        centers[j], frames[j] = cylinder.r, cylinder.R
    start = len(state.q) - len(work.branches)
    for j in range(m - 1):
        for i in range(3):
            middle = 0.5 * (centers[j, i] + centers[j + 1, i])
            X[j, i] = middle + state.q[start + row.between[first + j] + i]
    if not places_between(radii, centers, frames, near, P, S, X):
        return False
    for j in range(m - 1):
        for i in range(3):
            middle = 0.5 * (centers[j, i] + centers[j + 1, i])
            work.branches[row.between[first + j] + i] = X[j, i] - middle
    return True


@inner_kernel
def _divide(row, state, work, places, pieces):
    """Write the nodes of the way (markers, then places between cylinders) and its pieces (node, cylinder or -1, node).

    Return how many pieces and how many places between cylinders there are; no piece where no way is found.
    """
    n = row.n
    for k in range(n):
        places[k] = work.markers[row.markers[k]].r
    count, more, k = 0, 0, 0
    while k < n - 1:
        m = 0
        while row.radii[k + 1 + m] != 0.0:
            m += 1
        end = k + m + 1
        if m == 0:
            pieces[count, 0], pieces[count, 1], pieces[count, 2] = k, -1, end
            count += 1
        elif m > 1 and not _find_between(
            row, k + 1, m, state, work, places[k], places[end], places[n + more : n + more + m - 1]
        ):
            return 0, 0
        for j in range(m):
            pieces[count, 0] = k if j == 0 else n + more + j - 1
            pieces[count, 1] = k + 1 + j
            pieces[count, 2] = end if j == m - 1 else n + more + j
            count += 1
        more += max(m - 1, 0)
        k = end
    return count, more


@inner_kernel
def _contact(row, piece, places, state, work, dp, ds):
    """Return the angle over which a piece lies on its cylinder, -1 without one, NaN where it would go through it.

    Writes where its ends are from the cylinder to dp, ds (2, 3), in W and in its axes.
    """
    c = piece[1]
    if c < 0:
        return -1.0
    _from_cylinder(work, row.markers[c], places[piece[0]], dp)
    _from_cylinder(work, row.markers[c], places[piece[2]], ds)
    angle = turn_about(row.radii[c], dp[1], ds[1], _held(row, c, state, work))
    work.branches[row.branches[c]] = angle
    if passes_behind(row.radii[c], dp[1], ds[1], angle):
        return np.nan
    return contact_angle(row.radii[c], dp[1], ds[1], angle)


@kernel
def path_length(row, state, work, G):
    """Return the length of the way, m, and write its gradient by displacement and rotation of each marker to G (n, 6).

    NaN where a marker is inside a cylinder, or the way would have to go through one.
    """
    places, pieces = np.empty((2 * MOST, 3)), np.empty((MOST, 3), np.int64)
    dp, ds, g, H = np.empty((2, 3)), np.empty((2, 3)), np.empty((2, 3)), np.empty((6, 6))
    d, t = np.empty(3), np.empty(3)
    G[:] = 0.0
    n, total = row.n, 0.0
    count, _ = _divide(row, state, work, places, pieces)
    if count == 0:
        return np.nan
    for m in range(count):
        piece = pieces[m]
        c = piece[1]
        contact = _contact(row, piece, places, state, work, dp, ds)
        if contact <= 0.0:
            for i in range(3):
                d[i] = places[piece[2], i] - places[piece[0], i]
            length = max(norm(d), 1e-150)
            total += length
            for i in range(3):
                if piece[2] < n:
                    G[piece[2], i] += d[i] / length
                if piece[0] < n:
                    G[piece[0], i] -= d[i] / length
        else:
            total += around_cylinder(row.radii[c], dp[1], ds[1], contact, g, H)
            for side in range(2):
                place = dp if side == 0 else ds
                matvec(work.markers[row.markers[c]].R, g[side], d)
                cross(place[0], d, t)
                for i in range(3):
                    if piece[2 * side] < n:
                        G[piece[2 * side], i] += d[i]
                    G[c, i] -= d[i]
                    G[c, 3 + i] -= t[i]
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


@inner_kernel
def _turning(row, state, work, places, pieces, count, tension, K):
    """Add how the directions of all pieces change with the nodes, times the tension, to K."""
    dp, ds, g, H, d = np.empty((2, 3)), np.empty((2, 3)), np.empty((2, 3)), np.empty((6, 6)), np.empty((2, 3))
    for m in range(count):
        piece = pieces[m]
        c = piece[1]
        contact = _contact(row, piece, places, state, work, dp, ds)
        if contact <= 0.0:
            _add_straight(places[piece[0]], places[piece[2]], piece[0], piece[2], tension, K)
        else:
            around_cylinder(row.radii[c], dp[1], ds[1], contact, g, H)
            d[0], d[1] = dp[0], ds[0]
            _add_wrapped(work.markers[row.markers[c]].R, d, g, H, (piece[0], piece[2]), c, tension, K)


@inner_kernel
def _follow(n, more, K, follows):
    """Write how the places between cylinders follow displacements and rotations of the markers to (3 more, 6 n)."""
    own = np.empty((3 * more, 3 * more))
    for a in range(3 * more):
        at = 6 * (n + a // 3) + a % 3
        for b in range(3 * more):
            own[a, b] = K[at, 6 * (n + b // 3) + b % 3]
        for j in range(6 * n):
            follows[a, j] = -K[at, j]
    for a in range(0, 3 * more, 3):  # along its line a place is free: it stays, and nothing depends on it
        stiff = own[a, a] + own[a + 1, a + 1] + own[a + 2, a + 2]
        least, e = np.inf, np.zeros(3)
        for i in range(3):  # the direction that its own block does not resist: the largest product of two rows
            p, q, x = own[a + i, a : a + 3], own[a + (i + 1) % 3, a : a + 3], np.empty(3)
            cross(p, q, x)
            size = norm(x)
            if -size < least:
                least = -size
                e[:] = x / max(size, 1e-300)
        for i in range(3):
            for k in range(3):
                own[a + i, a + k] += stiff * e[i] * e[k]
    eliminate(own, follows)


@kernel
def add_path_curvature(row, state, work, tension, K):
    """Add ``tension dG``, what the directions of the way change with the places of its markers, to K (6 n, 6 n)."""
    places, pieces = np.empty((2 * MOST, 3)), np.empty((MOST, 3), np.int64)
    n = row.n
    count, more = _divide(row, state, work, places, pieces)
    if more == 0:
        _turning(row, state, work, places, pieces, count, tension, K)
        return
    size = 6 * (n + more)
    whole, follows = np.zeros((size, size)), np.empty((3 * more, 6 * n))
    _turning(row, state, work, places, pieces, count, 1.0, whole)
    _follow(n, more, whole, follows)
    for i in range(6 * n):
        for j in range(6 * n):
            x = whole[i, j]
            for a in range(3 * more):
                x += whole[i, 6 * (n + a // 3) + a % 3] * follows[a, j]
            K[i, j] += tension * x


@inner_kernel
def _angle_rate(work, c, moving, d):
    """Return the rates of the angle of a node about the axis of a cylinder and of its distance from the axis."""
    swept, v, V = np.empty(3), np.empty(3), np.empty(3)
    cylinder = work.markers[c]
    cross(cylinder.w, d[0], swept)
    for i in range(3):
        v[i] = moving[i] - cylinder.v[i] - swept[i]
    matvec_t(cylinder.R, v, V)
    rho2 = d[1, 0] ** 2 + d[1, 1] ** 2
    return (d[1, 0] * V[1] - d[1, 1] * V[0]) / rho2, (d[1, 0] * V[0] + d[1, 1] * V[1]) / rho2**0.5


@inner_kernel
def _speeds(row, state, work, places, pieces, count, more, v):
    """Write the velocities of all nodes; places between cylinders do not count their motion along the line."""
    n = row.n
    for k in range(n):
        v[k] = work.markers[row.markers[k]].v
    if more == 0:
        return
    size = 6 * (n + more)
    whole, follows = np.zeros((size, size)), np.empty((3 * more, 6 * n))
    _turning(row, state, work, places, pieces, count, 1.0, whole)
    _follow(n, more, whole, follows)
    for a in range(3 * more):
        x = 0.0
        for k in range(n):
            marker = work.markers[row.markers[k]]
            for i in range(3):
                x += follows[a, 6 * k + i] * marker.v[i] + follows[a, 6 * k + 3 + i] * marker.w[i]
        v[n + a // 3, a % 3] = x


@kernel
def write_kinks(row, state, work, out, first):
    """Write from row `first` of `out` where the way begins to touch its cylinders; return the row behind."""
    if row.cylinders == 0:
        return first
    places, pieces, v = np.empty((2 * MOST, 3)), np.empty((MOST, 3), np.int64), np.empty((2 * MOST, 3))
    dp, ds = np.empty((2, 3)), np.empty((2, 3))
    count, more = _divide(row, state, work, places, pieces)
    if count == 0:
        for m in range(row.cylinders):
            out[first + m, 0] = IDLE
        return first + row.cylinders
    _speeds(row, state, work, places, pieces, count, more, v)
    for m in range(count):
        piece = pieces[m]
        c = piece[1]
        if c < 0:
            continue
        r = abs(row.radii[c])
        kink = out[first]
        kink[:] = 0.0
        kink[0], kink[8], kink[9] = KINK, 1.0, 1.0
        kink[1] = _contact(row, piece, places, state, work, dp, ds)
        turn_p, away_p = _angle_rate(work, row.markers[c], v[piece[0]], dp)
        turn_s, away_s = _angle_rate(work, row.markers[c], v[piece[2]], ds)
        rate = (1.0 if row.radii[c] > 0.0 else -1.0) * (turn_s - turn_p)
        for side in range(2):
            x, away = (dp[1], away_p) if side == 0 else (ds[1], away_s)
            rho = (x[0] ** 2 + x[1] ** 2) ** 0.5
            rate -= r * away / (rho * (rho * rho - r * r) ** 0.5)
        kink[4] = rate
        first += 1
    return first
