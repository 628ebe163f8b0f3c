"""Steps that end where contacts begin and end, where formulas have kinks, and that follow friction through its turn.

After every step the places where forces have a kink are read. Between the ends of the step each follows the cubic
through its values and rates at both ends (Hermite). A contact that begins or ends inside, or both, shortens the step to
just past the first such time. Theory: integrators.
"""

from __future__ import annotations

from typing import Annotated, NamedTuple

import numpy as np

from flexmb.math.kernel import inner_kernel, kernel
from flexmb.math.plain_loops import copy_into
from flexmb.math.structures import ArrayOf, FloatRows, Floats, IntegerRows, Record, structure
from flexmb.math.switches import (
    COLUMNS,
    CROSSING,
    DISTANCE,
    FORMULA,
    GAP,
    KINK,
    OF_LENGTHS,
    PIECE,
    PIECE_BEGIN,
    PIECE_END,
    SLIP,
    TURN,
    TURN_GAP,
    UNKNOWN,
    call_sweep,
    call_switches,
)
from flexmb.system.program import run_kernels

__all__ = ["JUMPED", "SAME", "Switching", "allowed", "keep_switches", "new_switching", "part_of_step", "read_switches"]


class SwitchLimits(Record):
    """What a step may pass over."""

    floor: float
    """m, displacement that does not matter"""
    share: float
    """the same relative to the length of the model, of angles in rad, and of what a formula changes by in a step"""
    impact: float
    """share of the speed of an impact by which a step may change it; infinite: any"""
    slip: float
    """share of a slip by which a step may change it; infinite: any"""
    blur: float
    """1: steps across a jump are not shorter than a displacement that does not matter; 0: as short as can be"""
    closed: int
    """1: something touched in the last step"""
    turned: int
    """number of the turn, from 1, that has passed half a turn; 0: none"""


@structure
class Switching(NamedTuple):
    """The switches of a run."""

    kinds: IntegerRows
    """(nk, 5) address, first and last byte, number, address of the sweep: see `System`"""
    now: FloatRows
    """(n, COLUMNS) at the start of a step"""
    then: FloatRows
    """(n, COLUMNS) at its end"""
    limits: Annotated[np.ndarray, ArrayOf(SwitchLimits.dtype)]
    """one row"""
    touched: Floats
    """(n,) m/s, sum of the changes of speed in steps during which a contact was closed"""
    spans: Floats
    """(n,) by how much numbers of formulas change in a step, lately"""
    passed: Floats
    """(n,) how many times a formula has passed its jump once more within `AT_ONCE` steps"""
    since: Floats
    """(n,) steps since it passed"""


PAST, NEAR_END = 2.0, 4.0
"""Steps are shortened to so many displacements that do not matter past the begin of a contact; what begins within so
many before the end of a step began at its end."""
AT_ONCE = 4.0
"""Steps within which a formula that chatters passes its jump once more; between the passes of a swing are more."""
LOOKS, HALVINGS = 16, 40
SAME, BENT, JUMPED = 0, 1, 2
LATEST = 0.999
"""Part of a step from which on a crossing lies in the next one."""
SHORTEST, LONGEST = 0.1, 4.0
"""Least part of a step that is tried again where it changed a speed too much, and the largest growth."""


def new_switching(
    system, state, work, *, floor: float, impact: float = np.inf, slip: float = np.inf, blur: float = 0.0
) -> Switching:
    """Return the switches of a state, which has just been evaluated; see `SwitchLimits`."""
    n = len(system.switch_owners)
    sw = Switching(
        kinds=system.switch_kinds,
        now=np.zeros((n, COLUMNS)),
        then=np.zeros((n, COLUMNS)),
        limits=SwitchLimits.table(floor=floor, share=floor / system.lengths.whole, impact=impact, slip=slip, blur=blur),
        touched=np.zeros(n),
        spans=np.zeros(n),
        passed=np.zeros(n),
        since=np.full(n, np.inf),
    )
    read_switches(system.program, sw, state, work)
    sw.now[:] = sw.then
    return sw


@kernel
def read_switches(program, sw, state, work):
    """Write the switches of the state evaluated last to `then`."""
    first = 0
    for k in range(len(sw.kinds)):
        last = first + sw.kinds[k, 3]
        rows = program.raw[sw.kinds[k, 1] : sw.kinds[k, 2]]
        call_switches(sw.kinds[k, 0], rows, program.bulk, state, work, sw.then[first:last])
        first = last


@inner_kernel
def _gap(a, b, h, s):
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


@inner_kernel
def _first_change(a, b, h, level):
    """Return the part of a step at which a gap first passes `level` from the side where it begins; 2.0 if never."""
    g, along = _gap(a, b, h, 0.0)
    opened = g > level
    before = 0.0
    for k in range(1, LOOKS + 1):
        s = k / LOOKS
        g, next_along = _gap(a, b, h, s)
        inside = s
        if opened and g > level and along < 0.0 and next_along > 0.0:
            # it came nearest in between
            low, high = before, s
            for _ in range(HALVINGS):
                inside = 0.5 * (low + high)
                if _gap(a, b, h, inside)[1] < 0.0:
                    low = inside
                else:
                    high = inside
            g = _gap(a, b, h, inside)[0]
        if (g > level) != opened:
            low, high = before, inside
            for _ in range(HALVINGS):
                middle = 0.5 * (low + high)
                if (_gap(a, b, h, middle)[0] > level) == opened:
                    low = middle
                else:
                    high = middle
            return high
        before, along = s, next_along
    return 2.0


@inner_kernel
def _rate(a):
    """Return the rate of a gap."""
    if a[0] != DISTANCE:
        return a[4]
    size = max((a[1] * a[1] + a[2] * a[2] + a[3] * a[3]) ** 0.5, 1e-150)
    return (a[1] * a[4] + a[2] * a[5] + a[3] * a[6]) / size


@inner_kernel
def _fitting(most, change):
    """Return the factor of a step for a change to be below the largest one; 1.0 at least if it is already."""
    if change <= most:
        return min(LONGEST, max(1.0, 0.9 * most / change)) if change > 0.0 else LONGEST
    return max(SHORTEST, 0.8 * most / change)


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
    return _fitting(most, change)


@inner_kernel
def _struck(a, b, h, g0, g1, share):
    """Return how much longer or shorter a step may be for the speed of an impact to change by a share of it.

    The speed of an impact is that at which it began: sqrt(v^2 + p |v'|) with the penetration p, if it is elastic.
    """
    before, after = _rate(a), _rate(b)
    change, depth = abs(after - before), max(0.0, -g0, -g1)
    speed = (max(before**2, after**2) + depth * change / h) ** 0.5
    return _fitting(share * speed, change)


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
    part = g0 / (g0 - g1) if unknown else _first_change(a, b, h, 0.0)
    return part if part <= 1.0 else LONGEST, 0.5 * level / (speed * h)


@inner_kernel
def _crossed(a, b, h, span, limits):
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


@inner_kernel
def _left_piece(a, b, h, span, limits):
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


@inner_kernel
def _swept(program, sw, h, floor):
    """Return the part of a step that may be taken by the kinds that follow their surfaces through it."""
    part = np.empty(1)
    part[0] = LONGEST
    first = 0
    for k in range(len(sw.kinds)):
        last = first + sw.kinds[k, 3]
        if sw.kinds[k, 4] != 0:
            rows = program.raw[sw.kinds[k, 1] : sw.kinds[k, 2]]
            call_sweep(sw.kinds[k, 4], rows, program.bulk, sw.now[first:last], sw.then[first:last], h, floor, part)
        first = last
    return part[0]


@kernel
def allowed(program, sw, h, adaptive):
    """Return the part of a step that may be taken; from 1.0 on it may, and the next be so many times as long.

    A step of fixed size is shortened only where a contact would begin and end in it unseen.
    """
    least = _swept(program, sw, h, sw.limits[0].floor)
    for n in range(len(sw.now)):
        a, b = sw.now[n], sw.then[n]
        if a[0] < 0.0 or b[0] < 0.0 or a[0] == TURN:
            continue
        if a[0] == SLIP:
            if adaptive and np.isfinite(sw.limits[0].slip):
                least = min(least, _slipped(a, b, sw.limits[0].slip))
            continue
        if a[0] == CROSSING or a[0] == KINK:
            if adaptive:
                least = min(least, _crossed(a, b, h, sw.spans[n], sw.limits))
            continue
        if a[0] == PIECE:
            if adaptive:
                least = min(least, _left_piece(a, b, h, sw.spans[n], sw.limits))
            continue
        floor = sw.limits[0].share if a[0] == TURN_GAP else sw.limits[0].floor
        speed = 0.0
        for i in range(4, 7):
            speed = max(speed, abs(a[i]), abs(b[i]))
        if 2.0 * speed * h <= floor:
            continue
        g0, g1 = _gap(a, b, h, 0.0)[0], _gap(a, b, h, 1.0)[0]
        level = 1e-3 * floor
        unseen = g0 > level and g1 > level
        if unseen and g0 + g1 > 4.0 * speed * h:
            continue  # too far apart to touch
        if unseen or (adaptive and b[9] > 0.0):
            part = _first_change(a, b, h, level)
            near = floor / (speed * h)
            if part < 1.0 - NEAR_END * near:
                least = min(least, part + PAST * near)
                continue
        if adaptive and b[9] > 0.0 and np.isfinite(sw.limits[0].impact) and (g0 < 0.0 or g1 < 0.0):
            least = min(least, _struck(a, b, h, g0, g1, sw.limits[0].impact))
    return least


@inner_kernel
def _turned_over(a, b):
    """Has a rotation vector jumped from half a turn on one side to half a turn on the other?"""
    along, before, after = 0.0, 0.0, 0.0
    for i in range(1, 4):
        along += a[i] * b[i]
        before += a[i] ** 2
        after += b[i] ** 2
    return along < 0.0 and min(before, after) > 0.25 * np.pi**2


@kernel
def part_of_step(program, sw, state, work, h, adaptive):
    """Return `allowed` of a step with the end `state`; markers are placed anew.

    The last correction of an iteration is small for places, but over a short step not for speeds.
    """
    run_kernels(program.place, 0, program, state, work)
    read_switches(program, sw, state, work)
    return allowed(program, sw, h, adaptive)


@inner_kernel
def _formula_changed(a, b, h, limits):
    """Has a formula passed a kink that matters?"""
    places, speeds = _unfelt(a, limits, h)
    if a[0] == PIECE:
        return a[PIECE_BEGIN] != b[PIECE_BEGIN] and abs(b[1] - a[1]) > places + speeds
    return (a[1] > 0.0) != (b[1] > 0.0) and (a[0] == CROSSING or max(abs(a[1]), abs(b[1])) > places + speeds)


@kernel
def keep_switches(sw, h):
    """Make the end of a step the start of the next; return if a contact has begun or ended, or a formula has passed a
    kink (BENT) or a jump (JUMPED).
    """
    changed, jumped = False, False
    sw.limits[0].closed = 0
    for n in range(len(sw.now)):
        a, b = sw.now[n], sw.then[n]
        if a[0] >= 0.0 and b[0] >= 0.0:
            # of surfaces the same column is a part of their relative place
            if (a[0] == CROSSING or a[0] == KINK or a[0] == PIECE) and a[FORMULA] > 0.0:
                sw.since[n] += 1.0
                if _formula_changed(a, b, h, sw.limits):
                    changed, jumped = True, jumped or a[0] == CROSSING
                    if sw.since[n] <= AT_ONCE:
                        sw.passed[n] += 1.0
                    sw.since[n] = 0.0
                sw.spans[n] = max(abs(b[1] - a[1]), 0.5 * sw.spans[n])
            elif a[0] == TURN:
                if _turned_over(a, b):
                    sw.limits[0].turned = n + 1
            elif a[0] == SLIP:
                sw.touched[n] += abs(b[4] - a[4]) + abs(b[5] - a[5]) + abs(b[6] - a[6])
            else:
                g0, g1 = _gap(a, b, h, 0.0)[0], _gap(a, b, h, 1.0)[0]
                changed = changed or (b[9] > 0.0 and (g0 < 0.0) != (g1 < 0.0))
                if g0 < 0.0 or g1 < 0.0:
                    if a[0] == GAP or a[0] == TURN_GAP or a[0] == DISTANCE:
                        sw.limits[0].closed = 1
                    sw.touched[n] += abs(_rate(b) - _rate(a))
        copy_into(sw.now[n], b)
    return JUMPED if jumped else BENT if changed else SAME
