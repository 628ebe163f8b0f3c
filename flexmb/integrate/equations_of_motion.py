"""`equations`: the matrices of the equations of motion at a state, in coordinates with names."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy import sparse
from scipy.linalg import null_space, pinv, svd

from flexmb.errors import ModelError
from flexmb.integrate.impulsive import refuse_crowds, refuse_impulses
from flexmb.integrate.matrices import equations_at
from flexmb.math.rotations import euler_to_matrix
from flexmb.math.udwadia import Accelerated, solve
from flexmb.model.model import Model
from flexmb.system import assemble, assemble_as_drawn
from flexmb.system.given_state import given_state
from flexmb.system.mobility import DEPENDENT, DRIFTS, mass_metric
from flexmb.system.program import evaluate
from flexmb.system.system import System
from flexmb.tree.coordinates.joint_tree import JointTree

__all__ = ["EquationsOfMotion", "equations"]

RANK = 1e-10
TWIST = ("vx", "vy", "vz", "wx", "wy", "wz")
PLACE = ("x", "y", "z", "p0", "p1", "p2", "p3")


@dataclass(frozen=True, kw_only=True, eq=False)
class EquationsOfMotion:
    """``M u' = Q + L lam``, ``A u' = b`` at a state; u are the rates of `names`.

    The symbols of the papers: see the theory page on formulations.

    Parameters
    ----------
    names : tuple of str
        Of the rates: "crank.vx" ... (velocities in body axes), "crank.p0'" (Euler-parameter rates), "A.turn".
    equation_names : tuple of str
        Of the rows of A; rows of unit Euler parameters come last.
    M : (n, n); Q : (n,); A : (m, n); b : (m,)
        M, A, L and B are arrays, or sparse matrices (csr) where `equations(..., as_sparse=True)` asked for them.
    L : (n, m)
        Forces of unit multipliers: A^T, unless interface loads stiffen reduced bodies.
    u : (n,)
        The rates at the state.
    velocity : (m,)
        Residual A u + dg/dt of the velocities.
    B : (nu, n), Bdot_u : (nu,)
        Velocities of the bodies are B u + (what drives of the coordinates give), their rates B u' + Bdot_u: partial
        velocities of the system and what their rates give.
    rank : int, optional
        Number of independent rows of A, where some depend on others if only up to the digits of a mesh file; None:
        singular values tell it.
    """

    system: System
    state: Any
    names: tuple[str, ...]
    equation_names: tuple[str, ...]
    M: Any
    Q: np.ndarray
    A: Any
    b: np.ndarray
    L: Any
    u: np.ndarray
    velocity: np.ndarray
    B: Any
    Bdot_u: np.ndarray
    rank: int | None = None

    def __repr__(self):
        return (
            f"EquationsOfMotion({len(self.names)} rates, {len(self.equation_names)} constraints): M Q A b; "
            f"{', '.join(self.names[:8])}{', ...' if len(self.names) > 8 else ''}"
        )

    @property
    def Adot_u(self) -> np.ndarray:
        """What A u' must cancel (m,): A' u and the second rates of what is prescribed, -b."""
        return -self.b

    @property
    def complement(self) -> np.ndarray:
        """Orthonormal basis (n, n - rank) of the motions that the constraints leave, A complement = 0."""
        A = dense(self.A)
        if not len(A):
            return np.eye(len(self.u))
        if self.rank is None:
            return null_space(A, rcond=RANK)
        norms = np.linalg.norm(A, axis=1)
        return svd(A / np.where(norms > 0.0, norms, 1.0)[:, None])[2][self.rank :].T

    @property
    def A_pinv(self) -> np.ndarray:
        """Pseudo-inverse of A, (n, m)."""
        A = dense(self.A)
        if self.rank is None:
            return pinv(A, rtol=RANK)
        N = self.complement
        return pinv(A - (A @ N) @ N.T, rtol=RANK)  # dependent to all digits

    def partial_velocity(self, marker: str) -> tuple[np.ndarray, np.ndarray]:
        """Return the partial velocities (6, n) of a marker in W, and the acceleration (6,) at u' = 0.

        Velocity (m/s) and angular velocity (rad/s) in W are ``partial @ u`` (and what is prescribed), acceleration and
        angular acceleration ``partial @ u' + rate``, where rate = partial' u.
        """
        system, work = self.system, self.system.workspace()
        if marker not in system.marker_index:
            system.model.marker(marker, "equations")
        work.weights[0].wanted = 0
        evaluate(system.program, self.state, work)
        row = work.markers[system.marker_index[marker]]
        J = np.zeros((6, system.nu))
        nu, at = int(row["nu"]), int(row["iJ"])
        J[:, int(row["iu"]) : int(row["iu"]) + nu] = work.J[at : at + 6 * nu].reshape(6, nu)
        return J @ dense(self.B), row["bias"] + J @ self.Bdot_u

    def solve(self, C=None) -> Accelerated:
        """Return the accelerations by Udwadia & Phohomsiri's equation; C (n,) makes constraints that are not ideal."""
        L, A = dense(self.L), dense(self.A)
        if not np.allclose(L, A.T, rtol=1e-12, atol=1e-12 * np.max(np.abs(A), initial=0.0)):
            raise ModelError(
                "equations",
                found="forces of multipliers that are not A^T: interface loads stiffen a reduced body",
                expected="constraint forces A^T lam",
                remedy="Give the bodies geometric_stiffness=False, or use fmb.accelerations",
            )
        return solve(self.M, self.Q, self.A, self.b, C=C, rank=self.rank)

    def in_euler_parameters(self) -> EquationsOfMotion:
        """Return the equations in rates of positions in W and of Euler parameters, with ``|p| = 1`` as constraints.

        u = B q': v = R^T r', w = 4 L^T p' with p' = L w. Every body with a frame has a 4 x 4 block of mass of rank 3.
        """
        self._require_bodies()
        system, q, u = self.system, self.state.q, self.u
        names: list[str] = []
        unit: list[Any] = []
        blocks: list[Any] = []
        at, rate = 0, np.zeros(len(u))
        for body in system.model.bodies:
            iq, iu = system.body_slices[body.name]
            n = iu.stop - iu.start
            own, titles = np.eye(n), list(self.names[iu])
            if body.has_frame and n:
                p, R, v, w = q[iq][3:7], np.empty((3, 3)), u[iu][:3], u[iu][3:6]
                euler_to_matrix(p, R)
                own = np.zeros((n, n + 1))
                own[:3, :3], own[3:6, 3:7], own[6:, 7:] = R.T, 4.0 * _half_product(p).T, np.eye(n - 6)
                rate[iu.start : iu.start + 3] = np.cross(v, w)
                titles = [f"{body.name}.{name}'" for name in PLACE] + titles[6:]
                unit.append((body.name, at + 3, p, _half_product(p) @ w))
            blocks.append((iu, at, own))
            names += titles
            at += own.shape[1]
        B = sparse.lil_matrix((len(u), at))
        for iu, start, own in blocks:
            B[iu, start : start + own.shape[1]] = own
        B = B.tocsr() if sparse.issparse(self.M) else B.toarray()
        extra, second = np.zeros((len(unit), at)), np.zeros(len(unit))
        speed = np.zeros(at)
        for iu, start, own in blocks:
            speed[start : start + own.shape[1]] = np.linalg.pinv(own) @ u[iu]  # p' has no part along p
        for k, (_, start, p, dp) in enumerate(unit):
            extra[k, start : start + 4], second[k] = p, -dp @ dp
        of_unit = tuple(f"{name}: |p| = 1" for name, *_ in unit)
        return self._in(B, rate, speed, tuple(names), (extra, second, of_unit))

    def in_joint_coordinates(self, cut: tuple[str, ...] = ()) -> EquationsOfMotion:
        """Return the equations in the relative rates of the joint tree; equations that it satisfies are left out.

        Parameters
        ----------
        cut : tuple of str
            Joints that close loops, see `JointTree`.
        """
        self._require_bodies()
        tree = JointTree.of(self.system, self.state, cut)
        here = tree.read(self.state._replace(a=np.zeros(self.system.nu)), tree.work)
        zero = np.zeros(len(here.v))
        B = np.array([tree.absolute(here.q, row, zero, self.state.t).u for row in np.eye(len(zero))]).T
        B = B.reshape(self.system.nu, len(zero))
        B = sparse.csr_matrix(B) if sparse.issparse(self.M) else B
        rate = tree.absolute(here.q, here.v, zero, self.state.t).a
        found = self._in(B, rate, here.v.copy(), tree.rate_names, (np.zeros((0, len(zero))), np.zeros(0), ()))
        size = np.max(np.abs(dense(self.A)), axis=1, initial=0.0)
        least = 1e-9 if self.rank is None else DRIFTS * DEPENDENT
        kept = np.flatnonzero(
            np.max(np.abs(dense(found.A)), axis=1, initial=0.0) > least * np.where(size > 0.0, size, 1.0)
        )
        return replace(
            found,
            A=found.A[kept],
            b=found.b[kept],
            L=found.L[:, kept],
            velocity=found.velocity[kept],
            equation_names=tuple(found.equation_names[k] for k in kept),
        )

    def _require_bodies(self) -> None:
        if self.B.shape[0] != self.B.shape[1] or abs(self.B - sparse.identity(self.B.shape[0])).max() > 0.0:
            raise ModelError(
                "equations",
                found="equations in other coordinates than velocities of bodies",
                expected="those that fmb.equations returns",
                remedy="Write fmb.equations(model).in_euler_parameters()",
            )

    def _in(self, B, rate, u, names, more) -> EquationsOfMotion:
        """Return the equations in rates with velocities B u, (B u)' = B u' + rate, and constraints added."""
        rows, second, titles = more
        stacks: Any = sparse if sparse.issparse(self.M) else np
        rows = sparse.csr_matrix(rows) if sparse.issparse(self.M) else rows
        return replace(
            self,
            names=names,
            equation_names=(*self.equation_names, *titles),
            M=B.T @ self.M @ B,
            Q=B.T @ (self.Q - self.M @ rate),
            A=stacks.vstack([self.A @ B, rows], **({"format": "csr"} if stacks is sparse else {})),
            b=np.concatenate([self.b - self.A @ rate, second]),
            L=stacks.hstack([B.T @ self.L, rows.T], **({"format": "csr"} if stacks is sparse else {})),
            u=u,
            velocity=np.concatenate([self.velocity, np.zeros(len(second))]),
            B=B,
            Bdot_u=rate,
            rank=None if self.rank is None else self.rank + B.shape[1] - B.shape[0],
        )


def dense(matrix: Any) -> np.ndarray:
    """Return a matrix as an array."""
    return matrix.toarray() if sparse.issparse(matrix) else matrix


def _half_product(p: np.ndarray) -> np.ndarray:
    """Return the (4, 3) matrix of p' = L w, 1/2 p o (0, w)."""
    a, b, c, d = 0.5 * p
    return np.array([[-b, -c, -d], [a, -d, c], [d, a, -b], [-c, b, a]])


def equations(model: Model, state: Any = None, *, as_sparse: bool = False) -> EquationsOfMotion:
    """Return the equations of motion of a model at a state, in the velocities of its bodies.

    Parameters
    ----------
    model : Model
    state : Instant, optional
        ``solution.final``, ``solution.state(t)``; by default the assembled start.
    as_sparse : bool
        Sparse matrices (csr) M, A, L and B, for large models; arrays otherwise.

    Examples
    --------
    >>> body = fmb.RigidBody("b", mass=2.0, inertia=(1, 2, 3), angular_velocity=(1, 1, 0))
    >>> found = fmb.equations(fmb.Model(bodies=[body])).in_euler_parameters()
    >>> found.M.shape, int(np.linalg.matrix_rank(found.M)), found.equation_names
    ((7, 7), 6, ('b: |p| = 1',))
    """
    refuse_impulses(model, "equations")
    refuse_crowds(model, "equations")
    system, start = (assemble_as_drawn if state is None else assemble)(model)
    if state is not None:
        start = given_state(state, system, "equations")
    work = system.workspace()
    e = equations_at(system, start, work)
    names: list[str] = []
    for body in model.bodies:
        iu = system.body_slices[body.name][1]
        first = TWIST if body.has_frame else ()
        count = iu.stop - iu.start - len(first) if iu.stop > iu.start else 0
        titles = [*first, *(f"eta{k + 1}'" if body.has_frame else f"u{k + 1}" for k in range(count))]
        names += [f"{body.name}.{title}" for title in titles[: iu.stop - iu.start]]
    names += [f"{group.title}.{name}" for group in system.states for name in group.names]
    nu = system.nu
    return EquationsOfMotion(
        system=system,
        state=start,
        names=tuple(names),
        equation_names=system.equation_names,
        M=e.M.tocsr() if as_sparse else e.M.toarray(),
        Q=e.f,
        A=e.G.tocsr() if as_sparse else e.G.toarray(),
        b=e.b,
        L=e.L.tocsr() if as_sparse else e.L.toarray(),
        u=start.u.copy(),
        velocity=e.velocity,
        B=sparse.identity(nu, format="csr") if as_sparse else np.eye(nu),
        Bdot_u=np.zeros(nu),
        rank=_rank(e.independent().G.toarray() / np.sqrt(np.maximum(mass_metric(e.M), e.least_inertia)))
        if len(e.dependent)
        else None,
    )


def _rank(A: np.ndarray) -> int:
    """Return the rank of a matrix whose rows are of different size."""
    norms = np.linalg.norm(A, axis=1)
    return int(np.linalg.matrix_rank(A / np.where(norms > 0.0, norms, 1.0)[:, None], rtol=RANK)) if A.size else 0
