"""Gaps within a step: the cubic through values and rates at both of its ends (Hermite), and where it passes a level."""

from __future__ import annotations

from flexmb.math.kernel import kernel
from flexmb.math.switches import DISTANCE

__all__ = ["first_change", "gap_at", "rate_of_gap"]

LOOKS, HALVINGS = 16, 40


@kernel
def gap_at(a, b, h, s):
    """Return the gap at the part s of a step with the ends a and b, and d . d' if it is a distance."""
    s2, s3 = s * s, s * s * s
    p, q = 1.0 - 3.0 * s2 + 2.0 * s3, 3.0 * s2 - 2.0 * s3
    m, n = s - 2.0 * s2 + s3, s3 - s2
    dp, dm, dn = 6.0 * s2 - 6.0 * s, 1.0 - 4.0 * s + 3.0 * s2, 3.0 * s2 - 2.0 * s
    if a[0] != DISTANCE:
        return p * a[1] + q * b[1] + h * (m * a[4] + n * b[4]) - a[7], 0.0
    square, along = 0.0, 0.0
    for i in range(1, 4):
        x = p * a[i] + q * b[i] + h * (m * a[3 + i] + n * b[3 + i])
        rate = dp * (a[i] - b[i]) + h * (dm * a[3 + i] + dn * b[3 + i])
        square += x * x
        along += x * rate
    return square**0.5 - a[7], along


@kernel
def first_change(a, b, h, level):
    """Return the part of a step at which a gap first passes `level` from the side where it begins; 2.0 if never."""
    g, along = gap_at(a, b, h, 0.0)
    opened = g > level
    before = 0.0
    for k in range(1, LOOKS + 1):
        s = k / LOOKS
        g, next_along = gap_at(a, b, h, s)
        inside = s
        if opened and g > level and along < 0.0 and next_along > 0.0:
            # it came nearest in between
            low, high = before, s
            for _ in range(HALVINGS):
                inside = 0.5 * (low + high)
                if gap_at(a, b, h, inside)[1] < 0.0:
                    low = inside
                else:
                    high = inside
            g = gap_at(a, b, h, inside)[0]
        if (g > level) != opened:
            low, high = before, inside
            for _ in range(HALVINGS):
                middle = 0.5 * (low + high)
                if (gap_at(a, b, h, middle)[0] > level) == opened:
                    low = middle
                else:
                    high = middle
            return high
        before, along = s, next_along
    return 2.0


@kernel
def rate_of_gap(a):
    """Return the rate of a gap."""
    if a[0] != DISTANCE:
        return a[4]
    size = max((a[1] * a[1] + a[2] * a[2] + a[3] * a[3]) ** 0.5, 1e-150)
    return (a[1] * a[4] + a[2] * a[5] + a[3] * a[6]) / size
