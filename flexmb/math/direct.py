"""Calls of a kernel that come again and again with the same structures, without looking at their types each time.

To find the compiled function for its arguments, numba looks at every array of every structure: some 20 microseconds for
a program, its workspace and the variables of an integrator. That is nothing beside a run, and a lot beside one step.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
from numba import typeof

__all__ = ["direct"]

_KNOWN: WeakKeyDictionary[Any, dict[int, _Direct]] = WeakKeyDictionary()


class _Direct:
    """A kernel and the structures with which it was called last."""

    __slots__ = ("_found", "_kernel")

    def __init__(self, kernel: Any):
        self._kernel = kernel
        self._found: tuple[tuple[Any, ...], tuple[Any, ...], Callable[..., Any]] | None = None

    def __call__(self, *arguments: Any) -> Any:
        """Call the kernel; directly if the structures are the same as before, and the others of the same types.

        Arrays beside structures must be contiguous and writable, as numba has seen them first.
        """
        found = self._found  # one read: other threads may replace it
        if found is not None:
            kept, kinds, entry = found
            same = len(kept) == len(arguments)
            for one, before, kind in zip(arguments, kept, kinds):
                same = same and (one is before if kind is None else type(one) is kind and _alike(one, before))
            if same:
                return entry(*arguments)
        returned = self._kernel(*arguments)
        entry = self._kernel.get_overload(tuple(typeof(one) for one in arguments))
        kinds = tuple(None if _holds_arrays(one) else type(one) for one in arguments)
        self._found = tuple(_kept(one) for one in arguments), kinds, entry
        return returned


def _holds_arrays(one: Any) -> bool:
    """Is an argument a structure of arrays? One of numbers alone has the types that its class declares."""
    return isinstance(one, tuple) and any(isinstance(part, (tuple, np.ndarray)) for part in one)


def _kept(one: Any) -> Any:
    """Return an argument to compare others with: of an array its type alone, as the samples of a run may be large."""
    return np.empty((0,) * one.ndim, one.dtype) if isinstance(one, np.ndarray) else one


def _alike(one: Any, before: Any) -> bool:
    """Has an argument beside the structures the type of the one before to numba?"""
    if isinstance(one, np.ndarray):
        flags = one.flags
        return one.dtype is before.dtype and one.ndim == before.ndim and flags.c_contiguous and flags.writeable
    return True


def direct(owner: Any, kernel: Any) -> _Direct:
    """Return the kernel for calls with the structures of an owner, a compiled system; it is forgotten with it."""
    calls = _KNOWN.get(owner)
    if calls is None:
        calls = _KNOWN.setdefault(owner, {})
    call = calls.get(id(kernel))
    if call is None:
        call = calls.setdefault(id(kernel), _Direct(kernel))
    return call
