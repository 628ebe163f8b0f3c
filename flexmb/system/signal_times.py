"""`SignalTimes`: when the signals of a system are not smooth, and when they change fast."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from flexmb.model.breakpoints import breakpoints
from flexmb.model.expression import SignalProgram
from flexmb.model.time_scale import resolution

__all__ = ["SignalTimes", "Times"]

NEAR = 1e-3
"""Part of its cell by which a time of one signal may differ from another's that stands for both."""


@dataclass(frozen=True, eq=False)
class Times:
    """Times of all signals of a system within a span.

    Parameters
    ----------
    begin, end : float, s
    breaks : (n,), s
        When one may jump or kink, increasing; some may lie outside of the span.
    fine : (m,), s
        Ends of cells of time within which a parabola tells what they do, where they begin to change faster.
    missed : tuple of int
        Signals of which not all such times were found.
    sampled : (k,), s
        Those breaks at which blocks sample.
    """

    begin: float
    end: float
    breaks: np.ndarray
    fine: np.ndarray
    missed: tuple[int, ...] = ()
    sampled: np.ndarray = field(default_factory=lambda: np.empty(0))


@dataclass(frozen=True, eq=False)
class SignalTimes:
    """The times at which steps must end, found when they are first asked for.

    Parameters
    ----------
    programs : sequence of SignalProgram
        Of all signals, by number.
    titles : tuple of str
        Which part has each signal, for messages.
    clocks : tuple of (float, float), s
        Period of blocks that sample, and one of their times.
    """

    programs: Sequence[SignalProgram]
    titles: tuple[str, ...]
    clocks: tuple[tuple[float, float], ...] = ()
    _known: list[Times] = field(default_factory=list, repr=False)

    def between(self, begin: float, end: float) -> Times:
        """Return the times between `begin` and `end`, s, or of a longer span that holds them."""
        for known in self._known:
            if known.begin <= begin and end <= known.end:
                return known
        breaks, fine, missed = [np.empty(0)], [], []
        for number, program in enumerate(self.programs):
            found = breakpoints(program, begin, end)
            cells, resolved = resolution(program, found.pieces)
            breaks.append(found.times)
            fine.append(cells)
            if not (found.complete and resolved):
                missed.append(number)
        sampled = np.unique(np.concatenate([np.empty(0), *(_ticks(*clock, begin, end) for clock in self.clocks)]))
        every = np.unique(np.concatenate([*breaks, sampled]))
        times = Times(begin, end, every, _shared(fine, begin, end), tuple(missed), sampled)
        self._known[:] = [times]
        return times

    def sampled_at(self, t: float) -> bool:
        """Do blocks sample at a time, s, or just before it?"""
        return any(
            abs(t - offset - period * np.round((t - offset) / period)) <= 1e-9 * period + 1e-11 * abs(t)
            for period, offset in self.clocks
        )


def _shared(fine: Sequence[np.ndarray], begin: float, end: float) -> np.ndarray:
    """Return the times of all signals, increasing; one for several that are nearly the same.

    Signals that end at nearly the same time (a table whose last knot is reached with no rate has it a rounding early)
    have nearly the same cells: a mark at each would make steps that are as short as the differences.
    """
    kept = np.array([begin, end])
    for times in fine:
        edges = np.unique(np.concatenate([[begin], times, [end]]))
        if len(edges) < 2 or not len(times):
            continue
        at = np.searchsorted(edges, times)
        gaps = np.diff(edges)
        cell = np.minimum(gaps[np.clip(at - 1, 0, len(gaps) - 1)], gaps[np.clip(at, 0, len(gaps) - 1)])
        after = np.clip(np.searchsorted(kept, times), 1, len(kept) - 1)
        off = np.minimum(np.abs(times - kept[after - 1]), np.abs(times - kept[after]))
        kept = np.unique(np.concatenate([kept, times[off > NEAR * cell]]))
    return kept[(kept > begin) & (kept < end)]


def _ticks(period: float, offset: float, begin: float, end: float) -> np.ndarray:
    """Return the times offset + k period around [begin, end], s."""
    return offset + period * np.arange(np.floor((begin - offset) / period), np.ceil((end - offset) / period) + 1.0)
