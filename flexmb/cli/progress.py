"""A line of progress on the terminal: nothing where the output is a file or a pipe."""

from __future__ import annotations

import sys
import time
from collections import deque

from flexmb.errors import duration

__all__ = ["ProgressBar"]

WIDTH = 30
SECONDS = 0.1
"""Time between two updates: a terminal shows no more."""
LATEST, SETTLED = 10.0, 3.0
"""Seconds whose pace says what is left; after so many it is said, if it is as many."""


class ProgressBar:
    """Shows (stage, fraction) on one line of standard error, if that is a terminal.

    Examples
    --------
    ::

        with ProgressBar() as progress:
            progress("normal modes", 0.3)       # normal modes  [#########.....................]  30 %  12 s, 28 s left
    """

    def __init__(self, stream=None):
        self._stream = sys.stderr if stream is None else stream
        self._shown = bool(getattr(self._stream, "isatty", lambda: False)())
        self._start = self._last = time.monotonic()
        self._longest = 0
        self._marks: deque[tuple[float, float]] = deque()

    def __enter__(self) -> ProgressBar:
        return self

    def __exit__(self, *exception) -> None:
        if self._longest:
            self._stream.write("\r" + " " * self._longest + "\r")
            self._stream.flush()

    def __call__(self, stage: str, fraction: float) -> None:
        now = time.monotonic()
        if not self._shown or (now - self._last < SECONDS and fraction < 1.0 and self._longest):
            return
        self._last = now
        full = round(WIDTH * min(max(fraction, 0.0), 1.0))
        part = f"{100.0 * fraction:3.0f} %  {duration(now - self._start)}{self._left(now, fraction)}"
        line = f"{stage}  [{'#' * full}{'.' * (WIDTH - full)}] {part}"
        self._stream.write("\r" + line.ljust(self._longest))
        self._stream.flush()
        self._longest = max(self._longest, len(line))

    def _left(self, now: float, fraction: float) -> str:
        """Return what is left at the pace of the latest seconds, where that is worth a word."""
        if self._marks and fraction < self._marks[-1][1]:  # another stage
            self._marks.clear()
        self._marks.append((now, fraction))
        while now - self._marks[0][0] > LATEST and now - self._marks[1][0] > LATEST:
            self._marks.popleft()
        begun, before = self._marks[0]
        if now - begun < SETTLED or fraction >= 1.0:
            return ""
        gone = fraction - before
        left = (1.0 - fraction) / gone * (now - begun) if gone > 0.0 else float("inf")
        return f", {duration(left)} left" if left > SETTLED else ""
