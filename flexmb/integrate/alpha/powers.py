"""Powers at the end of a step of the generalized-alpha method, and the work they add up to. Theory: integrators."""

from __future__ import annotations

import numpy as np

from flexmb.math.energies import write_powers
from flexmb.math.kernel import inner_kernel
from flexmb.math.tables import State
from flexmb.system.program import evaluate

__all__ = ["SELDOM", "add_works", "look_at_powers_anew", "note_correction", "settle_powers"]

SMALL = 1e-5
"""Last correction of a step, relative to the velocities, up to which the powers before it do."""
SELDOM = 3.0
"""Steps from one evaluation after the last correction to the next."""


@inner_kernel
def note_correction(v, c, h, corrections):
    """Note the number of corrections of a step, if the last has changed velocities or states noticeably; else 0.

    Forces were evaluated before it.
    """
    velocity, change, of_states = 0.0, 0.0, 0.0
    for i in range(v.run[0].first_state):
        velocity = max(velocity, abs(v.u1[i]) * v.extent[i])
        change = max(change, abs(v.d[i]) * v.extent[i])
    for i in range(v.run[0].first_state, len(v.u)):
        of_states = max(of_states, abs(v.d[i]) * v.extent[i] / v.reach[i])
    noticed = change * c.gamma / (c.beta * h) > SMALL * velocity or of_states > SMALL
    v.run[0].rough = corrections if noticed else 0


@inner_kernel
def settle_powers(program, work, v, h):
    """Give the powers of an accepted step of the size h what they lack: they were evaluated before its last correction.

    A load that follows a place lags by the error of the prediction, which is in phase with it: its work would drift. An
    evaluation in each step would tell, and cost a fifth of it. The prediction goes along a straight line through the
    accelerations at the start and a step before: velocities err by h^2 (h + h_before) times the next rate of the
    motion, which hardly changes in some steps, where it is smooth. A step with more corrections lacks far less.
    """
    run = v.run[0]
    run.since_look += 1.0
    if run.rough == 0 or v.powers[0] == 0.0:
        return
    size = h * h * (h + run.last_step)
    if run.since_look >= SELDOM or run.rough != run.looked_at:
        for i in range(3):
            v.lacking[i] = v.powers[i]
        work.weights[0].wanted = 0
        evaluate(program, State(run.t + h, v.q1, v.body_u, v.body_a, v.lam1, v.signals), work)
        drives = v.powers[1]
        write_powers(work.energy, v.powers)
        v.powers[1] = drives  # by the corrected multipliers already
        for i in range(3):
            v.lacking[i] = (v.powers[i] - v.lacking[i]) / size
        run.since_look, run.looked_at = 0.0, run.rough
    else:
        for i in range(3):
            v.powers[i] += size * v.lacking[i]


@inner_kernel
def look_at_powers_anew(v):
    """Forget what powers lacked: loads have jumped, or a contact has begun or ended."""
    v.run[0].since_look = SELDOM


@inner_kernel
def add_works(v, h, powers):
    """Add the work of a step: the integral of the parabola through the powers at its ends and at the start before; of
    the straight line where they are not known there, at first and after a jump."""
    before = v.run[0].last_step
    for i in range(3):
        v.works[i] += 0.5 * h * (powers[i] + v.powers[i])
        if v.run[0].steps > 0 and np.isfinite(v.powers_last[i]):
            curvature = ((v.powers[i] - powers[i]) / h - (powers[i] - v.powers_last[i]) / before) / (h + before)
            v.works[i] -= curvature * h * h * h / 6.0
