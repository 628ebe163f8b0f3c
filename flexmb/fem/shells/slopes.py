"""Slopes of nodal fields on surfaces of triangles: quadratic fits through the nodes around.

The strain at the corner of a triangle is of first order, and the mean of the cells at an edge is a value beside it. The
displacements of nodes are of second order. So is the slope of a quadratic through them, fitted by least squares around
each node, on edges too; in bending it is exact (polynomial preserving recovery: Zhang & Naga, SIAM J. Sci. Comput. 26
(2005) 1192-1213).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse

__all__ = ["NodalSlopes", "nodal_slopes"]

FOLD = np.cos(np.radians(40.0))
"""Cosine of the angle between two cells beyond which the surface counts as folded: stress jumps there."""
FEWEST = 9
"""Nodes of a fit: a quadratic has six coefficients."""
RINGS = 3
SINGULAR = 1e-3
"""Least relative singular value of a fit; below, the nodes lie on few lines and tell no slope across."""


@dataclass(frozen=True, eq=False)
class NodalSlopes:
    """Slopes along the surfaces that meet at nodes.

    Parameters
    ----------
    node : (nl,), int
        Node of every surface; several at a fold or a step of the thickness.
    share : (nl,), -
        Share of its cells in the node's.
    axes : (nl, 3, 3)
        Rows: x and y along the surface, z normal, in body axes.
    cell : (nl,), int
        One of its cells: all are of one thickness.
    along_x, along_y : (nl, n) csr, 1/m
        Derivatives at the node of a field at the nodes.
    left : (ne, c), bool
        Corners of cells whose node has too few others around it for a fit.
    """

    node: np.ndarray
    share: np.ndarray
    axes: np.ndarray
    cell: np.ndarray
    along_x: sparse.csr_matrix
    along_y: sparse.csr_matrix
    left: np.ndarray


def nodal_slopes(
    connectivity: np.ndarray, normals: np.ndarray, thickness: np.ndarray, nodes: np.ndarray
) -> NodalSlopes:
    """Return the slopes at all nodes of cells (ne, c) with normals (ne, 3), thickness (ne,), m, nodes (n, 3), m."""
    n, ne, count = len(nodes), len(connectivity), connectivity.shape[1]
    cells_of = sparse.csr_matrix(
        (np.ones(ne * count), (connectivity.ravel(), np.repeat(np.arange(ne), count))), shape=(n, ne)
    )
    left = np.zeros((ne, count), bool)
    found: list[tuple] = []
    entries: list[tuple[np.ndarray, np.ndarray, np.ndarray]] = []
    for node in map(int, np.flatnonzero(np.diff(cells_of.indptr))):
        own = _row(cells_of, node)
        for leaf in _leaves(own, normals, thickness):
            axes = _axes(normals[leaf].mean(axis=0))
            fit = _fit(node, leaf, axes, connectivity, cells_of, normals, thickness, nodes)
            if fit is None:
                left[leaf] |= connectivity[leaf] == node
                continue
            around, slopes = fit
            entries.append((np.full(len(around), len(found)), around, slopes))
            found.append((node, len(leaf) / len(own), axes, leaf[0]))
    rows, columns = (np.concatenate([entry[k] for entry in entries] or [np.zeros(0, int)]) for k in range(2))
    values = np.concatenate([entry[2] for entry in entries] or [np.zeros((2, 0))], axis=1)
    along = [sparse.csr_matrix((value, (rows, columns)), shape=(len(found), n)) for value in values]
    places, shares, frames, first = (
        np.array([item[k] for item in found], kind) for k, kind in enumerate((int, float, float, int))
    )
    return NodalSlopes(places, shares, frames.reshape(-1, 3, 3), first, along[0], along[1], left)


def _row(matrix: sparse.csr_matrix, k: int) -> np.ndarray:
    return matrix.indices[matrix.indptr[k] : matrix.indptr[k + 1]]


def _leaves(own: np.ndarray, normals: np.ndarray, thickness: np.ndarray) -> list[np.ndarray]:
    """Return the cells at a node by the smooth surfaces, of one side and thickness, that meet there."""
    remaining, found = own, []
    while len(remaining):
        same = _same(remaining[0], remaining, normals, thickness) & (normals[remaining] @ normals[remaining[0]] > 0.0)
        found.append(remaining[same])
        remaining = remaining[~same]
    return found


def _same(cell: int, others: np.ndarray, normals: np.ndarray, thickness: np.ndarray) -> np.ndarray:
    """Return which cells go on with the surface of a cell, whichever side their normals point to (mask)."""
    alike = np.abs(normals[others] @ normals[cell]) >= FOLD
    return alike & (np.abs(thickness[others] - thickness[cell]) <= 1e-9 * thickness[cell])


def _axes(normal: np.ndarray) -> np.ndarray:
    """Return axes with z along a normal, (3, 3), rows."""
    z = normal / np.linalg.norm(normal)
    x = np.cross(np.eye(3)[np.abs(z).argmin()], z)
    x /= np.linalg.norm(x)
    return np.stack([x, np.cross(z, x), z])


def _fit(node, leaf, axes, connectivity, cells_of, normals, thickness, nodes):
    """Return the nodes of a patch and the weights (2, k) of their values in the two slopes, or None."""
    cells = leaf
    for ring in range(RINGS):
        around = np.unique(connectivity[cells])
        if len(around) >= FEWEST or ring == RINGS - 1:
            x = (nodes[around] - nodes[node]) @ axes[:2].T
            size = np.abs(x).max()
            a, b = x.T / size
            terms = np.column_stack([np.ones(len(a)), a, b, a * a, a * b, b * b])
            u, s, vt = np.linalg.svd(terms, full_matrices=False)
            if len(around) >= terms.shape[1] and s[-1] > SINGULAR * s[0]:
                return around, (vt.T[1:3] / s) @ u.T / size
        touching = np.unique(np.concatenate([_row(cells_of, k) for k in around]))
        cells = touching[_same(leaf[0], touching, normals, thickness)]
    return None
