"""`first_frequencies`: the lowest natural frequencies about the start, for models of any size.

Small models are linearised whole (see `linearize`). For large ones the undamped problem ``K x - L lam = w2 M x``, ``G x
= 0`` is solved by an Arnoldi iteration with sparse factors. Bodies on springs have hundreds of freedoms without
stiffness, to which the usual shift and invert converges first. The operator here is P K P M with ``P b = x`` of ``(K +
mu M) x - L lam = b``, ``G x = 0``: its eigenvalues are w2 / (w2 + mu)^2, largest where w2 = mu and zero for freedoms
without stiffness and for stiff ones, eq. (band-filter).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import ArpackError, ArpackNoConvergence, LinearOperator, eigs, splu

from flexmb.errors import ModelError
from flexmb.integrate.check import Report
from flexmb.integrate.impulsive import refuse_crowds, refuse_impulses
from flexmb.integrate.linear.driven import driven_accelerations
from flexmb.integrate.linear.linearize import linearize
from flexmb.integrate.matrices import adjoint, tangent_at
from flexmb.math.tables import State
from flexmb.model.model import Model
from flexmb.system import assemble, assemble_as_drawn
from flexmb.system.accelerations import accelerations, settled_accelerations
from flexmb.system.damped_accelerations import unsolved
from flexmb.system.given_state import given_state
from flexmb.system.holds import refuse_holds
from flexmb.system.mobility import mass_metric
from flexmb.system.system import System

__all__ = ["FirstFrequencies", "first_frequencies"]

DENSE = 300
"""Velocities of a model up to which all modes are computed."""
BELOW = 30.0
"""The filter is set so many times below the lowest frequency (squared) that is known."""
STEPS = 24
"""Of the iteration that looks for the lowest frequency."""
DEEP = 1e-7
"""How far below the lowest w2 in sight the last look goes."""
ROUNDED = 100.0 * np.finfo(float).eps
"""Of the largest stiffness: less is zero but for the last digits."""
SEARCHES, RESTARTS = 12, 40
NOTHING = 1e-8
"""Eigenvalues of the filter, times mu, that are rounding."""
UNSEEN = 1e-7
"""Frequencies below this share of the highest are zero but for the last digits of an eigenvalue, sqrt(1e-16)."""
SAME = 1e-6
"""Relative difference of frequencies that count as one: equal parts on equal springs."""


@dataclass(frozen=True, kw_only=True, eq=False)
class FirstFrequencies:
    """The lowest natural frequencies of a model about its start.

    Parameters
    ----------
    frequencies : (k,), Hz
        Ascending; of a large model the different ones, without damping.
    free : int or None
        Number of modes without oscillation (a free crank, a rigid body in space, an overdamped mode); None of a large
        model, where they are not counted.
    more : bool
        There are more than these.
    """

    frequencies: np.ndarray
    free: int | None
    more: bool

    def __str__(self) -> str:
        listed = ", ".join(f"{f:.4g}" for f in self.frequencies) + (", ..." if self.more else "")
        texts = [f"{listed} Hz" if listed else "none found" if self.free is None else ""]
        if self.free is None and listed:
            texts[0] += " (without damping; equal ones once)"
        texts.append(f"{self.free} without oscillation" if self.free else "")
        return "; ".join(text for text in texts if text)


def first_frequencies(model: Model, count: int = 6, *, about: Any = None) -> FirstFrequencies:
    """Return the lowest natural frequencies about the assembled start, or about another state.

    Parameters
    ----------
    model : Model
        A large one (more than 300 velocities) is taken at rest, its drives at their positions of the start.
    count : int
    about : Solution, Instant or Report, optional
        A state of this model, for example its equilibrium (`statics`); default: the start as described. The report of
        `check` stands for that start too; that of a large model is then not assembled again.

    Raises
    ------
    CompileError
        If the mechanism cannot be assembled.
    ModelError
        If `about` is no state of this model.

    Examples
    --------
    >>> print(first_frequencies(model))                                              # doctest: +SKIP
    1.592, 10.07, 28.33, ... Hz; 2 without oscillation
    """
    refuse_impulses(model, "first_frequencies")
    refuse_crowds(model, "first_frequencies")
    system, state = _assembled_about(model, about)
    refuse_holds(system, "first_frequencies")
    if system.nu <= DENSE:
        found = linearize(model, None if isinstance(about, Report) else about).frequencies
        positive = found[found > UNSEEN * found.max(initial=0.0)]
        return FirstFrequencies(
            frequencies=positive[:count], free=len(found) - len(positive), more=len(positive) > count
        )
    work = system.workspace()
    rest = system.state(state.t, state.q, np.zeros(system.nu))
    right = np.zeros(system.nu + system.ng)
    accelerations(system.program, rest, work, right, 12 if system.redundant else 2)
    if not settled_accelerations(system, rest, work, right):
        raise unsolved(system, "Accelerations")
    driven = driven_accelerations(system, rest, work)
    rest.a[:], rest.lam[:] = rest.a - driven[0], rest.lam - driven[1]
    tangent = tangent_at(system, rest, work)
    scale = sparse.diags(1.0 / np.sqrt(np.maximum(mass_metric(tangent.M), system.least_inertia)))
    kept = np.setdiff1d(np.arange(system.ng), system.redundant)
    K = (scale @ (tangent.K + tangent.M @ adjoint(system, rest.a)) @ scale).tocsr()
    M, L, G = (scale @ tangent.M @ scale).tocsr(), (scale @ tangent.L[:, kept]).tocsr(), (tangent.G[kept] @ scale)
    found = np.sqrt(_squares(K, M, L, G.tocsr(), 2 * count + 8)) / (2.0 * np.pi)
    return FirstFrequencies(frequencies=found[:count], free=None, more=len(found) > count)


def _assembled_about(model: Model, about: Any) -> tuple[System, State]:
    """Return the system of a model, and the state of it that is asked about."""
    if isinstance(about, Report):
        if about.model is not model:
            raise ModelError(
                "first_frequencies",
                found=f"the report of another model, named '{about.model.name}'",
                expected=f"that of this one, named '{model.name}'; a changed copy is another",
                remedy="Give about=flexmb.check(model), or leave about out",
            )
        return about.assembled or assemble_as_drawn(model)
    if about is None:
        return assemble_as_drawn(model)
    system = assemble(model)[0]
    return system, given_state(about, system, "first_frequencies")


def _squares(K, M, L, G, count: int) -> np.ndarray:
    """Return the lowest different positive w2, 1/s2, ascending.

    The filter is moved down with the lowest w2 that a few steps of the iteration find, until it stays. Then one search
    far below shows whether stiff parts have hidden a soft one.
    """
    diagonal = K.diagonal()
    positive = diagonal[diagonal > 0.0]
    if not len(positive):
        return positive
    mu, floor = float(np.exp(np.mean(np.log(positive)))), ROUNDED * float(positive.max())
    settled: list[_Filter] = []
    lowest, deep = np.inf, False
    for _ in range(SEARCHES):
        near = _Filter(K, M, L, G, mu, floor)
        found = near.glimpsed()
        if not len(found) or (deep and found[0] > 0.9 * lowest):
            break
        lowest, deep = found[0], bool(found[0] > 0.1 * BELOW * mu)
        settled += [near] if deep else []
        mu = max(DEEP * lowest, 100.0 * floor) if deep else lowest / BELOW
    squares = np.sort(np.concatenate([np.zeros(0), *(near.converged(count) for near in settled)]))
    return squares[np.diff(squares, prepend=-1.0) > 2.0 * SAME * squares]


class _Filter:
    """The operator of the module's docstring for one mu, and the w2 that are found with it."""

    def __init__(self, K, M, L, G, mu: float, floor: float):
        self.K, self.M, self.mu, self.floor = K, M, mu, floor
        self.nothing = np.zeros(G.shape[0])
        shifted = (K + mu * M).tocsc()
        self.factor = splu(sparse.block_array([[shifted, -L], [G, None]], format="csc") if G.shape[0] else shifted)
        self.start = self(np.random.default_rng(0).normal(size=K.shape[0]))

    def _inverse(self, b: np.ndarray) -> np.ndarray:
        return self.factor.solve(np.concatenate([b, self.nothing]))[: len(b)]

    def __call__(self, x: np.ndarray) -> np.ndarray:
        return self._inverse(self.K @ self._inverse(self.M @ np.ravel(x)))

    def glimpsed(self) -> np.ndarray:
        """Return w2 of the Ritz vectors of a few steps, ascending: none is far below the lowest there is."""
        V, H = [self.start / (np.linalg.norm(self.start) or 1.0)], np.zeros((STEPS + 1, STEPS))
        for k in range(STEPS):
            x = self(V[k])
            for _ in range(2):  # once more, for the last digits
                share = np.array([v @ x for v in V])
                H[: k + 1, k] += share
                x = x - np.array(V).T @ share
            H[k + 1, k] = np.linalg.norm(x)
            if H[k + 1, k] <= 1e-10 * np.abs(H).max():
                H = H[: k + 1, : k + 1]
                break
            V.append(x / H[k + 1, k])
        size = H.shape[1]
        values, vectors = np.linalg.eig(H[:size, :size])
        return self._squares(values, np.array(V[:size]).T @ vectors)

    def converged(self, count: int) -> np.ndarray:
        """Return the w2 whose values of the filter are largest, ascending."""
        n = self.K.shape[0]
        operator = LinearOperator((n, n), self, dtype=float)
        try:
            values, vectors = eigs(operator, min(count, n - 2), v0=self.start, tol=1e-8, maxiter=RESTARTS)
        except ArpackNoConvergence as error:
            values, vectors = error.eigenvalues, error.eigenvectors
        except ArpackError:
            return np.zeros(0)
        return self._squares(values, vectors)

    def _squares(self, values: np.ndarray, vectors: np.ndarray) -> np.ndarray:
        found = []
        for value, x in zip(values, vectors.T):
            if abs(value) * self.mu >= NOTHING:
                y = self._inverse(self.M @ x.real) + 1j * self._inverse(self.M @ x.imag)  # x / (w2 + mu)
                found.append(float((np.vdot(x, x) / np.vdot(x, y)).real) - self.mu)
        return np.sort([w2 for w2 in found if w2 > max(NOTHING * self.mu, self.floor)])
