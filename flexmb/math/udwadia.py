"""`solve`: accelerations of M a = Q + constraint forces, A a = b, for any consistent constraints and singular masses.

Source: Udwadia & Phohomsiri 2006, eq. 3.13: ``a = [(I - A^+ A) M; A]^+ [Q; b]``, unique exactly if [M; A] has full
column rank. Solved in its stable form: with an orthonormal basis (V1, V2) of the row space of A and its complement,

    a = A^+ b + V2 z,   (V2^T M V2) z = V2^T (Q + C - M A^+ b),

which is the same where M is symmetric without negative eigenvalues: V2^T M V2 is regular exactly under that condition.
No product of pseudo-inverses is formed, whose condition would be the square of M's.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.linalg import eigh, svd

from flexmb.errors import FlexmbError

__all__ = ["Accelerated", "solve"]

RANK = 1e-10
"""Singular values below this, relative to the largest, are zero."""
CONSISTENT = 1e-8
"""Part of b outside the range of A, relative, from which constraints contradict each other."""
MISFIT = 100.0
"""The same, in multiples of the part of dependent rows of A that lies outside the span of the others."""
ROUNDING = 1e-13
"""The same, relative to the accelerations without constraints: digits that the terms of b have lost."""
SYMMETRIC = 1e-10


@dataclass(frozen=True, kw_only=True, eq=False)
class Accelerated:
    """What `solve` found.

    Parameters
    ----------
    a : (n,)
        Accelerations.
    force : (n,)
        Force of the constraints, M a - Q: the ideal one, and what C gives.
    ideal : (n,)
        The ideal one, in the row space of A: M a - Q - C.
    multipliers : (m,)
        Those of least norm with A^T multipliers = ideal force.
    rank : int
        Rank of A: so many constraints are independent.
    rank_of_both : int
        Rank of [M; A]: n, or the accelerations would not be unique.
    free : (n, n - rank)
        Orthonormal basis of the motions that the constraints leave, in the scaled coordinates given by `weights`.
    """

    a: np.ndarray
    force: np.ndarray
    ideal: np.ndarray
    multipliers: np.ndarray
    rank: int
    rank_of_both: int
    free: np.ndarray

    def __repr__(self):
        n, m = len(self.a), len(self.multipliers)
        return f"Accelerated({n} coordinates, rank of A {self.rank} of {m}, rank of [M; A] {self.rank_of_both})"


def _array(value: Any, shape: tuple[int, ...], name: str) -> np.ndarray:
    try:
        array = np.asarray(value.toarray() if hasattr(value, "toarray") else value, float)
    except (TypeError, ValueError):
        array = np.full(1, np.nan)
    numbers = bool(np.all(np.isfinite(array)))
    if array.shape != shape or not numbers:
        raise FlexmbError(
            "udwadia.solve",
            found=f"{name} of shape {array.shape}" + ("" if numbers else ", with entries that are no numbers"),
            expected=f"finite numbers of shape {shape}",
            remedy=f"Correct {name}",
        )
    return array


def solve(M, Q, A, b, weights=None, *, C=None, rank: int | None = None) -> Accelerated:
    """Return the accelerations of a constrained system.

    Parameters
    ----------
    M : (n, n), array or sparse
        Mass matrix, symmetric, without negative eigenvalues; it may be singular.
    Q : (n,)
        Given forces.
    A, b : (m, n), (m,)
        Constraints A a = b at the level of accelerations: any number, dependent ones too.
    weights : (n,), optional
        Mass-like numbers that make coordinates comparable where ranks are decided, w = 1/(length scale)^2; by default
        the diagonal of M.
    C : (n,), optional
        Forces of constraints that are not ideal: their virtual work is C^T v.
    rank : int, optional
        How many constraints are independent, where it is known: the others depend on them but for the digits of their
        data. By default singular values below 1e-10 of the largest count as zero.

    Raises
    ------
    FlexmbError
        Shapes do not fit, M is not symmetric or has a negative eigenvalue, constraints contradict each other, or the
        accelerations are not unique.

    Examples
    --------
    >>> found = fmb.udwadia.solve([[2.0, 0], [0, 0]], [3.0, 0], [[1.0, -1.0]], [0.5])   # x' - y' = 0.5 t, y has no mass
    >>> found.a.round(12).tolist(), found.multipliers.round(12).tolist()
    ([1.5, 1.0], [0.0])
    """
    Q = np.asarray(Q, float)
    n = Q.shape[0] if Q.ndim == 1 else -1
    m = np.shape(b)[0] if np.ndim(b) == 1 else -1
    Q, M, b = _array(Q, (n,), "Q"), _array(M, (n, n), "M"), _array(b, (m,), "b")
    A = _array(A, (m, n), "A") if m else np.zeros((0, n))
    C = np.zeros(n) if C is None else _array(C, (n,), "C")
    scale = _scale(M, weights, n)
    mass, rows = scale[:, None] * M * scale, A * scale
    norms = np.linalg.norm(rows, axis=1)
    rows = rows / np.where(norms > 0.0, norms, 1.0)[:, None]
    right = b / np.where(norms > 0.0, norms, 1.0)
    _require_mass(mass)
    U, s, Vt = svd(rows) if m else (np.zeros((0, 0)), np.zeros(0), np.eye(n))
    load = scale * (Q + C)
    by_size = int(np.sum(s > RANK * np.max(s, initial=0.0)))
    rank = by_size if rank is None else min(_count(rank, min(m, n)), by_size)
    digits = float(s[rank] / s[0]) if rank < by_size else 0.0
    U, V1, V2 = U[:, :rank], Vt[:rank].T, Vt[rank:].T
    left = right - U @ (U.T @ right)
    size, free = np.max(np.abs(right), initial=0.0), _freely(mass, load, rows)
    allowed = max(CONSISTENT * size, ROUNDING * free, MISFIT * digits * max(size, free), np.finfo(float).tiny)
    if np.any(np.abs(left) > allowed):
        raise _contradiction(b, left * np.where(norms > 0.0, norms, 1.0), int(np.argmax(np.abs(left))), rank)
    own = V1 @ ((U.T @ right) / s[:rank])
    own += V1 @ ((U.T @ (right - rows @ own)) / s[:rank])
    both = _rank_of_both(mass, V1, V2)
    a = own
    if V2.shape[1]:
        reduced = V2.T @ mass @ V2
        values, vectors = eigh(0.5 * (reduced + reduced.T))
        a = own + V2 @ (vectors @ ((vectors.T @ (V2.T @ (load - mass @ own))) / values))
    force = (mass @ a - scale * Q) / scale
    ideal = mass @ a - load
    multipliers = U @ ((V1.T @ ideal) / s[:rank]) / np.where(norms > 0.0, norms, 1.0)
    return Accelerated(
        a=scale * a, force=force, ideal=ideal / scale, multipliers=multipliers, rank=rank, rank_of_both=both, free=V2
    )


def _contradiction(b: np.ndarray, missed: np.ndarray, k: int, rank: int) -> FlexmbError:
    """Return the error of constraints that contradict each other, of which row k misses most."""
    return FlexmbError(
        "udwadia.solve",
        found=f"A a = b has no solution: row {k} misses {b[k]:.6g} by {missed[k]:.3g}; A has rank {rank}",
        expected="constraints that can be satisfied together",
        remedy="Look for rows of A that depend on each other with values of b that do not",
    )


def _count(rank: Any, most: int) -> int:
    """Return a given rank; FlexmbError if it is none."""
    if not isinstance(rank, (int, np.integer)) or isinstance(rank, bool) or not 0 <= rank <= most:
        raise FlexmbError(
            "udwadia.solve",
            found=f"rank = {rank!r}",
            expected=f"a whole number from 0 to {most}, the smaller side of A",
            remedy="Leave it out: singular values tell it",
        )
    return int(rank)


def _freely(mass: np.ndarray, load: np.ndarray, rows: np.ndarray) -> float:
    """Return the size of A a without constraints: what the terms of b are rounded to, however small their sum is."""
    if not rows.size:
        return 0.0
    values, vectors = eigh(0.5 * (mass + mass.T))
    moves = values > RANK * max(values[-1], 0.0)
    free = vectors[:, moves] @ ((vectors[:, moves].T @ load) / values[moves])
    return float(np.max(np.abs(rows) @ np.abs(free)))


def _scale(M: np.ndarray, weights: Any, n: int) -> np.ndarray:
    """Return what makes coordinates comparable, (n,): one over the root of the weights."""
    if weights is None:
        diagonal = np.abs(np.diag(M))
        some = diagonal > 0.0
        middle = np.exp(np.mean(np.log(diagonal[some]))) if np.any(some) else 1.0
        return 1.0 / np.sqrt(np.where(some, diagonal, middle))
    weights = _array(weights, (n,), "weights")
    if np.any(weights <= 0.0):
        raise FlexmbError(
            "udwadia.solve",
            found=f"weights[{int(np.argmin(weights))}] = {weights.min():.3g}",
            expected="weights > 0",
            remedy="Give masses, or leave weights away for the diagonal of M",
        )
    return 1.0 / np.sqrt(weights)


def _require_mass(mass: np.ndarray) -> None:
    """Raise FlexmbError unless the mass matrix is symmetric, without negative eigenvalues."""
    size = np.max(np.abs(mass), initial=0.0)
    skew = np.max(np.abs(mass - mass.T), initial=0.0)
    lowest = float(eigh(0.5 * (mass + mass.T), eigvals_only=True)[0]) if len(mass) else 0.0
    if skew > SYMMETRIC * size or lowest < -SYMMETRIC * size:
        what = (
            f"differs from its transpose by {skew / size:.2g}"
            if skew > SYMMETRIC * size
            else "has a negative eigenvalue"
        )
        raise FlexmbError(
            "udwadia.solve",
            found=f"M {what} (scaled to a unit diagonal: lowest eigenvalue {lowest:.3g})",
            expected="a symmetric matrix without negative eigenvalues",
            remedy="Put what is not inertia into Q",
        )


def _rank_of_both(mass: np.ndarray, V1: np.ndarray, V2: np.ndarray) -> int:
    """Return the rank of [M; A]; FlexmbError if accelerations are not unique."""
    if not V2.shape[1]:
        return len(mass)
    s, Vt = svd(mass @ V2)[1:]
    loose = s <= RANK * max(np.max(s, initial=0.0), np.max(np.abs(mass), initial=0.0))
    if not np.any(loose) and len(s) == V2.shape[1]:
        return len(mass)
    motion = V2 @ Vt[int(np.flatnonzero(loose)[0])]
    k = int(np.argmax(np.abs(motion)))
    raise FlexmbError(
        "udwadia.solve",
        found=f"rank [M; A] = {len(mass) - int(np.sum(loose))} of {len(mass)}: a motion, most of coordinate {k}, has "
        "neither inertia nor a constraint",
        expected="[M; A] of full column rank, the condition for unique accelerations",
        remedy=f"Give coordinate {k} inertia, or a constraint (for Euler parameters p . p'' = -p' . p')",
    )
