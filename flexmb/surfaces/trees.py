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

__all__ = ["DEPTH", "NODE", "SLAB", "built", "slabs"]

NODE, SLAB = 8, 10
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


@kernel
def slabs(places, normals, nodes):
    """Return a tree over samples (n, 3) in their order: `SLAB` numbers for each node of their boxes.

    They are the middle (3), the radius of the ball around it, the mean normal (3), half the thickness along it, and the
    last two numbers of the node. A patch of a smooth surface is a ball much flattened.
    """
    count = len(nodes)
    out = np.zeros((count, SLAB))
    first = np.zeros(count, np.int64)
    last = np.zeros(count, np.int64)
    for k in range(count - 1, -1, -1):
        code = int(nodes[k, 7])
        if code > 0:
            first[k], last[k] = code // 16, code // 16 + code % 16
        else:
            right = int(nodes[k + 1, 6])
            first[k], last[k] = first[k + 1], last[right]
        own = out[k]
        own[8], own[9] = nodes[k, 6], nodes[k, 7]
        square = 0.0
        for i in range(3):
            own[i] = 0.5 * (nodes[k, i] + nodes[k, 3 + i])
            for m in range(first[k], last[k]):
                own[4 + i] += normals[m, i]
            square += own[4 + i] ** 2
        for i in range(3):
            own[4 + i] = own[4 + i] / square**0.5 if square > 0.0 else 0.0
        low, high, far = np.inf, -np.inf, 0.0
        for m in range(first[k], last[k]):
            along, distance = 0.0, 0.0
            for i in range(3):
                x = places[m, i] - own[i]
                along += x * own[4 + i]
                distance += x * x
            low, high, far = min(low, along), max(high, along), max(far, distance)
        own[3], own[7] = far**0.5, max(-low, high)
    return out
