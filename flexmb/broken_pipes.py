"""A pipe whose reader has died is an error to handle, not the end of this process."""

from __future__ import annotations

import ctypes
import signal

__all__ = ["keep_broken_pipes_errors"]

_IGNORED = 1
"""What C calls SIG_IGN."""


def keep_broken_pipes_errors() -> None:
    """Ignore SIGPIPE again, if a library has undone that without Python's knowledge.

    Python ignores the signal from its start, so that writing to a broken pipe raises BrokenPipeError. Gmsh gives the
    signal back its default, the end of the process without a word: a study would die with the first of its workers.
    A handler that was set through Python stays. The C function works in every thread, `signal.signal` only in one.
    """
    number = getattr(signal, "SIGPIPE", None)  # not on Windows
    if number is None or signal.getsignal(number) is not signal.SIG_IGN:
        return
    ctypes.pythonapi.PyOS_setsig.restype = ctypes.c_void_p
    ctypes.pythonapi.PyOS_setsig(ctypes.c_int(number), ctypes.c_void_p(_IGNORED))
