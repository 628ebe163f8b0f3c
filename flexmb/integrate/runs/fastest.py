"""The part of a model that moves fastest, for which steps are short; and looks at a run that leave no trace in it."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np

from flexmb.integrate.extent import extents
from flexmb.integrate.runs.block_start import copied, scratch, shared

__all__ = ["fastest", "present_rows", "unchanged"]


def fastest(integrator, system, work, variables, now: float) -> str:
    """Return the words for what changes at the highest rate at the time that a run has reached, s.

    The rate of a motion is the root of its acceleration over its length of reference, that of a first-order state its
    relative change, 1/s.
    """
    rows = present_rows(integrator, system, work, variables, now)
    if not len(rows["t"]):
        return ""
    with unchanged(system, work):
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


def present_rows(integrator, system, work, variables, now: float) -> dict[str, np.ndarray]:
    """Return the row of a sample at the time that a run has reached, s, or none; the run goes on as if there were none.

    It must not depend on when the clock has struck: a sample compares reactions, too.
    """
    known: dict[str, object] = {}
    try:
        variables = copied(variables, shared(integrator, system, work))
    except TypeError:  # of the solver of IDA: a sample of it leaves nothing but scratch, and what it counts by
        known = dict(vars(variables))
    with unchanged(system, work), np.errstate(all="ignore"):
        rows = integrator.run(system, work, variables, np.array([now]), 0, 1).rows
    for name, value in known.items():
        setattr(variables, name, value)
    return rows


@contextmanager
def unchanged(system, work) -> Iterator[None]:
    """Give the scratch arrays of a system back as they were, and the factors of its matrix, however the block ends."""
    arrays = scratch(system, work)
    before = [array.copy() for array in arrays]
    try:
        yield
    finally:
        for array, kept in zip(arrays, before, strict=True):
            array[...] = kept
