"""Warnings of what is kept: whoever gets it a second time is told again what was said when it was made.

The module `warnings` alone cannot say what was given: its filters show a text once only.
"""

from __future__ import annotations

import os
import sys
import warnings
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path
from typing import NamedTuple

from flexmb.errors import ValidityWarning

__all__ = ["Told", "listening", "repeat", "speaking_of", "tell"]

PACKAGE = str(Path(__file__).parent) + os.sep


class Told(NamedTuple):
    """A warning that was given."""

    category: type[Warning]
    text: str


_whose: ContextVar[str] = ContextVar("whose", default="")
_heard: ContextVar[tuple[list[Told], ...]] = ContextVar("heard", default=())


def tell(text: str, category: type[Warning] = ValidityWarning) -> None:
    """Give a warning at the line of the user, and to all that listen."""
    whose = _whose.get()
    if whose and not text.startswith(whose):
        text = f"{whose}: {text}"
    depth, frame = 1, sys._getframe(1)
    while frame.f_back is not None and _inside(frame.f_code.co_filename):
        depth, frame = depth + 1, frame.f_back
    for told in _heard.get():
        told.append(Told(category, text))
    warnings.warn(text, category, stacklevel=depth + 1)


def repeat(told: Iterable[Told]) -> None:
    """Give warnings once more, each text once."""
    for category, text in dict.fromkeys(told):
        tell(text, category)


@contextmanager
def speaking_of(whose: str) -> Iterator[None]:
    """Put a name before all that is told inside the ``with`` block: "Part 'jib'"."""
    before = _whose.set(whose)
    try:
        yield
    finally:
        _whose.reset(before)


@contextmanager
def listening() -> Iterator[list[Told]]:
    """Give a list of what is told inside the ``with`` block, in this thread, whatever the filters show."""
    told: list[Told] = []
    before = _heard.set((*_heard.get(), told))
    try:
        yield told
    finally:
        _heard.reset(before)


def _inside(file: str) -> bool:
    """Is a line one of the package, of `contextlib`, or of the `__init__` of a dataclass?"""
    return file.startswith((PACKAGE, "<string>")) or file.endswith("contextlib.py")
