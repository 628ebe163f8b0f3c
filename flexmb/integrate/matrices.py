"""The matrices of the equations about a state: ``M a + h = f + G^T lam``, ``g = 0``, and their derivatives."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from scipy import sparse

from flexmb.math.block_pattern import stored
from flexmb.math.weights import weigh
from flexmb.system.mobility import still_dependent
from flexmb.system.program import constraint_acceleration, constraint_velocity, evaluate

__all__ = ["Equations", "Tangent", "adjoint", "equations_at", "stiffness_at", "tangent_at"]


@dataclass(frozen=True, kw_only=True, eq=False)
class Equations:
    """The equations of motion at a state, linear in accelerations and multipliers: ``M a - L lam = f``, ``G a = b``.

    Parameters
    ----------
    M : (nu, nu)
        Mass matrix; with geometric stiffness it is not symmetric, because that scales with accelerations.
    L : (nu, ng)
        Forces of unit multipliers: G^T, plus the stiffening by interface loads.
    G : (ng, nu)
        Gradient of the constraints.
    f : (nu,)
        All other forces, at zero acceleration and multipliers.
    b : (ng,)
        What G a must be.
    velocity : (ng,)
        Residual of the velocity constraints, G u + dg/dt.
    position : (ng,)
        Residual of the constraints, zero for those at velocity level.
    weight : (ng,)
        Of the multipliers in the norm that is least where equations are dependent (see System).
    least_inertia : (nu,)
        With which equations are judged (see System).
    dependent : (k,) of int
        Equations that depend on others, if only up to the digits of a mesh file: no motion has to obey them.
    """

    M: sparse.csr_matrix
    L: sparse.csr_matrix
    G: sparse.csr_matrix
    f: np.ndarray
    b: np.ndarray
    velocity: np.ndarray
    position: np.ndarray
    weight: np.ndarray
    least_inertia: np.ndarray
    dependent: np.ndarray = field(default_factory=lambda: np.zeros(0, int))

    def independent(self) -> Equations:
        """Return the equations without the dependent ones."""
        kept = np.setdiff1d(np.arange(self.G.shape[0]), self.dependent)
        vectors = {name: getattr(self, name)[kept] for name in ("b", "velocity", "position", "weight")}
        return replace(self, L=self.L[:, kept], G=self.G[kept], dependent=np.zeros(0, int), **vectors)


@dataclass(frozen=True, kw_only=True, eq=False)
class Tangent:
    """Derivatives of the residual at a state: mass, damping, stiffness (nu, nu), L (nu, ng) and G (ng, nu)."""

    M: sparse.csr_matrix
    D: sparse.csr_matrix
    K: sparse.csr_matrix
    L: sparse.csr_matrix
    G: sparse.csr_matrix


def _matrix(system, state, work, mass=0.0, damping=0.0, stiffness=0.0):
    weigh(work.weights, mass, damping, stiffness)
    program = system.program._replace(regularisation=np.zeros(system.ng), floor=np.zeros(len(system.program.floor)))
    evaluate(program, state, work)
    return stored(work.S, program.pattern).tocsr()


def equations_at(system, state, work, a: np.ndarray | None = None, lam: np.ndarray | None = None) -> Equations:
    """Return the equations of motion at a state; its accelerations and multipliers are ignored.

    Friction by joint reactions is not linear in the multipliers, nor are limits of what follows accelerations linear in
    these: the equations are tangent to them at `a` and `lam` (zero).
    """
    nu = system.nu
    rest = state._replace(a=np.zeros(nu) if a is None else a, lam=np.zeros(system.ng) if lam is None else lam)
    S = _matrix(system, rest, work, mass=1.0)
    drift, velocity = np.zeros(system.ng), np.zeros(system.ng)
    constraint_acceleration(work, rest.a, drift)
    constraint_velocity(work, state.u, velocity)
    position = np.where(system.program.equation_level == 0, work.equations["g"], 0.0)
    M, L, G = S[:nu, :nu], -S[:nu, nu:], S[nu:, :nu]
    dependent = np.zeros(0, int)
    if system.redundant:
        dependent = still_dependent(system, M, G)
    return Equations(
        M=M,
        L=L,
        G=G,
        f=M @ rest.a - work.residual - L @ rest.lam,
        b=G @ rest.a - drift,
        velocity=velocity,
        position=position,
        weight=system.multiplier_weights,
        least_inertia=system.least_inertia,
        dependent=dependent,
    )


def tangent_at(system, state, work) -> Tangent:
    """Return the derivatives of the residual with respect to accelerations, velocities and configuration at a state."""
    nu = system.nu
    M, D, K = (_matrix(system, state, work, **{name: 1.0}) for name in ("mass", "damping", "stiffness"))
    return Tangent(M=M[:nu, :nu], D=D[:nu, :nu], K=K[:nu, :nu], L=-K[:nu, nu:], G=K[nu:, :nu])


def stiffness_at(system, state, work) -> tuple[sparse.csr_matrix, sparse.csr_matrix, sparse.csr_matrix]:
    """Return K (nu, nu), L (nu, ng) and G (ng, nu) at a state; the residual is left in the workspace."""
    nu = system.nu
    K = _matrix(system, state, work, stiffness=1.0)
    return K[:nu, :nu], -K[:nu, nu:], K[nu:, :nu]


def adjoint(system, u: np.ndarray) -> sparse.csr_matrix:
    """Return the block diagonal ad(u) (nu, nu): du = dx' + ad(u) dx for frames, zero for plain vectors."""
    first = np.asarray(system.program.frames, int).reshape(-1, 2)[:, 1]
    entries: list[tuple[np.ndarray, np.ndarray, np.ndarray]] = []
    for vector, row, column in ((3, 0, 0), (0, 0, 3), (3, 3, 3)):  # w~ v~; 0 w~
        for k in range(3):
            i, j = (k + 1) % 3, (k + 2) % 3
            x = u[first + vector + k]
            entries += [(first + row + j, first + column + i, x), (first + row + i, first + column + j, -x)]
    rows, columns, values = (np.concatenate(parts) for parts in zip(*entries))
    return sparse.csr_matrix((values, (rows, columns)), shape=(system.nu, system.nu))
