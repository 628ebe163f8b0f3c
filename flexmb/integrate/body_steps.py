"""Explicit steps in the coordinates of all bodies: rates by the sparse factorisation,
and the way back onto constraints.
"""

from __future__ import annotations

from flexmb.integrate.explicit_steps import (
    ACCEPTING,
    NUMBERS,
    PROJECTIONS,
    RATES,
    SETTLED,
    STAGES,
    call_rates,
)
from flexmb.integrate.stabilised import kinematics
from flexmb.math.kernel import inner_kernel
from flexmb.math.tables import State, pointer_kernel
from flexmb.system.program import accelerations, constraint_velocity, keep_branches, unit_frames
from flexmb.system.projection import project

__all__ = ["accepting", "rates"]

SMALL = 1e-10
"""Last correction of accelerations or multipliers, relative, above which the factorisation is not trusted."""


@pointer_kernel(RATES)
def rates(program, work, tree, s, t, stage):
    """Write the rates of s.y1 to s.K[stage]."""
    y, out = s.y1, s.K[stage]
    nq, nu = len(s.q), len(s.u)
    last = stage == 0 or stage == STAGES
    s.q[:] = y[:nq]
    unit_frames(program, s.q)
    s.u[:] = y[nq : nq + nu]
    state = State(t, s.q, s.u, s.a, s.lam, s.signals)
    failed = accelerations(program, state, work, s.right, s.sweeps[1 if last else 0])
    kinematics(program, 0.0, y, s.u, out)
    for k in range(len(s.pace)):
        out[program.branches + k] = s.pace[k]
    out[nq : nq + nu] = s.a
    for i in range(3):
        out[nq + nu + i] = work.energy[3 + i]
    out[nq + nu + 1] = 0.0  # of the drives: with the multipliers found last
    for i in range(len(s.lam)):
        out[nq + nu + 1] -= s.lam[i] * work.equations[i].rate
    s.counts[NUMBERS] = 1 if failed < 0 else 0
    s.counts[SETTLED] = 1 if not last or _settled(s) else 0


@inner_kernel
def _settled(s):
    """Was the last correction of accelerations and multipliers small?"""
    largest, change, force, correction = 1.0, 0.0, 1.0, 0.0
    nu = len(s.u)
    for i in range(nu):
        largest, change = max(largest, abs(s.a[i])), max(change, abs(s.right[i]))
    for i in range(len(s.lam)):
        force, correction = max(force, abs(s.lam[i])), max(correction, abs(s.right[nu + i]))
    return change <= SMALL * largest and correction <= SMALL * force


@inner_kernel
def _drifted(work, s):
    """Has the state evaluated last left the constraints, at the level of position or of velocity?"""
    constraint_velocity(work, s.u, s.rate)
    fastest, open_by, speed = 0.0, 0.0, 0.0
    for m in range(len(work.markers)):
        for i in range(3):
            fastest = max(fastest, abs(work.markers[m].v[i]) / s.limits[2], abs(work.markers[m].w[i]))
    for n in range(len(s.lam)):
        open_by = max(open_by, abs(work.equations[n].g) / s.bounds[n])
        speed = max(speed, abs(s.rate[n]) / s.bounds[n])
    return open_by > 1.0 or speed > fastest


@pointer_kernel(ACCEPTING)
def accepting(program, work, tree, s, h):
    """Put the end of a step back on the constraints, if it has drifted off, and keep its branches."""
    nq = len(s.q)
    for k in range(len(s.pace)):
        s.pace[k] = (work.branches[k] - s.y[program.branches + k]) / h
    s.y[:] = s.y1
    s.K[0] = s.K[STAGES]
    for k in range(len(s.pace)):  # the same through all stages: branches have no error
        s.K[0, program.branches + k] = s.pace[k]
    keep_branches(program, work, s.y)
    if len(s.lam) == 0 or not _drifted(work, s):
        return
    s.counts[PROJECTIONS] += 1
    keep_branches(program, work, s.q)
    state = State(s.times[0], s.q, s.u, s.a, s.lam, s.signals)
    project(program, state, work, s.right, s.q, 0.01 * s.bounds, s.gaps, s.units, 10)
    s.y[:nq] = s.q
    s.y[nq : nq + len(s.u)] = s.u
    s.y1[:] = s.y
    call_rates(s.calls[0], program, work, tree, s, s.times[0], 0)
