"""Absolute tolerances of the unknowns of `Explicit`."""

from __future__ import annotations

import numpy as np

from flexmb.integrate.extent import SLOW, absolute_tolerance, extents

__all__ = ["ATOL", "tolerances"]

ATOL = 1e-10
"""Usual absolute tolerance: m, rad and per second."""


def tolerances(settings, motion, state, span: float) -> np.ndarray:
    """Return the absolute tolerances of coordinates, rates and the three works, (n,).

    The usual one counts displacements of the material: what a unit of a flexible coordinate amounts to depends on how
    the data scale their modes. Rates have it per second in runs of up to `SLOW`, in longer ones per part of the run.

    Parameters
    ----------
    settings : Explicit
    motion : Motion
    state : State
        At the start of the run.
    span : float, s
        Length of the run.
    """
    system, unknowns = motion.system, motion.unknowns
    x, v, _ = unknowns.of(state)
    nx = len(x)
    found = np.full(nx + len(v) + 3, absolute_tolerance(settings.atol, ATOL, system))
    if settings.atol is not None:
        return found
    extent = extents(system, state, motion.work)[0]
    for coordinate, rate, first, count in unknowns.vectors():
        size = extent[first : first + count]
        size = np.where(size > 0.0, size, 1.0)
        found[coordinate : coordinate + count] /= size
        found[nx + rate : nx + rate + count] /= size
    found[nx : nx + len(v)] *= min(1.0, SLOW / span)
    return found
