"""The second motion beside a run of implicit Runge-Kutta steps, without the local errors that are known.

It is carried as its distance from the run, in the unknowns of the tree. A step takes it on by the trapezoidal rule in
two halves, from the start over the second stage, which lies in the middle, to the end: the matrix of the stages is that
of such halves, so each costs one evaluation and no factorisation. Theory: integrators.
"""

from __future__ import annotations

from typing import Annotated, NamedTuple

import numpy as np

from flexmb.integrate.implicit.stages import GAMMA, STAGES, WEIGHTS, Stages
from flexmb.integrate.runs.gap import EVERY, Gap, begin_again, measure, new_gap
from flexmb.math.block_lu import lu_solve
from flexmb.math.jets import sample_signals
from flexmb.math.kernel import entry_kernel, inner_kernel
from flexmb.math.program import PROGRAM
from flexmb.math.structures import ArrayOf, Floats, Record, array_type, numba_type, structure
from flexmb.math.tables import COUNT, FLOATS, NUMBER, WORK, State
from flexmb.system.program import constraint_acceleration, constraint_velocity, evaluate
from flexmb.tree.coordinates.settle import Chart, coordinate_rates, count_turns, prescribe, read_change, settle
from flexmb.tree.coordinates.settle import unit_length as to_unit_length

__all__ = ["Beside", "carry", "follow", "known", "new_beside"]

LINEAR = -8.463541666666567e-4
"""Error of a step of y' = f(y) by h^5 times the fifth derivative of y, for linear f."""


def _fifth() -> np.ndarray:
    """Return the weights (6,) by which the rates of the stages give h^4 times the fifth derivative of y in one step.

    The stages of y' = z y are those of (I - z A)^-1: powers of z up to three cancel and the fourth is one; and so do
    third powers of time in rates that are given. There are as many weights as these conditions.
    """
    rows = [np.ones(STAGES)]
    for _ in range(4):
        rows.append(WEIGHTS @ rows[-1])
    rows.append(rows[1] ** 3)
    return np.linalg.solve(rows, [0.0, 0.0, 0.0, 0.0, 1.0, 0.0])


ALONE = _fifth()
BESIDE = (3.6, 4.7, 8.0)
"""Error of order five beside what the embedded method differs by: of a vibration by 1.2 and by 2 radians a step, and of
one that steps do not follow."""
COARSE = 4.0
"""By how much the error is larger than that of linear equations at two radians a step: a heavy top errs 1.0 times as
much at 1.2 radians, 1.7 at 1.4, 4.1 at 2."""
FADES = 0.9
"""Part of the size of a step that still counts a step later: what swings passes zero."""
SEEN = 3
"""Steps after which that size is known."""
STRAIGHT = 0.1
"""Largest correction of the trapezoidal rule, relative to the distance."""
STIFF, MANY = 1.0, 0.1
"""The same from which the distance swings or dies away too fast to be carried, and the part of the steps that may."""
TURNS = 3
"""Corrections of coordinates whose rates depend on them."""


class BesideRun(Record):
    """How the motion beside goes on."""

    bent: float
    """s, size of the step before; 0 where there was none to compare how the distance bends with"""
    size: float
    """square of what the embedded method differed by in the rates, the largest of late"""
    wide: float
    """square of the distance in the rates, likewise"""
    stiff: int
    """steps over which the distance could not be carried"""
    closes: int
    """1: there are loops to be closed"""
    steps: int
    moving: int
    """rates before those of first-order states, whose numbers have units of their own"""


@structure
class Beside(NamedTuple):
    """The distance of the second motion from the run's, at the present time."""

    dx: Floats
    """(nx,) of the unknowns"""
    dv: Floats
    """(nv,) of their rates"""
    da: Floats
    """(nv,) of their second rates"""
    dlam: Floats
    """(ng,) of the multipliers"""
    dk: Floats
    """(nx,) of the first derivatives of the unknowns"""
    bx: Floats
    """(nx,) by how much the first derivatives of dx bend over a step, by the square of its size, the step before"""
    bv: Floats
    """(nv,) of dv, likewise"""
    kx: Floats
    """(nx,) the same of the step at hand"""
    kv: Floats
    x: Floats
    """the motion beside, as the next"""
    v: Floats
    a: Floats
    lam: Floats
    y: Floats
    """(nx,) x with unit Euler parameters"""
    k: Floats
    """(nx,) scratch, as the next four"""
    x0: Floats
    v0: Floats
    """(nv,)"""
    x1: Floats
    dx1: Floats
    dv1: Floats
    change: Floats
    """(nv,)"""
    right: Floats
    """(nu + ng,) right-hand side"""
    state: State
    """of all bodies"""
    start: Floats
    """(nq,) configuration from which motion is counted"""
    own: Annotated[np.ndarray, ArrayOf(BesideRun.dtype)]
    """one row"""
    run: Annotated[np.ndarray, ArrayOf(Gap.dtype)]
    """one row"""


def new_beside(system, unknowns, state, followed: bool) -> Beside:
    """Return the motion beside at the start of a run, where it still is the same."""
    nx, nv, nu, ng = unknowns.nx, unknowns.nv, system.nu, system.ng
    sizes = dict.fromkeys(("dx", "dk", "bx", "kx", "x", "y", "k", "x0", "x1", "dx1"), nx)
    sizes |= dict.fromkeys(("dv", "da", "bv", "kv", "v", "a", "v0", "dv1", "change"), nv)
    sizes |= {"dlam": ng, "lam": ng, "right": nu + ng}
    return Beside(
        **{name: np.zeros(size) for name, size in sizes.items()},
        state=system.state(state.t),
        start=state.q.copy(),
        own=BesideRun.table(closes=int(unknowns.closes and ng > 0), moving=nv - int(np.sum(system.is_state))),
        run=new_gap(system, followed),
    )


def carry(before: Beside, now: Beside) -> None:
    """Give a new start the distance that the motions had; in a model with other unknowns its size alone is known."""
    closes, moving = int(now.own["closes"][0]), int(now.own["moving"][0])
    now.own[:] = before.own
    now.own["closes"], now.own["moving"] = closes, moving
    now.run[:] = before.run
    sizes = ("dx", "dv", "dlam", "start")  # a lock changes the equations alone
    if any(getattr(before, name).shape != getattr(now, name).shape for name in sizes):
        now.own["bent"] = 0.0
        begin_again(now.run)
        return
    alike = before.dlam.shape == now.dlam.shape
    if not alike:  # other loops are closed: what the distance is stays known, how it goes on is not
        now.own["bent"] = 0.0
    for name in ("dx", "dv", "start", *(("da", "dlam", "bx", "bv") if alike else ())):
        getattr(now, name)[:] = getattr(before, name)


def known(beside: Beside) -> bool:
    """Could the distance be carried over nearly all steps?"""
    own = beside.own[0]
    return bool(own["stiff"] <= MANY * max(own["steps"], 1))


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
def _straightened(b, h):
    """Correct the distance by what the trapezoidal rule leaves out, h / 12 (2 f(1/2) - f(0) - f(1)) (Simpson's rule).

    It is known for the middle of the step, and wanted for its end: without that shift in time it would make
    vibrations grow. Where it is large it is left out. Returns whether the distance could be carried at all.
    """
    by = h**-2
    ahead = h / (h + b.own[0].bent)
    change, size = 0.0, 0.0
    for i in range(len(b.dv)):
        k = by * b.kv[i]
        b.kv[i] = h**3 / 12.0 * (k + ahead * (k - b.bv[i]))
        b.bv[i] = k
        if i < b.own[0].moving:
            change, size = change + b.kv[i] ** 2, size + b.dv[i] ** 2
    for i in range(len(b.dx)):
        k = by * b.kx[i]
        b.kx[i] = h**3 / 12.0 * (k + ahead * (k - b.bx[i]))
        b.bx[i] = k
    followed, b.own[0].bent = b.own[0].bent > 0.0, h
    if followed and change <= STRAIGHT**2 * size:
        for i in range(len(b.dv)):
            b.dv[i] += b.kv[i]
        for i in range(len(b.dx)):
            b.dx[i] += b.kx[i]
    b.own[0].wide = max(size, FADES * b.own[0].wide)
    return not followed or change <= STIFF**2 * b.own[0].wide


@inner_kernel
def _differ(weights, third, r, b, h):
    """Return the square of what the embedded method of order three differs by in the rates, the largest of late."""
    size = 0.0
    for i in range(b.own[0].moving):
        apart = 0.0
        for j in range(STAGES):
            apart += (weights[STAGES - 1, j] - third[j]) * r.A[j, i]
        size += (h * apart) ** 2
    b.own[0].size = max(size, FADES * b.own[0].size)
    return b.own[0].size


@inner_kernel
def _take_off_errors(r, b, h, weights, third):
    """Take the local error of a step off the motion beside: that of order five, as the stages of the step tell it."""
    size = 0.0
    for i in range(len(b.dv)):
        fifth = 0.0
        for j in range(STAGES):
            fifth += ALONE[j] * r.A[j, i]
        b.change[i] = LINEAR * h * fifth
        if i < b.own[0].moving:
            size += b.change[i] ** 2
    low, high, most = BESIDE
    differs = _differ(weights, third, r, b, h)
    seen = b.own[0].steps > SEEN and differs > 0.0
    if seen and not size <= most**2 * differs:
        b.own[0].stiff += 1
        return
    long = ((size / differs) ** 0.5 - low) / (high - low) if seen else 0.0
    times = 1.0 + (COARSE - 1.0) * min(max(long, 0.0), 1.0)
    for i in range(len(b.dv)):
        b.dv[i] -= times * b.change[i]
    for i in range(len(b.dx)):
        fifth = 0.0
        for j in range(STAGES):
            fifth += ALONE[j] * r.K[j, i]
        b.dx[i] -= times * LINEAR * h * fifth


@inner_kernel
def _hold(b):
    """Forget all rates of the distance, which stays as it is."""
    b.own[0].bent = 0.0
    b.da[:] = 0.0
    b.dlam[:] = 0.0


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

    Where something touches, what the step adds is not known, and the distance stays as it is.
    """
    if b.run[0].followed == 0:
        return
    b.own[0].steps += 1
    if touched == 1:
        b.run[0].blind += 1
        _hold(b)
        return
    shift, end = GAMMA * h, STAGES - 1
    b.x0[:], b.v0[:] = b.dx, b.dv
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
    if not done or not _straightened(b, h):
        b.own[0].stiff += 1
        b.dx[:], b.dv[:] = b.x0, b.v0
        _hold(b)
        return
    if b.own[0].steps % EVERY == 0:
        measure(program, r.state.q, b.state.q, r.extent, b.run, b.start, t + h)
    _take_off_errors(r, b, h, weights, third)
