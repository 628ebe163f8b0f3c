"""Where an open file is now: while it is written its name may be removed, changed, or taken by another file."""

from __future__ import annotations

import os
from collections.abc import Iterator
from itertools import count
from pathlib import Path

__all__ = ["is_folder", "place_of", "places_for"]

_REMOVED = " (deleted)"
"""What Linux puts behind the former name of a removed file."""
_HIDDEN = (".nfs", ".fuse_hidden", ".smb")
"""What network file systems call a removed file that is still open: with its last closing it is gone."""


def place_of(descriptor: int, path: Path) -> Path | None:
    """Return where the open file is that was opened as `path`: there, or where it was moved; None if it was removed.

    Where the system does not tell where an open file is (Linux and macOS do), a moved file counts as removed. Windows
    does not let open files be moved or removed.
    """
    if os.name == "nt" or _is(descriptor, path):
        return path
    name = _named(descriptor)
    if name is None or name.endswith(_REMOVED) or os.path.basename(name).startswith(_HIDDEN):
        return None
    if name == os.path.realpath(path):  # a file system that gives numbers anew whenever it is asked
        return path
    return Path(name) if _is(descriptor, Path(name)) else None


def places_for(path: Path, home: os.stat_result) -> Iterator[Path]:
    """Yield where a removed file can be written again: at its path, or beside it where something else is now.

    home: what its folder was. A folder that has the name now and is another one is left alone: it may be that of
    another run.
    """
    folder = Path(os.path.abspath(path.parent))
    if os.path.lexists(folder) and not is_folder(folder, home):
        yield from (folder.with_name(f"{folder.name}-kept{number}") / path.name for number in _numbers())
    else:
        yield path
        yield from (path.with_name(f"{path.stem}-kept{number}{path.suffix}") for number in _numbers())


def _numbers() -> Iterator[str]:
    yield ""
    yield from map(str, count(2))


def _is(descriptor: int, path: Path) -> bool:
    """Has the open file this name?"""
    try:
        return os.path.samestat(os.fstat(descriptor), os.stat(path))
    except OSError:
        return False


def is_folder(folder: Path, home: os.stat_result) -> bool:
    """Does this name still belong to the folder that it belonged to when `home` was asked for?"""
    try:
        return os.path.samestat(home, os.stat(folder))
    except OSError:
        return False


def _named(descriptor: int) -> str | None:
    """Return the name that the system knows of an open file, if it tells."""
    try:
        return os.readlink(f"/proc/self/fd/{descriptor}")
    except OSError:
        pass
    try:
        import fcntl

        found = fcntl.fcntl(descriptor, fcntl.F_GETPATH, bytes(1024))  # type: ignore[attr-defined]  # macOS
    except (ImportError, AttributeError, OSError):
        return None
    return os.fsdecode(found.rstrip(b"\0"))
