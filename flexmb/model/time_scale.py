"""How finely time must be divided to see what a signal does: a pulse that lasts a thousandth of a run is not missed.

A cell of time is resolved if the signal is nearly a parabola there: bounds of its second rate tell how nearly.
"""

from __future__ import annotations

import numpy as np

from flexmb.math import operations as op
from flexmb.math.interval_jets import bounds
from flexmb.model.expression import SignalProgram

__all__ = ["entries", "resolution"]

SHARE, SMALL = 0.01, 1e-5
"""What a parabola may miss: relative to the change over the cell, and to the largest value of the signal."""
SHORTEST = 1e-7
"""Length of a cell, relative to the run, that is not halved any more."""
MOST = 500_000
"""Cells that are looked at together before the search ends."""
BEFORE, FINER, ENTRY = 40, 4.0, 100
"""Where cells become so many times finer than the longest of so many before, so many are marked from the last
such on: a pulse is over then, its slow end too, and what lasts longer the integrator has seen."""


def resolution(program: SignalProgram, pieces: np.ndarray) -> tuple[np.ndarray, bool]:
    """Return the times (n,) that divide a signal into cells which a parabola resolves, and if all cells are.

    Parameters
    ----------
    pieces : (m,), s
        Begin, the times at which operations change pieces, end: see `breakpoints`.
    """
    a, b = pieces[:-1], pieces[1:]
    if op.TIME not in program.ops or not len(a):
        return np.empty(0), True
    at, shortest = 0.5 * (a + b), SHORTEST * (pieces[-1] - pieces[0])
    done, size = [pieces], 0.0
    while len(a):
        within = bounds(program.ops, program.args, program.tables, a, b, at)
        f = [_values(program, t, at) for t in (a, 0.5 * (a + b), b)]
        size = max(size, *(float(np.abs(x[np.isfinite(x)]).max(initial=0.0)) for x in f))
        with np.errstate(invalid="ignore"):
            change = np.maximum(np.abs(f[2] - f[0]), np.abs(f[0] - 2.0 * f[1] + f[2]))
            missed = (within.second[1] - within.second[0]) * (b - a) ** 2 / 8.0
        split = ~(missed <= np.maximum(SMALL * size, SHARE * change)) & (b - a > shortest)
        split &= np.any(np.isfinite(f), axis=0)  # where it is no number nothing is to be seen
        if np.count_nonzero(split) > MOST:
            return np.empty(0), False
        a, b, at = a[split], b[split], at[split]
        middle = 0.5 * (a + b)
        done.append(middle)
        a, b, at = np.concatenate([a, middle]), np.concatenate([middle, b]), np.tile(at, 2)
    edges = np.unique(np.concatenate(done))
    return entries(_merged(program, edges, size)), True


def _values(program: SignalProgram, t: np.ndarray, at: np.ndarray) -> np.ndarray:
    """Return the values at times t of the pieces that hold at `at`."""
    return bounds(program.ops, program.args, program.tables, t, t, at).value[0]


def _merged(program: SignalProgram, edges: np.ndarray, size: float) -> np.ndarray:
    """Return the edges of cells of which two neighbours are one where the signal is straight over both."""
    values = _values(program, edges, edges)
    for _ in range(60):
        left, middle, right = edges[:-2:2], edges[1:-1:2], edges[2::2]
        f, g, h = values[:-2:2], values[1:-1:2], values[2::2]
        share = (middle - left) / (right - left)
        alike = (share > 0.3) & (share < 0.7)
        with np.errstate(invalid="ignore"):
            straight = np.abs(g - f - share * (h - f)) <= np.maximum(SMALL * size, SHARE * np.abs(h - f))
        if not np.any(alike & straight):
            return edges
        keep = np.ones(len(edges), bool)
        keep[1:-1:2] = ~(alike & straight)
        edges, values = edges[keep], values[keep]
    return edges


def entries(edges: np.ndarray) -> np.ndarray:
    """Return the edges (n,) of the first cells of every stretch of time in which cells are finer than before."""
    lengths = np.diff(edges)
    before = np.full(len(lengths), np.inf)
    if len(lengths) > BEFORE:
        before[BEFORE:] = np.lib.stride_tricks.sliding_window_view(lengths[:-1], BEFORE).max(axis=1)
    begins = np.flatnonzero(before > FINER * lengths)
    keep = np.unique(np.minimum(begins[:, None] + np.arange(ENTRY), len(lengths) - 1))
    return np.unique(np.concatenate([edges[:-1][keep], edges[1:][keep]]))
