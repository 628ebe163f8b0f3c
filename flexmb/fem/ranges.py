"""How long the ranges of numbers in meshes and decks may be: THRU of Nastran, GENERATE of Abaqus."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

__all__ = ["LARGEST", "MANY", "RANGE", "members_in"]

LARGEST = 10**15
"""Integers stay below."""
MANY = 50_000_000
"""More numbers than a set of any deck holds: GENERATE with a wrong increment."""
RANGE = 1_000_000
"""Numbers that ranges may span where they are not compared with the numbers that exist."""


def members_in(span: range, known: Sequence[ArrayLike], before: int = 0) -> np.ndarray:
    """Return the numbers of a range, ascending; where they are more than `RANGE`, with those `before`, only those that
    one of the lists `known` has.
    """
    if before + len(span) <= RANGE:
        return np.arange(span.start, span.stop, span.step, dtype=np.int64)
    there = np.unique(np.concatenate([np.zeros(0, np.int64), *(np.asarray(numbers, np.int64) for numbers in known)]))
    inside = (there >= span.start) & (there < span.stop)
    return there[inside & ((there - span.start) % span.step == 0)]
