"""Numbers of formulas within a step: where they pass a kink or a jump of a force, and whether that matters."""

from __future__ import annotations

import numpy as np

from flexmb.integrate.runs.gaps_in_steps import first_change
from flexmb.math.impact_steps import LONGEST
from flexmb.math.kernel import inner_kernel, kernel
from flexmb.math.switches import (
    CROSSING,
    FORMULA,
    HELD,
    KINK,
    OF_LENGTHS,
    PIECE,
    PIECE_BEGIN,
    PIECE_END,
    UNITLESS,
    UNKNOWN,
)

__all__ = ["crossed", "formula_changed", "left_piece"]

LATEST = 0.999
"""Part of a step from which on a crossing lies in the next one."""


@inner_kernel
def _unfelt(a, limits, h):
    """Return how far a number of a formula may lie from its kink where that moves nothing further than matters:
    because it follows places, and because it follows speeds, in a step of h.
    """
    floor, share, n = limits[0].floor, limits[0].share, OF_LENGTHS
    return floor * a[n] + share * a[n + 1], (floor * a[n + 2] + share * a[n + 3]) / h


@inner_kernel
def _precision(a, b, span, limits, h):
    """Return how near to its kink a number is to come, and up to where a kink does not matter at all."""
    if a[FORMULA] == 0.0:
        return limits[0].floor, 0.0
    if a[FORMULA] == UNITLESS or a[FORMULA] == HELD:
        return limits[0].share * max(span, abs(a[1]), abs(b[1])), 0.0
    places, speeds = _unfelt(a, limits, h)
    level = limits[0].share * max(span, abs(b[1] - a[1]))
    return max(level, limits[0].blur * places) if a[0] == CROSSING else level, places + speeds


@inner_kernel
def _passing(a, b, h, level, begins):
    """Return the part of a step at which a number passes its threshold a[7], and the part in which it comes so near
    that it does not matter; `LONGEST` if it does not pass.

    Rates may be unknown: a place that is missed is looked for again in the shorter step, or in the next one.
    """
    g0, g1 = a[1] - a[7], b[1] - a[7]
    unknown = a[UNKNOWN] > 0.0 or b[UNKNOWN] > 0.0
    speed = abs(g1 - g0) / h
    if not unknown:
        speed = max(abs(a[4]), abs(b[4]), speed)
    opposite = (g0 > 0.0) != (g1 > 0.0)
    if not speed * h > 0.0 or (opposite and begins and abs(g1) <= level):
        return LONGEST, 0.0
    if not opposite and (unknown or 2.0 * speed * h <= level or abs(g0) + abs(g1) > 4.0 * speed * h):
        return LONGEST, 0.0
    part = g0 / (g0 - g1) if unknown else first_change(a, b, h, 0.0)
    return part if part <= 1.0 else LONGEST, 0.5 * level / (speed * h)


@kernel
def crossed(a, b, h, span, limits):
    """Return the part of a step that ends just before a number of the user passes zero, or, of one that begins there,
    just past it; `LONGEST` if it does not pass. A step that ends past a jump of the force would have it as its end.
    """
    level, unfelt = _precision(a, b, span, limits, h)
    begins = abs(a[1]) <= level
    if max(abs(a[1]), abs(b[1])) <= unfelt:
        return LONGEST
    if a[0] == KINK and (begins or abs(b[1]) <= level):
        return LONGEST  # a step across it would be too short to matter
    part, near = _passing(a, b, h, level, begins)
    if part > 1.0:
        return LONGEST
    return min(part + near if begins else max(part - near, 0.5 * part), LATEST)


@kernel
def left_piece(a, b, h, span, limits):
    """Return the part of a step that ends just behind the end of a piece of a table, where the next one begins;
    `LONGEST` if it ends on the same piece.
    """
    level, unfelt = _precision(a, b, span, limits, h)
    least = LONGEST
    for side in (PIECE_BEGIN, PIECE_END):
        a[7] = a[side]
        g0, g1 = a[1] - a[7], b[1] - a[7]
        if np.isfinite(a[7]) and abs(g1) > level and max(abs(g0), abs(g1)) > unfelt:
            part, near = _passing(a, b, h, level, abs(g0) <= level)
            if part <= 1.0 and part + near < LATEST:
                least = min(least, part + near)
    a[7] = 0.0
    return least


@kernel
def formula_changed(a, b, h, limits):
    """Has a formula passed a kink that matters?"""
    places, speeds = _unfelt(a, limits, h)
    if a[0] == PIECE:
        return a[PIECE_BEGIN] != b[PIECE_BEGIN] and abs(b[1] - a[1]) > places + speeds
    return (a[1] > 0.0) != (b[1] > 0.0) and (a[0] == CROSSING or max(abs(a[1]), abs(b[1])) > places + speeds)
