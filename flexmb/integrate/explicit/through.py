"""Explicit steps from sample to sample in one compiled loop, and what bodies and joints do at each."""

from __future__ import annotations

import numpy as np

from flexmb.integrate.explicit.eighth_order import run_to
from flexmb.integrate.explicit.steps import STAGES, STEPS
from flexmb.integrate.runs.patience import PAUSED
from flexmb.integrate.runs.sample_rows import SampleRows
from flexmb.integrate.runs.switching import Switching
from flexmb.integrate.sampled import accelerated
from flexmb.math.jets import sample_signals
from flexmb.math.kernel import entry_kernel, inner_kernel
from flexmb.math.program import PROGRAM
from flexmb.math.structures import array_type, numba_type
from flexmb.math.tables import COUNT, FLOATS, NUMBER, WORK, State
from flexmb.system.program import unit_frames
from flexmb.tree.coordinates.settle import count_turns, move, prescribe, unit_length
from flexmb.tree.rigid.link_tree import LINK_TREE

__all__ = ["UNSURE", "run_through"]

UNSURE = 4
"""The accelerations of a sample are no exact solution of the compiled factorisation."""


@inner_kernel
def _write_state(program, work, tree, s, q, u, signals):
    """Write the coordinates and velocities of all bodies at the present time."""
    t = s.run[0].t
    if len(tree.links) == 0:
        q[:] = s.y[: len(q)]
        u[:] = s.y[len(q) : len(q) + len(u)]
        unit_frames(program, q)
        return
    chart, nx, nv = tree.chart, len(tree.x), len(tree.v)
    x, v, a = s.y[:nx].copy(), s.y[nx : nx + nv].copy(), np.empty(nv)
    unit_length(chart.rows, x)
    if len(chart.driven) > 0:
        sample_signals(t, chart.signals, chart.sampled)
        prescribe(chart.driven, chart.sampled, x, v, a)
    move(chart.rows, program, work, chart.start, x, v, State(t, q, u, u, s.lam, signals))
    count_turns(chart, program, t, x, q)


@entry_kernel(
    PROGRAM,
    WORK,
    LINK_TREE,
    STEPS,
    numba_type(Switching),
    array_type(FLOATS),
    *[COUNT] * 6,
    *[NUMBER] * 2,
    numba_type(SampleRows),
)
def run_through(program, work, tree, s, sw, samples, first, last, most, trials, begun, redundant, goal, g, rows):
    """Integrate through samples[first:last], writing each to the rows; return (next sample, reason, goal, begun).

    Having tried so many steps, it returns PAUSED and goes on when it is called again. `most` steps are allowed between
    two samples; those to the sample `goal` have begun when there were `begun`. `g` (m/s2) is gravity.
    """
    asked = s.run[0].evaluations
    for k in range(first, last):
        if samples[k] > s.run[0].t and samples[k] != goal:
            goal, begun = samples[k], s.run[0].steps
            s.run[0].short_steps = 0
        left = trials - (s.run[0].evaluations - asked) // STAGES
        if left <= 0:
            return k, PAUSED, goal, begun
        reason = run_to(program, work, tree, s, sw, samples[k], most - (s.run[0].steps - begun), left)
        if reason != 0:
            return k, reason, goal, begun
        n = k - first
        _write_state(program, work, tree, s, rows.q[n], rows.u[n], s.signals)
        rows.t[n] = s.run[0].t
        rows.works[n] = s.y[len(s.y) - 3 :]
        state = State(rows.t[n], rows.q[n], rows.u[n], rows.a[n], rows.lam[n], s.signals)
        if not accelerated(program, work, state, s.right, g, redundant):
            return k, UNSURE, goal, begun
    return last, 0, goal, begun
