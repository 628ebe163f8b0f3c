"""Who compiles a kernel: of several processes that need it, one does, and the others wait for its machine code.

Tests, sweeps and the processes that compile ahead share one cache. A process that begins to compile holds a lock beside
the file to be; the lock ends with the process, however that ends. Kernels do not call each other in circles, so
processes that wait for each other's kernels do not wait in circles either.
"""

from __future__ import annotations

import os
import time
from pathlib import Path

from numba.core import event

from flexmb.errors import DataFileError
from flexmb.lock import Lock, holder

__all__ = ["claim", "give_up", "is_claimed", "release"]

PATIENCE = 600.0
"""s: so long another process is waited for; nothing takes so long to compile but a process that stands still."""

_claims: dict[Path, tuple[int, Lock]] = {}


def claim(path: Path) -> bool:
    """Claim the compiling of a kernel, whose file is not there; return whether another process has just made it.

    That of a folder that cannot be written is not claimed: there nobody's machine code is kept.
    """
    if path in _claims:  # of this process, or of the one that it was forked from
        return False
    began = time.monotonic()
    while time.monotonic() - began < PATIENCE:
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            lock = Lock(path, "Kernel")
        except DataFileError:
            time.sleep(0.05)
            continue
        except OSError:
            return False
        if path.exists():
            lock.release()
            return True
        _claims[path] = os.getpid(), lock
        return False
    return False


def is_claimed(path: Path) -> bool:
    """Is this process, or another one, compiling a kernel?"""
    return path in _claims or bool(holder(path))


def release(path: Path) -> None:
    """Tell the others that the file is there."""
    process, lock = _claims.pop(path, (0, None))
    if lock is not None and process == os.getpid():
        lock.release()


def give_up() -> None:
    """Release all claims: nothing is being compiled any more, as after an error or Ctrl-C."""
    for path in list(_claims):
        release(path)


class _End(event.Listener):
    """Gives up what is left when the outermost kernel fails; else it is written now, and released after that."""

    depth = 0

    def on_start(self, event):
        self.depth += 1

    def on_end(self, event):
        self.depth -= 1
        if not self.depth and event._exc_details is not None:  # `is_failed` of numba 0.68 says the contrary
            give_up()


event.register("numba:compile", _End())
