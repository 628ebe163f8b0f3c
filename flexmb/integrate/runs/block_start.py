"""Where a block of steps began: an event within the block takes the integrator back, and on to the row before it.

How far a block goes past an event depends on the clock, and on what else the machine has to do. What an integrator
knows there, the errors that have added up and the number of its steps, must not.
"""

from __future__ import annotations

import copy
from typing import Any

import numpy as np

__all__ = ["BlockStart", "copied", "scratch", "shared"]


class BlockStart:
    """The latest start of a block in a phase that waits for events.

    Parameters
    ----------
    integrator, system, work
        Of the phase.
    """

    def __init__(self, integrator: Any, system: Any, work: Any):
        self._integrator, self._system, self._work = integrator, system, work
        self._same: dict[int, Any] | None = None
        self._variables: Any = None
        self._arrays: list[np.ndarray] = []
        self._marks, self._first = np.empty(0), -1
        self._copies = not hasattr(integrator, "taken_back")

    def keep(self, variables: Any, marks: np.ndarray, first: int) -> None:
        """Keep what the steps to `marks[first]` begin with; what is kept of the same ones already stays."""
        if not self._copies:
            self._integrator.may_go_back(variables)
            return
        if first == self._first and marks is self._marks:
            return
        self._marks, self._first = marks, first
        arrays = scratch(self._system, self._work)
        if self._arrays:
            for kept, array in zip(self._arrays, arrays, strict=True):
                kept[...] = array
        else:
            self._arrays = [array.copy() for array in arrays]
        if self._same is None:  # phases without events never ask
            self._same = shared(self._integrator, self._system, self._work)
        self._variables = copied(variables, self._same)

    def back(self, variables: Any, n: int) -> Any:
        """Return the variables of the integrator, which has come further, at the row n of the block; 0 is its start."""
        first, self._first = self._first, -1
        if not self._copies:
            return self._integrator.taken_back(variables, n)
        variables, self._variables = self._variables, None
        for array, kept in zip(scratch(self._system, self._work), self._arrays, strict=True):
            array[...] = kept
        if n:
            self._integrator.run(self._system, self._work, variables, self._marks, first, first + n)
        return variables


def scratch(system: Any, work: Any) -> list[np.ndarray]:
    """Return the arrays of a system that steps write to and later ones read."""
    pattern = system.program.pattern
    return [*work, pattern.scratch, pattern.softness]


def shared(integrator: Any, system: Any, work: Any) -> dict[int, Any]:
    """Return what a copy of an integrator's variables shares with them, by identity."""
    return {id(one): one for one in (system, work, system.model, integrator, *work, *_parts(system.program))}


def copied(variables: Any, same: dict[int, Any]) -> Any:
    """Return an integrator's variables with arrays of their own, but for what is `shared`.

    Raises
    ------
    TypeError
        If the solver keeps its state to itself, as that of IDA does.
    """
    return copy.deepcopy(variables, dict(same))


def _parts(table: Any) -> list[Any]:
    """Return a structure with all that it holds."""
    inner = table if isinstance(table, tuple) else ()
    return [table, *(part for one in inner for part in _parts(one))]
