"""Ctrl-C, a polite kill and the limit of time of a run, noticed where nothing is half written."""

from __future__ import annotations

import signal
import time
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

import numpy as np

from flexmb.errors import caused_by_interrupt
from flexmb.results import Status

__all__ = ["GRACE", "Interruption", "look_within_step", "lost_interrupts"]

GRACE = 1.0
"""s of the clock that a step gets to end by itself after Ctrl-C, so that the state it reaches can be kept."""
_present: list[Interruption] = []
"""Those of the simulations that run, the innermost last."""


def look_within_step() -> None:
    """Raise KeyboardInterrupt if the user has asked for the end and the step under way does not come to its own.

    For steps in Python that may be long: a method of SciPy tries step sizes, or finds a matrix column by column, before
    it returns. The samples since the latest look are lost; all before it are kept.
    """
    if _present and _present[-1].overdue:
        raise KeyboardInterrupt


@contextmanager
def lost_interrupts() -> Iterator[None]:
    """Raise KeyboardInterrupt where Ctrl-C has struck in the first call of a compiled function.

    The function returns its result all the same, and Python makes a SystemError of the two.
    """
    try:
        yield
    except SystemError as error:
        if caused_by_interrupt(error):
            raise KeyboardInterrupt from error
        raise


class Interruption:
    """While a simulation runs, ends it between two blocks of samples instead of anywhere.

    An exception out of a signal handler can strike between two writes that belong together, and is lost in a
    destructor. So the handler only takes a note once `look` is called regularly; before that, and the second time, it
    raises at once: compiling or a step that hangs can be interrupted too.

    Only what would raise KeyboardInterrupt is taken over: Ctrl-C where Python's own handler is installed, and a kill
    where a handler turns it into one, as the command line does. Handlers of the caller's own stay.

    Parameters
    ----------
    limit : float, s, optional
        Clock time from the first look on after which it ends the simulation in the same way; what is compiled before
        does not count.
    """

    def __init__(self, limit: float | None = None):
        self._asked = self._looked = self._over = False
        self._limit, self._until = limit, np.inf
        self._before: dict[int, object] = {}
        self._asked_at = np.inf

    def __enter__(self) -> Interruption:
        try:
            self._before = {number: signal.signal(number, self._note) for number in _taken()}
        except ValueError:  # not the main thread: the caller's own handling stays
            self._before = {}
        _present.append(self)
        return self

    def __exit__(self, kind, error, trace) -> None:
        _present.remove(self)
        for number, handler in self._before.items():
            signal.signal(number, handler)  # type: ignore[arg-type]
        if isinstance(error, SystemError):
            with lost_interrupts():
                raise error

    def _note(self, number: int, frame: FrameType | None) -> None:
        at_once = self._asked or not self._looked
        self._asked, self._asked_at = True, min(self._asked_at, time.monotonic())
        if at_once:
            raise KeyboardInterrupt

    @property
    def asked(self) -> bool:
        """Has the user asked for the end, or was the time used up at the last look at the clock?"""
        return self._asked or self._over

    @property
    def overdue(self) -> bool:
        """Has the user asked for the end so long ago that a step should have ended?"""
        return self._asked and time.monotonic() - self._asked_at >= GRACE

    @property
    def in_grace(self) -> bool:
        """Has the user asked for the end just now, so that the run may still come to a better place to stop?"""
        return self._asked and not self.overdue

    def look_at_clock(self) -> None:
        """Find out whether the time is used up."""
        if self._limit is not None and not self._looked:
            self._until = time.monotonic() + self._limit
        self._over = time.monotonic() >= self._until

    def look(self) -> None:
        """Raise KeyboardInterrupt if the user has asked for the end, or the time is used up."""
        self._looked = True
        if self.asked:
            raise KeyboardInterrupt

    def look_now(self) -> None:
        """The same with a look at the clock, where there is no state worth keeping."""
        self.look_at_clock()
        self.look()

    def status(self, t: float) -> Status:
        """Return how a run has ended that it has stopped at t."""
        if self._over and not self._asked and self._limit is not None:
            return Status.limited(self._limit, t)
        return Status.interrupted(t)


def _taken() -> list[int]:
    """Return the numbers of the signals that would raise KeyboardInterrupt."""
    taken: list[int] = []
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        taken.append(signal.SIGINT)
    if getattr(signal.getsignal(signal.SIGTERM), "interrupts", False):
        taken.append(signal.SIGTERM)
    return taken
