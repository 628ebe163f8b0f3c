"""The supports of a profile in a direction: all places that stand out farthest among their neighbours.

A flat face with this normal touches the profile there. Lines stand out at their ends only, arcs and involutes have
closed forms, and a cubic has at most one place, the root of a polynomial of degree two.
"""

from __future__ import annotations

import math

import numpy as np

from flexmb.math.kernel import inner_kernel, kernel
from flexmb.profiles.feet import ROUNDING, rising_roots
from flexmb.profiles.segments import ARC, CUBIC, INVOLUTE, WIDTH, evaluate_segment, place_of, wrapped

__all__ = ["MOST_SUPPORTS", "SUPPORT", "find_supports"]

SUPPORT = 4
"""Numbers of a support: x, y, radius of curvature (0: a corner), how far it stands out."""
MOST_SUPPORTS = 8


@inner_kernel
def _outermost(table, i, nx, ny, places):
    """Write the places inside segment i with the outward normal (nx, ny), convex there; return their number."""
    at = place_of(i)
    kind = table[at]
    s = table[at + 5 : at + WIDTH]
    if kind == ARC:
        if s[4] < 0.0:
            return 0
        places[0] = (wrapped(math.atan2(ny, nx), s[3]) - s[3]) / s[4]
        return 1 if 0.0 < places[0] < 1.0 else 0
    if kind == INVOLUTE:  # the outward normal lies along the string: away from the base circle on walks to larger rolls
        speed = s[6] - s[5]
        g = math.atan2(ny, nx) + (0.5 * np.pi if speed > 0.0 else -0.5 * np.pi)
        t = wrapped(s[4] * (g - s[3]), min(s[5], s[6]))
        places[0] = (t - s[5]) / speed
        return 1 if 0.0 < places[0] < 1.0 else 0
    if kind == CUBIC:
        power = np.zeros(3)
        for k in range(2):
            n = nx if k == 0 else ny
            power[0] -= n * s[4 * k + 1]
            power[1] -= n * 2.0 * s[4 * k + 2]
            power[2] -= n * 3.0 * s[4 * k + 3]
        return rising_roots(power, 2, places)
    return 0


@inner_kernel
def _keep(x, y, radius, far, found, count):
    """Put a support at its place, the farthest first; return how many there are."""
    for k in range(count):
        if abs(found[k, 0] - x) + abs(found[k, 1] - y) <= 1e-9 * (abs(x) + abs(y)):
            return count  # on both sides of a joint
    if count == len(found):
        if far <= found[count - 1, 3]:
            return count
        count -= 1
    k = count
    while k > 0 and found[k - 1, 3] < far:
        for j in range(SUPPORT):
            found[k, j] = found[k - 1, j]
        k -= 1
    found[k, 0], found[k, 1], found[k, 2], found[k, 3] = x, y, radius, far
    return count + 1


@inner_kernel
def _corner_radius(nx, ny, before, after):
    """Return the radius of curvature of a joint that stands out in the direction n, 0 for a corner; -1 if it does not.

    At smooth joints neither side may lose the support to rounding.
    """
    one = ROUNDING * (before[1, 0] ** 2 + before[1, 1] ** 2) ** 0.5
    two = ROUNDING * (after[1, 0] ** 2 + after[1, 1] ** 2) ** 0.5
    here, there = nx * before[1, 0] + ny * before[1, 1], nx * after[1, 0] + ny * after[1, 1]
    if here < -one or there > two:
        return -1.0
    if here > one or there < -two:  # a corner, which stands out if it is convex
        return 0.0 if before[1, 0] * after[1, 1] - before[1, 1] * after[1, 0] > 0.0 else -1.0
    if nx * after[1, 1] - ny * after[1, 0] <= 0.0:
        return -1.0
    bend = after[1, 0] * after[2, 1] - after[1, 1] * after[2, 0]
    return (after[1, 0] ** 2 + after[1, 1] ** 2) ** 1.5 / bend if bend > 0.0 else 0.0


@kernel
def find_supports(table, nx, ny, found):
    """Write the supports in the direction (nx, ny) to `found` (n, SUPPORT), the farthest first; return how many."""
    n, closed = int(table[0]), table[1] == 1.0
    out, before = np.empty((3, 2)), np.empty((3, 2))
    places = np.empty(6)
    count = 0
    for i in range(n):
        for k in range(_outermost(table, i, nx, ny, places)):
            evaluate_segment(table, i, places[k], out)
            if nx * out[1, 1] - ny * out[1, 0] <= 0.0:
                continue  # the other side of a thin part, or of a hollow
            square = out[1, 0] ** 2 + out[1, 1] ** 2
            bend = out[1, 0] * out[2, 1] - out[1, 1] * out[2, 0]
            if bend <= 0.0:
                continue  # hollow
            radius = square**1.5 / bend
            count = _keep(out[0, 0], out[0, 1], radius, nx * out[0, 0] + ny * out[0, 1], found, count)
        if i == 0 and not closed:
            continue
        evaluate_segment(table, i - 1 if i > 0 else n - 1, 1.0, before)
        evaluate_segment(table, i, 0.0, out)
        radius = _corner_radius(nx, ny, before, out)
        if radius >= 0.0:
            count = _keep(out[0, 0], out[0, 1], radius, nx * out[0, 0] + ny * out[0, 1], found, count)
    return count
