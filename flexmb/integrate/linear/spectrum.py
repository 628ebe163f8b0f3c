"""Eigenvalues of linear equations of motion, zeros distinguished from rounding."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.linalg import eig, matrix_balance

__all__ = ["FirstOrder", "first_order", "modes_of", "state_matrix", "without_integrals"]

NOISE = 30.0
"""A singular value below so many times the rounding of the sums that make it is zero."""
EQUALISED = 10
"""How often rows and columns are scaled by the roots of their largest entries: each halves what is left (Ruiz 2001)."""
APART = 1e3
"""Ratio of eigenvalues up to which one matrix has the digits of all of them: ten are left of the square."""
GAP = 1.0 + 1e-3
"""Ratio of neighbours between which the spectrum is divided: a conjugate pair stays together."""
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
    heavy, damped, stiff = (aP @ np.abs(X) @ aN for X in (of.M, of.C, of.summed))
    # centrifugal and gyroscopic terms cancel in part before they come here
    damped, stiff = damped + fastest * heavy, stiff + fastest * damped + fastest**2 * heavy
    stiff, damped = stiff + damped @ aF + heavy @ aF @ aF, damped + heavy @ aF
    stiff += STEADY / (NOISE * digits) * fastest**2 * heavy
    # a shape has rounding for zeros, and the product with the stiffness of what it should not move is left
    stiff += np.finfo(float).eps ** 2 / digits * _stiffest(of) * heavy
    return FirstOrder(M @ Q, (M @ F + C) @ Q, M @ F @ F + C @ F + K, Q, F, digits * np.hstack([stiff, damped @ aQ]))


def _stiffest(of) -> float:
    """Return the largest square of a frequency, 1/s^2, that an entry of the stiffness makes with its own masses."""
    masses = np.abs(of.M.diagonal())
    has = masses > 0.0
    root = np.sqrt(masses[has])
    return float((of.summed[np.ix_(has, has)] / np.outer(root, root)).max(initial=0.0))


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
    B, E, rounded, unit = _scaled(of)
    still, zeros, left, rest = _zeros(B, E, rounded)
    values, vectors = _eigen(left.T @ B @ rest, left.T @ E @ rest)
    shapes = (rest @ vectors).astype(complex)
    # the part along the zeros follows: no other eigenvalue is left there, so that this is regular
    reached = E @ zeros
    along = reached.T @ (B @ shapes - (E @ shapes) * values)
    own, moved = reached.T @ (B @ zeros), reached.T @ reached
    for k, value in enumerate(values if zeros.shape[1] else ()):
        shapes[:, k] -= zeros @ np.linalg.solve(own - value * moved, along[:, k])
    values = np.concatenate([np.zeros(still.shape[1]), values])
    shapes = (unit[:, None] * np.hstack([still, shapes]))[:nz]
    order = np.lexsort((np.abs(values.real), np.abs(values.imag)))
    return values[order], shapes[:, order]


def _scaled(of: FirstOrder) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return B and E of E x' = B x, the rounding of B, and the units of x = (z, w).

    Rows and columns are scaled to the size of the sums behind them, so that no unit and no stiff part counts more.
    """
    nz, n = of.Q.shape
    eps = np.finfo(float).eps
    B = np.block([[of.F, of.Q], [-of.K, -of.C]])
    E = np.block([[np.eye(nz), np.zeros((nz, n))], [np.zeros((n, nz)), of.M]])
    rounded = eps * np.abs(B)
    rounded[nz:] += of.rounded
    # sums that cancel before they come here leave rounding in columns that should be empty
    rounded[nz:, :nz] = rounded[nz:, :nz].max(axis=1, keepdims=True, initial=0.0)
    A = state_matrix(of)[nz:]
    fastest = max(np.sqrt(np.abs(A[:, :nz]).max(initial=0.0)), np.abs(A[:, nz:]).max(initial=0.0))
    # a coordinate that no force knows has rounding only, and keeps its unit by E
    sizes = rounded / eps + np.sqrt(eps) * fastest * np.abs(E)
    rows, columns = np.ones(len(B)), np.ones(len(B))
    for _ in range(EQUALISED):
        now = sizes * rows[:, None] * columns
        across, along = now.max(axis=1), now.max(axis=0)
        rows /= np.sqrt(np.where(across > 0.0, across, 1.0))
        columns /= np.sqrt(np.where(along > 0.0, along, 1.0))
    B, E, rounded = (X * rows[:, None] * columns for X in (B, E, rounded))
    return B, E, rounded, columns


def _zeros(B: np.ndarray, E: np.ndarray, rounded: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return bases of what does not move, of all that ends there, of the equations of the others, and of the others.

    They are sought with forces as they are. Divided by the masses, the rounding of stiff springs on light masses would
    hide slow motions of heavy ones.
    """
    still, zeros, left, rest, largest = None, np.zeros((len(B), 0)), np.eye(len(B)), np.eye(len(B)), 0.0
    while rest.shape[1]:
        U, sizes, V = np.linalg.svd(left.T @ B @ rest)
        aU, aV = np.abs(left @ U), np.abs(rest @ V.T)
        largest = max(largest, sizes[0])  # what is taken out is known to the rounding of all
        none = sizes <= NOISE * (np.sum(aU * (rounded @ aV), axis=0) + np.finfo(float).eps * largest)
        if not np.any(none):
            break
        zeros = np.hstack([zeros, rest @ V[none].T])
        still = zeros if still is None else still
        rest = rest @ V[~none].T
        reached = E @ zeros
        left = np.linalg.qr(reached / np.linalg.norm(reached, axis=0), mode="complete")[0][:, zeros.shape[1] :]
    return zeros if still is None else still, zeros, left, rest


def _eigen(B: np.ndarray, E: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the eigenvalues of E x' = B x with imaginary part >= 0 and their vectors; B is regular.

    Rounding spoils eigenvalues by eps times the largest of the matrix, w2 of a mode by eps times (w_max / w)^2: all
    digits of the bending of a plate of a thousandth, beside the stretch of its thickness. The inverse matrix has the
    digits of the slow ones. So the fast half is taken from one and the slow half from the other, where they are far
    apart, divided at a gap.
    """
    if not len(B):
        return np.zeros(0, complex), np.zeros((0, 0), complex)
    values, vectors = _balanced(np.linalg.solve(E, B))
    size = np.abs(values)
    if size[-1] > APART * size[0]:
        slow, slow_vectors = _balanced(np.linalg.solve(B, E), inverse=True)
        slow_size = np.abs(slow)
        between = np.minimum(size[1:] / size[:-1], slow_size[1:] / slow_size[:-1])
        middle = np.abs(np.log(size[1:] * size[:-1]) - np.log(slow_size[0] * size[-1]))
        gaps = np.flatnonzero(between > GAP)
        if len(gaps):
            k = int(gaps[np.argmin(middle[gaps])]) + 1
            values = np.concatenate([slow[:k], values[k:]])
            vectors = np.hstack([slow_vectors[:, :k], vectors[:, k:]])
    chosen = np.flatnonzero(values.imag >= 0.0)
    return values[chosen], vectors[:, chosen]


def _balanced(A: np.ndarray, inverse: bool = False) -> tuple[np.ndarray, np.ndarray]:
    """Return the eigenvalues of A, or their inverses, the smallest first, and the vectors."""
    balanced, (scale, _) = matrix_balance(A, permute=False, separate=True)
    values, vectors = eig(balanced)
    values = 1.0 / values if inverse else values
    order = np.argsort(np.abs(values), kind="stable")
    return values[order], scale[:, None] * vectors[:, order]
