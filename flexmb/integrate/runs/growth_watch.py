"""Growth that the steps of a run moved on from outside pass over: looked at now and then, and where it ends.

What other programs set between the steps is held while the equations are looked at: a growth by way of them is theirs.
"""

from __future__ import annotations

from typing import Any

from flexmb.errors import IntegrationError
from flexmb.integrate.runs.outgrown import unstable_at_end, unstable_in_steps
from flexmb.integrate.runs.runaway import that_follow
from flexmb.results import Status

__all__ = ["GrowthWatch"]

FIRST = 16
"""Calls after which a run is looked at for the first time, then after twice as many: a look costs an eigenvalue
problem."""


class GrowthWatch:
    """Looks at one phase of a stepped run.

    Parameters
    ----------
    system : System
    """

    def __init__(self, system):
        self.system, self.follows = system, bool(that_follow(system))
        self._start: Any = None
        self._calls, self._next, self._told = 0, FIRST, False
        self._steps = 0

    def begin(self, state, steps: int) -> None:
        """Note the state at which the phase began, or, where the integrator begins anew in it, the steps before."""
        if self._start is None:
            self._start = state
        self._steps += steps

    def saved(self, steps: int) -> tuple[Any, ...]:
        """Return what is known when so many `steps` were taken since the integrator began last."""
        return self._start, self._calls, self._next, self._told, self._steps + steps

    def restore(self, saved: tuple[Any, ...], steps: int) -> None:
        """Forget what came after `saved`, where the integrator now has taken so many `steps`."""
        self._start, self._calls, self._next, self._told, total = saved
        self._steps = total - steps

    def is_due(self) -> bool:
        """Count a call; is it time to look?"""
        self._calls += 1
        if not self.follows or self._calls < self._next:
            return False
        self._next *= 2
        return True

    def require_followed(self, rows: list[dict[str, Any]], end: float, steps: int) -> None:
        """Raise IntegrationError if the steps until `end` have passed over a growth; see `unstable_in_steps`.

        `steps` : of the integrator since it began last.
        """
        gone, _ = self._found(rows, end, steps)
        if gone is not None:
            self._told = True
            raise IntegrationError(
                f"Model '{self.system.model.name}'",
                found=gone.message,
                expected="a motion that the integrator can follow",
                remedy=gone.remedy,
            )

    def sentences(self, rows: list[dict[str, Any]], end: float, steps: int) -> list[str]:
        """Return the words about a growth that has been passed over, or that nothing sets going; once."""
        if self._told or not self.follows:
            return []
        gone, stands = self._found(rows, end, steps)
        words = stands if gone is None else [f"Model '{self.system.model.name}': {gone.message}. {gone.remedy}"]
        self._told = bool(words)
        return words

    def at_failure(self, row: dict[str, Any], reached: float) -> str | None:
        """Return the words about a growth that explains why a step has failed, or None."""
        if not self.follows:
            return None
        return unstable_at_end(self.system, self.system.workspace(), self._start, row, reached)

    def _found(self, rows: list[dict[str, Any]], end: float, steps: int) -> tuple[Status | None, list[str]]:
        # a workspace of its own: the steps go on with the factors that the last one has left in theirs
        return unstable_in_steps(self.system, self.system.workspace(), self._start, rows, end, self._steps + steps)
