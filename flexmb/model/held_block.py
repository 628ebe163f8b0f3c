"""`HeldBlock`: a signal whose value is held until it jumps: at sample times, or where a threshold is passed.

Such values are neither functions of the present motion nor states with rates. They stand among the last coordinates,
which a step keeps as they are (as the turns of joints), so they are stored with every sample, and carried over events.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from flexmb.model.block import Block
from flexmb.model.measurement import Following
from flexmb.model.signal import Signal

__all__ = ["HeldBlock", "HeldValue"]


class HeldBlock(Block):
    """A signal that is held. It changes at times ``offset + k period``, or whenever `crossing` rises above zero."""

    period: float | None = None
    offset: float = 0.0

    def held(self) -> Mapping[str, float]:
        """Return names and starting values of what is held."""
        raise TypeError(f"{type(self).__name__} holds nothing")

    def reads(self) -> tuple[Signal, ...]:
        """Return the signals that a change reads."""
        raise TypeError(f"{type(self).__name__} reads nothing")

    def crossing(self) -> Signal | None:
        """Return the signal that passes zero upwards where the value changes; None for changes at sample times."""
        return None

    def following(self, held: np.ndarray, read: np.ndarray) -> np.ndarray:
        """Return what is held after a change, from what was held and what is read, in their orders."""
        raise TypeError(f"{type(self).__name__} does not change")

    def value(self, name: str) -> HeldValue:
        """Return what is held as a signal."""
        return HeldValue(self, name)


@dataclass(frozen=True, eq=False)
class HeldValue(Following):
    """A value that a block holds."""

    block: Any
    name: str
    word: ClassVar[str] = "held"
