"""Processes that ignore Ctrl-C, which a terminal sends to all of them: it is for their parent."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from contextlib import contextmanager

__all__ = ["ctrl_c_ignored"]


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
