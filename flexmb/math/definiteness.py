"""Definite and semidefinite matrices, and what a factorisation tells of one that is neither."""

from __future__ import annotations

import numpy as np

from flexmb.errors import ReductionError

__all__ = ["NotPositiveDefinite", "definite", "semidefinite", "symmetric"]

ROUNDING = 1e-9
"""Share of the largest eigenvalue below which a negative one is rounding."""
ROUNDED = 1e-13
"""Share of the largest entry by which products of matrices make one unsymmetric."""
SINGULAR = 1e-13
"""Least eigenvalue, with a diagonal of ones, of a matrix that can be inverted with digits left."""


def definite(matrix: np.ndarray) -> bool:
    """Whether a small symmetric matrix is positive definite, whatever the units of its rows; False if not finite."""
    matrix = np.asarray(matrix, float)
    diagonal = np.diagonal(matrix)
    if not np.isfinite(matrix).all() or not (diagonal > 0.0).all():
        return False
    scale = np.sqrt(diagonal)
    scaled = matrix / scale / scale[:, None]
    return bool(np.isfinite(scaled).all() and np.linalg.eigvalsh(scaled)[0] > SINGULAR)


def semidefinite(matrix: np.ndarray) -> bool:
    """Whether a small symmetric matrix has no negative eigenvalue beyond rounding; False if not finite."""
    matrix = np.asarray(matrix, float)
    largest = np.abs(matrix).max(initial=0.0)
    if not np.isfinite(largest):
        return False
    return largest == 0.0 or bool(np.linalg.eigvalsh(matrix / largest)[0] >= -ROUNDING)


def symmetric(matrix: np.ndarray, share: float = 1e-5) -> bool:
    """Whether matrices (..., n, n) are symmetric, or Hermitian, but for a share of what their diagonals permit.

    An entry of a semidefinite matrix is at most the root of the product of its two diagonal entries. In other units
    these are other numbers: entries below 1e-8 are all of a part of a millimetre.
    """
    matrix = np.asarray(matrix)
    size = np.sqrt(np.abs(np.diagonal(matrix, axis1=-2, axis2=-1)))
    permitted = size[..., :, None] * size[..., None, :]
    apart = np.abs(matrix - matrix.conj().swapaxes(-1, -2))
    return bool(np.all(apart <= share * permitted + ROUNDED * np.abs(matrix).max(initial=0.0)))


class NotPositiveDefinite(ReductionError):
    """The matrix is singular or indefinite; `freedom` is the row at which the factorisation broke down."""

    def __init__(self, freedom: int, found: str):
        super().__init__(
            "Sparse factorisation",
            found=found,
            expected="a symmetric positive definite matrix",
            remedy="Look for a mechanism or a missing support at this freedom",
        )
        self.freedom = freedom
