"""Formulations of the same equations ``M a - L lam = f``, ``G a = b``: each is a small object with the same method,
``.accelerate(system, state, work) -> (a, lam)``.

Without geometric stiffness L = G^T; with it, the interface loads stiffen reduced bodies and L differs from G^T. All
formulations below allow for that. Theory: formulations.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
from scipy import sparse
from scipy.linalg import null_space, orth, solve, svd
from scipy.sparse.linalg import splu

from flexmb.errors import CompileError, ModelError
from flexmb.integrate.matrices import Equations, equations_at
from flexmb.model.described import Described, is_number
from flexmb.system.accelerations import solved_accelerations
from flexmb.system.damped_accelerations import largest, load_sizes, unsolved
from flexmb.system.mobility import ROUNDING, equation_scale

__all__ = ["Augmented", "Baumgarte", "NullSpace", "UdwadiaPhohomsiri"]

FASTEST = 1e9
"""1/s, largest rate of a stabilisation: nothing faster than that is integrated."""
RANK = 1e-10
"""Singular values below this, relative to the largest, count as zero."""
ROUNDED = 1e-9
"""Change of accelerations and multipliers, relative to them or to the loads, that may go on for ever as rounding."""
UNLOADED = 3
"""Iterations without rest, after which it is looked whether what changes is rounding."""
TURNS = 40
"""Iterations of friction by joint reactions and of forces that follow accelerations, and refinements, at most."""
HARDLY = 1e-2
"""Inertia, relative to the least with which equations are judged, of a body that hardly resists."""
SOFT = 1e-9
"""Compliance of equations in large models, relative to G M^-1 G^T."""
EXACT = 1e-12
"""Change of the multipliers, relative, at which they end; of all unknowns in the last correction of a factorisation."""
FITS = 1e-4
"""Part of the force of a dependent equation that others may leave: geometric stiffness can make it larger."""
DENSE = 200
"""Number of unknowns up to which least squares by singular values are affordable."""


def _least(A: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return the x of least norm for which A x is closest to b, refined once with the rounding that it leaves.

    Columns of b have one factorisation: x has a column for each.
    """
    if not A.size:
        return np.zeros(A.shape[1:] + b.shape[1:])
    U, s, Vt = svd(A, full_matrices=False)
    held = s > RANK * s[0]
    U, V = U[:, held], Vt[held].T / s[held]
    x = V @ (U.T @ b)
    return x + V @ (U.T @ (b - A @ x))


@dataclass(frozen=True, kw_only=True, eq=False)
class _Balanced:
    """Dense equations in velocities that make lengths and angles comparable, each constraint with gradients of size 1.

    Without that, equations between rotations of small bodies are so much larger than those between their places that
    these look dependent: the units of the model would tell which. What is rounding beside the other gradients stays so.
    """

    M: np.ndarray
    L: np.ndarray
    G: np.ndarray
    f: np.ndarray
    b: np.ndarray
    scale: np.ndarray
    moves: np.ndarray

    @classmethod
    def of(cls, equations: Equations) -> _Balanced:
        """Return equations in balance; multipliers keep their units."""
        M = equations.M.toarray()
        diagonal = np.abs(np.diag(M))
        scale = 1.0 / np.sqrt(np.where(diagonal > 0.0, diagonal, np.max(diagonal, initial=1.0)))
        gradients = equations.G.toarray()
        largest = np.abs(gradients).max(axis=1, initial=0.0)
        moves = largest > ROUNDING * largest.max(initial=0.0)
        G = gradients * scale
        rows = _inverse_sizes(G, moves)
        return cls(
            M=scale[:, None] * M * scale,
            L=scale[:, None] * equations.L.toarray(),
            G=rows[:, None] * G,
            f=scale * equations.f,
            b=rows * equations.b,
            scale=scale,
            moves=moves,
        )

    def directions(self) -> np.ndarray:
        """Return the forces of the multipliers (nu, ng), each of size 1."""
        return self.L * _inverse_sizes(self.L.T, self.moves)


def _inverse_sizes(rows: np.ndarray, moves: np.ndarray) -> np.ndarray:
    """Return 1 / norm of each row of equations that move something, and of the others 1 / the largest norm."""
    sizes = np.linalg.norm(rows, axis=1)
    return 1.0 / np.where(moves & (sizes > 0.0), sizes, np.max(sizes, initial=0.0) or 1.0)


def _multipliers(own: _Balanced, load: np.ndarray, weight: np.ndarray) -> np.ndarray:
    """Return the multipliers of least norm, with weights (ng,), with L lam = load.

    Which forces depend on each other is found among directions of size 1: in other units one may be a million times
    as large as another.
    """
    sizes, of_lam = _inverse_sizes(own.L.T, own.moves), 1.0 / np.sqrt(weight)
    directions = own.directions()
    found = sizes * _least(directions, load) / of_lam
    stress = null_space(directions, rcond=RANK) * (sizes / of_lam)[:, None] if len(sizes) else np.zeros((0, 0))
    return of_lam * (found - stress @ _least(stress, found))


def _without_squares(own: _Balanced, e: Equations) -> tuple[np.ndarray, np.ndarray]:
    """Return accelerations and multipliers with orthonormal equations, where a body hardly resists.

    The matrix of `Augmented` has the square of what gradients differ by, 1e-5 where a light part closes a loop. Next to
    a dead centre it is the better one: orthonormal equations hold a mechanism there that should pass.
    """
    nu, ng = e.M.shape[0], e.G.shape[0]
    U, s, Vt = np.linalg.svd(own.G, full_matrices=False)
    held = s > RANK * np.max(s, initial=0.0)
    forces = orth(own.directions(), rcond=RANK) if ng else np.zeros((nu, 0))
    matrix = np.block([[own.M, -forces], [Vt[held], np.zeros((held.sum(), forces.shape[1]))]])
    a = _least(matrix, np.concatenate([own.f, U[:, held].T @ own.b / s[held]]))[:nu]
    return own.scale * a, _multipliers(own, own.M @ a - own.f, e.weight)


def _softened(e: Equations) -> tuple[np.ndarray, np.ndarray]:
    """Return accelerations and multipliers of large models in any position, dependent equations made soft.

    The part of b that no motion can satisfy would give multipliers r lam = misfit. It is removed, and the rest refined.
    Multipliers contain no self-stress: they have least norm.
    """
    nu = e.M.shape[0]
    soft = SOFT * np.max(equation_scale(e.M, e.G, e.least_inertia)) * e.weight
    matrix = sparse.bmat([[e.M, -e.L], [e.G, sparse.diags(soft)]], format="csc")
    try:
        factor = splu(matrix)
    except RuntimeError as error:
        raise CompileError(
            "Augmented",
            found="the matrix of the equations of motion is singular",
            expected="inertia in every freedom that joints leave",
            remedy="Use UdwadiaPhohomsiri, or look at flexmb.check(model)",
        ) from error
    x, change = np.zeros(matrix.shape[0]), np.zeros(matrix.shape[0])
    for _ in range(TURNS):
        left = np.concatenate([e.f - e.M @ x[:nu] + e.L @ x[nu:], e.b - e.G @ x[:nu]])
        change[:] = factor.solve(left)
        left[nu:] -= soft * change[nu:]
        change[:] = factor.solve(left)
        x += change
        if np.max(np.abs(change)) <= EXACT * np.max(np.abs(x), initial=1.0):
            break
    return x[:nu], x[nu:]


def _shared(e: Equations, lam: np.ndarray, a: np.ndarray) -> np.ndarray:
    """Return the multipliers (ng,) of least norm with the forces of the independent equations, `lam`.

    Multipliers (-y, 1) with L (-y, 1) = 0 are states of self-stress: what `lam` contains of them is removed.
    """
    if sum(e.L.shape) > DENSE:
        return _softened(replace(e, b=e.G @ a))[1]
    of_lam = 1.0 / np.sqrt(e.weight)
    kept = np.setdiff1d(np.arange(len(of_lam)), e.dependent)
    found = np.zeros(len(of_lam))
    found[kept] = lam / of_lam[kept]
    L = e.L.toarray() * of_lam
    own = L[:, e.dependent]
    y = _least(L[:, kept], own)
    fits = np.linalg.norm(own - L[:, kept] @ y, axis=0) <= FITS * np.linalg.norm(own, axis=0)
    stress = np.zeros((len(of_lam), len(e.dependent)))
    stress[kept] = np.where(fits, -y, 0.0)
    stress[e.dependent, np.arange(len(e.dependent))] = fits
    return of_lam * (found - stress @ _least(stress, found))


class _Formulation(metaclass=Described):
    """What the formulations share: they solve linear equations, which friction by reactions makes tangent ones."""

    compiled: ClassVar[bool] = False
    closed: ClassVar[bool] = False
    unknowns: ClassVar[None] = None

    def solve(self, e: Equations) -> tuple[np.ndarray, np.ndarray]:
        """Return accelerations (nu,) and multipliers (ng,) of linear equations.

        Equations that depend on others are left out: deviations of 1e-8 rad would lock a mechanism. Then the
        multipliers of all equations share the forces, with least norm.
        """
        if not len(e.dependent):
            return self._solve(e)
        a, lam = self._solve(e.independent())
        return a, _shared(e, lam, a)

    def _solve(self, e: Equations) -> tuple[np.ndarray, np.ndarray]:
        """Return accelerations (nu,) and multipliers (ng,) of linear equations; dependent ones are so to all digits."""
        raise TypeError(f"{type(self).__name__} solves no equations")

    def accelerate(self, system, state, work) -> tuple[np.ndarray, np.ndarray]:
        """Return accelerations (nu,) and multipliers (ng,) at a state; its own are ignored."""
        found = self.solve(equations_at(system, state, work))
        if not (system.implicit or any(force.reads_reactions for force in system.model.forces)):
            return found
        settled = self._settled(system, state, work, found)
        if settled is None:
            near = solved_accelerations(system, state, work)
            settled = None if near is None else self._settled(system, state, work, near)
        if settled is None:
            raise unsolved(system, type(self).__name__)
        return settled

    def _settled(self, system, state, work, found) -> tuple[np.ndarray, np.ndarray] | None:
        """Return what the equations that are tangent to accelerations and multipliers lead to, again and again; None
        if that does not come to rest."""
        a, lam = found
        of_a, of_lam = 0.0, 0.0
        for turn in range(TURNS):
            if turn == UNLOADED:  # joints that carry nothing leave rounding of the loads
                of_a, of_lam = load_sizes(system, state, work)
            before = a, lam
            a, lam = self.solve(equations_at(system, state, work, *before))
            moved = largest(a - before[0]) if system.implicit else 0.0
            change = largest(lam - before[1])
            rest = EXACT if turn < TURNS - 1 else ROUNDED
            if moved <= rest * max(largest(a), of_a) and change <= rest * max(largest(lam), of_lam):
                return a, lam
        return None


@dataclass(frozen=True)
class Augmented(_Formulation):
    """Accelerations and multipliers together from one sparse system (the form that the integrators use).

    They come from the compiled factorisation of the integrators. Where it does not converge (dependent equations that
    the assembled position did not show), the solution of least norm is taken: for small models by a dense singular
    value decomposition, for others by a factorisation in which dependent equations are soft.
    """

    compiled: ClassVar[bool] = True

    def accelerate(self, system, state, work) -> tuple[np.ndarray, np.ndarray]:
        """Return accelerations (nu,) and multipliers (ng,) at a state; its own are ignored."""
        found = solved_accelerations(system, state, work)
        return super().accelerate(system, state, work) if found is None else found

    def _solve(self, e: Equations) -> tuple[np.ndarray, np.ndarray]:
        """Return accelerations (nu,) and multipliers (ng,)."""
        nu, ng = e.M.shape[0], e.G.shape[0]
        if nu + ng <= DENSE:
            own = _Balanced.of(e)
            if np.any(e.M.diagonal() < HARDLY * e.least_inertia):
                return _without_squares(own, e)
            of_lam = 1.0 / np.sqrt(e.weight)
            matrix = np.block([[own.M, -own.L * of_lam], [own.G, np.zeros((ng, ng))]])
            x = _least(matrix, np.concatenate([own.f, own.b]))
            return own.scale * x[:nu], of_lam * x[nu:]
        return _softened(e)


@dataclass(frozen=True)
class NullSpace(_Formulation):
    """Kane's equations with an orthogonal complement: ``P^T M N z' = P^T (f - M a0)``.

    N spans the null space of G, P the null space of L^T (the same without geometric stiffness); a0 is a particular
    solution of G a0 = b. The multipliers follow by least squares. Source: Wang & Huston 1988.
    """

    closed: ClassVar[bool] = True

    def _solve(self, e: Equations) -> tuple[np.ndarray, np.ndarray]:
        """Return accelerations (nu,) and multipliers (ng,)."""
        own = _Balanced.of(e)
        M, G, f = own.M, own.G, own.f
        N = null_space(G, rcond=RANK) if len(G) else np.eye(len(M))
        P = null_space(own.directions().T, rcond=RANK) if len(G) else N
        a = _least(G, own.b)
        if N.shape[1]:
            a = a + N @ solve(P.T @ M @ N, P.T @ (f - M @ a))
        return own.scale * a, _multipliers(own, M @ a - f, e.weight)


@dataclass(frozen=True)
class UdwadiaPhohomsiri(_Formulation):
    """The closed form for singular mass matrices and dependent constraints.

    ``a = [(I - L L^+) M; G]^+ [(I - L L^+) f; b]``.

    Source: Udwadia & Phohomsiri 2006, eq. 3.13; unique if [M; G] has full column rank, which is checked.
    """

    closed: ClassVar[bool] = True

    def _solve(self, e: Equations) -> tuple[np.ndarray, np.ndarray]:
        """Return accelerations (nu,) and multipliers (ng,)."""
        own = _Balanced.of(e)
        M, G, f = own.M, own.G, own.f
        if len(G):
            U, s, _ = svd(own.directions(), full_matrices=False)
            U = U[:, s > RANK * max(s[0], 1e-300)]
        else:
            U = np.zeros((len(M), 0))
        project = np.eye(len(M)) - U @ U.T
        stacked = np.vstack([project @ M, G])
        if np.linalg.matrix_rank(np.vstack([M, G]), tol=RANK * np.abs(M).max()) < len(M):
            raise CompileError(
                "UdwadiaPhohomsiri",
                found="[M; G] does not have full column rank",
                expected="every freedom to have inertia or a constraint",
                remedy="Give the free motion inertia, or forbid it by a joint",
            )
        a = _least(stacked, np.concatenate([project @ f, own.b]))
        return own.scale * a, _multipliers(own, M @ a - f, e.weight)


@dataclass(frozen=True)
class Baumgarte(_Formulation):
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

    def __post_init__(self):
        if not isinstance(self.formulation, Augmented | NullSpace | UdwadiaPhohomsiri):
            raise ModelError(
                "Baumgarte",
                found=f"formulation = {self.formulation!r:.80}",
                expected="Augmented(), NullSpace() or UdwadiaPhohomsiri()",
                remedy="Leave it out for Augmented()",
            )
        for name in ("alpha", "beta"):
            value = getattr(self, name)
            if not is_number(value) or not 0.0 <= value <= FASTEST:
                raise ModelError(
                    "Baumgarte",
                    found=f"{name} = {value!r:.80}",
                    expected=f"a rate from 0 to {FASTEST:.0e} 1/s",
                    remedy="Leave it out for 10 1/s",
                )

    def solve(self, e: Equations) -> tuple[np.ndarray, np.ndarray]:
        """Return accelerations (nu,) and multipliers (ng,)."""
        b = e.b - 2.0 * self.alpha * e.velocity - self.beta**2 * e.position
        return self.formulation.solve(replace(e, b=b))
