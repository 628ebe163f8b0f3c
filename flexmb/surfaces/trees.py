"""Trees of boxes over many small things: triangles, samples.

A tree is one array of nodes in the order of a walk that goes down first: `NODE` numbers each, the corners of the box (3
and 3), the node that follows when this one is passed over, and 16 times the first thing plus their number in a leaf (0
in other nodes). The first child of a node follows it, the second is where the first one's is passed over.

Source: Ericson, Real-Time Collision Detection, section 6.2 (top-down, split at the median of the longest axis) and
6.6.2 (storage in the order of a preorder walk).
"""

from __future__ import annotations

import numpy as np

from flexmb.math.kernel import kernel

__all__ = ["DEPTH", "NODE", "built"]

NODE = 8
LEAF = 4
"""Most things of a leaf."""
DEPTH = 64
"""Enough for halving all that fits into memory."""


@kernel
def built(low, high):
    """Return the order (n,) in which things with the boxes `low`, `high` (n, 3) are to be stored, and nodes (m, 8)."""
    n = len(low)
    order = np.arange(n)
    nodes = np.zeros((max(2 * n, 1), NODE))
    first = np.zeros(DEPTH, np.int64)
    last = np.zeros(DEPTH, np.int64)
    top, count = 0, 0
    if n > 0:
        last[0], top = n, 1
    while top > 0:
        top -= 1
        i, j = first[top], last[top]
        node = nodes[count]
        count += 1
        for k in range(3):
            node[k], node[3 + k] = np.inf, -np.inf
            for m in range(i, j):
                node[k] = min(node[k], low[order[m], k])
                node[3 + k] = max(node[3 + k], high[order[m], k])
        if j - i <= LEAF:
            node[7] = 16.0 * i + (j - i)
            continue
        axis = 0
        for k in range(1, 3):
            if node[3 + k] - node[k] > node[3 + axis] - node[axis]:
                axis = k
        own = order[i:j].copy()
        key = np.empty(j - i)
        for m in range(j - i):
            key[m] = low[own[m], axis] + high[own[m], axis]
        by = np.argsort(key)
        for m in range(j - i):
            order[i + m] = own[by[m]]
        middle = (i + j) // 2
        first[top], last[top] = middle, j
        first[top + 1], last[top + 1] = i, middle
        top += 2
    sizes = np.ones(count + 1, np.int64)
    for k in range(count - 1, -1, -1):
        if nodes[k, 7] == 0.0:
            after = k + 1 + sizes[k + 1]
            sizes[k] = 1 + sizes[k + 1] + sizes[after]
        nodes[k, 6] = k + sizes[k]
    return order, nodes[:count].copy()
