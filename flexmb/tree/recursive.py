"""`Recursive`: accelerations by the O(n) recursion over the joint tree, loops by multipliers of the cut joints."""

from __future__ import annotations

import threading
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np

from flexmb.errors import CompileError, ModelError
from flexmb.math.found_once import found_once
from flexmb.math.kernel import kernel
from flexmb.math.weights import weigh
from flexmb.model.described import Described
from flexmb.system.accelerations import solved_accelerations
from flexmb.system.damped_accelerations import unsolved
from flexmb.system.program import constraint_acceleration, evaluate
from flexmb.tree.any_body.articulated import factor
from flexmb.tree.any_body.light_points import LightPoints
from flexmb.tree.any_body.loops import add_loads, are_open, closer, mobilities, responses, stress_basis
from flexmb.tree.any_body.passes import joint_multipliers, solve
from flexmb.tree.any_body.store import new_store
from flexmb.tree.coordinates.unknowns import RelativeUnknowns
from flexmb.tree.spanning import Spanning, spanning_tree

__all__ = ["Recursive"]

EXACT = 1e-12
"""What is left of the cut equations, relative to what there was, that is rounding."""
CLOSED = 4
"""Most solutions for their multipliers."""
TURNS = 200
"""Iterations of friction by joint reactions, at most; each gains at least the factor of a coefficient of friction."""
REFINED = 5
"""Refinements of a solution with modes, at most; each gains as many digits as the elimination has left."""
SMALL = 1e-6
"""A refinement that is so small a part of the accelerations is the last one: the next would be its square."""


@found_once
def _storages(tree: Spanning) -> threading.local:
    """Return what has the scratch of a tree, one per thread, like a workspace: large arrays are costly to make anew."""
    return threading.local()


def _storage(tree: Spanning):
    """Return the scratch of a tree in this thread."""
    own = _storages(tree)
    if not hasattr(own, "store"):
        own.store = new_store(tree.tables)
    return own.store


@kernel
def _solve_all(tables, store, force, weight, a):
    for tree in range(len(tables.trees) - 1):
        solve(tables, store, tree, force, weight, a)


@dataclass(frozen=True)
class Recursive(metaclass=Described):
    """The recursive solution of linear cost (Banerjee 1993; rigid bodies: the articulated-body algorithm).

    Trees cost the same per body whatever their number. Loops are opened at cut joints; their multipliers follow from
    the closure of the loops (Banerjee 1993, eq. 81), with least norm where equations depend on each other. Where forces
    follow accelerations, they come from the sparse factorisation of all bodies instead; the joint coordinates stay the
    unknowns. Theory: recursive.

    Parameters
    ----------
    cut : tuple of str
        Joints (or drives) to cut; by default the choice that leaves the fewest closing equations.
    """

    cut: tuple[str, ...] = ()

    compiled: ClassVar[bool] = False
    closed: ClassVar[bool] = False

    def __post_init__(self):
        if not isinstance(self.cut, list | tuple) or not all(isinstance(name, str) for name in self.cut):
            raise ModelError(
                "Recursive",
                found=f"cut = {self.cut!r}",
                expected="names of joints",
                remedy='Write cut=("A", "B"), or cut=("A",) for one',
            )
        object.__setattr__(self, "cut", tuple(self.cut))

    def tree(self, system) -> Spanning:
        """Return the spanning tree of a system."""
        return spanning_tree(system, self.cut)

    def unknowns(self, system, state, work) -> RelativeUnknowns:
        """Return the joint coordinates, as what an integrator solves for from a consistent state on."""
        return RelativeUnknowns(system, state, work, self.cut)

    def accelerate(self, system, state, work) -> tuple[np.ndarray, np.ndarray]:
        """Return accelerations (nu,) and multipliers (ng,) at a state; its own are ignored.

        Raises
        ------
        CompileError
            If a free motion has no inertia, or equations of one joint depend on each other.
        """
        tree = self.tree(system)
        if system.implicit:
            return _factorised(system, state, work)
        store = _storage(tree)
        own = state._replace(a=np.zeros(system.nu), lam=np.zeros(system.ng))
        weigh(work.weights, 1.0, constrained=0)
        evaluate(system.program, own, work)
        factor(tree.tables, own, work, store)
        if store.failed[0] >= 0:
            raise _failure(tree, int(store.failed[0]), int(store.failed[1]))
        closure = _Closure(tree.tables, work, store, system)
        force = -work.residual
        a, lam = closure.solve(force.copy())
        at = system.program.floor_at[:, 0]
        floor = np.where(np.isin(at, closure.points.velocities), 0.0, system.program.floor)
        for _ in range(2 if np.any(floor) else 0):  # the inertia lent to massless bodies is given back
            corrected = force.copy()
            corrected[at] += floor * a[at]
            a, lam = closure.solve(corrected)
        rubs = any(force.reads_reactions for force in system.model.forces)
        if tree.tables.i_eta[-1] > 0 and not rubs:
            a, lam = closure.refined(own, a, lam)
        if closure.is_open(a):  # masses that differ by so much that no digit is left
            found = solved_accelerations(system, state, work)
            if found is None:
                raise _left_open(tree)
            return found
        if rubs:
            a, lam = _with_friction(system, own, work, closure, a, lam, (at, floor))
        return a, lam


class _Closure:
    """The factorised tree with its closing equations, at one state."""

    def __init__(self, tables, work, store, system):
        self.tables, self.work, self.store, self.system = tables, work, store, system
        self.values, self.mobility = np.zeros(len(tables.rows)), np.zeros(len(tables.cut_equations))
        if len(tables.cut_equations):
            mobilities(work, tables.cut_equations, system.least_inertia, self.mobility)
        self.points = LightPoints(tables, work, store, system, self.mobility)
        if len(tables.cut_equations):
            responses(tables, work, store, np.zeros(system.nu), np.zeros(system.nu), self.values)

    def is_open(self, a) -> bool:
        """Do the accelerations (nu,) leave a closing equation unsatisfied?"""
        equations = self.tables.cut_equations
        return bool(len(equations) and are_open(self.work, equations, self.mobility, a))

    def refined(self, own, a, lam) -> tuple[np.ndarray, np.ndarray]:
        """Return accelerations and multipliers without what the elimination of modes has rounded.

        A marker whose joint lets it move has little inertia where the modes move it: it is what is left of the body's,
        digits of which cancel. What the solution leaves of the equations of motion is solved for once more.
        """
        self.work.weights[0].wanted = 0
        for _ in range(REFINED):
            evaluate(self.system.program, own._replace(a=a, lam=lam), self.work)
            more, stress = self.solve(-self.work.residual, a)
            a, lam = a + more, lam + stress
            if not np.max(np.abs(more), initial=0.0) > SMALL * np.max(np.abs(a), initial=0.0):
                break
        return a, lam

    def solve(self, force, base=None) -> tuple[np.ndarray, np.ndarray]:
        """Return accelerations and multipliers at generalised forces (nu,), which are overwritten.

        With accelerations `base` (nu,), which the joints of the tree allow, return what forces add to them.
        """
        tables, work, store = self.tables, self.work, self.store
        a, lam = np.zeros(self.system.nu), np.zeros(self.system.ng)
        weight = 1.0 if base is None else 0.0
        _solve_all(tables, store, force, weight, a)

        def add(cut):
            lam[tables.cut_equations] += cut
            add_loads(work, tables.cut_equations, cut, force)
            _solve_all(tables, store, force, weight, a)

        points, left = self.points, self._left(a, base)
        if len(points.mass):
            moved, cut = self._closer[0](left, force[points.velocities])
            add(cut)
            a[points.velocities] = moved
        elif len(left):
            first = np.abs(left).max()
            for _ in range(CLOSED):  # once is enough but for masses that differ by many orders
                add(self._closer[0](left))
                left, last = self._left(a, base), np.abs(left).max()
                if not EXACT * first < np.abs(left).max() < 0.1 * last:
                    break
        joint_multipliers(tables, store, lam)
        if len(tables.cut_equations) and self._closer[1].shape[1]:
            scale = np.sqrt(self.system.multiplier_weights)
            lam -= self._stresses @ (self._stresses.T @ (scale * lam)) / scale
        return a, lam

    def _left(self, a, base) -> np.ndarray:
        """Return what accelerations, with those that they are added to, leave of the cut equations (nc,)."""
        error = np.zeros(self.system.ng)
        constraint_acceleration(self.work, a if base is None else a + base, error)
        return error[self.tables.cut_equations]

    @cached_property
    def _closer(self):
        """What finds the multipliers of the cut equations, and their self-stresses."""
        if len(self.points.mass):
            return self.points.closer(self.values, self.tables)
        return closer(self.tables, self.values, self.mobility)

    @cached_property
    def _stresses(self):
        """The self-stresses of all joints, see `stress_basis`."""
        weights = self.system.multiplier_weights
        return stress_basis(self.tables, self.work, self.store, self._closer[1], weights, self.system.nu)


def _with_friction(system, own, work, closure, a, lam, lent):
    """Return accelerations and multipliers when forces depend on the multipliers, by fixed-point iteration.

    `lent` are the velocities with a lent inertia, and that inertia, which is given back with the accelerations before.
    """
    at, floor = lent
    work.weights[0].wanted = 0
    everything = np.arange(system.ng)
    for _ in range(TURNS):
        before = lam
        own.lam[:] = before
        evaluate(system.program, own, work)
        force = -work.residual
        add_loads(work, everything, -before, force)
        force[at] += floor * a[at]
        a, lam = closure.solve(force)
        if np.max(np.abs(lam - before), initial=0.0) <= 1e-12 * np.max(np.abs(lam), initial=1e-9):
            return a, lam
    raise CompileError(
        "Recursive",
        found=f"friction by joint reactions does not converge in {TURNS} iterations",
        expected="joints that friction does not jam",
        remedy="Use Augmented(), or a smaller coefficient of friction",
    )


def _factorised(system, state, work) -> tuple[np.ndarray, np.ndarray]:
    """Return accelerations and multipliers where forces follow accelerations.

    The mass matrix then joins bodies that no joint joins, and is not symmetric: no recursion over the tree solves it.
    """
    found = solved_accelerations(system, state, work)
    if found is None:
        raise unsolved(system, "Recursive")
    return found


def _left_open(tree: Spanning) -> CompileError:
    """Return the error about loops that stay open."""
    return CompileError(
        "Recursive",
        found=f"accelerations that do not close the loops of {', '.join(tree.cut)}",
        expected="masses whose ratio leaves digits, some 1e10",
        remedy="Use Augmented(), or cut other joints: Recursive(cut=(...,))",
    )


def _failure(tree: Spanning, place: int, reason: int) -> CompileError:
    name = tree.order[place]
    joint = f" (joint '{tree.joints[name]}')" if name in tree.joints else ""
    if reason == 2:
        return CompileError(
            f"Joint '{tree.joints[name]}'",
            found="its equations, with its drives, are dependent",
            expected="independent equations in the joint that carries a body",
            remedy=f"Remove a drive, or cut it: Recursive(cut=(...,)), the tree goes on to '{name}'",
        )
    return CompileError(
        f"Body '{name}'{joint}",
        found="its articulated inertia is singular",
        expected="inertia, its own or carried, in every free motion of its joint",
        remedy="Give the body mass and inertia about the free axis, or cut another joint",
    )
