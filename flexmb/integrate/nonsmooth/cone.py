"""One contact: the impulse in Coulomb's cone that its velocity asks for, eqs. (signorini, coulomb), exactly.

With the velocity xi = D P + q of the contact after the impulse P, axes (normal, two tangents)::

    0 <= P_N  _|_  xi_N >= 0,      |P_T| <= mu P_N,   P_T = -mu P_N xi_T / |xi_T| where it slips

There are three cases, taking off, sticking and slipping; the last is one equation in the angle of slip. The cone is
round: no direction is better than another. Source of the cases: Bonnefon & Daviet, Quartic formulation of Coulomb 3D
frictional contact, INRIA 2011; Acary & Brogliato, Numerical Methods for Nonsmooth Dynamical Systems, 2008, ch. 13.
"""

from __future__ import annotations

import numpy as np

from flexmb.math.kernel import inner_kernel, kernel

__all__ = ["disc_moment", "residual_of_contact", "solve_cone"]

LOOKS, HALVINGS = 200, 70
"""Doublings and halvings of a normal impulse, where Newton's method does not find the angle of slip."""
ROUNDING = 1e-13
"""Of an angle, rad."""
SOFT = 1e-13
"""Added to tangential mobilities, relative to the normal one: directions in which nothing can move stick."""


@inner_kernel
def _slip(D, q, mu, angle, u):
    """Return P_N, the turning part of the slip, and its derivative at an angle of P_T; the slip goes to `u` (2,)."""
    c, s = np.cos(angle), np.sin(angle)
    along = D[0, 0] + mu * (D[0, 1] * c + D[0, 2] * s)
    P = -q[0] / along
    dP = q[0] / (along * along) * mu * (D[0, 2] * c - D[0, 1] * s)
    a = D[1, 0] + mu * (D[1, 1] * c + D[1, 2] * s)
    b = D[2, 0] + mu * (D[2, 1] * c + D[2, 2] * s)
    u[0], u[1] = q[1] + P * a, q[2] + P * b
    du0 = dP * a + P * mu * (D[1, 2] * c - D[1, 1] * s)
    du1 = dP * b + P * mu * (D[2, 2] * c - D[2, 1] * s)
    return P, u[0] * s - u[1] * c, du0 * s - du1 * c + u[0] * c + u[1] * s


@inner_kernel
def _slips_back(D, q, mu, angle, u):
    """Does the contact press and slip against P_T at this angle?"""
    P = _slip(D, q, mu, angle, u)[0]
    return P > 0.0 and np.isfinite(P) and u[0] * np.cos(angle) + u[1] * np.sin(angle) <= 0.0


@inner_kernel
def _angle_of_slip(D, q, mu, angle, u):
    """Return the angle of P_T, from a guess; 1e9 if there is none."""
    size = abs(q[0]) + abs(q[1]) + abs(q[2])
    for _ in range(12):
        _, off, slope = _slip(D, q, mu, angle, u)
        if not abs(slope) > 1e-12 * size:
            break
        step = -off / slope
        angle += min(0.5, max(-0.5, step))
        if abs(step) < ROUNDING:
            break
    off, slope = _slip(D, q, mu, angle, u)[1:]
    if abs(off) <= 1e-12 * size and _slips_back(D, q, mu, angle, u):
        return angle
    return 1e9


@inner_kernel
def _velocity_under(D, q, mu, x, u):
    """Return the normal velocity under the normal impulse x and the friction it allows, which goes to `u` (2,)."""
    soft = SOFT * D[0, 0]
    a, d = D[1, 1] + soft, D[2, 2] + soft
    u[0], u[1] = disc_moment(a, D[1, 2], D[2, 1], d, q[1] + D[1, 0] * x, q[2] + D[2, 0] * x, mu * x)
    return q[0] + D[0, 0] * x + D[0, 1] * u[0] + D[0, 2] * u[1]


@inner_kernel
def _smallest_impulse(D, q, mu, least, u):
    """Return the normal impulse from `least` on that stops the approach, its friction in `u` (2,): always exists.

    The normal velocity is a continuous function of the normal impulse. Under a large one the contact sticks, and the
    velocity grows with it.
    """
    low = least
    if _velocity_under(D, q, mu, low, u) >= 0.0:
        return low
    high = max(2.0 * low, -q[0] / D[0, 0], 1e-12 * abs(q[0]) / D[0, 0])
    for _ in range(LOOKS):
        if _velocity_under(D, q, mu, high, u) >= 0.0:
            break
        low, high = high, 2.0 * high
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        if _velocity_under(D, q, mu, middle, u) >= 0.0:
            high = middle
        else:
            low = middle
    _velocity_under(D, q, mu, high, u)
    return high


@kernel
def solve_cone(D, q, mu, P, least):
    """Write the impulse P (3,) of one contact, eq. (local-contact); return if there is one.

    Parameters
    ----------
    D : (3, 3), 1/kg
        Velocity per impulse.
    q : (3,), m/s
        Velocity without the impulse.
    mu : float
    P : (3,), N s
        A guess, in place of which the impulse comes.
    least : float, N s
        Least normal impulse, of Poisson's restitution; 0 without.
    """
    normal = D[0, 0]
    if not normal > 0.0:
        P[:] = 0.0
        return q[0] >= 0.0
    u = np.empty(2)
    if mu == 0.0:
        P[0] = max(least, -q[0] / normal)
        P[1] = P[2] = 0.0
        return True
    if least == 0.0 and q[0] >= 0.0:
        P[:] = 0.0
        return True
    soft = SOFT * normal
    a, b, c, d = D[1, 1] + soft, D[1, 2], D[2, 1], D[2, 2] + soft
    # sticking: of (normal, tangent) = (-q), the tangents first, then the normal
    det = a * d - b * c
    n1, n2 = (d * D[1, 0] - b * D[2, 0]) / det, (a * D[2, 0] - c * D[1, 0]) / det
    m1, m2 = (d * q[1] - b * q[2]) / det, (a * q[2] - c * q[1]) / det
    along = normal - D[0, 1] * n1 - D[0, 2] * n2
    x = (-q[0] + D[0, 1] * m1 + D[0, 2] * m2) / along
    if x >= least and along > 0.0:
        y, z = -m1 - n1 * x, -m2 - n2 * x
        if y * y + z * z <= (mu * x) ** 2:
            P[0], P[1], P[2] = x, y, z
            return True
    if q[0] < 0.0:
        guess = np.arctan2(P[2], P[1]) if P[1] != 0.0 or P[2] != 0.0 else np.arctan2(-q[2], -q[1])
        angle = _angle_of_slip(D, q, mu, guess, u)
        if angle < 1e8:
            x = _slip(D, q, mu, angle, u)[0]
            if x >= least:
                P[0], P[1], P[2] = x, mu * x * np.cos(angle), mu * x * np.sin(angle)
                return True
    P[0] = _smallest_impulse(D, q, mu, least, u)
    P[1], P[2] = u[0], u[1]
    return True


@kernel
def disc_moment(a, b, c, d, x, y, radius):
    """Return (X, Y) in a disc, opposite to the velocity (x, y) + [a, b; c, d] (X, Y) where it is on its edge.

    With the nearly symmetric mobility it is the minimum of a quadratic form on the disc: the multiplier s >= 0 of
    ((a, b; c, d) + s I) (X, Y) = -(x, y), |(X, Y)| = radius, is found by Newton's method on 1 / |(X, Y)|.
    """
    if radius <= 0.0:
        return 0.0, 0.0
    s = 0.0
    X, Y = 0.0, 0.0
    for _ in range(60):
        det = (a + s) * (d + s) - b * c
        X, Y = -((d + s) * x - b * y) / det, -((a + s) * y - c * x) / det
        size = (X * X + Y * Y) ** 0.5
        if size <= radius * (1.0 + 1e-15):
            return X, Y
        # derivative of |(X, Y)| by s: -(X, Y) . inverse . (X, Y) / size
        slope = (X * ((d + s) * X - b * Y) + Y * ((a + s) * Y - c * X)) / (det * size)
        if not slope > 0.0:
            break
        step = (size - radius) / radius * size / slope
        s += step
        if abs(step) <= 1e-15 * s:
            break
    size = (X * X + Y * Y) ** 0.5
    return X * radius / size, Y * radius / size


@kernel
def residual_of_contact(P, xi, scale, mu, least):
    """Return by how much (m/s) an impulse and the velocity after it miss the laws: the natural map of Alart & Curnier.

    ``scale`` (kg) is one over the mobility, with which velocities become impulses.
    """
    x = P[0] - max(least, P[0] - scale * xi[0])
    y, z = P[1] - scale * xi[1], P[2] - scale * xi[2]
    size, radius = (y * y + z * z) ** 0.5, mu * max(P[0], 0.0)
    part = 1.0 if size <= radius else radius / size
    return max(abs(x), ((P[1] - part * y) ** 2 + (P[2] - part * z) ** 2) ** 0.5) / scale
