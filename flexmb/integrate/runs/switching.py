"""`Switching`: the places where forces of a run have a kink, at both ends of a step."""

from __future__ import annotations

from typing import Annotated, NamedTuple

import numpy as np

from flexmb.integrate.runs.spells import Spell
from flexmb.math.kernel import kernel
from flexmb.math.structures import ArrayOf, FloatRows, Floats, IntegerRows, structure
from flexmb.math.switches import COLUMNS, FORMULA, KINK, PIECE, SwitchLimits, call_switches

__all__ = ["PassedOver", "Switching", "new_switching", "read_switches"]


class PassedOver(NamedTuple):
    """The same as an integrator gives it."""

    floor: float = 0.0
    impact: float = np.inf
    slip: float = np.inf
    blur: float = 0.0
    duration: float = np.inf
    rounding: float = 0.0
    unfelt: float = 0.0


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
    """(n,) by how much numbers of formulas change in a step, lately; of numbers without unit the largest so far"""
    passed: Floats
    """(n,) how many times a formula has passed its jump once more within `AT_ONCE` steps"""
    since: Floats
    """(n,) steps since it passed"""
    spells: Annotated[np.ndarray, ArrayOf(Spell.dtype)]
    """(n,) how long contacts have been closed"""


def new_switching(system, state, work, over: PassedOver, fixed: bool = False) -> Switching:
    """Return the switches of a state, which has just been evaluated; see `SwitchLimits`.

    Steps of `fixed` size go over the corners of formulas: where there is nothing else, there are no switches.
    """
    sw = _all_switches(system, state, work, over, len(system.switch_owners))
    if not (fixed and len(sw.now)):
        return sw
    corners = np.isin(sw.now[:, 0], (KINK, PIECE)) & (sw.now[:, FORMULA] > 0.0)
    return _all_switches(system, state, work, over, 0) if np.all(corners) else sw


def _all_switches(system, state, work, over: PassedOver, n: int) -> Switching:
    """Return the switches of a state, or none (n = 0)."""
    sw = Switching(
        kinds=system.switch_kinds[: len(system.switch_kinds) if n else 0],
        now=np.zeros((n, COLUMNS)),
        then=np.zeros((n, COLUMNS)),
        limits=SwitchLimits.table(share=over.floor / system.lengths.whole, **over._asdict()),
        touched=np.zeros(n),
        spans=np.zeros(n),
        passed=np.zeros(n),
        since=np.full(n, np.inf),
        spells=np.zeros(n, Spell.dtype),
    )
    if n:
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
