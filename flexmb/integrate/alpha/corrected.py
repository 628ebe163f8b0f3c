"""A second motion beside the run's, without the local errors that are known: how far the two are apart is what the
errors have added up to, with all growth on the way.

It takes the steps of the run, with the local errors of displacement and velocity taken off, and are solved with the
matrix of the run by one correction: one evaluation more in a step. Theory: integrators.
"""

from __future__ import annotations

import numpy as np

from flexmb.integrate.alpha.increments import correct, move_to_end, solve_for_increment
from flexmb.integrate.alpha.step_size import fit_to_step, keep_rates, write_sample
from flexmb.integrate.alpha.variables import Apart, Controls, Motions, Variables
from flexmb.integrate.alpha.world_translation import to_body_axes, turn
from flexmb.integrate.runs.gap import EVERY, measure
from flexmb.integrate.runs.reaction_errors import add_difference
from flexmb.math.block_lu import lu_factor
from flexmb.math.block_substitution import lu_solve
from flexmb.math.kernel import entry_kernel, inner_kernel
from flexmb.math.kernel_on_demand import kernel_on_demand
from flexmb.math.program import PROGRAM
from flexmb.math.structures import numba_type
from flexmb.math.tables import CHOICE, NUMBER, WORK, State, void
from flexmb.system.program import constraint_acceleration, constraint_velocity, evaluate, keep_branches

__all__ = ["compare_reactions", "follow", "follow_anew", "local_errors"]

CORRECTIONS, ENOUGH = 6, 0.1
"""Corrections of a step at most, and what they may leave, relative to the tolerance of a step."""
MEASURED, FADES = 1e-3, 0.7
"""Correction, relative to that tolerance, above which a second one tells their rate; part of a rate that counts the
next time."""
SELDOM = 16
"""Steps from one look at that rate to the next."""
LONGER = 1.1
"""Growth of a step from which on what lies across the constraints is taken out at once."""


@entry_kernel(PROGRAM, WORK, numba_type(Motions), numba_type(Controls), NUMBER)
def local_errors(program, work, motions, c, h):
    """Write the local errors of a step, before it is accepted: what its end has too much.

    With d = alpha_m - alpha_f, the increment has (beta + d / 2 - 1/6) h^3 a' and the velocity
    (1/12 + d alpha_m - d / 2 - d^2) h^3 a''. A frame whose increments are in its own axes also misses the commutator
    of its velocity with its acceleration, (h^3 / 12) [nu, nu'] (Magnus 1954).
    """
    v, apart = motions.own, motions.apart
    if apart.run[0].followed == 0:
        return
    early, before = c.alpha_m - c.alpha_f, v.run[0].last_step
    of_place = (c.beta + 0.5 * early - 1.0 / 6.0) * h * h
    of_speed = (1.0 / 12.0 + early * c.alpha_m - 0.5 * early - early * early) * h * h * h
    s = motions.corrected
    now, then, last, q, u = v.a, v.a1, v.a_last, v.q, v.u
    dq, du, da, dx, rest, near_q, near_u = apart.q, apart.u, apart.a, apart.dx, apart.du, s.q, s.u
    for i in range(len(q)):
        dq[i] = near_q[i] - q[i]
    for i in range(len(u)):
        du[i] = near_u[i] - u[i]
        da[i] = s.a[i] - now[i]
        change, change_before = then[i] - now[i], now[i] - last[i]
        dx[i] = of_place * change
        bend = 2.0 * (change / h - change_before / before) / (h + before)
        rest[i] = of_speed * bend if change_before != 0.0 else 0.0
    third, known = h * h * h / 12.0, 0
    for n in range(len(program.frames)):
        iu = program.frames[n, 1]
        world = known < len(v.world) and v.world[known, 1] == iu
        known += 1 if world else 0
        for i in range(3):
            j, k = (i + 1) % 3, (i + 2) % 3
            wj, wk = 0.5 * (v.u[iu + 3 + j] + v.u1[iu + 3 + j]), 0.5 * (v.u[iu + 3 + k] + v.u1[iu + 3 + k])
            bj, bk = 0.5 * (v.a[iu + 3 + j] + v.a1[iu + 3 + j]), 0.5 * (v.a[iu + 3 + k] + v.a1[iu + 3 + k])
            apart.dx[iu + 3 + i] -= third * (wj * bk - wk * bj)
            if world:
                continue
            vj, vk = 0.5 * (v.u[iu + j] + v.u1[iu + j]), 0.5 * (v.u[iu + k] + v.u1[iu + k])
            aj, ak = 0.5 * (v.a[iu + j] + v.a1[iu + j]), 0.5 * (v.a[iu + k] + v.a1[iu + k])
            apart.dx[iu + i] -= third * (wj * ak - wk * aj + vj * bk - vk * bj)
    if _straightens(s, h):
        _second_rates(work, v, apart, apart.second, apart.early)
        for n in range(len(v.lam)):
            apart.early[n] -= apart.second[n]


@inner_kernel
def _straightens(s, h):
    """Is it time to bring the motion beside back along the constraints: now and then, and where steps get longer?"""
    return len(s.lam) > 0 and (s.run[0].steps % SELDOM == 0 or h > LONGER * s.run[0].last_step)


@inner_kernel
def _second_rates(work, v, apart, second, early):
    """Write the second rates (ng,) of the constraints at the end of a step, with both kinds of accelerations."""
    constraint_acceleration(work, v.body_a, second)
    to_body_axes(v.world, v.q1, v.u1, v.alg1, apart.x, apart.y)
    constraint_acceleration(work, apart.y, early)


@inner_kernel
def _add_rates(program, work, s, apart, rates, x):
    """Change `x` (nu,), velocities or accelerations, by what gives the constraints so much more of a rate (ng,)."""
    nu = len(x)
    for i in range(nu):
        s.right[i] = 0.0
    for n in range(len(rates)):
        s.right[nu + n] = rates[n]
    lu_solve(work.S, program.pattern, s.right)
    for i in range(nu):
        if not np.isfinite(s.right[i]):
            return
        apart.x[i] = s.right[i]
    turn(s.world, s.q1, apart.x)
    for i in range(nu):
        x[i] += apart.x[i]


@inner_kernel
def _along_constraints(program, work, s, apart):
    """Let velocities and accelerations of the motion beside satisfy the constraints, at the end of a step.

    What a step leaves across them swings from step to step and grows where steps get longer. The run limits its steps
    by that; beside it, it would grow by ten in six steps, and is no error of the motion. The algorithmic
    acceleration belongs to another time, and lies ahead by as much as the run's.
    """
    _second_rates(work, s, apart, apart.second, apart.earlier)
    for n in range(len(s.lam)):
        s.hidden[n] = -s.hidden[n]
        apart.second[n] = -apart.second[n]
        apart.earlier[n] = apart.early[n] - apart.earlier[n]
    _add_rates(program, work, s, apart, s.hidden, s.u1)
    _add_rates(program, work, s, apart, apart.second, s.a1)
    _add_rates(program, work, s, apart, apart.earlier, s.alg1)
    s.hidden[:] = 0.0


@entry_kernel(PROGRAM, WORK, numba_type(Motions), numba_type(Controls), NUMBER, NUMBER, CHOICE)
def follow(program, work, motions, c, h, t, short):
    """Take the step that has just been accepted, to time t, once more without its local errors.

    A step too short to tell a rate keeps the distance.
    """
    v, s, apart = motions.own, motions.corrected, motions.apart
    if apart.run[0].followed == 0:
        return
    nu, ng = len(v.u), len(v.lam)
    touched = len(v.switching.now) > 0 and v.switching.limits[0].closed == 1
    if touched:
        apart.run[0].blind, apart.run[0].followed = 1, 0
        return
    if short:
        _carry(v, s, apart, True)
        return
    fit_to_step(program, work, s, h)
    a, a1, alg, alg1, u, u1, dx = s.a, s.a1, s.alg, s.alg1, s.u, s.u1, s.dx
    after, before, too_far, too_fast = v.a, v.a_last, apart.dx, apart.du
    for i in range(nu):
        a1[i] = a[i] + after[i] - before[i]
        alg1[i] = ((1.0 - c.alpha_f) * a1[i] + c.alpha_f * a[i] - c.alpha_m * alg[i]) / (1.0 - c.alpha_m)
        u1[i] = u[i] + h * ((1.0 - c.gamma) * alg[i] + c.gamma * alg1[i]) - too_fast[i]
        dx[i] = h * u[i] + h * h * ((0.5 - c.beta) * alg[i] + c.beta * alg1[i]) - too_far[i]
    for i in range(ng):
        s.lam1[i] = s.lam[i] + v.lam[i] - v.lam_last[i]
    move_to_end(program, s, h)
    if _solved(program, work, s, c, h, t, v.run[0].convergence):
        constraint_velocity(work, s.body_u, s.hidden)
        if _straightens(s, h):
            _along_constraints(program, work, s, apart)
        keep_rates(s, c, h, h)
        for i in range(len(s.q)):
            s.q[i] = s.q1[i]
        for i in range(nu):
            s.u[i], s.a[i], s.alg[i] = s.u1[i], s.a1[i], s.alg1[i]
        for i in range(ng):
            s.lam[i] = s.lam1[i]
        keep_branches(program, work, s.q)
    else:
        s.run[0].rejected_by_iteration += 1
        _carry(v, s, apart, False)
    s.run[0].steps += 1
    if s.run[0].steps % EVERY == 0:
        measure(program, v.q, s.q, v.extent, apart.run, apart.q_start, t)


@inner_kernel
def compare_reactions(program, work, motions, c, lam):
    """Compare multipliers `lam` (ng,) of a sample with those that the motion without local errors has there.

    Both follow from places and velocities: those of the steps themselves swing. The factors are left as a sample leaves
    them. Samples that lie closer than some steps are passed over.
    """
    v, s, apart = motions.own, motions.corrected, motions.apart
    if apart.run[0].followed == 0 or c.sweeps == 0 or s.run[0].steps < s.run[0].compared + EVERY:
        return
    s.run[0].compared = s.run[0].steps
    s.run[0].t = v.run[0].t
    write_sample(program, work, s, c, s.u1, s.a1, s.lam1)
    add_difference(lam, s.lam1, apart.reactions)


@kernel_on_demand(void, numba_type(Variables), numba_type(Variables), numba_type(Apart), CHOICE)
def _carry(v, s, apart, with_rates):
    """Take the distance of the motions over a step as it was; of the accelerations too, or none."""
    for i in range(len(v.q)):
        s.q[i] = v.q[i] + apart.q[i]
    for i in range(len(v.u)):
        s.u[i], s.slope[i] = v.u[i] + apart.u[i], v.slope[i]
        s.a[i] = v.a[i] + (apart.a[i] if with_rates else 0.0)
        s.alg[i] = v.alg[i] + (apart.a[i] if with_rates else 0.0)
    for i in range(len(v.lam)):
        s.lam[i], s.hidden[i], s.curve[i] = v.lam[i], v.hidden[i], v.curve[i]
    s.run[0].last_step, s.run[0].short = v.run[0].last_step, v.run[0].short


@inner_kernel
def _solved(program, work, s, c, h, t, rate):
    """Solve a step, by one correction with the matrix of the run if that does, else by Newton's method; return if it
    converges.

    The matrix is that of another motion: how well it does follows from second corrections, now and then. The rate at
    which the run itself converges is no measure where a thin beam is bent otherwise: what is left along it would grow.
    """
    nu = len(s.u)
    scale = h * h * c.beta * (1.0 - c.alpha_f) / (1.0 - c.alpha_m)
    before = np.inf
    for k in range(CORRECTIONS):
        work.weights[0].wanted = 1 if k > 1 else 0
        evaluate(program, State(t, s.q1, s.body_u, s.body_a, s.lam1, s.signals), work)
        if k > 1 and lu_factor(work.S, program.pattern) >= 0:
            return False
        solve_for_increment(program, work, s, c, h, scale)
        size = 0.0
        for i in range(nu):
            size = max(size, abs(s.right[i]) * s.extent[i] / (c.tolerance * s.reach[i]))
            if not np.isfinite(s.right[i]):
                return False
        if k > 2 and size > before:
            return False
        correct(program, s, c, h, scale)
        if k == 0:
            left = max(rate, s.run[0].convergence)
            measured = s.run[0].steps % SELDOM == 1 and size > MEASURED
        else:
            left, measured = min(1.0, size / before), False
            if k == 1 and before > MEASURED:
                s.run[0].convergence = max(left, FADES * s.run[0].convergence)
        # what is left after this correction is about its rate times it
        if size * left < ENOUGH and not measured:
            return True
        before = size
    return False


@inner_kernel
def follow_anew(motions):
    """Forget the rate of the acceleration, as the run does where a contact has begun or ended."""
    s = motions.corrected
    for i in range(len(s.a)):
        s.alg[i] = s.a[i]
        s.slope[i] = 0.0
