"""Element matrices of elements with six freedoms per node, and their sum."""

from __future__ import annotations

import numpy as np
from scipy import sparse

__all__ = ["all_freedoms", "freedom_rows", "gathered", "rotated", "scattered", "summed"]


def all_freedoms(number_of_nodes: int) -> np.ndarray:
    """Return the (6 n, 2) table (node, direction) of six freedoms per node, node by node."""
    return np.stack(np.divmod(np.arange(6 * number_of_nodes), 6), axis=1)


def freedom_rows(dofs: np.ndarray, number_of_nodes: int) -> np.ndarray:
    """Return the (n, 6) matrix row of every node and direction; -1 where the model has no such freedom."""
    rows = np.full((number_of_nodes, 6), -1)
    rows[dofs[:, 0], dofs[:, 1]] = np.arange(len(dofs))
    return rows


def summed(
    element_matrices: np.ndarray, connectivity: np.ndarray, dofs: np.ndarray, number_of_nodes: int
) -> sparse.csr_matrix:
    """Return the sum (ndof, ndof) of element matrices (ne, 6 c, 6 c); absent freedoms are left out (held)."""
    ndof, size = len(dofs), element_matrices.shape[-1]
    rows = freedom_rows(dofs, number_of_nodes)[connectivity].reshape(len(connectivity), size)
    i, j = np.repeat(rows, size, axis=1).ravel(), np.tile(rows, (1, size)).ravel()
    present = (i >= 0) & (j >= 0)
    entries = element_matrices.ravel()[present]
    matrix = sparse.coo_matrix((entries, (i[present], j[present])), shape=(ndof, ndof)).tocsr()
    # exactly symmetric: the order of the sums leaves the last digit
    return (0.5 * (matrix + matrix.T)).tocsr()


def rotated(element_matrices: np.ndarray, axes: np.ndarray) -> np.ndarray:
    """Return local element matrices (ne, s, s) in body axes; the rows of axes (ne, 3, 3) are the local
    axes."""
    ne, size, _ = element_matrices.shape
    blocks = element_matrices.reshape(ne, size // 3, 3, size // 3, 3)
    turned = np.einsum("eia,epiqj,ejb->epaqb", axes, blocks, axes, optimize=True)
    return turned.reshape(ne, size, size)


def gathered(field: np.ndarray, connectivity: np.ndarray, axes: np.ndarray) -> np.ndarray:
    """Return the nodal field (n, 6, k) of each element in its local axes: (ne, 6 c, k)."""
    ne = len(connectivity)
    values = field[connectivity].reshape(ne, -1, 3, field.shape[-1])
    return np.einsum("eai,epik->epak", axes, values, optimize=True).reshape(ne, -1, field.shape[-1])


def scattered(values: np.ndarray, connectivity: np.ndarray, number_of_nodes: int) -> np.ndarray:
    """Return the mean (n, ...) of element corner values (ne, c, ...); NaN at nodes without an element."""
    total = np.zeros((number_of_nodes, *values.shape[2:]))
    np.add.at(total, connectivity.ravel(), values.reshape(-1, *values.shape[2:]))
    count = np.bincount(connectivity.ravel(), minlength=number_of_nodes).astype(float)
    count[count == 0.0] = np.nan
    return total / count.reshape(-1, *(1,) * (values.ndim - 2))
