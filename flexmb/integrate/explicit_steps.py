"""The storage of the explicit steps, and how they ask their unknowns for rates:
through addresses, compiled once for each.
"""

from __future__ import annotations

from collections import namedtuple

from flexmb.math.program import PROGRAM
from flexmb.math.tables import COUNT, FLOATS, INTEGERS, NUMBER, WORK, caller, tuple_type, void
from flexmb.tree.link_tree import LINK_TREE

__all__ = [
    "ACCEPTING",
    "NUMBERS",
    "PROJECTIONS",
    "RATES",
    "SETTLED",
    "SHORTS",
    "STAGES",
    "Steps",
    "call_accepting",
    "call_rates",
]

STAGES = 12

Steps = namedtuple(
    "Steps", "y y1 K q u a lam right rate signals pace gaps bounds units counts times limits sweeps calls A B C E3 E5"
)
"""Storage of the steps.

y, y1 (n,) : coordinates (of bodies with branches), velocities and works, at the start of a step and where rates are
asked for; K (13, n): rates of stages
q, u, a, lam, right, rate, signals : the state of a stage; scratch
pace (nb,) : rate of the branches over the last step; gaps (ng,), units (nu,): see `project`;
bounds (ng,): residuals, or per radian of motion their rates, at which the state is projected
counts (6,) : steps, evaluations, projections; are the latest rates numbers; have the accelerations settled; very short
steps in a row
times (4,): t, next step, longest step, length of the run
limits (3,) : rtol, atol, length of the model (m)
sweeps (2,) : of the accelerations in a stage, and at the end of a step, where their convergence is looked at
calls (2,) : addresses of what writes rates and of what accepts steps
"""

PROJECTIONS, NUMBERS, SETTLED, SHORTS = 2, 3, 4, 5

STEPS = tuple_type(
    Steps,
    FLOATS,
    FLOATS,
    (FLOATS, 2),
    *[FLOATS] * 6,
    (FLOATS, 2),
    *[FLOATS] * 4,
    INTEGERS,
    FLOATS,
    FLOATS,
    INTEGERS,
    INTEGERS,
    (FLOATS, 2),
    *[FLOATS] * 4,
)
RATES = void(PROGRAM, WORK, LINK_TREE, STEPS, NUMBER, COUNT)
"""(.., t, stage): write the rates of y1 at time t to K[stage]; the first and last belong to ends of steps."""
ACCEPTING = void(PROGRAM, WORK, LINK_TREE, STEPS, NUMBER)
"""(.., h): make y1 and K[-1], the end of a step of size h, the start y and K[0] of the next, on the constraints."""

call_rates = caller(RATES)
call_accepting = caller(ACCEPTING)
