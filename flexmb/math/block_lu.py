"""Sparse LU with a static block pattern: the order and the fill are found once, the numbers often.

Rows are grouped in blocks (the freedoms of a body, the multipliers of a joint); all rows of a block have the same
columns, stored as contiguous segments, and which block changes which columns of which is listed beforehand, so the
inner loops run over contiguous memory. There is no pivoting: the order (system room, `pattern`) puts a body before its
multipliers, which keeps every pivot away from zero; a vanishing pivot is reported with its row. The place of a pivot
holds its reciprocal afterwards: the factors are all in S, and matrices of one pattern do not touch each other's.
Solutions: `flexmb.math.block_substitution`. Source of the row-wise form: Davis, Direct Methods for Sparse Linear
Systems, 2006, ch. 6.
"""

from __future__ import annotations

import numpy as np

from flexmb.math.block_pattern import BlockPattern
from flexmb.math.kernel import entry_kernel, inner_kernel
from flexmb.math.kernel_on_demand import KernelOnDemand, kernel_on_demand
from flexmb.math.structures import array_type, numba_type
from flexmb.math.tables import COUNT, FLOATS, void

__all__ = ["eliminate", "lu_factor", "on_demand_for"]

VANISHING = 1e-14
"""A pivot below this, relative to its row and to the terms whose difference it is, has no digits left."""


@inner_kernel
def _largest(row):
    """Return the largest size of the numbers of a row: four grow side by side, none waits for another."""
    a, b, c, d = 0.0, 0.0, 0.0, 0.0
    n = len(row) // 4 * 4
    for t in range(0, n, 4):
        a, b = max(a, abs(row[t])), max(b, abs(row[t + 1]))
        c, d = max(c, abs(row[t + 2])), max(d, abs(row[t + 3]))
    for t in range(n, len(row)):
        a = max(a, abs(row[t]))
    return max(max(a, b), max(c, d))


@kernel_on_demand(void, array_type(FLOATS), numba_type(BlockPattern), *[COUNT] * 5)
def eliminate(S, p, s, base, first, n, width):
    """Subtract the multiples of an earlier block's rows from `n` rows that begin at `base`, the first of which is
    `first`; add to their scratch what the products are worth beside a pivot.

    Four rows of the earlier block at a time: each value of a row is loaded and stored a quarter as often. A rigid body
    on one joint has earlier blocks of six rows only.
    """
    block = p.source[s]
    m = p.block_start[block + 1] - p.block_start[block]
    start = p.row_start[p.block_start[block]]
    stride = p.row_start[p.block_start[block] + 1] - start
    own = start + p.own[block]
    begin, end = p.run_start[s], p.run_start[s + 1]
    for i in range(n):
        row = base + i * width
        x, made_of, k = S[row + p.at[s] :][:m], 0.0, 0
        while k + 3 < m:
            at = own + k * stride + k
            b, c, d = at + stride, at + 2 * stride, at + 3 * stride
            x0 = x[k]
            f0 = x0 * S[at]
            x1 = x[k + 1] - f0 * S[at + 1]
            f1 = x1 * S[b + 1]
            x2 = x[k + 2] - f0 * S[at + 2] - f1 * S[b + 2]
            f2 = x2 * S[c + 2]
            x3 = x[k + 3] - f0 * S[at + 3] - f1 * S[b + 3] - f2 * S[c + 3]
            f3 = x3 * S[d + 3]
            x[k], x[k + 1], x[k + 2], x[k + 3] = f0, f1, f2, f3
            worth = (abs(x0 * f0) + abs(x1 * f1)) + (abs(x2 * f2) + abs(x3 * f3))
            if worth != 0.0:
                made_of += worth
                left = m - k - 4
                y, u, v = x[k + 4 :], S[at + 4 :][:left], S[b + 4 :][:left]
                g, h = S[c + 4 :][:left], S[d + 4 :][:left]
                for t in range(left):
                    y[t] -= (f0 * u[t] + f1 * v[t]) + (f2 * g[t] + f3 * h[t])
                above = start + k * stride
                for r in range(begin, end):
                    length, source = p.run_length[r], above + p.run_from[r]
                    y, u, v = S[row + p.run_to[r] :][:length], S[source:][:length], S[source + stride :][:length]
                    g, h = S[source + 2 * stride :][:length], S[source + 3 * stride :][:length]
                    for t in range(length):
                        y[t] -= (f0 * u[t] + f1 * v[t]) + (f2 * g[t] + f3 * h[t])
            k += 4
        while k < m:
            x0 = x[k]
            if x0 != 0.0:
                f0 = x0 * S[own + k * stride + k]
                x[k] = f0
                made_of += abs(x0 * f0)
                u = S[own + k * stride :][:m]
                for t in range(k + 1, m):
                    x[t] -= f0 * u[t]
                above = start + k * stride
                for r in range(begin, end):
                    length = p.run_length[r]
                    y, u = S[row + p.run_to[r] :][:length], S[above + p.run_from[r] :][:length]
                    for t in range(length):
                        y[t] -= f0 * u[t]
            k += 1
        p.scratch[first + i] += made_of


def on_demand_for(p: BlockPattern) -> tuple[KernelOnDemand, ...]:
    """Return what `lu_factor` calls on demand for matrices of a pattern."""
    rows = np.diff(p.block_start)[p.source]
    return (eliminate,) if np.any(rows != 6) else ()


@inner_kernel
def _eliminate_six(S, p, s, base, first, n, width):
    """`eliminate` for an earlier block of six rows: a node or a body. The row's multipliers stay in registers."""
    block = p.source[s]
    start = p.row_start[p.block_start[block]]
    stride = p.row_start[p.block_start[block] + 1] - start
    own = start + p.own[block]
    u0, u1, u2 = S[own : own + 6], S[own + stride :][:6], S[own + 2 * stride :][:6]
    u3, u4, u5 = S[own + 3 * stride :][:6], S[own + 4 * stride :][:6], S[own + 5 * stride :][:6]
    g0, g1, g2, g3, g4, g5 = u0[0], u1[1], u2[2], u3[3], u4[4], u5[5]
    for r in range(p.run_start[s], p.run_start[s + 1]):
        m, at = p.run_length[r], start + p.run_from[r]
        a, b, c = S[at : at + m], S[at + stride :][:m], S[at + 2 * stride :][:m]
        d, e, f = S[at + 3 * stride :][:m], S[at + 4 * stride :][:m], S[at + 5 * stride :][:m]
        for i in range(n):
            row = base + i * width
            x = S[row + p.at[s] :][:6]
            if r == p.run_start[s]:
                x0 = x[0]
                x[0] = x0 * g0
                x1 = x[1] - x[0] * u0[1]
                x[1] = x1 * g1
                x2 = x[2] - x[0] * u0[2] - x[1] * u1[2]
                x[2] = x2 * g2
                x3 = x[3] - x[0] * u0[3] - x[1] * u1[3] - x[2] * u2[3]
                x[3] = x3 * g3
                x4 = x[4] - x[0] * u0[4] - x[1] * u1[4] - x[2] * u2[4] - x[3] * u3[4]
                x[4] = x4 * g4
                x5 = x[5] - x[0] * u0[5] - x[1] * u1[5] - x[2] * u2[5] - x[3] * u3[5] - x[4] * u4[5]
                x[5] = x5 * g5
                made_of = (abs(x0 * x[0]) + abs(x1 * x[1])) + (abs(x2 * x[2]) + abs(x3 * x[3]))
                p.scratch[first + i] += made_of + (abs(x4 * x[4]) + abs(x5 * x[5]))
            f0, f1, f2, f3, f4, f5 = x[0], x[1], x[2], x[3], x[4], x[5]
            y = S[row + p.run_to[r] :][:m]
            for t in range(m):
                y[t] -= (f0 * a[t] + f1 * b[t]) + (f2 * c[t] + f3 * d[t]) + (f4 * e[t] + f5 * f[t])


@inner_kernel
def _factor_own(S, p, first, n, corner, width, columns):
    """Factorise the `n` rows of a block from its own columns on; return -1, or the row whose pivot vanishes."""
    for i in range(n):
        row = S[corner + i * width :][:columns]
        k = 0
        while k + 3 < i:
            # four rows above at a time: each value of this row is loaded and stored a quarter as often
            at = corner + k * width
            a, b = S[at:][:columns], S[at + width :][:columns]
            c, d = S[at + 2 * width :][:columns], S[at + 3 * width :][:columns]
            f = row[k] * a[k]
            g = (row[k + 1] - f * a[k + 1]) * b[k + 1]
            h = (row[k + 2] - f * a[k + 2] - g * b[k + 2]) * c[k + 2]
            o = (row[k + 3] - f * a[k + 3] - g * b[k + 3] - h * c[k + 3]) * d[k + 3]
            row[k], row[k + 1], row[k + 2], row[k + 3] = f, g, h, o
            k += 4
            for t in range(k, columns):
                row[t] -= (f * a[t] + g * b[t]) + (h * c[t] + o * d[t])
        while k < i:
            above = S[corner + k * width :][:columns]
            f = row[k] * above[k]
            row[k] = f
            k += 1
            for t in range(k, columns):
                row[t] -= f * above[t]
        pivot, made_of = row[i], p.scratch[first + i]
        for k in range(i):
            made_of += row[k] * row[k] / abs(S[corner + k * (width + 1)])
        if not abs(pivot) > VANISHING * min(made_of, p.scratch[len(p.order) + first + i]):
            return first + i
        row[i] = 1.0 / pivot
    return -1


@inner_kernel
def _factor_six(S, p, first, corner, width, columns):
    """`_factor_own` for a block of six rows: every row at once by all rows above it."""
    r0, r1 = S[corner : corner + columns], S[corner + width :][:columns]
    r2, r3 = S[corner + 2 * width :][:columns], S[corner + 3 * width :][:columns]
    r4, r5 = S[corner + 4 * width :][:columns], S[corner + 5 * width :][:columns]
    g0 = 1.0 / r0[0]
    a = r1[0] * g0
    r1[0] = a
    for t in range(1, columns):
        r1[t] -= a * r0[t]
    g1 = 1.0 / r1[1]
    a = r2[0] * g0
    b = (r2[1] - a * r0[1]) * g1
    r2[0], r2[1] = a, b
    for t in range(2, columns):
        r2[t] -= a * r0[t] + b * r1[t]
    g2 = 1.0 / r2[2]
    a = r3[0] * g0
    b = (r3[1] - a * r0[1]) * g1
    c = (r3[2] - a * r0[2] - b * r1[2]) * g2
    r3[0], r3[1], r3[2] = a, b, c
    for t in range(3, columns):
        r3[t] -= a * r0[t] + b * r1[t] + c * r2[t]
    g3 = 1.0 / r3[3]
    a = r4[0] * g0
    b = (r4[1] - a * r0[1]) * g1
    c = (r4[2] - a * r0[2] - b * r1[2]) * g2
    d = (r4[3] - a * r0[3] - b * r1[3] - c * r2[3]) * g3
    r4[0], r4[1], r4[2], r4[3] = a, b, c, d
    for t in range(4, columns):
        r4[t] -= (a * r0[t] + b * r1[t]) + (c * r2[t] + d * r3[t])
    g4 = 1.0 / r4[4]
    a = r5[0] * g0
    b = (r5[1] - a * r0[1]) * g1
    c = (r5[2] - a * r0[2] - b * r1[2]) * g2
    d = (r5[3] - a * r0[3] - b * r1[3] - c * r2[3]) * g3
    e = (r5[4] - a * r0[4] - b * r1[4] - c * r2[4] - d * r3[4]) * g4
    r5[0], r5[1], r5[2], r5[3], r5[4] = a, b, c, d, e
    for t in range(5, columns):
        r5[t] -= (a * r0[t] + b * r1[t]) + (c * r2[t] + d * r3[t]) + e * r4[t]
    r0[0], r1[1], r2[2], r3[3], r4[4], r5[5] = g0, g1, g2, g3, g4, 1.0 / r5[5]
    for i in range(6):
        made_of, row = p.scratch[first + i], S[corner + i * width :][:6]
        for k in range(i):
            made_of += row[k] * row[k] / abs(S[corner + k * (width + 1)])
        if not abs(row[i]) * VANISHING * min(made_of, p.scratch[len(p.order) + first + i]) < 1.0:
            return first + i
    return -1


@entry_kernel(array_type(FLOATS), numba_type(BlockPattern))
def lu_factor(S, p):
    """Factorise S = L U in place; return -1, or the first row (place) whose pivot vanishes or is not finite.

    A pivot is the difference of the diagonal and of products L_ik U_ki. It vanishes if it is small beside its row, and
    no digits of these are left: masses, moments of inertia and gradients have different units, so that the row alone
    says little; nor do the products alone, which are large behind the pivots of equations that depend on each other.
    The matrix is nearly symmetric but for signs, so that the products are about L_ik^2 U_kk.
    """
    for block in range(len(p.own)):
        first = p.block_start[block]
        n = p.block_start[block + 1] - first
        if n == 0:
            continue
        base = p.row_start[first]
        width = p.row_start[first + 1] - base
        own = p.own[block]
        for i in range(n):
            row = S[base + i * width :][:width]
            p.scratch[first + i] = abs(row[own + i])
            p.scratch[len(p.order) + first + i] = _largest(row)
        for s in range(p.step_start[block], p.step_start[block + 1]):
            if p.block_start[p.source[s] + 1] - p.block_start[p.source[s]] == 6:
                _eliminate_six(S, p, s, base, first, n, width)
            else:
                eliminate(S, p, s, base, first, n, width)
        if n == 6:
            failed = _factor_six(S, p, first, base + own, width, width - own)
        else:
            failed = _factor_own(S, p, first, n, base + own, width, width - own)
        if failed >= 0:
            return failed
    return -1
