"""Sparse LU with a static block pattern: the order and the fill are found once, the numbers often.

Rows are grouped in blocks (the freedoms of a body, the multipliers of a joint); all rows of a block have the same
columns, stored as contiguous segments, so the inner loops run over contiguous memory. There is no pivoting: the order
(system room, `pattern`) puts a body before its multipliers, which keeps every pivot away from zero; a vanishing pivot
is reported with its row. Source of the row-wise form: Davis, Direct Methods for Sparse Linear Systems, 2006, ch. 6.
"""

from __future__ import annotations

from collections import namedtuple

import numpy as np

from flexmb.math.kernel import kernel

__all__ = ["BlockPattern", "lu_factor", "lu_solve"]

BlockPattern = namedtuple("BlockPattern", "order row_start row_block segment_start column length inverse scratch")
"""order (n,): unknown at each place; row_start (n + 1,): first value of each row; row_block (n,);
segment_start (blocks + 1,); column, length (segments,): first place and number of columns of each segment;
inverse (n,): reciprocal pivots, written by `lu_factor`; scratch (n,)."""


@kernel
def lu_factor(S, p):
    """Factorise S = L U in place; return -1, or the first row (place) whose pivot vanishes or is not finite."""
    w = p.scratch
    for row in range(len(p.row_block)):
        block = p.row_block[row]
        first, last = p.segment_start[block], p.segment_start[block + 1]
        at = p.row_start[row]
        largest = 0.0
        for s in range(first, last):
            c, m = p.column[s], p.length[s]
            for t in range(m):
                w[c + t] = S[at + t]
                largest = max(largest, abs(S[at + t]))
            at += m
        for s in range(first, last):
            c = p.column[s]
            if c >= row:
                break
            for k in range(c, min(c + p.length[s], row)):
                if w[k] == 0.0:
                    continue
                f = w[k] * p.inverse[k]
                w[k] = f
                inner = p.row_block[k]
                source = p.row_start[k]
                for r in range(p.segment_start[inner], p.segment_start[inner + 1]):
                    c2, m2 = p.column[r], p.length[r]
                    if c2 + m2 > k + 1:
                        skip = max(0, k + 1 - c2)
                        for t in range(skip, m2):
                            w[c2 + t] -= f * S[source + t]
                    source += m2
        pivot = w[row]
        if not abs(pivot) > 1e-14 * largest:
            return row
        p.inverse[row] = 1.0 / pivot
        at = p.row_start[row]
        for s in range(first, last):
            c, m = p.column[s], p.length[s]
            for t in range(m):
                S[at + t] = w[c + t]
            at += m
    return -1


@kernel
def lu_solve(S, p, b):
    """Solve L U x = b in place, unknowns in their natural order."""
    w = p.scratch
    n = len(p.row_block)
    for row in range(n):
        block = p.row_block[row]
        at = p.row_start[row]
        x = b[p.order[row]]
        for s in range(p.segment_start[block], p.segment_start[block + 1]):
            c = p.column[s]
            if c >= row:
                break
            for k in range(c, min(c + p.length[s], row)):
                x -= S[at + k - c] * w[k]
            at += p.length[s]
        w[row] = x
    for row in range(n - 1, -1, -1):
        block = p.row_block[row]
        at = p.row_start[row]
        x = w[row]
        for s in range(p.segment_start[block], p.segment_start[block + 1]):
            c, m = p.column[s], p.length[s]
            if c + m > row + 1:
                for k in range(max(c, row + 1), c + m):
                    x -= S[at + k - c] * w[k]
            at += m
        w[row] = x * p.inverse[row]
    for row in range(n):
        b[p.order[row]] = w[row]


def stored(S: np.ndarray, p: BlockPattern):
    """Return the matrix of the stored values (before factorisation), csr, in the natural order of unknowns."""
    from scipy import sparse

    n = len(p.row_block)
    indices = np.empty(p.row_start[-1], np.int64)
    for row in range(n):
        at = p.row_start[row]
        for s in range(p.segment_start[p.row_block[row]], p.segment_start[p.row_block[row] + 1]):
            indices[at : at + p.length[s]] = p.order[p.column[s] : p.column[s] + p.length[s]]
            at += p.length[s]
    permuted = sparse.csr_matrix((S, indices, p.row_start), shape=(n, n))
    back = np.empty(n, np.int64)
    back[p.order] = np.arange(n)
    return permuted[back]
