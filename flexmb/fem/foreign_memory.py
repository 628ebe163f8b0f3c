"""What the reader of a foreign file may take of the memory: a small file may announce, or unpack to, any size."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

__all__ = ["memory_for", "no_more_than"]

PER_BYTE, FEW = 100, 600_000_000
"""Bytes of memory for a byte of the file, and for any file: no reader here takes more than some 20 for sound ones."""

_LOCK = threading.RLock()
_NESTED: list[tuple[int, int]] = []


@contextmanager
def memory_for(path: Path, per_byte: int = PER_BYTE) -> Iterator[None]:
    """Let the process take at most so much more address space inside the ``with`` block: MemoryError beyond.

    The limit counts for all threads, and where the system has one (Linux). A block inside another one keeps its limit.
    """
    before = _limited(path, per_byte)
    try:
        yield
    finally:
        _released(before)


def no_more_than(size: int) -> None:
    """Let the block that is open take only so many more bytes from now on.

    Nothing happens if several are open, or if this thread is not alone: the others may read, or compute, more.
    """
    if (taken := _taken()) is None:
        return
    import resource

    with _LOCK:
        # The system limits the process: what fits this file would fail the work of other threads that know nothing of
        # it. Beside them, the wider limit of the block remains.
        if len(_NESTED) == 1 and threading.active_count() == 1:
            now, hard = resource.getrlimit(resource.RLIMIT_AS)
            resource.setrlimit(resource.RLIMIT_AS, (min(now, taken + size), hard))


def _taken() -> int | None:
    """Return the bytes of address space of this process; None where there is no limit of them."""
    try:
        import resource

        return int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    except (ImportError, OSError):
        return None


def _limited(path: Path, per_byte: int) -> tuple[int, int] | None:
    try:
        size = path.stat().st_size
    except OSError:
        return None
    if (taken := _taken()) is None:
        return None
    import resource

    with _LOCK:
        before = resource.getrlimit(resource.RLIMIT_AS)
        if not _NESTED:
            most = taken + FEW + per_byte * size
            allowed = [bound for bound in before if bound != resource.RLIM_INFINITY]
            resource.setrlimit(resource.RLIMIT_AS, (min(most, *allowed) if allowed else most, before[1]))
        _NESTED.append(before)
    return before


def _released(before: tuple[int, int] | None) -> None:
    if before is None:
        return
    import resource

    with _LOCK:
        first = _NESTED[0]
        _NESTED.pop()
        if not _NESTED:
            resource.setrlimit(resource.RLIMIT_AS, first)
