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

from flexmb.math.structure_type import seen

__all__ = ["direct"]

_ENTRIES: dict[tuple[Any, tuple], Callable[..., Any]] = {}
"""Compiled functions by kernel and what its arguments' types depend on: variants have structures of their own, and the
same types."""
_KNOWN: WeakKeyDictionary[Any, dict[int, _Direct]] = WeakKeyDictionary()


class _Direct:
    """A kernel and the structures with which it was called last."""

    __slots__ = ("_found", "_kernel")

    def __init__(self, kernel: Any):
        self._kernel = kernel
        self._found: tuple[Callable[..., Any], tuple[type, ...], tuple[Any, ...], tuple[Any, ...]] | None = None

    def __call__(self, *arguments: Any) -> Any:
        """Call the kernel; directly if the structures are the same as before, and the others of the same types.

        Arrays beside structures must be contiguous and writable, as numba has seen them first.
        """
        found = self._found  # one read: other threads may replace it
        if found is not None:
            entry, kinds, structures, arrays = found
            if tuple(map(type, arguments)) == kinds and _alike(arguments, structures, arrays):
                return entry(*arguments)
        known = seen(arguments)
        same = None if known is None else _ENTRIES.get((self._kernel, known))
        if same is None:
            returned = self._kernel(*arguments)
            same = self._kernel.get_overload(tuple(typeof(one) for one in arguments))
            if known is not None:
                _ENTRIES[self._kernel, known] = same
        else:  # found for the system of another variant
            returned = same(*arguments)
        structures = tuple((k, one) for k, one in enumerate(arguments) if _holds_arrays(one))
        arrays = tuple((k, one.dtype, one.ndim) for k, one in enumerate(arguments) if isinstance(one, np.ndarray))
        self._found = same, tuple(map(type, arguments)), structures, arrays
        return returned


def _holds_arrays(one: Any) -> bool:
    """Is an argument a structure of arrays? One of numbers alone has the types that its class declares."""
    return isinstance(one, tuple) and any(isinstance(part, (tuple, np.ndarray)) for part in one)


def _alike(arguments: tuple[Any, ...], structures: tuple[Any, ...], arrays: tuple[Any, ...]) -> bool:
    """Are structures those of the call before, and arrays beside them of the same types to numba?"""
    for k, before in structures:
        if arguments[k] is not before:
            return False
    for k, dtype, ndim in arrays:
        one = arguments[k]
        if one.dtype is not dtype or one.ndim != ndim or not one.flags.carray:
            return False
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
