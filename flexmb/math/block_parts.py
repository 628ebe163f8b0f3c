"""Parts of a factorised matrix that do not touch each other: a free body, a mechanism, bodies tied by springs.

A right side that is zero but in one part is solved there alone, at the cost of that part. A heap of free bodies in
contact so costs six unknowns for every body, however many there are. Same factors as `block_lu`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from flexmb.math.block_pattern import BlockPattern
from flexmb.math.kernel import inner_kernel, kernel
from flexmb.math.structures import Integers, structure

__all__ = ["Parts", "parts_of", "solve_part"]


@structure
class Parts(NamedTuple):
    """Blocks and unknowns of every part."""

    of: Integers
    """(n,) part of every unknown, in the natural order"""
    place: Integers
    """(n,) its number within the part"""
    block_start: Integers
    """(parts + 1,)"""
    blocks: Integers
    """blocks of each part, in the order of elimination"""
    start: Integers
    """(parts + 1,)"""
    unknowns: Integers
    """unknowns of each part"""


def parts_of(p: BlockPattern) -> Parts:
    """Return the parts of a pattern."""
    n_blocks = len(p.own)
    root = np.arange(n_blocks)

    def find(k: int) -> int:
        while root[k] != k:
            root[k] = root[root[k]]
            k = root[k]
        return k

    for block in range(n_blocks):
        # a block may read others that do not read it
        columns = range(p.segment_start[block], p.segment_start[block + 1])
        for s in columns:
            for other in range(p.row_block[p.column[s]], p.row_block[p.column[s] + p.length[s] - 1] + 1):
                a, b = find(other), find(block)
                if a != b:
                    root[a] = b
    roots = np.array([find(k) for k in range(n_blocks)], np.int64)
    _, of_block = np.unique(roots, return_inverse=True)
    count = int(of_block.max()) + 1 if n_blocks else 0
    blocks = np.argsort(of_block, kind="stable")
    of = np.zeros(len(p.order), np.int64)
    of[p.order] = of_block[p.row_block]
    unknowns = np.argsort(of, kind="stable")
    start = np.searchsorted(of[unknowns], np.arange(count + 1))
    place = np.zeros(len(p.order), np.int64)
    place[unknowns] = np.arange(len(p.order)) - start[of[unknowns]]
    return Parts(
        of=of.astype(np.int64),
        place=place,
        block_start=np.searchsorted(of_block[blocks], np.arange(count + 1)).astype(np.int64),
        blocks=blocks.astype(np.int64),
        start=start.astype(np.int64),
        unknowns=unknowns.astype(np.int64),
    )


@inner_kernel
def _substitute_blocks(S, p, blocks, b):
    """Solve L U x = b in place, in the rows of these blocks."""
    w = p.scratch
    for n in range(len(blocks)):
        for row in range(p.block_start[blocks[n]], p.block_start[blocks[n] + 1]):
            w[row] = b[p.order[row]]
    for n in range(len(blocks)):
        block = blocks[n]
        first = p.block_start[block]
        for row in range(first, p.block_start[block + 1]):
            at, total = p.row_start[row], w[row]
            for s in range(p.segment_start[block], p.own_segment[block]):
                for t in range(p.length[s]):
                    total -= S[at + t] * w[p.column[s] + t]
                at += p.length[s]
            for k in range(row - first):
                total -= S[at + k] * w[first + k]
            w[row] = total
    for n in range(len(blocks) - 1, -1, -1):
        block = blocks[n]
        first, last = p.block_start[block], p.block_start[block + 1]
        for row in range(last - 1, first - 1, -1):
            own, total = p.row_start[row] + p.own[block], w[row]
            for k in range(row - first + 1, last - first):
                total -= S[own + k] * w[first + k]
            at = own + last - first
            for s in range(p.own_segment[block] + 1, p.segment_start[block + 1]):
                for t in range(p.length[s]):
                    total -= S[at + t] * w[p.column[s] + t]
                at += p.length[s]
            w[row] = total * S[own + row - first]
    for n in range(len(blocks)):
        for row in range(p.block_start[blocks[n]], p.block_start[blocks[n] + 1]):
            b[p.order[row]] = w[row]


@kernel
def solve_part(S, p, parts, part, b, given):
    """Solve L U x = b in place in the unknowns of one part; b and `given` (n,) are not touched elsewhere.

    What dependent equations contradict is left out, as in `lu_solve`.
    """
    blocks = parts.blocks[parts.block_start[part] : parts.block_start[part + 1]]
    unknowns = parts.unknowns[parts.start[part] : parts.start[part + 1]]
    if len(p.softness) == 0:
        _substitute_blocks(S, p, blocks, b)
        return
    for k in unknowns:
        given[k] = b[k]
    for turn in range(3):
        if turn > 0:
            for k in unknowns:
                given[k] -= p.softness[k] * b[k]
                b[k] = given[k]
        _substitute_blocks(S, p, blocks, b)
