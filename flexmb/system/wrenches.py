"""Wrenches of forces that are measured in loops: their rows, channels and derivatives."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from flexmb.constraints.loop import words
from flexmb.constraints.wrench import EACH_PAIR, WRENCH
from flexmb.errors import ModelError

__all__ = ["Wrenches"]


class Wrenches:
    """Gives the forces whose wrenches are measured their channels, behind the forces that follow."""

    def __init__(self, compiler):
        self.compiler = compiler
        self.known: dict[str, tuple[int, tuple[int, ...]]] = {}

    def rows(self, parts: Iterable[str], first: int) -> tuple[list[tuple[Any, tuple]], int]:
        """Return the rows that measure the forces of these names, and the number of all channels; `first` is free."""
        items, compiler = [], self.compiler
        for part in parts:
            force = compiler.model.force(part)
            table, row, pairs, follows = compiler.written[part]
            if follows or force.reads_reactions:
                raise ModelError(
                    f"Sensor of {force.title}",
                    found=f"a force that {'follows measurements itself' if follows else 'depends on reactions'}",
                    expected="a force of place, motion, time and its own states",
                    remedy="Follow the signal that it follows (SignalValue)" if follows else "Measure the motion",
                )
            copied = np.array([row], table.row).view(float)
            self.known[part] = first, pairs
            values = {
                "marker": compiler.marker(force.measure(compiler.model)),
                "address": table.kernels["apply"].compiled.address,
                "row": compiler.bulk(copied),
                "words": len(copied),
                "pairs": compiler.bulk(words(pairs)),
                "n_pairs": len(pairs),
                "channel": first,
            }
            items.append((WRENCH, WRENCH.filled(None, values)))
            first += 1 + EACH_PAIR * len(pairs)
        return items, first

    def place(self, part: str, pair: int) -> tuple[int, int, int, int]:
        """Return the channel of a wrench, of the derivatives by a pair of the force (-1: none), and its markers."""
        channel, pairs = self.known[part]
        if pair >= len(pairs):
            return channel, -1, -1, -1
        a, b, _ = next(key for key, number in self.compiler.pairs.items() if number == pairs[pair])
        return channel, channel + 1 + EACH_PAIR * pair, a, b

    def more_pairs(self, part: str) -> range:
        """Return the pairs of a force besides the first."""
        return range(1, len(self.known[part][1]))
