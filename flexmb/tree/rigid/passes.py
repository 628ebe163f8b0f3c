"""The articulated-body algorithm in link axes, for rigid links on joints of one, three or six freedoms.

A motion about or along z is one column of the inertia; a ball or a free frame takes the leading block. Inertias are
symmetric: ``[[J, H], [H^T, M]]`` in (angular, linear), stored as 6 + 9 + 6 numbers. Source: Featherstone 2008, table
7.1.
"""

from __future__ import annotations

import numpy as np

from flexmb.math.kernel import inner_kernel, kernel
from flexmb.tree.rigid.places import (
    BALL,
    BIAS,
    COUPLING,
    DIVISOR,
    DRIVE,
    FIXED,
    FORCE,
    FRAME,
    GAIN,
    INERTIA,
    LOAD,
    MOMENT,
    RATE,
    SINGLE,
    SWING,
    TURN,
    WAY,
    carry,
    reach_axes,
    read_axes,
)

__all__ = ["gather", "solve_factor", "spread"]


@inner_kernel
def _column(link, row):
    """Return the column of the inertia (6,) that belongs to the joint's one motion."""
    t, s = link.turn, link.slide
    return (
        t * row[MOMENT + 2] + s * row[COUPLING + 2],
        t * row[MOMENT + 4] + s * row[COUPLING + 5],
        t * row[MOMENT + 5] + s * row[COUPLING + 8],
        t * row[COUPLING + 6] + s * row[INERTIA + 2],
        t * row[COUPLING + 7] + s * row[INERTIA + 4],
        t * row[COUPLING + 8] + s * row[INERTIA + 5],
    )


@inner_kernel
def _open(link, row, tau):
    """Subtract what the joint's one motion takes from inertia and force; False if it moves no inertia."""
    U = _column(link, row)
    D = link.turn * U[2] + link.slide * U[5]
    if not D > 1e-300:
        return False
    D = 1.0 / D
    for i in range(6):
        row[BIAS + i] = U[i] * D
    row[DIVISOR] = D
    row[DRIVE] = link.sign * tau[link.rate] - link.turn * row[FORCE + 2] - link.slide * row[FORCE + 5]
    k = 0
    for i in range(3):
        for j in range(i, 3):
            row[MOMENT + k] -= row[BIAS + i] * U[j]
            row[INERTIA + k] -= row[BIAS + 3 + i] * U[3 + j]
            k += 1
        for j in range(3):
            row[COUPLING + 3 * i + j] -= row[BIAS + i] * U[3 + j]
    return True


@inner_kernel
def _factorise(L, n):
    """Replace the lower half of L (n, n), flat with rows of n, by its Cholesky factor; False if it is not positive."""
    for j in range(n):
        x = L[n * j + j]
        for k in range(j):
            x -= L[n * j + k] ** 2
        if not x > 1e-300:
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
    J, H = row[MOMENT : MOMENT + 6], row[COUPLING : COUPLING + 9]
    block[0], block[3], block[4], block[6], block[7], block[8] = J[0], J[1], J[3], J[2], J[4], J[5]
    if not _factorise(block[:9], 3):
        return False
    x, y, z = reach_axes(link, row, tau[link.rate], tau[link.rate + 1], tau[link.rate + 2])
    block[LOAD], block[LOAD + 1], block[LOAD + 2] = x - row[FORCE], y - row[FORCE + 1], z - row[FORCE + 2]
    for j in range(3):  # K = H^T J^-1, row j
        column[0], column[1], column[2] = H[j], H[3 + j], H[6 + j]
        solve_factor(block[:9], 3, column)
        for i in range(3):
            block[GAIN + 3 * j + i] = column[i]
    k = 0
    for i in range(3):
        for j in range(i, 3):
            x = 0.0
            for m in range(3):
                x += block[GAIN + 3 * i + m] * H[3 * m + j]
            row[INERTIA + k] -= x
            k += 1
    for i in range(3):
        row[FORCE + i] += block[LOAD + i]
        for m in range(3):
            row[FORCE + 3 + i] += block[GAIN + 3 * i + m] * block[LOAD + m]
    row[MOMENT : MOMENT + 6] = 0.0
    row[COUPLING : COUPLING + 9] = 0.0
    return True


@inner_kernel
def _open_frame(link, row, block, tau):
    """Factorise the whole inertia of a free body: nothing is passed on."""
    J, H, M = row[MOMENT : MOMENT + 6], row[COUPLING : COUPLING + 9], row[INERTIA : INERTIA + 6]
    k = 0
    for i in range(3):
        for j in range(i, 3):
            block[6 * j + i], block[6 * (3 + j) + 3 + i] = J[k], M[k]
            k += 1
        for j in range(3):
            block[6 * (3 + j) + i] = H[3 * i + j]
    for i in range(3):
        block[LOAD + i] = tau[link.rate + 3 + i] - row[FORCE + i]
        block[LOAD + 3 + i] = tau[link.rate + i] - row[FORCE + 3 + i]
    return _factorise(block[:36], 6)


@inner_kernel
def _force_with_swing(row):
    """Add P c to the force, and what the joint's one motion gives it."""
    a, b, c = row[SWING], row[SWING + 1], row[SWING + 2]
    u, v, w = row[SWING + 3], row[SWING + 4], row[SWING + 5]
    J, H, M = MOMENT, COUPLING, INERTIA
    load = row[DRIVE]
    row[FORCE] += row[J] * a + row[J + 1] * b + row[J + 2] * c + row[H] * u + row[H + 1] * v + row[H + 2] * w
    row[FORCE + 1] += (
        row[J + 1] * a + row[J + 3] * b + row[J + 4] * c + row[H + 3] * u + row[H + 4] * v + row[H + 5] * w
    )
    row[FORCE + 2] += (
        row[J + 2] * a + row[J + 4] * b + row[J + 5] * c + row[H + 6] * u + row[H + 7] * v + row[H + 8] * w
    )
    row[FORCE + 3] += row[H] * a + row[H + 3] * b + row[H + 6] * c + row[M] * u + row[M + 1] * v + row[M + 2] * w
    row[FORCE + 4] += (
        row[H + 1] * a + row[H + 4] * b + row[H + 7] * c + row[M + 1] * u + row[M + 3] * v + row[M + 4] * w
    )
    row[FORCE + 5] += (
        row[H + 2] * a + row[H + 5] * b + row[H + 8] * c + row[M + 2] * u + row[M + 4] * v + row[M + 5] * w
    )
    for i in range(6):
        row[FORCE + i] += row[BIAS + i] * load


@inner_kernel
def _turned(row, at, symmetric, out, half):
    """Write R A R^T to `out` (9,); A at row[at] has 6 numbers if symmetric, else 9."""
    if symmetric:
        A = (
            row[at],
            row[at + 1],
            row[at + 2],
            row[at + 1],
            row[at + 3],
            row[at + 4],
            row[at + 2],
            row[at + 4],
            row[at + 5],
        )
    else:
        A = (
            row[at],
            row[at + 1],
            row[at + 2],
            row[at + 3],
            row[at + 4],
            row[at + 5],
            row[at + 6],
            row[at + 7],
            row[at + 8],
        )
    for j in range(3):
        x, y, z = row[TURN + 3 * j], row[TURN + 3 * j + 1], row[TURN + 3 * j + 2]
        half[j] = A[0] * x + A[1] * y + A[2] * z
        half[3 + j] = A[3] * x + A[4] * y + A[5] * z
        half[6 + j] = A[6] * x + A[7] * y + A[8] * z
    for i in range(3):
        x, y, z = row[TURN + 3 * i], row[TURN + 3 * i + 1], row[TURN + 3 * i + 2]
        for j in range(3):
            out[3 * i + j] = x * half[j] + y * half[3 + j] + z * half[6 + j]


@inner_kernel
def _give(row, of_parent, M, H, J, half):
    """Add inertia and force to the parent's: turned, then moved by r: H + r~ M, J + r~ H^T - (H + r~ M) r~."""
    x, y, z = row[WAY], row[WAY + 1], row[WAY + 2]
    _turned(row, INERTIA, True, M, half)
    _turned(row, COUPLING, False, H, half)
    _turned(row, MOMENT, True, J, half)
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
            of_parent[MOMENT + k] += J[3 * i + j] + shift[j]
            of_parent[INERTIA + k] += M[3 * i + j]
            k += 1
        for j in range(3):
            of_parent[COUPLING + 3 * i + j] += H[3 * i + j]
    for i in range(3):
        p, q, r = row[TURN + 3 * i], row[TURN + 3 * i + 1], row[TURN + 3 * i + 2]
        half[i] = p * row[FORCE] + q * row[FORCE + 1] + r * row[FORCE + 2]
        half[3 + i] = p * row[FORCE + 3] + q * row[FORCE + 4] + r * row[FORCE + 5]
    of_parent[FORCE] += half[0] + y * half[5] - z * half[4]
    of_parent[FORCE + 1] += half[1] + z * half[3] - x * half[5]
    of_parent[FORCE + 2] += half[2] + x * half[4] - y * half[3]
    for i in range(3):
        of_parent[FORCE + 3 + i] += half[3 + i]


@kernel
def gather(links, rows, blocks, tau):
    """Pass inertias and forces on to the parents, joints opened; return -1, or a link whose motion has no inertia.

    tau (nv,) : forces on the rates
    """
    M, H, J, half = np.empty(9), np.empty(9), np.empty(9), np.empty(9)
    for k in range(len(links) - 1, -1, -1):
        link, row = links[k], rows[k]
        row[DRIVE] = 0.0
        if link.kind == FRAME:
            if not _open_frame(link, row, blocks[link.block], tau):
                return k
            continue
        if link.kind == BALL:
            if not _open_ball(link, row, blocks[link.block], tau, half):
                return k
            row[BIAS : BIAS + 6] = 0.0
        elif link.kind == FIXED or link.driven == 1:
            row[BIAS : BIAS + 6] = 0.0
        elif not _open(link, row, tau):
            return k
        _force_with_swing(row)
        if link.parent >= 0:
            _give(row, rows[link.parent], M, H, J, half)
    return -1


@inner_kernel
def _several(link, row, block, column, a):
    """The accelerations of a ball or free frame: P' a = load, of which what is carried here is a part already."""
    at = link.rate
    n = 3 if link.kind == BALL else 6
    for i in range(n):
        column[i] = block[LOAD + i]
    solve_factor(block, n, column)
    if n == 3:
        for i in range(3):
            for j in range(3):
                column[i] -= block[GAIN + 3 * j + i] * row[RATE + 3 + j]
    for i in range(n):
        x = column[i]
        column[i] -= row[RATE + i]
        row[RATE + i] = x
    if n == 3:
        a[at], a[at + 1], a[at + 2] = read_axes(link, row, column[0], column[1], column[2])
    else:
        for i in range(3):
            a[at + i], a[at + 3 + i] = column[3 + i], column[i]


@kernel
def spread(links, rows, blocks, fall, weight, tau, a):
    """Write the second rates `a` (nv,), from the roots to the leaves; the forces on driven rates to `tau`.

    weight : 1.0 with the velocity terms and the ground's acceleration -fall (3,); 0.0 for the response to loads alone
    """
    n = len(links)
    column = np.empty(6)
    ground = rows[n]
    for i in range(3):
        ground[RATE + i], ground[RATE + 3 + i] = 0.0, -weight * fall[i]
    for k in range(n):
        link, row = links[k], rows[k]
        carry(row, rows[link.parent], RATE, RATE)
        if link.driven == 1 and weight != 0.0:
            U = _column(link, row)
            x = link.turn * row[FORCE + 2] + link.slide * row[FORCE + 5] - row[DRIVE]
            for i in range(6):
                x += U[i] * row[RATE + i]
            tau[link.rate] = link.sign * x
        for i in range(6):
            row[RATE + i] += weight * row[SWING + i]
        if link.kind == SINGLE and link.driven == 0:
            x = row[DRIVE] * row[DIVISOR]
            for i in range(6):
                x -= row[BIAS + i] * row[RATE + i]
            row[RATE + 2] += link.turn * x
            row[RATE + 5] += link.slide * x
            a[link.rate] = link.sign * x
        elif link.kind == BALL or link.kind == FRAME:
            _several(link, row, blocks[link.block], column, a)
