"""What forces with a kink tell of themselves: where it is, and how fast the motion nears it.

A row of numbers per place: kind, path d (3), its rate d' (3), threshold, scale, weight. The kind is

- GAP: a gap ``d_x - threshold``; DISTANCE: a gap ``|d| - threshold``; both are open above zero. The weight is 1.0 where
  steps follow an impact. The scale is 0.0, or of one of many points of a line the speed of the fastest one, m/s, by a
  share of which a step may change that of any impact;
  TURN_GAP: a GAP in rad, the unit of whose numbers does not follow lengths;
- SLIP: friction with the slip d', which turns within `scale` (m/s or rad/s);
- TURN: a rotation vector d that may not pass half a turn;
- CROSSING: a number d_x of the user that changes its sign where a force jumps or has a kink; d'_x is its rate as far as
  it is known, without what accelerations do to it;
- KINK: the same where only the rate of a force jumps: steps end there, but may begin across it;
- PIECE: a number d_x that leaves the piece of a table between two of its points: steps end just behind it;
- IDLE: nothing now.

Numbers of formulas (CROSSING, KINK, PIECE) have no unit that is known here. Their columns from 10 on are `FORMULA`.

Of surfaces the numbers from 10 on are their relative pose: d, d', w (3 each) and Q (9), all in the axes of the first.
A kind that writes them has a kernel "sweep", which finds contacts that begin and end within a step.
"""

from __future__ import annotations

import numpy as np

from flexmb.math.structures import Record, array_type
from flexmb.math.tables import BYTES, CHOICE, FLOATS, NUMBER, STATE, WORK, caller, pointer_kernel, void

__all__ = [
    "COLUMNS",
    "CROSSING",
    "DISTANCE",
    "FORMULA",
    "GAP",
    "HELD",
    "IDLE",
    "KINK",
    "OF_LENGTHS",
    "PIECE",
    "PIECE_BEGIN",
    "PIECE_END",
    "SLIP",
    "TURN",
    "TURN_GAP",
    "UNITLESS",
    "UNKNOWN",
    "SwitchLimits",
    "call_sweep",
    "call_switches",
    "sweep_kernel",
    "switch_kernel",
]

IDLE, GAP, DISTANCE, SLIP, TURN, CROSSING, KINK, PIECE, TURN_GAP = -1.0, 0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0
FORMULA, UNKNOWN, OF_LENGTHS, PIECE_BEGIN, PIECE_END = 10, 11, 12, 16, 17
"""1.0: a number of a formula; 1.0: its rate follows from accelerations, which nobody knows; sums of its derivatives by
lengths, by angles and states, by speeds, and by rates of angles; ends of a piece.
"""
UNITLESS = 2.0
"""In the column `FORMULA`: a number whose unit nobody knows, located relative to the largest that it has been."""
HELD = -1.0
"""There: the same, at whose zero a value that blocks hold will change: no step goes on behind it."""
COLUMNS = 28
SWITCHES = void(array_type(BYTES), array_type(FLOATS), STATE, WORK, array_type(np.dtype(float), 2))
"""(rows, data, state, work, out): write the places of all rows of a kind, as evaluated last."""

call_switches = caller(SWITCHES)
"""Call the kernel at an address that writes the switches of a kind."""


def switch_kernel(function):
    """Declare a kernel that writes the switches of a kind."""
    return pointer_kernel(SWITCHES)(function)


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
    duration: float
    """s, of the run: speeds of an impact at which nothing moves by more than `floor` in that time do not matter"""
    blur: float
    """1: steps across a jump are not shorter than a displacement that does not matter; 0: as short as can be"""
    rounding: float
    """m, of positions of which speeds are differences (of angles: relative to the length of the model, as `share`);
    0: speeds are integrated by themselves"""
    unfelt: float
    """1: a force that begins within a step is not felt in it; 0: it is at the end of the step"""
    closed: int
    """1: something touched in the last step"""
    turned: int
    """number of the turn, from 1, that has passed half a turn; 0: none"""


SWEEPS = void(
    array_type(BYTES),
    array_type(FLOATS),
    array_type(np.dtype(float), 2),
    array_type(np.dtype(float), 2),
    NUMBER,
    CHOICE,
    array_type(SwitchLimits.dtype),
    array_type(FLOATS),
)
"""(rows, data, now, then, h, adaptive, limits, part): lower part[0] to where in a step of h, s, a contact begins that
is open at both of its ends, as far as it is deeper than `limits[0].floor`, m. Kinds that write no gaps follow their
impacts here too, if steps are `adaptive`."""

call_sweep = caller(SWEEPS)
"""Call the kernel at an address that looks for contacts within a step."""


def sweep_kernel(function):
    """Declare a kernel that looks for contacts of a kind within a step."""
    return pointer_kernel(SWEEPS)(function)
