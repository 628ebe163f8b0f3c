"""A worker process of a study: computes one variant after another until its pipe is closed."""

from __future__ import annotations

import multiprocessing
import os
import pickle
import signal
import time
from collections.abc import Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from flexmb.ctrl_c import ctrl_c_ignored
from flexmb.math import SWITCH, watch_compilation

__all__ = ["Worker"]

ONE_THREAD = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")
"""Variants run beside each other: BLAS with threads of its own would make more threads than there are cores."""


class Worker:
    """A spawned process, and number and parameters of the variant it is working on.

    Parameters
    ----------
    task : bytes
        A pickled Task.
    """

    def __init__(self, task: bytes):
        spawning = multiprocessing.get_context("spawn")  # compiled code and BLAS threads do not survive a fork
        self.pipe, end = spawning.Pipe()
        self.process = spawning.Process(target=_serve, args=(end, task), name="flexmb study", daemon=True)
        with _environment():
            self.process.start()
        end.close()  # with the only other end inside the process, its death is the end of the pipe
        self.ready = self.compiling = False
        self.number: int | None = None
        self.parameters: Mapping[str, Any] = {}
        self.began = 0.0
        self.spent_before = 0.0

    def spent(self) -> float:
        """Return the processor time of the process, s; clock time where the system does not tell."""
        try:
            fields = Path(f"/proc/{self.process.pid}/stat").read_text(encoding="utf-8").rpartition(")")[2].split()
            return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")  # in user and in system mode
        except (OSError, ValueError, IndexError):
            return time.monotonic()

    def receive(self) -> tuple[str, Any] | None:
        """Return the next message, (kind, content), or None if the process has ended."""
        try:
            return self.pipe.recv()
        except (EOFError, OSError):
            self.process.join()
            return None

    def end(self) -> None:
        """End the process at once."""
        if self.process.is_alive():
            self.process.kill()
        self.process.join()
        self.pipe.close()

    def cause_of_death(self) -> str:
        """Return how the process ended, as text."""
        code = self.process.exitcode
        if code is None or code >= 0:
            return f"the worker process ended with code {code}"
        name = signal.Signals(-code).name if -code in set(signal.Signals) else f"signal {-code}"
        hint = {"SIGKILL": ", often because memory ran out", "SIGSEGV": ", a crash of compiled code"}.get(name, "")
        return f"the worker process was ended by {name}{hint}"


@contextmanager
def _environment():
    """What a new process inherits: one BLAS thread, nothing compiled ahead (the other workers have the cores), and
    Ctrl-C ignored, because the parent handles it."""
    wanted = {**dict.fromkeys(ONE_THREAD, "1"), SWITCH: "0"}
    before = {name: os.environ.get(name) for name in wanted}
    os.environ.update(wanted)
    try:
        with ctrl_c_ignored():
            yield
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value


def _serve(pipe: Any, pickled: bytes) -> None:
    """Compute what comes through the pipe."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    try:
        task = pickle.loads(pickled)
    except Exception as error:  # a module that is not found, a name that is gone: said once, not per variant
        pipe.send(("useless", f"{type(error).__name__}: {error}"))
        return
    watch_compilation(lambda: None, lambda begins: pipe.send(("compiling", begins)))
    pipe.send(("ready", None))
    while True:
        try:
            number, parameters = pipe.recv()
        except (EOFError, OSError):  # the parent is gone, or has no more work
            return
        pipe.send(("row", task.row(number, parameters)))
