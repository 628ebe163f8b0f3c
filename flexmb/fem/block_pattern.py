"""Sparsity of a mesh, node by node, and compiled scattering of element matrices straight into CSR arrays.

Coordinate triples (scikit-fem, most codes) need 24 bytes per element entry and a sort. The pattern of node neighbours
is nine times smaller than the matrix, is found once, and serves K, M and K_g.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from flexmb.math.kernel import kernel

__all__ = ["BlockPattern", "node_pattern"]


@dataclass(frozen=True, kw_only=True, eq=False)
class BlockPattern:
    """Rows of node neighbours: node i has ``indices[start[i]:start[i + 1]]``, ascending, i included."""

    start: np.ndarray
    indices: np.ndarray

    @property
    def n(self) -> int:
        """Number of nodes."""
        return len(self.start) - 1

    def blocks(self, data: np.ndarray) -> sparse.csr_matrix:
        """Return the (3n, 3n) matrix whose values `data` were scattered by `scatter_blocks`."""
        index = np.int32 if 9 * len(self.indices) < 2**31 else np.int64
        start, indices = np.empty(3 * self.n + 1, index), np.empty(9 * len(self.indices), index)
        _block_columns(self.start, self.indices, start, indices)
        return sparse.csr_matrix((data, indices, start), shape=(3 * self.n, 3 * self.n))

    def scalar(self, data: np.ndarray) -> sparse.csr_matrix:
        """Return the (n, n) matrix with one value per pair of neighbours."""
        return sparse.csr_matrix((data, self.indices, self.start), shape=(self.n, self.n))

    def three_times(self, data: np.ndarray) -> sparse.csr_matrix:
        """Return the (3n, 3n) matrix ``kron(scalar(data), I3)``: the same value in all three directions."""
        index = np.int32 if 3 * len(self.indices) < 2**31 else np.int64
        start, indices = np.empty(3 * self.n + 1, index), np.empty(3 * len(self.indices), index)
        values = np.empty(3 * len(self.indices))
        _repeat_rows(self.start, self.indices, data, start, indices, values)
        return sparse.csr_matrix((values, indices, start), shape=(3 * self.n, 3 * self.n))


def node_pattern(n: int, connectivities: list[np.ndarray]) -> BlockPattern:
    """Return the neighbours of n nodes in cells of several kinds, each (ne, nodes per cell) int64."""
    # All cells as one ragged list; then, per node, the cells it belongs to.
    flat = np.concatenate([connectivity.ravel() for connectivity in connectivities])
    sizes = np.concatenate([np.full(len(c), c.shape[1]) for c in connectivities])
    first = np.concatenate([[0], np.cumsum(sizes)])
    owner_start = np.concatenate([[0], np.cumsum(np.bincount(flat, minlength=n))])
    owners = np.repeat(np.arange(len(sizes)), sizes)[np.argsort(flat, kind="stable")]
    start = np.zeros(n + 1, np.int64)
    _neighbours(first, flat, owner_start, owners, start, np.empty(0, np.int64))
    indices = np.empty(start[-1], np.int64)
    _neighbours(first, flat, owner_start, owners, start, indices)
    if len(indices) < 2**31:
        return BlockPattern(start=start.astype(np.int32), indices=indices.astype(np.int32))
    return BlockPattern(start=start, indices=indices)


@kernel
def _neighbours(first, flat, owner_start, owners, start, indices):
    """Count the neighbours of each node into `start`, or (when `indices` has room) list them, ascending."""
    n = len(start) - 1
    seen = np.full(n, -1)
    listing = len(indices) > 0
    for i in range(n):
        count = 0
        for o in range(owner_start[i], owner_start[i + 1]):
            cell = owners[o]
            for p in range(first[cell], first[cell + 1]):
                j = flat[p]
                if seen[j] != i:
                    seen[j] = i
                    if listing:
                        indices[start[i] + count] = j
                    count += 1
        if listing:
            indices[start[i] : start[i] + count].sort()
        else:
            start[i + 1] = start[i] + count


@kernel
def position(start, indices, row, column):
    """Place of a neighbour in the pattern, by bisection."""
    low, high = start[row], start[row + 1] - 1
    while low < high:
        middle = (low + high) // 2
        if indices[middle] < column:
            low = middle + 1
        else:
            high = middle
    return low


@kernel
def scatter_blocks(start, indices, nodes, matrix, data):
    """Add a (3 nn, 3 nn) element matrix to CSR values whose row 3 i + k holds the blocks of node i."""
    nn = len(nodes)
    for a in range(nn):
        row = start[nodes[a]]
        length = 3 * (start[nodes[a] + 1] - row)
        for b in range(nn):
            column = 9 * row + 3 * (position(start, indices, nodes[a], nodes[b]) - row)
            for i in range(3):
                for j in range(3):
                    data[column + i * length + j] += matrix[3 * a + i, 3 * b + j]


@kernel
def scatter_scalar(start, indices, nodes, matrix, data):
    """Add an (nn, nn) element matrix to the values of the node pattern."""
    for a in range(len(nodes)):
        for b in range(len(nodes)):
            data[position(start, indices, nodes[a], nodes[b])] += matrix[a, b]


@kernel
def _block_columns(start, indices, row_start, columns):
    row_start[0] = 0
    p = 0
    for i in range(len(start) - 1):
        for k in range(3):
            for q in range(start[i], start[i + 1]):
                for j in range(3):
                    columns[p] = 3 * indices[q] + j
                    p += 1
            row_start[3 * i + k + 1] = p


@kernel
def _repeat_rows(start, indices, data, row_start, columns, values):
    row_start[0] = 0
    p = 0
    for i in range(len(start) - 1):
        for k in range(3):
            for q in range(start[i], start[i + 1]):
                columns[p] = 3 * indices[q] + k
                values[p] = data[q]
                p += 1
            row_start[3 * i + k + 1] = p
