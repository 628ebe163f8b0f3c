"""Small matrices of the recursion: moved between points, factorised in place.

The rate of a twist (velocity, angular velocity) at a point r + d is ``Sh(d) = [1, -d~; 0, 1]`` times that at r; in W.
"""

from __future__ import annotations

from flexmb.math.kernel import kernel

__all__ = ["factor_block", "invert_block", "shift_inertia", "solve_block"]


@kernel
def shift_inertia(A, x, y, z):
    """Replace the matrix A (36,) by Sh(d)^T A Sh(d), d = (x, y, z), eq. (tree-shift)."""
    for i in range(6):
        k = 6 * i
        a, b, c = A[k], A[k + 1], A[k + 2]
        A[k + 3] += y * c - z * b
        A[k + 4] += z * a - x * c
        A[k + 5] += x * b - y * a
    for j in range(6):
        a, b, c = A[j], A[j + 6], A[j + 12]
        A[j + 18] += y * c - z * b
        A[j + 24] += z * a - x * c
        A[j + 30] += x * b - y * a


@kernel
def factor_block(A, n, pivots, least):
    """Factorise the leading (n, n) part of A in place with row exchanges; False if a pivot is not above `least`."""
    for k in range(n):
        p = k
        for i in range(k + 1, n):
            if abs(A[i, k]) > abs(A[p, k]):
                p = i
        if not abs(A[p, k]) > least:
            return False
        pivots[k] = p
        if p != k:
            for j in range(n):
                x = A[k, j]
                A[k, j] = A[p, j]
                A[p, j] = x
        f = 1.0 / A[k, k]
        for i in range(k + 1, n):
            x = A[i, k] * f
            A[i, k] = x
            if x != 0.0:
                for j in range(k + 1, n):
                    A[i, j] -= x * A[k, j]
    return True


@kernel
def solve_block(A, n, pivots, b):
    """Solve A x = b with the factors of `factor_block`; x replaces b."""
    for k in range(n):
        p = pivots[k]
        x = b[p]
        b[p] = b[k]
        b[k] = x
    for i in range(n):
        x = b[i]
        for j in range(i):
            x -= A[i, j] * b[j]
        b[i] = x
    for i in range(n - 1, -1, -1):
        x = b[i]
        for j in range(i + 1, n):
            x -= A[i, j] * b[j]
        b[i] = x / A[i, i]


@kernel
def invert_block(A, n, pivots, column, least, out, at):
    """Write the inverse of A (n, n), which is overwritten, to out[at:] row by row; False if it is singular."""
    if not factor_block(A, n, pivots, least):
        return False
    for j in range(n):
        for i in range(n):
            column[i] = 1.0 if i == j else 0.0
        solve_block(A, n, pivots, column)
        for i in range(n):
            out[at + i * n + j] = column[i]
    return True
