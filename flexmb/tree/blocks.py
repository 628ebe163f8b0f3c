"""Small matrices of the recursion: moved between points and axes, factorised in place.

A twist (velocity, angular velocity) or its rate at a point r is ``Sh(d) = [1, -d~; 0, 1]`` times itself at r + d; all in W.
"""

from __future__ import annotations

from flexmb.math.kernel import kernel

__all__ = ["factor_block", "invert_block", "shift_inertia", "solve_block", "turn_block"]


@kernel
def turn_block(S, rows, iu, a, b, R, half, P):
    """Write R B R^T to P[a:a+3, b:b+3]; B is that part of the body's own block in S."""
    for i in range(3):
        at = rows[iu + a + i] + b
        x, y, z = S[at], S[at + 1], S[at + 2]
        for j in range(3):
            half[i, j] = x * R[j, 0] + y * R[j, 1] + z * R[j, 2]
    for i in range(3):
        for j in range(3):
            P[a + i, b + j] = R[i, 0] * half[0, j] + R[i, 1] * half[1, j] + R[i, 2] * half[2, j]


@kernel
def shift_inertia(P, d):
    """Replace P (6, 6) by Sh(d)^T P Sh(d), eq. (tree-shift)."""
    x, y, z = d[0], d[1], d[2]
    for i in range(6):
        a, b, c = P[i, 0], P[i, 1], P[i, 2]
        P[i, 3] += y * c - z * b
        P[i, 4] += z * a - x * c
        P[i, 5] += x * b - y * a
    for j in range(6):
        a, b, c = P[0, j], P[1, j], P[2, j]
        P[3, j] += y * c - z * b
        P[4, j] += z * a - x * c
        P[5, j] += x * b - y * a


@kernel
def factor_block(A, n, pivots, least):
    """Factorise the leading (n, n) part of A in place, A = P L U; False if a pivot is not above `least`."""
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
def invert_block(A, n, pivots, column, least, out):
    """Write the inverse of A (n, n), which is overwritten, to `out`; False if it is singular."""
    if n == 1:
        if not abs(A[0, 0]) > least:
            return False
        out[0, 0] = 1.0 / A[0, 0]
        return True
    if not factor_block(A, n, pivots, least):
        return False
    for j in range(n):
        for i in range(n):
            column[i] = 1.0 if i == j else 0.0
        solve_block(A, n, pivots, column)
        for i in range(n):
            out[i, j] = column[i]
    return True
