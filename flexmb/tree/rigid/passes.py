"""The articulated-body algorithm in link axes, for rigid links on joints of one, three or six freedoms.

A motion about or along z is one column of the inertia; a ball or a free frame takes the leading block. Inertias are
symmetric: ``[[J, H], [H^T, M]]`` in (angular, linear), stored as 6 + 9 + 6 numbers. Source: Featherstone 2008, table
7.1.
"""

from __future__ import annotations

import numpy as np

from flexmb.math.kernel import inner_kernel, kernel
from flexmb.tree.rigid.places import BALL, FIXED, FRAME, SINGLE, carry, reach_axes, read_axes

__all__ = ["SINGULAR", "gather", "let_fall", "solve_factor", "spread"]

SINGULAR = 1e-15
"""Inertia of a free motion below this, relative to the largest mass or moment of the articulated inertia, counts as
none: it is rounding."""


@inner_kernel
def _column(link, row):
    """Return the column of the inertia (6,) that belongs to the joint's one motion."""
    t, s = link.turn, link.slide
    return (
        t * row.J[2] + s * row.H[0, 2],
        t * row.J[4] + s * row.H[1, 2],
        t * row.J[5] + s * row.H[2, 2],
        t * row.H[2, 0] + s * row.M[2],
        t * row.H[2, 1] + s * row.M[4],
        t * row.H[2, 2] + s * row.M[5],
    )


@inner_kernel
def _open(link, row, tau):
    """Subtract what the joint's one motion takes from inertia and force; False if it moves no inertia."""
    U = _column(link, row)
    D = link.turn * U[2] + link.slide * U[5]
    t, s = link.turn * link.turn, link.slide * link.slide
    usual = t * max(row.J[0], row.J[3], row.J[5]) + s * max(row.M[0], row.M[3], row.M[5])
    if not D > max(SINGULAR * usual, 1e-300):
        return False
    D = 1.0 / D
    for i in range(6):
        row.gain[i] = U[i] * D
    row.mobility = D
    row.load = link.sign * tau[link.rate] - link.turn * row.force[2] - link.slide * row.force[5]
    k = 0
    for i in range(3):
        for j in range(i, 3):
            row.J[k] -= row.gain[i] * U[j]
            row.M[k] -= row.gain[3 + i] * U[3 + j]
            k += 1
        for j in range(3):
            row.H[i, j] -= row.gain[i] * U[3 + j]
    return True


@inner_kernel
def _factorise(L, n):
    """Replace the lower half of L (n, n), flat with rows of n, by its Cholesky factor; False if it is not positive.

    L has three moments, and three masses behind them.
    """
    usual = 0.0
    for j in range(n):
        if j % 3 == 0:
            usual = max(L[n * j + j], L[n * (j + 1) + j + 1], L[n * (j + 2) + j + 2])
        x = L[n * j + j]
        least = max(SINGULAR * usual, 1e-300)
        for k in range(j):
            x -= L[n * j + k] ** 2
        if not x > least:
            return False
        x = x**0.5
        L[n * j + j] = x
        for i in range(j + 1, n):
            y = L[n * i + j]
            for k in range(j):
                y -= L[n * i + k] * L[n * j + k]
            L[n * i + j] = y / x
    return True


@kernel
def solve_factor(L, n, b):
    """Solve with the Cholesky factor L (n, n), flat; the solution replaces b (n,)."""
    for i in range(n):
        x = b[i]
        for k in range(i):
            x -= L[n * i + k] * b[k]
        b[i] = x / L[n * i + i]
    for i in range(n - 1, -1, -1):
        x = b[i]
        for k in range(i + 1, n):
            x -= L[n * k + i] * b[k]
        b[i] = x / L[n * i + i]


@inner_kernel
def _open_ball(link, row, block, tau, column):
    """The same for a ball: P - U J^-1 U^T leaves M - H^T J^-1 H alone."""
    J, H, L = row.J, row.H, block.L
    L[0], L[3], L[4], L[6], L[7], L[8] = J[0], J[1], J[3], J[2], J[4], J[5]
    if not _factorise(L, 3):
        return False
    x, y, z = reach_axes(link, row, tau[link.rate], tau[link.rate + 1], tau[link.rate + 2])
    block.load[0], block.load[1], block.load[2] = x - row.force[0], y - row.force[1], z - row.force[2]
    for j in range(3):  # K = H^T J^-1, row j
        column[0], column[1], column[2] = H[0, j], H[1, j], H[2, j]
        solve_factor(L, 3, column)
        for i in range(3):
            block.gain[j, i] = column[i]
    k = 0
    for i in range(3):
        for j in range(i, 3):
            x = 0.0
            for m in range(3):
                x += block.gain[i, m] * H[m, j]
            row.M[k] -= x
            k += 1
    for i in range(3):
        row.force[i] += block.load[i]
        for m in range(3):
            row.force[3 + i] += block.gain[i, m] * block.load[m]
    J[:] = 0.0
    H[:] = 0.0
    return True


@inner_kernel
def _open_frame(link, row, block, tau):
    """Factorise the whole inertia of a free body: nothing is passed on."""
    J, H, M, L = row.J, row.H, row.M, block.L
    k = 0
    for i in range(3):
        for j in range(i, 3):
            L[6 * j + i], L[6 * (3 + j) + 3 + i] = J[k], M[k]
            k += 1
        for j in range(3):
            L[6 * (3 + j) + i] = H[i, j]
    for i in range(3):
        block.load[i] = tau[link.rate + 3 + i] - row.force[i]
        block.load[3 + i] = tau[link.rate + i] - row.force[3 + i]
    return _factorise(L, 6)


@inner_kernel
def _force_with_bias(row):
    """Add P c to the force, and what the joint's one motion gives it."""
    a, b, c = row.bias[0], row.bias[1], row.bias[2]
    u, v, w = row.bias[3], row.bias[4], row.bias[5]
    J, H, M = row.J, row.H, row.M
    force = row.force
    force[0] += J[0] * a + J[1] * b + J[2] * c + H[0, 0] * u + H[0, 1] * v + H[0, 2] * w
    force[1] += J[1] * a + J[3] * b + J[4] * c + H[1, 0] * u + H[1, 1] * v + H[1, 2] * w
    force[2] += J[2] * a + J[4] * b + J[5] * c + H[2, 0] * u + H[2, 1] * v + H[2, 2] * w
    force[3] += H[0, 0] * a + H[1, 0] * b + H[2, 0] * c + M[0] * u + M[1] * v + M[2] * w
    force[4] += H[0, 1] * a + H[1, 1] * b + H[2, 1] * c + M[1] * u + M[3] * v + M[4] * w
    force[5] += H[0, 2] * a + H[1, 2] * b + H[2, 2] * c + M[2] * u + M[4] * v + M[5] * w
    for i in range(6):
        force[i] += row.gain[i] * row.load


@inner_kernel
def _full(A):
    """Return all nine numbers of a symmetric matrix of six."""
    return A[0], A[1], A[2], A[1], A[3], A[4], A[2], A[4], A[5]


@inner_kernel
def _turned(R, A, out, half):
    """Write R A R^T to `out` (9,); A is given as nine numbers."""
    for j in range(3):
        x, y, z = R[j, 0], R[j, 1], R[j, 2]
        half[j] = A[0] * x + A[1] * y + A[2] * z
        half[3 + j] = A[3] * x + A[4] * y + A[5] * z
        half[6 + j] = A[6] * x + A[7] * y + A[8] * z
    for i in range(3):
        x, y, z = R[i, 0], R[i, 1], R[i, 2]
        for j in range(3):
            out[3 * i + j] = x * half[j] + y * half[3 + j] + z * half[6 + j]


@inner_kernel
def _give(row, of_parent, M, H, J, half):
    """Add inertia and force to the parent's: turned, then moved by r: H + r~ M, J + r~ H^T - (H + r~ M) r~."""
    x, y, z = row.r[0], row.r[1], row.r[2]
    R, of = row.R, row.H
    _turned(R, _full(row.M), M, half)
    _turned(R, (of[0, 0], of[0, 1], of[0, 2], of[1, 0], of[1, 1], of[1, 2], of[2, 0], of[2, 1], of[2, 2]), H, half)
    _turned(R, _full(row.J), J, half)
    for j in range(3):
        # r~ H^T: the cross product of r with row j of H, as column j
        a, b, c = H[3 * j], H[3 * j + 1], H[3 * j + 2]
        J[j] += y * c - z * b
        J[3 + j] += z * a - x * c
        J[6 + j] += x * b - y * a
    for j in range(3):
        a, b, c = M[j], M[3 + j], M[6 + j]
        H[j] += y * c - z * b
        H[3 + j] += z * a - x * c
        H[6 + j] += x * b - y * a
    k = 0
    for i in range(3):
        a, b, c = H[3 * i], H[3 * i + 1], H[3 * i + 2]
        # row i of -H r~ is r x (row i of H) with the opposite sign of (row i of H) x r
        shift = (y * c - z * b, z * a - x * c, x * b - y * a)
        for j in range(i, 3):
            of_parent.J[k] += J[3 * i + j] + shift[j]
            of_parent.M[k] += M[3 * i + j]
            k += 1
        for j in range(3):
            of_parent.H[i, j] += H[3 * i + j]
    for i in range(3):
        p, q, r = row.R[i, 0], row.R[i, 1], row.R[i, 2]
        half[i] = p * row.force[0] + q * row.force[1] + r * row.force[2]
        half[3 + i] = p * row.force[3] + q * row.force[4] + r * row.force[5]
    of_parent.force[0] += half[0] + y * half[5] - z * half[4]
    of_parent.force[1] += half[1] + z * half[3] - x * half[5]
    of_parent.force[2] += half[2] + x * half[4] - y * half[3]
    for i in range(3):
        of_parent.force[3 + i] += half[3 + i]


@kernel
def gather(links, rows, blocks, tau, first, last):
    """Pass inertias and forces of the links from `first` to before `last` on to their parents, joints opened.

    Returns -1, or a link whose motion has no inertia.

    tau (nv,) : forces on the rates
    """
    M, H, J, half = np.empty(9), np.empty(9), np.empty(9), np.empty(9)
    for k in range(last - 1, first - 1, -1):
        link, row = links[k], rows[k]
        row.load = 0.0
        if link.kind == FRAME:
            if not _open_frame(link, row, blocks[link.block], tau):
                return k
            continue
        if link.kind == BALL:
            if not _open_ball(link, row, blocks[link.block], tau, half):
                return k
            row.gain[:] = 0.0
        elif link.kind == FIXED or link.driven == 1:
            row.gain[:] = 0.0
        elif not _open(link, row, tau):
            return k
        _force_with_bias(row)
        if link.parent >= 0:
            _give(row, rows[link.parent], M, H, J, half)
    return -1


@inner_kernel
def _several(link, row, block, column, a):
    """The accelerations of a ball or free frame: P' a = load, of which what is carried here is a part already."""
    at = link.rate
    n = 3 if link.kind == BALL else 6
    for i in range(n):
        column[i] = block.load[i]
    solve_factor(block.L, n, column)
    if n == 3:
        for i in range(3):
            for j in range(3):
                column[i] -= block.gain[j, i] * row.rate[3 + j]
    for i in range(n):
        x = column[i]
        column[i] -= row.rate[i]
        row.rate[i] = x
    if n == 3:
        a[at], a[at + 1], a[at + 2] = read_axes(link, row, column[0], column[1], column[2])
    else:
        for i in range(3):
            a[at + i], a[at + 3 + i] = column[3 + i], column[i]


@kernel
def spread(links, rows, blocks, weight, tau, a, first, last):
    """Write the second rates `a` (nv,) of the links from `first` to before `last`, and the forces on driven rates.

    weight : 1.0 with the velocity terms; 0.0 for the response to loads alone
    """
    column = np.empty(6)
    for k in range(first, last):
        link, row = links[k], rows[k]
        carry(row, rows[link.parent].rate, row.rate)
        if link.driven == 1 and weight != 0.0:
            U = _column(link, row)
            x = link.turn * row.force[2] + link.slide * row.force[5] - row.load
            for i in range(6):
                x += U[i] * row.rate[i]
            tau[link.rate] = link.sign * x
        for i in range(6):
            row.rate[i] += weight * row.bias[i]
        if link.kind == SINGLE and link.driven == 0:
            x = row.load * row.mobility
            for i in range(6):
                x -= row.gain[i] * row.rate[i]
            row.rate[2] += link.turn * x
            row.rate[5] += link.slide * x
            a[link.rate] = link.sign * x
        elif link.kind == BALL or link.kind == FRAME:
            _several(link, row, blocks[link.block], column, a)


@kernel
def let_fall(ground, fall, weight):
    """Give the row of the ground the acceleration -fall (3,), times a weight."""
    for i in range(3):
        ground.rate[i], ground.rate[3 + i] = 0.0, -weight * fall[i]
