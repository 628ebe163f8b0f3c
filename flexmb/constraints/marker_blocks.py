"""What a row adds to the iteration matrix over the coordinates of all its markers at once.

Markers of one body share their coordinates: their derivatives are summed before they are spread over rows and columns
of the body, which for n markers on a reduced body is n times less than pair by pair.
"""

from __future__ import annotations

import numpy as np

from flexmb.math.kernel import kernel
from flexmb.math.tables import DIRECT

__all__ = ["add_to_pair", "block_codes", "own_parts", "projected"]


@kernel
def own_parts(spans, numbers, markers, firsts):
    """Write where the coordinates of each marker begin; return how many there are of all.

    Markers of one group (`spans`) share theirs.
    """
    total = 0
    for c in range(len(numbers)):
        firsts[c] = -1
        for d in range(c):
            if spans[d] == spans[c]:
                firsts[c] = firsts[d]
        if firsts[c] < 0:
            firsts[c] = total
            total += markers[numbers[c]].nu
    return total


@kernel
def projected(numbers, firsts, total, K, D, work):
    """Return J^T (ck K + cd D) J over the coordinates of n markers; K and D (6 n, 6 n) are by their twists in W."""
    ck, cd = work.weights[0].stiffness, work.weights[0].damping
    M = np.zeros((total, total))
    column = np.empty(total)
    for k in range(len(K)):
        column[:] = 0.0
        used = False
        for m in range(len(K)):
            x = ck * K[k, m] + cd * D[k, m]
            if x != 0.0:
                used = True
                marker, first = work.markers[numbers[m // 6]], firsts[m // 6]
                at = marker.iJ + (m % 6) * marker.nu
                for j in range(marker.nu):
                    column[first + j] += x * work.J[at + j]
        if not used:
            continue
        marker, first = work.markers[numbers[k // 6]], firsts[k // 6]
        at = marker.iJ + (k % 6) * marker.nu
        for i in range(marker.nu):
            x = work.J[at + i]
            if x != 0.0:
                for j in range(total):
                    M[first + i, j] += x * column[j]
    return M


def block_codes(compiler, markers: list[int], needed) -> np.ndarray:
    """Return for every two of n groups of coordinates the code of `add_to_pair`, (n, n), -1 where none is needed.

    Parameters
    ----------
    compiler : Compiler
    markers : list of int
        One marker of each group.
    needed : iterable of (int, int)
        Groups that meet.
    """
    codes = np.full((len(markers), len(markers)), -1.0)
    for a, b in sorted(needed):
        pair = compiler.pair(markers[a], markers[b], DIRECT)
        for k, (i, j) in enumerate(((a, a), (a, b), (b, a), (b, b))):
            codes[i, j] = 4 * pair + k
    return codes


@kernel
def add_to_pair(code, M, first, second, work):
    """Add a block of M to the iteration matrix: block aa, ab, ba or bb of a pair."""
    pair, block = work.pairs[code // 4], code % 4
    a, b = work.markers[pair.a], work.markers[pair.b]
    rows, columns = (a if block < 2 else b), (a if block % 2 == 0 else b)
    start = pair.iS
    for k in range(block):
        before, after = (a if k < 2 else b), (a if k % 2 == 0 else b)
        if before.nu > 0 and after.nu > 0:
            start += before.nu * (after.nu // after.width)
    if columns.nu == 0:
        return
    blocks = columns.nu // columns.width
    for i in range(rows.nu):
        for n in range(blocks):
            at = work.pair_rows[start + i * blocks + n]
            for j in range(columns.width):
                work.S[at + j] += M[first + i, second + n * columns.width + j]
