"""How long a step may be that follows an impact: by what share of its speed it may change that."""

from __future__ import annotations

from flexmb.math.kernel import kernel

__all__ = ["AT_BEGIN", "LONGEST", "SHORTEST", "SLOWLY", "fitting", "slow_speed", "strikes", "struck"]

LONGEST = 4.0
"""The largest growth of a step."""
SHORTEST = 0.1
"""Least part of a step that is tried again where it changed a speed too much."""
AT_BEGIN = 0.02
"""Share of the speed of an impact by which the step in which it begins may change it: its stages lie before and behind
the kink."""
SLOWLY = 0.1
"""Speed at which a point of a line touches, relative to that of its fastest one, from which on it is felt: of slower
ones, as where a belt runs onto a pulley, less than a hundredth of the energy of the line can be wrong."""
STRIKING = 30.0
"""Times the speed that moves nothing that matters in the whole run: an impact, no body that is pressed from rest."""


@kernel
def fitting(most, change):
    """Return the factor of a step for a change to be below the largest one; 1.0 at least if it is already."""
    if change <= most:
        return min(LONGEST, max(1.0, 0.9 * most / change)) if change > 0.0 else LONGEST
    return max(SHORTEST, 0.8 * most / change)


@kernel
def struck(before, after, depth, h, share, slow):
    """Return how much longer or shorter a step of h may be for the speed of an impact to change by a share of it, or by
    what is `slow` for the whole run.

    `before` and `after` are the rates of the gap at its ends, `depth` the deepest penetration there. The speed of an
    impact is that at which it began: sqrt(v^2 + p |v'|) with the penetration p, if it is elastic.
    """
    change = abs(after - before)
    speed = (max(before**2, after**2) + max(0.0, depth) * change / h) ** 0.5
    return fitting(max(share * speed, slow), change)


@kernel
def strikes(before, after, short, floor, duration):
    """Does something strike that moves by more than `floor` in a step (else `short`), or nears faster than it can from
    rest? What is pressed from rest gets its speed by the step itself, in however short a step.
    """
    speed = abs(before)
    return not short or speed > STRIKING * floor / duration or 4.0 * speed >= abs(after - before)


@kernel
def slow_speed(limits, floor, h):
    """Return the speed of an impact, m/s or rad/s, that does not matter.

    A speed that is a difference of positions has their rounding over the step: a shorter one would have more.
    """
    slow = floor / limits[0].duration
    if limits[0].rounding > 0.0:
        slow = max(slow, limits[0].rounding * floor / (limits[0].floor * h))
    return slow
