"""Pass one of the recursion: articulated inertias from the leaves to the roots.

Coordinates of a body are the rate V of the twist of its own marker C, in W, and its modal accelerations. For C and the
marker Q of the parent, with the joint's free motions N::

    V = Sh(C - Q) J_Q a_parent + c + N x,      W = P V - p (wrench of the joint),      N^T W = 0

Flexible coordinates are eliminated body by body, so each step costs the size of one body (Banerjee 1993, eqs. 50-72, in
absolute velocities; rigid: Featherstone 2008, ch. 7).
"""

from __future__ import annotations

import numpy as np

from flexmb.math.kernel import kernel
from flexmb.tree.blocks import invert_block, shift_inertia
from flexmb.tree.joint_basis import joint_basis, velocity_terms
from flexmb.tree.modes import add_to_modes, eliminate_modes, own_modes
from flexmb.tree.store import AXES, DROP, FREE, GAIN, INVERSE, LEVER, SPEED, STEP, WAY, P, U

__all__ = ["factor"]

SINGULAR = 1e-15
"""Inertia of a free motion below this, relative to the largest entry of the articulated inertia, counts as none."""


@kernel
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


@kernel
def _turned_block(row, S, rows, first, a, b, half):
    """Write R B R^T to the block (a, b) of P; B is that part of the body's own block in S."""
    for i in range(3):
        at = rows[first + a + i] + b
        x, y, z = S[at], S[at + 1], S[at + 2]
        for j in range(3):
            r = AXES + 3 * j
            half[3 * i + j] = x * row[r] + y * row[r + 1] + z * row[r + 2]
    for i in range(3):
        r = AXES + 3 * i
        x, y, z = row[r], row[r + 1], row[r + 2]
        for j in range(3):
            row[P + 6 * (a + i) + b + j] = x * half[j] + y * half[3 + j] + z * half[6 + j]


@kernel
def _own_inertia(row, q, iq, iu, outer, markers, S, rows, half):
    """Write the body's own inertia at its marker C, eq. (tree-own)."""
    _axes(row, q, iq + 3)
    C = markers[outer]
    for i in range(3):
        row[LEVER + i] = C.r[i] - q[iq + i]
    _turned_block(row, S, rows, iu, 0, 0, half)
    _turned_block(row, S, rows, iu, 0, 3, half)
    _turned_block(row, S, rows, iu, 3, 0, half)
    _turned_block(row, S, rows, iu, 3, 3, half)
    shift_inertia(row, P, -row[LEVER], -row[LEVER + 1], -row[LEVER + 2])


@kernel
def _open_joint(row, through, scratch, pivots):
    """Write D, U, GAIN and what the body transmits, eq. (tree-open); False if a free motion has no inertia."""
    nf = int(row[FREE])
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
    if nf == 1:
        if not abs(E[0, 0]) > SINGULAR * largest:
            return False
        row[INVERSE] = 1.0 / E[0, 0]
    elif nf > 1 and not invert_block(E, nf, pivots, column, SINGULAR * largest, row, INVERSE):
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


@kernel
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
            add_to_modes(row, through, m, tables.i_modal[p], tables.i_parent[k], outer, tables.inner[k], work, store,
                         scratch, half)
        shift_inertia(through, 0, row[STEP], row[STEP + 1], row[STEP + 2])
        of_parent = store.rows[p]
        for i in range(36):
            of_parent[P + i] += through[i]
    failed[0] = -1
