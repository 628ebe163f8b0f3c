"""Solutions with the factors of `flexmb.math.block_lu`, which stand in S with the reciprocals of the pivots."""

from __future__ import annotations

from flexmb.math.block_pattern import BlockPattern
from flexmb.math.kernel import entry_kernel, inner_kernel, kernel
from flexmb.math.structures import array_type, numba_type
from flexmb.math.tables import FLOATS

__all__ = ["lu_solve", "lu_solve_softened", "subtract_product"]


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
