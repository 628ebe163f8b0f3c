"""Formulations of the same equations ``M a - L lam = f``, ``G a = b``: each is a small object with one method.

Without geometric stiffness L = G^T; with it, the interface loads stiffen reduced bodies and L differs from G^T. All
formulations below allow for that. Theory: formulations.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse
from scipy.linalg import lstsq, null_space, solve, svd
from scipy.sparse.linalg import splu

from flexmb.errors import CompileError
from flexmb.integrate.matrices import Equations

__all__ = ["Augmented", "Baumgarte", "NullSpace", "UdwadiaPhohomsiri"]

RANK = 1e-10
"""Singular values below this, relative to the largest, count as zero."""


def _least(A: np.ndarray, b: np.ndarray) -> np.ndarray:
    return lstsq(A, b, cond=RANK)[0] if A.size else np.zeros(A.shape[1])


def _balanced(equations: Equations) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return dense M, L, G, f and the scale of the velocities, which makes lengths and angles comparable."""
    M = equations.M.toarray()
    diagonal = np.abs(np.diag(M))
    scale = 1.0 / np.sqrt(np.where(diagonal > 0.0, diagonal, np.max(diagonal, initial=1.0)))
    return (scale[:, None] * M * scale, scale[:, None] * equations.L.toarray(), equations.G.toarray() * scale,
            scale * equations.f, scale)


@dataclass(frozen=True)
class Augmented:
    """Accelerations and multipliers together from one sparse system (the form that the integrators use).

    Dependent equations: the solution of least norm, by a dense singular value decomposition.
    """

    def solve(self, e: Equations) -> tuple[np.ndarray, np.ndarray]:
        """Return accelerations (nu,) and multipliers (ng,)."""
        nu, ng = e.M.shape[0], e.G.shape[0]
        if nu + ng <= 200:
            M, L, G, f, scale = _balanced(e)
            matrix = np.block([[M, -L], [G, np.zeros((ng, ng))]])
            x = _least(matrix, np.concatenate([f, e.b]))
            return scale * x[:nu], x[nu:]
        matrix = sparse.bmat([[e.M, -e.L], [e.G, None]], format="csc")
        try:
            x = splu(matrix).solve(np.concatenate([e.f, e.b]))
        except RuntimeError as error:
            raise CompileError("Augmented", found="the matrix of the equations of motion is singular",
                               expected="independent equations and inertia in every freedom",
                               remedy="Use UdwadiaPhohomsiri, or look at flexmb.check(model)") from error
        return x[:nu], x[nu:]


@dataclass(frozen=True)
class NullSpace:
    """Kane's equations with an orthogonal complement: ``P^T M N z' = P^T (f - M a0)``.

    N spans the null space of G, P that of L^T (the same without geometric stiffness); a0 is a particular solution of
    G a0 = b. The multipliers follow by least squares. Source: Wang & Huston 1988.
    """

    def solve(self, e: Equations) -> tuple[np.ndarray, np.ndarray]:
        """Return accelerations (nu,) and multipliers (ng,)."""
        M, L, G, f, scale = _balanced(e)
        N = null_space(G, rcond=RANK) if len(G) else np.eye(len(M))
        P = null_space(L.T, rcond=RANK) if len(G) else N
        a = _least(G, e.b)
        if N.shape[1]:
            a = a + N @ solve(P.T @ M @ N, P.T @ (f - M @ a))
        return scale * a, _least(L, M @ a - f)


@dataclass(frozen=True)
class UdwadiaPhohomsiri:
    """The closed form for singular mass matrices and dependent constraints.

    ``a = [(I - L L^+) M; G]^+ [(I - L L^+) f; b]``.

    Source: Udwadia & Phohomsiri 2006, eq. 3.13; unique if [M; G] has full column rank, which is checked.
    """

    def solve(self, e: Equations) -> tuple[np.ndarray, np.ndarray]:
        """Return accelerations (nu,) and multipliers (ng,)."""
        M, L, G, f, scale = _balanced(e)
        if len(G):
            U, s, _ = svd(L, full_matrices=False)
            U = U[:, s > RANK * max(s[0], 1e-300)]
        else:
            U = np.zeros((len(M), 0))
        project = np.eye(len(M)) - U @ U.T
        stacked = np.vstack([project @ M, G])
        if np.linalg.matrix_rank(np.vstack([M, G]), tol=RANK * np.abs(M).max()) < len(M):
            raise CompileError("UdwadiaPhohomsiri", found="[M; G] does not have full column rank",
                               expected="every freedom to have inertia or a constraint",
                               remedy="Give the free motion inertia, or forbid it by a joint")
        a = _least(stacked, np.concatenate([project @ f, e.b]))
        return scale * a, _least(L, M @ a - f)


@dataclass(frozen=True)
class Baumgarte:
    """Stabilised right-hand side for index-1 forms: ``G a = b - 2 alpha g' - beta^2 g`` around another formulation.

    Parameters
    ----------
    formulation : Augmented, NullSpace or UdwadiaPhohomsiri
    alpha, beta : float, 1/s
        Equal values give critical damping of the constraint errors.

    Source: Baumgarte 1972.
    """

    formulation: Augmented | NullSpace | UdwadiaPhohomsiri = Augmented()
    alpha: float = 10.0
    beta: float = 10.0

    def solve(self, e: Equations, g: np.ndarray | None = None) -> tuple[np.ndarray, np.ndarray]:
        """Return accelerations (nu,) and multipliers (ng,); `g` (ng,) is the residual of the positions."""
        position = np.zeros(len(e.b)) if g is None else g
        b = e.b - 2.0 * self.alpha * e.velocity - self.beta**2 * position
        return self.formulation.solve(Equations(M=e.M, L=e.L, G=e.G, f=e.f, b=b, velocity=e.velocity))
