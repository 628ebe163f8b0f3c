"""Sparse LU with a static block pattern: the order and the fill are found once, the numbers often.

Rows are grouped in blocks (the freedoms of a body, the multipliers of a joint); all rows of a block have the same
columns, stored as contiguous segments, and which block changes which columns of which is listed beforehand, so the
inner loops run over contiguous memory. There is no pivoting: the order
(system room, `pattern`) puts a body before its multipliers, which keeps every pivot away from zero; a vanishing pivot
is reported with its row. Source of the row-wise form: Davis, Direct Methods for Sparse Linear Systems, 2006, ch. 6.
"""

from __future__ import annotations

from collections import namedtuple

import numpy as np

from flexmb.math.kernel import kernel

__all__ = ["BlockPattern", "lu_factor", "lu_solve", "stored"]

BlockPattern = namedtuple(
    "BlockPattern",
    "order row_start row_block segment_start column length block_start own own_segment step_start source at "
    "run_start run_to run_from run_length inverse scratch softness",
    defaults=[np.zeros(0)],
)
"""order (n,): unknown at each place; row_start (n + 1,): first value of each row; row_block (n,);
segment_start (blocks + 1,); column, length (segments,): first place and number of columns of each segment;
block_start (blocks + 1,): first row of each block; own, own_segment (blocks,): where its diagonal block is;
step_start (blocks + 1,): the earlier blocks to eliminate; source and at (steps,): which, and where;
run_start (steps + 1,); run_to, run_from, run_length: columns that a step changes, in the rows of both blocks;
inverse (n,): reciprocal pivots, written by `lu_factor`; scratch (n,);
softness (n,) or (0,): what was added to the diagonal to regularise dependent equations, in the natural order."""


@kernel
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
            f = x * p.inverse[first + k]
            S[left + k] = f
            pivot_row = start + k * stride
            for t in range(k + 1, m):
                S[left + t] -= f * S[pivot_row + own + t]
            for r in range(p.run_start[s], p.run_start[s + 1]):
                to, source = row + p.run_to[r], pivot_row + p.run_from[r]
                for t in range(p.run_length[r]):
                    S[to + t] -= f * S[source + t]


@kernel
def lu_factor(S, p):
    """Factorise S = L U in place; return -1, or the first row (place) whose pivot vanishes or is not finite."""
    for block in range(len(p.own)):
        first = p.block_start[block]
        n = p.block_start[block + 1] - first
        if n == 0:
            continue
        base = p.row_start[first]
        width = p.row_start[first + 1] - base
        own = p.own[block]
        for i in range(n):
            largest = 0.0
            row = base + i * width
            for t in range(width):
                largest = max(largest, abs(S[row + t]))
            p.scratch[first + i] = largest
        for s in range(p.step_start[block], p.step_start[block + 1]):
            _eliminate(S, p, s, base, n, width)
        for i in range(n):
            row = base + i * width
            left = row + own
            k = 0
            while k + 1 < i:
                # two rows above at a time: each value of this row is loaded and stored half as often
                above = base + k * width
                below = above + width
                f = S[left + k] * p.inverse[first + k]
                g = (S[left + k + 1] - f * S[above + own + k + 1]) * p.inverse[first + k + 1]
                S[left + k], S[left + k + 1] = f, g
                k += 2
                if f == 0.0 and g == 0.0:
                    continue
                for t in range(own + k, width):
                    S[row + t] -= f * S[above + t] + g * S[below + t]
            if k < i:
                above = base + k * width
                f = S[left + k] * p.inverse[first + k]
                S[left + k] = f
                for t in range(own + k + 1, width):
                    S[row + t] -= f * S[above + t]
            pivot = S[row + own + i]
            if not abs(pivot) > 1e-14 * p.scratch[first + i]:
                return first + i
            p.inverse[first + i] = 1.0 / pivot
    return -1


@kernel
def _substitute(S, p, b):
    """Solve L U x = b in place, unknowns in their natural order."""
    w = p.scratch
    blocks = len(p.own)
    for block in range(blocks):
        first = p.block_start[block]
        for row in range(first, p.block_start[block + 1]):
            start = p.row_start[row]
            x = b[p.order[row]]
            at = start
            for s in range(p.segment_start[block], p.own_segment[block]):
                c = p.column[s]
                for t in range(p.length[s]):
                    x -= S[at + t] * w[c + t]
                at += p.length[s]
            for k in range(row - first):
                x -= S[at + k] * w[first + k]
            w[row] = x
    for block in range(blocks - 1, -1, -1):
        first, last = p.block_start[block], p.block_start[block + 1]
        for row in range(last - 1, first - 1, -1):
            at = p.row_start[row] + p.own[block]
            x = w[row]
            for k in range(row + 1 - first, last - first):
                x -= S[at + k] * w[first + k]
            at += last - first
            for s in range(p.own_segment[block] + 1, p.segment_start[block + 1]):
                c = p.column[s]
                for t in range(p.length[s]):
                    x -= S[at + t] * w[c + t]
                at += p.length[s]
            w[row] = x * p.inverse[row]
    for row in range(len(p.row_block)):
        b[p.order[row]] = w[row]


@kernel
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
