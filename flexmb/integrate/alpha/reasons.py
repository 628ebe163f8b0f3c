"""Why steps of the generalized-alpha method do not go on, in words."""

from __future__ import annotations

import numpy as np

from flexmb.integrate.alpha.newmark import SINGULAR, STALLED
from flexmb.integrate.alpha.variables import Variables
from flexmb.system.complaints import without_value, worst_equations

__all__ = ["reason_of"]


def reason_of(system, work, v: Variables, reason: int) -> str:
    """Return what has ended the steps, with the part that it is due to."""
    t = v.run[0].t
    if reason == SINGULAR:
        if not np.all(np.isfinite(work.residual)):
            return f"the equations of motion are not finite at t = {t:.9g} s{without_value(system, work, v.q1, v.u1)}"
        return f"the iteration matrix is singular at t = {t:.9g} s (dead centre, or dependent equations)"
    if reason == STALLED:
        worst = int(np.argmax(np.abs(v.right[: system.nu]) * v.extent)) if system.nu else 0
        equations = f"; worst equations: {worst_equations(system, work)}" if system.ng else ""
        return f"the iteration does not converge at t = {t:.9g} s near {system.owner(worst)}{equations}"
    worst = int(np.argmax(np.abs(v.a1 - v.a) * v.extent / v.reach))
    return f"the step size fell below {v.run[0].next_step:.3g} s at t = {t:.9g} s because of {system.owner(worst)}"
