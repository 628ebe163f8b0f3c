"""Static solutions of an elastic body held at its interfaces: one sparse factorisation serves everything.

The freedoms that rigid and bare-node interfaces prescribe are taken out; what is left, K_ii, is factorised once.
Averaging interfaces and bodies that the interfaces do not hold enter through a small dense system (docs, theory
"reduction"): constraint modes, fixed-interface modes, unit loads and free-free modes are block solves with K_ii.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from scipy import sparse
from scipy.linalg import cho_factor, cho_solve, eigh, lu_factor, lu_solve, qr

from flexmb.fem.fe_model import FEModel
from flexmb.math.factor import Backend, NotPositiveDefinite, factor
from flexmb.reduction.checks import beside_largest, check_connected, check_grounding, check_mass, mechanism
from flexmb.reduction.interfaces import Coupling, independent_columns, rigid_block

__all__ = ["HeldBody"]

HINGE = 1e-14
"""Strain energy of interface motions, relative to the largest, that is rounding."""


class HeldBody:
    """An FE model with its interface coordinates q: constraint modes, solutions with q = 0, condensed stiffness.

    Attributes
    ----------
    fe : FEModel
    couplings : tuple of Coupling
    rigid : (ndof, r)
        Independent rigid motions about the centroid (r = 6 unless freedoms are missing).
    slices : tuple of slice
        Interface coordinates of each coupling; coordinates behind the last one hold a body that is not held otherwise.
    constraint_modes : (ndof, nq)
        Static deformation for a unit value of each interface coordinate.
    rigid_coordinates : (nq, r)
        Interface coordinates of the rigid motions.
    condensed : (nq, nq)
        Stiffness of the interface coordinates (Guyan), exact for interface loads.
    """

    def __init__(self, fe: FEModel, couplings: Sequence[Coupling], backend: Backend | None = None):
        self.fe, self.couplings = fe, tuple(couplings)
        self.center = fe.nodes.mean(axis=0)
        self.length = float(np.linalg.norm(fe.nodes - self.center, axis=1).max()) or 1.0
        block = rigid_block(fe, np.arange(fe.ndof), self.center)
        self.motions = independent_columns(block, self.length)
        self.rigid = block[:, self.motions]
        self.rigid_mass = self.rigid.T @ (fe.M @ self.rigid)
        check_mass(fe, self.rigid_mass, self.motions)
        self.grounding = check_grounding(fe, self.rigid, self.motions)
        self._number_coordinates()
        check_connected(fe, self.couplings)
        self._choose_supports()
        self._factorise(backend)
        self._constraint_modes()
        self._factors: dict[tuple[int, ...], Any] = {}

    # --- setting up ------------------------------------------------------------------------------------------------

    def _number_coordinates(self) -> None:
        """Number the interface coordinates and collect the averages; add the mass average if nothing else holds."""
        fe, slices, start = self.fe, [], 0
        for coupling in self.couplings:
            slices.append(slice(start, start + len(coupling.freedoms)))
            start += len(coupling.freedoms)
        self.slices = tuple(slices)
        rows = [_average_rows(fe, c) for c in self.couplings if c.averaging]
        held = [rigid_block(fe, c.rows, self.center)[:, self.motions] for c in self.couplings if not c.averaging]
        held += [row @ self.rigid for row in rows]
        scale = np.where(self.motions < 3, 1.0, self.length)
        motion = np.vstack(held) / scale if held else np.zeros((0, len(scale)))
        self.free_motions = len(scale) - (np.linalg.matrix_rank(motion, tol=1e-6 * np.abs(motion).max(initial=1.0)))
        if self.free_motions:  # e.g. one bare node of a solid, or no interface: hold the mean motion of the mass
            rows.append(np.linalg.solve(self.rigid_mass, (fe.M @ self.rigid).T))
        self._averages = np.vstack(rows) if rows else np.zeros((0, fe.ndof))
        self.nq = start + (len(scale) if self.free_motions else 0)

    def _choose_supports(self) -> None:
        """Pick the freedoms that make K_ii definite where only averages hold the body (3-2-1 support)."""
        fe = self.fe
        prescribed = [c.rows for c in self.couplings if not c.averaging]
        self.prescribed = np.concatenate(prescribed) if prescribed else np.zeros(0, int)
        scaled = self.rigid / np.where(self.motions < 3, 1.0, self.length)
        fixed = scaled[self.prescribed]
        held = np.linalg.qr(np.vstack([fixed, np.zeros((1, scaled.shape[1]))]), mode="r")
        _, size, turn = np.linalg.svd(held)
        rank = int(np.sum(size > 1e-6 * size.max(initial=0.0)))
        loose = scaled @ turn[rank:].T
        loose[self.prescribed] = 0.0
        self.supports = (
            np.sort(qr(loose.T, mode="r", pivoting=True)[1][: loose.shape[1]]) if loose.shape[1] else np.zeros(0, int)
        )
        free = np.ones(fe.ndof, bool)
        free[self.prescribed] = free[self.supports] = False
        self.interior = np.flatnonzero(free)

    def _factorise(self, backend: Backend | None) -> None:
        fe, inner = self.fe, self.interior
        K_ii = fe.K[inner][:, inner]
        try:
            self.factor = factor(K_ii, fe.nodes[fe.dofs[inner, 0]], backend=backend)
        except NotPositiveDefinite as error:
            raise mechanism(fe, inner[error.freedom], str(error.found)) from error
        self.nnz = self.factor.nnz
        self._check_definite(K_ii)

    def _check_definite(self, K_ii: sparse.csr_matrix) -> None:
        """Find a mechanism that rounding hides from the pivots: inverse iteration must keep some strain energy."""
        n = len(self.interior)
        if self.factor.weakest_pivot > 1e-9:
            return
        weight = K_ii.diagonal()
        x = np.random.default_rng(5).standard_normal((n, 2)) * np.sqrt(weight)[:, None]
        for _ in range(2):
            x = self.factor.solve(x)
            x *= weight[:, None] / np.abs(x).max(axis=0)
        x = self.factor.solve(x)
        energy = np.einsum("ik,ik->k", x, K_ii @ x)
        handled = np.einsum("ik,ik->k", np.abs(x), abs(K_ii) @ np.abs(x))
        worst = int(np.argmin(energy / handled))
        if not energy[worst] > 1e-14 * handled[worst]:
            freedom = self.interior[int(np.argmax(np.abs(x[:, worst])))]
            raise mechanism(
                self.fe,
                freedom,
                f"a motion without strain energy (relative {energy[worst] / handled[worst]:.0e})",
            )

    def _constraint_modes(self) -> None:
        fe = self.fe
        prescribing = [c for c in self.couplings if not c.averaging]
        columns = sum(len(c.freedoms) for c in prescribing)
        given = np.zeros((fe.ndof, columns + len(self.supports)))
        owner, start = [], 0
        for coupling, where in zip(self.couplings, self.slices, strict=True):
            if not coupling.averaging:
                given[coupling.rows, start : start + len(coupling.freedoms)] = coupling.matrix
                owner.extend(range(where.start, where.stop))
                start += len(coupling.freedoms)
        given[self.supports, columns + np.arange(len(self.supports))] = 1.0
        rhs = np.hstack([-(fe.K @ given)[self.interior], -self._averages.T[self.interior]])
        static = self.factor.solve(rhs) if len(self.interior) else rhs
        given[self.interior] = static[:, : given.shape[1]]
        self._on_supports, responses = given[:, columns:], given[:, :columns]
        self._multipliers = np.zeros((fe.ndof, len(self._averages)))
        self._multipliers[self.interior] = static[:, given.shape[1] :]
        self._assemble_small_system()
        modes = np.zeros((fe.ndof, self.nq))
        modes[:, owner] = responses + self._close(
            -self._on_supports.T @ (fe.K @ responses), -self._averages @ responses
        )
        averaged = np.setdiff1d(np.arange(self.nq), owner)
        modes[:, averaged] = self._close(np.zeros((len(self.supports), len(averaged))), np.eye(len(averaged)))
        self.constraint_modes = modes
        self._condense()

    def _assemble_small_system(self) -> None:
        """H = [[S_ss, (A X_s)^T], [A X_s, A Y]] of the supports' motions and the averages' multipliers, scaled."""
        fe, X, Y, A = self.fe, self._on_supports, self._multipliers, self._averages
        H = np.block([[X.T @ (fe.K @ X), (A @ X).T], [A @ X, A @ Y]])
        flexibility = np.abs(np.diag(A @ Y)).max(initial=0.0) or 1.0
        self._scale = np.concatenate([np.full(X.shape[1], np.sqrt(flexibility)), np.full(len(A), flexibility**-0.5)])
        self._small = lu_factor(self._scale[:, None] * H * self._scale) if len(H) else None

    def _close(self, forces: np.ndarray, gaps: np.ndarray) -> np.ndarray:
        """Return X_s beta + Y lambda for support forces and gaps of the averages: (ndof, k)."""
        if self._small is None:
            return np.zeros((self.fe.ndof, gaps.shape[1]))
        unknown = self._scale[:, None] * lu_solve(self._small, self._scale[:, None] * np.vstack([forces, gaps]))
        count = self._on_supports.shape[1]
        return self._on_supports @ unknown[:count] + self._multipliers @ unknown[count:]

    def _condense(self) -> None:
        """Condense K to q and take the rounding out: rigid motions carry no energy, exactly."""
        Z = self.coordinates(self.rigid)
        scale = self.coordinate_scale()
        S = self.constraint_modes.T @ (self.fe.K @ self.constraint_modes)
        scaled = Z * scale[:, None]
        project = np.eye(self.nq) - Z @ np.linalg.solve(scaled.T @ scaled, (scaled * scale[:, None]).T)
        S = project.T @ S @ project
        self.rigid_coordinates, self.condensed = Z, 0.5 * (S + S.T)

    def coordinates(self, vectors: np.ndarray) -> np.ndarray:
        """Return the interface coordinates (nq, k) of displacements (ndof, k) that the couplings allow."""
        read = [(c.matrix if c.averaging else np.linalg.pinv(c.matrix)) @ vectors[c.rows] for c in self.couplings] + (
            [self._averages[-len(self.motions) :] @ vectors] if self.free_motions else []
        )
        return np.vstack(read) if read else np.zeros((0, vectors.shape[1]))

    def coordinate_scale(self) -> np.ndarray:
        """Return the weight of each interface coordinate that makes rotations comparable to translations, m."""
        kinds = [c.freedoms for c in self.couplings] + ([self.motions] if self.free_motions else [])
        kind = np.concatenate(kinds) if kinds else np.zeros(0)
        return np.where(kind < 3, 1.0, self.length)

    # --- solving ---------------------------------------------------------------------------------------------------

    def solve(self, forces: np.ndarray) -> np.ndarray:
        """Return the displacement (ndof, k) under nodal forces (ndof, k) with all interface coordinates zero."""
        out = np.zeros(forces.shape)
        if len(self.interior):
            out[self.interior] = self.factor.solve(forces[self.interior])
        if self._small is None:
            return out
        return out + self._close(self._on_supports.T @ forces, -self._averages @ out)

    def release_factor(self) -> None:
        """Give the memory of the factorisation back: nothing can be solved any more, all arrays stay."""
        self.factor = factor(sparse.csr_matrix((0, 0)))

    def solve_supported(self, forces: np.ndarray, support: np.ndarray | None = None) -> np.ndarray:
        """Return the displacement (ndof, k) under forces with the interface coordinates `support` held at zero.

        Any statically determinate choice of six will do for forces in equilibrium; `determinate_support` picks one.
        """
        support = self.determinate_support() if support is None else np.asarray(support, int)
        free = np.setdiff1d(np.arange(self.nq), support)
        out = self.solve(forces)
        if len(free):
            scale = self.coordinate_scale()[free, None]
            load = (self.constraint_modes[:, free].T @ forces) / scale
            out += self.constraint_modes[:, free] @ (cho_solve(self._supported(support), load) / scale)
        return out

    def _supported(self, held: np.ndarray):
        """Return the factor of the scaled stiffness of coordinates that are not held; ReductionError for a hinge."""
        support = tuple(held.tolist())
        free = np.setdiff1d(np.arange(self.nq), held)
        scale = self.coordinate_scale()[free]
        if support not in self._factors:
            stiffness = self.condensed[np.ix_(free, free)] / np.outer(scale, scale)
            unit = np.sqrt(np.maximum(np.diag(stiffness), 0.0))
            unit[unit == 0.0] = 1.0
            energy, y = eigh(stiffness / np.outer(unit, unit))
            if not energy[0] > max(HINGE * energy[-1], 0.0):  # of zeros alone as well
                shape = self.constraint_modes[:, free] @ (y[:, 0] / unit / scale)
                raise mechanism(
                    self.fe,
                    int(np.abs(shape).argmax()),
                    f"the interfaces move against each other without strain energy{beside_largest(energy)}",
                    held=False,
                )
            self._factors[support] = cho_factor(stiffness)
        return self._factors[support]

    def check_hinges(self) -> None:
        """Raise ReductionError where interfaces move against each other without strain energy."""
        support = self.determinate_support()
        if len(support) < self.nq:
            self._supported(support)

    def determinate_support(self) -> np.ndarray:
        """Return as many interface coordinates as there are rigid motions, chosen to hold them best."""
        scaled = (
            self.rigid_coordinates * self.coordinate_scale()[:, None] / np.where(self.motions < 3, 1.0, self.length)
        )
        return np.sort(qr(scaled.T, mode="r", pivoting=True)[1][: scaled.shape[1]])

    def solve_free(self, forces: np.ndarray) -> np.ndarray:
        """Return the elastic displacement of the free body: forces balanced by inertia, no rigid motion left in it."""
        balanced = forces - (self.fe.M @ self.rigid) @ np.linalg.solve(self.rigid_mass, self.rigid.T @ forces)
        return self.without_rigid(self.solve_supported(balanced))

    def without_rigid(self, vectors: np.ndarray) -> np.ndarray:
        """Return vectors (ndof, k) made M-orthogonal to the rigid motions (twice is enough for rounding)."""
        for _ in range(2):
            vectors = vectors - self.rigid @ np.linalg.solve(self.rigid_mass, self.rigid.T @ (self.fe.M @ vectors))
        return vectors


def _average_rows(fe: FEModel, coupling: Coupling) -> np.ndarray:
    rows = np.zeros((len(coupling.freedoms), fe.ndof))
    rows[:, coupling.rows] = coupling.matrix
    return rows
