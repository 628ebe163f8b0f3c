"""The storage of the explicit steps, and how they ask their unknowns for rates:
through addresses, compiled once for each.
"""

from __future__ import annotations

from typing import Annotated, NamedTuple

import numpy as np

from flexmb.math.program import PROGRAM
from flexmb.math.structures import ArrayOf, FloatRows, Floats, Integers, Record, numba_type, structure
from flexmb.math.tables import COUNT, NUMBER, WORK, caller, void
from flexmb.tree.rigid.link_tree import LINK_TREE

__all__ = [
    "ACCEPTING",
    "RATES",
    "STAGES",
    "Dense",
    "ExplicitRun",
    "Steps",
    "call_accepting",
    "call_rates",
]

STAGES = 12


class ExplicitRun(Record):
    """How far a run is, and how it goes on."""

    t: float
    """s"""
    next_step: float
    """s"""
    longest_step: float
    """s"""
    span: float
    """s, length of the run"""
    rtol: float
    sweeps: int
    """of the accelerations in a stage; 1 where they are linear and found by one evaluation"""
    last_sweeps: int
    """the same at the end of a step, where their convergence is looked at"""
    rates: int
    """address of what writes rates"""
    accepting: int
    """address of what accepts steps"""
    steps: int
    evaluations: int
    projections: int
    finite: int
    """1: the latest rates are numbers"""
    settled: int
    """1: the accelerations have settled"""
    short_steps: int
    """very short ones in a row"""


@structure
class Dense(NamedTuple):
    """Where the mass matrix stands, and which equations are taken first."""

    rows: Integers
    """(k,) of an entry of the mass matrix, as the next"""
    columns: Integers
    at: Integers
    """(k,) its place in the iteration matrix"""
    order: Integers
    """(ng,) of the equations: those that may depend on others last"""
    apart: Floats
    """(ng,) part of an equation beyond those before it, from which it counts"""


@structure
class Steps(NamedTuple):
    """Storage of the steps."""

    y: Floats
    """(n,) coordinates (of bodies with branches), velocities and works at the start of a step"""
    y1: Floats
    """(n,) the same where rates are asked for"""
    K: FloatRows
    """(13, n) rates of stages"""
    q: Floats
    """the state of a stage, as the next three"""
    u: Floats
    a: Floats
    lam: Floats
    right: Floats
    """scratch, as the next"""
    rate: Floats
    signals: FloatRows
    pace: Floats
    """(nb,) rate of the branches over the last step"""
    gaps: Floats
    """(ng,) see `project`"""
    bounds: Floats
    """(ng,) residuals, or per radian of motion their rates, at which the state is projected"""
    lengths: Floats
    """(ng,) m, of the bodies that an equation relates"""
    units: Floats
    """(nu,) see `project`"""
    atol: Floats
    """(n,) absolute tolerances"""
    run: Annotated[np.ndarray, ArrayOf(ExplicitRun.dtype)]
    """one row: how far it is, and how it goes on"""
    dense: Dense
    """of steps with accelerations in closed form"""
    A: FloatRows
    """coefficients of the method, as the next four"""
    B: Floats
    C: Floats
    E3: Floats
    E5: Floats


STEPS = numba_type(Steps)
RATES = void(PROGRAM, WORK, LINK_TREE, STEPS, NUMBER, COUNT)
"""(.., t, stage): write the rates of y1 at time t to K[stage]; the first and last belong to ends of steps."""
ACCEPTING = void(PROGRAM, WORK, LINK_TREE, STEPS, NUMBER)
"""(.., h): make y1 and K[-1], the end of a step of size h, the start y and K[0] of the next, on the constraints."""

call_rates = caller(RATES)
call_accepting = caller(ACCEPTING)
