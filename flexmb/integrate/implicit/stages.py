"""The compiled step of an implicit Runge-Kutta method in the unknowns of a tree: six stages, one matrix.

The method is ESDIRK4(3)6L[2]SA of Kennedy & Carpenter 2003 (the implicit part of their additive pair): order four,
error estimate of order three, first stage explicit, stage order two, L-stable, the last stage is the end of the step.

With the stage's relative acceleration a as unknown, v = v0 + s a and x = x0 + s x'(x, v), s = h / 4, hold by
construction. Newton's method on the equations of motion in absolute coordinates solves eq. (tree-stage) of the theory
of the recursion, ``[M + s D + s^2 K, -G^T; G, 0] (du', dlam) = -(r, g'')``, whose factorisation goes from the leaves to
the roots, and the change of a is read from du'.
"""

from __future__ import annotations

from typing import Annotated, NamedTuple

import numpy as np

from flexmb.integrate.runs.spin_axes import error_of_axes
from flexmb.math.block_lu import lu_factor
from flexmb.math.block_substitution import lu_solve
from flexmb.math.energies import powers
from flexmb.math.jets import sample_signals
from flexmb.math.kernel import entry_kernel, inner_kernel
from flexmb.math.program import PROGRAM
from flexmb.math.structures import ArrayOf, FloatRows, Floats, Record, array_type, numba_type, structure
from flexmb.math.tables import FLOATS, NUMBER, WORK, State
from flexmb.math.weights import weigh
from flexmb.system.program import constraint_acceleration, evaluate
from flexmb.tree.coordinates.passes import move_bodies
from flexmb.tree.coordinates.settle import (
    Chart,
    coordinate_rates,
    count_turns,
    prescribe,
    read_change,
    read_turns,
    settle,
    unit_length,
)

__all__ = ["COUNTED", "STAGES", "THIRD", "WEIGHTS", "Stages", "new_stages", "run_step"]

GAMMA = 0.25
WEIGHTS = np.array(
    [
        [0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        [1 / 4, 1 / 4, 0.0, 0.0, 0.0, 0.0],
        [8611 / 62500, -1743 / 31250, 1 / 4, 0.0, 0.0, 0.0],
        [5012029 / 34652500, -654441 / 2922500, 174375 / 388108, 1 / 4, 0.0, 0.0],
        [15267082809 / 155376265600, -71443401 / 120774400, 730878875 / 902184768, 2285395 / 8070912, 1 / 4, 0.0],
        [82889 / 524892, 0.0, 15625 / 83664, 69875 / 102672, -2260 / 8211, 1 / 4],
    ]
)
"""Of the stages; the last row is the step's."""
THIRD = np.array(
    [4586570599 / 29645900160, 0.0, 178811875 / 945068544, 814220225 / 1159782912, -3700637 / 11593932, 61727 / 225920]
)
"""Weights of the embedded method of order three."""
STAGES = 6
MOST = 12
"""Iterations of a stage."""
SLOW = 0.5
"""Rate of convergence at which the matrix is made anew."""
STALLED = 0.3
"""Rate of convergence at which, with corrections far below the tolerance, only rounding is left."""
AXES = 1.0
"""Times the tolerance to the power of 3/4: the part of the motion of an axis that local errors may be."""
UNSEEN = 1e-3
"""What the iteration may leave of velocities, relative to their error in a step:
like the error of positions, it is of order h^4.
"""


class StageRun(Record):
    """How the steps go on."""

    error: float
    """of the step, relative to its tolerance"""
    span: float
    """s, of the run"""
    first_state: int
    """velocities from here on are first-order states"""
    fresh: int
    """1: the matrix is to be made anew"""
    steps: int
    iterations: int
    factorisations: int
    rejected_by_error: int
    rejected_by_iteration: int


COUNTED = ("steps", "iterations", "factorisations", "rejected_by_error", "rejected_by_iteration")
"""What the statistics of a run tell."""


@structure
class Stages(NamedTuple):
    """Storage of the steps."""

    x: Floats
    """(nx,) unknowns of the stage at hand, at the end of the step"""
    v: Floats
    """(nv,) rates, likewise"""
    a: Floats
    """(nv,) second rates, likewise"""
    lam: Floats
    """(ng,) multipliers, likewise"""
    x0: Floats
    """(nx,) what the stage starts from"""
    v0: Floats
    """(nv,) likewise"""
    y: Floats
    """(nx,) x with unit Euler parameters"""
    change: Floats
    """(nv,) of a"""
    K: FloatRows
    """(6, nx) rates of x of the stages, of which the first is the start of the step, as in the next four"""
    V: FloatRows
    """(6, nv) rates v"""
    A: FloatRows
    """(6, nv) second rates"""
    L: FloatRows
    """(6, ng) multipliers"""
    W: FloatRows
    """(6, 3) powers"""
    state: State
    """of all bodies"""
    right: Floats
    """(nu + ng,) right-hand side of the iteration"""
    extent: Floats
    """(nu,) see `flexmb.integrate.extent`, as the next"""
    reach: Floats
    axes: FloatRows
    """(frames, AXIS) errors of the axes of spinning bodies, see `flexmb.integrate.runs.spin_axes`"""
    run: Annotated[np.ndarray, ArrayOf(StageRun.dtype)]
    """one row: how the steps go on"""


def new_stages(unknowns, state, extent, reach, axes, span: float, first_state: int) -> Stages:
    """Return storage for the unknowns of a state, and a run of so many s; velocities from `first_state` on are
    first-order states.
    """
    nx, nv, nu = unknowns.nx, unknowns.nv, len(state.u)
    ng = len(state.lam)
    return Stages(
        x=np.zeros(nx),
        v=np.zeros(nv),
        a=np.zeros(nv),
        lam=state.lam.copy(),
        x0=np.zeros(nx),
        v0=np.zeros(nv),
        y=np.zeros(nx),
        change=np.zeros(nv),
        K=np.zeros((STAGES, nx)),
        V=np.zeros((STAGES, nv)),
        A=np.zeros((STAGES, nv)),
        L=np.zeros((STAGES, ng)),
        W=np.zeros((STAGES, 3)),
        state=state,
        right=np.zeros(nu + ng),
        extent=extent,
        reach=reach,
        axes=axes,
        run=StageRun.table(fresh=1, span=span, first_state=first_state),
    )


@inner_kernel
def _norm(r, change, scale, tolerance):
    """Return the largest displacement of a change (nu,) times `scale`, relative to its tolerance."""
    largest = 0.0
    for i in range(len(r.extent)):
        x = abs(scale * change[i]) * r.extent[i] / (tolerance * r.reach[i])
        if not np.isfinite(x):
            return np.inf
        largest = max(largest, x)
    return largest


@inner_kernel
def _displacement(chart, work, r, scale, tolerance):
    """Return the largest displacement of the bodies by r.change of the rates, drives left out; see `_norm`."""
    for n in range(len(chart.driven)):
        r.change[chart.driven[n, 1]] = 0.0
    move_bodies(chart.rows, work, r.state.q, r.change, r.right)
    return _norm(r, r.right, scale, tolerance)


@inner_kernel
def _follow(chart, program, work, r, t, shift, rates):
    """Write x and v of the stage that follow from its accelerations, and the state of all bodies."""
    for i in range(len(r.v)):
        r.v[i] = r.v0[i] + shift * r.a[i]
    for _ in range(3):  # Euler parameters turn with themselves, but slowly within a step
        coordinate_rates(chart.rows, r.x, r.v, rates)
        for i in range(len(r.x)):
            r.x[i] = r.x0[i] + shift * rates[i]
    prescribe(chart.driven, chart.sampled, r.x, r.v, r.a)
    r.y[:] = r.x
    unit_length(chart.rows, r.y)
    state = State(t, r.state.q, r.state.u, r.state.a, r.lam, r.state.signals)
    settle(chart.rows, program, work, chart.start, r.y, r.v, r.a, state)
    count_turns(chart, program, t, r.y, state.q)


@inner_kernel
def _predict(r, c, s):
    """Write accelerations and multipliers of stage s, at c[s] of the step,
    by the polynomial through up to three before.
    """
    first = max(0, s - 3)
    r.a[:], r.lam[:] = 0.0, 0.0
    for j in range(first, s):
        share = 1.0
        for k in range(first, s):
            if k != j:
                share *= (c[s] - c[k]) / (c[j] - c[k])
        r.a[:] += share * r.A[j]
        r.lam[:] += share * r.L[j]


@inner_kernel
def _solve_for_change(program, work, r, a):
    """Write what Newton's method changes of the velocities of bodies, over the shift, and of multipliers to r.right."""
    nu = len(r.extent)
    for i in range(nu):
        r.right[i] = -work.residual[i]
    constraint_acceleration(work, a, r.right[nu:])
    for i in range(len(r.lam)):
        r.right[nu + i] = -r.right[nu + i]
    lu_solve(work.S, program.pattern, r.right)


@inner_kernel
def _add_change(chart, work, r):
    """Add r.right to the unknowns: to the accelerations as r.change, and to the multipliers."""
    read_change(chart.rows, work, r.right, r.change)
    for i in range(len(r.a)):
        r.a[i] += r.change[i]
    for i in range(len(r.lam)):
        r.lam[i] += r.right[len(r.extent) + i]


@inner_kernel
def _keep_stage(chart, work, r, shift, s):
    """Keep powers, rates, accelerations and multipliers of a stage that is solved."""
    r.W[s] = powers(work.energy)
    r.W[s, 1] = 0.0  # of the drives: with the corrected multipliers
    for i in range(len(r.lam)):
        r.W[s, 1] -= r.lam[i] * work.equations[i].rate
    for i in range(len(r.v)):
        r.v[i] += shift * r.change[i]
    prescribe(chart.driven, chart.sampled, r.x, r.v, r.a)
    r.V[s], r.A[s], r.L[s] = r.v, r.a, r.lam


@inner_kernel
def _stage(chart, program, work, r, t, shift, s, tolerance, newton, settled):
    """Solve stage s by Newton's method; the matrix is kept while it converges fast. False if it fails.

    It ends when what is left is below `newton` of the tolerance and `settled` of the accelerations, or, below the
    former, when iterations gain nothing more.
    """
    size, rate = 0.0, 0.5
    if len(chart.driven) > 0:
        sample_signals(t, chart.signals, chart.sampled)
    for iteration in range(MOST):
        _follow(chart, program, work, r, t, shift, r.K[s])
        state = State(t, r.state.q, r.state.u, r.state.a, r.lam, r.state.signals)
        weigh(work.weights, 1.0, shift, shift * shift)
        work.weights[0].wanted = r.run[0].fresh
        evaluate(program, state, work)
        r.run[0].iterations += 1
        if r.run[0].fresh == 1:
            r.run[0].factorisations += 1
            if lu_factor(work.S, program.pattern) >= 0:
                return False
        _solve_for_change(program, work, r, state.a)
        before, size = size, _norm(r, r.right, shift * shift, tolerance)
        if not np.isfinite(size) or size > 1e12:
            return False
        _add_change(chart, work, r)
        if iteration > 0 and before > 0.0:
            if size > SLOW * before:  # equations that depend on each other may yield all the time, and move nothing
                size = _displacement(chart, work, r, shift * shift, tolerance)
            rate = size / before
            if rate > 1.5 and iteration > 2 and size > newton:
                return False
        rate = min(rate, 0.99)
        goal = min(newton, settled * _norm(r, state.a, shift * shift, tolerance)) if np.isfinite(settled) else newton
        exhausted = iteration > 1 and (rate > STALLED or iteration == MOST - 1) and size <= newton
        if exhausted or (size * rate / (1.0 - rate) <= goal and (iteration > 0 or size <= 1e-2 * goal)):
            _keep_stage(chart, work, r, shift, s)
            return True
        r.run[0].fresh = 1 if iteration > 0 and rate > SLOW else 0
    return False


@inner_kernel
def _error_of_turns(chart, work, r, h, weights, third, tolerance):
    """Return the error of rotations in space, relative to its tolerance: Euler parameters turn with themselves, and a
    steady spin, which has no error in its rates, is not followed at any step.
    """
    r.x0[:], r.change[:] = 0.0, 0.0
    for j in range(STAGES):
        r.x0[:] += h * (weights[STAGES - 1, j] - third[j]) * r.K[j]
    return _displacement(chart, work, r, 1.0, tolerance) if read_turns(chart.rows, r.y, r.x0, r.v, r.change) else 0.0


@inner_kernel
def _error_of_states(chart, work, r, h, weights, third, tolerance):
    """Return the largest error of the first-order states in the step, relative to its tolerance."""
    largest = 0.0
    if r.run[0].first_state < len(r.extent):
        r.change[:] = 0.0
        for j in range(STAGES):
            r.change[:] += h * (weights[STAGES - 1, j] - third[j]) * r.A[j]
        move_bodies(chart.rows, work, r.state.q, r.change, r.right)
        for i in range(r.run[0].first_state, len(r.extent)):
            largest = max(largest, abs(r.right[i]) / (tolerance * r.reach[i]))
    return largest


@entry_kernel(
    numba_type(Chart),
    PROGRAM,
    WORK,
    numba_type(Stages),
    *[array_type(FLOATS)] * 2,
    *[NUMBER] * 2,
    array_type(FLOATS, 2),
    array_type(FLOATS),
    *[NUMBER] * 3,
)
def run_step(chart, program, work, r, x, v, t, h, weights, third, tolerance, newton, settled):
    """Take a step from x, v, whose rates stand in the first stage; return whether its stages could be solved.

    The end of the step stands in r.x, r.v, r.a, r.lam, and its error, relative to the tolerance, in r.error. `settled`
    is what the iteration may leave of the accelerations at least; more where the step before erred more.
    """
    shift = GAMMA * h
    r.x[:], r.v[:] = x, v  # also after a step that failed
    r.run[0].fresh = 1
    for i in range(r.run[0].first_state, len(r.extent)):
        r.extent[i] = 1.0 / shift  # an increment of the integral of a state means this one of the state
    settled = max(settled, UNSEEN * tolerance * r.run[0].error)
    c = np.sum(weights, axis=1)
    for s in range(1, STAGES):
        r.x0[:], r.v0[:] = x, v
        for j in range(s):
            w = h * weights[s, j]
            if w != 0.0:
                r.x0[:] += w * r.K[j]
                r.v0[:] += w * r.A[j]
        _predict(r, c, s)
        if not _stage(chart, program, work, r, t + c[s] * h, shift, s, tolerance, newton, settled):
            return False
    r.change[:] = 0.0
    for j in range(STAGES):
        r.change[:] += h * (weights[STAGES - 1, j] - third[j]) * r.V[j]
    error = _displacement(chart, work, r, 1.0, tolerance)
    of_axes = error_of_axes(
        program.frames,
        r.axes,
        r.state.q,
        r.state.u,
        r.state.a,
        r.right,
        r.extent,
        r.reach,
        tolerance,
        AXES * tolerance**0.75,
        h,
        r.run[0].span,
    )
    # relative to the motion of an axis in the step: of third order
    error = max(error, of_axes ** (4.0 / 3.0), _error_of_turns(chart, work, r, h, weights, third, tolerance))
    r.run[0].error = max(error, _error_of_states(chart, work, r, h, weights, third, tolerance))
    return True
