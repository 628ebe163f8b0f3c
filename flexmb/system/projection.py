"""`project`: a state on its constraints, with least motion."""

from __future__ import annotations

import numpy as np

from flexmb.math.block_lu import lu_factor
from flexmb.math.block_substitution import lu_solve
from flexmb.math.kernel import inner_kernel, kernel
from flexmb.math.weights import weigh
from flexmb.system.accelerations import EXACT
from flexmb.system.program import advance, constraint_velocity, evaluate, keep_branches

__all__ = ["project"]


@inner_kernel
def _hold_shape(program, work):
    """Make deformation expensive in the metric of `project`: bodies are moved together, and bent only if they must."""
    for n in range(len(program.vectors)):
        iu, size, flexible = program.vectors[n, 1], program.vectors[n, 2], program.vectors[n, 3]
        if flexible == 1:
            for i in range(size):
                work.S[work.rows[iu + i] + 6 + i] *= 1e6


@inner_kernel
def _of_velocities(program):
    """Is there an equation at velocity level?"""
    found = False
    for level in program.equation_level:
        found = found or level == 1
    return found


@kernel
def project(program, state, work, right, q, bounds, gaps, units, iterations):
    """Move q with least motion (in the metric of M, without deformation where that is possible) onto g = 0, then u
    onto G u + dg/dt = 0; q belongs to state.

    Equations are satisfied to `bounds` (ng,). Where they depend on each other they may contradict each other by up to
    `gaps` (ng,), and the nearest q is taken. `units` (nu,) makes steps comparable: a displacement relative to the
    length of the assembly, or rad. Returns the number of iterations, or -1 if they do not converge, or -2 if the matrix
    is singular.
    """
    nu, ng = len(state.u), len(state.lam)
    weigh(work.weights, 1.0)
    state.lam[:] = 0.0
    state.a[:] = 0.0
    done = -1
    stride = np.inf
    for iteration in range(iterations):
        evaluate(program, state, work)
        largest, closed = 0.0, True
        for i in range(ng):
            right[nu + i] = -work.equations[i].g if program.equation_level[i] == 0 else 0.0
            largest = max(largest, abs(right[nu + i]) / bounds[i])
            closed = closed and abs(right[nu + i]) <= max(gaps[i], bounds[i])
        if not np.isfinite(largest):
            return -1
        keep_branches(program, work, q)
        _hold_shape(program, work)
        if lu_factor(work.S, program.pattern) >= 0:
            return -2
        at_rest = len(program.pattern.softness) > 0 and stride <= EXACT
        if (largest <= 1.0 and iteration > 0) or at_rest:
            done = iteration if closed else -1
            break
        right[:nu] = 0.0
        lu_solve(work.S, program.pattern, right)
        scale = 1.0
        stride = 0.0
        for i in range(nu):
            stride = max(stride, abs(right[i]) * units[i])
        if stride > 0.5:  # of the assembly, or rad: a longer one would leave the branch of the drawing
            scale = 0.5 / stride
        advance(program, q.copy(), right[:nu], scale, q)
    for turn in range(12):  # two, unless dependent equations, which are regularised, leave more
        constraint_velocity(work, state.u, right[nu:])
        largest = 0.0
        for i in range(ng):
            right[nu + i] = -right[nu + i]
            largest = max(largest, abs(right[nu + i]) / bounds[i])
        if turn > 1 and largest <= 1.0:
            break
        right[:nu] = 0.0
        lu_solve(work.S, program.pattern, right)
        for i in range(nu):
            state.u[i] += right[i]
        if _of_velocities(program):  # they need not be linear in the velocities
            evaluate(program, state, work)
            _hold_shape(program, work)
            if lu_factor(work.S, program.pattern) >= 0:
                return -2
    return done
