"""Small arrays of constant size that kernels keep in their own memory: the same results, nothing from the heap."""

import numpy as np
import pytest
from numba import types
from numba.core.errors import LoweringError
from numba.core.runtime import _nrt_python, rtsys
from numba.typed import List

from flexmb.math.kernel import inner_kernel, kernel
from flexmb.math.own_room import LARGEST

WIDTH = 4
ROW = np.dtype([("code", np.int8), ("x", float, (3,)), ("n", np.int64)], align=True)


@kernel
def of_constants(x):
    a, b = np.empty(3), np.zeros((2, 2 * WIDTH - 1), np.int64)
    for k in range(3):
        a[k] = 2.0 * x[k]
    b[1, 6] += 5
    return a[0] + a[1] + a[2] + b.sum()


@kernel
def of_a_size(x, n):
    a = np.empty(n)
    a[:] = x[0]
    return a.sum()


@kernel
def large():
    a = np.zeros(LARGEST // 8 + 1)
    a[3] = 2.0
    return a.sum()


@kernel
def turn_by_turn(out):
    """Each turn's array beside that of the turn before."""
    before = np.zeros(2)
    for k in range(len(out)):
        now = np.zeros(2)
        now[0] = k + 1.0
        out[k] = now[0] - before[0] + now[1]
        before = now


@kernel
def given_away(x):
    a = np.empty(3)
    a[:] = x
    return a


@kernel
def given_with_others(x):
    a = np.empty(3)
    a[:] = x
    return x, a[1:]


@kernel
def listed(x):
    kept = []
    for k in range(3):
        kept.append(given_away(x + k))
    a = np.zeros(3)
    kept.append(a)
    a[0] = 7.0
    return kept[0][0] + kept[2][0] + kept[3][0]


@inner_kernel
def _count_up(x):
    a = np.zeros(2)
    a[1] += x
    return a[1]


@kernel
def by_calls(n):
    total = 0.0
    for k in range(n):
        total += _count_up(1.0 * k)
    return total


@kernel
def of_one_of_two(x, which):
    a, b = np.zeros(2), np.zeros(2)
    a[0], b[0] = 1.0, 2.0
    c = a if which else b
    c[1] = x
    return c[0] + 10.0 * a[1] + 100.0 * b[1]


@kernel
def step_by_step(n):
    """What a generator keeps from step to step."""
    a = np.zeros(3)
    for k in range(n):
        a[k % 3] += k + 1.0
        yield a[0] + 10.0 * a[1] + 100.0 * a[2]


@kernel
def added_up(n):
    total, filler = 0.0, np.zeros(3)
    for x in step_by_step(n):
        filler[0] += x
        total = 3.0 * total + x
    return total + filler[0]


@kernel
def numbers_of(a):
    for k in range(len(a)):
        yield a[k]


@kernel
def row_of(x):
    table = np.zeros(2, ROW)
    table[0].x[1] = x
    table[0].n = 7
    return table[0]


@kernel
def second_row(table):
    return table[1]


@kernel
def refused(x):
    a = np.zeros(3)
    a[1] = x
    if x > 1.0:
        raise ValueError("too large", a)
    return a[1]


@kernel
def _put_into(lists, a):
    lists[0].append(a)


@kernel
def put_away(lists, x):
    a = np.zeros(3)
    a[0] = x
    _put_into(lists, a)
    return 0


@kernel
def of_no_dimension(x):
    a = np.zeros(())
    a[()] = x
    return 2.0 * a[()]


@pytest.fixture(scope="module", autouse=True)
def counted():
    """The heap counts what it is asked for."""
    counting = _nrt_python.memsys_stats_enabled()
    _nrt_python.memsys_enable_stats()
    yield
    if not counting:
        _nrt_python.memsys_disable_stats()


def asked_of_the_heap(function, *arguments) -> int:
    """How many arrays does a call make on the heap?"""
    function(*arguments)
    before = rtsys.get_allocation_stats().alloc
    function(*arguments)
    return rtsys.get_allocation_stats().alloc - before


def test_arrays_of_constant_size_need_no_heap():
    x = np.arange(1.0, 4.0)
    assert of_constants(x) == of_constants(x) == 17.0
    assert of_a_size(x, 5) == 5.0
    assert large() == 2.0
    assert asked_of_the_heap(of_constants, x) == 0
    assert asked_of_the_heap(by_calls, 5) == 0
    assert asked_of_the_heap(of_a_size, x, 5) > 0
    assert asked_of_the_heap(large) > 0


def test_zeros_are_zeros_at_every_call():
    assert by_calls(5) == 10.0
    assert by_calls(5) == 10.0


def test_an_array_of_the_turn_before_stays_as_it_is():
    out = np.zeros(4)
    turn_by_turn(out)
    np.testing.assert_array_equal(out, np.ones(4))


def test_arrays_that_are_given_away_live_on():
    x = np.arange(3.0)
    made = [given_away(x + k) for k in range(50)]
    parts = [given_with_others(x + k)[1] for k in range(50)]
    for k in range(50):
        np.testing.assert_array_equal(made[k], x + k)
        np.testing.assert_array_equal(parts[k], (x + k)[1:])
    assert listed(x) == 0.0 + 2.0 + 7.0


def test_one_name_for_one_of_two_arrays():
    assert of_one_of_two(3.0, True) == 31.0
    assert of_one_of_two(3.0, False) == 302.0


def test_generators_keep_their_arrays():
    """In plain Python: 1, 21, 321, 325, 375, 975."""
    assert list(step_by_step(6)) == list(step_by_step.py_func(6)) == [1.0, 21.0, 321.0, 325.0, 375.0, 975.0]
    assert added_up(6) == added_up.py_func(6)
    given = numbers_of(np.arange(5000.0))
    fillers = [np.full(5000, -1.0) for _ in range(20)]
    assert sum(given) == 4999.0 * 5000.0 / 2.0
    assert len(fillers) == 20


def test_rows_of_own_arrays_cannot_be_returned():
    """They are addresses, of memory that ends with the function; rows of what was given live on."""
    with pytest.raises(LoweringError, match="a kernel returns a record, whose memory may end with it"):
        row_of(2.5)
    table = np.zeros(2, ROW)
    table["n"] = 3, 7
    assert second_row(table)["n"] == 7


def test_arrays_in_errors_and_lists_live_on():
    with pytest.raises(ValueError, match="too large") as told:
        refused(7.0)
    np.testing.assert_array_equal(told.value.args[1], (0.0, 7.0, 0.0))
    kept = List.empty_list(types.float64[::1])
    for x in (3.0, 4.0):
        put_away((kept, 1), x)
    np.testing.assert_array_equal(kept, ((3.0, 0.0, 0.0), (4.0, 0.0, 0.0)))


def test_arrays_of_no_dimension():
    assert of_no_dimension(3.0) == 6.0
