"""Eigenvalues of linear equations of motion, zeros distinguished from rounding."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.linalg import eig, matrix_balance

__all__ = ["FirstOrder", "first_order", "modes_of", "state_matrix", "without_integrals"]

NOISE = 30.0
"""A singular value below so many times the rounding of the sums that make it is zero."""
STEADY = 1e-9
"""Centrifugal stiffness is known to this, relative: the tolerance of the equilibrium that `statics` finds."""


class FirstOrder(NamedTuple):
    """M w' + C w + K z = 0, z' = Q w + F z: (n, n), K (n, nz), Q (nz, n), F (nz, nz).

    rounded (n, nz + n) : bound of what rounding makes of K and C.
    """

    M: np.ndarray
    C: np.ndarray
    K: np.ndarray
    Q: np.ndarray
    F: np.ndarray
    rounded: np.ndarray


def first_order(of, basis, fastest: float, digits: float) -> FirstOrder:
    """Return the equations of `Coefficients` in the coordinates of `Independent`.

    Bodies turn with `fastest`, rad/s; positions are rounded to `digits`, relative to the lengths of the model.
    """
    N, Q, F, P = basis
    M, C, K = (P.T @ X @ N for X in (of.M, of.C, of.K))
    aP, aN, aQ, aF = np.abs(P).T, np.abs(N), np.abs(Q), np.abs(F)
    heavy, damped, stiff = (aP @ np.abs(X) @ aN for X in (of.M, of.C, of.K))
    # centrifugal and gyroscopic terms cancel in part before they come here
    damped, stiff = damped + fastest * heavy, stiff + fastest * damped + fastest**2 * heavy
    stiff, damped = stiff + damped @ aF + heavy @ aF @ aF, damped + heavy @ aF
    stiff += STEADY / (NOISE * digits) * fastest**2 * heavy
    return FirstOrder(M @ Q, (M @ F + C) @ Q, M @ F @ F + C @ F + K, Q, F, digits * np.hstack([stiff, damped @ aQ]))


def without_integrals(of: FirstOrder, states: int) -> FirstOrder:
    """Return the equations without the last coordinates z: integrals of first-order states, which nothing reads."""
    if not states:
        return of
    nz = len(of.F) - states
    rounded = np.delete(of.rounded, np.s_[nz : nz + states], axis=1)
    return of._replace(K=of.K[:, :nz], Q=of.Q[:nz], F=of.F[:nz, :nz], rounded=rounded)


def state_matrix(of) -> np.ndarray:
    """Return A of x' = A x, x = (z, w)."""
    return np.block([[of.F, of.Q], [-np.linalg.solve(of.M, of.K), -np.linalg.solve(of.M, of.C)]])


def modes_of(of: FirstOrder) -> tuple[np.ndarray, np.ndarray]:
    """Return eigenvalues (k,) and shapes in z (nz, k): one of each conjugate pair, all real ones, one zero per shape.

    A body that flies freely has a double zero for each of its six motions: place and speed are both arbitrary, and
    rounding would make a pair of small numbers of any kind of them. What is zero within rounding is taken out first,
    again as long as anything is left of it (the staircase of the zero eigenvalue: Golub & Wilkinson 1976), so that the
    others come without it.
    """
    nz, n = of.Q.shape
    if n == 0:
        return np.zeros(0, complex), np.zeros((nz, 0), complex)
    A = state_matrix(of)
    rounded = np.vstack([np.zeros((nz, nz + n)), np.abs(np.linalg.inv(of.M)) @ of.rounded])
    # velocities in units that make both halves of A alike; not by fast dampers, beside which slow motions would be zero
    pace = np.sqrt(np.abs(A[nz:, :nz]).max(initial=0.0)) or np.abs(A[nz:, nz:]).max(initial=0.0) or 1.0
    unit = np.concatenate([np.ones(nz), np.full(n, pace)])
    A, rounded = A * unit / unit[:, None], rounded * unit / unit[:, None]
    rounded += np.finfo(float).eps * np.abs(A)
    first, zeros, rest = _zeros(A, rounded)
    values, vectors = _eigen(rest.T @ A @ rest)
    shapes = np.zeros((len(A), len(values)), complex)
    slow = zeros.T @ A @ zeros
    for k, (value, y) in enumerate(zip(values, vectors.T, strict=True)):
        x = rest @ y
        # the part along the zeros follows: slow has no other eigenvalue, so that this is regular
        shapes[:, k] = x + zeros @ np.linalg.solve(value * np.eye(len(slow)) - slow, zeros.T @ (A @ x))
    values = np.concatenate([np.zeros(first.shape[1]), values])
    shapes = np.hstack([first, shapes])[:nz]
    order = np.lexsort((np.abs(values.real), np.abs(values.imag)))
    return values[order], shapes[:, order]


def _zeros(A: np.ndarray, rounded: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return orthonormal bases of the null space of A, of all that ends there under its powers, and of the rest."""
    first, zeros, rest = None, np.zeros((len(A), 0)), np.eye(len(A))
    while rest.shape[1]:
        U, sizes, V = np.linalg.svd(rest.T @ A @ rest)
        aU, aV = np.abs(rest @ U), np.abs(rest @ V.T)
        own = np.finfo(float).eps * sizes[0]
        none = sizes <= NOISE * (np.einsum("ik,ij,jk->k", aU, rounded, aV) + own)
        if not np.any(none):
            break
        zeros = np.hstack([zeros, rest @ V[none].T])
        first = zeros if first is None else first
        rest = rest @ V[~none].T
    return zeros if first is None else first, zeros, rest


def _eigen(A: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the eigenvalues with imaginary part >= 0 and their vectors."""
    if not len(A):
        return np.zeros(0, complex), np.zeros((0, 0), complex)
    balanced, (scale, _) = matrix_balance(A, permute=False, separate=True)
    values, vectors = eig(balanced)
    chosen = np.flatnonzero(values.imag >= 0.0)
    return values[chosen], scale[:, None] * vectors[:, chosen]
