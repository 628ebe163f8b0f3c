"""Joints on whose links flexible bodies hang: articulated inertias that loads on bent bodies make unsymmetric.

In (angular, linear) of the link, six by six with two columns of zeros behind them.
A motion takes ``P S D S^T P``; theory, eq. (tree-open).
"""

from __future__ import annotations

import numpy as np

from flexmb.math.eights import WIDTH, crossing, keep, less, more, part, plus, put, read, same, times, totals
from flexmb.math.kernel import inner_kernel, kernel
from flexmb.tree.any_body.blocks import factor_block, solve_block
from flexmb.tree.flexible.six_rows import add_six, keep_six, read_six
from flexmb.tree.rigid.passes import SINGULAR
from flexmb.tree.rigid.places import BALL, FIXED, FRAME, SINGLE, carry, reach_axes, read_axes

__all__ = ["add_own", "clear_wide", "force_with_bias", "give_wide", "move_wide", "open_wide"]


_UP_0, _UP_1, _UP_2 = (
    crossing(0, 1, 2, 8, 9, 10, 6, 7),
    crossing(1, 3, 4, 11, 12, 13, 6, 7),
    crossing(2, 4, 5, 14, 15, 6, 6, 7),
)
_LOW_0, _LOW_1, _LOW_2 = (
    crossing(8, 11, 14, 0, 1, 2, 6, 7),
    crossing(9, 12, 15, 1, 3, 4, 6, 7),
    crossing(10, 13, 6, 2, 4, 5, 6, 7),
)
"""Rows of [J, H; H^T, M] of the six numbers of J or M, with zeros behind them, and the first eight of H."""


@kernel
def add_own(row, P):
    """Add the symmetric part of an inertia, its own and of rigid links on it, to the rest P (6, 8)."""
    J, M, H, last = part(row.J, 0, 6), part(row.M, 0, 6), read(row.H, (0, 0)), row.H[2, 2]
    up, low = put(_UP_2(J, H), 5, last), put(_LOW_2(M, H), 2, last)
    add_six(P, 0, _UP_0(J, H), _UP_1(J, H), up, _LOW_0(M, H), _LOW_1(M, H), low)


_COLUMN_0, _COLUMN_1, _COLUMN_2 = (
    crossing(0, 3, 6, 0, 3, 6, 14, 15),
    crossing(1, 4, 7, 1, 4, 7, 14, 15),
    crossing(2, 5, 8, 2, 5, 8, 14, 15),
)
"""A column of a rotation twice, of its first eight numbers and, first of the others, the ninth."""
_FIRST, _SECOND, _THIRD = (
    crossing(0, 0, 0, 3, 3, 3, 6, 7),
    crossing(1, 1, 1, 4, 4, 4, 6, 7),
    crossing(2, 2, 2, 5, 5, 5, 6, 7),
)
"""What the three columns are multiplied by, of a row of angular and linear numbers."""
_NEXT, _BEFORE = crossing(1, 2, 0, 3, 4, 5, 6, 7), crossing(2, 0, 1, 3, 4, 5, 6, 7)
_LINEAR_NEXT, _LINEAR_BEFORE = crossing(5, 3, 4, 6, 7, 6, 7, 7), crossing(4, 5, 3, 6, 7, 6, 7, 7)
"""Numbers of a cross product with the linear part of a row."""


@inner_kernel
def _moved_row(x, a, b, c, following, before):
    """Return a row of eight turned by the columns a, b, c, and moved by an arm in cyclic orders."""
    x = more(more(times(a, _FIRST(x, x)), b, _SECOND(x, x)), c, _THIRD(x, x))
    return less(more(x, following, _LINEAR_NEXT(x, x)), before, _LINEAR_BEFORE(x, x))


@kernel
def moved(row, P, force, out):
    """Write inertia P (6, 8) and force (6,) of a link in axes of its parent, about the parent's origin, to out (6, 8).

    X^T P X with ``X = diag(R, R)^T [1, 0; -r~, 1]``; the force is the seventh column.
    """
    R, r = row.R, row.r
    x, y, z = r[0], r[1], r[2]
    arm, zero = part(r, 0, 3), same(0.0)
    following, before = _NEXT(arm, arm), _BEFORE(arm, arm)
    whole, last = read(R, (0, 0)), put(zero, 0, R[2, 2])
    A, B, C = _COLUMN_0(whole, put(zero, 6, 1.0)), _COLUMN_1(whole, zero), _COLUMN_2(whole, last)
    a, b, c, d, e, f = read_six(P, 0)
    a, b, c = put(a, 6, force[0]), put(b, 6, force[1]), put(c, 6, force[2])
    d, e, f = put(d, 6, force[3]), put(e, 6, force[4]), put(f, 6, force[5])
    g = more(more(times(R[0, 0], a), R[0, 1], b), R[0, 2], c)
    h = more(more(times(R[1, 0], a), R[1, 1], b), R[1, 2], c)
    k = more(more(times(R[2, 0], a), R[2, 1], b), R[2, 2], c)
    a = more(more(times(R[0, 0], d), R[0, 1], e), R[0, 2], f)
    b = more(more(times(R[1, 0], d), R[1, 1], e), R[1, 2], f)
    c = more(more(times(R[2, 0], d), R[2, 1], e), R[2, 2], f)
    keep_six(
        out,
        0,
        _moved_row(less(more(g, y, c), z, b), A, B, C, following, before),
        _moved_row(less(more(h, z, a), x, c), A, B, C, following, before),
        _moved_row(less(more(k, x, b), y, a), A, B, C, following, before),
        _moved_row(a, A, B, C, following, before),
        _moved_row(b, A, B, C, following, before),
        _moved_row(c, A, B, C, following, before),
    )


@kernel
def force_with_bias(row, P):
    """Add P c to the force."""
    sums = np.empty(WIDTH)
    c, zero = part(row.bias, 0, 6), same(0.0)
    p, q, r, x, y, z = read_six(P, 0)
    keep(sums, 0, totals(times(c, p), times(c, q), times(c, r), times(c, x), times(c, y), times(c, z), zero, zero))
    for i in range(6):
        row.force[i] += sums[i]


@inner_kernel
def _open_single(link, row, P, gain, tau):
    """Subtract what the joint's one motion takes; False if it moves no inertia."""
    t, s = link.turn, link.slide
    for i in range(6):
        gain[i] = t * P[i, 2] + s * P[i, 5]
        row.gain[i] = t * P[2, i] + s * P[5, i]
    D = t * gain[2] + s * gain[5]  # negative beyond a body that is bent so far that it takes more than all inertia
    usual = t * t * max(abs(P[0, 0]), abs(P[1, 1]), abs(P[2, 2])) + s * s * max(
        abs(P[3, 3]), abs(P[4, 4]), abs(P[5, 5])
    )
    if not abs(D) > max(SINGULAR * usual, 1e-300):
        return False
    D = 1.0 / D
    row.mobility = D
    row.load = link.sign * tau[link.rate] - t * row.force[2] - s * row.force[5]
    taken = times(D, more(times(t, read(P, (2, 0))), s, read(P, (5, 0))))
    for i in range(6):
        row.gain[i] *= D
    for i in range(6):
        keep(P, (i, 0), less(read(P, (i, 0)), gain[i], taken))
    for i in range(6):
        gain[i] *= D
    return True


@inner_kernel
def _inverse(A, n, D):
    """Write the inverse of the leading (n, n) part of A, which is overwritten, to D; False if it is singular.

    A has three moments, and three masses behind them.
    """
    pivots, column = np.empty(6, np.int64), np.empty(6)
    usual = max(abs(A[0, 0]), abs(A[1, 1]), abs(A[2, 2]))
    if n == 6:
        usual = min(usual, max(abs(A[3, 3]), abs(A[4, 4]), abs(A[5, 5])))
    if not factor_block(A, n, pivots, max(SINGULAR * usual, 1e-300)):
        return False
    for j in range(n):
        for i in range(n):
            column[i] = 1.0 if i == j else 0.0
        solve_block(A, n, pivots, column)
        for i in range(n):
            D[i, j] = column[i]
    return True


@inner_kernel
def _open_several(link, row, P, block, factor, tau):
    """The same for a ball, which leaves M - C J^-1 B, or a free frame, which leaves nothing."""
    n, at = link.kind, link.rate
    A = np.empty((6, 6))
    for i in range(n):
        for j in range(n):
            A[i, j] = P[i, j]
    if not _inverse(A, n, factor.D):
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
def open_wide(link, row, wide, light, block, factor, tau):
    """Subtract what the joint's motion takes from inertia and force, velocity terms added; False without inertia.

    light : 1 if the link has no inertia of its own or of rigid links on it
    """
    P = wide.P
    row.load = 0.0
    if light == 0:
        add_own(row, P)
    if link.kind == FRAME or link.kind == BALL:
        if not _open_several(link, row, P, block, factor, tau):
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
def clear_wide(P):
    """Forget what was given to a link in the evaluation before."""
    for i in range(6):
        keep(P, (i, 0), same(0.0))


@kernel
def give_wide(row, P, of_parent, parent, first):
    """Give inertia P (6, 8) and force of a link to its parent, which replaces what is there if it is the `first`."""
    out = np.empty((6, WIDTH))
    moved(row, P, row.force, out)
    for i in range(6):
        of_parent.force[i] += out[i, 6]
        own = put(read(out, (i, 0)), 6, 0.0)
        keep(parent.P, (i, 0), own if first else plus(read(parent.P, (i, 0)), own))


@inner_kernel
def _several(link, row, block, factor, a):
    """The accelerations of a ball or free frame, of which what is carried here is a part already."""
    at, n = link.rate, link.kind
    column = np.empty(6)
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
def move_wide(link, row, wide, block, factor, of_parent, weight, tau, a):
    """Write the rate of a link and the second rates of its joint to `a`."""
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
        _several(link, row, block, factor, a)
