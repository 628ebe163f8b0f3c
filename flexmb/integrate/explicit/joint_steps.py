"""Explicit steps in joint coordinates of rigid bodies: rates by the passes in link axes,
and the way back onto loops.
"""

from __future__ import annotations

import numpy as np

from flexmb.integrate.explicit.steps import (
    ACCEPTING,
    RATES,
    STAGES,
    call_rates,
)
from flexmb.math.tables import pointer_kernel
from flexmb.tree.coordinates.settle import coordinate_rates, unit_length
from flexmb.tree.rigid.motion import close_links, link_rates, loops_are_open

__all__ = ["accepting", "rates"]


@pointer_kernel(RATES)
def rates(program, work, tree, s, t, stage):
    """Write the rates of s.y1 to s.K[stage]: drives have their rates, whatever y1 says."""
    nx, nv = len(tree.x), len(tree.v)
    out = s.K[stage]
    failed = link_rates(tree, work, t, s.y1[:nx], s.y1[nx : nx + nv])
    coordinate_rates(tree.chart.rows, tree.x, tree.v, out)
    out[nx : nx + nv] = tree.a
    out[nx + nv :] = tree.powers
    s.run[0].finite = 1 if failed < 0 else 0
    s.run[0].settled = 1


@pointer_kernel(ACCEPTING)
def accepting(program, work, tree, s, h):
    """Close the loops at the end of a step, if they have come open, and follow the turns that are counted."""
    chart, nx = tree.chart, len(tree.x)
    s.y[:] = s.y1
    s.K[0] = s.K[STAGES]
    for k in range(len(chart.branches)):
        chart.pace[k] = (work.branches[k] - chart.branches[k]) / h
        chart.branches[k] = work.branches[k]
    chart.clock[0] = s.run[0].t
    if len(tree.closing.equations) == 0 or not loops_are_open(tree, work, s.bounds, s.lengths):
        return
    s.run[0].projections += 1
    # rounding adds up along loops of many bodies: what is within the bounds will do
    left = np.maximum(s.gaps, s.bounds)
    if not close_links(tree, work, s.run[0].t, 0.01 * s.bounds, left, program.equation_level):
        s.run[0].finite = 0
        return
    s.y[:nx], s.y[nx : nx + len(tree.v)] = tree.x, tree.v
    unit_length(chart.rows, s.y)
    s.y1[:] = s.y
    call_rates(s.run[0].rates, program, work, tree, s, s.run[0].t, 0)
