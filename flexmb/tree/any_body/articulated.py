"""Pass one of the recursion: articulated inertias from the leaves to the roots.

Coordinates of a body are the rate V of the twist of its own marker C, in W, and its modal accelerations. For C and the
marker Q of the parent, with the joint's free motions N::

    V = Sh(C - Q) J_Q a_parent + c + N x,      W = P V - p (wrench of the joint),      N^T W = 0

Flexible coordinates are eliminated body by body, so each step costs the size of one body (Banerjee 1993, eqs. 50-72, in
absolute velocities; rigid: Featherstone 2008, ch. 7).
"""

from __future__ import annotations

import numpy as np

from flexmb.math.kernel import inner_kernel, kernel
from flexmb.tree.any_body.blocks import invert_block, shift_inertia
from flexmb.tree.any_body.joint_basis import joint_basis, velocity_terms
from flexmb.tree.any_body.modes import add_to_modes, eliminate_modes, own_modes

__all__ = ["factor"]

SINGULAR = 1e-15
"""Inertia of a free motion below this, relative to the largest mass or moment of the articulated inertia, counts as
none."""


@inner_kernel
def _axes(row, q, at):
    """Write the rotation matrix of Euler parameters (scalar first) at q[at]."""
    a, b, c, d = q[at], q[at + 1], q[at + 2], q[at + 3]
    row.R[0, 0] = 1.0 - 2.0 * (c * c + d * d)
    row.R[0, 1] = 2.0 * (b * c - a * d)
    row.R[0, 2] = 2.0 * (b * d + a * c)
    row.R[1, 0] = 2.0 * (b * c + a * d)
    row.R[1, 1] = 1.0 - 2.0 * (b * b + d * d)
    row.R[1, 2] = 2.0 * (c * d - a * b)
    row.R[2, 0] = 2.0 * (b * d - a * c)
    row.R[2, 1] = 2.0 * (c * d + a * b)
    row.R[2, 2] = 1.0 - 2.0 * (b * b + c * c)


@inner_kernel
def _ten_numbers(S, rows, iu, J):
    """Write the inertia about the origin to `J` (9,) and return mass and first moment, all in the body's own axes.

    They stand in the block of the body's frame, ``[m 1, -h~; h~, J]``: of a body that deforms, for its present shape.
    """
    for i in range(3):
        at = rows[iu + 3 + i] + 3
        for j in range(3):
            J[3 * i + j] = S[at + j]
    return S[rows[iu]], S[rows[iu + 5] + 1], S[rows[iu + 3] + 2], S[rows[iu + 4]]


@inner_kernel
def _turn(R, J):
    """Replace J (9,) by R J R^T; the nine numbers behind it are scratch."""
    for i in range(3):
        x, y, z = J[3 * i], J[3 * i + 1], J[3 * i + 2]
        for j in range(3):
            J[9 + 3 * i + j] = x * R[j, 0] + y * R[j, 1] + z * R[j, 2]
    for i in range(3):
        x, y, z = R[i, 0], R[i, 1], R[i, 2]
        for j in range(3):
            J[3 * i + j] = x * J[9 + j] + y * J[12 + j] + z * J[15 + j]


@inner_kernel
def _own_inertia(row, q, iq, iu, outer, markers, S, rows, J):
    """Write the body's own inertia at its marker C, eq. (tree-own): ten numbers, mass, first moment and inertia.

    With the lever s from the origin to C and the first moment h in W: ``h_C = h - m s`` and
    ``J_C = J + (m s.s - 2 h.s) 1 + h s^T + s h^T - m s s^T``.
    """
    _axes(row, q, iq + 3)
    R, P, lever = row.R, row.P, row.lever
    m, a, b, c = _ten_numbers(S, rows, iu, J)
    _turn(R, J)
    C = markers[outer]
    hs, ss = 0.0, 0.0
    for i in range(3):
        s = C.r[i] - q[iq + i]
        h = R[i, 0] * a + R[i, 1] * b + R[i, 2] * c
        lever[i], J[9 + i] = s, h
        hs += h * s
        ss += s * s
    for i in range(3):
        for j in range(3):
            s, t = lever[i], lever[j]
            P[i, j] = 0.0
            P[3 + i, 3 + j] = J[3 * i + j] + J[9 + i] * t + s * J[9 + j] - m * s * t
        P[i, i] = m
        P[3 + i, 3 + i] += m * ss - 2.0 * hs
    x, y, z = J[9] - m * lever[0], J[10] - m * lever[1], J[11] - m * lever[2]
    P[0, 3], P[0, 4], P[0, 5] = 0.0, z, -y
    P[1, 3], P[1, 4], P[1, 5] = -z, 0.0, x
    P[2, 3], P[2, 4], P[2, 5] = y, -x, 0.0
    P[3, 0], P[3, 1], P[3, 2] = 0.0, -z, y
    P[4, 0], P[4, 1], P[4, 2] = z, 0.0, -x
    P[5, 0], P[5, 1], P[5, 2] = -y, x, 0.0


@inner_kernel
def _usual(N, P):
    """Return the inertia that a motion N (6,) would have by the largest mass and the largest moment of P (6, 6)."""
    mass, moment, along, about = 0.0, 0.0, 0.0, 0.0
    for i in range(3):
        mass, moment = max(mass, abs(P[i, i])), max(moment, abs(P[3 + i, 3 + i]))
        along, about = along + N[i] * N[i], about + N[3 + i] * N[3 + i]
    return mass * along + moment * about


@inner_kernel
def _open_hinge(row, through):
    """Write what `_open_joint` writes, for one free motion, the most frequent case."""
    N, P = row.way[5], row.P
    D = 0.0
    for i in range(6):
        x, y = 0.0, 0.0
        for j in range(6):
            n = N[j]
            x += P[i, j] * n
            y += P[j, i] * n
        row.U[0, i], row.gain[0, i] = x, y
        D += N[i] * x
    if not abs(D) > SINGULAR * _usual(N, P):
        return False
    D = 1.0 / D
    row.D[0] = D
    for i in range(6):
        x = row.U[0, i] * D
        row.U[0, i] = x
        for j in range(6):
            through[6 * i + j] = P[i, j] - x * row.gain[0, j]
    for i in range(6):
        row.gain[0, i] *= D
    return True


@inner_kernel
def _open_joint(row, through, scratch, pivots):
    """Write D, U, gain and what the body transmits, eq. (tree-open); False if a free motion has no inertia."""
    nf = row.free
    if nf == 1:
        return _open_hinge(row, through)
    first, P = 6 - nf, row.P
    least = np.inf  # masses and moments with their like: of a micrometre moments are a 1e-12 of masses
    E, column = scratch[0:6], scratch[6]
    for f in range(nf):
        least = min(least, SINGULAR * _usual(row.way[first + f], P))
        for i in range(6):
            x, y = 0.0, 0.0
            for j in range(6):
                x += P[i, j] * row.way[first + f, j]
                y += P[j, i] * row.way[first + f, j]
            row.U[f, i] = x
            row.gain[f, i] = y
    for f in range(nf):
        for e in range(nf):
            x = 0.0
            for i in range(6):
                x += row.way[first + f, i] * row.U[e, i]
            E[f, e] = x
    if nf > 1 and not invert_block(E, nf, pivots, column, least, row.D, 0):
        return False
    for i in range(6):
        for j in range(6):
            through[6 * i + j] = P[i, j]
    for j in range(6):
        for f in range(nf):
            column[f] = row.gain[f, j]
        for f in range(nf):
            x = 0.0
            for e in range(nf):
                x += row.D[nf * f + e] * column[e]
            row.gain[f, j] = x
            for i in range(6):
                through[6 * i + j] -= row.U[f, i] * x
    for i in range(6):
        for f in range(nf):
            column[f] = row.U[f, i]
        for f in range(nf):
            x = 0.0
            for e in range(nf):
                x += column[e] * row.D[nf * e + f]
            row.U[f, i] = x
    return True


@inner_kernel
def _invert_plain(n, iu, at, work, store, pivots):
    """Write the inverse of the mass matrix of a body without a frame."""
    M = np.empty((n, n))
    for i in range(n):
        for j in range(n):
            M[i, j] = work.S[work.rows[iu + i] + j]
    return invert_block(M, n, pivots, np.empty(n), 1e-300, store.plain, at)


@kernel
def factor(tables, state, work, store):
    """Factorise the tree; the workspace holds an evaluation with unit weight of the mass. See store.failed."""
    failed, scratch = store.failed, store.scratch
    through, half = scratch[7], np.empty(36)
    pivots = np.empty(scratch.shape[1], np.int64)
    n = len(tables.iu)
    for k in range(n):
        if tables.outer[k] < 0:
            continue
        row, iu = store.rows[k], tables.iu[k]
        _own_inertia(row, state.q, tables.iq[k], iu, tables.outer[k], work.markers, work.S, work.rows, half)
        m = tables.i_eta[k + 1] - tables.i_eta[k]
        if m > 0:
            own_modes(row, m, tables.i_modal[k], iu, tables.outer[k], work, store)
        if tables.parent[k] >= 0:
            a, b = work.markers[tables.outer[k]], work.markers[tables.outer[tables.parent[k]]]
            for i in range(3):
                row.step[i] = a.r[i] - b.r[i]
    for k in range(n - 1, -1, -1):
        failed[0], failed[1] = k, 1
        outer, first, last = tables.outer[k], tables.start_equation[k], tables.start_equation[k + 1]
        if outer < 0:
            if not _invert_plain(tables.nu[k], tables.iu[k], tables.i_plain[k], work, store, pivots):
                return
            continue
        row = store.rows[k]
        m = tables.i_eta[k + 1] - tables.i_eta[k]
        if m > 0 and not eliminate_modes(row, m, tables.i_modal[k], tables.i_eta[k], store, scratch[6]):
            return
        if not joint_basis(row, tables.equations, first, last, outer, work.equations, work.legs, half):
            failed[1] = 2
            return
        if not _open_joint(row, through, scratch, pivots):
            return
        velocity_terms(row, tables.equations, first, last, outer, tables.inner[k], work.equations, work.markers, half)
        for i in range(6):
            x = 0.0
            for j in range(6):
                x += through[6 * i + j] * row.bias[j]
            row.drop[i] = x
        p = tables.parent[k]
        if p < 0:
            continue
        m = tables.i_eta[p + 1] - tables.i_eta[p]
        if m > 0:
            add_to_modes(
                row,
                through,
                m,
                tables.i_modal[p],
                tables.i_parent[k],
                outer,
                tables.inner[k],
                work,
                store,
                scratch,
                half,
            )
        shift_inertia(through, row.step[0], row.step[1], row.step[2])
        of_parent = store.rows[p]
        for i in range(6):
            for j in range(6):
                of_parent.P[i, j] += through[6 * i + j]
    failed[0] = -1
