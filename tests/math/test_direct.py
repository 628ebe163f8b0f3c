"""Calls that go past the look at types: what they give, when they look again, and what they keep."""

import gc
import weakref
from typing import NamedTuple

import numpy as np
from numba import typeof

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


def test_types_that_were_seen_with_one_owner_are_not_looked_at_with_another(monkeypatch):
    """What decides is the type of every array and number, in structures too."""
    arguments = Pair(np.ones(2), np.ones(3)), np.ones(4), 2.0
    assert direct(first := Owner(), weighted)(*arguments) == 14.0
    looks = []
    monkeypatch.setattr("flexmb.math.direct.typeof", lambda one: looks.append(one) or typeof(one))
    assert direct(second := Owner(), weighted)(Pair(np.full(2, 2.0), np.ones(3)), np.ones(4), 2.0) == 18.0
    assert not looks
    others = [(np.ones(2, np.int64), 2.0), (np.ones(4)[::2], 2.0), (np.ones(2), True), (np.ones(2), np.float64(1.0))]
    for array, factor in others:  # compiled for these, not read as floats in a row
        again = Pair(np.ones(2), array), array, factor
        assert direct(Owner(), weighted)(*again) == factor * 4.0 + 2.0
    assert looks
    assert first is not second
