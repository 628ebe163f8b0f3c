"""The feet of a point on a profile: all places where the distance is least among their neighbours.

Lines, arcs and involutes in closed form. The nearest point of an involute lies on the tangent from the point to its
base circle. On a cubic the places are roots of a polynomial of degree five, isolated by the signs of its Bernstein
coefficients (Lane & Riesenfeld 1981: no sign change, no root; one change, one root), so none is missed.
"""

from __future__ import annotations

import math

import numpy as np

from flexmb.math.kernel import inner_kernel, kernel
from flexmb.profiles.segments import ARC, INVOLUTE, LINE, WIDTH, evaluate_segment, place_of, wrapped

__all__ = ["FOOT", "MOST_FEET", "find_feet", "rising_roots"]

FOOT = 7
"""Numbers of a foot: x, y, outward normal (2), distance (negative inside the material), c with Hessian c t t^T of the
distance, curvature of the profile there (infinite: a corner)."""
MOST_FEET = 8
ROUNDING = 1e-12
"""Cosines below this are right angles: at smooth joints neither side may lose the foot."""
EPS = 2.0**-52
DEPTH = 52
"""Of bisections: a root is located to the last digit."""


@inner_kernel
def _split(b, degree, left, right):
    """Write the Bernstein coefficients of both halves (de Casteljau)."""
    for k in range(degree + 1):
        right[k] = b[k]
    left[0] = b[0]
    for level in range(1, degree + 1):
        for k in range(degree + 1 - level):
            right[k] = 0.5 * (right[k] + right[k + 1])
        left[level] = right[0]


@kernel
def rising_roots(power, degree, roots):
    """Write the roots in (0, 1) at which the polynomial sum power_k h^k rises through zero; return their number."""
    stack = np.empty((2 * DEPTH + 4, 8))
    for i in range(degree + 1):  # from powers to Bernstein: b_i = sum_k C(i, k) / C(degree, k) a_k
        total, choose = 0.0, 1.0
        for k in range(i + 1):
            total += choose * power[k]
            choose *= (i - k) / (degree - k) if degree > k else 0.0
        stack[0, i] = total
    stack[0, 6], stack[0, 7] = 0.0, 1.0
    top, count = 1, 0
    b = np.empty(8)
    while top > 0:
        top -= 1
        b[:] = stack[top]
        changes, last = 0, 0.0
        for i in range(degree + 1):
            if b[i] != 0.0:
                if last * b[i] < 0.0:
                    changes += 1
                last = b[i]
        low, high = b[6], b[7]
        if changes == 0:
            continue
        if (changes == 1 and b[0] < 0.0 < b[degree]) or high - low < 1e-14:
            if count < len(roots) and b[0] <= 0.0 <= b[degree]:
                roots[count] = _bracketed(power, degree, low, high)
                count += 1
            continue
        if changes == 1 and b[0] > 0.0 > b[degree]:  # one root, through which it falls
            continue
        _split(b, degree, stack[top + 1], stack[top])
        middle = 0.5 * (low + high)
        stack[top + 1, 6], stack[top + 1, 7] = low, middle
        stack[top, 6], stack[top, 7] = middle, high
        top += 2
    return count


@inner_kernel
def _bracketed(power, degree, low, high):
    """Return the root of a polynomial that rises from `low` to `high`, by Newton's method kept inside."""
    h = 0.5 * (low + high)
    for _ in range(100):
        f, slope = 0.0, 0.0
        for k in range(degree, -1, -1):
            slope = slope * h + f
            f = f * h + power[k]
        if f < 0.0:
            low = h
        else:
            high = h
        step = f / slope if slope > 0.0 else np.inf
        following = h - step
        if not low < following < high:
            following = 0.5 * (low + high)
        if abs(following - h) <= 1e-16 * (1.0 + abs(h)):
            return following
        h = following
    return h


@inner_kernel
def _minima(table, i, x, y, places):
    """Write the places inside segment i at which the distance from (x, y) is least; return their number."""
    at = place_of(i)
    kind = table[at]
    s = table[at + 5 : at + WIDTH]
    h = -1.0
    if kind == LINE:
        h = ((x - s[0]) * s[2] + (y - s[1]) * s[3]) / (s[2] * s[2] + s[3] * s[3])
    elif kind == ARC:
        angle = math.atan2(y - s[1], x - s[0])
        if s[4] > 0.0:
            h = (wrapped(angle, s[3]) - s[3]) / s[4]
        else:
            h = (wrapped(angle, s[3] - 2.0 * np.pi) - s[3]) / s[4]
    elif kind == INVOLUTE:
        dx, dy = x - s[0], y - s[1]
        far = (dx * dx + dy * dy) ** 0.5
        if far <= s[2]:
            return 0
        g = math.atan2(dy, dx) + s[4] * math.acos(s[2] / far)
        t = wrapped(s[4] * (g - s[3]), min(s[5], s[6]))
        h = (t - s[5]) / (s[6] - s[5])
    else:
        power = np.zeros(6)
        for k in range(2):
            a0, a1, a2, a3 = s[4 * k], s[4 * k + 1], s[4 * k + 2], s[4 * k + 3]
            a0 -= x if k == 0 else y
            power[0] += a1 * a0
            power[1] += a1 * a1 + 2.0 * a2 * a0
            power[2] += 3.0 * a1 * a2 + 3.0 * a3 * a0
            power[3] += 4.0 * a1 * a3 + 2.0 * a2 * a2
            power[4] += 5.0 * a2 * a3
            power[5] += 3.0 * a3 * a3
        return rising_roots(power, 5, places)
    if 0.0 < h < 1.0:
        places[0] = h
        return 1
    return 0


@inner_kernel
def _box_distance(table, i, x, y):
    """Return the distance from (x, y) to the box of segment i: no point of it is nearer."""
    at = place_of(i)
    dx = max(table[at + 1] - x, 0.0, x - table[at + 2])
    dy = max(table[at + 3] - y, 0.0, y - table[at + 4])
    return (dx * dx + dy * dy) ** 0.5


@inner_kernel
def _far_corner(table, i, x, y):
    """Return the distance from (x, y) to the farthest corner of the box of segment i: its points are nearer."""
    at = place_of(i)
    dx = max(x - table[at + 1], table[at + 2] - x)
    dy = max(y - table[at + 3], table[at + 4] - y)
    return (dx * dx + dy * dy) ** 0.5


@inner_kernel
def _keep(x, y, nx, ny, distance, bend, curvature, feet, count):
    """Put a foot at its place among `feet`, nearest first; return how many there are."""
    for k in range(count):
        if abs(feet[k, 0] - x) + abs(feet[k, 1] - y) <= 1e-7 * abs(distance):
            return count  # on both sides of a joint
    if count == len(feet):
        if abs(distance) >= abs(feet[count - 1, 4]):
            return count
        count -= 1
    k = count
    while k > 0 and abs(feet[k - 1, 4]) > abs(distance):
        for j in range(FOOT):
            feet[k, j] = feet[k - 1, j]
        k -= 1
    feet[k, 0], feet[k, 1], feet[k, 2], feet[k, 3] = x, y, nx, ny
    feet[k, 4], feet[k, 5], feet[k, 6] = distance, bend, curvature
    return count + 1


@inner_kernel
def _smooth_foot(out, x, y, feet, count):
    """Keep the foot inside a segment, which is evaluated in `out`."""
    speed = (out[1, 0] ** 2 + out[1, 1] ** 2) ** 0.5
    nx, ny = out[1, 1] / speed, -out[1, 0] / speed
    distance = nx * (x - out[0, 0]) + ny * (y - out[0, 1])
    curvature = (out[1, 0] * out[2, 1] - out[1, 1] * out[2, 0]) / speed**3
    if curvature * distance <= -1.0:  # beyond the centre of curvature it is the farthest place
        return count
    bend = curvature / (1.0 + curvature * distance)
    return _keep(out[0, 0], out[0, 1], nx, ny, distance, bend, curvature, feet, count)


@inner_kernel
def _corner_foot(before, after, x, y, feet, count):
    """Keep the joint of two segments, evaluated in `before` and `after`, if the distance is least there."""
    ex, ey = x - after[0, 0], y - after[0, 1]
    distance = (ex * ex + ey * ey) ** 0.5
    here = before[1, 0] * ex + before[1, 1] * ey
    there = after[1, 0] * ex + after[1, 1] * ey
    # on the joint itself the place is known to the rounding of its coordinates only
    slack = distance * ROUNDING + 4.0 * EPS * (abs(x) + abs(y))
    one = (before[1, 0] ** 2 + before[1, 1] ** 2) ** 0.5 * slack
    two = (after[1, 0] ** 2 + after[1, 1] ** 2) ** 0.5 * slack
    if here < -one or there > two:
        return count
    if here <= one and there >= -two:  # across both: the joint is smooth, or the point is on it
        return _smooth_foot(after, x, y, feet, count)
    if before[1, 0] * after[1, 1] - before[1, 1] * after[1, 0] < 0.0:  # a hollow corner is nearest from inside only
        distance = -distance
    return _keep(after[0, 0], after[0, 1], ex / distance, ey / distance, distance, 1.0 / distance, np.inf, feet, count)


@kernel
def find_feet(table, x, y, reach, feet):
    """Write the nearest foot of (x, y), and those within `reach`, to `feet` (n, FOOT), nearest first; return how many.

    The nearest foot is always among them, however far, unless the point lies beyond the ends of an open profile.
    """
    n, closed = int(table[0]), table[1] == 1.0
    out, before = np.empty((3, 2)), np.empty((3, 2))
    places = np.empty(6)
    limit = np.inf
    for i in range(n):
        limit = min(limit, _far_corner(table, i, x, y))
    limit = max(limit, reach) if closed else np.inf
    count = 0
    for i in range(n):
        if _box_distance(table, i, x, y) > limit * (1.0 + 1e-12):
            continue
        for k in range(_minima(table, i, x, y, places)):
            evaluate_segment(table, i, places[k], out)
            count = _smooth_foot(out, x, y, feet, count)
        if i > 0 or closed:
            evaluate_segment(table, i - 1 if i > 0 else n - 1, 1.0, before)
            evaluate_segment(table, i, 0.0, out)
            count = _corner_foot(before, out, x, y, feet, count)
    while count > 1 and abs(feet[count - 1, 4]) > reach:
        count -= 1
    return count
