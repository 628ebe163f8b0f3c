"""The distance of a second motion, without the local errors that are known, from a run of `Implicit`."""

from __future__ import annotations

from typing import Annotated, NamedTuple

import numpy as np

from flexmb.integrate.implicit.two_steps import ALL, KEPT, TREES
from flexmb.integrate.runs.gap import Gap, begin_again, new_gap
from flexmb.integrate.runs.reaction_errors import ENDED, new_comparison
from flexmb.math.structures import ArrayOf, FloatRows, Floats, Record, structure
from flexmb.math.tables import State

__all__ = ["Beside", "carry", "known", "new_beside", "uncertainty"]

MANY = 0.1
"""Part of the steps over which the distance may not be carried."""
GROWS = 0.5
"""Growth of the distance, over what local errors that stay as they are would make of it, from which on errors grow by
themselves: free bodies come to 0.47, driven double pendulums to 0.57 to 140."""
UNSURE = 6.0
"""By how much the error may then be larger than what is found: forty runs of driven double pendulums were 19 times at
the most, one of twenty more than 5 times."""


class BesideRun(Record):
    """How the motion beside goes on."""

    bent: float
    """s, size of the step before; 0 where there was none to compare how the distance bends with"""
    bent_before: float
    """s, of the one before that, likewise"""
    bends: float
    """square of how much the second rates of the distance bend over a step, the largest of late"""
    turns: float
    """square of how much they change over a step, likewise"""
    size: float
    """square of what the embedded method differed by in the rates, the largest of late"""
    wide: float
    """square of the distance in the rates, likewise"""
    before: float
    """s, size of the step before, whose rates are kept; 0 where there was none on the same side of a jump"""
    passed: float
    """s, what very short steps have gone since"""
    given_x: float
    """sum of the sizes of local errors, of the unknowns"""
    given_v: float
    """of their rates, likewise"""
    elapsed: float
    """s, that the motion has been followed for"""
    grown: float
    """size of the distance, over what local errors that stay as they are make of it, when it was largest"""
    stiff: int
    """steps over which the distance could not be carried"""
    swings: float
    """square of how much the distance itself changes over a step, the largest of late"""
    spread: float
    """square of its size, likewise"""
    closes: int
    """1: there are loops to be closed"""
    steps: int
    wild: int
    """1: the distance has grown within a step by more than steps resolve"""
    moving: int
    """rates before those of first-order states, whose numbers have units of their own"""


@structure
class Beside(NamedTuple):
    """The distance of the second motion from the run's, at the present time."""

    dx: Floats
    """(nx,) of the unknowns"""
    dv: Floats
    """(nv,) of their rates"""
    da: Floats
    """(nv,) of their second rates"""
    dlam: Floats
    """(ng,) of the multipliers"""
    dk: Floats
    """(nx,) of the first derivatives of the unknowns"""
    bx: Floats
    """(nx,) by how much the first derivatives of dx bend over a step, by the square of its size, the step before"""
    bv: Floats
    """(nv,) of dv, likewise"""
    cx: Floats
    """(nx,) bx a step earlier"""
    cv: Floats
    """(nv,) bv a step earlier"""
    kx: Floats
    """(nx,) the same of the step at hand"""
    kv: Floats
    x: Floats
    """the motion beside, as the next"""
    v: Floats
    a: Floats
    lam: Floats
    y: Floats
    """(nx,) x with unit Euler parameters"""
    k: Floats
    """(nx,) scratch, as the next four"""
    x0: Floats
    v0: Floats
    """(nv,) at the start of the step, as the next"""
    a0: Floats
    x1: Floats
    dx1: Floats
    dv1: Floats
    change: Floats
    """(nv,)"""
    right: Floats
    """(nu + ng,) right-hand side"""
    A: FloatRows
    """(KEPT, nv) rates of v at stages of the step before, as the next of x"""
    K: FloatRows
    """(KEPT, nx)"""
    trees: FloatRows
    """(9, 18) scratch, as the next two: see `weights_of_two`"""
    w: Floats
    sizes: Floats
    state: State
    """of all bodies"""
    free: Floats
    """(nv,) 1 of rates that follow the equations of motion, 0 of those that drives prescribe: they have no errors"""
    start: Floats
    """(nq,) configuration from which motion is counted"""
    reactions: FloatRows
    """(ng, 4) see `flexmb.integrate.runs.reaction_errors`"""
    own: Annotated[np.ndarray, ArrayOf(BesideRun.dtype)]
    """one row"""
    run: Annotated[np.ndarray, ArrayOf(Gap.dtype)]
    """one row"""


def new_beside(system, unknowns, state, followed: bool) -> Beside:
    """Return the motion beside at the start of a run, where it still is the same."""
    nx, nv, nu, ng = unknowns.nx, unknowns.nv, system.nu, system.ng
    sizes = dict.fromkeys(("dx", "dk", "bx", "cx", "kx", "x", "y", "k", "x0", "x1", "dx1"), nx)
    sizes |= dict.fromkeys(("dv", "da", "bv", "cv", "kv", "v", "a", "v0", "a0", "dv1", "change"), nv)
    sizes |= {"dlam": ng, "lam": ng, "right": nu + ng}
    free = np.ones(nv)
    free[unknowns.chart.driven[:, 1]] = 0.0
    return Beside(
        **{name: np.zeros(size) for name, size in sizes.items()},
        A=np.zeros((KEPT, nv)),
        K=np.zeros((KEPT, nx)),
        trees=np.zeros((TREES, ALL)),
        w=np.zeros(ALL),
        sizes=np.zeros(3),
        state=system.state(state.t),
        free=free,
        start=state.q.copy(),
        reactions=new_comparison(system),
        own=BesideRun.table(closes=int(unknowns.closes and ng > 0), moving=nv - int(np.sum(system.is_state))),
        run=new_gap(system, followed),
    )


def carry(before: Beside, now: Beside) -> None:
    """Give a new start the distance that the motions had; in a model with other unknowns its size alone is known."""
    closes, moving = int(now.own["closes"][0]), int(now.own["moving"][0])
    now.own[:] = before.own
    now.own["closes"], now.own["moving"], now.own["before"] = closes, moving, 0.0
    now.run[:] = before.run
    now.reactions[:] = ENDED  # the distance meets other equations: nothing is told of reactions from here on
    sizes = ("dx", "dv", "dlam", "start")  # a lock changes the equations alone
    if any(getattr(before, name).shape != getattr(now, name).shape for name in sizes):
        now.own["bent"] = now.own["bent_before"] = 0.0
        begin_again(now.run)
        return
    alike = before.dlam.shape == now.dlam.shape
    if not alike:  # other loops are closed: what the distance is stays known, how it goes on is not
        now.own["bent"] = now.own["bent_before"] = 0.0
    for name in ("dx", "dv", "start", *(("da", "dlam", "bx", "bv", "cx", "cv") if alike else ())):
        getattr(now, name)[:] = getattr(before, name)


def uncertainty(beside: Beside) -> float:
    """Return by how much the error may be larger than the distance: where errors grow, single ones decide."""
    return UNSURE if beside.own[0]["grown"] > GROWS else 1.0


def known(beside: Beside) -> bool:
    """Could the distance be carried over nearly all steps?"""
    own = beside.own[0]
    return bool(own["stiff"] <= MANY * max(own["steps"], 1) and not own["wild"])
