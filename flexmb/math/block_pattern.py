"""The static block pattern of a sparse matrix and of its factors: which row has which columns, and what changes what.

Rows are grouped in blocks (the freedoms of a body, the multipliers of a joint); all rows of a block have the same
columns, stored as contiguous segments. The pattern is made once (system room, `pattern`), `block_lu` uses it often.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from flexmb.math.structures import Floats, Integers, structure

__all__ = ["PARENT", "BlockPattern", "blocks", "elimination", "stored"]

NONE = np.zeros(0)
PARENT = 2
"""Blocks that one of a tree leaves behind, at most: its joint and the body that carries it."""


@structure
class BlockPattern(NamedTuple):
    """The pattern of the factors, with scratch space for one thread."""

    order: Integers
    """(n,) unknown at each place"""
    row_start: Integers
    """(n + 1,) first value of each row"""
    row_block: Integers
    """(n,)"""
    segment_start: Integers
    """(blocks + 1,)"""
    column: Integers
    """(segments,) first place of the columns of each segment; neighbours are joined, but for the own block"""
    length: Integers
    """(segments,) number of its columns"""
    block_start: Integers
    """(blocks + 1,) first row of each block"""
    own: Integers
    """(blocks,) where its diagonal block is in a row"""
    own_segment: Integers
    """(blocks,) and which segment that is"""
    step_start: Integers
    """(blocks + 1,) the earlier blocks to eliminate"""
    source: Integers
    """(steps,) which they are"""
    at: Integers
    """(steps,) and where in the row"""
    run_start: Integers
    """(steps + 1,) columns that a step changes, in runs"""
    run_to: Integers
    """(runs,) first column in the rows that change"""
    run_from: Integers
    """(runs,) first column in the rows of the source"""
    run_length: Integers
    """(runs,)"""
    scratch: Floats
    """(2 n,) nothing is kept there from one call to the next"""
    softness: Floats = NONE
    """(n,) or (0,): what was added to the diagonal to regularise dependent equations, in the natural order"""


def _runs(starts: np.ndarray, lengths: np.ndarray) -> np.ndarray:
    """Return starts[0], starts[0] + 1, ..., as many as lengths[0], then the next."""
    before = np.cumsum(lengths) - lengths
    return np.repeat(starts - before, lengths) + np.arange(int(np.sum(lengths)))


def stored(S: np.ndarray, p: BlockPattern):
    """Return the matrix of the stored values (before factorisation), csr, in the natural order of unknowns."""
    from scipy import sparse

    n = len(p.row_block)
    first = p.segment_start[p.row_block]
    segments = _runs(first, p.segment_start[p.row_block + 1] - first)
    indices = p.order[_runs(p.column[segments], p.length[segments])]
    permuted = sparse.csr_matrix((S, indices, p.row_start), shape=(n, n))
    return permuted[np.argsort(p.order)]


def blocks(p: BlockPattern) -> np.ndarray:
    """Return the block (a body, a node of a body, a joint with its drive) of every unknown in the natural
    order, (n,).
    """
    return p.row_block[np.argsort(p.order)]


def elimination(p: BlockPattern) -> str:
    """Return in words how the matrix is factorised: by the recursion over a tree, or with what loops couple.

    Where every block, a body or a joint, leaves at most its joint and its parent behind, the elimination is the block
    recursion from the leaves to the roots, of linear cost.
    """
    sizes = np.diff(p.block_start)
    after = np.bincount(p.source, minlength=len(sizes))
    ends = np.concatenate([[0], np.cumsum(p.length)])
    wide = ends[p.segment_start[1:]] - ends[p.own_segment + 1]
    rows, behind = np.repeat(sizes, np.diff(p.step_start)), sizes[p.source]
    count = np.sum(sizes**3 / 3.0 + 0.5 * sizes**2 * wide)
    count = float(count + np.sum(rows * behind * (0.5 * behind + wide[p.source])))
    most = int(after.max(initial=0))
    how = "recursion from the leaves" if most <= PARENT else f"sparse order, at most {most} blocks coupled by one,"
    return f"{how} over {len(sizes)} blocks, {count:.3g} multiplications"
