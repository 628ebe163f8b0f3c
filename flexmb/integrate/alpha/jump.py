"""A jump of the loads between two steps of the generalized-alpha method."""

from __future__ import annotations

import numpy as np

from flexmb.integrate.alpha.powers import look_at_powers_anew
from flexmb.integrate.alpha.variables import Motions
from flexmb.integrate.alpha.world_translation import to_body_axes, to_world_axes
from flexmb.math.energies import write_powers
from flexmb.math.kernel_on_demand import kernel_on_demand
from flexmb.math.plain_loops import copy_into
from flexmb.math.program import PROGRAM
from flexmb.math.structures import numba_type
from flexmb.math.tables import COUNT, WORK, State
from flexmb.system.accelerations import accelerations
from flexmb.system.program import evaluate

__all__ = ["take_jump"]


@kernel_on_demand(COUNT, PROGRAM, WORK, numba_type(Motions), COUNT)
def take_jump(program, work, motions, sweeps):
    """Write what accelerations, multipliers and powers are after a jump of the loads; return -1, or a place where the
    matrix is singular.

    The algorithmic acceleration keeps its distance from the true one, the rate of the motion before, which does not
    jump: steps of the size before remain accurate, and no new start is needed.
    """
    v, s = motions.own, motions.corrected
    nu, ng = len(v.u), len(v.lam)
    to_body_axes(v.world, v.q, v.u, v.a, v.body_u, v.body_a)
    u, a = v.body_u.copy(), v.body_a.copy()
    lam = v.lam.copy()
    state = State(v.run[0].t, v.q, v.body_u, a, lam, v.signals)
    failed = accelerations(program, state, work, v.right, sweeps)
    if failed >= 0:
        return failed
    work.weights[0].wanted = 0
    evaluate(program, state, work)
    write_powers(work.energy, v.powers)
    look_at_powers_anew(v)
    v.powers_last[:] = np.inf  # those before the jump tell nothing of how powers bend in the next step
    copy_into(v.body_a, a)
    to_world_axes(v.world, v.q, u, a)
    for i in range(nu):
        change = a[i] - v.a[i]
        v.a[i] += change
        v.alg[i] += change
        v.a_last[i] += change
        s.a[i] += change
        s.alg[i] += change
    for i in range(ng):
        v.lam_last[i] += lam[i] - v.lam[i]
        s.lam[i] += lam[i] - v.lam[i]
        v.lam[i] = lam[i]
    return -1
