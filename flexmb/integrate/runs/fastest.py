"""The part of a model that moves fastest, for which steps are short; and looks at a run that leave no trace in it."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np

from flexmb.integrate.extent import extents

__all__ = ["fastest", "unchanged"]


def fastest(integrator, system, work, variables, now: float) -> str:
    """Return the words for the part whose acceleration is largest at the time that a run has reached, s."""
    with unchanged(system, work):  # the run must not depend on when the clock has struck
        rows = integrator.run(system, work, variables, np.array([now]), 0, 1).rows
        if not len(rows["t"]):
            return ""
        q, u, a = (np.ascontiguousarray(rows[name][-1]) for name in "qua")
        extent, _ = extents(system, system.state(now, q, u), work)
    size = np.where(np.isfinite(a), np.abs(a) * extent, np.inf)
    if not len(size) or not size.max() > 0.0:
        return ""
    worst = int(np.argmax(size))
    unit = "rad" if system.is_turn(worst) else "m"
    return f"; the fastest is {system.owner(worst)} ({u[worst]:.3g} {unit}/s, {a[worst]:.3g} {unit}/s2)"


@contextmanager
def unchanged(system, work) -> Iterator[None]:
    """Give the scratch arrays of a system back as they were, and the factors of its matrix, however the block ends."""
    pattern = system.program.pattern
    arrays = (*work, pattern.inverse, pattern.scratch, pattern.softness)
    before = [array.copy() for array in arrays]
    try:
        yield
    finally:
        for array, kept in zip(arrays, before, strict=True):
            array[...] = kept
