"""What the kernels of all bodies share: the row header, marker kinematics on a frame, writing the body's own block."""

from __future__ import annotations

import numpy as np

from flexmb.math.kernel import kernel

__all__ = ["HEADER", "add_own_block", "add_product_skew", "add_to_residual", "skew_to"]

HEADER = [
    ("iq", np.int64),  # first coordinate
    ("iu", np.int64),  # first velocity
    ("marker", np.int64),  # first marker
    ("n_markers", np.int64),
]
"""The first fields of every body row."""


@kernel
def add_to_residual(work, iu, marker):
    """Subtract the marker's wrench, J^T W, from the residual."""
    nu = marker.nu
    for k in range(6):
        w = marker.wrench[k]
        if w != 0.0:
            start = marker.iJ + k * nu
            for j in range(nu):
                work.residual[iu + j] -= work.J[start + j] * w


@kernel
def add_own_block(work, iu, block, n):
    """Add the (n, n) block to the body's own block of the iteration matrix."""
    for i in range(n):
        start = work.rows[iu + i]
        for j in range(n):
            work.S[start + j] += block[i, j]


@kernel
def skew_to(a, out):
    """Write a~ to `out`."""
    out[0, 0] = 0.0
    out[1, 1] = 0.0
    out[2, 2] = 0.0
    out[0, 1] = -a[2]
    out[0, 2] = a[1]
    out[1, 0] = a[2]
    out[1, 2] = -a[0]
    out[2, 0] = -a[1]
    out[2, 1] = a[0]


@kernel
def add_product_skew(B, row, column, scale, a, b):
    """Add scale * a~ b~ = scale * (b a^T - (a . b) I) to the block of `B` at `row`, `column`."""
    ab = a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
    for i in range(3):
        for j in range(3):
            B[row + i, column + j] += scale * b[i] * a[j]
        B[row + i, column + i] -= scale * ab
