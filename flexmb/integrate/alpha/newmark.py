"""The compiled step of the Lie-group generalized-alpha method, index 3 (Arnold & Brüls 2007; Brüls, Cardona & Arnold
2012): prediction, Newton iteration, error estimate, size of the next step by eq. (alpha-step). Theory: integrators.

Scaling: the equations of motion are multiplied by c = h^2 beta (1 - alpha_f) / (1 - alpha_m) and the multipliers are
solved for as c lam. The iteration matrix then is [M + (c gamma / (beta h)) D + c K, -G^T; G, 0], whose condition does
not grow as h goes to zero (Bottasso, Bauchau & Cardona 2007).
"""

from __future__ import annotations

import numpy as np

from flexmb.integrate.alpha.corrected import compare_reactions, follow, follow_anew, local_errors
from flexmb.integrate.alpha.increments import correct, move_to_end, solve_for_increment
from flexmb.integrate.alpha.jump import take_jump
from flexmb.integrate.alpha.powers import add_works, look_at_powers_anew, note_correction, settle_powers
from flexmb.integrate.alpha.step_size import (
    SHORT,
    TINY,
    back_to_step,
    fit_to_step,
    is_short,
    keep_rates,
    settle_short_step,
    write_sample,
)
from flexmb.integrate.alpha.variables import Controls, Motions
from flexmb.integrate.runs.kept_switches import JUMPED, SAME, keep_switches
from flexmb.integrate.runs.patience import PAUSED, UNCUT
from flexmb.integrate.runs.sample_rows import SampleRows
from flexmb.integrate.runs.spin_axes import error_of_axes, keep_axes
from flexmb.integrate.runs.switches import part_of_step
from flexmb.math.block_lu import lu_factor
from flexmb.math.energies import write_powers
from flexmb.math.kernel import entry_kernel, inner_kernel
from flexmb.math.plain_loops import copy_into
from flexmb.math.program import PROGRAM
from flexmb.math.structures import array_type, numba_type
from flexmb.math.tables import COUNT, FLOATS, WORK, State
from flexmb.math.weights import weigh
from flexmb.system.program import constraint_velocity, evaluate, keep_branches

__all__ = ["run_steps"]

STALLED, SINGULAR, TOO_SMALL = 1, 2, 3


@inner_kernel
def _predict(program, v, c, h):
    """Extrapolate acceleration and multipliers; write the end-of-step variables that follow from them."""
    ratio = h / v.run[0].last_step if v.run[0].last_step > 0.0 else 0.0
    ratio = min(ratio, 2.0)
    for i in range(len(v.u)):
        v.a1[i] = v.a[i] + ratio * (v.a[i] - v.a_last[i])
        v.alg1[i] = ((1.0 - c.alpha_f) * v.a1[i] + c.alpha_f * v.a[i] - c.alpha_m * v.alg[i]) / (1.0 - c.alpha_m)
        v.u1[i] = v.u[i] + h * ((1.0 - c.gamma) * v.alg[i] + c.gamma * v.alg1[i])
        v.dx[i] = h * v.u[i] + h * h * ((0.5 - c.beta) * v.alg[i] + c.beta * v.alg1[i])
    for i in range(len(v.lam)):
        v.lam1[i] = v.lam[i] + c.trend * ratio * (v.lam[i] - v.lam_last[i])
    move_to_end(program, v, h)


@inner_kernel
def _norm(v, d, tolerance):
    """Largest displacement of `d` relative to its tolerance; non-finite values are returned unchanged."""
    largest = 0.0
    for i in range(len(v.u)):
        x = abs(d[i]) * v.extent[i] / (tolerance * v.reach[i])
        if not np.isfinite(x):
            return x
        largest = max(largest, x)
    return largest


@inner_kernel
def _flips(program, v):
    """Does the correction turn a body by more than a radian?

    Long steps of a steady spin are exact, and their error says nothing against them, but from a bad prediction the
    iteration may end in another configuration: a shaft that points backwards through its sliding joint.
    """
    for n in range(len(program.frames)):
        k = program.frames[n, 1]
        for i in range(3, 6):
            if abs(v.right[k + i]) > 1.0:
                return True
    return False


@inner_kernel
def _shortened(v, size, before, share):
    """Shorten a correction that takes back most of the one before, and return by how much.

    A force that changes its sign within a small part of the step's change of velocity, friction about to stick, makes
    Newton's method jump from one side to the other and back: by halves it comes between. Corrections that do not
    alternate grow to their full length again.
    """
    alternates = 0.0
    if size > 0.5 * before:
        for i in range(len(v.u)):
            alternates += v.right[i] * v.d[i] * v.extent[i] * v.extent[i]
    share = 0.5 * share if alternates < 0.0 else min(1.0, 2.0 * share)
    if share < 1.0:
        for i in range(len(v.right)):
            v.right[i] *= share
    return share


@inner_kernel
def _scale_states(v, c, h):
    """Make increments of the integrals of first-order states comparable: as the changes of the states they mean."""
    for i in range(v.run[0].first_state, len(v.u)):
        v.extent[i] = c.gamma / (c.beta * h)


@inner_kernel
def _accelerations_settled(v, c, scale, left):
    """Is what is left of the correction, as acceleration, a small part of the accelerations?

    In a step much shorter than its error allows, a displacement within tolerance still is a large acceleration, and the
    multipliers would be noise.
    """
    largest, correction = 0.0, 0.0
    for i in range(v.run[0].first_state):
        largest = max(largest, abs(v.a1[i]) * v.extent[i])
        correction = max(correction, abs(v.d[i]) * v.extent[i])
    return left * correction <= max(c.settled * largest * scale, v.run[0].rounding)


@inner_kernel
def _note_end(work, v, c, h, iteration):
    """Note what an iteration that has converged leaves: powers, its error, and how far its rate is trusted."""
    write_powers(work.energy, v.powers)
    v.powers[1] = 0.0  # of the drives: with the corrected multipliers
    for i in range(len(v.lam)):
        v.powers[1] -= v.lam1[i] * work.equations[i].rate
    note_correction(v, c, h, iteration + 1)
    if iteration == 0:
        # trusted once more, but less and less until it is measured again
        v.run[0].convergence = min(1.5 * v.run[0].convergence, 0.05)


@inner_kernel
def _iterate(program, work, v, c, h):
    """Solve the step by Newton's method; the matrix is kept while it converges fast. Return 0 or why it fails."""
    scale = h * h * c.beta * (1.0 - c.alpha_f) / (1.0 - c.alpha_m)
    weigh(work.weights, 1.0, scale * c.gamma / (c.beta * h), scale, 0.5 * h, world_axes=1 if len(v.world) > 0 else 0)
    size, rate, share = 0.0, v.run[0].convergence, 1.0
    fresh = True
    for iteration in range(c.iterations):
        renewed = fresh
        work.weights[0].wanted = 1 if fresh else 0
        evaluate(program, State(v.run[0].t + h, v.q1, v.body_u, v.body_a, v.lam1, v.signals), work)
        v.run[0].iterations += 1
        if fresh:
            v.run[0].factorisations += 1
            if lu_factor(work.S, program.pattern) >= 0:
                return SINGULAR
        solve_for_increment(program, work, v, c, h, scale)
        before = size
        size = _norm(v, v.right, c.tolerance)
        if not np.isfinite(size) or size > 1e12 or _flips(program, v):
            return STALLED
        if iteration > 0:
            share = _shortened(v, size, before, share)
        correct(program, v, c, h, scale)
        if iteration > 0 and before > 0.0:
            rate = size / before
            if rate > 1.5 and iteration > 2 and size > c.newton:
                return STALLED
            rate = min(max(rate, 1e-6), 0.99)
            if iteration == 1:
                v.run[0].convergence = max(rate, 1e-4)
        # what is left after this correction is about rate / (1 - rate) of it
        left = rate / (1.0 - rate)
        # in a singular position rounding shows in the accelerations: a fresh matrix gains nothing there
        rounding = renewed and iteration > 1 and rate > 0.3 and size <= c.newton
        settled = (
            size * left <= c.newton and (iteration > 0 or size <= 1.0) and _accelerations_settled(v, c, scale, left)
        )
        if (rounding or settled) and share == 1.0:
            _note_end(work, v, c, h, iteration)
            return 0
        fresh = rate > 0.2
    return STALLED


@inner_kernel
def _step_error(program, v, c, h):
    """Estimate the local error of the positions relative to the tolerance.

    Taylor expansion of the update with the algorithmic acceleration of time t + (alpha_m - alpha_f) h gives
    ``e = (beta + (alpha_m - alpha_f) / 2 - 1/6) h^2 (a1 - a)`` (Géradin & Cardona 2001, ch. 11). The same expansion of
    the update of first-order states gives eq. (alpha-state-error): with d = alpha_m - alpha_f,
    ``e = (1/12 - d^2 / 2 + d (alpha_m + alpha_f - 1) / 2) h^3 d3x/dt3``.
    """
    bodies = v.run[0].first_state
    factor = abs(c.beta + 0.5 * (c.alpha_m - c.alpha_f) - 1.0 / 6.0) * h * h
    for i in range(bodies):
        v.d[i] = factor * (v.a1[i] - v.a[i])
    early, before = c.alpha_m - c.alpha_f, v.run[0].last_step
    factor = 1.0 / 12.0 - 0.5 * early * early + 0.5 * early * (c.alpha_m + c.alpha_f - 1.0)
    for i in range(bodies, len(v.u)):
        curvature = 2.0 * ((v.a1[i] - v.a[i]) / h - (v.a[i] - v.a_last[i]) / before) / (h + before)
        v.d[i] = factor * h * h * h * curvature / v.extent[i]
    whole = _norm(v, v.d, c.tolerance)
    of_axes = error_of_axes(
        program.frames, v.axes, v.q1, v.u1, v.a1, v.d, v.extent, v.reach, c.tolerance, c.of_axes, h, v.run[0].span
    )
    return max(whole, of_axes**1.5)  # relative to the motion of an axis in the step: of second order


@inner_kernel
def _largest_growth(v, c, error):
    """Return by how much the next step may be longer.

    Oscillations that the steps do not resolve change their sign in every step and are damped by rho_inf, but what
    `fit_to_step` carries over grows with the step. Where they show, a step grows by less than they decay.
    """
    if error <= 1e-6 or c.alpha_f == 0.0:
        return 2.0
    product, size, before = 0.0, 0.0, 0.0
    for i in range(v.run[0].first_state):
        now, last = (v.a1[i] - v.a[i]) * v.extent[i], (v.a[i] - v.a_last[i]) * v.extent[i]
        product += now * last
        size += now * now
        before += last * last
    if product > -0.5 * (size * before) ** 0.5:
        return 2.0
    rho = c.alpha_f / (1.0 - c.alpha_f)
    return min(2.0, 0.5 + 0.5 / rho)


@inner_kernel
def _begin_anew(v):
    """Forget the rate of the acceleration: a contact has begun or ended.

    What the algorithmic acceleration keeps of it alternates, halves with every step at rho_inf = 0.8 and grows with the
    step size: while steps grow after an impact it would not go away, and change the speed of the rebound.
    """
    for i in range(len(v.a)):
        v.alg[i] = v.a[i]
        v.slope[i] = 0.0
        v.a_last[i] = v.a[i]
    for i in range(len(v.lam)):
        v.lam_last[i] = v.lam[i]
    look_at_powers_anew(v)


@inner_kernel
def _accept(program, work, v, c, h, planned, powers):
    """Make the end of the step the start of the next."""
    constraint_velocity(work, v.body_u, v.hidden)
    settle_powers(program, work, v, h)
    add_works(v, h, powers)
    if keep_rates(v, c, h, planned):
        copy_into(v.powers_last, powers)
    for k in range(len(v.pace)):
        v.pace[k] = (work.branches[k] - v.q[program.branches + k]) / h
    for i in range(len(v.q)):
        v.q[i] = v.q1[i]
    for i in range(len(v.u)):
        v.u[i] = v.u1[i]
        v.a[i] = v.a1[i]
        v.alg[i] = v.alg1[i]
    for i in range(len(v.lam)):
        v.lam[i] = v.lam1[i]
    keep_branches(program, work, v.q)
    for n in range(len(program.vectors)):
        if program.vectors[n, 3] != 1:  # positions in W: how far the origin is says nothing about a tolerance
            continue
        # tolerances of flexible coordinates are relative to the largest displacement they have reached
        iq, iu, size = program.vectors[n, 0], program.vectors[n, 1], program.vectors[n, 2]
        largest = 0.0
        for i in range(size):
            largest = max(largest, abs(v.q[iq + i]) * v.extent[iu + i])
        for i in range(size):
            v.reach[iu + i] = max(v.reach[iu + i], largest)
    for i in range(v.run[0].first_state, len(v.u)):
        v.reach[i] = max(v.reach[i], abs(v.u[i]))
    v.run[0].steps += 1


@inner_kernel
def _take_back(v, h, failure, part, error, powers):
    """Go back to where a step began that failed, goes past a change of a contact, or errs by too much; plan a shorter
    one."""
    back_to_step(v)
    for i in range(3):
        v.powers[i] = powers[i]
    if failure != 0:
        v.run[0].rejected_by_iteration += 1
        v.run[0].next_step = 0.25 * h
    elif part < 1.0:
        v.run[0].cut_at_contacts += 1
        v.run[0].next_step = part * h
    else:
        v.run[0].rejected_by_error += 1
        v.run[0].next_step = h * max(0.2, 0.85 * error ** (-1.0 / 3.0))


@inner_kernel
def _solved(program, work, v, c, h, planned):
    """Solve a step from its prediction; return if it is a short one, see `is_short`, and 0 or why it fails."""
    short, failure = is_short(v, c, h, planned), 0
    if not (short and h < TINY * planned and settle_short_step(program, work, v, c, h)):
        failure = _iterate(program, work, v, c, h)
        if short and failure == 0:
            settle_short_step(program, work, v, c, h)
    return short, failure


@inner_kernel
def _plan(v, c, h, planned, short, error, most, part):
    """Plan the size of the next step, from that of the one that was accepted."""
    if c.adaptive:
        growth = min(most, 0.85 * max(error, 1e-6) ** (-1.0 / 3.0))
        if growth < 1.0 or growth > 1.15 or growth == most:
            v.run[0].next_step = h * growth if growth < 1.0 else max(v.run[0].next_step, h * growth)
        v.run[0].next_step = min(v.run[0].next_step, max(part, 1.0) * h) if part < 2.0 else v.run[0].next_step
    else:
        v.run[0].next_step = v.run[0].longest_step
    if h < SHORT * planned and not short:
        v.run[0].next_step = min(v.run[0].next_step, h / SHORT)


@entry_kernel(
    PROGRAM,
    WORK,
    numba_type(Motions),
    numba_type(Controls),
    array_type(FLOATS),
    *[COUNT] * 3,
    numba_type(SampleRows),
)
def run_steps(program, work, motions, c, samples, first, last, trials, rows):
    """Integrate through samples[first:last], writing each to the output rows; return (next sample, reason).

    After so many `trials` of a step, the reason is PAUSED: called again from the next sample, it goes on.

    The steps are fitted to end exactly at the samples, so every sample is a solution of the step equations.
    """
    v = motions.own
    powers, tried = np.empty(3), 0
    for k in range(first, last):
        span = samples[k] - samples[k - 1] if k > 0 else samples[k] - v.run[0].t
        while samples[k] - v.run[0].t > 1e-12 * max(abs(samples[k]), span):
            if tried >= trials:
                return k, PAUSED
            tried += 1
            left = samples[k] - v.run[0].t
            planned = min(v.run[0].next_step, v.run[0].longest_step)
            h = left / max(1.0, np.ceil(left / planned * (1.0 - 1e-9)))
            fit_to_step(program, work, v, h)
            _scale_states(v, c, h)
            for i in range(3):
                powers[i] = v.powers[i]
            _predict(program, v, c, h)
            short, failure = _solved(program, work, v, c, h, planned)
            error = 0.0
            part = 2.0
            if failure == 0:
                error = _step_error(program, v, c, h) if c.adaptive else 0.0
                if not error > 1.0 and len(v.switching.now) > 0 and h > UNCUT * c.smallest:
                    state = State(v.run[0].t + h, v.q1, v.body_u, v.body_a, v.lam1, v.signals)
                    part = part_of_step(program, v.switching, state, work, h, c.adaptive)
            if failure != 0 or error > 1.0 or part < 1.0:
                _take_back(v, h, failure, part, error, powers)
                if v.run[0].next_step < c.smallest:
                    return k, failure if failure != 0 else TOO_SMALL
                continue
            now = samples[k] if left - h <= 1e-12 * left else v.run[0].t + h
            most = min(part, _largest_growth(v, c, error))
            if c.adaptive:
                keep_axes(program.frames, v.axes, v.u1, h)
            local_errors(program, work, motions, c, h)
            _accept(program, work, v, c, h, planned, powers)
            changed = keep_switches(v.switching, h) if len(v.switching.now) > 0 else SAME
            follow(program, work, motions, c, h, now, short)
            if changed == JUMPED:  # what a step across it tells of accelerations is rounding divided by its size
                take_jump(program, work, motions, max(c.sweeps, 2))
            if changed != SAME:
                _begin_anew(v)
                follow_anew(motions)
            v.run[0].t = now
            _plan(v, c, h, planned, short, error, most, part)
        n = k - first
        rows.t[n] = v.run[0].t
        copy_into(rows.q[n], v.q)
        write_sample(program, work, v, c, rows.u[n], rows.a[n], rows.lam[n])
        copy_into(rows.works[n], v.works)
        compare_reactions(program, work, motions, c, rows.lam[n])
    return last, 0
