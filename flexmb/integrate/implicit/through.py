"""Implicit Runge-Kutta steps from sample to sample in one compiled loop: their size, contacts, loops, and samples."""

from __future__ import annotations

from typing import Annotated, NamedTuple

import numpy as np

from flexmb.integrate.explicit.drift import drifted
from flexmb.integrate.implicit.added_errors import follow
from flexmb.integrate.implicit.beside import Beside
from flexmb.integrate.implicit.stages import STAGES, Stages, run_step
from flexmb.integrate.runs.gap import EVERY
from flexmb.integrate.runs.kept_switches import keep_switches
from flexmb.integrate.runs.patience import PAUSED, ROUNDINGS, UNCUT
from flexmb.integrate.runs.sample_rows import SampleRows
from flexmb.integrate.runs.spin_axes import keep_axes
from flexmb.integrate.runs.switches import allowed
from flexmb.integrate.runs.switching import Switching, read_switches
from flexmb.integrate.sampled import accelerated
from flexmb.math.jets import sample_signals
from flexmb.math.kernel import entry_kernel, inner_kernel
from flexmb.math.plain_loops import all_finite
from flexmb.math.program import PROGRAM
from flexmb.math.structures import ArrayOf, FloatRows, Floats, Integers, Record, array_type, numba_type, structure
from flexmb.math.tables import COUNT, FLOATS, INTEGRALS, WORK, State
from flexmb.system.program import energies, evaluate
from flexmb.system.projection import project
from flexmb.tree.coordinates.passes import read_state
from flexmb.tree.coordinates.settle import Chart, coordinate_rates, count_turns, move, prescribe, unit_length

__all__ = ["SHORT", "UNSURE", "Going", "GoingOn", "run_through"]

SHORT, UNSURE = 1, 2
"""Why the loop ends: steps fail down to the smallest; the accelerations of a sample are for `Recursive` to find."""
BEGUN = 0.01
"""Part of the longest step in which the work of drives may begin to grow."""
TOLD = 2.0 / 3.0
"""Power of the tolerance to which the work of drives is known in a step, relative to the largest so far."""


class GoingOn(Record):
    """How far a run is, and how it goes on."""

    t: float
    """s"""
    goal: float
    """s, the sample that is aimed at"""
    span: float
    """s, from where that began"""
    next_step: float
    """s"""
    longest_step: float
    """s"""
    rtol: float
    newton: float
    """what the iteration may leave, relative to the tolerance of a step"""
    settled: float
    """what it may leave of the accelerations at least; infinite: any"""
    turned: float
    """J, the largest work of drives so far"""
    gravity: float
    """m/s2"""
    kinetic: float
    """J, the largest at every fourth step"""
    adaptive: int
    """1: steps follow the error; 0: they are all as long"""
    driven: int
    """1: the errors of the work of drives count"""
    closes: int
    """1: the state after a step is looked at: loops may have come open, turns are counted"""
    exact: int
    """1: accelerations of samples are found here"""
    redundant: int
    """1: equations depend on each other"""
    cut: int
    """steps that were shortened at contacts"""
    projections: int


@structure
class Going(NamedTuple):
    """What a run has reached, and what it needs to go on."""

    x: Floats
    """(nx,) unknowns"""
    v: Floats
    """(nv,) their rates"""
    works: Floats
    """(3,) J"""
    weights: FloatRows
    """(6, 6) of the method"""
    third: Floats
    """(6,) of the embedded method"""
    gaps: Floats
    """(ng,) see `project`, as `units`"""
    bounds: Floats
    """(ng,) residuals at which the state is projected"""
    lengths: Floats
    """(ng,) m, of the bodies that an equation relates"""
    units: Floats
    turns: Integers
    """angles among the unknowns"""
    balls: Integers
    """where Euler parameters of balls begin"""
    state: State
    """of all bodies"""
    right: Floats
    """(nu + ng,) scratch, as the next three"""
    xs: Floats
    vs: Floats
    second: Floats
    run: Annotated[np.ndarray, ArrayOf(GoingOn.dtype)]
    """one row"""


@inner_kernel
def _smallest(t, goal):
    """Return the step size at which a run ends, see `smallest_step`."""
    return ROUNDINGS * max(abs(t), abs(goal))


@inner_kernel
def _error_of_work(r, g, h):
    """Return the error of the work of drives in a step, relative to its tolerance: coordinates that are driven have
    no error, however long a step is.

    The tolerance is never less than that of what the power does in a part of the longest step: work that begins to
    grow, as t^5, has the same relative error in every first step, however short.
    """
    greatest, error = 0.0, 0.0
    for s in range(STAGES):
        greatest = max(greatest, abs(r.W[s, 1]))
        error += (g.weights[STAGES - 1, s] - g.third[s]) * r.W[s, 1]
    if g.run[0].driven == 0 or greatest == 0.0:
        return 0.0
    turned = max(g.run[0].turned, max(h, BEGUN * g.run[0].longest_step) * greatest)
    return abs(h * error) / (g.run[0].rtol ** TOLD * turned)


@inner_kernel
def _place(chart, program, work, g, t, x, v):
    """Write the state of all bodies at x and v, which get unit Euler parameters and the drives."""
    unit_length(chart.rows, x)
    if len(chart.driven) > 0:
        sample_signals(t, chart.signals, chart.sampled)
        prescribe(chart.driven, chart.sampled, x, v, g.second)
    move(
        chart.rows,
        program,
        work,
        chart.start,
        x,
        v,
        State(t, g.state.q, g.state.u, g.state.a, g.state.lam, g.state.signals),
    )
    count_turns(chart, program, t, x, g.state.q)


@inner_kernel
def _part(chart, program, work, r, sw, g, h):
    """Return the part of a step that may be taken, by what touches in it, 2.0 if nothing is to be asked."""
    t = g.run[0].t
    if len(sw.now) == 0 or not h > UNCUT * _smallest(t, g.run[0].goal):
        return 2.0
    g.xs[:], g.vs[:] = r.y, r.v
    _place(chart, program, work, g, t + h, g.xs, g.vs)
    work.weights[0].wanted = 0
    g.state.a[:], g.state.lam[:] = 0.0, 0.0
    state = State(t + h, g.state.q, g.state.u, g.state.a, g.state.lam, g.state.signals)
    evaluate(program, state, work)
    read_switches(program, sw, state, work)
    return allowed(program, sw, h, g.run[0].adaptive == 1)


@inner_kernel
def _closed(chart, program, work, g):
    """Put the state that has just been reached back onto its loops, where they have come open, and count turns; return
    if they had.
    """
    t = g.run[0].t
    _place(chart, program, work, g, t, g.x, g.v)
    g.state.a[:], g.state.lam[:] = 0.0, 0.0
    state = State(t, g.state.q, g.state.u, g.state.a, g.state.lam, g.state.signals)
    work.weights[0].wanted = 0
    evaluate(program, state, work)
    off = len(g.bounds) > 0 and drifted(work, state.u, g.bounds, g.lengths)
    if off:
        g.run[0].projections += 1
        project(program, state, work, g.right, state.q, 0.01 * g.bounds, g.gaps, g.units, 10)
        work.weights[0].wanted = 0
        evaluate(program, state, work)
    passed = t - chart.clock[0]
    for k in range(len(chart.branches)):
        if passed > 0.0:
            chart.pace[k] = (work.branches[k] - chart.branches[k]) / passed
        chart.branches[k] = work.branches[k]
    chart.clock[0] = t
    if not off:
        return False
    for k in range(len(chart.branches)):
        state.q[program.branches + k] = work.branches[k]
    evaluate(program, state, work)
    g.xs[:] = g.x
    read_state(chart.rows, state, work, g.x, g.v, g.second)
    for n in range(len(g.turns)):
        i = g.turns[n]
        g.x[i] += 2.0 * np.pi * np.round((g.xs[i] - g.x[i]) / (2.0 * np.pi))
    for n in range(len(g.balls)):
        i, along = g.balls[n], 0.0
        for k in range(4):
            along += g.x[i + k] * g.xs[i + k]
        if along < 0.0:
            for k in range(4):
                g.x[i + k] = -g.x[i + k]
    return True


@inner_kernel
def _accepted(chart, program, work, r, b, sw, g, h):
    """Make the end of a step the start of the next."""
    if len(sw.now) > 0:
        keep_switches(sw, h)
    keep_axes(program.frames, r.axes, r.state.u, h)
    if b.run[0].followed and h * h > 0.0:  # it divides by this square
        touched = 1 if len(sw.now) > 0 and sw.limits[0].closed == 1 else 0
        follow(chart, program, work, r, b, g.x, g.v, g.run[0].t, h, g.weights, g.third, touched)
    g.run[0].t += h
    for s in range(STAGES):
        w = h * g.weights[STAGES - 1, s]
        for i in range(3):
            g.works[i] += w * r.W[s, i]
    g.run[0].turned = max(g.run[0].turned, abs(g.works[1]))
    g.x[:], g.v[:] = r.y, r.v
    if g.run[0].closes == 1 and _closed(chart, program, work, g):
        b.own[0].before = 0.0  # a step from another place tells nothing of the next one
    r.A[0], r.W[0], r.L[0] = r.A[STAGES - 1], r.W[STAGES - 1], r.lam
    coordinate_rates(chart.rows, g.x, g.v, r.K[0])
    r.V[0] = g.v
    r.run[0].steps += 1
    if r.run[0].steps % EVERY == 0:
        energies(program, State(g.run[0].t, r.state.q, r.state.u, r.state.a, r.state.lam, r.state.signals), work)
        g.run[0].kinetic = max(g.run[0].kinetic, work.energy[0].kinetic)
    for n in range(len(program.vectors)):
        iq, iu, size, flexible = (
            program.vectors[n, 0],
            program.vectors[n, 1],
            program.vectors[n, 2],
            program.vectors[n, 3],
        )
        if flexible == INTEGRALS:
            for i in range(iu, iu + size):
                r.reach[i] = max(r.reach[i], abs(r.state.u[i]))
        elif flexible:  # positions in W: how far the origin is says nothing about a tolerance
            # tolerances of flexible coordinates are relative to the largest displacement they have reached
            largest = 0.0
            for i in range(size):
                largest = max(largest, abs(r.state.q[iq + i]) * r.extent[iu + i])
            for i in range(iu, iu + size):
                r.reach[i] = max(r.reach[i], largest)


@inner_kernel
def _step(chart, program, work, r, b, sw, g, h):
    """Take a step, or shorten the next one."""
    run, planned = g.run[0], g.run[0].next_step
    if not run_step(chart, program, work, r, g.x, g.v, run.t, h, g.weights, g.third, run.rtol, run.newton, run.settled):
        r.run[0].rejected_by_iteration += 1
        g.run[0].next_step = 0.25 * h
        return
    error = max(r.run[0].error, _error_of_work(r, g, h))
    if run.adaptive == 1 and not error <= 1.0:
        r.run[0].rejected_by_error += 1
        g.run[0].next_step = h * max(0.2, 0.85 * error**-0.25)
        return
    part = _part(chart, program, work, r, sw, g, h)
    if part < 1.0:
        g.run[0].cut += 1
        g.run[0].next_step = part * h
        return
    _accepted(chart, program, work, r, b, sw, g, h)
    longest = run.longest_step
    g.run[0].next_step = longest
    if run.adaptive == 1:
        growth = min(2.0, 0.85 * max(error, 1e-6) ** -0.25)
        following = min(longest, h * growth if growth < 1.0 else max(planned, h * growth))
        g.run[0].next_step = min(following, part * h) if part < 2.0 else following


@inner_kernel
def _to(chart, program, work, r, b, sw, g, goal, trials):
    """Integrate to the time `goal` in at most so many tries; return 0 or why it ends, and the tries that are left."""
    if goal > g.run[0].t and goal != g.run[0].goal:
        g.run[0].goal, g.run[0].span = goal, goal - g.run[0].t
    while goal - g.run[0].t > 1e-12 * max(abs(goal), g.run[0].span):
        if trials <= 0:
            return PAUSED, trials
        left = goal - g.run[0].t
        h = left / max(1.0, np.ceil(left / min(g.run[0].next_step, g.run[0].longest_step) * (1.0 - 1e-9)))
        _step(chart, program, work, r, b, sw, g, h)
        trials -= 1
        if g.run[0].next_step < _smallest(g.run[0].t, goal):
            return SHORT, trials
    g.run[0].t = goal
    return 0, trials


@entry_kernel(
    numba_type(Chart),
    PROGRAM,
    WORK,
    numba_type(Stages),
    numba_type(Beside),
    numba_type(Switching),
    numba_type(Going),
    array_type(FLOATS),
    *[COUNT] * 3,
    numba_type(SampleRows),
)
def run_through(chart, program, work, r, b, sw, g, samples, first, last, trials, rows):
    """Integrate through samples[first:last], writing each to the rows; return the next sample and why it ends there.

    Having tried so many steps, it returns PAUSED and goes on when it is called again.
    """
    for k in range(first, last):
        reason, trials = _to(chart, program, work, r, b, sw, g, samples[k], trials)
        if reason != 0:
            return k, reason
        if g.run[0].exact == 0:
            return k, UNSURE
        n, now = k - first, g.run[0].t
        g.xs[:], g.vs[:] = g.x, g.v
        _place(chart, program, work, g, now, g.xs, g.vs)
        state = State(now, g.state.q, g.state.u, g.state.a, g.state.lam, g.state.signals)
        found = accelerated(program, work, state, g.right, g.run[0].gravity, g.run[0].redundant)
        if not (found and all_finite(state.a) and all_finite(state.lam)):
            return k, UNSURE
        rows.t[n], rows.works[n] = now, g.works
        rows.q[n], rows.u[n], rows.a[n], rows.lam[n] = state.q, state.u, state.a, state.lam
    return last, 0
