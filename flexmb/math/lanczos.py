"""Lowest eigenpairs of K x = w2 M x by block Lanczos on block solves.

The operator is X -> K^-1 M X, symmetric in the M scalar product. A single sparse solve is memory bound, a block of
eight costs little more: blocks are 1.4 to 2 times faster than one vector at a time, and they find multiple eigenvalues.
(Grimes, Lewis & Simon, SIAM J. Matrix Anal. Appl. 15 (1994) 228-272; full reorthogonalisation instead of selective.)
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.linalg import eigh

from flexmb.errors import FlexmbError

__all__ = ["lowest_modes"]

Operator = Callable[[np.ndarray], np.ndarray]


def lowest_modes(
    solve: Operator,
    mass: Operator,
    n: int,
    count: int,
    *,
    start: np.ndarray | None = None,
    block: int = 8,
    tolerance: float = 1e-9,
) -> tuple[np.ndarray, np.ndarray]:
    """Return the lowest eigenvalues and eigenvectors of K x = w2 M x.

    Parameters
    ----------
    solve : callable (n, k) -> (n, k)
        K^-1 on the admissible subspace (constraints are built into it).
    mass : callable (n, k) -> (n, k)
        Product with M, symmetric positive semidefinite.
    n, count : int
        Size, and how many pairs are asked for.
    start : (n, k) or None
        Approximate modes to begin with.
    block, tolerance
        Vectors per block solve; relative residual bound of the eigenvalues of K^-1 M.

    Returns
    -------
    w2 : (k,), 1/s2, ascending
    X : (n, k), X^T M X = I
        k = count, or less where the matrix has fewer modes with mass.
    """
    rng = np.random.default_rng(20210)
    first = rng.standard_normal((n, block))
    if start is not None and start.shape[1]:
        first[:, : min(block, start.shape[1])] += 1e3 * start[:, :block] / np.abs(start[:, :block]).max()
    V, k = (
        np.zeros((n, min(n, 16 * (count + block))), order="F"),
        0,
    )  # columns take memory when they are written
    T = np.zeros((0, 0))
    Q, MQ = _orthonormal(solve(mass(first)), mass, V[:, :0])
    if not Q.shape[1]:  # nothing with mass moves
        return np.zeros(0), np.zeros((n, 0))
    while True:
        p = Q.shape[1]
        if k + p > V.shape[1]:
            V = np.hstack([V, np.zeros((n, V.shape[1]), order="F")])
        V[:, k : k + p] = Q
        basis = V[:, : k + p]
        W = solve(MQ)
        coefficients = basis.T @ mass(W)
        W -= basis @ coefficients
        T = np.block([[T, coefficients[:k]], [coefficients[:k].T, coefficients[k:]]])
        T = 0.5 * (T + T.T)
        theta, S = eigh(T)
        Q, MQ = _orthonormal(W, mass, basis, scale=theta[-1])
        found = min(count, len(theta))
        wanted = slice(len(theta) - found, None)
        error = np.linalg.norm((MQ.T @ W) @ S[k:, wanted], axis=0)
        k += p
        converged = found == count and np.all(error <= tolerance * theta[wanted])
        if converged or Q.shape[1] == 0:
            keep = np.flatnonzero(theta[wanted] > 1e-14 * theta[-1])[::-1]
            order = keep + (len(theta) - found)
            return 1.0 / theta[order], basis @ S[:, order]


def _orthonormal(W: np.ndarray, mass: Operator, V: np.ndarray, scale: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """Return an M-orthonormal basis Q of W, M-orthogonal to V, and M Q; directions without mass are dropped.

    M V is not stored: it would double the memory, and a product with M costs little beside a solve.
    """
    while True:
        W = W - V @ (V.T @ mass(W))
        MW = mass(W)
        gram = W.T @ MW
        if not np.all(np.isfinite(gram)):
            raise FlexmbError(
                "Normal modes",
                found="products of stiffness and mass beyond the range of numbers",
                expected="K and M of a part in SI units: squares of their entries, and of their ratios, are finite",
                remedy="Correct the modulus, the density, sections, thicknesses and masses",
            )
        size, vectors = eigh(0.5 * (gram + gram.T))
        floor = max(1e-14 * size[-1], (1e-13 * scale) ** 2) if len(size) else 0.0
        keep = size > floor
        turn = vectors[:, keep] / np.sqrt(size[keep])
        W, MW = W @ turn, MW @ turn
        if not keep.any() or size[keep][0] > 1e-4 * size[-1]:
            return W, MW
        scale = 0.0  # nearly dependent columns lost digits in the division: once more
