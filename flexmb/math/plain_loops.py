"""Loops over arrays that kernels write again and again.

numba compiles numpy's own functions for every use of them, with their iterators, their broadcasting and the texts of
their errors: ``np.max`` of one array takes it longer than most of our kernels.
"""

from __future__ import annotations

import numpy as np

from flexmb.math.kernel import kernel

__all__ = ["all_finite", "copy_into", "knots_until", "largest_size"]


@kernel
def copy_into(out, x):
    """Write x (n,) to the first n numbers of `out`."""
    for i in range(len(x)):
        out[i] = x[i]


@kernel
def all_finite(x):
    """Is no number of x (n,) infinite or undefined?"""
    finite = True
    for i in range(len(x)):
        finite = finite and np.isfinite(x[i])
    return finite


@kernel
def largest_size(x):
    """Return the largest absolute value of x (n,), 0 of none; what is undefined is returned."""
    largest = 0.0
    for i in range(len(x)):
        size = abs(x[i])
        if not size <= largest:
            largest = size
            if size != size:
                break
    return largest


@kernel
def knots_until(knots, x):
    """Return how many of the rising `knots` (n,) are not beyond x: all of them if it is undefined."""
    low, high = 0, len(knots)
    while low < high:
        middle = (low + high) // 2
        if x < knots[middle]:
            high = middle
        else:
            low = middle + 1
    return low
