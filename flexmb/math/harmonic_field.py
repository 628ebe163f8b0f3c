"""All derivatives of a field of attraction at a place: of a point, and of a flattened body.

The derivatives of 1/r follow from a recursion in the powers of 1/r (McMurchie & Davidson 1978, eq. 4.6): with
E_n = (-1)^n (2 n - 1)!! / r^(2 n + 1),

    D_n[t + 1, u, v] = t D_(n+1)[t - 1, u, v] + x D_(n+1)[t, u, v],    D_n[0, 0, 0] = E_n,

and D_0[t, u, v] is the derivative t times by x, u times by y and v times by z. What a flattening J2 adds to the
potential is itself a second derivative, along the axis k: (3 z^2 - r^2) / r^5 = (k . d/dr)^2 1/r.
"""

from __future__ import annotations

from math import expm1, log1p

import numpy as np

from flexmb.math.kernel import inner_kernel, kernel
from flexmb.math.vectors import dot, norm

__all__ = ["HIGHEST", "falling_oblate", "fourth", "hessian", "oblate_field", "point_field", "third"]

HIGHEST = 4
"""Highest derivatives that fields are asked for: of the tangent of a force to second order over a body."""


@inner_kernel
def _inverse_distance(x, order):
    """Return the derivatives of 1/|x| up to an order, D[t, u, v]."""
    n = order + 1
    D = np.zeros((n, n, n, n))
    far = norm(x)
    e = x / far
    size = 1.0
    for k in range(n):
        D[k, 0, 0, 0] = size
        size *= -(2.0 * k + 1.0)
    for s in range(1, n):
        for t in range(s + 1):
            for u in range(s - t + 1):
                v = s - t - u
                for k in range(n - s):
                    if t > 0:
                        found = e[0] * D[k + 1, t - 1, u, v]
                        if t > 1:
                            found += (t - 1) * D[k + 1, t - 2, u, v]
                    elif u > 0:
                        found = e[1] * D[k + 1, t, u - 1, v]
                        if u > 1:
                            found += (u - 1) * D[k + 1, t, u - 2, v]
                    else:
                        found = e[2] * D[k + 1, t, u, v - 1]
                        if v > 1:
                            found += (v - 1) * D[k + 1, t, u, v - 2]
                    D[k, t, u, v] = found
    power = 1.0 / far
    for s in range(n):
        for t in range(s + 1):
            for u in range(s - t + 1):
                D[0, t, u, s - t - u] *= power
        power /= far
    return D[0]


@kernel
def point_field(x, mu, P):
    """Write the derivatives of -mu / |x|, P[t, u, v] up to the order `HIGHEST`."""
    D = _inverse_distance(x, HIGHEST)
    for t in range(HIGHEST + 1):
        for u in range(HIGHEST + 1 - t):
            for v in range(HIGHEST + 1 - t - u):
                P[t, u, v] = -mu * D[t, u, v]


@kernel
def oblate_field(x, k, strength, P):
    """Write the derivatives of strength (k . d/dx)^2 1/|x|, P[t, u, v] up to the order `HIGHEST`.

    The strength is mu J2 R^2 / 2, k (3,) the axis.
    """
    D = _inverse_distance(x, HIGHEST + 2)
    for t in range(HIGHEST + 1):
        for u in range(HIGHEST + 1 - t):
            for v in range(HIGHEST + 1 - t - u):
                twice = k[0] ** 2 * D[t + 2, u, v] + k[1] ** 2 * D[t, u + 2, v] + k[2] ** 2 * D[t, u, v + 2]
                mixed = k[0] * k[1] * D[t + 1, u + 1, v] + k[0] * k[2] * D[t + 1, u, v + 1]
                P[t, u, v] = strength * (twice + 2.0 * (mixed + k[1] * k[2] * D[t, u + 1, v + 1]))


@inner_kernel
def _count(c, i, j, k, m):
    """Return how often an axis is among four (-1: none)."""
    return (1 if i == c else 0) + (1 if j == c else 0) + (1 if k == c else 0) + (1 if m == c else 0)


@inner_kernel
def _entry(P, i, j, k, m):
    return P[_count(0, i, j, k, m), _count(1, i, j, k, m), _count(2, i, j, k, m)]


@kernel
def hessian(P, H):
    """Write the second derivatives (3, 3)."""
    for i in range(3):
        for j in range(3):
            H[i, j] = _entry(P, i, j, -1, -1)


@kernel
def third(P, T):
    """Write the third derivatives (3, 3, 3)."""
    for i in range(3):
        for j in range(3):
            for k in range(3):
                T[i, j, k] = _entry(P, i, j, k, -1)


@kernel
def fourth(P, c, T):
    """Write the change (3, 3, 3) of the third derivatives along the axis c."""
    for i in range(3):
        for j in range(3):
            for k in range(3):
                T[i, j, k] = _entry(P, i, j, k, c)


@kernel
def falling_oblate(rho, d, k, strength, out):
    """Set what a flattening adds to the attraction (3,), m/s2, at rho + d, less that at rho; all of it if rho is 0.

    g = -c ((6 z k + 3 r) / r^5 - 15 z^2 r / r^7), z = k . r; the difference is taken term by term, so nothing cancels.
    """
    near, along, at, rise = dot(rho, rho), 0.0, dot(k, rho), dot(k, d)
    far = 0.0
    for i in range(3):
        far += (rho[i] + d[i]) ** 2
        along += d[i] * (d[i] + 2.0 * rho[i])
    five, seven = far**-2.5, far**-3.5
    by_five, by_seven = 0.0, 0.0
    if near > 0.0:
        grown = log1p(along / near)
        by_five, by_seven = near**-2.5 * expm1(-2.5 * grown), near**-3.5 * expm1(-3.5 * grown)
    z = at + rise
    for i in range(3):
        change = (6.0 * rise * k[i] + 3.0 * d[i]) * five + (6.0 * at * k[i] + 3.0 * rho[i]) * by_five
        change -= 15.0 * z * z * d[i] * seven
        change -= 15.0 * rho[i] * (rise * (2.0 * at + rise) * seven + at * at * by_seven)
        out[i] = -strength * change
