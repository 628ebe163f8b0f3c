"""Matrices of six rows, of a twist or a wrench, eight columns at a time."""

from __future__ import annotations

from flexmb.math.eights import keep, plus, read
from flexmb.math.kernel import kernel

__all__ = ["add_six", "keep_six", "read_six"]


@kernel
def read_six(A, at):
    """Return the columns of A (6, n) from `at` on, row by row."""
    return read(A, (0, at)), read(A, (1, at)), read(A, (2, at)), read(A, (3, at)), read(A, (4, at)), read(A, (5, at))


@kernel
def keep_six(A, at, a, b, c, d, e, f):
    """Write rows to the columns of A (6, n) from `at` on."""
    keep(A, (0, at), a)
    keep(A, (1, at), b)
    keep(A, (2, at), c)
    keep(A, (3, at), d)
    keep(A, (4, at), e)
    keep(A, (5, at), f)


@kernel
def add_six(A, at, a, b, c, d, e, f):
    """Add rows to the columns of A (6, n) from `at` on."""
    keep(A, (0, at), plus(read(A, (0, at)), a))
    keep(A, (1, at), plus(read(A, (1, at)), b))
    keep(A, (2, at), plus(read(A, (2, at)), c))
    keep(A, (3, at), plus(read(A, (3, at)), d))
    keep(A, (4, at), plus(read(A, (4, at)), e))
    keep(A, (5, at), plus(read(A, (5, at)), f))
