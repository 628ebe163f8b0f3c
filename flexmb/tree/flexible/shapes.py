"""Where flexible bodies and their markers are: poses and twists that follow the modes, with their velocity terms.

With the translation and rotation shapes Phi_t, Phi_r of a marker, ``s = s_0 + Phi_t eta`` and ``theta = Phi_r eta``, it
is at s in body axes, its axes are ``exp(theta~) A_0``, and its twist against the body, at the body's origin, is
``E eta'``, ``E = [T Phi_r; Phi_t + s~ T Phi_r]`` in (angular, linear): theory, eq. (bend-columns).
"""

from __future__ import annotations

import numpy as np

from flexmb.math.eights import WIDTH, keep, less, more, read, same, times
from flexmb.math.kernel import inner_kernel, kernel
from flexmb.tree.rigid.places import carry

__all__ = ["clear_inertia", "place_bend", "place_mount", "rate_of_place", "shape", "write_columns"]

SMALL = 2.5e-3
"""Square of an angle below which series are exact to the last digit, rad2."""


@inner_kernel
def _coefficients(x):
    """Return a, b, c, b', c' of a rotation with squared angle x: exp = 1 + a t~ + b t~^2, T = 1 + b t~ + c t~^2.

    b' and c' are derivatives by the angle, divided by it.
    """
    if x < SMALL:  # powers times constants: each of a dozen divisions would take longer
        a = 1.0 + x * (-1 / 6 + x * (1 / 120 + x * (-1 / 5040 + x * (1 / 362880))))
        b = 0.5 + x * (-1 / 24 + x * (1 / 720 + x * (-1 / 40320)))
        c = 1 / 6 + x * (-1 / 120 + x * (1 / 5040 + x * (-1 / 362880)))
        db = -1 / 12 + x * (1 / 180 + x * (-1 / 6720))
        dc = -1 / 60 + x * (1 / 1260 + x * (-1 / 60480))
        return a, b, c, db, dc
    t = x**0.5
    sine, rest = np.sin(t), 1.0 - np.cos(t)
    a, b, c = sine / t, rest / x, (t - sine) / (x * t)
    return a, b, c, (t * sine - 2.0 * rest) / (x * x), (3.0 * sine - 2.0 * t - t * np.cos(t)) / (x * x * t)


@inner_kernel
def _sums(rises, m, eta, rate, out):
    """Write Phi_t eta, Phi_r eta, two zeros, and the same of the rates to `out` (16,)."""
    a, b = same(0.0), same(0.0)
    for j in range(m):
        row = read(rises, (j, 0))
        a, b = more(a, eta[j], row), more(b, rate[j], row)
    keep(out, 0, a)
    keep(out, WIDTH, b)


@kernel
def write_columns(shapes, m, present, E):
    """Write [T Phi_r; Phi_t + s~ T Phi_r] of shapes (6, m) to E; present (12,) has s and T."""
    x, y, z, T = present[0], present[1], present[2], present[3:]
    for at in range(0, m, WIDTH):
        a, b, c = read(shapes, (3, at)), read(shapes, (4, at)), read(shapes, (5, at))
        f = more(more(times(T[0], a), T[1], b), T[2], c)
        g = more(more(times(T[3], a), T[4], b), T[5], c)
        h = more(more(times(T[6], a), T[7], b), T[8], c)
        keep(E, (0, at), f)
        keep(E, (1, at), g)
        keep(E, (2, at), h)
        keep(E, (3, at), less(more(read(shapes, (0, at)), y, h), z, g))
        keep(E, (4, at), less(more(read(shapes, (1, at)), z, f), x, h))
        keep(E, (5, at), less(more(read(shapes, (2, at)), x, g), y, f))


@kernel
def rate_of_place(rises, m, present, rates, first):
    """Return what modal rates or second rates, from `first` on, add to the twist of a place at the body's origin: E
    times them, as six numbers.
    """
    x = np.empty(WIDTH)
    a = same(0.0)
    for j in range(m):
        a = more(a, rates[first + j], read(rises, (j, 0)))
    keep(x, 0, a)
    u, v, w = x[3], x[4], x[5]
    p = present[3] * u + present[4] * v + present[5] * w
    q = present[6] * u + present[7] * v + present[8] * w
    r = present[9] * u + present[10] * v + present[11] * w
    u, v, w = present[0], present[1], present[2]
    return p, q, r, x[0] + v * r - w * q, x[1] + w * p - u * r, x[2] + u * q - v * p


@kernel
def shape(rest, rises, m, eta, rate, present, A, motion):
    """Write a marker of a deformed body: s and T to `present` (12,), axes A (3, 3), and its motion (12,).

    The motion has s, its rate, the spin T theta' and T' theta', in body axes. rest (12,) : s and axes of the undeformed
    one
    """
    x = np.empty(2 * WIDTH)
    _sums(rises, m, eta, rate, x)
    p, q, r = x[3], x[4], x[5]
    square = p * p + q * q + r * r
    a, b, c, db, dc = _coefficients(square)
    # T = 1 + b t~ + c (t t^T - t.t 1)
    d = 1.0 - c * square
    T = (
        d + c * p * p,
        c * p * q - b * r,
        c * p * r + b * q,
        c * p * q + b * r,
        d + c * q * q,
        c * q * r - b * p,
        c * p * r - b * q,
        c * q * r + b * p,
        d + c * r * r,
    )
    d = 1.0 - b * square
    X = (
        d + b * p * p,
        b * p * q - a * r,
        b * p * r + a * q,
        b * p * q + a * r,
        d + b * q * q,
        b * q * r - a * p,
        b * p * r - a * q,
        b * q * r + a * p,
        d + b * r * r,
    )
    for j in range(3):
        u, v, w = rest[3 + j], rest[6 + j], rest[9 + j]
        A[0, j] = X[0] * u + X[1] * v + X[2] * w
        A[1, j] = X[3] * u + X[4] * v + X[5] * w
        A[2, j] = X[6] * u + X[7] * v + X[8] * w
    sx, sy, sz = rest[0] + x[0], rest[1] + x[1], rest[2] + x[2]
    present[0], present[1], present[2] = sx, sy, sz
    present[3], present[4], present[5] = T[0], T[1], T[2]
    present[6], present[7], present[8] = T[3], T[4], T[5]
    present[9], present[10], present[11] = T[6], T[7], T[8]
    u, v, w = x[11], x[12], x[13]
    motion[0], motion[1], motion[2] = sx, sy, sz
    motion[3], motion[4], motion[5] = x[8], x[9], x[10]
    motion[6] = T[0] * u + T[1] * v + T[2] * w
    motion[7] = T[3] * u + T[4] * v + T[5] * w
    motion[8] = T[6] * u + T[7] * v + T[8] * w
    # T' rate = b' (t.rate) t x rate + c' (t.rate) t x (t x rate) + c rate x (t x rate)
    e, f, g = q * w - r * v, r * u - p * w, p * v - q * u
    speed = p * u + q * v + r * w
    db, dc = db * speed, dc * speed
    motion[9] = db * e + dc * (q * g - r * f) + c * (v * g - w * f)
    motion[10] = db * f + dc * (r * e - p * g) + c * (w * e - u * g)
    motion[11] = db * g + dc * (p * f - q * e) + c * (u * f - v * e)


@kernel
def clear_inertia(row):
    """Forget what rigid links gave to a link."""
    row.J[:] = 0.0
    row.H[:] = 0.0
    row.M[:] = 0.0


@kernel
def place_bend(link, row, of_parent, A, motion):
    """Place the frame of a flexible body, whose own marker has the axes A and the motion of `shape`, in its parent.

    The marker stands still in the parent: the frame moves with -E eta'.
    """
    for i in range(3):
        a, b, c = link.R[i, 0], link.R[i, 1], link.R[i, 2]
        for j in range(3):
            row.R[i, j] = a * A[j, 0] + b * A[j, 1] + c * A[j, 2]
        row.r[i] = link.r[i] - row.R[i, 0] * motion[0] - row.R[i, 1] * motion[1] - row.R[i, 2] * motion[2]
    V, bias = row.twist, row.bias
    carry(row, of_parent.twist, V)
    x, y, z = motion[0], motion[1], motion[2]
    f, g, h = motion[3], motion[4], motion[5]
    p, q, r = motion[6], motion[7], motion[8]
    d, e, k = motion[9], motion[10], motion[11]
    # relative velocity of the origin, -(s' + s x spin)
    u, v, w = -f - (y * r - z * q), -g - (z * p - x * r), -h - (x * q - y * p)
    V[0] -= p
    V[1] -= q
    V[2] -= r
    V[3] += u
    V[4] += v
    V[5] += w
    bias[0] = q * V[2] - r * V[1] - d
    bias[1] = r * V[0] - p * V[2] - e
    bias[2] = p * V[1] - q * V[0] - k
    bias[3] = V[1] * w - V[2] * v - (V[4] * r - V[5] * q) - (g * r - h * q) - (y * k - z * e)
    bias[4] = V[2] * u - V[0] * w - (V[5] * p - V[3] * r) - (h * p - f * r) - (z * d - x * k)
    bias[5] = V[0] * v - V[1] * u - (V[3] * q - V[4] * p) - (f * q - g * p) - (x * e - y * d)
    row.force[:] = 0.0


@kernel
def place_mount(row, of_parent, A, motion):
    """Place a marker of a flexible body, with the axes A and the motion of `shape`, in the body."""
    V, bias = row.twist, row.bias
    for i in range(3):
        row.r[i] = motion[i]
        for j in range(3):
            row.R[i, j] = A[i, j]
    carry(row, of_parent.twist, V)
    f, g, h = motion[3], motion[4], motion[5]
    p, q, r = motion[6], motion[7], motion[8]
    x, y, z = q * h - r * g, r * f - p * h, p * g - q * f  # spin x s'
    d, e, n = motion[9], motion[10], motion[11]
    own = row.rate  # scratch: the relative twist in axes of the marker
    for i in range(3):
        a, b, c = A[0, i], A[1, i], A[2, i]
        own[i] = a * p + b * q + c * r
        own[3 + i] = a * f + b * g + c * h
        bias[i] = a * d + b * e + c * n
        bias[3 + i] = -(a * x + b * y + c * z)
        V[i] += own[i]
        V[3 + i] += own[3 + i]
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        bias[i] += V[j] * own[k] - V[k] * own[j]
        bias[3 + i] += V[j] * own[3 + k] - V[k] * own[3 + j] + V[3 + j] * own[k] - V[3 + k] * own[j]
    row.force[:] = 0.0
