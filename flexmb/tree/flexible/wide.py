"""Joints on whose links flexible bodies hang: articulated inertias that loads on bent bodies make unsymmetric.

In (angular, linear) of the link, six by six. A motion takes ``P S D S^T P``; theory, eq. (tree-open).
"""

from __future__ import annotations

from flexmb.math.kernel import inner_kernel, kernel
from flexmb.tree.any_body.blocks import factor_block, solve_block
from flexmb.tree.rigid.places import BALL, FIXED, FRAME, SINGLE, carry, reach_axes, read_axes

__all__ = ["add_own", "give_wide", "move_wide", "open_wide"]


@kernel
def add_own(row, P):
    """Add the symmetric part of an inertia, its own and of rigid links on it, to the rest P."""
    k = 0
    for i in range(3):
        for j in range(i, 3):
            P[i, j] += row.J[k]
            P[3 + i, 3 + j] += row.M[k]
            if j > i:
                P[j, i] += row.J[k]
                P[3 + j, 3 + i] += row.M[k]
            k += 1
        for j in range(3):
            P[i, 3 + j] += row.H[i, j]
            P[3 + j, i] += row.H[i, j]


@kernel
def moved(R, r, A, half, out):
    """Write inertia and force A (6, 8) of a link in axes of its parent, about the parent's origin, to `out`.

    X^T A X with ``X = diag(R, R)^T [1, 0; -r~, 1]``; half (6, 8) is scratch.
    """
    for h in range(0, 6, 3):
        for i in range(3):
            a, b, c = R[i, 0], R[i, 1], R[i, 2]
            for j in range(8):
                half[h + i, j] = a * A[h, j] + b * A[h + 1, j] + c * A[h + 2, j]
    for i in range(6):
        for h in range(0, 6, 3):
            x, y, z = half[i, h], half[i, h + 1], half[i, h + 2]
            for j in range(3):
                out[i, h + j] = R[j, 0] * x + R[j, 1] * y + R[j, 2] * z
        out[i, 6], out[i, 7] = half[i, 6], 0.0
    x, y, z = r[0], r[1], r[2]
    for j in range(7):
        a, b, c = out[3, j], out[4, j], out[5, j]
        out[0, j] += y * c - z * b
        out[1, j] += z * a - x * c
        out[2, j] += x * b - y * a
    for i in range(6):
        a, b, c = out[i, 3], out[i, 4], out[i, 5]
        out[i, 0] += y * c - z * b
        out[i, 1] += z * a - x * c
        out[i, 2] += x * b - y * a


@kernel
def force_with_bias(row, P):
    """Add P c to the force."""
    for i in range(6):
        x = 0.0
        for j in range(6):
            x += P[i, j] * row.bias[j]
        row.force[i] += x


@inner_kernel
def _open_single(link, row, P, gain, tau):
    """Subtract what the joint's one motion takes; False if it moves no inertia."""
    t, s = link.turn, link.slide
    for i in range(6):
        gain[i] = t * P[i, 2] + s * P[i, 5]
        row.gain[i] = t * P[2, i] + s * P[5, i]
    D = t * gain[2] + s * gain[5]
    if not D > 1e-300:
        return False
    D = 1.0 / D
    row.mobility = D
    row.load = link.sign * tau[link.rate] - t * row.force[2] - s * row.force[5]
    for i in range(6):
        row.gain[i] *= D
    for i in range(6):
        for j in range(6):
            P[i, j] -= gain[i] * row.gain[j]
    for i in range(6):
        gain[i] *= D
    return True


@inner_kernel
def _inverse(A, n, D, pivots, column):
    """Write the inverse of the leading (n, n) part of A, which is overwritten, to D; False if it is singular."""
    if not factor_block(A, n, pivots, 1e-300):
        return False
    for j in range(n):
        for i in range(n):
            column[i] = 1.0 if i == j else 0.0
        solve_block(A, n, pivots, column)
        for i in range(n):
            D[i, j] = column[i]
    return True


@inner_kernel
def _open_several(link, row, P, block, factor, tau, A, pivots, column):
    """The same for a ball, which leaves M - C J^-1 B, or a free frame, which leaves nothing."""
    n, at = link.kind, link.rate
    for i in range(n):
        for j in range(n):
            A[i, j] = P[i, j]
    if not _inverse(A, n, factor.D, pivots, column):
        return False
    if n == 6:
        for i in range(3):
            block.load[i] = tau[at + 3 + i] - row.force[i]
            block.load[3 + i] = tau[at + i] - row.force[3 + i]
        return True
    x, y, z = reach_axes(link, row, tau[at], tau[at + 1], tau[at + 2])
    block.load[0], block.load[1], block.load[2] = x - row.force[0], y - row.force[1], z - row.force[2]
    for i in range(3):
        for j in range(3):
            x, y = 0.0, 0.0
            for k in range(3):
                x += P[3 + i, k] * factor.D[k, j]
                y += factor.D[i, k] * P[k, 3 + j]
            factor.column[i, j], factor.row[i, j] = x, y
    for i in range(3):
        for j in range(3):
            for k in range(3):
                P[3 + i, 3 + j] -= factor.column[i, k] * P[k, 3 + j]
    for i in range(3):
        row.force[i] += block.load[i]
        for k in range(3):
            row.force[3 + i] += factor.column[i, k] * block.load[k]
    P[:3, :] = 0.0
    P[3:, :3] = 0.0
    return True


@kernel
def open_wide(link, row, wide, block, factor, tau, A, pivots, column):
    """Subtract what the joint's motion takes from inertia and force, velocity terms added; False without inertia.

    A (6, 6), pivots (6,) of integers, column (6,) : scratch
    """
    P = wide.P
    row.load = 0.0
    add_own(row, P)
    if link.kind == FRAME or link.kind == BALL:
        if not _open_several(link, row, P, block, factor, tau, A, pivots, column):
            return False
        if link.kind == FRAME:
            return True
        row.gain[:] = 0.0
        wide.gain[:] = 0.0
    elif link.kind == FIXED or link.driven == 1:
        row.gain[:] = 0.0
        wide.gain[:] = 0.0
    elif not _open_single(link, row, P, wide.gain, tau):
        return False
    force_with_bias(row, P)
    for i in range(6):
        row.force[i] += wide.gain[i] * row.load
    return True


@kernel
def give_wide(row, P, force, of_parent, parent, A, half, out):
    """Add inertia P (6, 6) and force (6,) of a link to its parent's; three (6, 8) are scratch."""
    for i in range(6):
        for j in range(6):
            A[i, j] = P[i, j]
        A[i, 6], A[i, 7] = force[i], 0.0
    moved(row.R, row.r, A, half, out)
    for i in range(6):
        of_parent.force[i] += out[i, 6]
        for j in range(6):
            parent.P[i, j] += out[i, j]


@inner_kernel
def _several(link, row, block, factor, column, a):
    """The accelerations of a ball or free frame, of which what is carried here is a part already."""
    at, n = link.rate, link.kind
    for i in range(n):
        x = 0.0
        for j in range(n):
            x += factor.D[i, j] * block.load[j]
        column[i] = x
    if n == 3:
        for i in range(3):
            for j in range(3):
                column[i] -= factor.row[i, j] * row.rate[3 + j]
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
def move_wide(link, row, wide, block, factor, of_parent, weight, tau, column, a):
    """Write the rate of a link and the second rates of its joint to `a`; column (6,) is scratch."""
    carry(row, of_parent.rate, row.rate)
    if link.driven == 1 and weight != 0.0:
        x = link.turn * row.force[2] + link.slide * row.force[5] - row.load
        for i in range(6):
            x += (link.turn * wide.P[2, i] + link.slide * wide.P[5, i]) * row.rate[i]
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
        _several(link, row, block, factor, column, a)
