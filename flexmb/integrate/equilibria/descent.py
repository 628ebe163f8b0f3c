"""Newton's method with an artificial inertia that fades: the iteration of `statics` towards a stable equilibrium."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import splu

from flexmb.errors import IntegrationError
from flexmb.integrate.extent import extents
from flexmb.integrate.linear.steady import FactoredSaddle, saddle, steady_motion
from flexmb.integrate.matrices import tangent_at
from flexmb.system.complaints import without_value
from flexmb.system.mobility import mass_metric
from flexmb.system.program import advance, evaluate, increment, keep_branches

__all__ = ["Descent"]

LINEAR = 0.1
"""A move with a smaller nonlinearity lets the pseudo time grow, whatever the forces."""
CUTS = 30
"""How often the pseudo time is halved until no move is uphill."""
SHORTEST = 1e-6
"""Pseudo time, relative to the first, below which moves lead nowhere."""
UPHILL = 1e-8
"""How far, as a share of the model's size, a move may go against its force: what rounding does."""
SOFT = 1e-9
"""Of the equations, where states of self-stress are looked for, relative to G diag(M)^-1 G^T."""
LOST = 1e6
"""Largest displacement in a search, relative to the model's size; of a turn: its arc at the radius of gyration."""
DIGITS = 1e-15
"""Of the forces where a search begins, what is left may be their rounding."""
NEAR = 1e-9
"""Displacement that forces which are small beside those of the start may still make, relative to the model's size."""
REFINED = 50
"""Most corrections of multipliers of least norm."""
_PLACE = ("q", "x", "lam", "now", "motion", "tangent", "force", "g", "unbalanced")


class Descent:
    """Newton's method with an artificial inertia M / step^2.

    The pseudo time `step` grows with the fall of the unbalanced forces, and where a move has proved linear: the forces
    after it are those foreseen, in the measure of the displacements that the rest would cause (Deuflhard's natural
    level). That does not depend on how stiff the stiffest direction is, as a norm of the forces does. It is cut where
    the next move would go uphill, against the force: to the far side of a buckling load.

    Both judge by the stiffness at one place, so they need a smooth model. Between stiff contacts with small gaps it
    predicts nothing: a part that floats in its gap has no unbalanced force, a move there is linear, and its pseudo time
    would grow until rounding drives it. Without `smooth`, `step` follows the unbalanced forces alone.
    """

    def __init__(
        self, system, start, work, t: float, q: np.ndarray, at_rest: bool, wary: bool, smooth: bool, held: bool = False
    ):
        self.at_rest, self.wary, self.smooth = at_rest, wary, smooth
        self.system, self.work, self.t, self.q = system, work, t, q
        self.size, self.lengths = system.lengths.whole, system.lengths.are_lengths
        self.extent, _ = extents(system, start, work)
        self.states, self.x, self.held = system.is_state, start.u[system.is_state], held
        self.per_extent = np.where(self.states, 0.0, 1.0 / self.extent)
        self.extent[self.states] = 0.0  # they are judged by themselves, see `_settled`
        self.lam = np.zeros(system.ng)
        self.path: list[tuple[np.ndarray, ...]] = []
        self.step, self.first, self.unbalanced, self.largest = 0.0, 0.0, np.inf, 0.0
        self.met = self.loads = 0.0  # the largest force on the way so far, and out of balance where it begins
        self.before: dict[str, Any] = {}
        self.foreseen: tuple | None = None
        self.softest = np.random.default_rng(0).standard_normal((system.nu, min(3, system.nu)))

    def balanced(self, tolerance: float) -> bool:
        """Evaluate the forces at the present configuration; are they in balance, and the constraints satisfied?"""
        now = self.system.state(self.t, self.q, u=self._at_rest(), lam=self.lam)
        if self.path and self._beyond(now):
            self.__dict__.update(self.before)
            self.step *= 0.1
            return False
        try:
            self.now, self.motion = now, steady_motion(self.system, now, self.work, known=self.at_rest)
        except RuntimeError:  # singular: numbers that end on the way
            if not self.path:
                raise
            self.unbalanced = np.nan
            return False
        now.u[:], now.a[:] = self.motion.u, self.motion.a
        self.tangent = self._of_states(tangent_at(self.system, now, self.work))
        keep_branches(self.system.program, self.work, self.q)
        self.force, self.g = self.work.residual.copy(), self.work.equations["g"].copy()
        self.force[self.states] *= not self.held
        before, self.unbalanced = self.unbalanced, self._greatest(self.force * self.per_extent)
        if self.wary and self.path and not self.unbalanced <= max(30.0 * before, self.met):
            self.__dict__.update(self.before)
            self.step *= 0.1
            self.wary = self.step > 1e-9 * self.first
            return False
        reactions = abs(self.tangent.L) @ np.abs(self.lam)
        # of this place alone: beside the reactions of a move that led nowhere, or the force of a spring that was
        # stretched at the start, any force is small
        self.largest = max(
            self._greatest(np.maximum(reactions, self._from_markers()) * self.per_extent),
            self._inertia(np.where(self.states, 0.0, now.u)),
        )
        self.loads = self.loads if self.path else self.unbalanced
        self.met = max(self.met, self.largest, self.loads)
        self.path.append((self.q.copy(), now.u, now.a, self.lam.copy()))
        if len(self.path) == 1:
            # first pseudo time: the unbalanced forces may move the model by a hundredth of its size
            pull = self._greatest(self.force * self.extent / mass_metric(self.tangent.M))
            self.step = self.first = np.sqrt(0.02 * self.size / max(pull, 1e-30))
        elif np.isfinite(self.unbalanced):
            growth = min(4.0, max(0.3, (before / max(self.unbalanced, 1e-300)) ** 0.7))
            self.step *= max(growth, min(4.0, LINEAR / max(self._nonlinearity(), 1e-300)))
        return (
            self._greatest(self.g) <= 1e-9 * self.size
            and self._settled(tolerance)
            and (
                self.unbalanced <= max(tolerance * self.largest, DIGITS * self.loads, 1e-30)
                or self._rounded(before)
                or (self.unbalanced <= tolerance * self.loads and self._moves_no_more())
            )
        )

    def lost(self) -> bool:
        """Has the search left all bounds: numbers without a value, or a million model sizes away from its start?"""
        if not self.path:
            return not np.isfinite(self.unbalanced)
        moved = np.zeros(self.system.nu)
        increment(self.system.program, self.path[0][0], self.q, moved)
        far = self._greatest(np.where(self.states, 0.0, moved * self.extent))
        return not (np.isfinite(self.unbalanced) and far <= LOST * self.size)

    def _beyond(self, now) -> bool:
        """Has a move led where an equation or a force has no value? Raise IntegrationError if even short ones do."""
        self.work.weights[0].wanted = 0
        evaluate(self.system.program, now, self.work)
        cause = without_value(self.system, self.work, now.q, now.u, now.lam)
        if cause and self.step <= SHORTEST * self.first:
            raise IntegrationError(
                f"Model '{self.system.model.name}'",
                found=f"the search for an equilibrium comes to where numbers end{cause}",
                expected="equations and forces with a value all the way to the equilibrium",
                remedy=_what_to_do(self.system.model, cause),
            )
        return bool(cause)

    def _at_rest(self) -> np.ndarray:
        """Return velocities (nu,) of bodies at rest, with the states."""
        u = np.zeros(self.system.nu)
        u[self.states] = self.x
        return u

    def _of_states(self, tangent):
        """Return the tangent with states, not their integrals, as unknowns of the last columns; held, they stay."""
        if not self.states.any():
            return tangent
        own = sparse.diags(self.states.astype(float), format="csr")
        rest = sparse.identity(len(self.states), format="csr") - own
        K, D = tangent.K @ rest + tangent.D @ own, tangent.D @ rest
        if self.held:
            K, D = rest @ K @ rest + own, rest @ D
        return replace(tangent, K=K, D=D)

    def _settled(self, tolerance: float) -> bool:
        """Are the rates of the states rounding, or within the tolerance, beside the terms that they are made of?"""
        states = self.states
        K = abs(self.tangent.K)[states]
        size = np.where(states, 0.0, self.size * self.per_extent)
        size[states] = np.maximum(np.abs(self.x), self.system.state_sizes)
        return bool(np.all(np.abs(self.force[states]) <= tolerance * (K @ size)))

    def _nonlinearity(self) -> float:
        """Return the displacement that undoes what the last move has made of the forces beyond the foreseen, relative
        to the move."""
        if self.foreseen is None or not self.smooth:
            return np.inf
        factor, rest, move = self.foreseen
        more = factor.solve(np.concatenate([self.force, self.g]) - rest)[: self.system.nu]
        return self._greatest(more * self.extent) / max(self._greatest(move * self.extent), 1e-300)

    def _rounded(self, before: float) -> bool:
        """Are the unbalanced forces what rounding the positions makes? Without any load, these are all there are.

        They are below what the stiffest direction makes of the last digit, and either an iteration leaves them as large
        as they were `before`, or the last digits of these coordinates do make them: a small load on a soft direction,
        as on a thin plate, is below the first bound too.
        """
        stiffest = self._greatest((abs(self.tangent.K) @ self._magnitudes()) * self.per_extent)
        if self.unbalanced > 1e-16 * stiffest:
            return False
        if 0.1 * before <= self.unbalanced:
            return True
        made, digits = np.zeros(self.system.nu), np.random.default_rng(0)
        self.work.weights[0].wanted = 0
        for _ in range(3):
            near = self.q * (1.0 + np.finfo(float).eps * digits.choice((-1.0, 1.0), len(self.q)))
            evaluate(self.system.program, self.now._replace(q=near), self.work)
            made = np.maximum(made, np.abs(self.work.residual - self.force))
        return bool(np.all((np.abs(self.force) <= 10.0 * made)[~self.states]))

    def _moves_no_more(self) -> bool:
        """Are the unbalanced forces, small beside those of the start, also small beside all stiffnesses that count?

        Where no force is left, as between springs that have come to their lengths, displacements tell. Motions that the
        unbalanced force would take a million model sizes away are free.
        """
        tangent, least = self.tangent, self.system.least_inertia
        free = self._greatest(self.force * self.extent / np.maximum(mass_metric(tangent.M), least)) / (LOST * self.size)
        block = tangent.M * free + self._moving()
        try:
            matrix = saddle(block, tangent.L, tangent.G, 1e-12, self.lengths, least * free)
            factor = FactoredSaddle(matrix, self.system.nu)
        except RuntimeError:
            return False
        x = factor.solve(-np.concatenate([self.force, self.g]))[: self.system.nu]
        return bool(self._greatest(x * self.extent) <= NEAR * self.size)

    def _moving(self):
        """Return the stiffness; the velocities of a steady motion turn with the bodies."""
        tangent, motion = self.tangent, self.motion
        return tangent.K + tangent.D @ motion.turning + tangent.M @ motion.centripetal

    def _magnitudes(self) -> np.ndarray:
        """Return the size of the numbers (nu,) that are rounded: the model's, or of nodes their vectors themselves."""
        magnitudes = self.size * self.per_extent
        for iq, iu, count, flexible in self.system.program.vectors:
            if flexible == 0:
                own = np.linalg.norm(self.q[iq : iq + count].reshape(-1, 3), axis=1)
                magnitudes[iu : iu + count] = np.repeat(own, 3)
        return magnitudes

    def _inertia(self, u: np.ndarray) -> float:
        """Return the size of the inertia forces of a steady motion: they cancel where a rotor is balanced."""
        rate = self._greatest(u * self.extent) / self.size
        return rate * self._greatest((abs(self.tangent.M) @ np.abs(u)) * self.per_extent)

    def _from_markers(self) -> np.ndarray:
        """Return the largest force (nu,) that the wrench on one marker puts on each freedom."""
        forces = np.zeros(self.system.nu)
        for marker in self.work.markers:
            nu, iu, iJ = int(marker["nu"]), int(marker["iu"]), int(marker["iJ"])
            if nu and marker["wrench"].any():
                J = self.work.J[iJ : iJ + 6 * nu].reshape(6, nu)
                forces[iu : iu + nu] = np.maximum(forces[iu : iu + nu], np.abs(J.T @ marker["wrench"]))
        return forces

    def share_multipliers(self) -> None:
        """Give the multipliers of dependent equations least norm.

        Newton's method leaves the last digit of the forces, divided by a softness of 1e-12, in states of self-stress.
        The solution of (diag M, -L; G, r) (x, y) = (0, r lam) is that part with full digits; it is taken out, and what
        this leaves unbalanced (a share r of the others) is found once more.
        """
        if not self.system.redundant:
            return
        system, nu, L, G = self.system, self.system.nu, self.tangent.L, self.tangent.G
        metric = np.maximum(mass_metric(self.tangent.M), system.least_inertia)
        soft = SOFT * np.max(abs(G).power(2) @ (1.0 / metric)) * system.multiplier_weights
        try:
            factor = splu(sparse.bmat([[sparse.diags(metric), -L], [G, sparse.diags(soft)]], format="csc"))
        except RuntimeError:
            return
        lam = self.lam
        for _ in range(2):
            lam, last = lam - factor.solve(np.concatenate([np.zeros(nu), soft * lam]))[nu:], np.inf
            for _ in range(REFINED):  # one is enough but for equations of other units, which are relatively soft
                left = -(self.force + L @ (self.lam - lam))
                change = factor.solve(np.concatenate([left, np.zeros(system.ng)]))[nu:]
                size = self._greatest(change)
                if not size < 0.5 * last:
                    break
                lam, last = lam + change, size
        self.lam = lam
        self.path[-1] = (*self.path[-1][:3], lam.copy())

    def advance(self) -> bool:
        """Move by one iteration, at most three tenths of the model's size; never done by itself."""
        self.before = {name: getattr(self, name) for name in _PLACE}
        tangent, motion, moving = self.tangent, self.motion, self._moving()
        self.foreseen, rest = None, np.concatenate([self.force, self.g])
        for _ in range(CUTS):
            try:
                block, least = tangent.M / self.step**2 + moving, self.system.least_inertia / self.step**2
                matrix = saddle(block, tangent.L, tangent.G, 1e-12, self.lengths, least)
                factor = FactoredSaddle(matrix, self.system.nu)
            except RuntimeError:  # exactly singular: more inertia helps
                self.step *= 0.5
                return False
            x, taken = factor.solve(-rest), self.step
            if not self.smooth or motion.u.any() or self.states.any() or not self._uphill(factor):
                break  # what spins may be stable beyond its critical speed
            self.step *= 0.5
        stride = self._greatest(x[: self.system.nu] * self.extent) / self.size
        if stride > 0.2:
            self.step *= 0.5
        scale = min(1.0, 0.3 / stride) if stride > 0.0 else 1.0
        q, moved = np.zeros(self.system.nq), x[: self.system.nu].copy()
        self.x = self.x + scale * moved[self.states]
        moved[self.states] = 0.0
        advance(self.system.program, self.q, moved, scale, q)
        self.q, self.lam = q, self.lam + scale * x[self.system.nu :]
        inertia = tangent.M @ x[: self.system.nu] / taken**2
        rest *= 1.0 - scale
        rest[: self.system.nu] -= scale * inertia
        self.foreseen = (factor, rest, x[: self.system.nu]) if stride <= 0.2 else None
        return False

    def _uphill(self, factor) -> bool:
        """Would a part of the move go against the force, along a motion that M / step^2 + K pushes on?

        Looked for among the Ritz vectors of the motions that it resists least. An unstable motion without force, as
        such as a straight column leaving its line, is left alone.
        """
        nu = self.system.nu
        for _ in range(2):
            load = np.zeros((nu + self.system.ng, self.softest.shape[1]))
            load[:nu] = self.tangent.M @ self.softest
            moved = factor.solve(load)[:nu]
            size = np.linalg.norm(moved, axis=0)
            if not (np.all(np.isfinite(size)) and np.all(size > 0.0)):
                return False
            resisted = (moved / size).T @ (load[:nu] / size)
            self.softest, turn = np.linalg.qr(moved / size)
        inverse = np.linalg.pinv(turn)
        values, vectors = np.linalg.eigh(inverse.T @ (0.5 * (resisted + resisted.T)) @ inverse)
        along = self.softest @ vectors[:, 0]
        if values[0] >= -1e-9 * np.abs(values).max():
            return False
        share = along * (along @ self.force / values[0])
        return self._greatest(share * self.extent) > UPHILL * self.size

    def most_unbalanced(self) -> str:
        """Return the title of the body on which most force is left, or the state that does not settle."""
        if self.states.any() and not self._settled(1e-9):
            return self.system.owner(int(np.argmax(np.where(self.states, np.abs(self.force), -1.0))))
        return self.system.owner(int(np.argmax(np.abs(self.force * self.per_extent)))).partition(",")[0]

    @staticmethod
    def _greatest(x: np.ndarray) -> float:
        return float(np.max(np.abs(x), initial=0.0))


def _what_to_do(model, cause: str) -> str:
    """Return the remedy where numbers end because of an equation, or near a part."""
    for force in model.forces:
        if force.without_value and force.title in cause:
            return force.without_value
    if "equation" in cause:
        return (
            "Correct the equation, its numbers or the loads: there is no root or logarithm of what is not positive; or "
            "begin nearer to the equilibrium"
        )
    return "Correct the forces on it, their functions or tables, or the loads; or begin nearer to the equilibrium"
