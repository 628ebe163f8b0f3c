"""The fastest growing motion of the linear equations of a model with many velocities, by sparse factors.

With x' = A x the Cayley transform C = (A + mu) (A - mu)^-1 has the eigenvalues (s + mu) / (s - mu), which are larger
than one where s grows, and largest where it grows by about mu (Cliffe, Garratt & Spence, Eigenvalues of the discretized
Navier-Stokes equation with application to the detection of Hopf bifurcations, Adv. Comput. Math. 1, 1993). A product
with C is a solution with mu^2 M + mu D + K between the constraints. So a few values of mu, ten times apart, find what
grows within some steps of Arnoldi's method; what neither grows nor decays stays at one.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import ArpackError, ArpackNoConvergence, LinearOperator, eigs, splu

__all__ = ["Growth", "fastest_of_many", "within"]

APART = 10.0
"""From one mu to the next."""
SURELY = 1.05
"""Size of an eigenvalue of C from which on its motion grows: of others it is one, but for rounding."""
BASIS, RESTARTS, PAIRS = 16, 5, 4
"""Of Arnoldi's method, and how many eigenvalues it is asked for."""
SOFT = 1e-10
"""What is taken for equality of constraints, so that those which depend on each other can be factorised."""
REFINED = 4
"""Newton's steps towards the eigenvalue."""


class Growth(NamedTuple):
    """A growing motion in the coordinates of the equations."""

    value: complex
    """1/s"""
    shape: np.ndarray
    """(n,) right eigenvector of s^2 M + s D + K between the constraints"""
    left: np.ndarray
    """(n,) left one"""


def fastest_of_many(
    M, D, K, G, least: float, near: float | None = None, look: Callable[[], None] = lambda: None
) -> Growth | None:
    """Return the motion that grows fastest, by at least the rate `least`, 1/s; None if none is found.

    Parameters
    ----------
    M, D, K : (n, n) sparse
        Derivatives of the residual by accelerations, velocities and places, scaled so that M is about one.
    G : (m, n) sparse
        Gradient of the constraints.
    near : float, 1/s
        A rate about which alone is looked.
    look : callable
        Called before every factorisation and every product: what it raises ends the search.
    """
    sizes = [float(abs(part).sum(1).max()) for part in (D, K)]
    most = APART * max(least, sizes[0], np.sqrt(sizes[1]))
    found = None
    places = np.geomspace(least, most, 1 + int(np.ceil(np.log(most / least) / np.log(APART))))
    for mu in places if near is None else (1.3 * near,):  # where it is, the equations are singular
        for value, shape in _grown(M, D, K, G, float(mu), look):
            known = max(least, 0.0 if found is None else 1.01 * found.value.real)
            refined = _refined(M, D, K, G, value, shape, look) if value.real > known else None
            if refined is not None and refined.value.real > known:
                found = refined
    return found


def within(G, x: np.ndarray) -> np.ndarray:
    """Return the part of a vector (n,) that constraints with the gradient G allow."""
    return _Bordered(sparse.identity(len(x), format="csc"), G).solve(x) if G.shape[0] else x


class _Bordered:
    """Solves with a matrix between constraints: [Q, G^T; G, 0]."""

    def __init__(self, Q, G):
        self.n, self.size = Q.shape[0], max(float(abs(Q).max()), np.finfo(float).tiny)
        soft = -SOFT * sparse.identity(G.shape[0])
        self.factors = splu(sparse.bmat([[Q / self.size, G.T], [G, soft]], format="csc").astype(Q.dtype))

    def solve(self, b: np.ndarray, *, adjoint: bool = False) -> np.ndarray:
        whole = np.concatenate([b / self.size, np.zeros(self.factors.shape[0] - self.n)]).astype(self.factors.L.dtype)
        return self.factors.solve(whole, trans="H" if adjoint else "N")[: self.n]


def _at(M, D, K, s):
    return (s * s * M + s * D + K).tocsc()


def _grown(M, D, K, G, mu: float, look) -> list[tuple[complex, np.ndarray]]:
    """Return eigenvalues and place parts of what seems to grow by about `mu`, rounding across constraints among it."""
    n = M.shape[0]
    look()
    try:
        bordered = _Bordered(_at(M, D, K, mu), G)
    except RuntimeError:  # singular
        return []

    def product(z):
        look()
        p, q = z[:n], z[n:]
        x = -bordered.solve(M @ (q + mu * p) + D @ p)
        return np.concatenate([p + 2.0 * mu * x, q + 2.0 * mu * (p + mu * x)])

    places, speeds = (bordered.solve(row) for row in np.random.default_rng(1).normal(size=(2, n)))
    size = np.linalg.norm(places)
    if not np.isfinite(size) or size == 0.0:
        return []
    start = np.concatenate([places, mu * speeds]) / size
    operator = LinearOperator((2 * n, 2 * n), matvec=product, dtype=float)
    try:
        values, vectors = eigs(operator, k=PAIRS, v0=start, ncv=BASIS, maxiter=RESTARTS, tol=1e-4)
    except ArpackNoConvergence as stopped:
        values, vectors = stopped.eigenvalues, stopped.eigenvectors
    except (ArpackError, ValueError):
        return []
    grows = [k for k, c in enumerate(values) if np.isfinite(c) and abs(c) > SURELY and c.imag >= 0.0]
    return [(complex(mu * (values[k] + 1.0) / (values[k] - 1.0)), vectors[:n, k]) for k in grows]


def _refined(M, D, K, G, value: complex, shape: np.ndarray, look) -> Growth | None:
    """Return a motion by Newton's method for (s^2 M + s D + K) x = 0, v^H x = 1."""
    s, x = complex(value), shape.astype(complex) / np.linalg.norm(shape)
    left = None
    for _ in range(REFINED):
        look()
        try:
            bordered = _Bordered(_at(M, D, K, s).astype(complex), G)
        except RuntimeError:  # s is an eigenvalue to the last digit
            break
        y = bordered.solve(2.0 * s * (M @ x) + D @ x)
        right = x if left is None else left
        left = bordered.solve(2.0 * np.conj(s) * (M.T @ right) + D.T @ right, adjoint=True)
        along = np.vdot(x, y)
        if not np.all(np.isfinite(y)) or not np.all(np.isfinite(left)) or along == 0.0:
            return None
        s, x, left = s - 1.0 / along, y / np.linalg.norm(y), left / np.linalg.norm(left)
    if left is None or not np.isfinite(s) or not abs(s - value) < 0.1 * abs(value):
        return None
    return Growth(s, x, left)
