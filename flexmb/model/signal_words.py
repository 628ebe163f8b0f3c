"""The words by which model files make signals: functions of time, measurements, blocks."""

from __future__ import annotations

from flexmb.model.blocks import BLOCKS
from flexmb.model.function_block import Delay, Function
from flexmb.model.held_blocks import HELD_BLOCKS
from flexmb.model.measurement import Formula, Measurement
from flexmb.model.signal import Signal
from flexmb.model.table2_signal import Table2
from flexmb.model.table_signal import SIGNALS

__all__ = ["SIGNAL_WORDS"]

SIGNAL_WORDS: dict[str, type[Signal]] = {
    **SIGNALS,
    **{kind.word: kind for kind in (Measurement, Formula, Function, Delay, Table2)},
    **BLOCKS,
    **HELD_BLOCKS,
}
"""All kinds of signals by the word that makes them."""
