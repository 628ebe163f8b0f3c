"""The second motion beside a run of implicit Runge-Kutta steps, without the local errors that are known.

It is carried as its distance from the run, in the unknowns of the tree. A step takes it on by the trapezoidal rule in
two halves, from the start over the second stage, which lies in the middle, to the end: the matrix of the stages is that
of such halves, so each costs one evaluation and no factorisation. Theory: integrators.
"""

from __future__ import annotations

import numpy as np

from flexmb.integrate.implicit.beside import Beside
from flexmb.integrate.implicit.local_errors import SEEN, keep_rates, take_off_errors
from flexmb.integrate.implicit.stages import GAMMA, STAGES, Stages
from flexmb.integrate.implicit.straighten import straightened
from flexmb.integrate.runs.gap import EVERY, measure
from flexmb.integrate.runs.reaction_errors import add_difference
from flexmb.math.block_substitution import lu_solve
from flexmb.math.jets import sample_signals
from flexmb.math.kernel import entry_kernel, inner_kernel
from flexmb.math.program import PROGRAM
from flexmb.math.structures import array_type, numba_type
from flexmb.math.tables import COUNT, FLOATS, NUMBER, WORK, State
from flexmb.system.program import constraint_acceleration, constraint_velocity, evaluate
from flexmb.tree.coordinates.settle import Chart, coordinate_rates, count_turns, prescribe, read_change, settle
from flexmb.tree.coordinates.settle import unit_length as to_unit_length

__all__ = ["follow"]

TURNS = 3
"""Corrections of coordinates whose rates depend on them."""
GROWTH = 5.0
"""Growth of the distance in a step from which on it is not known: what grows by itself grows by less in steps that
follow it. Where a mechanism passes close to a dead centre, one correction does not find the motion beside."""
SLIGHT = 0.01
"""Share of the motion below which the distance may do so: steps that begin to grow, loops that are closed."""


@inner_kernel
def _place(chart, program, work, b, t):
    """Write the state of all bodies of the motion beside, drives as they are at time t."""
    if len(chart.driven) > 0:
        sample_signals(t, chart.signals, chart.sampled)
        prescribe(chart.driven, chart.sampled, b.x, b.v, b.a)
    b.y[:] = b.x
    to_unit_length(chart.rows, b.y)
    state = State(t, b.state.q, b.state.u, b.state.a, b.lam, b.state.signals)
    settle(chart.rows, program, work, chart.start, b.y, b.v, b.a, state)
    count_turns(chart, program, t, b.y, state.q)


@inner_kernel
def _turned(chart, b, x1, v1, k1, shift):
    """Write the motion beside, and its distance dx1, where rates have come to be b.dv1 away; x1' = k1 of the run."""
    b.dx1[:] = b.dx
    for i in range(len(v1)):
        b.v[i] = v1[i] + b.dv1[i]
    for _ in range(TURNS):
        for i in range(len(x1)):
            b.x[i] = x1[i] + b.dx1[i]
        coordinate_rates(chart.rows, b.x, b.v, b.k)
        for i in range(len(x1)):
            b.k[i] -= k1[i]
            b.dx1[i] = b.dx[i] + shift * (b.dk[i] + b.k[i])
    for i in range(len(x1)):
        b.x[i] = x1[i] + b.dx1[i]


@inner_kernel
def _solve(chart, program, work, b):
    """Write the change of second rates that b.right asks for; return if it is one."""
    lu_solve(work.S, program.pattern, b.right)
    for i in range(len(b.right)):
        if not np.isfinite(b.right[i]):
            return False
    read_change(chart.rows, work, b.right, b.change)
    for n in range(len(chart.driven)):
        b.change[chart.driven[n, 1]] = 0.0
    return True


@inner_kernel
def _close(chart, program, work, b):
    """Put the motion beside back on its loops, by the residuals of the latest evaluation; return if it can."""
    nu, nx = len(b.state.u), len(b.x)
    b.right[:nu] = 0.0
    for n in range(len(b.lam)):
        b.right[nu + n] = -work.equations[n].g if program.equation_level[n] == 0 else 0.0
    if not _solve(chart, program, work, b):
        return False
    coordinate_rates(chart.rows, b.x, b.change, b.x)
    for i in range(nx):
        b.dx1[i] += b.x[i]
    b.right[:nu] = 0.0
    constraint_velocity(work, b.state.u, b.right[nu:])
    for n in range(len(b.lam)):
        b.right[nu + n] = -b.right[nu + n]
    if not _solve(chart, program, work, b):
        return False
    for i in range(len(b.v)):
        b.dv1[i] += b.change[i]
    return True


@inner_kernel
def _half(chart, program, work, b, x1, v1, a1, lam1, k1, t, shift, closed):
    """Take the distance over half a step, to where the run has x1, v1, a1, lam1 and x1' = k1; return if it can.

    Newton's method on the equations of motion, one step of it: the distance is small.
    """
    nu = len(b.state.u)
    for i in range(len(v1)):
        b.dv1[i] = b.dv[i] + 2.0 * shift * b.da[i]
        b.a[i] = a1[i] + b.da[i]
    for i in range(len(lam1)):
        b.lam[i] = lam1[i] + b.dlam[i]
    _turned(chart, b, x1, v1, k1, shift)
    _place(chart, program, work, b, t)
    state = State(t, b.state.q, b.state.u, b.state.a, b.lam, b.state.signals)
    work.weights[0].wanted = 0
    evaluate(program, state, work)
    for i in range(nu):
        b.right[i] = -work.residual[i]
    constraint_acceleration(work, state.a, b.right[nu:])
    for i in range(len(lam1)):
        b.right[nu + i] = -b.right[nu + i]
    if not _solve(chart, program, work, b):
        return False
    for i in range(len(v1)):
        b.dv1[i] += shift * b.change[i]
        b.da[i] += b.change[i]
    for i in range(len(lam1)):
        b.dlam[i] += b.right[nu + i]
    _turned(chart, b, x1, v1, k1, shift)
    if closed and not _close(chart, program, work, b):
        return False
    b.dx[:] = b.dx1
    b.dv[:] = b.dv1
    b.dk[:] = b.k
    return True


@inner_kernel
def _bent(b, sign):
    """Add the present derivatives of the distance, times a number, to how much they bend."""
    for i in range(len(b.dx)):
        b.kx[i] += sign * b.dk[i]
    for i in range(len(b.dv)):
        b.kv[i] += sign * b.da[i]


@inner_kernel
def _hold(b):
    """Forget all rates of the distance, which stays as it is."""
    b.own[0].bent, b.own[0].bent_before = 0.0, 0.0
    b.da[:] = 0.0
    b.dlam[:] = 0.0


@inner_kernel
def _grows_wildly(b, h, spread, wide):
    """Return if the distance grows within a step by more than steps resolve: from what it was at the start, with the
    error of the step before, and of late (squares).
    """
    before, now, fast_before, fast = 0.0, 0.0, 0.0, 0.0
    for i in range(b.own[0].moving):
        fast_before += b.v0[i] ** 2
        fast += b.dv[i] ** 2
    for i in range(len(b.dx) - len(b.dv) + b.own[0].moving):
        before += b.x0[i] ** 2
        now += b.dx[i] ** 2
    return now + h * h * fast > GROWTH**2 * (max(before, spread) + h * h * max(fast_before, wide))


@inner_kernel
def _grows(b, t):
    """Keep how much the distance has grown by itself, if it is the largest until now."""
    if not (b.run[0].far_t == t or b.run[0].wide_t == t):
        return
    far, fast, own = 0.0, 0.0, b.own[0]
    for i in range(len(b.dx) - len(b.dv) + own.moving):
        far += b.dx[i] ** 2
    for i in range(own.moving):
        fast += b.dv[i] ** 2
    if own.given_v > 0.0:
        drifts = own.given_x + own.elapsed * own.given_v
        b.own[0].grown = min(far**0.5 / drifts, fast**0.5 / own.given_v)


@entry_kernel(
    numba_type(Chart),
    PROGRAM,
    WORK,
    numba_type(Stages),
    numba_type(Beside),
    *[array_type(FLOATS)] * 2,
    *[NUMBER] * 2,
    array_type(FLOATS, 2),
    array_type(FLOATS),
    COUNT,
)
def follow(chart, program, work, r, b, x, v, t, h, weights, third, touched):
    """Take the motion beside over the step from x, v at time t that has just been solved, with its matrix.

    It ends where something touches: the motion beside touches at another time, and what comes of that is not known.
    """
    if b.run[0].followed == 0:
        return
    b.own[0].steps += 1
    for n in range(len(chart.driven)):
        b.dx[chart.driven[n, 0]] = 0.0
    if touched == 1:
        b.run[0].blind, b.run[0].followed = 1, 0
        return
    shift, end, spread, wide = GAMMA * h, STAGES - 1, b.own[0].spread, b.own[0].wide
    b.x0[:], b.v0[:], b.a0[:] = b.dx, b.dv, b.da
    b.x1[:] = x + b.dx
    b.v[:] = v + b.dv
    coordinate_rates(chart.rows, b.x1, b.v, b.dk)
    for i in range(len(x)):
        b.dk[i] -= r.K[0, i]
        b.x1[i] = x[i] + shift * (r.K[0, i] + r.K[1, i])
    b.kx[:] = 0.0
    b.kv[:] = 0.0
    _bent(b, -1.0)
    closes = b.own[0].closes == 1
    done = _half(chart, program, work, b, b.x1, r.V[1], r.A[1], r.L[1], r.K[1], t + 2.0 * shift, shift, False)
    _bent(b, 2.0)
    done = done and _half(chart, program, work, b, r.x, r.V[end], r.A[end], r.L[end], r.K[end], t + h, shift, closes)
    _bent(b, -1.0)
    if not done or not straightened(b, h):
        b.own[0].stiff += 1
        b.dx[:], b.dv[:] = b.x0, b.v0
        _hold(b)
        keep_rates(r, b, h)
        return
    if b.own[0].steps > SEEN and _grows_wildly(b, h, spread, wide):
        measure(program, r.state.q, b.state.q, r.extent, b.run, b.start, t + h)
        if b.run[0].far > SLIGHT * b.run[0].moved or b.run[0].wide > SLIGHT * b.run[0].turned:
            b.own[0].wild, b.run[0].followed = 1, 0
            return
    b.own[0].elapsed += h
    if b.own[0].steps % EVERY == 0:
        measure(program, r.state.q, b.state.q, r.extent, b.run, b.start, t + h)
        _grows(b, t + h)
        for i in range(len(b.lam)):
            b.lam[i] = r.L[end, i] + b.dlam[i]
        add_difference(r.L[end], b.lam, b.reactions)
    take_off_errors(r, b, h, weights, third)
    keep_rates(r, b, h)
