"""What belongs to the size of a step: algorithmic acceleration and rate of the constraints, and samples, which are
steps of size zero. The size itself is chosen in `newmark.run_steps`. Theory: integrators.
"""

from __future__ import annotations

from flexmb.integrate.alpha.variables import Controls, Variables
from flexmb.integrate.alpha.world_translation import to_body_axes, to_world_axes, turn
from flexmb.math.block_substitution import lu_solve
from flexmb.math.energies import write_powers
from flexmb.math.kernel import entry_kernel, inner_kernel
from flexmb.math.kernel_on_demand import kernel_on_demand
from flexmb.math.plain_loops import all_finite, copy_into
from flexmb.math.program import PROGRAM
from flexmb.math.structures import array_type, numba_type
from flexmb.math.tables import CHOICE, FLOATS, NUMBER, WORK, State
from flexmb.system.accelerations import accelerations, corrected_accelerations
from flexmb.system.program import evaluate

__all__ = [
    "SHORT",
    "TINY",
    "back_to_step",
    "change_of_velocities",
    "fit_to_step",
    "is_short",
    "keep_rates",
    "settle_short_step",
    "write_sample",
]

SHORT, TINY = 0.1, 1e-4
"""Steps below these parts of the planned one, before a time that must be met, tell no rates, and need no iteration."""
EQUAL = 1e-9
"""Steps that differ by less, relative to them, differ by the rounding of the times between which they lie."""


@inner_kernel
def change_of_velocities(program, work, v, h):
    """Write the change of the velocities that gives the constraints the rate which a step of the size h leaves."""
    largest = 0.0
    for i in range(len(v.u)):
        v.change[i] = 0.0
        v.right[i] = 0.0
    for i in range(len(v.lam)):
        change = h * h * v.curve[i] - v.hidden[i] if program.equation_level[i] == 0 else 0.0
        v.right[len(v.u) + i] = change
        largest = max(largest, abs(change))
    if largest > 0.0:
        lu_solve(work.S, program.pattern, v.right)
        if not all_finite(v.right):  # factors of a trial beyond the end of an equation: velocities stay
            return
        for i in range(len(v.u)):
            v.change[i] = v.right[i]
        turn(v.world, v.q, v.change)


@entry_kernel(PROGRAM, WORK, numba_type(Variables), NUMBER)
def fit_to_step(program, work, v, h):
    """Move what belongs to the step size, algorithmic acceleration and rate of the constraints, to a new one.

    The algorithmic acceleration belongs to time t + (alpha_m - alpha_f) h. Positions that satisfy the constraints leave
    velocities which violate them by C h^2 G a'; kept at that value of the step before, the multipliers would carry an
    error of first order through the next steps (Arnold, Brüls & Cardona 2015).
    """
    if abs(h - v.run[0].last_step) <= EQUAL * h and v.run[0].short == 0.0:
        v.change[:] = 0.0
    else:
        change_of_velocities(program, work, v, h)
    for i in range(len(v.u)):
        v.alg[i] = v.a[i] + v.slope[i] * h
        v.u[i] += v.change[i]


@inner_kernel
def back_to_step(v):
    """Undo `fit_to_step` after a step that failed."""
    for i in range(len(v.u)):
        v.u[i] -= v.change[i]


@inner_kernel
def is_short(v, c, h, planned):
    """Is a step much shorter than planned, to a sample or a kink just ahead?

    The rates that it tells are rounding divided by its size. Those of the step before hold on, until such steps make up
    half of its size. Where one follows another of its size, as over a pulse, and accelerations stand out of rounding,
    it tells rates and plans the next steps: rates of the time before the pulse would leave an error of first order.
    """
    if h >= SHORT * planned or v.run[0].short + h > 0.5 * v.run[0].last_step:
        return False
    largest = 0.0
    for i in range(v.run[0].first_state):
        largest = max(largest, abs(v.a[i]) * v.extent[i])
    noise = h < TINY * planned and c.settled * c.beta * h * h * largest <= v.run[0].rounding
    return noise or h < SHORT * v.run[0].size


@kernel_on_demand(CHOICE, PROGRAM, WORK, numba_type(Variables), numba_type(Controls), NUMBER)
def settle_short_step(program, work, v, c, h):
    """Solve for accelerations and multipliers at the end of a short step: its own are the rounding of positions
    divided by the square of its size. Where there is no solution they stay as they are; return if there is.
    """
    a, lam = v.body_a.copy(), v.lam1.copy()
    state = State(v.run[0].t + h, v.q1, v.body_u, a, lam, v.signals)
    if c.friction:
        found = corrected_accelerations(program, state, work, v.right)
    else:
        found = accelerations(program, state, work, v.right, max(c.sweeps, 2)) < 0
    found = found and all_finite(a) and all_finite(lam)
    if found:
        copy_into(v.body_a, a)
        copy_into(v.lam1, lam)
        copy_into(v.a1, a)
        copy_into(v.d, v.body_u)
        to_world_axes(v.world, v.q1, v.d, v.a1)
        for i in range(len(v.a1)):
            v.alg1[i] = v.a1[i] + v.slope[i] * h
    work.weights[0].wanted = 0
    evaluate(program, State(v.run[0].t + h, v.q1, v.body_u, v.body_a, v.lam1, v.signals), work)
    write_powers(work.energy, v.powers)
    v.run[0].rough = 0
    return found


@inner_kernel
def keep_rates(v, c, h, planned):
    """Keep what an accepted step tells of rates, before its end becomes the start of the next; return if it does."""
    tells = not is_short(v, c, h, planned)
    for i in range(len(v.u)):
        if tells:
            v.slope[i] = (v.alg1[i] - v.a1[i]) / h
            v.a_last[i] = v.a[i]
    for i in range(len(v.lam)):
        if tells:
            v.curve[i] = v.hidden[i] / (h * h)
            v.lam_last[i] = v.lam[i]
    v.run[0].last_step = h if tells else v.run[0].last_step + h
    v.run[0].short = 0.0 if tells else v.run[0].short + h
    v.run[0].size = h
    return tells


@entry_kernel(PROGRAM, WORK, numba_type(Variables), numba_type(Controls), *[array_type(FLOATS)] * 3)
def write_sample(program, work, v, c, u, a, lam):
    """Write velocities, accelerations and multipliers of a sample.

    The velocities belong to a step of size zero, so they satisfy the constraints. Accelerations and multipliers
    solve M a - G^T lam = f, G a = -drift at its q and u: the step's own have errors C h^2 a'', and swing for some steps
    after a contact begins or ends.

    Friction that reads reactions is taken at the step's own velocity. Where a joint is stuck it is so steep in the
    velocity that C h^2 G a' more of it would change the force.
    """
    change_of_velocities(program, work, v, 0.0)
    for i in range(len(u)):
        v.d[i] = v.u[i] + v.change[i]
    to_body_axes(v.world, v.q, v.d, v.a, u, a)
    copy_into(lam, v.lam)
    if c.sweeps == 0:
        return
    if c.friction:
        to_body_axes(v.world, v.q, v.u, v.a, v.body_u, v.body_a)
        state = State(v.run[0].t, v.q, v.body_u, v.body_a, lam, v.signals)
        found = corrected_accelerations(program, state, work, v.right)
        copy_into(a, v.body_a)
    else:
        state = State(v.run[0].t, v.q, u, a, lam, v.signals)
        found = accelerations(program, state, work, v.right, c.sweeps) < 0
    if not (found and all_finite(a) and all_finite(lam)):
        to_body_axes(v.world, v.q, v.d, v.a, u, a)
        copy_into(lam, v.lam)
