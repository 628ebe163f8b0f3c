"""3-vectors in kernels: plain loops without allocation; `out` may not be one of the inputs."""

from __future__ import annotations

from flexmb.math.kernel import kernel

__all__ = ["add_combination", "add_cross", "add_skew", "cross", "dot", "matvec", "matvec_t", "norm", "rotate_columns"]


@kernel
def dot(a, b):
    """Scalar product of two 3-vectors."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@kernel
def add_combination(x, rows, out):
    """Add sum_k x_k rows[k] to `out` (n,), rows (k, n): contiguous, without a chain of sums,
    so compilers vectorise it.
    """
    for k in range(len(x)):
        a = x[k]
        if a != 0.0:
            row = rows[k]
            for i in range(len(out)):
                out[i] += a * row[i]


@kernel
def norm(a):
    """Length of a 3-vector."""
    return (a[0] * a[0] + a[1] * a[1] + a[2] * a[2]) ** 0.5


@kernel
def cross(a, b, out):
    """Write a x b to `out`."""
    out[0] = a[1] * b[2] - a[2] * b[1]
    out[1] = a[2] * b[0] - a[0] * b[2]
    out[2] = a[0] * b[1] - a[1] * b[0]


@kernel
def add_cross(a, b, out):
    """Add a x b to `out`."""
    out[0] += a[1] * b[2] - a[2] * b[1]
    out[1] += a[2] * b[0] - a[0] * b[2]
    out[2] += a[0] * b[1] - a[1] * b[0]


@kernel
def matvec(A, x, out):
    """Write A x to `out` (3 x 3)."""
    for i in range(3):
        out[i] = A[i, 0] * x[0] + A[i, 1] * x[1] + A[i, 2] * x[2]


@kernel
def matvec_t(A, x, out):
    """Write A^T x to `out` (3 x 3)."""
    for i in range(3):
        out[i] = A[0, i] * x[0] + A[1, i] * x[1] + A[2, i] * x[2]


@kernel
def rotate_columns(A, B, out):
    """Write A B to `out` (3 x 3)."""
    for i in range(3):
        for j in range(3):
            out[i, j] = A[i, 0] * B[0, j] + A[i, 1] * B[1, j] + A[i, 2] * B[2, j]


@kernel
def add_skew(B, row, column, scale, a):
    """Add scale * a~ to the block of `B` at `row`, `column`."""
    B[row, column + 1] -= scale * a[2]
    B[row, column + 2] += scale * a[1]
    B[row + 1, column] += scale * a[2]
    B[row + 1, column + 2] -= scale * a[0]
    B[row + 2, column] -= scale * a[1]
    B[row + 2, column + 1] += scale * a[0]
