"""What every reader of matrices returns, and how entries of one triangle become a matrix."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy import sparse

from flexmb.errors import MeshError
from flexmb.fem.foreign_files import whole_numbers

__all__ = ["FileMatrices", "by_labels", "symmetric_from_entries"]


@dataclass(frozen=True, eq=False)
class FileMatrices:
    """Matrices of a file, with node numbers as in the file.

    Parameters
    ----------
    K, M : (ndof, ndof) csr
    labels, directions : (ndof,), int, or None
        Node number in the file and direction 0..5 of every row; None: nodes in order, three or six rows each.
    nodes : where the positions are if the user names no mesh: a path, a NodeTable, or None
    """

    K: sparse.csr_matrix
    M: sparse.csr_matrix
    labels: np.ndarray | None = None
    directions: np.ndarray | None = None
    nodes: Any = None


def symmetric_from_entries(part: str, i: np.ndarray, j: np.ndarray, values: np.ndarray, size: int) -> sparse.csr_matrix:
    """Return the symmetric matrix of entries in either triangle, each pair once (or both, with equal
    values)."""
    low, high = np.minimum(i, j), np.maximum(i, j)
    if len(i) == 0:
        return sparse.csr_matrix((size, size))
    key, first, count = np.unique(low.astype(np.int64) * size + high, return_index=True, return_counts=True)
    last = np.zeros(len(key))
    last[np.searchsorted(key, low.astype(np.int64) * size + high)] = values  # the later one of each pair
    both = count > 1
    gap = np.abs(values[first] - last)
    if (count > 2).any() or (gap[both] > 1e-6 * np.abs(values).max()).any():
        k = first[np.argmax(np.where(both, gap, 0.0))]
        raise MeshError(
            part,
            found=f"the entry ({i[k] + 1}, {j[k] + 1}) more than once with different values",
            expected="one triangle, or both of a symmetric matrix",
            remedy="Export the matrix again",
        )
    upper = sparse.csr_matrix((values[first], (low[first], high[first])), shape=(size, size))
    return (upper + sparse.triu(upper, 1).T).tocsr()


def by_labels(part: str, entries: dict[str, np.ndarray]) -> FileMatrices:
    """Return K and M from tables (ne, 5) of node, direction (1..6), node, direction, value under the keys K
    and M."""
    keys = []
    for symbol, table in entries.items():
        whole_numbers(f"{part}, {symbol}", "the node number", table[:, [0, 2]], -(2**53) // 16, 2**53 // 16)
        whole_numbers(f"{part}, {symbol}", "the freedom", table[:, [1, 3]], 0, 7)
        keys += [table[:, 0] * 8 + table[:, 1] - 1, table[:, 2] * 8 + table[:, 3] - 1]
    freedoms = np.unique(np.concatenate(keys).astype(np.int64))
    labels, directions = np.divmod(freedoms, 8)
    if len(freedoms) and labels.min() < 1:
        raise MeshError(
            part,
            found=f"the node number {labels.min()}",
            expected="numbers >= 1 of nodes of the mesh",
            remedy="Internal (Lagrange multiplier) nodes cannot be used: model contact and ties otherwise",
        )
    if len(freedoms) and directions.max() > 5:
        raise MeshError(
            part,
            found=f"the freedom {directions.max() + 1} of node {labels[directions.argmax()]}",
            expected="freedoms 1..6",
            remedy="Leave out pressure, temperature and warping freedoms",
        )
    matrices = {}
    for symbol, table in entries.items():
        i = np.searchsorted(freedoms, (table[:, 0] * 8 + table[:, 1] - 1).astype(np.int64))
        j = np.searchsorted(freedoms, (table[:, 2] * 8 + table[:, 3] - 1).astype(np.int64))
        matrices[symbol] = symmetric_from_entries(f"{part}, {symbol}", i, j, table[:, 4], len(freedoms))
    return FileMatrices(matrices["K"], matrices["M"], labels=labels, directions=directions)
