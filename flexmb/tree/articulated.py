"""Pass one of the recursion: articulated inertias from the leaves to the roots.

Coordinates of a body are the rate of the twist V of its own marker C, in W, and its modal accelerations. For C and the
parent's marker P, with the joint's free motions N and multipliers::

    V = Sh(C - P) (J_P a_parent) + c + N x,      W = P V - p (wrench of the joint),      N^T W = 0

Flexible coordinates are eliminated body by body, so each step costs the size of one body (Banerjee 1993, eqs. 50-72, in
absolute velocities; rigid: Featherstone 2008, ch. 7). With geometric stiffness by interface loads, wrenches also act on
the modal rows: J then differs between rows and columns (by work.H), and inertias are not symmetric.
"""

from __future__ import annotations

import numpy as np

from flexmb.math.kernel import kernel
from flexmb.math.rotations import euler_to_matrix
from flexmb.tree.blocks import factor_block, invert_block, shift_inertia, solve_block, turn_block
from flexmb.tree.joint_basis import joint_basis, velocity_terms
from flexmb.tree.store import modal_views

__all__ = ["factor"]

SINGULAR = 1e-15
"""Inertia of a free motion below this, relative to the largest entry of the articulated inertia, counts as none."""


@kernel
def _own_inertia(tables, k, state, work, store, half, back):
    """Write the body's own inertia at its marker C, eq. (tree-own), and its coupling with the modes."""
    iu, iq = tables.iu[k], tables.iq[k]
    R, P, s = store.R[k], store.P[k], store.lever[k]
    C = work.markers[tables.outer[k]]
    euler_to_matrix(state.q[iq + 3 : iq + 7], R)
    for i in range(3):
        s[i] = C.r[i] - state.q[iq + i]
        back[i] = -s[i]
    for a in (0, 3):
        for b in (0, 3):
            turn_block(work.S, work.rows, iu, a, b, R, half, P)
    shift_inertia(P, back)
    if tables.i_eta[k + 1] > tables.i_eta[k]:
        _own_modes(tables, k, work, store)
    parent = tables.parent[k]
    if parent >= 0:
        other = work.markers[tables.outer[parent]]
        for i in range(3):
            store.step[k, i] = C.r[i] - other.r[i]


@kernel
def _own_modes(tables, k, work, store):
    """Write modal block and couplings in the coordinates (V, eta''): frame accelerations are Sh(-s) (V - Jc eta'')."""
    K, right, left, Jc, Jr = modal_views(tables, store, k)
    m, iu = K.shape[0], tables.iu[k]
    P, R, s = store.P[k], store.R[k], store.lever[k]
    C = work.markers[tables.outer[k]]
    for j in range(m):
        for i in range(6):
            x = work.J[C.iJ + i * C.nu + 6 + j]
            Jc[i, j] = x
            Jr[i, j] = x - (work.H[C.iH + i * C.nu + 6 + j] if C.iH >= 0 else 0.0)
        at = work.rows[iu + 6 + j]
        for i in range(m):
            K[j, i] = work.S[at + 6 + i]
        for i in range(3):
            x, y = 0.0, 0.0
            u, v = 0.0, 0.0
            for a in range(3):
                x += R[i, a] * work.S[work.rows[iu + a] + 6 + j]
                y += R[i, a] * work.S[work.rows[iu + 3 + a] + 6 + j]
                u += R[i, a] * work.S[at + a]
                v += R[i, a] * work.S[at + 3 + a]
            right[i, j], right[3 + i, j] = x, y
            left[j, i], left[j, 3 + i] = u, v
        for i in range(3):  # from the origin to C: Sh(-s)^T
            a, b = (i + 1) % 3, (i + 2) % 3
            right[3 + i, j] -= s[a] * right[b, j] - s[b] * right[a, j]
            left[j, 3 + i] -= s[a] * left[j, b] - s[b] * left[j, a]
    for j in range(m):
        for i in range(m):
            x = 0.0
            for a in range(6):
                x += left[j, a] * Jc[a, i]
            K[j, i] -= x
    for i in range(6):
        for j in range(m):
            x = 0.0
            for a in range(6):
                x += P[i, a] * Jc[a, j]
            right[i, j] -= x
    for j in range(m):
        for i in range(m):
            x = 0.0
            for a in range(6):
                x += Jr[a, j] * right[a, i]
            K[j, i] -= x
        for i in range(6):
            x = 0.0
            for a in range(6):
                x += Jr[a, j] * P[a, i]
            left[j, i] -= x


@kernel
def _eliminate_modes(tables, k, store, column):
    """Factorise the modal block, replace the coupling (m, 6) by K^-1 times it and P by its Schur complement."""
    K, right, left, _, _ = modal_views(tables, store, k)
    m = K.shape[0]
    P = store.P[k]
    pivots = store.pivots[tables.i_eta[k] : tables.i_eta[k + 1]]
    if not factor_block(K, m, pivots, 1e-300):
        return False
    for j in range(6):
        for i in range(m):
            column[i] = left[i, j]
        solve_block(K, m, pivots, column)
        for i in range(m):
            left[i, j] = column[i]
    for i in range(6):
        for j in range(6):
            x = 0.0
            for a in range(m):
                x += right[i, a] * left[a, j]
            P[i, j] -= x
    return True


@kernel
def _open_joint(k, store, NP, E, pivots, column):
    """Write D, U, K and what the body transmits, eq. (tree-open); False if a free motion has no inertia."""
    nf = store.free[k]
    ne = 6 - nf
    P, Q, D, U, K, through = store.P[k], store.basis[k], store.D[k], store.U[k], store.K[k], store.through[k]
    largest = 0.0
    for i in range(6):
        largest = max(largest, abs(P[i, i]))
        for j in range(6):
            through[i, j] = P[i, j]
    if nf == 0:
        return True
    for f in range(nf):
        for j in range(6):
            NP[f, j] = 0.0
        for i in range(6):
            x = Q[i, ne + f]
            if x != 0.0:
                for j in range(6):
                    NP[f, j] += x * P[i, j]
        for e in range(nf):
            x = 0.0
            for j in range(6):
                x += NP[f, j] * Q[j, ne + e]
            E[f, e] = x
    if not invert_block(E, nf, pivots, column, SINGULAR * largest, D):
        return False
    for f in range(nf):
        for j in range(6):
            x = 0.0
            for e in range(nf):
                x += D[f, e] * NP[e, j]
            K[f, j] = x
    for i in range(6):
        for e in range(nf):
            x = 0.0
            for j in range(6):
                x += P[i, j] * Q[j, ne + e]
            E[0, e] = x
        for f in range(nf):
            x = 0.0
            for e in range(nf):
                x += E[0, e] * D[e, f]
            U[i, f] = x
            y = E[0, f]
            for j in range(6):
                through[i, j] -= y * K[f, j]
    return True


@kernel
def _pass_to_modes(tables, k, p, work, store, moved, product):
    """Add what body k transmits to the modes of its parent p: E = Sh J_P - Sh J_C of the parent."""
    _, right, left, Jc, Jr = modal_views(tables, store, p)
    K = modal_views(tables, store, p)[0]
    m = K.shape[0]
    through, d = store.through[k], store.step[k]
    a = tables.i_parent[k]
    E = store.parent[a : a + 6 * m].reshape((6, m))
    Er = store.parent[a + 6 * m : a + 12 * m].reshape((6, m))
    C, P = work.markers[tables.outer[k]], work.markers[tables.inner[k]]
    for j in range(m):
        for i in range(6):
            x = work.J[P.iJ + i * P.nu + 6 + j]
            E[i, j] = x
            Er[i, j] = x - (work.H[P.iH + i * P.nu + 6 + j] if P.iH >= 0 else 0.0)
        for i in range(3):
            b, c = (i + 1) % 3, (i + 2) % 3
            y, z = C.r[b] - P.r[b], C.r[c] - P.r[c]
            E[i, j] += E[3 + b, j] * z - E[3 + c, j] * y
            Er[i, j] += Er[3 + b, j] * z - Er[3 + c, j] * y
        for i in range(3):
            b, c = (i + 1) % 3, (i + 2) % 3
            E[i, j] -= Jc[i, j] + Jc[3 + b, j] * d[c] - Jc[3 + c, j] * d[b]
            Er[i, j] -= Jr[i, j] + Jr[3 + b, j] * d[c] - Jr[3 + c, j] * d[b]
        for i in range(3, 6):
            E[i, j] -= Jc[i, j]
            Er[i, j] -= Jr[i, j]
    for i in range(6):
        for j in range(m):
            x = 0.0
            for b in range(6):
                x += through[i, b] * E[b, j]
            product[i, j] = x
    for j in range(m):
        for i in range(m):
            x = 0.0
            for b in range(6):
                x += Er[b, j] * product[b, i]
            K[j, i] += x
    _add_couplings(through, d, E, Er, product, right, left, moved)


@kernel
def _add_couplings(through, d, E, Er, product, right, left, moved):
    """Add Sh^T (through E) to `right` and Er^T (through Sh) to `left`."""
    for i in range(6):
        for j in range(6):
            moved[i, j] = through[i, j]
        for j in range(3):
            b, c = (j + 1) % 3, (j + 2) % 3
            moved[i, 3 + j] += d[b] * through[i, c] - d[c] * through[i, b]
    for j in range(E.shape[1]):
        for i in range(6):
            right[i, j] += product[i, j]
            x = 0.0
            for b in range(6):
                x += Er[b, j] * moved[b, i]
            left[j, i] += x
        for i in range(3):
            b, c = (i + 1) % 3, (i + 2) % 3
            right[3 + i, j] += d[b] * product[c, j] - d[c] * product[b, j]


@kernel
def _invert_plain(tables, k, work, store, pivots):
    """Write the inverse of the mass matrix of a body without a frame."""
    n, iu = tables.nu[k], tables.iu[k]
    out = store.plain[tables.i_plain[k] : tables.i_plain[k + 1]].reshape((n, n))
    M = np.empty((n, n))
    for i in range(n):
        for j in range(n):
            M[i, j] = work.S[work.rows[iu + i] + j]
    return invert_block(M, n, pivots, np.empty(n), 1e-300, out)


@kernel
def factor(tables, state, work, store):
    """Factorise the tree; the workspace holds an evaluation with unit weight of the mass. See store.failed."""
    n = len(tables.iu)
    store.failed[:] = -1
    NP, E = np.empty((6, 6)), np.empty((6, 6))
    scratch = store.scratch
    pivots = np.empty(scratch.shape[1], np.int64)
    for k in range(n):
        if tables.outer[k] >= 0:
            _own_inertia(tables, k, state, work, store, NP[0:3, 0:3], E[0])
    for k in range(n - 1, -1, -1):
        store.failed[0] = k
        store.failed[1] = 1
        if tables.outer[k] < 0:
            if not _invert_plain(tables, k, work, store, pivots):
                return
            continue
        if tables.i_eta[k + 1] > tables.i_eta[k] and not _eliminate_modes(tables, k, store, scratch[0]):
            return
        if not joint_basis(tables, k, work, store, scratch[0], scratch[1]):
            store.failed[1] = 2
            return
        if not _open_joint(k, store, NP, E, pivots, scratch[0]):
            return
        velocity_terms(tables, k, work, store, scratch[0])
        through, c = store.through[k], store.c[k]
        for i in range(6):
            x = 0.0
            for j in range(6):
                x += through[i, j] * c[j]
            store.drop[k, i] = x
        p = tables.parent[k]
        if p < 0:
            continue
        if tables.i_eta[p + 1] > tables.i_eta[p]:
            _pass_to_modes(tables, k, p, work, store, NP, scratch)
        shift_inertia(through, store.step[k])
        P = store.P[p]
        for i in range(6):
            for j in range(6):
                P[i, j] += through[i, j]
    store.failed[:] = -1
