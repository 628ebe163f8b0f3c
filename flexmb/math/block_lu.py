"""Sparse LU with a static block pattern: the order and the fill are found once, the numbers often.

Rows are grouped in blocks (the freedoms of a body, the multipliers of a joint); all rows of a block have the same
columns, stored as contiguous segments, and which block changes which columns of which is listed beforehand, so the
inner loops run over contiguous memory. There is no pivoting: the order
(system room, `pattern`) puts a body before its multipliers, which keeps every pivot away from zero; a vanishing pivot
is reported with its row. The place of a pivot holds its reciprocal afterwards: the factors are all in S, and matrices
of one pattern do not touch each other's. Source of the row-wise form: Davis, Direct Methods for Sparse Linear Systems,
2006, ch. 6.
"""

from __future__ import annotations

from flexmb.math.block_pattern import BlockPattern
from flexmb.math.kernel import entry_kernel, inner_kernel, kernel
from flexmb.math.structures import array_type, numba_type
from flexmb.math.tables import FLOATS

__all__ = ["lu_factor", "lu_solve", "lu_solve_softened", "subtract_product"]

VANISHING = 1e-14
"""A pivot below this, relative to its row and to the terms whose difference it is, has no digits left."""


@inner_kernel
def _eliminate(S, p, s, base, n, width):
    """Subtract the multiples of an earlier block's rows from `n` rows that begin at `base`."""
    block = p.source[s]
    first = p.block_start[block]
    m = p.block_start[block + 1] - first
    start = p.row_start[first]
    stride = p.row_start[first + 1] - start
    own = p.own[block]
    for i in range(n):
        row = base + i * width
        left = row + p.at[s]
        for k in range(m):
            x = S[left + k]
            if x == 0.0:
                continue
            pivot_row = start + k * stride
            f = x * S[pivot_row + own + k]
            S[left + k] = f
            for t in range(k + 1, m):
                S[left + t] -= f * S[pivot_row + own + t]
            for r in range(p.run_start[s], p.run_start[s + 1]):
                to, source = row + p.run_to[r], pivot_row + p.run_from[r]
                for t in range(p.run_length[r]):
                    S[to + t] -= f * S[source + t]


@inner_kernel
def _eliminate_six(S, p, s, base, n, width):
    """`_eliminate` for an earlier block of six rows: a node or a body. The row's multipliers stay in registers."""
    block = p.source[s]
    first = p.block_start[block]
    start = p.row_start[first]
    stride = p.row_start[first + 1] - start
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
                x[0] *= g0
                x[1] = (x[1] - x[0] * u0[1]) * g1
                x[2] = (x[2] - x[0] * u0[2] - x[1] * u1[2]) * g2
                x[3] = (x[3] - x[0] * u0[3] - x[1] * u1[3] - x[2] * u2[3]) * g3
                x[4] = (x[4] - x[0] * u0[4] - x[1] * u1[4] - x[2] * u2[4] - x[3] * u3[4]) * g4
                x[5] = (x[5] - x[0] * u0[5] - x[1] * u1[5] - x[2] * u2[5] - x[3] * u3[5] - x[4] * u4[5]) * g5
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
        while k + 1 < i:
            # two rows above at a time: each value of this row is loaded and stored half as often
            above, below = S[corner + k * width :][:columns], S[corner + (k + 1) * width :][:columns]
            f = row[k] * above[k]
            g = (row[k + 1] - f * above[k + 1]) * below[k + 1]
            row[k], row[k + 1] = f, g
            k += 2
            for t in range(k, columns):
                row[t] -= f * above[t] + g * below[t]
        if k < i:
            above = S[corner + k * width :][:columns]
            f = row[k] * above[k]
            row[k] = f
            for t in range(k + 1, columns):
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
            row, largest = base + i * width, 0.0
            for t in range(width):
                largest = max(largest, abs(S[row + t]))
            p.scratch[first + i] = abs(S[row + own + i])
            p.scratch[len(p.order) + first + i] = largest
        for s in range(p.step_start[block], p.step_start[block + 1]):
            if p.block_start[p.source[s] + 1] - p.block_start[p.source[s]] == 6:
                _eliminate_six(S, p, s, base, n, width)
            else:
                _eliminate(S, p, s, base, n, width)
            earlier = p.block_start[p.source[s]]
            stride = p.row_start[earlier + 1] - p.row_start[earlier]
            corner = p.row_start[earlier] + p.own[p.source[s]]
            for k in range(p.block_start[p.source[s] + 1] - earlier):
                pivot = 1.0 / abs(S[corner + k * (stride + 1)])
                for i in range(n):
                    x = S[base + i * width + p.at[s] + k]
                    p.scratch[first + i] += x * x * pivot
        if n == 6:
            failed = _factor_six(S, p, first, base + own, width, width - own)
        else:
            failed = _factor_own(S, p, first, n, base + own, width, width - own)
        if failed >= 0:
            return failed
    return -1


@inner_kernel
def _products(S, p, segments, last_segment, base, n, width, w, x):
    """Subtract the product of segments of the n rows that begin at `base` with w from x (n,)."""
    for i in range(n):
        at, total = base + i * width, x[i]
        for s in range(segments, last_segment):
            m = p.length[s]
            row, y = S[at : at + m], w[p.column[s] :][:m]
            for t in range(m):
                total -= row[t] * y[t]
            at += m
        x[i] = total


@inner_kernel
def _products_six(S, p, segments, last_segment, base, width, w, x):
    """`_products` for six rows: six sums grow side by side, none waits for another."""
    x0, x1, x2, x3, x4, x5 = x[0], x[1], x[2], x[3], x[4], x[5]
    for s in range(segments, last_segment):
        n = p.length[s]
        y = w[p.column[s] :][:n]
        a, b, c = S[base : base + n], S[base + width :][:n], S[base + 2 * width :][:n]
        d, e, f = S[base + 3 * width :][:n], S[base + 4 * width :][:n], S[base + 5 * width :][:n]
        for t in range(n):
            x0 -= a[t] * y[t]
            x1 -= b[t] * y[t]
            x2 -= c[t] * y[t]
            x3 -= d[t] * y[t]
            x4 -= e[t] * y[t]
            x5 -= f[t] * y[t]
        base += n
    x[0], x[1], x[2], x[3], x[4], x[5] = x0, x1, x2, x3, x4, x5


@inner_kernel
def _lower(S, corner, n, width, x):
    """Solve L x = x in place with the unit triangle of n rows whose first number is S[corner]."""
    for i in range(1, n):
        row, total = S[corner + i * width :][:n], x[i]
        for k in range(i):
            total -= row[k] * x[k]
        x[i] = total


@inner_kernel
def _lower_six(S, corner, width, x):
    """`_lower` for six rows."""
    b, c, d = S[corner + width :][:6], S[corner + 2 * width :][:6], S[corner + 3 * width :][:6]
    e, f = S[corner + 4 * width :][:6], S[corner + 5 * width :][:6]
    x0 = x[0]
    x1 = x[1] - b[0] * x0
    x2 = x[2] - c[0] * x0 - c[1] * x1
    x3 = x[3] - d[0] * x0 - d[1] * x1 - d[2] * x2
    x4 = x[4] - e[0] * x0 - e[1] * x1 - e[2] * x2 - e[3] * x3
    x5 = x[5] - f[0] * x0 - f[1] * x1 - f[2] * x2 - f[3] * x3 - f[4] * x4
    x[1], x[2], x[3], x[4], x[5] = x1, x2, x3, x4, x5


@inner_kernel
def _upper(S, corner, n, width, x):
    """Solve U x = x in place with the triangle of n rows whose first number is S[corner]."""
    for i in range(n - 1, -1, -1):
        row, total = S[corner + i * width :][:n], x[i]
        for k in range(i + 1, n):
            total -= row[k] * x[k]
        x[i] = total * row[i]


@inner_kernel
def _upper_six(S, corner, width, x):
    """`_upper` for six rows."""
    a, b, c = S[corner : corner + 6], S[corner + width :][:6], S[corner + 2 * width :][:6]
    d, e, f = S[corner + 3 * width :][:6], S[corner + 4 * width :][:6], S[corner + 5 * width :][:6]
    x5 = x[5] * f[5]
    x4 = (x[4] - e[5] * x5) * e[4]
    x3 = (x[3] - d[5] * x5 - d[4] * x4) * d[3]
    x2 = (x[2] - c[5] * x5 - c[4] * x4 - c[3] * x3) * c[2]
    x1 = (x[1] - b[5] * x5 - b[4] * x4 - b[3] * x3 - b[2] * x2) * b[1]
    x0 = (x[0] - a[5] * x5 - a[4] * x4 - a[3] * x3 - a[2] * x2 - a[1] * x1) * a[0]
    x[0], x[1], x[2], x[3], x[4], x[5] = x0, x1, x2, x3, x4, x5


@inner_kernel
def _substitute(S, p, b):
    """Solve L U x = b in place, unknowns in their natural order."""
    w = p.scratch
    for row in range(len(p.order)):
        w[row] = b[p.order[row]]
    blocks = len(p.own)
    for turn in range(2 * blocks):
        block = turn if turn < blocks else 2 * blocks - 1 - turn
        first = p.block_start[block]
        n = p.block_start[block + 1] - first
        if n > 0:
            base = p.row_start[first]
            width = p.row_start[first + 1] - base
            own = base + p.own[block]
            x = w[first : first + n]
            if turn < blocks:
                start, stop = p.segment_start[block], p.own_segment[block]
            else:
                start, stop, base = p.own_segment[block] + 1, p.segment_start[block + 1], own + n
            if n == 6:
                _products_six(S, p, start, stop, base, width, w, x)
                if turn < blocks:
                    _lower_six(S, own, width, x)
                else:
                    _upper_six(S, own, width, x)
            else:
                _products(S, p, start, stop, base, n, width, w, x)
                if turn < blocks:
                    _lower(S, own, n, width, x)
                else:
                    _upper(S, own, n, width, x)
    for row in range(len(p.order)):
        b[p.order[row]] = w[row]


@entry_kernel(array_type(FLOATS), numba_type(BlockPattern), array_type(FLOATS))
def lu_solve(S, p, b):
    """Solve L U x = b in place, unknowns in their natural order; what dependent equations contradict is left out.

    With [M, -G^T; G, R] x = (f, b) the part of b that no motion can satisfy comes back as R lam, large multipliers that
    do no work. It is measured by a first solve and taken out; the next one leaves what the rounding of the small pivots
    hid. So a misfit of dependent equations (mesh tolerance) stresses nothing, and everything else is solved as before.
    """
    softened = len(p.softness) > 0
    given = b.copy() if softened else b
    for turn in range(3 if softened else 1):
        if turn > 0:
            for i in range(len(b)):
                given[i] -= p.softness[i] * b[i]
                b[i] = given[i]
        _substitute(S, p, b)


@kernel
def lu_solve_softened(S, p, b):
    """Solve L U x = b in place, unknowns in their natural order, with dependent equations as soft as they were made."""
    _substitute(S, p, b)


@kernel
def subtract_product(S, p, x, b):
    """Subtract S x from b in place, both in the natural order of unknowns: S as it is before factorisation."""
    n = len(p.order)
    w, left = p.scratch[:n], p.scratch[n:]
    for row in range(n):
        w[row] = x[p.order[row]]
        left[row] = b[p.order[row]]
    for block in range(len(p.own)):
        first = p.block_start[block]
        rows = p.block_start[block + 1] - first
        if rows > 0:
            base = p.row_start[first]
            width = p.row_start[first + 1] - base
            start, stop = p.segment_start[block], p.segment_start[block + 1]
            _products(S, p, start, stop, base, rows, width, w, left[first : first + rows])
    for row in range(n):
        b[p.order[row]] = left[row]
