"""The door to sparse factorisations of symmetric positive definite matrices.

``factor(K, coordinates)`` returns an object with ``.solve(B)`` for blocks of right-hand sides. Which code factorises is
an object too: the own `Multifrontal` and SciPy's `SuperLU` are always there, `Pardiso` and `Cholmod` where they are
installed. All of them are checked by the residual of their first solve.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np
from scipy import sparse

from flexmb.errors import ReductionError
from flexmb.math.definiteness import NotPositiveDefinite

__all__ = ["Backend", "Factor", "NotPositiveDefinite", "SuperLU", "factor"]

_RESIDUAL = 1e-8  # a relative residual above this means a wrong factor, not rounding
_SMALL = 2000  # freedoms; below, SuperLU needs a few milliseconds and no compiled kernel


class Factor(Protocol):
    """A factorised matrix.

    ``n`` rows, ``nnz`` entries of the factor, ``weakest_pivot``: the smallest pivot relative to its diagonal entry, at
    the level of rounding where the matrix is singular (0 where the code does not tell).
    """

    n: int
    nnz: int
    weakest_pivot: float

    def solve(self, B: np.ndarray) -> np.ndarray:
        """Return K^-1 B for B (n,) or (n, k)."""


class Backend(Protocol):
    """A code that factorises: called with K (n, n) csr and coordinates (n, 3) or None, it returns a `Factor`."""

    def __call__(self, K: sparse.csr_matrix, coordinates: np.ndarray | None) -> Factor:
        """Factorise K."""


def factor(K: sparse.spmatrix, coordinates: np.ndarray | None = None, *, backend: Backend | None = None) -> Factor:
    """Factorise a symmetric positive definite sparse matrix.

    Parameters
    ----------
    K : (n, n) sparse, symmetric positive definite
    coordinates : (n, 3) or None
        Position of the node of each freedom, for a geometric ordering; freedoms of one node stand together. Without
        them the distances in the matrix graph take their place.
    backend : Backend or None
        Which code factorises: None for SuperLU on small matrices and the own multifrontal factorisation on others.

    Raises
    ------
    NotPositiveDefinite
        With the freedom at which the factorisation broke down.
    """
    K = sparse.csr_matrix(K, dtype=float)
    if K.shape[0] == 0:
        return _Empty()
    if backend is None:
        backend = SuperLU() if K.shape[0] < _SMALL else _own()
    return _Checked(K, backend(K, coordinates))


def _own() -> Backend:
    from flexmb.math.multifrontal import Multifrontal  # numba loads only where it is needed

    return Multifrontal()


class SuperLU:
    """SciPy's SuperLU in symmetric mode with a minimum-degree ordering: for small matrices, and as the reference."""

    def __call__(self, K: sparse.csr_matrix, coordinates: np.ndarray | None = None) -> Factor:
        """Factorise K."""
        return _SuperLUFactor(K)


class _SuperLUFactor:
    def __init__(self, K: sparse.csr_matrix):
        from scipy.sparse.linalg import splu

        self.n, diagonal = K.shape[0], K.diagonal()
        try:
            self._lu = splu(
                K.tocsc(), permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True}
            )
        except RuntimeError as error:
            freedom = int(np.argmin(np.abs(diagonal)))
            raise NotPositiveDefinite(freedom, f"exactly singular ({error})") from error
        self.nnz = self._lu.L.nnz
        pivots = self._lu.U.diagonal()[self._lu.perm_c]  # of each freedom
        worst = int(np.argmin(pivots))
        if not pivots[worst] > 0.0:
            raise NotPositiveDefinite(worst, f"the pivot {pivots[worst]:.3g} at freedom {worst}")
        self.weakest_pivot = float(np.min(pivots / diagonal))

    def solve(self, B: np.ndarray) -> np.ndarray:
        return self._lu.solve(np.ascontiguousarray(B, float))


class _Checked:
    """Any factor, with the residual of the first solve checked against the matrix."""

    def __init__(self, K: sparse.csr_matrix, inner: Factor):
        self.n, self.nnz, self.weakest_pivot = inner.n, inner.nnz, inner.weakest_pivot
        self._inner, self._K = inner, K

    def solve(self, B: np.ndarray) -> np.ndarray:
        """Return K^-1 B for B (n,) or (n, k)."""
        B = np.asarray(B, float)
        if not B.size:  # a body that nothing loads; some factors take no empty blocks
            return B.copy()
        X = self._inner.solve(B)
        if self._K is not None:
            residual = np.abs(self._K @ X - B).max()
            scale = (abs(self._K) @ np.abs(X)).max() + np.abs(B).max()
            if not residual <= _RESIDUAL * scale:
                raise ReductionError(
                    "Sparse factorisation",
                    found=f"relative residual {residual / scale:.1e} of the first solve",
                    expected=f"at most {_RESIDUAL:g}",
                    remedy="The matrix is unsymmetric or nearly singular: check its symmetry and its supports",
                )
            self._K = None
        return X


class _Empty:
    n, nnz, weakest_pivot = 0, 0, 1.0

    def solve(self, B: np.ndarray) -> np.ndarray:
        """Return the empty block."""
        return np.zeros_like(np.asarray(B, float))
