"""The share of the Sun's disc that a spherical body leaves to be seen from a place in its shadow.

The Sun is a disc of the apparent half angle a, the body one of b = asin(R / r), their centres are the angle c apart
(Montenbruck & Gill 2000, section 3.4.2). Between a + b, where the penumbra begins, and b - a, where the umbra does, the
discs have in common

    A = a^2 acos(x / a) + b^2 acos((c - x) / b) - c y,   x = (c^2 + a^2 - b^2) / (2 c),   y = sqrt(a^2 - x^2),

and the share is 1 - A / (pi a^2). With dA/dc = -2 y and dA/db = 2 b acos((c - x) / b) its slope is known too. Without a
half angle the shadow is a cylinder, at whose wall the light jumps.
"""

from __future__ import annotations

import math

from flexmb.math.kernel import inner_kernel, kernel
from flexmb.math.vectors import dot, norm

__all__ = ["edges", "lit"]


@inner_kernel
def _angles(r, s, radius):
    """Return b and c, rad, of a place r from the body's centre and a unit vector s towards the Sun."""
    far = norm(r)
    b = math.asin(radius / far) if far > radius else 0.5 * math.pi
    return b, math.acos(min(1.0, max(-1.0, -dot(r, s) / far)))


@kernel
def lit(r, s, radius, a, slope):
    """Return the share of the light at a place r (3,), and write its gradient (3,), 1/m.

    s (3,) is the unit vector towards the Sun, a half of its apparent angle.
    """
    slope[:] = 0.0
    b, c = _angles(r, s, radius)
    if c >= a + b:
        return 1.0
    if c <= b - a:
        return 0.0
    if c <= a - b:
        # a ring is seen
        share, by_b, by_c = 1.0 - (b / a) ** 2, -2.0 * b / (a * a), 0.0
    else:
        x = (c * c + a * a - b * b) / (2.0 * c)
        y = math.sqrt(max(0.0, a * a - x * x))
        own, other = math.acos(min(1.0, max(-1.0, x / a))), math.acos(min(1.0, max(-1.0, (c - x) / b)))
        disc = math.pi * a * a
        share = 1.0 - (a * a * own + b * b * other - c * y) / disc
        by_b, by_c = -2.0 * b * other / disc, 2.0 * y / disc
    far = norm(r)
    toward, across = dot(r, s) / far, math.sin(c)
    for i in range(3):
        e = r[i] / far
        if far > radius:
            slope[i] -= by_b * radius / (far * math.sqrt(far * far - radius * radius)) * e
        if across > 0.0:
            slope[i] += by_c * (s[i] - toward * e) / (far * across)
    return share


@kernel
def edges(r, v, s, ds, radius, a, out):
    """Write how far the place is outside of penumbra and umbra, rad, and the rates: (2, 2).

    v (3,) is the velocity of the place, ds (3,) the rate of s.
    """
    b, c = _angles(r, s, radius)
    far, across = norm(r), math.sin(c)
    rising = dot(r, v) / far
    toward = dot(r, s) / far
    turning = (dot(v, s) + dot(r, ds)) / far - toward * rising / far
    c_rate = turning / across if across > 0.0 else 0.0
    b_rate = -radius * rising / (far * math.sqrt(far * far - radius * radius)) if far > radius else 0.0
    out[0, 0], out[0, 1] = c - b - a, c_rate - b_rate
    out[1, 0], out[1, 1] = c - abs(b - a), c_rate - (b_rate if b >= a else -b_rate)
