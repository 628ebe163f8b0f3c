"""Compile kernels in other processes while this one compiles others: a first run uses more than one core.

numba compiles under one lock, so threads would not help. An analysis names the entry kernels that it will call later,
and large parts of them. Those whose machine code is not there are compiled in processes of their own: each takes the
next that nobody compiles, parts first, while this one compiles what it needs in the order of its calls. Whoever needs a
kernel that another process is compiling waits for it (`kernel_claims`). The processes end with the one that has started
them.
"""

from __future__ import annotations

import gc
import os
import subprocess
import sys
from collections.abc import Iterable
from importlib import import_module
from typing import Any

__all__ = ["SWITCH", "compile_ahead", "cores"]

SWITCH = "FLEXMB_AHEAD"
"""Environment variable; with 0, as in these processes and in the workers of a sweep, nothing is compiled ahead."""
MOST = 3
"""Processes that are started at most: kernels call each other, so many would wait for what a few compile."""
_started: list[subprocess.Popen] = []


def compile_ahead(
    kernels: Iterable[Any], parts: Iterable[Any] = (), on_demand: Iterable[Any] = (), rows: Iterable[Any] = ()
) -> int:
    """Compile entry kernels in other processes, as far as their machine code is missing and cores are free.

    Parameters
    ----------
    kernels : iterable of kernels
        Those that the analysis will call.
    parts : iterable of kernels
        Large ones that they call, each with declared types, in the order in which they are begun.
    on_demand : iterable of kernels on demand
        Those that the analysis will come to (`flexmb.math.kernel_on_demand`).
    rows : iterable of row kernels
        Those of the kinds of the model, in the order in which this process comes to them. The others begin with the
        last ones, after all else: so they meet this process in the middle.

    Returns
    -------
    int
        The number of processes that were started.
    """
    spare = min(cores() - 1, MOST)
    if os.environ.get(SWITCH) == "0" or spare < 1:
        return 0
    _started[:] = [process for process in _started if process.poll() is None]
    missing = [kernel for kernel in kernels if _is_missing(kernel)]
    if missing:  # where the entries are there, so are their parts
        missing = [kernel for kernel in parts if _is_missing(kernel)] + missing
    missing += [kernel for kernel in on_demand if _is_missing(kernel)]
    missing += [kernel for kernel in reversed(tuple(rows)) if _is_missing(kernel)]
    spare = min(spare - len(_started), len(missing))
    names = list(dict.fromkeys(map(_name, missing)))
    for part in range(spare):
        first = part * len(names) // spare  # each begins elsewhere, so that two do not reach for the same one
        ordered = [*names[first:], *names[:first]]
        command = [sys.executable, "-c", "from flexmb.math.ahead import main; main()", str(os.getpid()), *ordered]
        quiet = subprocess.DEVNULL
        environment = {**os.environ, SWITCH: "0", "FLEXMB_QUIET": "1"}
        try:
            _started.append(subprocess.Popen(command, stdin=quiet, stdout=quiet, stderr=quiet, env=environment))
        except OSError:  # no memory or no process left: this one compiles all
            return part
    return max(spare, 0)


def main() -> None:
    """Compile the kernels that the command line names, until the process that has asked for them is gone."""
    parent, *names = sys.argv[1:]
    gc.disable()  # nearly all that a compiler makes lives on, and this process ends soon
    for name in names:
        if os.name != "nt" and os.getppid() != int(parent):
            return
        module, _, function = name.partition(":")
        try:
            kernel = getattr(import_module(module), function)
        except (ImportError, AttributeError):  # of a script or a test that only its own process finds
            continue
        if not _is_missing(kernel):
            continue
        if hasattr(kernel, "is_being_compiled"):
            if not kernel.is_being_compiled():
                _ = kernel.compiled
        elif not kernel._cache.is_being_compiled(kernel.entry, kernel.targetctx):
            kernel.compile(kernel.entry)


def _name(kernel: Any) -> str:
    """Return where other processes find a kernel."""
    function = getattr(kernel, "py_func", None) or kernel.function
    return f"{function.__module__}:{function.__qualname__}"


def _is_missing(kernel: Any) -> bool:
    if hasattr(kernel, "is_missing"):  # of a kernel called through its address
        return kernel.is_missing()
    return not kernel.overloads and not kernel._cache.holds(kernel.entry, kernel.targetctx)


def cores() -> int:
    """Return the number of cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
