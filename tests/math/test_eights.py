"""Eight numbers at once: every operation beside numpy's, bit by bit."""

from fractions import Fraction

import numpy as np
import pytest

from flexmb.math.eights import (
    WIDTH,
    crossing,
    keep,
    keep_columns,
    less,
    more,
    only_after,
    part,
    plus,
    put,
    read,
    same,
    times,
    total,
    totals,
)
from flexmb.math.kernel import kernel

PLACES = 3, 0, 15, 8, 8, 1, 7, 10
_SOME = crossing(*PLACES)


@kernel
def combine(x, a, b, out):
    one, other = read(a, 0), read(b, 0)
    keep(out, (0, 0), times(x, one))
    keep(out, (1, 0), plus(one, other))
    keep(out, (2, 0), more(one, x, other))
    keep(out, (3, 0), less(one, x, other))
    keep(out, (4, 0), more(one, one, other))
    keep(out, (5, 0), _SOME(one, other))
    keep(out, (6, 0), same(x))


@kernel
def change(a, b, place, x, out):
    keep(out, (0, 0), put(read(a, 0), place, x))
    keep(out, (1, 0), only_after(read(a, 0), read(b, 0), place))


@kernel
def read_part(a, first, count, out):
    keep(out, 0, part(a, first, count))


@kernel
def read_of(a, i, j, k):
    return total(read(a, (i, j, k)))


@kernel
def turn(rows, first, out):
    a, b, c, d = read(rows, (0, 0)), read(rows, (1, 0)), read(rows, (2, 0)), read(rows, (3, 0))
    e, f, g, h = read(rows, (4, 0)), read(rows, (5, 0)), read(rows, (6, 0)), read(rows, (7, 0))
    keep_columns(out, first, a, b, c, d, e, f, g, h)


@kernel
def sums(rows, out):
    a, b, c, d = read(rows, (0, 0)), read(rows, (1, 0)), read(rows, (2, 0)), read(rows, (3, 0))
    e, f, g, h = read(rows, (4, 0)), read(rows, (5, 0)), read(rows, (6, 0)), read(rows, (7, 0))
    keep(out, 0, totals(a, b, c, d, e, f, g, h))


def rounded_once(a, x, b):
    """Return a + x b, exact numbers rounded at the end."""
    return np.array([float(Fraction(p) + Fraction(q) * Fraction(r)) for p, q, r in zip(a, x, b, strict=True)])


def test_sums_with_products_are_rounded_once(rng):
    a, b, x, out = rng.normal(size=WIDTH), rng.normal(size=WIDTH), rng.normal(), np.zeros((7, WIDTH))
    b[:4] = -a[:4] / x * (1.0 + 1e-15 * rng.normal(size=4))  # what is left is the rounding of the product
    combine(x, a, b, out)
    factor = np.full(WIDTH, x)
    sums = rounded_once(a, factor, b), rounded_once(a, -factor, b), rounded_once(a, a, b)
    assert np.any(sums[0] != a + x * b)
    np.testing.assert_array_equal(out, (x * a, a + b, *sums, np.concatenate([a, b])[list(PLACES)], factor))


@pytest.mark.parametrize("place", range(WIDTH))
def test_one_place(place, rng):
    a, b, out = rng.normal(size=WIDTH), rng.normal(size=WIDTH), np.zeros((2, WIDTH))
    change(a, b, place, 7.0, out)
    np.testing.assert_array_equal(out[0], np.where(np.arange(WIDTH) == place, 7.0, a))
    np.testing.assert_array_equal(out[1], np.where(np.arange(WIDTH) > place, a, b))


@pytest.mark.parametrize("count", range(WIDTH + 3))
def test_part_reads_no_number_behind_it(count):
    a, out = np.arange(1.0, 30.0), np.full(WIDTH, np.nan)
    a[5 + count :] = np.nan
    read_part(a, 5, count, out)
    taken = min(count, WIDTH)
    np.testing.assert_array_equal(out, np.r_[a[5 : 5 + taken], np.zeros(WIDTH - taken)])


def test_places_of_arrays_of_several_axes(rng):
    a = rng.integers(0, 100, (3, 4, 2 * WIDTH)).astype(float)
    assert read_of(a, 2, 1, 5) == a[2, 1, 5 : 5 + WIDTH].sum()


def test_columns_become_rows_and_sums_stand_in_order(rng):
    rows, out = rng.integers(0, 100, (WIDTH, WIDTH)).astype(float), np.zeros((2 * WIDTH, WIDTH))
    turn(rows, 3, out)
    np.testing.assert_array_equal(out[3 : 3 + WIDTH], rows.T)
    assert not out[:3].any()
    assert not out[3 + WIDTH :].any()
    found = np.zeros(WIDTH)
    sums(rows, found)
    np.testing.assert_array_equal(found, rows.sum(axis=1))
