"""Explicit steps with accelerations in closed form (Udwadia & Phohomsiri), or by the null space (Kane).

Both are the same numbers: an orthonormal basis of the constraints' rows, and of the motions that they leave. Dependent
equations and bodies without inertia are part of it, so there is no other factorisation to fall back to.
"""

from __future__ import annotations

import numpy as np

from flexmb.integrate.explicit.steps import RATES, Dense
from flexmb.integrate.ida.stabilised import kinematics
from flexmb.math.block_pattern import stored
from flexmb.math.closed_form import RANK, solve_closed
from flexmb.math.energies import powers
from flexmb.math.kernel import inner_kernel
from flexmb.math.tables import State, pointer_kernel
from flexmb.math.weights import weigh
from flexmb.system.mobility import DEPENDENT, DRIFTS
from flexmb.system.program import constraint_acceleration, evaluate, unit_frames

__all__ = ["applies", "dense_of", "no_dense", "rates"]


def no_dense() -> Dense:
    """Return what steps by other accelerations have."""
    none = np.zeros(0, np.int64)
    return Dense(rows=none, columns=none, at=none, order=none, apart=np.zeros(0))


def dense_of(system, work) -> Dense:
    """Return the places of the mass matrix of a system."""
    numbered = stored(np.arange(1.0, len(work.S) + 1.0), system.program.pattern).tocoo()
    own = (numbered.row < system.nu) & (numbered.col < system.nu)
    last = np.array(system.redundant, np.int64)
    apart = np.full(system.ng, RANK)
    apart[last] = DRIFTS * DEPENDENT
    return Dense(
        rows=numbered.row[own].astype(np.int64),
        columns=numbered.col[own].astype(np.int64),
        at=np.rint(numbered.data[own]).astype(np.int64) - 1,
        order=np.concatenate([np.setdiff1d(np.arange(system.ng), last), last]).astype(np.int64),
        apart=apart,
    )


def applies(system) -> bool:
    """Are forces of constraints A^T lam: no friction by reactions, no stiffening by interface loads?"""
    stiffened = np.any(system.tables["markers"]["iH"] >= 0)
    reads = any(force.reads_reactions for force in system.model.forces)
    return not stiffened and not reads and not system.implicit


@inner_kernel
def _gradients(program, work, state, A, b):
    """Write A and b of the constraints, A a = b."""
    A[:] = 0.0
    constraint_acceleration(work, state.a, b)
    for n in range(len(b)):
        b[n] = -b[n]
    for n in range(len(work.legs)):
        leg = work.legs[n]
        marker = work.markers[leg.marker]
        for k in range(6):
            x = leg.gradient[k]
            if x != 0.0:
                start = marker.iJ + k * marker.nu
                for j in range(marker.nu):
                    A[leg.equation, marker.iu + j] += x * work.J[start + j]


@pointer_kernel(RATES)
def rates(program, work, tree, s, t, stage):
    """Write the rates of s.y1 to s.K[stage]."""
    y, out = s.y1, s.K[stage]
    nq, nu, ng = len(s.q), len(s.u), len(s.lam)
    s.q[:] = y[:nq]
    unit_frames(program, s.q)
    s.u[:] = y[nq : nq + nu]
    s.a[:] = 0.0
    s.lam[:] = 0.0
    state = State(t, s.q, s.u, s.a, s.lam, s.signals)
    weigh(work.weights, 1.0)
    work.weights[0].constrained = 0
    evaluate(program, state, work)
    for n in range(len(program.floor_at)):  # inertia that factorisations need is not lent here
        work.S[program.floor_at[n, 1]] -= program.floor[n]
    d = s.dense
    masses, Q, A, b = np.empty(len(d.at)), np.empty(nu), np.empty((ng, nu)), np.empty(ng)
    for e in range(len(d.at)):
        masses[e] = work.S[d.at[e]]
    for i in range(nu):
        Q[i] = -work.residual[i]
    _gradients(program, work, state, A, b)
    unique = solve_closed(d.rows, d.columns, masses, Q, A, b, d.order, d.apart, s.a, s.lam)
    kinematics(program, 0.0, y, s.u, out)
    for k in range(len(s.pace)):
        out[program.branches + k] = s.pace[k]
    out[nq : nq + nu] = s.a
    out[nq + nu : nq + nu + 3] = powers(work.energy)
    out[nq + nu + 1] = 0.0  # of the drives: with these multipliers
    for i in range(ng):
        out[nq + nu + 1] -= s.lam[i] * work.equations[i].rate
    s.run[0].finite = 1 if unique else 0
    s.run[0].settled = 1 if unique else 0
