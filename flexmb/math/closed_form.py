"""The explicit equation of Udwadia & Phohomsiri for compiled runs: accelerations of M a = Q + forces of A a = b.

In its stable form, eq. (udwadia-stable), without a library: rows of A are made orthonormal one after another (Gram and
Schmidt, twice), and with them what they demand, so that a = sum of beta_k v_k + V2 z; V2 completes the basis, and z
follows from V2^T M V2 by Cholesky. Coordinates are scaled by the diagonal of M, as in `flexmb.math.udwadia`.
"""

from __future__ import annotations

import numpy as np

from flexmb.math.kernel import inner_kernel, kernel

__all__ = ["solve_closed"]

RANK = 1e-10
"""Part of a row beyond the others, below which it depends on them; of a pivot of V2^T M V2."""


@inner_kernel
def _apart(V, count, x, c):
    """Take the parts along the first `count` rows of V out of x, twice; add them to c; return what is left of it."""
    n = len(x)
    for _ in range(2):
        for k in range(count):
            part = 0.0
            for i in range(n):
                part += V[k, i] * x[i]
            c[k] += part
            for i in range(n):
                x[i] -= part * V[k, i]
    size = 0.0
    for i in range(n):
        size += x[i] * x[i]
    return size**0.5


@inner_kernel
def _complete(V, count, x, c):
    """Complete the orthonormal rows of V to a basis by the unit vectors that are farthest from them."""
    n = len(x)
    left = np.ones(n)
    for i in range(n):
        for k in range(count):
            left[i] -= V[k, i] * V[k, i]
    for row in range(count, n):
        best = int(np.argmax(left))
        x[:] = 0.0
        x[best] = 1.0
        size = _apart(V, row, x, c)
        left[best] = -1.0
        for i in range(n):
            V[row, i] = x[i] / size
            left[i] -= V[row, i] * V[row, i]


@inner_kernel
def _independent_rows(A, b, order, apart, scale, V, beta, R, chosen):
    """Make the rows of A orthonormal in V, with beta = what they demand; return their number, or -1.

    R (m, m) has the parts of each chosen row along those before it, and its own last.
    """
    n, rank = len(scale), 0
    x, c = np.empty(n), np.empty(len(b) + n)
    for at in range(len(order)):
        row, size = order[at], 0.0
        for i in range(n):
            x[i] = A[row, i] * scale[i]
            size += x[i] * x[i]
        size = size**0.5
        if size == 0.0 or rank == n:
            continue
        for i in range(n):
            x[i] /= size
        c[:rank] = 0.0
        left = _apart(V, rank, x, c)
        if not np.isfinite(left):
            return -1
        if left <= apart[row]:
            continue
        own = b[row] / size
        for k in range(rank):
            own -= c[k] * beta[k]
            R[rank, k] = c[k] * size
            V[rank, k] = 0.0
        R[rank, rank] = left * size
        beta[rank] = own / left
        for i in range(n):
            V[rank, i] = x[i] / left
        chosen[rank] = row
        rank += 1
    return rank


@inner_kernel
def _solve_positive(H, z):
    """Solve H z = z by Cholesky in place; return if all pivots are positive."""
    n = len(z)
    largest = 0.0
    for i in range(n):
        largest = max(largest, H[i, i])
    for j in range(n):
        for k in range(j):
            for i in range(j, n):
                H[i, j] -= H[i, k] * H[j, k]
        if not H[j, j] > RANK * largest:
            return False
        root = H[j, j] ** 0.5
        for i in range(j, n):
            H[i, j] /= root
    for i in range(n):
        for k in range(i):
            z[i] -= H[i, k] * z[k]
        z[i] /= H[i, i]
    for i in range(n - 1, -1, -1):
        for k in range(i + 1, n):
            z[i] -= H[k, i] * z[k]
        z[i] /= H[i, i]
    return True


@kernel
def solve_closed(rows, columns, masses, Q, A, b, order, apart, a, multipliers):
    """Write accelerations (n,) and multipliers (m,) of independent rows, zero of the others; return if they are unique.

    Parameters
    ----------
    rows, columns, masses : (k,)
        Entries of the mass matrix (n, n).
    Q, A, b : (n,), (m, n), (m,)
    order : (m,) of int
        In which rows are taken: those that may depend on others last.
    apart : (m,)
        Part of each row beyond those before it, from which it counts.
    """
    n, m = len(Q), len(b)
    scale, total, count = np.zeros(n), 0.0, 0
    for e in range(len(masses)):
        if rows[e] == columns[e]:
            scale[rows[e]] = abs(masses[e])
    for i in range(n):
        if scale[i] > 0.0:
            total += np.log(scale[i])
            count += 1
    middle = np.exp(total / count) if count > 0 else 1.0
    for i in range(n):
        scale[i] = 1.0 / (scale[i] if scale[i] > 0.0 else middle) ** 0.5
    V, beta, R, chosen = np.empty((n, n)), np.empty(m), np.empty((m, m)), np.empty(m, np.int64)
    rank = _independent_rows(A, b, order, apart, scale, V, beta, R, chosen)
    if rank < 0:
        return False
    x, c = np.empty(n), np.zeros(n)
    _complete(V, rank, x, c)
    a[:] = 0.0
    for k in range(rank):
        for i in range(n):
            a[i] += beta[k] * V[k, i]
    left = np.empty(n)  # Q - M a, scaled
    for i in range(n):
        left[i] = scale[i] * Q[i]
    for e in range(len(masses)):
        left[rows[e]] -= scale[rows[e]] * masses[e] * scale[columns[e]] * a[columns[e]]
    free = n - rank
    MV, H, z = np.zeros((free, n)), np.zeros((free, free)), np.zeros(free)
    for e in range(len(masses)):
        x_e = scale[rows[e]] * masses[e] * scale[columns[e]]
        for k in range(free):
            MV[k, rows[e]] += x_e * V[rank + k, columns[e]]
    for k in range(free):
        for i in range(n):
            z[k] += V[rank + k, i] * left[i]
            for j in range(k + 1):
                H[k, j] += MV[k, i] * V[rank + j, i]
    if not _solve_positive(H, z):
        return False
    for k in range(free):
        for i in range(n):
            a[i] += z[k] * V[rank + k, i]
            left[i] -= z[k] * MV[k, i]
    multipliers[:] = 0.0
    for k in range(rank - 1, -1, -1):  # A^T lam = M a - Q
        own = 0.0
        for i in range(n):
            own -= V[k, i] * left[i]
        for j in range(k + 1, rank):
            own -= R[j, k] * multipliers[chosen[j]]
        multipliers[chosen[k]] = own / R[k, k]
    for i in range(n):
        a[i] *= scale[i]
    return True
