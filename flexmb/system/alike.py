"""Assembling models that differ from an assembled one in numbers only: the variants of one mechanism.

What `assemble` finds out with sparse matrices about any model, dependent equations and bodies without inertia, is
excluded here by singular values of small dense ones, or known where a variant is drawn alike and only inertias and
loads differ. Where singular values are not far from zero, where a joint is drawn open or
a velocity contradicts a joint, nothing is returned and `assemble_as_drawn` decides: it knows what to say. What is
returned has the same digits as there.
"""

from __future__ import annotations

import threading
from dataclasses import replace

import numpy as np

from flexmb.constraints.formula import Formula
from flexmb.math.tables import State
from flexmb.math.weights import no_matrix, weigh_mass
from flexmb.model.model import Model
from flexmb.system.accelerations import accelerations, is_solved
from flexmb.system.assembly import MEETS, softened
from flexmb.system.compile import compile
from flexmb.system.complaints import equations_of_forces
from flexmb.system.fit import misfits, require_fit
from flexmb.system.lengths import described_lengths, velocity_units, warn_of_lost_digits
from flexmb.system.mobility import constraint_matrix
from flexmb.system.needles import least_inertia, warn_of_needles
from flexmb.system.program import constraint_acceleration, constraint_velocity, evaluate, increment
from flexmb.system.projection import project
from flexmb.system.stations import warn_of_stations
from flexmb.system.system import System

__all__ = ["Alike", "Alikes"]

SMALL = 200
"""Velocities and equations up to which dense matrices are quicker than sparse ones."""
REGULAR = 1e-4
"""Least singular value of unit gradients from which no equation depends on others: a hundred times what counts."""
HEAVY = 1e-9
"""Of a body's mass matrix with a diagonal of one: a thousand times what counts as without inertia."""
CLOSED = 1e-3
"""Gap in the drawing, relative to the size or in rad, and relative change of a velocity, that nobody is told of."""
APART = 1e3
"""Factor between the inertias of two variants up to which their dependent equations are the same: the limit of
dependence is far below the parts of independent ones, and rounding far below that."""
LEFT = 1e-6
"""Of the terms of a derivative of an equation: a tenth of what a consistent start may leave."""
ROUND = 1e-11
"""Largest residual of the constraints (m or rad), as in `assemble`."""


MOST = 64
"""Structures that are remembered, as many as patterns."""


class Alikes:
    """Assembles models of the structures that were assembled before: variants may choose one of several parts."""

    def __init__(self):
        self._known: list[Alike] = []
        self._noting = threading.Lock()

    def assembled(self, model: Model, t: float) -> tuple[System, State] | None:
        """Return what `assemble_as_drawn` returns, or None where no such model is known."""
        if not self._known:
            return None
        require_fit(model)
        system = compile(model)
        alike = next((one for one in self._known if one.same(system)), None)
        return None if alike is None else alike.assembled(system, t)

    def note(self, system: System) -> None:
        """Remember an assembled system, of which nothing had to be told."""
        with self._noting:
            if len(self._known) < MOST and not any(one.same(system) for one in self._known):
                self._known.append(Alike(system))


class Alike:
    """Assembles models of the structure of an assembled system.

    Parameters
    ----------
    system : System
        With its lengths and dependent equations known.
    """

    def __init__(self, system: System):
        self.system = system
        self.applies = not (
            len(system.program.floor)
            or system.implicit
            or system.nu + system.ng > SMALL
            or any(isinstance(kind, Formula) for _, kind in system.equation_owners)
            or np.any(system.program.equation_level)
        )
        if self.applies:
            self._find_places()

    def _find_places(self) -> None:
        """Find where the entries of the mass matrix and of the gradients stand among the stored values."""
        system = self.system
        self.mass, self.gradient = (
            (
                np.repeat(np.arange(rows), np.diff(system.tables[f"{name}_starts"])),
                system.tables[f"{name}_columns"],
                system.tables[f"{name}_at"],
            )
            for name, rows in (("mass", system.nu), ("gradient", system.ng))
        )
        lengths = described_lengths(system, np.zeros(system.nu), system.lengths.are_lengths)
        self.rigid = all(b.n_velocities == 6 * b.has_frame or b.n_velocities == 3 for b in system.model.bodies)
        self.sized = self.rigid and all(
            np.array_equal(getattr(lengths, name), getattr(system.lengths, name)) for name in lengths._fields
        )
        self.metric = self._metric()
        spans = [u for _, u in system.body_slices.values() if u.stop > u.start]
        sizes = sorted({u.stop - u.start for u in spans})
        self.blocks = [np.array([np.arange(u.start, u.stop) for u in spans if u.stop - u.start == n]) for n in sizes]

    def _metric(self) -> np.ndarray:
        """Return the diagonal of the mass matrix as drawn, (nu,)."""
        work = self.system.workspace()
        weigh_mass(work.weights)
        evaluate(self.system.program, self.system.state(), work)
        return np.diag(self._matrices(work.S)[0])

    def assembled(self, system: System, t: float) -> tuple[System, State] | None:
        """Return what `assemble_as_drawn` returns of a compiled model of this structure, or None where it may have
        something to say.
        """
        if not self.applies:
            return None
        model = system.model
        redundant, drawn_alike = bool(self.system.redundant), self._drawn_alike(system)
        work, state = system.workspace(), system.state(t)
        weigh_mass(work.weights)
        evaluate(system.program, state, work)
        M, G = self._matrices(work.S)
        if not (np.all(np.isfinite(M)) and np.all(np.isfinite(G)) and self._heavy(M)):
            return None
        if not (drawn_alike and self._masses_alike(M) if redundant else self._regular(M, G)):
            return None
        inertia, drawn, forces = np.abs(np.diag(M)), np.abs(work.equations["g"]), equations_of_forces(system, work)
        known = drawn_alike and self.sized and np.array_equal(self.system.lengths.are_lengths, forces)
        lengths = self.system.lengths if known else described_lengths(system, inertia, forces)
        warn_of_lost_digits(model, lengths)
        least = least_inertia(system)
        warn_of_needles(system, least)
        warn_of_stations(model)
        system = replace(
            system,
            lengths=lengths,
            units=velocity_units(system, lengths, inertia),
            least_inertia=least,
            gaps=np.zeros(system.ng),
        )
        closed = ROUND if redundant else CLOSED if self.rigid else MEETS
        if np.any(drawn > closed * lengths.equations) or misfits(model):
            return None
        if redundant:
            parts = constraint_matrix(system, work)
            system = softened(system, work, *parts, self.system.redundant, self.system.indeterminate)
        return self._begun(system, state, work)

    def _drawn_alike(self, system: System) -> bool:
        """Is a system drawn like this one, all of rigid bodies, and nothing in its joints differs?"""
        one, two = self.system, system
        first, last = (len(one.program.place), len(one.program.place) + len(one.program.equations))
        span = slice(one.program.starts[first], one.program.starts[last])
        return (
            self.rigid
            and one.prescribing.start == one.prescribing.stop
            and np.array_equal(one.q0, two.q0)
            and all(np.array_equal(one.tables["markers"][name], two.tables["markers"][name]) for name in "rR")
            and np.array_equal(one.program.raw[span], two.program.raw[span])
            and np.array_equal(one.program.bulk, two.program.bulk)
        )

    def _masses_alike(self, M: np.ndarray) -> bool:
        """Does the system have these inertias, but for a factor that no rank depends on?"""
        share = np.diag(M) / self.metric
        return bool(np.all((share > 1.0 / APART) & (share < APART)))

    def _begun(self, system: System, state: State, work) -> tuple[System, State] | None:
        """Return system and start on the constraints, with consistent velocities and accelerations."""
        right, bounds, drawn = np.zeros(system.nu + system.ng), system.bounds(ROUND), state.q.copy()
        if project(system.program, state, work, right, state.q, bounds, system.gaps, system.units, 60) < 0:
            return None
        fastest = np.abs(system.u0).max(initial=0.0)
        if fastest and np.any(np.abs(state.u - system.u0) > CLOSED * fastest):
            return None
        moved = np.zeros(system.nu)
        increment(system.program, drawn, state.q, moved)
        if system.redundant and np.any(np.abs(moved * system.units) > ROUND):
            return None
        open_rates = np.zeros(system.ng)
        constraint_velocity(work, state.u, open_rates)
        given = np.abs(work.equations["rate"])
        if np.any(np.abs(work.equations["g"]) > bounds):
            return None
        if accelerations(system.program, state, work, right, 12 if system.redundant else 2) >= 0:
            return None
        if system.implicit and not is_solved(system, state, right, work):
            return None
        drift, left = np.zeros((2, system.ng))
        constraint_acceleration(work, state.a, left)
        constraint_acceleration(work, np.zeros(system.nu), drift)
        if not (np.all(np.isfinite(state.a)) and np.all(np.isfinite(state.lam))):
            return None
        weigh_mass(work.weights)
        evaluate(system.program, state, work)
        M, G = self._matrices(work.S)
        if not (system.redundant or self._regular(M, G)):
            return None
        for rest, terms, motion in ((open_rates, given, state.u), (left, np.abs(drift), state.a)):
            if np.any(np.abs(rest) > LEFT * (terms + np.abs(G) @ np.abs(motion) + 1e-7 * system.lengths.equations)):
                return None
        no_matrix(work.weights)
        return system, state

    def same(self, system: System) -> bool:
        """Has a system the tables of this one, but for numbers?"""
        one, two = self.system, system
        return (
            one.program.pattern.order is two.program.pattern.order  # one structure, one pattern
            and one.equation_names == two.equation_names
            and one.body_slices == two.body_slices
            and np.array_equal(one.program.starts, two.program.starts)
            and all(
                np.array_equal(getattr(one.program, name), getattr(two.program, name))
                for name in ("place", "inertia", "energy", "equations", "forces", "equation_level")
            )
        )

    def _matrices(self, S: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the mass matrix (nu, nu) and the gradients (ng, nu) of the values evaluated last."""
        nu, ng = self.system.nu, self.system.ng
        M, G = np.zeros((nu, nu)), np.zeros((ng, nu))
        rows, columns, at = self.mass
        M[rows, columns] = S[at]
        rows, columns, at = self.gradient
        G[rows, columns] = S[at]
        return M, G

    def _heavy(self, M: np.ndarray) -> bool:
        """Has every freedom of every body inertia of its own?"""
        for own in self.blocks:
            parts = M[own[:, :, None], own[:, None, :]]
            diagonal = np.diagonal(parts, axis1=1, axis2=2)
            if not np.all(diagonal > 0.0):
                return False
            scale = 1.0 / np.sqrt(diagonal)
            scaled = parts * scale[:, :, None] * scale[:, None, :]
            if not np.linalg.svd(scaled, compute_uv=False)[:, -1].min() > HEAVY:
                return False
        return True

    def _regular(self, M: np.ndarray, G: np.ndarray) -> bool:
        """Are all gradients far from the span of the others, in the metric of the masses?"""
        if not len(G):
            return True
        A = G / np.sqrt(np.diag(M))
        norms = np.linalg.norm(A, axis=1)
        if not np.all(norms > 0.0) or len(G) > G.shape[1]:
            return False
        return bool(np.linalg.svd(A / norms[:, None], compute_uv=False)[-1] > REGULAR)
