"""How the iteration of a step of `MoreauJean` goes: how fast it converges, and when it ends."""

from __future__ import annotations

import numpy as np

__all__ = ["LEAST", "Course"]

SETTLED, LEAST = 1e-10, 1e-6
"""Change of the velocities in an iteration, relative to them, at which it ends, and up to which a step is taken."""
ITERATIONS, MANY, SLOW = 20, 60, 0.1
"""Iterations, those where forces follow accelerations, and the rate of convergence that asks for a new matrix there."""


class Course:
    """The course of the iteration of one step for `nu` velocities; `follows`: forces follow accelerations."""

    def __init__(self, nu: int, follows: bool):
        self.follows = follows
        self.most = MANY if follows else ITERATIONS
        self.change, self.before, self.rate = np.inf, np.inf, 0.0
        self.correction = np.zeros(nu)
        self.share, self.calm = 1.0, 0

    def wants_matrix(self, iteration: int) -> bool:
        """A force that follows accelerations has its share in the matrix, which changes at its corners."""
        return iteration == 0 or (self.follows and self.rate > SLOW)

    def take(self, correction: np.ndarray, size: float) -> float:
        """Take note of a correction of velocities of that size; return which share of it is to be added."""
        last, self.correction = self.correction, correction
        self.before, self.change = self.change, float(np.max(np.abs(correction), initial=0.0)) / max(size, 1e-300)
        self.rate = self.change / self.before if self.before > 0.0 else 0.0
        if self.follows:  # whole steps may lead from one side of a corner to the other and back
            self.calm = 0 if self.rate > 0.5 and correction @ last < 0.0 else self.calm + 1
            if self.calm == 0:
                self.share *= 0.5
            elif self.calm > 1:
                self.share = min(1.0, 2.0 * self.share)
        return self.share

    def is_lost(self, iteration: int) -> bool:
        """Does the iteration go astray?"""
        return not np.isfinite(self.change) or (not self.follows and iteration > 4 and self.change > 10.0 * self.before)

    def is_settled(self, iteration: int) -> bool:
        """Is nothing left to correct, or rounding alone?"""
        if self.share < 1.0:
            return False
        rounding = iteration > 1 and self.change <= 1e-7 and self.change > 0.5 * self.before
        return self.change <= SETTLED or rounding
