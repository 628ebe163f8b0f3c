"""Who is told while parts are reduced: a line of progress, a count of a study."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Protocol

__all__ = ["Count", "Watcher", "tell_made", "tell_progress", "tell_taken", "tell_trouble", "watching"]


class Watcher(Protocol):
    """What is called as parts are reduced or found in the cache."""

    def progress(self, part: str, stage: str, fraction: float) -> None:
        """A reduction goes on: its stage, and the fraction 0..1 that is done."""

    def made(self, part: str, seconds: float) -> None:
        """A part was reduced."""

    def taken(self, part: str) -> None:
        """A part was found in the cache."""

    def trouble(self, part: str, text: str) -> None:
        """An entry of the cache was damaged, or could not be kept; the part itself is sound."""


class Count:
    """Counts how many parts were reduced and how many were found in the cache."""

    def __init__(self):
        self.reduced = self.reused = 0

    def progress(self, part: str, stage: str, fraction: float) -> None:
        """Not counted."""

    def made(self, part: str, seconds: float) -> None:
        """Count a reduction."""
        self.reduced += 1

    def taken(self, part: str) -> None:
        """Count a part that was there."""
        self.reused += 1

    def trouble(self, part: str, text: str) -> None:
        """Not counted."""


_watchers: ContextVar[tuple[Watcher, ...]] = ContextVar("watchers", default=())


@contextmanager
def watching(watcher: Watcher) -> Iterator[Watcher]:
    """Tell a watcher about all parts that are reduced inside the ``with`` block, in this thread."""
    token = _watchers.set((*_watchers.get(), watcher))
    try:
        yield watcher
    finally:
        _watchers.reset(token)


def tell_progress(part: str, stage: str, fraction: float) -> None:
    """Tell all watchers how far a reduction is."""
    for watcher in _watchers.get():
        watcher.progress(part, stage, fraction)


def tell_made(part: str, seconds: float) -> None:
    """Tell all watchers that a part was reduced."""
    for watcher in _watchers.get():
        watcher.made(part, seconds)


def tell_taken(part: str) -> None:
    """Tell all watchers that a part was found in the cache."""
    for watcher in _watchers.get():
        watcher.taken(part)


def tell_trouble(part: str, text: str) -> None:
    """Tell all watchers what is wrong with the cache."""
    for watcher in _watchers.get():
        watcher.trouble(part, text)
