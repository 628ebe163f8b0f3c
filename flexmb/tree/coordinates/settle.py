"""From the coordinates of a tree to the state of its bodies and back, in compiled passes: what integration needs."""

from __future__ import annotations

from typing import Annotated, NamedTuple

import numpy as np

from flexmb.math.jets import SignalCode
from flexmb.math.kernel import inner_kernel, kernel
from flexmb.math.rotations import euler_to_matrix
from flexmb.math.structures import ArrayOf, FloatRows, Floats, IntegerRows, structure
from flexmb.math.vectors import cross, dot, matvec_t
from flexmb.model.signal import pack
from flexmb.system.program import run_kernels
from flexmb.tree.coordinates.joint_kinematics import read_twist, relative_pose
from flexmb.tree.coordinates.motions import FREE, HINGED, MOTION
from flexmb.tree.coordinates.passes import accelerate_bodies, marker_rate, move_bodies, place_bodies

__all__ = [
    "Chart",
    "coordinate_rates",
    "count_turns",
    "move",
    "new_chart",
    "place",
    "prescribe",
    "read_change",
    "read_turns",
    "settle",
    "unit_length",
]


@structure
class Chart(NamedTuple):
    """Joint coordinates as unknowns."""

    rows: Annotated[np.ndarray, ArrayOf(MOTION)]
    """bodies of the tree, parents first"""
    driven: IntegerRows
    """(nd, 2) coordinates and rates that drives prescribe"""
    signals: SignalCode
    """of the drives"""
    sampled: FloatRows
    """(nd, 3) their values"""
    counted: IntegerRows
    """(nc, 2) turns that the model counts, with the numbers of their branches"""
    clock: Floats
    """see `Followed`, as the next two"""
    branches: Floats
    pace: Floats
    start: Floats
    """(nq,) any configuration"""


def new_chart(tree, start: np.ndarray, followed) -> Chart:
    """Return the chart of a `JointTree`; `start` (nq,) is any configuration, `followed` counts the branches."""
    signals = list(tree.driven.values())
    driven = np.array([(tree.places[name], tree.rate_places[name]) for name in tree.driven], np.int64).reshape(-1, 2)
    counted = np.array(tree.counted, np.int64).reshape(-1, 2)
    return Chart(
        rows=tree.rows,
        driven=driven,
        signals=SignalCode(*pack([s.program() for s in signals])),
        sampled=np.zeros((len(signals), 3)),
        counted=counted,
        clock=followed.clock,
        branches=followed.branches,
        pace=followed.pace,
        start=start.copy(),
    )


@kernel
def place(rows, program, work, start, x, state):
    """Write the coordinates of all bodies at relative coordinates x to state.q, without velocities.

    `start` (nq,) is any configuration: what a marker is in its own body is seen there, with the modes of x.
    """
    state.q[:] = start
    state.u[:] = 0.0
    bends = False
    for k in range(len(rows)):
        row = rows[k]
        if row.held <= FREE:
            for i in range(row.modes):
                state.q[row.q + 7 + i] = x[row.iq + row.coordinates + i]
                bends = True
    if bends:
        run_kernels(program.place, 0, program, state, work)
    place_bodies(rows, work, state.q.copy(), x, state.q)
    run_kernels(program.place, 0, program, state, work)


@kernel
def move(rows, program, work, start, x, v, state):
    """Write coordinates and velocities of all bodies at x and v; the workspace knows the former."""
    place(rows, program, work, start, x, state)
    move_bodies(rows, work, state.q, v, state.u)


@kernel
def settle(rows, program, work, start, x, v, a, state):
    """Write coordinates, velocities and accelerations of all bodies at x, v, a; the workspace knows q and u."""
    move(rows, program, work, start, x, v, state)
    run_kernels(program.place, 0, program, state, work)
    accelerate_bodies(rows, work, state.q, v, a, state.a)


@kernel
def read_change(rows, work, change, out):
    """Write what a change of the bodies' accelerations (nu,) that the joints allow is in second rates `out` (nv,)."""
    d, R = np.empty(3), np.empty((3, 3))
    A, B, twist = np.empty(6), np.empty(6), np.empty(6)
    s, t = np.empty(3), np.empty(3)
    for k in range(len(rows)):
        row = rows[k]
        nr, own = row.rates, row.u
        if row.held == HINGED:
            one, two = row.own, row.other
            if row.forward == 1:
                one, two = row.other, row.own
            first, second = work.markers[one], work.markers[two]
            relative_pose(first, second, d, R)
            marker_rate(first, work.J, change, A)
            marker_rate(second, work.J, change, B)
            for i in range(3):
                s[i] = second.r[i] - first.r[i]
            cross(A[3:6], s, t)
            for i in range(3):
                t[i] = B[i] - A[i] - t[i]
                s[i] = B[3 + i] - A[3 + i]
            matvec_t(first.R, t, twist[0:3])
            matvec_t(first.R, s, twist[3:6])
            read_twist(row, R, twist, out[row.iv : row.iv + nr])
            own += 6
        else:
            for i in range(nr):
                out[row.iv + i] = change[own + i]
            own += nr
        for i in range(row.modes):
            out[row.iv + nr + i] = change[own + i]


@inner_kernel
def _turning(p, w, out):
    """Write p' = 1/2 p o (0, w) of Euler parameters (scalar first)."""
    out[0] = -0.5 * (p[1] * w[0] + p[2] * w[1] + p[3] * w[2])
    out[1] = 0.5 * (p[0] * w[0] + p[2] * w[2] - p[3] * w[1])
    out[2] = 0.5 * (p[0] * w[1] + p[3] * w[0] - p[1] * w[2])
    out[3] = 0.5 * (p[0] * w[2] + p[1] * w[1] - p[2] * w[0])


@kernel
def coordinate_rates(rows, x, v, out):
    """Write x' of relative coordinates x at rates v: their derivatives, but for frames and balls."""
    R, p = np.empty((3, 3)), np.empty(4)
    for k in range(len(rows)):
        row = rows[k]
        iq, iv, nc = row.iq, row.iv, row.rates
        if row.held == FREE:
            length = np.sqrt(np.sum(x[iq + 3 : iq + 7] ** 2))
            for i in range(4):
                p[i] = x[iq + 3 + i] / length
            euler_to_matrix(p, R)
            for i in range(3):
                out[iq + i] = R[i, 0] * v[iv] + R[i, 1] * v[iv + 1] + R[i, 2] * v[iv + 2]
            _turning(x[iq + 3 : iq + 7], v[iv + 3 : iv + 6], out[iq + 3 : iq + 7])
        elif row.ball >= 0 and row.held == HINGED:
            nc = row.ball
            for i in range(nc):
                out[iq + i] = v[iv + i]
            _turning(x[iq + nc : iq + nc + 4], v[iv + nc : iv + nc + 3], out[iq + nc : iq + nc + 4])
        else:
            for i in range(nc):
                out[iq + i] = v[iv + i]
        for i in range(row.modes):
            out[iq + row.coordinates + i] = v[iv + row.rates + i]


@kernel
def unit_length(rows, x):
    """Scale the Euler parameters among relative coordinates to unit length."""
    for k in range(len(rows)):
        row = rows[k]
        at = row.iq + 3 if row.held == FREE else row.iq + row.ball
        if row.held == FREE or (row.held == HINGED and row.ball >= 0):
            length = np.sqrt(np.sum(x[at : at + 4] ** 2))
            for i in range(4):
                x[at + i] /= length


@kernel
def read_turns(rows, x, change, v, out):
    """Write to the rates `out` what rotations, rad, a change of the Euler parameters among x means; are there any?

    What it changes of their length counts as a rotation about the spin among the rates v: a step that errs by one errs
    by about as much of the other.
    """
    found = False
    for k in range(len(rows)):
        row = rows[k]
        free = row.held == FREE
        if not free and (row.held != HINGED or row.ball < 0):
            continue
        found = True
        first = 3 if free else row.ball
        p, d = x[row.iq + first : row.iq + first + 4], change[row.iq + first : row.iq + first + 4]
        w, turn = v[row.iv + first : row.iv + first + 3], out[row.iv + first : row.iv + first + 3]
        turn[0] = 2.0 * (p[0] * d[1] - p[1] * d[0] - p[2] * d[3] + p[3] * d[2])
        turn[1] = 2.0 * (p[0] * d[2] - p[2] * d[0] - p[3] * d[1] + p[1] * d[3])
        turn[2] = 2.0 * (p[0] * d[3] - p[3] * d[0] - p[1] * d[2] + p[2] * d[1])
        speed = dot(w, w) ** 0.5
        if speed > 0.0:
            along = dot(w, turn) / speed
            longer = 2.0 * (p[0] * d[0] + p[1] * d[1] + p[2] * d[2] + p[3] * d[3])
            whole = (along * along + longer * longer) ** 0.5
            more = whole - along if along >= 0.0 else -whole - along
            for i in range(3):
                turn[i] += more * w[i] / speed
    return found


@kernel
def prescribe(driven, signals, x, v, a):
    """Write value, rate and second rate of the signals (nd, 3) to the coordinates and rates `driven` (nd, 2)."""
    for n in range(len(driven)):
        x[driven[n, 0]] = signals[n, 0]
        v[driven[n, 1]] = signals[n, 1]
        a[driven[n, 1]] = signals[n, 2]


@kernel
def count_turns(chart, program, t, x, q):
    """Write the branches of a state at time t: turns of tree joints as they are counted in x,
    others as they went on.
    """
    for k in range(len(chart.branches)):
        q[program.branches + k] = chart.branches[k] + (t - chart.clock[0]) * chart.pace[k]
    for n in range(len(chart.counted)):
        q[program.branches + chart.counted[n, 1]] = x[chart.counted[n, 0]]
