"""The part of a model that moves fastest, for which steps are short; and looks at a run that leave no trace in it."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np

from flexmb.integrate.extent import extents

__all__ = ["fastest", "unchanged"]


def fastest(integrator, system, work, variables, now: float) -> str:
    """Return the words for what changes at the highest rate at the time that a run has reached, s.

    The rate of a motion is the root of its acceleration over its length of reference, that of a first-order state its
    relative change, 1/s.
    """
    with unchanged(system, work):  # the run must not depend on when the clock has struck
        rows = integrator.run(system, work, variables, np.array([now]), 0, 1).rows
        if not len(rows["t"]):
            return ""
        q, u, a = (np.ascontiguousarray(rows[name][-1]) for name in "qua")
        extent, reach = extents(system, system.state(now, q, u), work)
    states = system.is_state
    rate = np.where(states, np.abs(a) / np.maximum(np.abs(u), reach), np.sqrt(np.abs(a) * extent / reach))
    rate = np.where(np.isfinite(a), rate, np.inf)
    if not len(rate) or not rate.max() > 0.0:
        return ""
    worst = int(np.argmax(rate))
    owner = system.owner(worst)
    if states[worst]:
        return f"; the fastest is {owner} ({u[worst]:.3g}, its rate {a[worst]:.3g} 1/s)"
    unit = "rad" if system.is_turn(worst) else "m"
    return f"; the fastest is {owner} ({u[worst]:.3g} {unit}/s, {a[worst]:.3g} {unit}/s2)"


@contextmanager
def unchanged(system, work) -> Iterator[None]:
    """Give the scratch arrays of a system back as they were, and the factors of its matrix, however the block ends."""
    pattern = system.program.pattern
    arrays = (*work, pattern.scratch, pattern.softness)
    before = [array.copy() for array in arrays]
    try:
        yield
    finally:
        for array, kept in zip(arrays, before, strict=True):
            array[...] = kept
