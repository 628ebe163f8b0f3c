"""What the terminal shows while parts of finite elements are reduced for a model."""

from __future__ import annotations

import sys

from flexmb.cli.progress import ProgressBar

__all__ = ["ReductionLines"]


class ReductionLines:
    """A line of progress for each reduction, and a line on standard error when it is done."""

    def __init__(self):
        self._bar: ProgressBar | None = None

    def progress(self, part: str, stage: str, fraction: float) -> None:
        """Show how far it is."""
        if self._bar is None:
            self._bar = ProgressBar()
        self._bar(f"{part}: {stage}", fraction)

    def made(self, part: str, seconds: float) -> None:
        """Say that a part was reduced."""
        self._end()
        print(f"flexmb: part '{part}' reduced in {seconds:.1f} s", file=sys.stderr)

    def taken(self, part: str) -> None:
        """A part from the cache costs nothing and is not worth a line."""
        self._end()

    def trouble(self, part: str, text: str) -> None:
        """Say what is wrong with the cache."""
        self._end()
        print(f"flexmb: warning: part '{part}': {text}", file=sys.stderr)

    def _end(self) -> None:
        if self._bar is not None:
            self._bar.__exit__()
            self._bar = None
