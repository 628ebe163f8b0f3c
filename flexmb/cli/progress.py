"""A line of progress on the terminal: nothing where the output is a file or a pipe."""

from __future__ import annotations

import sys
import time

__all__ = ["ProgressBar"]

WIDTH = 30
SECONDS = 0.1
"""Time between two updates: a terminal shows no more."""


class ProgressBar:
    """Shows (stage, fraction) on one line of standard error, if that is a terminal.

    Examples
    --------
    ::

        with ProgressBar() as progress:
            progress("normal modes", 0.3)       # normal modes  [#########.....................]  30 %  12 s
    """

    def __init__(self, stream=None):
        self._stream = sys.stderr if stream is None else stream
        self._shown = bool(getattr(self._stream, "isatty", lambda: False)())
        self._start = self._last = time.monotonic()
        self._longest = 0

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
        line = f"{stage}  [{'#' * full}{'.' * (WIDTH - full)}] {100.0 * fraction:3.0f} %  {now - self._start:.0f} s"
        self._stream.write("\r" + line.ljust(self._longest))
        self._stream.flush()
        self._longest = max(self._longest, len(line))
