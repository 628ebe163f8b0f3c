"""Kernels get structures by address: every field arrives, nothing is counted twice, nothing is used when it is gone."""

import sys
from typing import NamedTuple

import numpy as np
import pytest
from numba import typeof
from numba.core.errors import NumbaError
from numba.core.registry import cpu_target
from numba.core.runtime import _nrt_python, rtsys

from flexmb.math.kernel import inner_kernel, kernel
from flexmb.math.remembered_types import ComparedFlags, remembering
from flexmb.math.structure_type import Structure, read_as_structure
from flexmb.math.structures import FloatRows, Floats, Integers, numba_type, structure


@structure
class Inner(NamedTuple):
    values: Floats
    factor: float


@structure
class Outer(NamedTuple):
    flag: bool
    count: int
    rows: FloatRows
    inner: Inner
    places: Integers


class Remembered(NamedTuple):
    """Any array beside any number."""

    array: np.ndarray
    number: float


read_as_structure(Remembered)


@kernel
def weighted(o):
    total = 0.0
    for k in o.places:
        total += o.inner.factor * o.inner.values[k] + o.rows[k, 1]
    return total + o.count if o.flag else -total


@kernel
def through_another(o):
    return weighted(o)


@kernel
def parts(o):
    return o.flag, o.count, o.inner.factor, o.rows[1, 0]


@kernel
def made_here(o, n):
    total = 0.0
    for k in range(n):
        row = Inner(o.rows[k], 10.0 * k)
        total += row.factor * row.values[1]
    return total


@inner_kernel
def read(pair, k):
    spoiled = np.full(3, 1e30)  # takes the memory of an array that has been let go too early
    return spoiled[0] * 0.0 + pair.values[k] * pair.factor


@kernel
def made_of_own(n):
    total = 0.0
    for k in range(n):
        own = np.ones(3)
        own[0] = k
        pair = Inner(own, 2.0)
        total += read(pair, 0)
    return total


@kernel
def chosen_of_own(n, wanted):
    if not wanted:
        return 0.0
    pair = Inner(factor=3.0, values=np.full(n, 2.0))
    return read(pair, n - 1)


@kernel
def new_array(o):
    return o.inner.values * 2.0


@kernel
def written(o, k):
    o.inner.values[k] = -1.0
    view = o.rows[k]
    view[0] = -2.0


def returned(o):
    return Inner(o.inner.values, 1.0).values[0] if o.flag else given_back(o).values[0]


@inner_kernel
def given_back(o):
    return Inner(o.inner.values, 2.0)


def outer(flag=True):
    return Outer(flag, 7, np.arange(6.0).reshape(3, 2), Inner(np.array([10.0, 20.0, 30.0]), 0.5), np.array([0, 2]))


def test_every_field_arrives():
    assert weighted(outer()) == 0.5 * (10.0 + 30.0) + (1.0 + 5.0) + 7
    assert through_another(outer(False)) == -26.0
    assert parts(outer()) == (True, 7, 0.5, 2.0)
    assert parts(outer(False)._replace(count=-3)) == (False, -3, 0.5, 2.0)


def test_arrays_are_those_of_the_caller():
    given = outer()
    written(given, 1)
    np.testing.assert_array_equal(given.inner.values, [10.0, -1.0, 30.0])
    np.testing.assert_array_equal(given.rows[1], [-2.0, 3.0])


def test_kernels_make_structures_of_arrays_that_they_were_given():
    assert made_here(outer(), 3) == 10.0 * 3.0 + 20.0 * 5.0


def test_arrays_made_in_the_same_kernel_live_until_it_returns():
    """A structure holds no reference; what it is made of is held for it, and let go at the end."""
    _nrt_python.memsys_enable_stats()
    before = rtsys.get_allocation_stats()
    for n in (1, 3, 1000):
        assert made_of_own(n) == 2.0 * sum(range(n))
        assert chosen_of_own(n, True) == 6.0
        assert chosen_of_own(n, False) == 0.0
    after = rtsys.get_allocation_stats()
    assert after.alloc - before.alloc == after.free - before.free > 0


def test_no_reference_is_left_and_none_is_taken_away():
    given = outer()
    arrays = given.rows, given.places, given.inner.values
    before = [sys.getrefcount(array) for array in arrays]
    for _ in range(50):
        weighted(given)
        made_here(given, 3)
        written(given, 0)
        doubled = new_array(given)
    assert [sys.getrefcount(array) for array in arrays] == before
    np.testing.assert_array_equal(doubled, 2.0 * given.inner.values)
    assert doubled.base is not given.inner.values


def test_the_type_is_told_by_the_value_and_by_the_declaration():
    """A field of another type is another type, with another symbol: code for the first is not used for it."""
    declared = numba_type(Outer)
    assert isinstance(declared, Structure)
    other = outer()._replace(rows=np.asfortranarray(outer().rows))
    assert through_another(outer()) == through_another(other) == 33.0
    kinds = [arguments[0] for arguments in through_another.overloads]
    assert declared in kinds
    assert len({kind.mangling_args for kind in kinds}) == len(kinds) == 2


def test_what_was_wrong_is_told_before_anything_runs():
    with pytest.raises(NumbaError, match="Unknown attribute 'missing'"):
        kernel(lambda o: o.missing)(outer())
    with pytest.raises(NumbaError):
        kernel(lambda o: o[0])(outer())


def test_a_kernel_that_returns_a_structure_is_refused():
    """The memory of one that it has made ends with it."""
    with pytest.raises(NumbaError, match="a kernel returns a structure"):
        kernel(returned)(outer())


@inner_kernel
def _beside_a_number(y):
    values = np.zeros(3)
    values[1] = y
    return Inner(values, y), 2.0


@inner_kernel
def _given_beside_a_number(o):
    return o.inner, 2.0


def test_nor_does_a_tuple_carry_one_out():
    """A structure that was given may be in one: it lives on."""

    @kernel
    def made(y):
        inner, number = _beside_a_number(y)
        return inner.values[1] + number

    @kernel
    def given(o):
        inner, number = _given_beside_a_number(o)
        return inner.factor + number

    with pytest.raises(NumbaError, match="a kernel returns a structure, whose memory may end with it"):
        made(3.0)
    assert given(outer()) == outer().inner.factor + 2.0


def test_contexts_and_flags_that_remember_stand_for_those_of_numba():
    context = cpu_target.typing_context
    assert remembering(context) is remembering(context)
    assert (remembering(context), hash(remembering(context))) == (context, hash(context))
    assert context == remembering(context)
    plain = ComparedFlags.__bases__[0]()
    plain.nrt = True
    own = ComparedFlags(plain)
    assert (own, hash(own)) == (plain, hash(plain))
    own.nrt = False
    assert own != plain
    assert own.copy() == own


def test_remembered_types_are_those_of_what_is_given():
    """Layout, element type, axes and right to write are parts of the type, also where the class was seen before."""
    plain, other = np.zeros((4, 4)), np.zeros((4, 4), np.int64)
    locked = plain.copy()
    locked.flags.writeable = False
    for array in (plain, plain.T[::2], plain[:, ::2], other, plain[0], locked):
        for _ in range(2):
            assert typeof(Remembered(array, 1.0)).types == (typeof(array), typeof(1.0))
    assert typeof(Remembered(plain, 1)).types[1] == typeof(1)
