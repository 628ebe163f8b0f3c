"""By how much reactions of the midpoint rule are late, and what vibrations in them lose of their phase.

Each is a mean over its step, which is the one half a step ago: half of the change from step to step is measured,
whatever makes it. A vibration at ``w`` comes forward by ``2 arctan(w h / 2)`` in a step instead of ``w h``. There is no
second motion to compare with, so the reaction tells itself how fast it swings: the k-th difference of a vibration by
``theta`` in a step is ``(2 sin(theta / 2))^k`` times as large as the vibration. Differences of order 0, 1 and 2 are
taken for three vibrations, beside what is slower, and each adds up what it loses, ``2 tan(theta / 2) - theta`` in a
step. Theory: integrators, "Reactions".
"""

from __future__ import annotations

import numpy as np

from flexmb.integrate.runs.reaction_errors import SHARE, add_difference, new_comparison, shares_of_reactions
from flexmb.math.kernel import kernel
from flexmb.math.weights import no_matrix
from flexmb.system.program import evaluate

__all__ = ["Lateness"]

LEVELS = 3
"""Vibrations that are looked for in a reaction."""
FASTEST = 1.9
"""Size of a difference, of that one order lower, that is still taken for a vibration: 2.5 radians a step."""


@kernel
def _add(lam, last, middle, table):
    """Add the multipliers (ng,) of a step beside those half a step later; `middle` is scratch."""
    for i in range(len(lam)):
        middle[i] = 0.5 * (last[i] + lam[i])
    add_difference(lam, middle, table)


@kernel
def _lose(lam, past, count, steps, sums, tables):
    """Add what vibrations have lost of their phase until a step with the multipliers (ng,).

    past : (3, ng), those of the steps before; count : how many of them belong to this motion; steps : until now
    sums : (4, ng), squares of the differences by order; tables : (3, ng, 4), errors and sizes
    """
    order = np.zeros(4)
    for i in range(len(lam)):
        order[0] = lam[i]
        order[1] = lam[i] - past[0, i]
        order[2] = lam[i] - 2.0 * past[0, i] + past[1, i]
        order[3] = lam[i] - 3.0 * past[0, i] + 3.0 * past[1, i] - past[2, i]
        if count > 2:
            for k in range(4):
                sums[k, i] += order[k] ** 2
            for k in range(3):
                if not sums[k, i] > 0.0:
                    continue  # nothing has changed yet
                ratio = min((sums[k + 1, i] / sums[k, i]) ** 0.5, FASTEST)
                theta = 2.0 * np.arcsin(0.5 * ratio)
                phase = steps * (2.0 * np.tan(0.5 * theta) - theta)
                swing = abs(order[k]) / ratio**k if ratio > 0.0 else 0.0
                wrong = swing * 2.0 * np.sin(0.5 * min(phase, np.pi))
                tables[k, i, 0] += wrong
                tables[k, i, 1] += abs(lam[i])
                tables[k, i, 2] += wrong * wrong
                tables[k, i, 3] += lam[i] * lam[i]
        past[2, i], past[1, i], past[0, i] = past[1, i], past[0, i], lam[i]


class Lateness:
    """How reactions change from step to step, where nothing touches."""

    def __init__(self, system, vibrates: bool):
        self.table = new_comparison(system)
        self.last, self.middle = np.zeros((2, system.ng))
        self.goes_on, self.count, self.h = False, 0, 0.0
        self.past, self.sums = np.zeros((3, system.ng)), np.zeros((LEVELS + 1, system.ng))
        self.steps, self.tables = 0, np.zeros((LEVELS, system.ng, 4))
        # drives that leave no freedom leave nothing that could swing by itself; of bodies without springs the reactions
        # have harmonics, whose phase is that of the motion
        self.loses = vibrates and system.nu > system.ng - len(system.redundant)

    def add(self, lam: np.ndarray, touched: bool, h: float) -> None:
        """Take the multipliers of a step; those of what touches have impulses in them, which are no values to read."""
        if self.goes_on and not touched:
            _add(lam, self.last, self.middle, self.table)
        self.goes_on = not touched
        self.last[:] = lam
        if not self.loses:
            return
        if touched or not 0.99 * self.h < h < 1.01 * self.h:  # differences need steps of one size
            self.count, self.h = 0, h
        if touched:  # what has struck makes vibrations that have lost nothing yet
            self.steps = 0
        if not touched:
            _lose(lam, self.past, self.count, self.steps, self.sums, self.tables)
            self.count, self.steps = self.count + 1, self.steps + 1

    def goes_on_from(self, before: Lateness) -> None:
        """Go on with what was told before, where the method begins anew."""
        self.table[...] = before.table
        self.sums[...], self.tables[...], self.steps = before.sums, before.tables, before.steps

    def notes(self, system, state) -> list[str]:
        """Return the notes about the joints whose reactions are late by most and have lost most, if it is much."""
        if not system.ng:
            return []
        work = system.workspace()
        no_matrix(work.weights)
        evaluate(system.program, state, work)
        lost: dict[str, float] = {}
        for table in self.tables if self.loses else ():
            for title, share in shares_of_reactions(system, work, table).items():
                lost[title] = max(share, lost.get(title, 0.0))
        return _late(shares_of_reactions(system, work, self.table)) + _lost(lost)


def _late(shares: dict[str, float]) -> list[str]:
    title = max(shares, key=lambda one: shares[one], default="")
    if not title or not shares[title] > SHARE:
        return []
    return [
        f"the reaction of {title} changes so fast that its samples, which are means over the step before them, are "
        f"late by about {100.0 * shares[title]:.2g} % of it on an average; a vibration that swings by itself loses "
        "its phase besides. Where single values of it matter, use a smaller step of MoreauJean, Explicit or IDA"
    ]


def _lost(shares: dict[str, float]) -> list[str]:
    title = max(shares, key=lambda one: shares[one], default="")
    if not title or not shares[title] > SHARE:
        return []
    much = f"about {100.0 * shares[title]:.2g} %" if shares[title] < 1.0 else "all"
    return [
        f"the reaction of {title} swings so fast that a vibration of that rate loses its phase in steps of this size: "
        f"where it swings by itself, not as loads or drives make it, {much} of the reaction is wrong on an average. "
        "The loss goes with the square of the step: where single values matter, use a smaller one, Explicit or IDA"
    ]
