"""What an integrator remembers of its steps beside the state: kept where a run is cut off, and given back.

A method whose steps depend on those before takes others when it begins anew at the same state: where a contact has just
begun they differ by more than anything else.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from typing import Any

import numpy as np

from flexmb.integrate.runs.breaks import beside
from flexmb.integrate.runs.marks import meets_at_once
from flexmb.results.memory import Memory

__all__ = ["floats_of", "may_stop", "memory_of", "remember_again", "rounding"]


def floats_of(variables: Any, left_out: Collection[str]) -> Iterator[np.ndarray]:
    """Yield all arrays of floats of a structure and of those within it, fields of its tables of one row too.

    Whole numbers are none of them: some are places in arrays, which no file may choose.
    """
    for name, value in zip(variables._fields, variables, strict=True):
        if name in left_out:
            continue
        if isinstance(value, tuple):
            yield from floats_of(value, left_out)
        elif value.dtype.names is not None:
            fields = [field for field in value.dtype.names if field not in left_out]
            yield from (value[field] for field in fields if value.dtype[field] == np.dtype(float))
        elif value.dtype == np.dtype(float):
            yield value


def memory_of(integrator: Any, variables: Any) -> Memory | None:
    """Return what an integrator remembers at present; None if it has no memory, or does not tell."""
    tell = getattr(integrator, "memory", None)
    if tell is None:
        return None
    return Memory(of=repr(integrator), numbers=np.concatenate([np.empty(0), *(x.ravel() for x in tell(variables))]))


def remember_again(integrator: Any, system, variables: Any, start, phase, jumps) -> bool:
    """Let an integrator that was just started at the end of a phase know what it knew there.

    Return False if that is not known, belongs to another integrator, or a signal `jumps` or blocks hold something else
    from there on.
    """
    tell, memory = getattr(integrator, "memory", None), phase.memory
    held = [system.program.branches + number for hold in system.holds for number in hold.branches]
    if jumps or memory is None or tell is None or memory.of != repr(integrator):
        return False
    arrays, first = list(tell(variables)), 0
    same = np.array_equal(start.q[held], phase.q[-1][held])
    if not same or memory.numbers.shape != (sum(x.size for x in arrays),) or np.any(np.isnan(memory.numbers)):
        return False
    for array in arrays:
        array[...] = memory.numbers[first : first + array.size].reshape(array.shape)
        first += array.size
    return True


def may_stop(integrator: Any, marks: np.ndarray, first: int, mark: float, now: float, grace) -> bool:
    """May a run be cut off at the time `now`, behind a mark and before `marks[first]`?

    Not a rounding before a mark, for which the state that is kept would stand; and with `grace`, where events are
    looked for at marks and it will not take long to get to one, not between them: what the integrator knows there
    would be kept with no state.
    """
    between = now - mark > rounding(mark) and hasattr(integrator, "memory")
    return not (meets_at_once(marks, first, now) or (grace and between))


def rounding(t: float) -> float:
    """Return how far behind a mark an integrator may begin, where a signal jumps, s."""
    return 10.0 * float(beside(t))
