"""Calls that go past the look at types: what they give, when they look again, and what they keep."""

import gc
import weakref
from typing import NamedTuple

import numpy as np

from flexmb.math.direct import direct
from flexmb.math.kernel import kernel


class Owner:
    """Stands for a compiled system."""


class Pair(NamedTuple):
    """A structure of arrays."""

    x: np.ndarray
    y: np.ndarray


@kernel
def weighted(pair, a, factor):
    """Return the sum of all, weighed."""
    return factor * (np.sum(pair.x) + np.sum(pair.y)) + np.sum(a)


def test_other_structures_and_types_are_looked_at_and_no_array_is_kept():
    owner, pair = Owner(), Pair(np.ones(2), np.ones(3))
    call = direct(owner, weighted)
    assert call is direct(owner, weighted)
    a = np.ones(4)
    alive = weakref.ref(a)
    assert call(pair, a, 2.0) == 14.0
    del a
    gc.collect()
    assert alive() is None
    assert call(pair, np.full(5, 2.0), 2.0) == 20.0
    assert call(pair, np.ones(4, np.int64), 2.0) == 14.0  # of another type: not read as floats
    assert call(pair, np.ones(8)[::2], 2.0) == 14.0
    assert call(Pair(np.ones(2, np.int64), np.ones(3)), np.ones(4), 2) == 14.0
