"""The compiled steps of the explicit method of order eight, DOP853.

Its unknowns are the coordinates of all bodies, with accelerations from the compiled factorisation; or, for rigid
bodies, the coordinates of the joints, with accelerations from the passes in link axes.

The same method as SciPy's (Hairer, Nørsett & Wanner 1993, II.10): twelve stages, error estimate of orders five and
three; its coefficients are taken from there. Between two samples no Python runs.
"""

from __future__ import annotations

import numpy as np

from flexmb.integrate.explicit.drift import PATIENCE, VANISHING
from flexmb.integrate.explicit.steps import STAGES, STEPS, call_accepting, call_rates
from flexmb.integrate.runs.kept_switches import keep_switches
from flexmb.integrate.runs.patience import PAUSED
from flexmb.integrate.runs.switches import allowed
from flexmb.integrate.runs.switching import Switching, read_switches
from flexmb.math.kernel import entry_kernel, inner_kernel, kernel
from flexmb.math.plain_loops import all_finite
from flexmb.math.program import PROGRAM
from flexmb.math.structures import numba_type
from flexmb.math.tables import COUNT, NUMBER, WORK, State
from flexmb.tree.rigid.link_tree import LINK_TREE

__all__ = ["MANY", "SHORT", "UNSETTLED", "ask", "run_to"]

GROWTH, DECAY, SAFETY = 10.0, 0.2, 0.9
CUT = 1e-11
"""Steps shorter than this part of the run are not cut at contacts."""
PASSED, PASSES = 0.8, 6
"""A step that ends in a singular position is shortened by this factor, so many times in a row."""
SHORT, MANY, UNSETTLED = 1, 2, 3


@inner_kernel
def _rates(program, work, tree, s, t, stage):
    """Write the rates of s.y1 to s.K[stage]; return if they are numbers."""
    s.run[0].evaluations += 1
    call_rates(s.run[0].rates, program, work, tree, s, t, stage)
    return s.run[0].finite == 1 and all_finite(s.K[stage])


@kernel
def ask(program, work, tree, s, t, stage):
    """Write the rates of s.y1 to s.K[stage]; return if they are numbers, and settled."""
    return _rates(program, work, tree, s, t, stage) and s.run[0].settled == 1


@inner_kernel
def _error(s, h):
    """Return the error of a step relative to its tolerance, from the estimates of orders five and three."""
    n = len(s.y)
    fifth, third = 0.0, 0.0
    for i in range(n):
        scale = s.atol[i] + s.run[0].rtol * max(abs(s.y[i]), abs(s.y1[i]))
        x, y = 0.0, 0.0
        for k in range(STAGES + 1):
            x += s.E5[k] * s.K[k, i]
            y += s.E3[k] * s.K[k, i]
        fifth += (x / scale) ** 2
        third += (y / scale) ** 2
    both = fifth + 0.01 * third
    return abs(h) * fifth / np.sqrt(both * n) if both > 0.0 else 0.0


@inner_kernel
def _try(program, work, tree, s, h):
    """Write the end of a step to y1, the rates there to the last of K; return its error, infinite if there is none."""
    t, n = s.run[0].t, len(s.y)
    for stage in range(1, STAGES + 1):
        weights = s.A[stage] if stage < STAGES else s.B
        s.y1[:] = s.y
        for k in range(stage):
            x = h * weights[k]
            if x != 0.0:
                for i in range(n):
                    s.y1[i] += x * s.K[k, i]
        at = t + (s.C[stage] * h if stage < STAGES else h)
        if not _rates(program, work, tree, s, at, stage):
            return np.inf
    return _error(s, h)


@inner_kernel
def _accept(program, work, tree, s, h):
    """Make the end of a step the start of the next, on the constraints; return if its rates are numbers and settled."""
    s.run[0].t += h
    call_accepting(s.run[0].accepting, program, work, tree, s, h)
    return s.run[0].finite == 1 and s.run[0].settled == 1 and all_finite(s.K[0])


@inner_kernel
def _part(program, work, tree, s, sw, h):
    """Return the part of a step that ends where a contact begins or ends, 1.0 if none does inside."""
    if len(sw.now) == 0 or h < CUT * s.run[0].span:
        return 1.0
    read_switches(
        program, sw, State(s.run[0].t + h, tree.q if len(tree.links) > 0 else s.q, s.u, s.a, s.lam, s.signals), work
    )
    return allowed(program, sw, h, True)


@entry_kernel(PROGRAM, WORK, LINK_TREE, STEPS, numba_type(Switching), NUMBER, COUNT, COUNT)
def run_to(program, work, tree, s, sw, goal, most, pause):
    """Integrate to the time `goal` in at most so many steps; return 0 or why it ends before.

    Having tried `pause` steps it returns PAUSED after the next one that is accepted, and goes on when it is called
    again.
    """
    rejected, done, singular, tried = False, 0, 0, 0
    while goal > s.run[0].t:
        if tried >= pause and not rejected and singular == 0:
            return PAUSED
        tried += 1
        left = goal - s.run[0].t
        h = left / max(1.0, np.ceil(left / min(s.run[0].next_step, s.run[0].longest_step) * (1.0 - 1e-9)))
        s.run[0].short_steps = s.run[0].short_steps + 1 if h < VANISHING * s.run[0].span and h < left else 0
        if s.run[0].short_steps > PATIENCE or not s.run[0].t + h > s.run[0].t:
            return SHORT
        if done >= most:
            return MANY
        error = _try(program, work, tree, s, h)
        if not error <= 1.0:
            s.run[0].next_step = h * (max(DECAY, SAFETY * error**-0.125) if np.isfinite(error) else DECAY)
            rejected = True
            continue
        if s.run[0].settled == 0 and singular < PASSES:
            # singular positions are single points: a step that ends elsewhere passes them
            s.run[0].next_step = PASSED * h
            singular += 1
            continue
        part = _part(program, work, tree, s, sw, h)
        if part < 1.0:
            s.run[0].next_step = part * h
            continue
        if len(sw.now) > 0:
            keep_switches(sw, h)
        done, singular = done + 1, 0
        s.run[0].steps += 1
        growth = min(GROWTH, SAFETY * max(error, 1e-30) ** -0.125)
        growth = min(growth, 1.0) if rejected else growth
        # a step that only was short to end at a sample says little about longer ones
        s.run[0].next_step = max(s.run[0].next_step, h * growth) if growth >= GROWTH else h * growth
        rejected = False
        if not _accept(program, work, tree, s, h):
            return UNSETTLED
        if goal - s.run[0].t <= 1e-12 * max(abs(goal), h):
            s.run[0].t = goal
    return 0
