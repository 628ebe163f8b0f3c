"""Values that blocks hold: where they stand, when they change, and what they change to."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from flexmb.errors import IntegrationError, ModelError
from flexmb.math.weights import no_matrix
from flexmb.model.held_block import HeldBlock
from flexmb.system.accelerations import accelerations, settled_accelerations
from flexmb.system.damped_accelerations import unsolved
from flexmb.system.program import evaluate

__all__ = ["HELD", "Hold", "held_from", "refuse_holds", "upstream_first"]

HELD = "held "
"""The names of such coordinates begin so."""
NEVER = -1e30
"""s, when nothing was sampled yet."""
MOST = 50
"""Changes that one change may bring about at once."""


@dataclass(frozen=True, eq=False)
class Hold:
    """A block that holds values.

    Parameters
    ----------
    title : str
    block : HeldBlock
    branches : tuple of int
        Which of the last coordinates are its values, in their order.
    reads : tuple of int
        Signals that it reads.
    crossing : int
        Signal that passes zero upwards where it changes, or -1.
    clock : int
        Which of the last coordinates is the time of its latest sample, or -1.
    period, offset : float, s
        Of its samples.
    """

    title: str
    block: HeldBlock
    branches: tuple[int, ...]
    reads: tuple[int, ...]
    crossing: int = -1
    clock: int = -1
    period: float = 1.0
    offset: float = 0.0


def upstream_first(holds: Sequence[Hold], needs: Sequence[set[int]]) -> list[Hold]:
    """Return blocks behind those whose values they read: `needs` are the branches on which each depends.

    Blocks that read each other see what the others held before.
    """
    found: list[Hold] = []
    opened: set[int] = set()

    def add(k: int) -> None:
        if k in opened:
            return
        opened.add(k)
        for other, hold in enumerate(holds):
            if needs[k] & set(hold.branches):
                add(other)
        found.append(holds[k])

    for k in range(len(holds)):
        add(k)
    return found


def held_from(system, work, t: float, q: np.ndarray, u: np.ndarray, passed: str = "") -> np.ndarray:
    """Return q with the values that blocks hold from time t on: what is due is sampled, what has passed switches.

    The block with the title `passed` has reached its threshold, whatever is rounded.

    Raises
    ------
    IntegrationError
        Blocks switch each other without end.
    """
    if not system.holds:
        return q
    q, first = np.array(q, float), system.program.branches
    for hold in system.holds:
        if hold.clock >= 0 and _due(hold, t, q[first + hold.clock]):
            _change(hold, system, work, t, q, u)
            q[first + hold.clock] = _nearest(hold, t)
    over = [hold for hold in system.holds if hold.title == passed]
    for _ in range(MOST):
        for hold in over:
            _change(hold, system, work, t, q, u)
        signals = _signals(system, work, t, q, u)
        over = [hold for hold in system.holds if hold.crossing >= 0 and signals[hold.crossing] > 0.0]
        if not over:
            return q
    raise IntegrationError(
        over[0].title,
        found=f"it switches without end at t = {t:.9g} s",
        expected="a signal that its own switching does not bring back at once",
        remedy="Put a lag into the loop, or set the limits farther apart",
    )


def _nearest(hold: Hold, t: float) -> float:
    """Return the sample time next to t."""
    return hold.offset + hold.period * np.round((t - hold.offset) / hold.period)


def _due(hold: Hold, t: float, latest: float) -> bool:
    nearest, near = _nearest(hold, t), 1e-9 * hold.period + 1e-11 * abs(t)
    return abs(t - nearest) <= near and abs(nearest - latest) > near


def _signals(system, work, t: float, q: np.ndarray, u: np.ndarray) -> np.ndarray:
    """Return the values of all signals, (ns,)."""
    state = system.state(t, q, u)
    if system.implicit or system.samples_reactions:
        right = np.zeros(system.nu + system.ng)
        accelerations(system.program, state, work, right, 12 if system.redundant else 2)
        if not settled_accelerations(system, state, work, right):
            raise unsolved(system, "Accelerations")
    no_matrix(work.weights)
    evaluate(system.program, state, work)
    return state.signals[:, 0]


def _change(hold: Hold, system, work, t: float, q: np.ndarray, u: np.ndarray) -> None:
    at = system.program.branches + np.array(hold.branches)
    read = _signals(system, work, t, q, u)[list(hold.reads)]
    q[at] = hold.block.following(q[at], read)


def refuse_holds(system, asker: str) -> None:
    """Raise ModelError if blocks hold values, which jump in time, of which the asker knows nothing."""
    if system.holds:
        first = system.holds[0]
        raise ModelError(
            asker,
            found=f"{first.title} holds values that jump as time passes",
            expected="signals that are smooth functions of the motion",
            remedy=f"Put its continuous counterpart in the place of {first.title} (Pid, StateSpace, Limit, table), or "
            "an input of its value; or use simulate",
        )
