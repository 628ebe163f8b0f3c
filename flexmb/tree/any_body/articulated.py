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
from flexmb.tree.any_body.store import AXES, DROP, FREE, GAIN, INVERSE, LEVER, SPEED, STEP, WAY, P, U

__all__ = ["factor"]

SINGULAR = 1e-15
"""Inertia of a free motion below this, relative to the largest entry of the articulated inertia, counts as none."""


@inner_kernel
def _axes(row, q, at):
    """Write the rotation matrix of Euler parameters (scalar first) at q[at]."""
    a, b, c, d = q[at], q[at + 1], q[at + 2], q[at + 3]
    row[AXES] = 1.0 - 2.0 * (c * c + d * d)
    row[AXES + 1] = 2.0 * (b * c - a * d)
    row[AXES + 2] = 2.0 * (b * d + a * c)
    row[AXES + 3] = 2.0 * (b * c + a * d)
    row[AXES + 4] = 1.0 - 2.0 * (b * b + d * d)
    row[AXES + 5] = 2.0 * (c * d - a * b)
    row[AXES + 6] = 2.0 * (b * d - a * c)
    row[AXES + 7] = 2.0 * (c * d + a * b)
    row[AXES + 8] = 1.0 - 2.0 * (b * b + c * c)


@inner_kernel
def _turned_inertia(row, S, rows, iu, J):
    """Write R J R^T to `J` (9,), the inertia about the body's origin;
    its own axes stand in the lower right block of S.
    """
    for i in range(3):
        at = rows[iu + 3 + i] + 3
        x, y, z = S[at], S[at + 1], S[at + 2]
        for j in range(3):
            r = AXES + 3 * j
            J[9 + 3 * i + j] = x * row[r] + y * row[r + 1] + z * row[r + 2]
    for i in range(3):
        r = AXES + 3 * i
        x, y, z = row[r], row[r + 1], row[r + 2]
        for j in range(3):
            J[3 * i + j] = x * J[9 + j] + y * J[12 + j] + z * J[15 + j]


@inner_kernel
def _own_inertia(row, q, iq, iu, outer, markers, S, rows, J):
    """Write the body's own inertia at its marker C, eq. (tree-own): ten numbers, mass, first moment and inertia.

    With the lever s from the origin to C and the first moment h in W: ``h_C = h - m s`` and
    ``J_C = J + (m s.s - 2 h.s) 1 + h s^T + s h^T - m s s^T``.
    """
    _axes(row, q, iq + 3)
    _turned_inertia(row, S, rows, iu, J)
    C, m = markers[outer], S[rows[iu]]
    # the lower left block of S is m c~
    a, b, c = S[rows[iu + 5] + 1], S[rows[iu + 3] + 2], S[rows[iu + 4]]
    hs, ss = 0.0, 0.0
    for i in range(3):
        r, s = AXES + 3 * i, C.r[i] - q[iq + i]
        h = row[r] * a + row[r + 1] * b + row[r + 2] * c
        row[LEVER + i], J[9 + i] = s, h
        hs += h * s
        ss += s * s
    for i in range(3):
        for j in range(3):
            s, t = row[LEVER + i], row[LEVER + j]
            row[P + 6 * i + j] = 0.0
            row[P + 6 * (3 + i) + 3 + j] = J[3 * i + j] + J[9 + i] * t + s * J[9 + j] - m * s * t
        row[P + 7 * i] = m
        row[P + 7 * (3 + i)] += m * ss - 2.0 * hs
    x, y, z = J[9] - m * row[LEVER], J[10] - m * row[LEVER + 1], J[11] - m * row[LEVER + 2]
    row[P + 3], row[P + 4], row[P + 5] = 0.0, z, -y
    row[P + 9], row[P + 10], row[P + 11] = -z, 0.0, x
    row[P + 15], row[P + 16], row[P + 17] = y, -x, 0.0
    row[P + 18], row[P + 19], row[P + 20] = 0.0, -z, y
    row[P + 24], row[P + 25], row[P + 26] = z, 0.0, -x
    row[P + 30], row[P + 31], row[P + 32] = -y, x, 0.0


@inner_kernel
def _open_hinge(row, through):
    """Write what `_open_joint` writes, for one free motion, the most frequent case."""
    way = WAY + 30
    D, largest = 0.0, 0.0
    for i in range(6):
        x, y = 0.0, 0.0
        for j in range(6):
            n = row[way + j]
            x += row[P + 6 * i + j] * n
            y += row[P + 6 * j + i] * n
        row[U + i], row[GAIN + i] = x, y
        D += row[way + i] * x
        largest = max(largest, abs(row[P + 7 * i]))
    if not abs(D) > SINGULAR * largest:
        return False
    D = 1.0 / D
    row[INVERSE] = D
    for i in range(6):
        x = row[U + i] * D
        row[U + i] = x
        for j in range(6):
            through[6 * i + j] = row[P + 6 * i + j] - x * row[GAIN + j]
    for i in range(6):
        row[GAIN + i] *= D
    return True


@inner_kernel
def _open_joint(row, through, scratch, pivots):
    """Write D, U, GAIN and what the body transmits, eq. (tree-open); False if a free motion has no inertia."""
    nf = int(row[FREE])
    if nf == 1:
        return _open_hinge(row, through)
    way = WAY + 6 * (6 - nf)
    largest = 0.0
    for i in range(6):
        largest = max(largest, abs(row[P + 7 * i]))
    E, column = scratch[0:6], scratch[6]
    for f in range(nf):
        for i in range(6):
            x, y = 0.0, 0.0
            for j in range(6):
                x += row[P + 6 * i + j] * row[way + 6 * f + j]
                y += row[P + 6 * j + i] * row[way + 6 * f + j]
            row[U + 6 * f + i] = x
            row[GAIN + 6 * f + i] = y
    for f in range(nf):
        for e in range(nf):
            x = 0.0
            for i in range(6):
                x += row[way + 6 * f + i] * row[U + 6 * e + i]
            E[f, e] = x
    if nf > 1 and not invert_block(E, nf, pivots, column, SINGULAR * largest, row, INVERSE):
        return False
    for i in range(36):
        through[i] = row[P + i]
    for j in range(6):
        for f in range(nf):
            column[f] = row[GAIN + 6 * f + j]
        for f in range(nf):
            x = 0.0
            for e in range(nf):
                x += row[INVERSE + nf * f + e] * column[e]
            row[GAIN + 6 * f + j] = x
            for i in range(6):
                through[6 * i + j] -= row[U + 6 * f + i] * x
    for i in range(6):
        for f in range(nf):
            column[f] = row[U + 6 * f + i]
        for f in range(nf):
            x = 0.0
            for e in range(nf):
                x += column[e] * row[INVERSE + nf * e + f]
            row[U + 6 * f + i] = x
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
                row[STEP + i] = a.r[i] - b.r[i]
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
                x += through[6 * i + j] * row[SPEED + j]
            row[DROP + i] = x
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
        shift_inertia(through, 0, row[STEP], row[STEP + 1], row[STEP + 2])
        of_parent = store.rows[p]
        for i in range(36):
            of_parent[P + i] += through[i]
    failed[0] = -1
