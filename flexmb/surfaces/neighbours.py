"""Which surfaces are near each other: all pairs of a few, a grid of cells for many.

Source of the grid: Ericson, Real-Time Collision Detection, 2005, section 7.1.
"""

from __future__ import annotations

import numpy as np

from flexmb.math.kernel import inner_kernel, kernel
from flexmb.surfaces.records import FAR

__all__ = ["FEW", "LARGE", "candidates", "near_among", "near_pairs"]

FEW = 3000
"""Pairs up to which all are tried."""
LARGE = 4.0
"""Reach, relative to the median one, from which on a surface is tried with all others instead of the grid."""


def candidates(first: np.ndarray, second: np.ndarray, body: np.ndarray) -> np.ndarray:
    """Return the pairs (n, 2) of two groups of surfaces, of different bodies, each pair once."""
    i, j = (x.ravel() for x in np.meshgrid(first, second, indexing="ij"))
    keep = body[i] != body[j]
    both = np.isin(i, second) & np.isin(j, first)
    keep &= ~(both & (i > j))
    return np.column_stack([i[keep], j[keep]]).astype(np.int64)


@inner_kernel
def _take(i, j, side, body, pairs, found):
    """Write a pair, in the order of its groups; return how many there are then."""
    if body[i] == body[j] or not (((side[i] & 1) and (side[j] & 2)) or ((side[i] & 2) and (side[j] & 1))):
        return found
    if (side[i] & 1) and (side[j] & 2) and not ((side[i] & 2) and (side[j] & 1) and i > j):
        a, b = i, j
    else:
        a, b = j, i
    if found < len(pairs):
        pairs[found, 0], pairs[found, 1] = a, b
    return found + 1


@kernel
def near_pairs(places, reach, side, body, members, large, size, pairs):
    """Write the pairs of surfaces whose balls may meet; return how many there are (more than `pairs` has: again).

    Parameters
    ----------
    places : (ns, 3), m; reach : (ns,), m, with the margin
    side : (ns,), 1: of the first group, 2: of the second, 3: of both
    body : (ns,)
    members : surfaces that go into the grid
    large : surfaces that are tried with all
    size : m, edge of a cell, at least twice the largest reach of the members
    pairs : (n, 2)
    """
    found, n = 0, len(members)
    for x in range(len(large)):
        i = large[x]
        for y in range(x + 1, len(large)):
            found = _take(i, large[y], side, body, pairs, found)
        for m in range(n):
            found = _take(i, members[m], side, body, pairs, found)
    low = np.full(3, np.inf)
    high = np.full(3, -np.inf)
    for m in range(n):
        for k in range(3):
            low[k] = min(low[k], places[members[m], k])
            high[k] = max(high[k], places[members[m], k])
    cells = np.empty(3, np.int64)
    for k in range(3):
        cells[k] = int(min((high[k] - low[k]) / size, 1e6)) + 3 if n > 0 else 1
    keys = np.empty(n, np.int64)
    for m in range(n):
        key = 0
        for k in range(3):
            key = key * cells[k] + int(min((places[members[m], k] - low[k]) / size, 1e6)) + 1
        keys[m] = key
    order = np.argsort(keys, kind="mergesort")
    ordered = keys[order]
    for m in range(n):
        i = members[order[m]]
        for dx in range(-1, 2):
            for dy in range(-1, 2):
                # the cells dz = -1, 0, 1 have consecutive numbers
                key = ordered[m] + (dx * cells[1] + dy) * cells[2]
                at = np.searchsorted(ordered, key - 1)
                while at < n and ordered[at] <= key + 1:
                    if at > m:
                        j = members[order[at]]
                        gap = 0.0
                        for k in range(3):
                            gap += (places[i, k] - places[j, k]) ** 2
                        if gap < (reach[i] + reach[j]) ** 2:
                            found = _take(i, j, side, body, pairs, found)
                    at += 1
    return found


@kernel
def near_among(places, reach, side, body):
    """Return the pairs (m, 2) of surfaces whose balls meet; arguments as those of `near_pairs`."""
    n = len(reach)
    # argsort, as in the trees: numba names the inner function of np.sort alike, and kept code of both clashes
    typical = reach[np.argsort(reach)[n // 2]] if n > 0 else 0.0
    members, large = np.empty(n, np.int64), np.empty(n, np.int64)
    few, many, widest = 0, 0, 1e-300
    for k in range(n):
        if reach[k] >= FAR or reach[k] > LARGE * typical:
            large[few] = k
            few += 1
        else:
            members[many] = k
            widest = max(widest, reach[k])
            many += 1
    pairs = np.empty((8 * n, 2), np.int64)
    while True:
        size = 2.0 * widest * (1.0 + 1e-9)
        found = near_pairs(places, reach, side, body, members[:many], large[:few], size, pairs)
        if found <= len(pairs):
            return pairs[:found]
        pairs = np.empty((2 * found, 2), np.int64)
