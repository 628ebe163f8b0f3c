"""`Recursive`: accelerations by the O(n) recursion over the joint tree, loops by multipliers of the cut joints."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from scipy.linalg import lstsq

from flexmb.errors import CompileError
from flexmb.math.kernel import kernel
from flexmb.system.program import constraint_acceleration, evaluate
from flexmb.tree.recursion import factor, joint_multipliers, new_store, solve
from flexmb.tree.spanning import Spanning, spanning_tree

__all__ = ["Recursive"]


@kernel
def _unit_load(work, equation, out):
    """Write the generalised force of a unit multiplier, L[:, equation], to `out` (nu,)."""
    out[:] = 0.0
    row = work.equations[equation]
    for n in range(row.leg, row.leg + row.legs):
        leg = work.legs[n]
        marker = work.markers[leg.marker]
        nu = marker.nu
        for k in range(6):
            x = leg.gradient[k]
            for j in range(nu):
                out[marker.iu + j] += x * work.J[marker.iJ + k * nu + j]
                if marker.iH >= 0:
                    out[marker.iu + j] -= x * work.H[marker.iH + k * nu + j]


@kernel
def _row_products(work, equations, a, out):
    """Write G[equations] a to `out`."""
    for e in range(len(equations)):
        row = work.equations[equations[e]]
        s = 0.0
        for n in range(row.leg, row.leg + row.legs):
            leg = work.legs[n]
            marker = work.markers[leg.marker]
            for k in range(6):
                x = leg.gradient[k]
                if x != 0.0:
                    for j in range(marker.nu):
                        s += x * work.J[marker.iJ + k * marker.nu + j] * a[marker.iu + j]
        out[e] = s


@kernel
def _responses(tables, work, store, right, accelerations, matrix):
    """Write the accelerations of unit multipliers of the cut equations, and what they do to those equations."""
    for n in range(len(tables.cut_equations)):
        _unit_load(work, tables.cut_equations[n], right)
        solve(tables, work, store, right, 0.0, accelerations[n])
        _row_products(work, tables.cut_equations, accelerations[n], matrix[:, n])


@dataclass(frozen=True)
class Recursive:
    """The recursive solution of linear cost (Banerjee 1993; rigid bodies: the articulated-body algorithm).

    Trees cost the same per body whatever their number. Loops are opened at cut joints; their multipliers follow from the
    closure of the loops (Banerjee 1993, eq. 81), with least norm where the closing equations depend on each other.

    Parameters
    ----------
    cut : tuple of str
        Joints that shall be cut; by default those that leave the fewest closing equations.
    """

    cut: tuple[str, ...] = ()
    _trees: dict = field(default_factory=dict, init=False, repr=False, compare=False)

    def tree(self, system) -> Spanning:
        """Return the spanning tree of a system (found once)."""
        known = self._trees.get(id(system.program.raw))
        if known is None or known[0] is not system.program.raw:
            self._trees.clear()
            self._trees[id(system.program.raw)] = known = (system.program.raw, spanning_tree(system, self.cut))
        return known[1]

    def accelerate(self, system, state, work) -> tuple[np.ndarray, np.ndarray]:
        """Return accelerations (nu,) and multipliers (ng,) at a state."""
        tree = self.tree(system)
        tables, store = tree.tables, new_store(tree.tables, system.nu)
        state.a[:], state.lam[:] = 0.0, 0.0
        work.coefficients[:] = (1.0, 0.0, 0.0, 1.0, 0.0)
        evaluate(system.program, state, work)
        factor(tables, work, store)
        if store.failed[0] >= 0:
            name = tree.order[int(store.failed[0])]
            raise CompileError(f"Body '{name}'", found="its articulated inertia is singular",
                               expected="inertia in every free motion of its joint",
                               remedy="Give the body mass and inertia about the free axis, or another cut joint")
        a, lam = np.zeros(system.nu), np.zeros(system.ng)
        force = -work.residual.copy()
        solve(tables, work, store, force, 1.0, a)
        nc = len(tables.cut_equations)
        if nc:
            accelerations, matrix = np.zeros((nc, system.nu)), np.zeros((nc, nc))
            _responses(tables, work, store, np.zeros(system.nu), accelerations, matrix)
            error = np.zeros(system.ng)
            constraint_acceleration(work, a, error)
            cut = lstsq(matrix, -error[tables.cut_equations], cond=1e-11)[0]
            lam[tables.cut_equations] = cut
            load = np.zeros(system.nu)
            for n, equation in enumerate(tables.cut_equations):
                _unit_load(work, equation, load)
                force += cut[n] * load
            solve(tables, work, store, force, 1.0, a)
        joint_multipliers(tables, store, lam)
        return a, lam
