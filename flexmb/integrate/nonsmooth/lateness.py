"""By how much reactions of the midpoint rule are late: each is a mean over its step, which is the one half a step ago.

Half of the change from step to step is measured, whatever makes it. What vibrations lose of their phase besides is not
known: there is no second motion to compare with. Theory: integrators, "Reactions".
"""

from __future__ import annotations

import numpy as np

from flexmb.integrate.runs.reaction_errors import SHARE, add_difference, new_comparison, shares_of_reactions
from flexmb.math.kernel import kernel
from flexmb.math.weights import no_matrix
from flexmb.system.program import evaluate

__all__ = ["Lateness"]


@kernel
def _add(lam, last, middle, table):
    """Add the multipliers (ng,) of a step beside those half a step later; `middle` is scratch."""
    for i in range(len(lam)):
        middle[i] = 0.5 * (last[i] + lam[i])
    add_difference(lam, middle, table)


class Lateness:
    """How reactions change from step to step, where nothing touches."""

    def __init__(self, system):
        self.table = new_comparison(system)
        self.last, self.middle = np.zeros((2, system.ng))
        self.goes_on = False

    def add(self, lam: np.ndarray, touched: bool) -> None:
        """Take the multipliers of a step; those of what touches have impulses in them, which are no values to read."""
        if self.goes_on and not touched:
            _add(lam, self.last, self.middle, self.table)
        self.goes_on = not touched
        self.last[:] = lam

    def notes(self, system, state) -> list[str]:
        """Return the note about the joint whose reaction is late by most, if it is much."""
        if not system.ng:
            return []
        work = system.workspace()
        no_matrix(work.weights)
        evaluate(system.program, state, work)
        shares = shares_of_reactions(system, work, self.table)
        title = max(shares, key=lambda one: shares[one], default="")
        if not title or not shares[title] > SHARE:
            return []
        return [
            f"the reaction of {title} changes so fast that its samples, which are means over the step before them, are "
            f"late by about {100.0 * shares[title]:.2g} % of it on an average; a vibration that swings by itself loses "
            "its phase besides. Where single values of it matter, use a smaller step of MoreauJean, Explicit or IDA"
        ]
