"""Passes two and three of the recursion: loads from the leaves to the roots, accelerations from there to the leaves."""

from __future__ import annotations

from flexmb.math.kernel import inner_kernel, kernel
from flexmb.tree.any_body.blocks import solve_block
from flexmb.tree.any_body.store import modal_views

__all__ = ["joint_multipliers", "solve"]


@inner_kernel
def _own_load(row, force, iu):
    """Write the generalised force of a body to its load at C, eq. (tree-load)."""
    for i in range(3):
        x, y, z = row.R[i, 0], row.R[i, 1], row.R[i, 2]
        row.load[i] = x * force[iu] + y * force[iu + 1] + z * force[iu + 2]
        row.load[3 + i] = x * force[iu + 3] + y * force[iu + 4] + z * force[iu + 5]
    x, y, z = row.lever[0], row.lever[1], row.lever[2]
    a, b, c = row.load[0], row.load[1], row.load[2]
    row.load[3] -= y * c - z * b
    row.load[4] -= z * a - x * c
    row.load[5] -= x * b - y * a


@inner_kernel
def _own_modal_load(row, force, iu, m, i_modal, i_eta, store):
    """Write the modal loads at fixed C."""
    Jr = modal_views(store.modal, i_modal, m)[4]
    for j in range(m):
        x = force[iu + 6 + j]
        for i in range(6):
            x -= Jr[i, j] * row.load[i]
        store.eta[i_eta + j] = x


@inner_kernel
def _eliminate_load(row, m, i_modal, i_eta, store):
    """Solve for the modal accelerations at V = 0 and subtract their inertia from the load."""
    K, right, _, _, _ = modal_views(store.modal, i_modal, m)
    eta = store.eta[i_eta : i_eta + m]
    solve_block(K, m, store.pivots[i_eta : i_eta + m], eta)
    for i in range(6):
        x = 0.0
        for j in range(m):
            x += right[i, j] * eta[j]
        row.load[i] -= x


@inner_kernel
def _pass_load(row, weight, of_parent, passed):
    """Write what the joint passes on of the load, eq. (tree-open), and add it to the parent's."""
    nf = row.free
    for i in range(6):
        passed[i] = row.load[i] - weight * row.drop[i]
    for f in range(nf):
        s = row.along[f]
        for i in range(6):
            passed[i] -= s * row.U[f, i]
    x, y, z = row.step[0], row.step[1], row.step[2]
    a, b, c = passed[0], passed[1], passed[2]
    of_parent.load[0] += a
    of_parent.load[1] += b
    of_parent.load[2] += c
    of_parent.load[3] += passed[3] + y * c - z * b
    of_parent.load[4] += passed[4] + z * a - x * c
    of_parent.load[5] += passed[5] + x * b - y * a


@inner_kernel
def _sum_load(row):
    """Write N^T p."""
    nf = row.free
    for f in range(nf):
        s = 0.0
        for i in range(6):
            s += row.way[6 - nf + f, i] * row.load[i]
        row.along[f] = s


@inner_kernel
def _carried(row, weight, of_parent):
    """Write the rate of C that the parent's frame gives it."""
    x, y, z = row.step[0], row.step[1], row.step[2]
    a, b, c = of_parent.rate[3], of_parent.rate[4], of_parent.rate[5]
    row.rate[0] = weight * row.bias[0] + of_parent.rate[0] + b * z - c * y
    row.rate[1] = weight * row.bias[1] + of_parent.rate[1] + c * x - a * z
    row.rate[2] = weight * row.bias[2] + of_parent.rate[2] + a * y - b * x
    row.rate[3] = weight * row.bias[3] + a
    row.rate[4] = weight * row.bias[4] + b
    row.rate[5] = weight * row.bias[5] + c


@inner_kernel
def _move(row, x):
    """Add the motion of the joint to the rate of C."""
    nf = row.free
    for f in range(nf):
        s = 0.0
        for e in range(nf):
            s += row.D[nf * f + e] * row.along[e]
        for i in range(6):
            s -= row.gain[f, i] * row.rate[i]
        x[f] = s
    for f in range(nf):
        s = x[f]
        for i in range(6):
            row.rate[i] += s * row.way[6 - nf + f, i]


@inner_kernel
def _own_modal_accelerations(row, iu, m, i_modal, i_eta, store, a, frame):
    """Write the modal accelerations and subtract their part from the rate of C."""
    _, _, left, Jc, _ = modal_views(store.modal, i_modal, m)
    for i in range(m):
        x = store.eta[i_eta + i]
        for j in range(6):
            x -= left[i, j] * row.rate[j]
        a[iu + 6 + i] = x
        for j in range(6):
            frame[j] -= Jc[j, i] * x


@inner_kernel
def _frame_accelerations(row, frame, iu, a):
    """Write the accelerations of the frame, in its own axes and at its origin."""
    x, y, z = row.lever[0], row.lever[1], row.lever[2]
    u, v, w = frame[3], frame[4], frame[5]
    x, y, z = frame[0] - (v * z - w * y), frame[1] - (w * x - u * z), frame[2] - (u * y - v * x)
    for i in range(3):
        r, s, t = row.R[0, i], row.R[1, i], row.R[2, i]
        a[iu + i] = r * x + s * y + t * z
        a[iu + 3 + i] = r * u + s * v + t * w


@inner_kernel
def _gather(tables, store, k, weight, passed):
    """Pass two of body k: eliminate modes and joint, load the parent and its modes."""
    row = store.rows[k]
    m = tables.i_eta[k + 1] - tables.i_eta[k]
    if m > 0:
        _eliminate_load(row, m, tables.i_modal[k], tables.i_eta[k], store)
    _sum_load(row)
    p = tables.parent[k]
    if p < 0:
        return
    _pass_load(row, weight, store.rows[p], passed)
    first = tables.i_eta[p]
    m = tables.i_eta[p + 1] - first
    if m > 0:
        at = tables.i_parent[k] + 6 * m
        Er = store.parent[at : at + 6 * m].reshape((6, m))
        for i in range(6):
            for j in range(m):
                store.eta[first + j] += Er[i, j] * passed[i]


@inner_kernel
def _spread(tables, store, k, weight, a, x):
    """Pass three of body k: the rate of its marker, and with it its accelerations."""
    row, iu, p = store.rows[k], tables.iu[k], tables.parent[k]
    if p < 0:
        for i in range(6):
            row.rate[i] = weight * row.bias[i]
    else:
        _carried(row, weight, store.rows[p])
        m = tables.i_eta[p + 1] - tables.i_eta[p]
        if m > 0:
            E = store.parent[tables.i_parent[k] : tables.i_parent[k] + 6 * m].reshape((6, m))
            for i in range(6):
                for j in range(m):
                    row.rate[i] += E[i, j] * a[tables.iu[p] + 6 + j]
    _move(row, x)
    for i in range(6):
        x[i] = row.rate[i]
    m = tables.i_eta[k + 1] - tables.i_eta[k]
    if m > 0:
        _own_modal_accelerations(row, iu, m, tables.i_modal[k], tables.i_eta[k], store, a, x)
    _frame_accelerations(row, x, iu, a)


@kernel
def solve(tables, store, tree, force, weight, a):
    """Write the accelerations that `force` (nu,) gives the bodies of a tree to `a` (nu,).

    `weight` of the velocity terms is 1.0 for the motion itself, 0.0 for the response to a unit multiplier.
    """
    first, last = tables.trees[tree], tables.trees[tree + 1]
    scratch = store.scratch[0]
    for k in range(first, last):
        if tables.outer[k] >= 0:
            _own_load(store.rows[k], force, tables.iu[k])
            m = tables.i_eta[k + 1] - tables.i_eta[k]
            if m > 0:
                _own_modal_load(store.rows[k], force, tables.iu[k], m, tables.i_modal[k], tables.i_eta[k], store)
    for k in range(last - 1, first - 1, -1):
        if tables.outer[k] >= 0:
            _gather(tables, store, k, weight, scratch)
    for k in range(first, last):
        if tables.outer[k] >= 0:
            _spread(tables, store, k, weight, a, scratch)
            continue
        n, iu, at = tables.nu[k], tables.iu[k], tables.i_plain[k]
        for i in range(n):
            x = 0.0
            for j in range(n):
                x += store.plain[at + n * i + j] * force[iu + j]
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
        row = store.rows[k]
        for i in range(6):
            s = -row.load[i]
            for j in range(6):
                s += row.P[i, j] * row.rate[j]
            W[i] = s
        for j in range(ne - 1, -1, -1):
            s = 0.0
            for i in range(6):
                s += row.way[j, i] * W[i]
            for i in range(j + 1, ne):
                s -= row.triangle[j, i] * lam[tables.equations[first + i]]
            lam[tables.equations[first + j]] = s / row.triangle[j, j]
