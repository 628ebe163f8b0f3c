"""Multifrontal Cholesky factorisation of sparse symmetric positive definite matrices (Duff & Reid 1983).

The order comes from nested dissection on node coordinates, so every front is a dense block and nearly all the work is
LAPACK's (dpotrf, dtrsm, dsyrk); the assembly of the fronts is compiled. One BLAS thread: fronts are too small for more.
"""

from __future__ import annotations

from functools import cache
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from scipy import sparse
from scipy.linalg.blas import dgemm, dsyrk, dtrsm
from scipy.linalg.lapack import dpotrf

from flexmb.math.definiteness import NotPositiveDefinite
from flexmb.math.kernel import kernel
from flexmb.math.nested_dissection import dissect, front_tree, node_graph, pseudo_coordinates

__all__ = ["Multifrontal"]

_PANEL = 128  # columns kept together in the factor of a wide front
_LEAF = 120  # freedoms of a part that is not divided further (measured: flat between 90 and 200)


class Multifrontal:
    """The factorisation of flexmb itself: no dependency, as fast as PARDISO on solid models."""

    def __call__(self, K: sparse.csr_matrix, coordinates: np.ndarray | None = None) -> MultifrontalFactor:
        """Factorise K."""
        return MultifrontalFactor(K, coordinates)


@cache
def _threads():
    from threadpoolctl import ThreadpoolController

    return ThreadpoolController()


class MultifrontalFactor:
    """L L^T = P K P^T, front by front."""

    def __init__(self, K: sparse.csr_matrix, coordinates: np.ndarray | None):
        self.n = K.shape[0]
        node_of, x = _nodes(self.n, coordinates)
        start, neighbours = node_graph(K, node_of, int(node_of.max()) + 1)
        if x is None:
            x = pseudo_coordinates(start, neighbours)
        leaf = max(_LEAF * len(x) // self.n, 4)
        order, ends = dissect(start, neighbours, x, leaf)
        rows_start, rows, parent = front_tree(start, neighbours, order, ends)
        self._number(node_of, order, ends, rows_start, rows)
        with _threads().limit(limits=1, user_api="blas"):
            self._factorise(K, parent)
        self.nnz = sum(p.own.shape[0] * (p.own.shape[0] + 1) // 2 + p.below.size for p in self._panels)

    def _number(self, node_of, order, ends, rows_start, rows) -> None:
        """Expand nodes to freedoms: permutation, own freedoms [first, last) and boundary freedoms of every front."""
        position = np.empty(len(order), np.int64)
        position[order] = np.arange(len(order))
        self._permutation = np.argsort(position[node_of], kind="stable")
        freedom_start = np.concatenate([[0], np.cumsum(np.bincount(node_of, minlength=len(order))[order])])
        self._last = freedom_start[ends]
        self._first = np.concatenate([[0], self._last[:-1]])
        self._rows = [_expand(freedom_start, rows[a:b]) for a, b in pairwise(rows_start)]

    def _factorise(self, K: sparse.csr_matrix, parent: np.ndarray) -> None:
        permutation = self._permutation
        place = np.empty(self.n, np.int64)
        place[permutation] = np.arange(self.n)
        local = np.empty(self.n, np.int64)
        self._panels: list[_Panel] = []
        self.weakest_pivot, diagonal = 1.0, K.diagonal()[permutation]
        waiting: list[list] = [[] for _ in parent]
        for f, rows in enumerate(self._rows):
            first, last = self._first[f], self._last[f]
            own = np.zeros((last - first, last - first), order="F")
            below = np.zeros((len(rows), last - first), order="F")
            update = np.zeros((len(rows), len(rows)), order="F")
            local[rows] = np.arange(len(rows))
            assemble(K.indptr, K.indices, K.data, permutation, place, first, last, local, own, below)
            for child_rows, child in waiting[f]:
                extend_add(child, child_rows, first, last, local, own, below, update)
            waiting[f] = []
            own, info = dpotrf(own, lower=1, clean=0, overwrite_a=1)
            if info > 0:
                freedom = int(permutation[first + info - 1])
                raise NotPositiveDefinite(freedom, f"a pivot that is not positive at freedom {freedom}")
            pivots = np.diagonal(own) ** 2 / diagonal[first:last]
            self.weakest_pivot = min(self.weakest_pivot, float(pivots.min()))
            if len(rows):
                below = dtrsm(1.0, own, below, side=1, lower=1, trans_a=1, overwrite_b=1)
                update = dsyrk(-1.0, below, beta=1.0, c=update, lower=1, overwrite_c=1)
                waiting[parent[f]].append((rows, packed(update)))
            self._panels += _panels(first, last, own, below, rows)

    def solve(self, B: np.ndarray) -> np.ndarray:
        """Return K^-1 B for B (n,) or (n, k): k columns at once cost little more than one."""
        B = np.asarray(B, float)
        X = B.reshape(self.n, -1)[self._permutation]  # the rows of a panel transposed are a Fortran array
        with _threads().limit(limits=1, user_api="blas"):
            self._forward(X)
            self._backward(X)
        out = np.empty_like(X)
        out[self._permutation] = X
        return out.reshape(B.shape)

    def _forward(self, X: np.ndarray) -> None:
        for p in self._panels:
            Y = dtrsm(1.0, p.own, X[p.first : p.last].T, side=1, lower=1, trans_a=1, overwrite_b=1)
            X[p.first : p.last] = Y.T
            if len(p.rows):
                X[p.rows] -= dgemm(1.0, Y, p.below, trans_b=1).T

    def _backward(self, X: np.ndarray) -> None:
        for p in reversed(self._panels):
            Y = X[p.first : p.last].T
            if len(p.rows):
                Y = dgemm(-1.0, X[p.rows].T, p.below, beta=1.0, c=Y, overwrite_c=1)
            X[p.first : p.last] = dtrsm(1.0, p.own, Y, side=1, lower=1, overwrite_b=1).T


class _Panel(NamedTuple):
    """Columns [first, last) of L: the triangle `own`, and `below` at the freedoms `rows`."""

    first: int
    last: int
    own: np.ndarray
    below: np.ndarray
    rows: np.ndarray


def _panels(first: int, last: int, own: np.ndarray, below: np.ndarray, rows: np.ndarray) -> list[_Panel]:
    """Cut a wide front into panels: the square of a front wastes its upper half, the squares of panels little."""
    width = last - first
    if width <= 2 * _PANEL:
        return [_Panel(first, last, own, below, rows)]
    cut = []
    for a in range(0, width, _PANEL):
        b = min(a + _PANEL, width)
        later = np.concatenate([np.arange(first + b, last), rows])
        cut.append(
            _Panel(
                first + a,
                first + b,
                np.asfortranarray(own[a:b, a:b]),
                np.asfortranarray(np.concatenate([own[b:, a:b], below[:, a:b]])),
                later,
            )
        )
    return cut


def _nodes(n: int, coordinates: np.ndarray | None) -> tuple[np.ndarray, np.ndarray | None]:
    """Group freedoms with equal coordinates into nodes: (node of each freedom, coordinates of each node)."""
    if coordinates is None:
        return np.arange(n), None
    coordinates = np.asarray(coordinates, float)
    new = np.any(np.diff(coordinates, axis=0) != 0.0, axis=1)  # freedoms of a node stand together as a rule
    node_of = np.concatenate([[0], np.cumsum(new)])
    return node_of, coordinates[np.concatenate([[0], np.flatnonzero(new) + 1])]


def _expand(start: np.ndarray, positions: np.ndarray) -> np.ndarray:
    """Freedoms of the nodes at the given positions, ascending."""
    counts = start[positions + 1] - start[positions]
    shift = np.repeat(start[positions] - np.concatenate([[0], np.cumsum(counts)[:-1]]), counts)
    return np.arange(counts.sum()) + shift if len(positions) else np.zeros(0, np.int64)


@kernel
def assemble(indptr, indices, data, permutation, place, first, last, local, own, below):
    """Put the lower triangle of the columns first..last of K into the front."""
    for column in range(first, last):
        row = permutation[column]  # K is symmetric: its row is its column
        for e in range(indptr[row], indptr[row + 1]):
            p = place[indices[e]]
            if p >= last:
                below[local[p], column - first] += data[e]
            elif p >= column:
                own[p - first, column - first] += data[e]


@kernel
def extend_add(child, rows, first, last, local, own, below, update):
    """Add a child's packed update matrix to the front; `rows` are its freedoms, ascending."""
    n, e = len(rows), 0
    split = np.searchsorted(rows, last)
    for j in range(n):
        if j < split:
            c = rows[j] - first
            for i in range(j, split):
                own[rows[i] - first, c] += child[e]
                e += 1
            for i in range(split, n):
                below[local[rows[i]], c] += child[e]
                e += 1
        else:
            c = local[rows[j]]
            for i in range(j, n):
                update[local[rows[i]], c] += child[e]
                e += 1


@kernel
def packed(update):
    """Return the lower triangle, column by column: waiting updates take half the memory."""
    n, e = len(update), 0
    out = np.empty(n * (n + 1) // 2)
    for j in range(n):
        for i in range(j, n):
            out[e] = update[i, j]
            e += 1
    return out
