"""Steps that end where contacts begin and end, where formulas have kinks, and that follow friction through its turn.

After every step the places where forces have a kink are read. Between the ends of the step each follows the cubic
through its values and rates at both ends (Hermite). A contact that begins or ends inside, or both, shortens the step to
just past the first such time. Theory: integrators.
"""

from __future__ import annotations

import numpy as np

from flexmb.integrate.runs.formula_kinks import crossed, left_piece
from flexmb.integrate.runs.gaps_in_steps import first_change, gap_at, rate_of_gap
from flexmb.integrate.runs.switching import Switching, read_switches
from flexmb.math.impact_steps import AT_BEGIN, LONGEST, SHORTEST, SLOWLY, fitting, slow_speed, strikes, struck
from flexmb.math.kernel import inner_kernel
from flexmb.math.kernel_on_demand import kernel_on_demand
from flexmb.math.program import PROGRAM
from flexmb.math.structures import numba_type
from flexmb.math.switches import CROSSING, KINK, PIECE, SLIP, TURN, TURN_GAP, call_sweep
from flexmb.math.tables import CHOICE, NUMBER, STATE, WORK
from flexmb.system.program import run_kernels

__all__ = ["allowed", "part_of_step"]

PAST, NEAR_END = 2.0, 4.0
"""Steps are shortened to so many displacements that do not matter past the begin of a contact; what begins within so
many before the end of a step began at its end."""


@inner_kernel
def _slipped(a, b, share):
    """Return how much longer or shorter a step may be for a slip to change by a share of it."""
    before, after, change = 0.0, 0.0, 0.0
    for i in range(4, 7):
        before += a[i] ** 2
        after += b[i] ** 2
        change += (b[i] - a[i]) ** 2
    most = share * max(before, after) ** 0.5 + 2.0 * max(a[8], b[8])
    change = change**0.5
    return fitting(most, change)


@inner_kernel
def _touched(a, b, h, g0, g1, speed):
    """May a contact have begun and ended in a step which is open at both ends?

    The cubic does not know what turned the motion: without it the one end leads through the surface, or the other
    comes from behind it.
    """
    if g0 + g1 > 4.0 * speed * h:
        return False
    return g0 + h * rate_of_gap(a) < 0.0 or g1 - h * rate_of_gap(b) < 0.0 or first_change(a, b, h, 0.0) <= 1.0


@inner_kernel
def _swept(program, sw, h, adaptive):
    """Return the part of a step that may be taken by the kinds that follow their surfaces through it."""
    part = np.empty(1)
    part[0] = LONGEST
    first = 0
    for k in range(len(sw.kinds)):
        last = first + sw.kinds[k, 3]
        if sw.kinds[k, 4] != 0:
            rows = program.raw[sw.kinds[k, 1] : sw.kinds[k, 2]]
            now, then = sw.now[first:last], sw.then[first:last]
            call_sweep(sw.kinds[k, 4], rows, program.bulk, now, then, h, adaptive, sw.limits, part)
        first = last
    return part[0]


@inner_kernel
def _struck(a, b, h, limits, g0, g1, speed, short):
    """Return by how much a step may be longer or shorter where something strikes in it, from its gaps at the ends."""
    floor = limits[0].floor if a[0] != TURN_GAP else limits[0].share
    before, after = rate_of_gap(a), rate_of_gap(b)
    if not strikes(before, after, short, floor, limits[0].duration):
        return LONGEST
    if not (g0 < 0.0 or g1 < 0.0 or _touched(a, b, h, g0, g1, speed)):
        return LONGEST
    share, slow, depth = limits[0].impact, slow_speed(limits, floor, h), max(-g0, -g1)
    fits = struck(before, after, depth, h, share, max(slow, share * b[8]))
    share = min(share, AT_BEGIN)
    felt = max(abs(before), abs(after)) >= SLOWLY * b[8]
    begins = felt and g0 > 0.0 > g1 and fits >= 1.0
    if begins and struck(before, after, depth, h, share, max(slow, share * b[8])) < 1.0:
        fits = max(SHORTEST, min(0.9, first_change(a, b, h, 0.0)))
    return fits


@inner_kernel
def _by_gap(a, b, h, limits, adaptive):
    """Return the part of a step that a gap allows."""
    floor = limits[0].share if a[0] == TURN_GAP else limits[0].floor
    speed = 0.0
    for i in range(4, 7):
        speed = max(speed, abs(a[i]), abs(b[i]))
    follows = adaptive and b[9] > 0.0 and np.isfinite(limits[0].impact)
    short = 2.0 * speed * h <= floor  # the depth of a hard contact may be less than that, its change of speed not
    if short and not follows:
        return LONGEST
    g0, g1 = gap_at(a, b, h, 0.0)[0], gap_at(a, b, h, 1.0)[0]
    level = 1e-3 * floor
    unseen = not short and g0 > level and g1 > level
    if unseen and g0 + g1 > 4.0 * speed * h:
        return LONGEST  # too far apart to touch
    felt = max(abs(rate_of_gap(a)), abs(rate_of_gap(b))) >= SLOWLY * b[8]
    if unseen or (not short and adaptive and b[9] > 0.0 and felt):
        part = first_change(a, b, h, level)
        near = floor / (speed * h)
        if part < 1.0 - NEAR_END * near:
            return part + PAST * near
    return _struck(a, b, h, limits, g0, g1, speed, short) if follows else LONGEST


@inner_kernel
def _by_formula(a, b, h, span, limits):
    """Return the part of a step that a formula or the piece of a table allows."""
    return left_piece(a, b, h, span, limits) if a[0] == PIECE else crossed(a, b, h, span, limits)


@kernel_on_demand(NUMBER, PROGRAM, numba_type(Switching), NUMBER, CHOICE)
def allowed(program, sw, h, adaptive):
    """Return the part of a step that may be taken; from 1.0 on it may, and the next be so many times as long.

    A step of fixed size is shortened only where a contact would begin and end in it unseen.
    """
    least = _swept(program, sw, h, adaptive)
    for n in range(len(sw.now)):
        a, b = sw.now[n], sw.then[n]
        if a[0] < 0.0 or b[0] < 0.0 or a[0] == TURN:
            continue
        if a[0] == SLIP:
            if adaptive and np.isfinite(sw.limits[0].slip):
                least = min(least, _slipped(a, b, sw.limits[0].slip))
        elif a[0] == CROSSING or a[0] == KINK or a[0] == PIECE:
            if adaptive:
                least = min(least, _by_formula(a, b, h, sw.spans[n], sw.limits))
        else:
            least = min(least, _by_gap(a, b, h, sw.limits, adaptive))
    return least


@kernel_on_demand(NUMBER, PROGRAM, numba_type(Switching), STATE, WORK, NUMBER, CHOICE)
def part_of_step(program, sw, state, work, h, adaptive):
    """Return `allowed` of a step with the end `state`; markers are placed anew.

    The last correction of an iteration is small for places, but over a short step not for speeds.
    """
    run_kernels(program.place, 0, program, state, work)
    read_switches(program, sw, state, work)
    return allowed(program, sw, h, adaptive)
