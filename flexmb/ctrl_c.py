"""Ctrl-C and a polite kill: what a process does with them; processes that it starts leave them to their parent."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from contextlib import contextmanager, suppress

__all__ = ["ctrl_c_ignored", "ignore_from_now_on", "let_termination_interrupt"]


@contextmanager
def ctrl_c_ignored() -> Iterator[None]:
    """Let processes that are started meanwhile ignore Ctrl-C."""
    try:
        before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    except ValueError:  # not the main thread
        yield
        return
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, signal.SIG_DFL if before is None else before)  # None: set by other than Python


def let_termination_interrupt() -> None:
    """Let a polite kill (SIGTERM) end the process like Ctrl-C: what was computed is written."""

    def interrupt(number, frame):
        raise KeyboardInterrupt

    interrupt.interrupts = True  # type: ignore[attr-defined] # a running simulation may wait for its next sample
    try:
        signal.signal(signal.SIGTERM, interrupt)
    except ValueError:  # not the main thread: the caller's own signals stay
        return


def ignore_from_now_on() -> None:
    """Let a process that is done end with its own exit code, whatever comes while Python takes it down."""
    with suppress(ValueError):
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, signal.SIG_IGN)
    # CPython notes an interruption that has left text given to `exec` (named tuples and data classes are made so), and
    # ends with that signal whatever becomes of it; the next such text takes the note back
    exec("")
