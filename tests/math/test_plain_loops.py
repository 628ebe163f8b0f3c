"""Loops that stand for functions of numpy give what these give."""

import numpy as np
import pytest

from flexmb.math.plain_loops import all_finite, copy_into, knots_until, largest_size
from flexmb.math.rotations import advance_frame, relative_frame

NUMBERS = [np.array([]), np.array([-3.0, 2.0]), np.array([1.0, -np.inf]), np.array([1.0, np.nan, 5.0])]


@pytest.mark.parametrize("x", NUMBERS, ids=str)
def test_size_and_finiteness(x):
    assert largest_size(x) == pytest.approx(np.max(np.abs(x), initial=0.0), nan_ok=True)
    assert all_finite(x) == np.all(np.isfinite(x))


def test_numbers_are_copied_to_the_front():
    out = np.arange(4.0)
    copy_into(out, np.array([7.0, 8.0]))
    assert list(out) == [7.0, 8.0, 2.0, 3.0]


@pytest.mark.parametrize("n", [1, 2, 5, 8])
def test_knots_are_counted_as_numpy_does(n):
    knots = np.cumsum(np.ones(n))
    for x in (*np.arange(-1.0, n + 2.0, 0.5), np.inf, -np.inf, np.nan):
        assert knots_until(knots, x) == np.searchsorted(knots, x, side="right")


@pytest.mark.parametrize("angle", [0.0, 1e-9, 1e-3, 1.0, 3.0, np.pi - 1e-9])
def test_an_increment_of_a_frame_is_found_again(rng, angle):
    """Up to half a turn, where the map from rotation vectors to axes has its smallest determinant, 4/pi^2."""
    for _ in range(20):
        axis, p = rng.normal(size=3), rng.normal(size=4)
        frame = np.concatenate([rng.normal(size=3), p / np.linalg.norm(p)])
        d = np.concatenate([rng.normal(size=3), angle * axis / np.linalg.norm(axis)])
        other, found = np.empty(7), np.empty(6)
        advance_frame(frame, d, 1.0, other)
        relative_frame(frame, other, found)
        assert found == pytest.approx(d, abs=1e-12 if angle < 3.0 else 1e-7)
