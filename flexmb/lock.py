"""`Lock`: one process at a time writes a run, a run folder or a study; it ends with the process, however that ends.

The lock is one of the operating system on a small file beside what it is for, which says who holds it. Network file
systems know locks of byte ranges (POSIX). Where no locks exist, the process that the file names is searched, if it runs
on this machine.
"""

from __future__ import annotations

import contextlib
import errno
import json
import os
import socket
import stat
import time
from pathlib import Path

from flexmb.errors import DataFileError
from flexmb.whereabouts import place_of

__all__ = ["Lock", "holder", "locked_by_other"]

_NO_LOCKS = {getattr(errno, name) for name in ("ENOLCK", "ENOTSUP", "EOPNOTSUPP", "ENOSYS") if hasattr(errno, name)}
_PLACE = 1 << 30
"""Byte that is locked: far behind the text, which on Windows could not be read otherwise."""
_PATIENCE = 0.2
"""s: a reader that looks whether the lock is held holds it for a moment."""
_held: set[str] = set()
"""Those of this process: the operating system would give it the same lock twice."""


class Lock:
    """Holds the lock for writing `path`, a file or a folder, until `release`, the end of a ``with`` block or of the
    process.

    Parameters
    ----------
    path : path
    part : str
        How messages call it: "Run folder 'runs/flap'".

    Raises
    ------
    DataFileError
        Another process, or this one, is writing there.
    OSError
        The folder cannot be written.
    """

    def __init__(self, path: str | Path, part: str):
        self.file, self.key = _file(path), os.path.realpath(_file(path))
        if self.key in _held:
            raise _refused(part, "this process is writing it already")
        self._stream = self._taken(part)
        _held.add(self.key)

    def _taken(self, part: str):
        began = time.monotonic()
        while True:
            stream = open(self.file, "a+b", buffering=0, opener=_opened)  # noqa: SIM115 - closed by `release`
            try:
                if not _lock(stream.fileno()):
                    if time.monotonic() - began > _PATIENCE:
                        raise _refused(part, f"{_named(self.file)} is writing it")
                elif _same(stream.fileno(), self.file):
                    stream.truncate(0)
                    who = {
                        "pid": os.getpid(),
                        "host": socket.gethostname(),
                        "since": time.strftime("%Y-%m-%d %H:%M:%S"),
                    }
                    stream.write(json.dumps(who).encode())
                    return stream
            except BaseException:
                stream.close()
                raise
            stream.close()  # held, or removed by its holder between opening and locking: once more
            time.sleep(0.02)

    def __enter__(self) -> Lock:
        return self

    def __exit__(self, *exception) -> None:
        self.release()

    def release(self) -> None:
        """Give the lock back; a second time does nothing."""
        if self._stream.closed:
            return
        _held.discard(self.key)
        if os.name != "nt":  # removed while it is held: who opens it now looks whether it is still the same
            with contextlib.suppress(OSError):
                # the folder may have got another name, or be another
                place = place_of(self._stream.fileno(), self.file)
                if place is not None:
                    place.unlink(missing_ok=True)
        self._stream.close()
        if os.name == "nt":
            with contextlib.suppress(OSError):
                self.file.unlink(missing_ok=True)


def holder(path: str | Path) -> str:
    """Return who is writing `path` ("process 4711 on host 'a' (since ...)"), or an empty text."""
    file = _file(path)
    if os.path.realpath(file) in _held:
        return f"process {os.getpid()}, this one,"
    try:
        with open(file, "rb", opener=_opened) as stream:
            return "" if _lock(stream.fileno(), shared=True) else _named(file)
    except OSError:  # there is none, or one that cannot be looked at
        return ""


def locked_by_other(path: str | Path) -> bool:
    """Has another program locked a file as a whole, as HDF5 does (flock)?"""
    try:
        import fcntl

        with open(path, "rb", opener=_opened) as stream:
            fcntl.flock(stream.fileno(), fcntl.LOCK_SH | fcntl.LOCK_NB)
    except BlockingIOError:
        return True
    except (ImportError, OSError):  # no such locks here
        return False
    return False


def _file(path: str | Path) -> Path:
    path = Path(path)
    return path / ".lock" if path.is_dir() else path.with_name(f".{path.name}.lock")


def _opened(name: str, flags: int) -> int:
    """Open a file for `open`; OSError for a pipe, of which opening would wait for the other end."""
    descriptor = os.open(name, flags | getattr(os, "O_NONBLOCK", 0), 0o666)
    if stat.S_ISREG(os.fstat(descriptor).st_mode):
        return descriptor
    os.close(descriptor)
    raise OSError(errno.EINVAL, "it is no regular file", name)


def _same(descriptor: int, file: Path) -> bool:
    """Is the open file still the one that has the name?"""
    try:
        return os.path.samestat(os.fstat(descriptor), os.stat(file))
    except FileNotFoundError:
        return False


def _lock(descriptor: int, shared: bool = False) -> bool:
    """Lock an open file until it is closed; return if that was possible."""
    try:
        if os.name == "nt":
            import msvcrt

            os.lseek(descriptor, _PLACE, os.SEEK_SET)
            msvcrt.locking(descriptor, msvcrt.LK_NBLCK, 1)  # type: ignore[attr-defined]
        else:
            import fcntl

            fcntl.lockf(descriptor, (fcntl.LOCK_SH if shared else fcntl.LOCK_EX) | fcntl.LOCK_NB, 1, _PLACE)
    except OSError as error:
        if error.errno in _NO_LOCKS:
            return not _alive(_who(descriptor))
        return False
    return True


def _who(descriptor: int) -> dict:
    """Return what the holder has written."""
    try:
        os.lseek(descriptor, 0, os.SEEK_SET)
        found = json.loads(os.read(descriptor, 4096))
    except (OSError, ValueError):
        return {}
    return found if isinstance(found, dict) else {}


def _alive(who: dict) -> bool:
    """Is the holder a process of this machine that still runs?"""
    pid = who.get("pid")
    if who.get("host") != socket.gethostname() or not isinstance(pid, int) or pid <= 0 or os.name == "nt":
        return False
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    except OverflowError:  # no system has such a number
        return False
    except OSError:
        return True
    return True


def _named(file: Path) -> str:
    try:
        with open(file, "rb", opener=_opened) as stream:
            who = _who(stream.fileno())
    except OSError:
        who = {}
    if not who:
        return "another process"
    return f"process {who.get('pid')} on host '{who.get('host')}' (since {who.get('since')})"


def _refused(part: str, found: str) -> DataFileError:
    return DataFileError(
        part,
        found=found,
        expected="one writer at a time",
        remedy="Wait until it has ended, end it, or give another folder with --out",
    )
