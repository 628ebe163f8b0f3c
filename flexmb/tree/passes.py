"""Passes two and three of the recursion: loads from the leaves to the roots, accelerations from the roots to the leaves."""

from __future__ import annotations

from flexmb.math.kernel import kernel
from flexmb.tree.blocks import solve_block
from flexmb.tree.store import modal_views

__all__ = ["joint_multipliers", "solve"]


@kernel
def _own_loads(tables, k, force, store):
    """Write the generalised force of a body to its load at C, eq. (tree-load), and to its modal loads."""
    iu = tables.iu[k]
    R, s, load = store.R[k], store.lever[k], store.load[k]
    for i in range(3):
        load[i] = R[i, 0] * force[iu] + R[i, 1] * force[iu + 1] + R[i, 2] * force[iu + 2]
        load[3 + i] = R[i, 0] * force[iu + 3] + R[i, 1] * force[iu + 4] + R[i, 2] * force[iu + 5]
    load[3] -= s[1] * load[2] - s[2] * load[1]
    load[4] -= s[2] * load[0] - s[0] * load[2]
    load[5] -= s[0] * load[1] - s[1] * load[0]
    first = tables.i_eta[k]
    m = tables.i_eta[k + 1] - first
    if m > 0:
        Jr = modal_views(tables, store, k)[4]
        for j in range(m):
            x = force[iu + 6 + j]
            for i in range(6):
                x -= Jr[i, j] * load[i]
            store.eta[first + j] = x


@kernel
def _collect(tables, k, store, weight, passed, y):
    """Eliminate modes and joint of body k and add what it passes on to the load of its parent, eq. (tree-open)."""
    load = store.load[k]
    m = tables.i_eta[k + 1] - tables.i_eta[k]
    if m > 0:
        K, right, _, _, _ = modal_views(tables, store, k)
        eta = store.eta[tables.i_eta[k] : tables.i_eta[k + 1]]
        solve_block(K, m, store.pivots[tables.i_eta[k] : tables.i_eta[k + 1]], eta)
        for i in range(6):
            x = 0.0
            for j in range(m):
                x += right[i, j] * eta[j]
            load[i] -= x
    p = tables.parent[k]
    if p < 0:
        return
    nf = store.free[k]
    Q, U, drop = store.basis[k], store.U[k], store.drop[k]
    for f in range(nf):
        x = 0.0
        for i in range(6):
            x += Q[i, 6 - nf + f] * load[i]
        y[f] = x
    for i in range(6):
        x = load[i] - weight * drop[i]
        for f in range(nf):
            x -= U[i, f] * y[f]
        passed[i] = x
    m = tables.i_eta[p + 1] - tables.i_eta[p]
    if m > 0:
        a = tables.i_parent[k]
        Er = store.parent[a + 6 * m : a + 12 * m].reshape((6, m))
        for j in range(m):
            x = 0.0
            for i in range(6):
                x += Er[i, j] * passed[i]
            store.eta[tables.i_eta[p] + j] += x
    d, load = store.step[k], store.load[p]
    for i in range(6):
        load[i] += passed[i]
    load[3] += d[1] * passed[2] - d[2] * passed[1]
    load[4] += d[2] * passed[0] - d[0] * passed[2]
    load[5] += d[0] * passed[1] - d[1] * passed[0]


@kernel
def _move(tables, k, store, weight, a, start, x):
    """Write the acceleration of C, V, from that of the parent, and with it those of the body."""
    V, c, Q, D, K, load = store.V[k], store.c[k], store.basis[k], store.D[k], store.K[k], store.load[k]
    for i in range(6):
        V[i] = weight * c[i]
    p = tables.parent[k]
    if p >= 0:
        d, of_parent = store.step[k], store.V[p]
        for i in range(6):
            V[i] += of_parent[i]
        V[0] += of_parent[4] * d[2] - of_parent[5] * d[1]
        V[1] += of_parent[5] * d[0] - of_parent[3] * d[2]
        V[2] += of_parent[3] * d[1] - of_parent[4] * d[0]
        m = tables.i_eta[p + 1] - tables.i_eta[p]
        if m > 0:
            first = tables.i_parent[k]
            E = store.parent[first : first + 6 * m].reshape((6, m))
            iu = tables.iu[p] + 6
            for i in range(6):
                s = 0.0
                for j in range(m):
                    s += E[i, j] * a[iu + j]
                V[i] += s
    nf = store.free[k]
    ne = 6 - nf
    for f in range(nf):
        s = 0.0
        for i in range(6):
            s += Q[i, ne + f] * load[i]
        start[f] = s
    for f in range(nf):
        s = 0.0
        for e in range(nf):
            s += D[f, e] * start[e]
        for i in range(6):
            s -= K[f, i] * V[i]
        x[f] = s
    for f in range(nf):
        s = x[f]
        for i in range(6):
            V[i] += Q[i, ne + f] * s


@kernel
def _own_accelerations(tables, k, store, a, frame):
    """Write the accelerations of a body, frame in its axes, from that of its marker C."""
    iu, first = tables.iu[k], tables.i_eta[k]
    R, s, V = store.R[k], store.lever[k], store.V[k]
    for i in range(6):
        frame[i] = V[i]
    m = tables.i_eta[k + 1] - first
    if m > 0:
        _, _, left, Jc, _ = modal_views(tables, store, k)
        for i in range(m):
            x = store.eta[first + i]
            for j in range(6):
                x -= left[i, j] * V[j]
            a[iu + 6 + i] = x
            for j in range(6):
                frame[j] -= Jc[j, i] * x
    x = frame[0] - (frame[4] * s[2] - frame[5] * s[1])
    y = frame[1] - (frame[5] * s[0] - frame[3] * s[2])
    z = frame[2] - (frame[3] * s[1] - frame[4] * s[0])
    for i in range(3):
        a[iu + i] = R[0, i] * x + R[1, i] * y + R[2, i] * z
        a[iu + 3 + i] = R[0, i] * frame[3] + R[1, i] * frame[4] + R[2, i] * frame[5]


@kernel
def solve(tables, store, tree, force, weight, a):
    """Write the accelerations that `force` (nu,) gives the bodies of a tree to `a` (nu,).

    `weight` of the velocity terms is 1.0 for the motion itself, 0.0 for the response to a unit multiplier.
    """
    first, last = tables.trees[tree], tables.trees[tree + 1]
    one, other = store.scratch[0], store.scratch[1]
    for k in range(first, last):
        if tables.outer[k] >= 0:
            _own_loads(tables, k, force, store)
    for k in range(last - 1, first - 1, -1):
        if tables.outer[k] >= 0:
            _collect(tables, k, store, weight, one, other)
    for k in range(first, last):
        if tables.outer[k] >= 0:
            _move(tables, k, store, weight, a, one, other)
            _own_accelerations(tables, k, store, a, one)
            continue
        n, iu = tables.nu[k], tables.iu[k]
        inverse = store.plain[tables.i_plain[k] : tables.i_plain[k + 1]].reshape((n, n))
        for i in range(n):
            x = 0.0
            for j in range(n):
                x += inverse[i, j] * force[iu + j]
            a[iu + i] = x


@kernel
def joint_multipliers(tables, store, lam):
    """Write the multipliers of the tree joints to `lam`: their wrenches are W = P V - p, eq. (tree-wrench)."""
    W = store.scratch[0]
    for k in range(len(tables.iu)):
        first = tables.start_equation[k]
        ne = tables.start_equation[k + 1] - first
        if ne == 0:
            continue
        P, V, load, Q, R = store.P[k], store.V[k], store.load[k], store.basis[k], store.triangle[k]
        for i in range(6):
            s = -load[i]
            for j in range(6):
                s += P[i, j] * V[j]
            W[i] = s
        for j in range(ne - 1, -1, -1):
            s = 0.0
            for i in range(6):
                s += Q[i, j] * W[i]
            for i in range(j + 1, ne):
                s -= R[j, i] * lam[tables.equations[first + i]]
            lam[tables.equations[first + j]] = s / R[j, j]
