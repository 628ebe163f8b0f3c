"""What a spot of two skins adds to the iteration matrix, over the coordinates of all its markers at once."""

from __future__ import annotations

import numpy as np

from flexmb.forces.skin_wrench import COLUMNS
from flexmb.math.kernel import kernel

__all__ = ["add_to_pair", "own_parts", "projected"]


@kernel
def own_parts(spans, numbers, markers, firsts):
    """Write where the coordinates of each of the four markers begin among those of all; return how many these are.

    Markers of one group share theirs.
    """
    total = 0
    for c in range(4):
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
    """Return J^T (ck K + cd D) J over the coordinates of four markers."""
    ck, cd = work.weights[0].stiffness, work.weights[0].damping
    M = np.zeros((total, total))
    column = np.empty(total)
    for k in range(COLUMNS):
        column[:] = 0.0
        used = False
        for m in range(COLUMNS):
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
