"""Elements of arrays are read and written by code of ours: as numpy does, for all layouts, indices and types."""

import numpy as np
import pytest

from flexmb.math.kernel import kernel

SIGNED, UNSIGNED = (np.int64, np.int32, np.int8), (np.uint64, np.uint32, np.uint8)
ROW = np.dtype([("mass", float), ("count", np.int64)], align=True)


@kernel
def read_one(x, i):
    return x[i]


@kernel
def read_two(x, i, j):
    return x[i, j]


@kernel
def read_three(x, i, j, k):
    return x[i, j, k]


@kernel
def read_only(x):
    return x[()]


@kernel
def read_last(x):
    return x[-1, -2]


@kernel
def write_one(x, i, value):
    x[i] = value


@kernel
def write_two(x, i, j, value):
    x[i, j] = value


@kernel
def add_to_first(x, value):
    x[0] += value


@kernel
def read_mass(rows, i):
    return rows[i].mass


@kernel
def write_count(rows, i, value):
    rows[i].count = value


@pytest.mark.parametrize("kind", [float, np.float32, complex, np.int64, np.uint8, bool])
def test_elements_of_all_types(kind):
    x = np.array([0, 1, 0, 1, 1, 0, 1], kind)
    for i in range(-7, 7):
        assert read_one(x, i) == x[i]
    write_one(x, -3, kind(1))
    write_one(x, 1, kind(0))
    np.testing.assert_array_equal(x, np.array([0, 0, 0, 1, 1, 0, 1], kind))


@pytest.mark.parametrize("kind", [*SIGNED, *UNSIGNED])
def test_indices_of_all_types(kind):
    x = np.arange(12.0).reshape(3, 4)
    for i in range(-3 if kind in SIGNED else 0, 3):
        for j in range(4):
            assert read_two(x, kind(i), j) == x[i, j]
            assert read_two(x, kind(i), kind(j)) == x[i, j]
    assert read_last(x) == x[-1, -2]


@pytest.mark.parametrize(
    "part",
    [
        lambda x: x,
        lambda x: x[::2],
        lambda x: x[::-1, 1:],
        lambda x: x.T,
        lambda x: x[1:, ::-2],
        lambda x: np.asfortranarray(x),
    ],
)
def test_elements_of_slices(part):
    """They have strides of their own, some negative."""
    x = part(np.arange(20.0).reshape(5, 4))
    for i in range(-len(x), len(x)):
        for j in range(-x.shape[1], x.shape[1]):
            assert read_two(x, i, j) == x[i, j]
    wanted = x.copy()
    write_two(x, -2, 1, 7.5)
    wanted[-2, 1] = 7.5
    np.testing.assert_array_equal(x, wanted)
    row = x[:, 0]
    assert read_one(row, -1) == row[-1]
    before = row[0]
    add_to_first(row, 2.0)
    assert x[0, 0] == before + 2.0


def test_no_axis():
    assert read_only(np.array(2.5)) == 2.5


def test_three_axes():
    whole = np.arange(2.0 * 3 * 5).reshape(2, 3, 5)
    for x in (whole, whole[:, ::2, ::-1]):
        for place in np.ndindex(*x.shape):
            assert read_three(x, *place) == x[place]
            back = tuple(np.subtract(place, x.shape).tolist())
            assert read_three(x, *back) == x[back]


def test_numbers_become_what_the_array_holds():
    x = np.zeros(3, np.int64)
    write_one(x, 0, 2.75)
    write_one(x, 2, True)
    np.testing.assert_array_equal(x, (2, 0, 1))
    y = np.zeros(2)
    write_one(y, 1, 3)
    np.testing.assert_array_equal(y, (0.0, 3.0))


def test_rows_of_tables():
    rows = np.zeros(4, ROW)
    rows["mass"] = 1.5, 2.5, 3.5, 4.5
    for table in (rows, rows[::-1]):
        for i in range(-4, 4):
            assert read_mass(table, i) == table["mass"][i]
    write_count(rows, -1, 8)
    np.testing.assert_array_equal(rows["count"], (0, 0, 0, 8))
