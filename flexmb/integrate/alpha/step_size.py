"""What belongs to the size of a step: algorithmic acceleration and rate of the constraints, and samples, which are
steps of size zero. Theory: integrators.
"""

from __future__ import annotations

import numpy as np

from flexmb.integrate.alpha.world_translation import to_body_axes, turn
from flexmb.math.block_lu import lu_solve
from flexmb.math.kernel import kernel
from flexmb.math.tables import State
from flexmb.system.accelerations import accelerations, corrected_accelerations

__all__ = ["back_to_step", "change_of_velocities", "fit_to_step", "write_sample"]


@kernel
def change_of_velocities(program, work, v, share):
    """Write the change of the velocities that adds a share of itself to the rate of the constraints."""
    largest = 0.0
    for i in range(len(v.u)):
        v.change[i] = 0.0
        v.right[i] = 0.0
    for i in range(len(v.lam)):
        change = share * v.hidden[i] if program.equation_level[i] == 0 else 0.0
        v.right[len(v.u) + i] = change
        largest = max(largest, abs(change))
    if largest > 0.0:
        lu_solve(work.S, program.pattern, v.right)
        for i in range(len(v.u)):
            v.change[i] = v.right[i]
        turn(v.world, v.q, v.change)


@kernel
def fit_to_step(program, work, v, h):
    """Move what belongs to the step size, algorithmic acceleration and rate of the constraints, to a new one.

    The algorithmic acceleration belongs to time t + (alpha_m - alpha_f) h. Positions that satisfy the constraints leave
    velocities which violate them by C h^2 G a'; kept at that value of the step before, the multipliers would carry an
    error of first order through the next steps (Arnold, Brüls & Cardona 2015).
    """
    ratio = h / v.run[0].last_step
    change_of_velocities(program, work, v, ratio * ratio - 1.0)
    for i in range(len(v.u)):
        v.alg[i] = v.a[i] + (v.alg[i] - v.a[i]) * ratio
        v.u[i] += v.change[i]


@kernel
def back_to_step(v, h):
    """Undo `fit_to_step` after a step that failed."""
    for i in range(len(v.u)):
        v.alg[i] = v.a[i] + (v.alg[i] - v.a[i]) * v.run[0].last_step / h
        v.u[i] -= v.change[i]


@kernel
def write_sample(program, work, v, c, u, a, lam):
    """Write velocities, accelerations and multipliers of a sample.

    The velocities belong to a step of size zero, so they satisfy the constraints. Accelerations and multipliers
    solve M a - G^T lam = f, G a = -drift at its q and u: the step's own have errors C h^2 a'', and swing for some steps
    after a contact begins or ends.

    Friction that reads reactions is taken at the step's own velocity. Where a joint is stuck it is so steep in the
    velocity that C h^2 G a' more of it would change the force.
    """
    change_of_velocities(program, work, v, -1.0)
    for i in range(len(u)):
        v.d[i] = v.u[i] + v.change[i]
    to_body_axes(v.world, v.q, v.d, v.a, u, a)
    lam[:] = v.lam
    if c.sweeps == 0:
        return
    if c.friction:
        to_body_axes(v.world, v.q, v.u, v.a, v.body_u, v.body_a)
        state = State(v.run[0].t, v.q, v.body_u, v.body_a, lam, v.signals)
        found = corrected_accelerations(program, state, work, v.right)
        a[:] = v.body_a
    else:
        state = State(v.run[0].t, v.q, u, a, lam, v.signals)
        found = accelerations(program, state, work, v.right, c.sweeps) < 0
    if not found or not np.all(np.isfinite(a)) or not np.all(np.isfinite(lam)):
        to_body_axes(v.world, v.q, v.d, v.a, u, a)
        lam[:] = v.lam
