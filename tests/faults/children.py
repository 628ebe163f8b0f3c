"""Commands of flexmb in child processes that are starved, limited, interrupted or ended, and what became of them.

A child is a fork of a process that has imported and compiled everything already: hundreds of cases take minutes.
"""

from __future__ import annotations

import ctypes
import os
import signal
import tempfile
import time
import traceback
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from flexmb.cli import main
from flexmb.results import RunFile
from flexmb.results.journal import Journal
from flexmb.results.written import SAMPLES

__all__ = ["Ended", "begin", "ended", "shim"]

ROWS = 64
"""Samples that are written at a time: many writes in a short run."""


@dataclass(frozen=True)
class Ended:
    """How a child ended: its exit code, or the negative number of the signal; what it printed; how many samples it had
    written when a write came back for the last time; how long it took, s, and whether it had to be ended."""

    code: int
    text: str
    promised: int
    seconds: float
    hung: bool = False

    @property
    def traceback(self) -> bool:
        """Was there an error that is no message?"""
        return "Traceback (most recent call last)" in self.text

    @property
    def calls(self) -> int:
        """How many calls the shim has counted; 0 if the child did not come to its end."""
        return int(self.text.rpartition("calls: ")[2] or 0) if "\ncalls: " in self.text else 0

    @property
    def crashed(self) -> bool:
        """Did it end by a signal that nobody has sent?"""
        return self.code in (-signal.SIGSEGV, -signal.SIGABRT, -signal.SIGBUS, -signal.SIGFPE, -signal.SIGILL)


@dataclass
class Child:
    """A command that runs."""

    pid: int
    began: float
    text: str
    pipe: int


def shim():
    """Return the functions of `shim.c` if it has been preloaded, else None."""
    library = ctypes.CDLL(None)
    return library if hasattr(library, "faults_begin") else None


def begin(arguments: Sequence[str], before: Callable[[], None] = lambda: None, act: Callable[..., int] = main) -> Child:
    """Start ``flexmb``, or another function, with these arguments in a fork, after `before` has been called there."""
    handle, text = tempfile.mkstemp(suffix=".txt")
    reading, writing = os.pipe()
    pid = os.fork()
    if pid:
        os.close(handle)
        os.close(writing)
        return Child(pid, time.monotonic(), text, reading)
    code = 1
    try:
        os.dup2(handle, 1)
        os.dup2(handle, 2)
        os.close(reading)
        signal.signal(signal.SIGINT, signal.default_int_handler)
        _report_to(writing)
        before()
        code = act(list(arguments))
        library = shim()
        if library is not None:
            os.write(2, f"\ncalls: {library.faults_count()}\n".encode())
    except SystemExit as end:
        code = end.code if isinstance(end.code, int) else 2
    except BaseException:
        os.write(2, traceback.format_exc().encode())
    finally:
        ctypes.CDLL(None).exit(code)  # with what libraries do at the end, but without leaving the frames of the parent
    raise AssertionError


def _report_to(pipe: int) -> None:
    """Tell through a pipe of every write of samples that has come back."""
    add, opened = Journal.add, RunFile._open

    def told(journal, kind, says, numbers=()):
        add(journal, kind, says, numbers)
        if kind == SAMPLES:
            os.write(pipe, f"{says['n']}\n".encode())

    def small(run, path, rows, seconds, doing):
        opened(run, path, ROWS, seconds, doing)

    Journal.add, RunFile._open = told, small


def ended(child: Child, limit: float = 120.0) -> Ended:
    """Wait for a child, end it after `limit` seconds, and return what became of it."""
    hung, status = False, 0
    while True:
        pid, status = os.waitpid(child.pid, os.WNOHANG)
        if pid:
            break
        if time.monotonic() - child.began > limit and not hung:
            hung = True
            os.kill(child.pid, signal.SIGKILL)
        time.sleep(0.005)
    seconds = time.monotonic() - child.began
    with os.fdopen(child.pipe) as told:
        promised = sum(int(line) for line in told.read().split())
    text = Path(child.text).read_text(encoding="utf-8", errors="replace")
    os.unlink(child.text)
    return Ended(os.waitstatus_to_exitcode(status), text, promised, seconds, hung)
