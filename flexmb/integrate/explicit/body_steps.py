"""Explicit steps in the coordinates of all bodies: rates by the sparse factorisation,
and the way back onto constraints.
"""

from __future__ import annotations

from flexmb.integrate.explicit.drift import drifted
from flexmb.integrate.explicit.steps import (
    ACCEPTING,
    RATES,
    STAGES,
    call_rates,
)
from flexmb.integrate.ida.stabilised import kinematics
from flexmb.math.energies import powers
from flexmb.math.kernel import inner_kernel
from flexmb.math.tables import State, pointer_kernel
from flexmb.system.accelerations import accelerations, linear_accelerations
from flexmb.system.program import keep_branches, unit_frames
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
    sweeps = s.run[0].last_sweeps if last else s.run[0].sweeps
    if sweeps == 1:
        failed = linear_accelerations(program, state, work, s.right)
    else:
        failed = accelerations(program, state, work, s.right, sweeps)
    kinematics(program, 0.0, y, s.u, out)
    for k in range(len(s.pace)):
        out[program.branches + k] = s.pace[k]
    out[nq : nq + nu] = s.a
    out[nq + nu : nq + nu + 3] = powers(work.energy)
    out[nq + nu + 1] = 0.0  # of the drives: with the multipliers found last
    for i in range(len(s.lam)):
        out[nq + nu + 1] -= s.lam[i] * work.equations[i].rate
    s.run[0].finite = 1 if failed < 0 else 0
    s.run[0].settled = 1 if not last or _settled(s) else 0


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
    if len(s.lam) == 0 or not drifted(work, s.u, s.bounds, s.lengths):
        return
    s.run[0].projections += 1
    keep_branches(program, work, s.q)
    state = State(s.run[0].t, s.q, s.u, s.a, s.lam, s.signals)
    project(program, state, work, s.right, s.q, 0.01 * s.bounds, s.gaps, s.units, 10)
    s.y[:nq] = s.q
    s.y[nq : nq + len(s.u)] = s.u
    s.y1[:] = s.y
    call_rates(s.run[0].rates, program, work, tree, s, s.run[0].t, 0)
