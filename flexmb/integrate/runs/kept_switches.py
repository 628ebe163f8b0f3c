"""What is kept of the switches from step to step: which contacts have begun and ended, and how fast speeds changed."""

from __future__ import annotations

import numpy as np

from flexmb.integrate.runs.formula_kinks import formula_changed
from flexmb.integrate.runs.gaps_in_steps import first_change, gap_at, rate_of_gap
from flexmb.integrate.runs.spells import follow_spell, forget_spell
from flexmb.integrate.runs.switching import Switching
from flexmb.math.impact_steps import SLOWLY
from flexmb.math.kernel import inner_kernel
from flexmb.math.kernel_on_demand import kernel_on_demand
from flexmb.math.plain_loops import copy_into
from flexmb.math.structures import numba_type
from flexmb.math.switches import CROSSING, DISTANCE, FORMULA, GAP, HELD, KINK, PIECE, SLIP, TURN, TURN_GAP, UNITLESS
from flexmb.math.tables import COUNT, NUMBER

__all__ = ["BENT", "JUMPED", "SAME", "keep_switches"]

AT_ONCE = 4.0
"""Steps within which a formula that chatters passes its jump once more; between the passes of a swing are more."""
SAME, BENT, JUMPED = 0, 1, 2


@inner_kernel
def _turned_over(a, b):
    """Has a rotation vector jumped from half a turn on one side to half a turn on the other?"""
    along, before, after = 0.0, 0.0, 0.0
    for i in range(1, 4):
        along += a[i] * b[i]
        before += a[i] ** 2
        after += b[i] ** 2
    return along < 0.0 and min(before, after) > 0.25 * np.pi**2


@inner_kernel
def _within(a, b, h, apart):
    """Has a contact begun and ended in a step which is open at both ends, `apart` together?"""
    speed = 0.0
    for i in range(4, 7):
        speed = max(speed, abs(a[i]), abs(b[i]))
    return apart <= 4.0 * speed * h and first_change(a, b, h, 0.0) <= 1.0


@inner_kernel
def _follow_formula(sw, n, a, b, h):
    """Note how far a formula has come, and what it was while it passed a kink or a jump; return if it has."""
    changed = False
    sw.since[n] += 1.0
    if formula_changed(a, b, h, sw.limits):
        changed = True
        if sw.since[n] <= AT_ONCE:
            sw.passed[n] += 1.0
        sw.since[n] = 0.0
    if a[FORMULA] == UNITLESS:
        sw.spans[n] = max(sw.spans[n], abs(a[1]), abs(b[1]))
    else:
        sw.spans[n] = max(abs(b[1] - a[1]), 0.5 * sw.spans[n])
    return changed


@inner_kernel
def _follow_gap(sw, n, a, b, h):
    """Note what a gap tells of its contact; return if that has begun or ended."""
    g0, g1 = gap_at(a, b, h, 0.0)[0], gap_at(a, b, h, 1.0)[0]
    change = abs(rate_of_gap(b) - rate_of_gap(a))
    speed, fastest = max(abs(rate_of_gap(a)), abs(rate_of_gap(b))), max(a[8], b[8])
    if g0 < 0.0 or g1 < 0.0:
        if a[0] == GAP or a[0] == TURN_GAP or a[0] == DISTANCE:
            sw.limits[0].closed = 1
        sw.touched[n] += change
    sw.spells[n].deepest = max(sw.spells[n].deepest, -g1)
    if b[9] > 0.0 and (g0 < 0.0 or g1 < 0.0 or _within(a, b, h, g0 + g1)):
        follow_spell(sw.spells[n], g0, g1, change, speed, fastest, h)
    return b[9] > 0.0 and (g0 < 0.0) != (g1 < 0.0) and speed >= SLOWLY * fastest


@kernel_on_demand(COUNT, numba_type(Switching), NUMBER)
def keep_switches(sw, h):
    """Make the end of a step the start of the next; return if a contact has begun or ended, or a formula has passed a
    kink (BENT) or a jump (JUMPED).
    """
    changed, jumped = False, False
    sw.limits[0].closed = 0
    for n in range(len(sw.now)):
        a, b = sw.now[n], sw.then[n]
        if a[0] >= 0.0 and b[0] >= 0.0:
            formula = a[0] == CROSSING or a[0] == KINK or a[0] == PIECE
            # of surfaces the same column is a part of their relative place
            if formula and a[FORMULA] > 0.0:
                if _follow_formula(sw, n, a, b, h):
                    changed, jumped = True, jumped or a[0] == CROSSING
            elif a[0] == TURN:
                if _turned_over(a, b):
                    sw.limits[0].turned = n + 1
            elif a[0] == SLIP:
                sw.touched[n] += abs(b[4] - a[4]) + abs(b[5] - a[5]) + abs(b[6] - a[6])
            else:
                if a[FORMULA] == HELD and formula:
                    sw.spans[n] = max(sw.spans[n], abs(a[1]), abs(b[1]))
                changed = _follow_gap(sw, n, a, b, h) or changed
        else:
            forget_spell(sw.spells[n])
        copy_into(sw.now[n], b)
    return JUMPED if jumped else BENT if changed else SAME
