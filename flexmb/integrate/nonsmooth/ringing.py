"""What steps of the midpoint rule lose of reactions that swing: there is no second motion to compare with, but the rule
tells by how much it lags behind a vibration.

From step to step a vibration by w h radians of time has central differences of first and second order with the ratio
w h, whatever its amplitude, and gets a phase of 2 atan(w h / 2). A reaction is a mean over its step. Theory:
integrators, "Reactions".
"""

from __future__ import annotations

import numpy as np

from flexmb.integrate.runs.reaction_errors import SHARE, shares_of_reactions
from flexmb.math.kernel import kernel
from flexmb.math.weights import no_matrix
from flexmb.system.program import evaluate

__all__ = ["Ringing"]

SIZE, FIRST, SECOND, LATE, PLAIN, BENT = range(6)
"""Columns: sums over steps of the squares of multipliers, of their first and second differences, and of first
differences times the steps since something touched; sums of the sizes of first and second differences."""


@kernel
def _add(lam, last, before, sums, steps):
    """Add the multipliers (ng,) of a step; `last` and `before` are those of the two steps before it."""
    for i in range(len(lam)):
        sums[i, SIZE] += lam[i] * lam[i]
        if steps >= 2:
            first, second = 0.5 * (lam[i] - before[i]), lam[i] - 2.0 * last[i] + before[i]
            sums[i, FIRST] += first * first
            sums[i, SECOND] += second * second
            sums[i, LATE] += first * first * steps * steps
            sums[i, PLAIN] += abs(first)
            sums[i, BENT] += abs(second)
        before[i], last[i] = last[i], lam[i]


class Ringing:
    """How multipliers swing from step to step, where nothing touches."""

    def __init__(self, system):
        self.sums = np.zeros((system.ng, 6))
        self.last, self.before = np.zeros((2, system.ng))
        self.steps = 0

    def add(self, lam: np.ndarray, touched: bool) -> None:
        """Take the multipliers of a step; what touches shakes anew, and is no vibration."""
        if touched:
            self.steps = 0
            return
        _add(lam, self.last, self.before, self.sums, self.steps)
        self.steps += 1

    def _lost(self) -> tuple[np.ndarray, np.ndarray]:
        """Return what reactions lose (ng,), squares summed over steps, and the angles by which they swing in a step.

        Both kinds of sums have one ratio in a vibration; a short pulse now and then has it in squares alone.
        """
        size, first, second, late, plain, bent = self.sums.T
        swings = np.isfinite(self.sums).all(axis=1) & (first > 0.0)
        first, plain = np.where(swings, first, 1.0), np.where(swings, plain, 1.0)
        turn = np.where(swings, np.minimum(np.sqrt(second / first), bent / plain), 0.0)
        angle = 2.0 * np.arctan(0.5 * turn)
        phase = (turn - angle) ** 2 * late / first + (0.5 * angle) ** 2
        amplitude = np.where(swings, first / np.maximum(np.sin(angle) ** 2, 1e-300), 0.0)  # squares, summed
        return np.minimum(amplitude, size) * np.minimum(phase, 2.0), angle

    def notes(self, system, state) -> list[str]:
        """Return the note about the joint whose reaction loses most, if it is much."""
        if not system.ng:
            return []
        (error, angle), size = self._lost(), self.sums[:, SIZE]
        table = np.column_stack([np.sqrt(error), np.sqrt(size), error, size])
        work = system.workspace()
        no_matrix(work.weights)
        evaluate(system.program, state, work)
        shares = shares_of_reactions(system, work, table)
        title = max(shares, key=lambda one: shares[one], default="")
        if not title or not shares[title] > SHARE:
            return []
        span = next(s for name, s in system.joint_equations.items() if system.model.joint(name, "").title == title)
        in_step = float(angle[span][np.argmax(error[span])])
        period = max(2.0, 2.0 * np.pi / in_step)
        return [
            f"the reaction of {title} swings within {period:.2g} steps, and MoreauJean does not check how well steps "
            f"resolve reactions: if it swings by itself, it loses its phase, on an average by about "
            f"{100.0 * shares[title]:.2g} % of the reaction. Where single values of it matter, compare with a tenth of "
            "the step, or with Explicit or IDA"
        ]
