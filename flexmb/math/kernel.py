"""`kernel` and `inner_kernel`: the way to compile a function in flexmb."""

from __future__ import annotations

import os
import sys

from numba import njit

__all__ = ["inner_kernel", "kernel", "watch_sources"]


def kernel(function):
    """Compile with numba; the machine code is cached on disk, so only the first run on a machine compiles.

    ``error_model="numpy"`` makes a division by zero give inf or nan as numpy does (found by the residual checks),
    instead of a branch in every division. ``fastmath`` stays off: the order of operations is part of the result.
    The second entry for callers in C is left out, as nobody uses it and every kernel would pay for compiling it;
    kernels that are called through their address are `PointerKernel`.
    """
    return _compiled(function, called_from_python=True)


def inner_kernel(function):
    """Compile a function that only kernels of its own file call.

    It gets no entry for Python: unpacking the tables of a system there takes longer to compile than many a function. A
    call from Python would end the process; a test of the architecture sees to it that there is none.
    """
    return _compiled(function, called_from_python=False)


def _compiled(function, called_from_python: bool):
    compiled = njit(
        cache=True, error_model="numpy", nogil=True, no_cfunc_wrapper=True, no_cpython_wrapper=not called_from_python
    )(function)
    watch_sources(compiled._cache, function)
    return compiled


def watch_sources(cache, function) -> None:
    """Let the cached machine code of `function` expire when any file changes from which it calls a kernel.

    numba itself looks only at the function's own file, although the code of called kernels is compiled into it.
    """
    file = getattr(cache, "_cache_file", None)
    if file is not None and hasattr(file, "_source_stamp"):
        file._source_stamp = tuple(sorted(_stamps(function.__module__)))


_known: dict[str, frozenset] = {}


def _stamps(module: str) -> frozenset:
    """Return (file name, time, size) of a module and of all modules whose kernels it calls."""
    names, waiting = set(), [module]
    while waiting:
        name = waiting.pop()
        if name in names or name not in sys.modules:
            continue
        names.add(name)
        for value in list(vars(sys.modules[name]).values()):
            called = getattr(value, "py_func", None)
            if called is not None:
                waiting.append(called.__module__)
    found: set = set()
    for name in names:
        if name not in _known:
            path = getattr(sys.modules[name], "__file__", None)
            status = os.stat(path) if path else None
            _known[name] = frozenset() if status is None else frozenset({(name, status.st_mtime, status.st_size)})
        found |= _known[name]
    return frozenset(found)
