"""The three passes of the recursion: articulated inertias from the leaves, forces from the leaves, accelerations from the
roots. Cost linear in the number of bodies.

For a body with the tree joint's marker C and the parent's marker P, accelerations of the markers (6, in W) obey::

    V = X J_P a_parent + c + N x,      V = J_C a,      wrench on C: W = J_C^-T (M a - f),      N^T W = 0

N spans the motions which the joint's equations leave free (null space of their gradient at C), X moves a twist from P to
C, c collects the quadratic velocity terms. Flexible coordinates are eliminated body by body, so each step costs the size
of one body (Banerjee 1993, eqs. 50-72, in absolute velocities; rigid: Featherstone 2008, ch. 7). With geometric stiffness
by interface loads, wrenches also act on the modal rows: J_C and J_P then differ between rows and columns (H).
"""

from __future__ import annotations

from collections import namedtuple

import numpy as np

from flexmb.math.kernel import kernel

__all__ = ["Store", "factor", "new_store", "solve"]

Store = namedtuple("Store", "mass modal parent T free basis P D U c triangle force V wrench failed")
"""Numbers of the recursion between its passes.

mass : mass matrices, with the articulated children; modal: inverse of the modal block and both couplings; parent: X J_P
T (nb, 6, 6) : inverse of the frame part of J_C; free (nb,): free motions of the joint; basis (nb, 6, 6): equations'
directions first, then N; P, D, U : articulated inertia, inverse of N^T P N, P N D; c (nb, 6): velocity terms
triangle (nb, 6, 6) : triangular factor of the equations; force (nu,), V, wrench (nb, 6)
failed (1,) : place of a body whose articulated inertia is singular, or -1
"""


def new_store(tables, n_velocities: int) -> Store:
    """Return storage for a tree."""
    n = len(tables.iu)
    six = (n, 6, 6)
    return Store(np.zeros(tables.i_mass[-1]), np.zeros(max(1, tables.i_modal[-1])),
                 np.zeros(max(1, tables.i_parent[-1])), np.zeros(six), np.zeros(n, np.int64), np.zeros(six), np.zeros(six),
                 np.zeros(six), np.zeros(six), np.zeros((n, 6)), np.zeros(six), np.zeros(n_velocities),
                 np.zeros((n, 6)), np.zeros((n, 6)), np.full(1, -1, np.int64))


@kernel
def invert(A, n, out):
    """Write the inverse of the leading (n, n) part of `A` to `out` (Gauss-Jordan, partial pivoting); False if singular."""
    work = np.empty((n, 2 * n))
    for i in range(n):
        for j in range(n):
            work[i, j] = A[i, j]
            work[i, n + j] = 1.0 if i == j else 0.0
    for k in range(n):
        p = k
        for i in range(k + 1, n):
            if abs(work[i, k]) > abs(work[p, k]):
                p = i
        if not abs(work[p, k]) > 1e-300:
            return False
        for j in range(2 * n):
            x = work[k, j]
            work[k, j] = work[p, j]
            work[p, j] = x
        f = 1.0 / work[k, k]
        for j in range(2 * n):
            work[k, j] *= f
        for i in range(n):
            if i != k and work[i, k] != 0.0:
                f = work[i, k]
                for j in range(2 * n):
                    work[i, j] -= f * work[k, j]
    for i in range(n):
        for j in range(n):
            out[i, j] = work[i, n + j]
    return True


@kernel
def _joint_basis(tables, k, work, store):
    """Orthogonalise the gradients of the joint's equations at C: directions, triangular factor, and the rest, N."""
    Q, R = store.basis[k], store.triangle[k]
    first, last = tables.start_equation[k], tables.start_equation[k + 1]
    ne = last - first
    R[:] = 0.0
    for j in range(ne):
        equation = work.equations[tables.equations[first + j]]
        row = np.zeros(6)
        for leg in range(equation.leg, equation.leg + equation.legs):
            if work.legs[leg].marker == tables.outer[k]:
                for i in range(6):
                    row[i] += work.legs[leg].gradient[i]
        for _ in range(2):
            for i in range(j):
                s = 0.0
                for m in range(6):
                    s += Q[m, i] * row[m]
                R[i, j] += s
                for m in range(6):
                    row[m] -= s * Q[m, i]
        length = 0.0
        for m in range(6):
            length += row[m] * row[m]
        length = length**0.5
        R[j, j] = length
        for m in range(6):
            Q[m, j] = row[m] / length if length > 1e-12 else 0.0
    found = ne
    for e in range(6):
        if found == 6:
            break
        row = np.zeros(6)
        row[e] = 1.0
        for _ in range(2):
            for i in range(found):
                s = 0.0
                for m in range(6):
                    s += Q[m, i] * row[m]
                for m in range(6):
                    row[m] -= s * Q[m, i]
        length = 0.0
        for m in range(6):
            length += row[m] * row[m]
        length = length**0.5
        # in six dimensions one of the remaining unit vectors keeps at least 1/sqrt(6) of its length
        if length > 0.3 or (length > 1e-3 and 6 - e <= 6 - found):
            for m in range(6):
                Q[m, found] = row[m] / length
            found += 1
    store.free[k] = 6 - ne
    return found == 6


@kernel
def _velocity_terms(tables, k, work, store):
    """Write c = X bias_P + sigma - bias_C, where sigma satisfies the joint's equations at zero accelerations."""
    first, last = tables.start_equation[k], tables.start_equation[k + 1]
    ne = last - first
    C = work.markers[tables.outer[k]]
    P = work.markers[tables.inner[k]]
    Q, R, c = store.basis[k], store.triangle[k], store.c[k]
    z = np.zeros(6)
    for j in range(ne):
        s = -work.equations[tables.equations[first + j]].drift
        for i in range(j):
            s -= R[i, j] * z[i]
        z[j] = s / R[j, j]
    d = np.empty(3)
    for i in range(3):
        d[i] = C.r[i] - P.r[i]
    for i in range(6):
        c[i] = P.bias[i] - C.bias[i]
        for j in range(ne):
            c[i] += Q[i, j] * z[j]
    for i in range(3):
        j, m = (i + 1) % 3, (i + 2) % 3
        c[i] += P.bias[3 + j] * d[m] - P.bias[3 + m] * d[j]


@kernel
def _shifted_jacobian(tables, k, work, store, columns, rows):
    """Write X J_P (6, nu) of the parent to `columns`, and to `rows` the same with the stiffening by the wrench."""
    C = work.markers[tables.outer[k]]
    P = work.markers[tables.inner[k]]
    nu = P.nu
    d = np.empty(3)
    for i in range(3):
        d[i] = C.r[i] - P.r[i]
    for j in range(nu):
        for i in range(6):
            columns[i, j] = work.J[P.iJ + i * nu + j]
            rows[i, j] = columns[i, j] - (work.H[P.iH + i * nu + j] if P.iH >= 0 else 0.0)
        for i in range(3):
            a, b = (i + 1) % 3, (i + 2) % 3
            columns[i, j] += columns[3 + a, j] * d[b] - columns[3 + b, j] * d[a]
            rows[i, j] += rows[3 + a, j] * d[b] - rows[3 + b, j] * d[a]


@kernel
def _to_marker(M, T, Jc, Jr, m, out):
    """Write the mass matrix in the coordinates (V, eta'') to `out`: frame accelerations are T (V - J eta'')."""
    n = 6 + m
    half = np.empty((n, n))
    for i in range(n):
        for j in range(6):
            s = 0.0
            for k in range(6):
                s += M[i, k] * T[k, j]
            half[i, j] = s
        for j in range(m):
            s = M[i, 6 + j]
            for k in range(6):
                s -= half[i, k] * Jc[k, j]
            half[i, 6 + j] = s
    for j in range(n):
        for i in range(6):
            s = 0.0
            for k in range(6):
                s += T[k, i] * half[k, j]
            out[i, j] = s
        for i in range(m):
            s = half[6 + i, j]
            for k in range(6):
                s -= Jr[k, i] * out[k, j]
            out[6 + i, j] = s


@kernel
def _modal_views(tables, store, k):
    """Return the views of the inverse modal block (m, m) and the couplings (6, m), (m, 6)."""
    m = max(0, tables.nu[k] - 6)
    a = tables.i_modal[k]
    inverse = store.modal[a : a + m * m].reshape((m, m))
    right = store.modal[a + m * m : a + m * m + 6 * m].reshape((6, m))
    left = store.modal[a + m * m + 6 * m : a + m * m + 12 * m].reshape((m, 6))
    return inverse, right, left


@kernel
def _flexible_jacobian(tables, k, work, Jc, Jr):
    """Write the modal columns of J_C, without and with the stiffening, (6, m)."""
    C = work.markers[tables.outer[k]]
    for j in range(tables.nu[k] - 6):
        for i in range(6):
            x = work.J[C.iJ + i * C.nu + 6 + j]
            Jc[i, j] = x
            Jr[i, j] = x - (work.H[C.iH + i * C.nu + 6 + j] if C.iH >= 0 else 0.0)


@kernel
def _articulate(tables, k, work, store):
    """Eliminate modes and joint of body k: P, N, D, U and the transmitted inertia; return False if it is singular."""
    nu = tables.nu[k]
    m = nu - 6
    M = store.mass[tables.i_mass[k] : tables.i_mass[k + 1]].reshape((nu, nu))
    C = work.markers[tables.outer[k]]
    T, P = store.T[k], store.P[k]
    for i in range(3):
        for j in range(3):
            # inverse of [[R, B], [0, R]] is [[R^T, -R^T B R^T], [0, R^T]]
            T[i, j] = work.J[C.iJ + j * nu + i]
            T[3 + i, 3 + j] = T[i, j]
            T[3 + i, j] = 0.0
    for i in range(3):
        for j in range(3):
            s = 0.0
            for a in range(3):
                for b in range(3):
                    s -= T[i, a] * work.J[C.iJ + a * nu + 3 + b] * T[b, j]
            T[i, 3 + j] = s
    Jc, Jr = np.empty((6, m)), np.empty((6, m))
    _flexible_jacobian(tables, k, work, Jc, Jr)
    moved = np.empty((nu, nu))
    _to_marker(M, T, Jc, Jr, m, moved)
    for i in range(6):
        for j in range(6):
            P[i, j] = moved[i, j]
    if m > 0:
        inverse, right, left = _modal_views(tables, store, k)
        if not invert(moved[6:, 6:], m, inverse):
            return False
        for i in range(m):
            for j in range(6):
                s = 0.0
                for a in range(m):
                    s += inverse[i, a] * moved[6 + a, j]
                left[i, j] = s  # eta'' = inverse f_eta - left V
        for i in range(6):
            for j in range(m):
                s = 0.0
                for a in range(m):
                    s += moved[i, 6 + a] * inverse[a, j]
                right[i, j] = s
            for j in range(6):
                for a in range(m):
                    P[i, j] -= moved[i, 6 + a] * left[a, j]
    return _open_joint(k, store)


@kernel
def _open_joint(k, store):
    """Write D = (N^T P N)^-1 and U = P N D; return False if the free motions have no inertia."""
    nf = store.free[k]
    ne = 6 - nf
    P, Q, D, U = store.P[k], store.basis[k], store.D[k], store.U[k]
    PN = np.empty((6, 6))
    E = np.zeros((6, 6))
    for i in range(6):
        for j in range(nf):
            s = 0.0
            for a in range(6):
                s += P[i, a] * Q[a, ne + j]
            PN[i, j] = s
    largest = 0.0
    for i in range(nf):
        for j in range(nf):
            for a in range(6):
                E[i, j] += Q[a, ne + i] * PN[a, j]
        largest = max(largest, abs(E[i, i]))
    if nf > 0 and not invert(E, nf, D):
        return False
    for i in range(6):
        for j in range(nf):
            s = 0.0
            for a in range(nf):
                s += PN[i, a] * D[a, j]
            U[i, j] = s
    return nf == 0 or largest > 0.0


@kernel
def factor(tables, work, store):
    """Pass one: articulated inertias from the leaves to the roots. The workspace holds an evaluation with unit mass weight."""
    n = len(tables.iu)
    store.failed[0] = -1
    for k in range(n):
        nu, iu = tables.nu[k], tables.iu[k]
        M = store.mass[tables.i_mass[k] : tables.i_mass[k + 1]].reshape((nu, nu))
        for i in range(nu):
            for j in range(nu):
                M[i, j] = work.S[work.rows[iu + i] + j]
    for k in range(n - 1, -1, -1):
        nu = tables.nu[k]
        M = store.mass[tables.i_mass[k] : tables.i_mass[k + 1]].reshape((nu, nu))
        if tables.outer[k] < 0:
            if not invert(M, nu, M):
                store.failed[0] = k
            continue
        if not (_joint_basis(tables, k, work, store) and _articulate(tables, k, work, store)):
            store.failed[0] = k
            return
        _velocity_terms(tables, k, work, store)
        p = tables.parent[k]
        if p < 0:
            continue
        np_ = tables.nu[p]
        a = tables.i_parent[k]
        columns = store.parent[a : a + 6 * np_].reshape((6, np_))
        rows = store.parent[a + 6 * np_ : a + 12 * np_].reshape((6, np_))
        _shifted_jacobian(tables, k, work, store, columns, rows)
        nf = store.free[k]
        ne = 6 - nf
        P, U, Q = store.P[k], store.U[k], store.basis[k]
        through = np.empty((6, 6))
        for i in range(6):
            for j in range(6):
                s = P[i, j]
                for f in range(nf):
                    t = 0.0
                    for b in range(6):
                        t += Q[b, ne + f] * P[b, j]
                    s -= U[i, f] * t
                through[i, j] = s
        Mp = store.mass[tables.i_mass[p] : tables.i_mass[p + 1]].reshape((np_, np_))
        PJ = np.empty((6, np_))
        for i in range(6):
            for j in range(np_):
                s = 0.0
                for b in range(6):
                    s += through[i, b] * columns[b, j]
                PJ[i, j] = s
        for i in range(np_):
            for j in range(np_):
                s = 0.0
                for b in range(6):
                    s += rows[b, i] * PJ[b, j]
                Mp[i, j] += s


@kernel
def _load_at_marker(tables, k, work, store, p, modal):
    """Write the load of body k on its marker with modes eliminated to `p` (6,), and its modal part to `modal` (m,)."""
    iu = tables.iu[k]
    m = tables.nu[k] - 6
    T = store.T[k]
    for i in range(6):
        p[i] = 0.0
        for j in range(6):
            p[i] += T[j, i] * store.force[iu + j]
    if m > 0:
        Jc, Jr = np.empty((6, m)), np.empty((6, m))
        _flexible_jacobian(tables, k, work, Jc, Jr)
        for j in range(m):
            s = store.force[iu + 6 + j]
            for i in range(6):
                s -= Jr[i, j] * p[i]
            modal[j] = s
        _, right, _ = _modal_views(tables, store, k)
        for i in range(6):
            for j in range(m):
                p[i] -= right[i, j] * modal[j]


@kernel
def solve(tables, work, store, right, velocity_terms, a):
    """Passes two and three: forces `right` (nu,) from the leaves, accelerations `a` (nu,) and wrenches from the roots.

    `velocity_terms` is 1.0 for the motion itself, 0.0 for the response to a unit multiplier.
    """
    n = len(tables.iu)
    store.force[:] = right
    t = np.empty(6)
    for k in range(n - 1, -1, -1):
        if tables.outer[k] < 0:
            continue
        nu = tables.nu[k]
        nf = store.free[k]
        ne = 6 - nf
        P, U, Q, c = store.P[k], store.U[k], store.basis[k], store.c[k]
        p = store.wrench[k]
        modal = np.empty(nu - 6)
        _load_at_marker(tables, k, work, store, p, modal)
        parent = tables.parent[k]
        if parent < 0:
            continue
        # transmitted: -(through c - (I - U N^T) p) = (I - U N^T) (p - P c)
        for i in range(6):
            t[i] = p[i]
            for j in range(6):
                t[i] -= velocity_terms * P[i, j] * c[j]
        moved = np.empty(6)
        for i in range(6):
            moved[i] = t[i]
        for f in range(nf):
            s = 0.0
            for i in range(6):
                s += Q[i, ne + f] * t[i]
            for i in range(6):
                moved[i] -= U[i, f] * s
        width = tables.nu[parent]
        start = tables.i_parent[k]
        rows = store.parent[start + 6 * width : start + 12 * width].reshape((6, width))
        for j in range(width):
            for i in range(6):
                store.force[tables.iu[parent] + j] += rows[i, j] * moved[i]
    for k in range(n):
        _accelerate(tables, k, work, store, velocity_terms, a)


@kernel
def _accelerate(tables, k, work, store, velocity_terms, a):
    """Find the acceleration of body k from that of its parent, and the wrench of its joint."""
    iu, nu = tables.iu[k], tables.nu[k]
    m = nu - 6
    if tables.outer[k] < 0:
        inverse = store.mass[tables.i_mass[k] : tables.i_mass[k + 1]].reshape((nu, nu))
        for i in range(nu):
            a[iu + i] = 0.0
            for j in range(nu):
                a[iu + i] += inverse[i, j] * store.force[iu + j]
        return
    nf = store.free[k]
    ne = 6 - nf
    P, D, Q, T, V = store.P[k], store.D[k], store.basis[k], store.T[k], store.V[k]
    p = np.empty(6)
    modal = np.empty(max(m, 0))
    _load_at_marker(tables, k, work, store, p, modal)
    parent = tables.parent[k]
    for i in range(6):
        V[i] = velocity_terms * store.c[k, i]
    if parent >= 0:
        width = tables.nu[parent]
        start = tables.i_parent[k]
        columns = store.parent[start : start + 6 * width].reshape((6, width))
        for j in range(width):
            x = a[tables.iu[parent] + j]
            for i in range(6):
                V[i] += columns[i, j] * x
    rest = np.empty(6)
    for i in range(6):
        rest[i] = p[i]
        for j in range(6):
            rest[i] -= P[i, j] * V[j]
    slide = np.zeros(6)
    for f in range(nf):
        for i in range(6):
            slide[f] += Q[i, ne + f] * rest[i]
    for f in range(nf):
        x = 0.0
        for e in range(nf):
            x += D[f, e] * slide[e]
        for i in range(6):
            V[i] += Q[i, ne + f] * x
    for i in range(6):
        store.wrench[k, i] = -p[i]
        for j in range(6):
            store.wrench[k, i] += P[i, j] * V[j]
    free = np.empty(6)
    for i in range(6):
        free[i] = V[i]
    if m > 0:
        inverse, _, left = _modal_views(tables, store, k)
        Jc, Jr = np.empty((6, m)), np.empty((6, m))
        _flexible_jacobian(tables, k, work, Jc, Jr)
        for i in range(m):
            x = 0.0
            for j in range(m):
                x += inverse[i, j] * modal[j]
            for j in range(6):
                x -= left[i, j] * V[j]
            a[iu + 6 + i] = x
            for j in range(6):
                free[j] -= Jc[j, i] * x
    for i in range(6):
        s = 0.0
        for j in range(6):
            s += T[i, j] * free[j]
        a[iu + i] = s


@kernel
def joint_multipliers(tables, store, lam):
    """Write the multipliers of the tree joints that make up the wrenches to `lam`."""
    for k in range(len(tables.iu)):
        if tables.outer[k] < 0:
            continue
        first = tables.start_equation[k]
        ne = tables.start_equation[k + 1] - first
        Q, R = store.basis[k], store.triangle[k]
        for j in range(ne - 1, -1, -1):
            s = 0.0
            for i in range(6):
                s += Q[i, j] * store.wrench[k, i]
            for i in range(j + 1, ne):
                s -= R[j, i] * lam[tables.equations[first + i]]
            lam[tables.equations[first + j]] = s / R[j, j]
