"""What is found once for an object, and kept as long as that lives."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import Any, TypeVar
from weakref import WeakKeyDictionary

__all__ = ["found_once"]

Found = TypeVar("Found")


def found_once(find: Callable[..., Found]) -> Callable[..., Found]:
    """Let a function of an object, and of further arguments that can be hashed, find each result once.

    The results are forgotten with the object, which nothing here keeps alive: `lru_cache` would keep the last systems
    of a program, with all their tables. A result must not refer to the object itself.
    """
    known: WeakKeyDictionary[Any, dict[tuple, Found]] = WeakKeyDictionary()

    @wraps(find)
    def once(of, *rest):
        results = known.setdefault(of, {})
        if rest not in results:
            results[rest] = find(of, *rest)
        return results[rest]

    return once
