"""PARDISO and CHOLMOD behind the door of `factor`: used when they are installed and asked for."""

from __future__ import annotations

import importlib

import numpy as np
from scipy import sparse

from flexmb.errors import ReductionError
from flexmb.math.factor import Factor, NotPositiveDefinite

__all__ = ["Cholmod", "Pardiso"]


class Pardiso:
    """Intel MKL PARDISO, symmetric positive definite (``pip install pypardiso``)."""

    def __call__(self, K: sparse.csr_matrix, coordinates: np.ndarray | None = None) -> Factor:
        """Factorise K."""
        return _PardisoFactor(K, _load("pypardiso", "pip install pypardiso"))


#: Numbers of the MKL manual (one-based). With own settings (1) the solver leaves out the two iterative refinements
#: that its defaults add to every solve: they made each solve 2.7 times longer and changed the fifteenth digit.
_PARDISO_SETTINGS = {
    1: 1,  # own settings
    2: 2,  # ordering by nested dissection
    18: -1,  # count the non-zeros of the factor
    24: 1,  # two-level parallel factorisation
}


class _PardisoFactor:
    def __init__(self, K: sparse.csr_matrix, pypardiso):
        self.n, self.weakest_pivot = K.shape[0], 0.0
        self._upper = sparse.triu(K, format="csr")
        self._solver = pypardiso.PyPardisoSolver(mtype=2)  # the default, 11, treats the matrix as unsymmetric
        for number, value in _PARDISO_SETTINGS.items():
            self._solver.set_iparm(number, value)
        try:
            self._solver.factorize(self._upper)
        except Exception as error:  # PyPardisoError carries only a number
            raise NotPositiveDefinite(int(np.argmin(K.diagonal())), f"PARDISO stopped ({error})") from error
        self.nnz = int(self._solver.get_iparm(18))

    def solve(self, B: np.ndarray) -> np.ndarray:
        B = np.asfortranarray(B, float)
        return np.asarray(self._solver.solve(self._upper, B)).reshape(B.shape)


class Cholmod:
    """SuiteSparse CHOLMOD, supernodal (scikit-sparse 0.4 or later)."""

    def __call__(self, K: sparse.csr_matrix, coordinates: np.ndarray | None = None) -> Factor:
        """Factorise K."""
        return _CholmodFactor(K, _load("sksparse.cholmod", "install SuiteSparse and pip install scikit-sparse"))


class _CholmodFactor:
    def __init__(self, K: sparse.csr_matrix, cholmod):
        self.n, self.weakest_pivot = K.shape[0], 0.0
        factorise = cholmod.cholesky if hasattr(cholmod, "cholesky") else cholmod.cho_factor  # 0.4, 0.5
        try:
            self._factor = factorise(K.tocsc())
        except Exception as error:  # CholmodNotPositiveDefiniteError, named differently in 0.4 and 0.5
            freedom = int(getattr(error, "column", np.argmin(K.diagonal())))
            raise NotPositiveDefinite(freedom, f"CHOLMOD stopped ({error})") from error
        self.nnz = 0

    def solve(self, B: np.ndarray) -> np.ndarray:
        solve = getattr(self._factor, "solve", self._factor)
        return np.asarray(solve(np.asfortranarray(B, float)))


def _load(module: str, how: str):
    try:
        return importlib.import_module(module)
    except ImportError as error:
        raise ReductionError(
            "Sparse factorisation",
            found=f"the package '{module.split('.')[0]}' is not installed",
            expected="an installed package, or backend=None",
            remedy=f"{how[0].upper()}{how[1:]}, or leave the choice to flexmb",
        ) from error
