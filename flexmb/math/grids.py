"""Functions of two numbers through points of a grid: products of piecewise cubic polynomials."""

from __future__ import annotations

import numpy as np

from flexmb.math.kernel import inner_kernel, kernel
from flexmb.math.plain_loops import knots_until

__all__ = ["interpolate_grid"]


@inner_kernel
def _place(x, knots):
    """Return the number of the piece, the distance from its first knot, and 1.0 unless x is outside (held)."""
    n = len(knots)
    i = min(max(knots_until(knots, x) - 1, 0), n - 2)
    if x < knots[0]:
        return i, 0.0, 0.0
    if x > knots[n - 1]:
        return i, knots[n - 1] - knots[i], 0.0
    return i, x - knots[i], 1.0


@kernel
def interpolate_grid(x, y, table, out):
    """Write f, f_x, f_y, f_xx, f_xy, f_yy to `out` (6,).

    `table` = n, m, knots (n,), knots (m,), coefficients (n - 1, m - 1, 4, 4) of x^3 ... x^0 times y^3 ... y^0. Before
    the first and after the last knot values are held.
    """
    n, m = int(table[0]), int(table[1])
    i, h, inside_x = _place(x, table[2 : 2 + n])
    j, k, inside_y = _place(y, table[2 + n : 2 + n + m])
    first = 2 + n + m + 16 * (i * (m - 1) + j)
    out[:] = 0.0
    f, fx, fxx = np.zeros(3), np.zeros(3), np.zeros(3)  # with their derivatives by y
    for p in range(4):
        at = first + 4 * p
        a, b, c, d = table[at], table[at + 1], table[at + 2], table[at + 3]
        row = (((a * k + b) * k + c) * k + d, (3.0 * a * k + 2.0 * b) * k + c, 6.0 * a * k + 2.0 * b)
        for q in range(3):  # Horner, with derivatives
            fxx[q] = fxx[q] * h + 2.0 * fx[q]
            fx[q] = fx[q] * h + f[q]
            f[q] = f[q] * h + row[q]
    out[0] = f[0]
    out[1], out[2] = inside_x * fx[0], inside_y * f[1]
    out[3], out[4], out[5] = inside_x * fxx[0], inside_x * inside_y * fx[1], inside_y * f[2]
