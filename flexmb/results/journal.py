"""Records behind the end of an HDF5 file: samples of a running simulation, which a kill at any moment cannot harm.

What is in the file is never written again; records are added behind it, each with its length and its checksum. A kill
leaves whole records and perhaps the beginning of one, which readers leave out. HDF5 takes no notice of what follows its
own end, so the file is a sound HDF5 file at every moment.

A record is a head (mark, kind, length of the rest, checksums of the rest and of the head), the length of a text, the
text (JSON), and float64 numbers, all little-endian. Its text holds its number in the file, 0, 1, 2, ...: a record that
is missing from the middle, dropped or damaged, is noticed by the first whole one behind it. Records of files of earlier
states have no number; for them, only damage is noticed.
"""

from __future__ import annotations

import contextlib
import json
import os
import shutil
import struct
import time
import zlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import takewhile
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from flexmb import hdf5
from flexmb.files import write_all
from flexmb.whereabouts import place_of

__all__ = ["Journal", "Record", "records"]

_HEAD = struct.Struct("<6s2sQII")
_MARK = b"FLEXMB"
_LENGTH = struct.Struct("<I")
_PIECE = 1 << 20
"""Bytes that are read at a time to look at a checksum."""
_SERIAL = "serial"
"""What the number of a record is called in its text."""
_STRAY = 1000
"""Marks without a sound head that are passed by behind a damaged record: by chance there is not one."""
SYNC = 10.0
"""Seconds after which the disk is made to have what is written: what a power cut may cost. A kill costs nothing."""


@dataclass(frozen=True)
class Record:
    """One record: its kind (two letters), what its text says, and where its numbers are in the file.

    missing: how many records there should be between the one before and this one; negative if it should stand before
    """

    kind: str
    says: Mapping[str, Any]
    start: int
    end: int
    missing: int = 0

    def numbers(self, stream: BinaryIO, first: int = 0, count: int | None = None) -> np.ndarray:
        """Return `count` numbers from number `first` on, by default all."""
        start = self.start + 8 * first
        count = (self.end - start) // 8 if count is None else count
        if not 0 <= 8 * count <= self.end - start:
            raise ValueError(f"{count} numbers in {self.end - start} bytes")
        found = np.empty(count, "<f8")
        stream.seek(start)
        stream.readinto(found.data.cast("B"))  # type: ignore[attr-defined]
        return found.astype(float, copy=False)


def records(stream: BinaryIO, start: int) -> Iterator[Record]:
    """Yield the whole records of an open file from byte `start` on, also those behind damaged or `missing` ones."""
    size = os.fstat(stream.fileno()).st_size
    expected, stray, damaged = 0, 0, False
    while start + _HEAD.size + _LENGTH.size <= size and stray < _STRAY:
        stream.seek(start)
        head = stream.read(_HEAD.size)
        mark, kind, length, checksum, own = _HEAD.unpack(head)
        body, end = start + _HEAD.size, start + _HEAD.size + length
        if mark != _MARK or own != zlib.crc32(head[:-4]) or end > size:
            start, stray, damaged = _next_mark(stream, start + 1), stray + 1, True
            continue
        start = end  # also behind a wrong checksum: looked at from byte to byte, a hostile file would never end
        found = _text(stream, body, end) if _checksum(stream, body, length) == checksum else None
        if found is None:
            damaged = True
            continue
        says, first = found
        serial = says.get(_SERIAL, expected + damaged) if isinstance(says, dict) else expected
        yield Record(kind.decode("ascii"), says, first, end, serial - expected)
        expected, damaged = serial + 1, False


def _text(stream: BinaryIO, body: int, end: int) -> tuple[Any, int] | None:
    """Return what the text of a record says and where it ends; None if it does not fit."""
    if body + _LENGTH.size > end:
        return None
    stream.seek(body)
    (length,) = _LENGTH.unpack(stream.read(_LENGTH.size))
    first = body + _LENGTH.size + length
    return (json.loads(stream.read(length)), first) if first <= end else None


def _next_mark(stream: BinaryIO, start: int) -> int:
    """Return where the next mark is from byte `start` on, or the end of the file."""
    while True:
        stream.seek(start)
        piece = stream.read(_PIECE)
        at = piece.find(_MARK)
        if at >= 0 or len(piece) < _PIECE:
            return start + (at if at >= 0 else len(piece))
        start += len(piece) - len(_MARK) + 1


def _checksum(stream: BinaryIO, start: int, length: int) -> int:
    stream.seek(start)
    found = 0
    while length > 0:
        piece = stream.read(min(length, _PIECE))
        if not piece:
            return -1
        found, length = zlib.crc32(piece, found), length - len(piece)
    return found


class Journal:
    """Adds records to a file, behind its HDF5 part and the whole records that it has up to the first gap.

    Parameters
    ----------
    path : path
        A closed HDF5 file.
    """

    def __init__(self, path: str | Path):
        start = hdf5.end_of(path)
        self._stream = Path(path).open("r+b", buffering=0)  # noqa: SIM115 - open until `close`
        with Path(path).open("rb") as stream:
            whole = list(takewhile(lambda record: record.missing <= 0, records(stream, start)))
        self._end = max((record.end for record in whole), default=start)
        self._serial = len(whole)
        self._stream.truncate(self._end)  # the beginning of a record, or space that an older release had reserved
        self._synced = time.monotonic()

    def add(self, kind: str, says: Mapping[str, Any], numbers: Sequence[np.ndarray] = ()) -> None:
        """Write a record; once this returns, it survives the end of the process, and `SYNC` later a power cut.

        Raises
        ------
        OSError
            It cannot be written; what was there before stays.
        """
        text = json.dumps({**says, _SERIAL: self._serial}).encode()
        start = _HEAD.size + _LENGTH.size + len(text)
        whole = memoryview(bytearray(start + 8 * sum(x.size for x in numbers)))
        whole[_HEAD.size : start] = _LENGTH.pack(len(text)) + text
        for x in numbers:
            np.frombuffer(whole, "<f8", x.size, start)[:] = x.reshape(-1)
            start += 8 * x.size
        head = _HEAD.pack(_MARK, kind.encode(), len(whole) - _HEAD.size, zlib.crc32(whole[_HEAD.size :]), 0)[:-4]
        whole[: _HEAD.size] = head + zlib.crc32(head).to_bytes(4, "little")
        if time.monotonic() - self._synced > SYNC:
            os.fsync(self._stream.fileno())
            self._synced = time.monotonic()
        try:
            self._stream.seek(self._end)
            write_all(self._stream, whole)
        except OSError:
            with contextlib.suppress(OSError):
                self._stream.truncate(self._end)
            raise
        self._end += len(whole)
        self._serial += 1

    def place(self, path: Path) -> Path | None:
        """Return where the file is that was opened as `path`; None if it was removed."""
        return path if self._stream.closed else place_of(self._stream.fileno(), path)

    def copy_to(self, path: Path) -> None:
        """Write what the file holds, of which no name need be left, to a new file, and go on there.

        Raises
        ------
        OSError
            The file exists, or cannot be written: the old one stays open.
        """
        new = path.open("x+b", buffering=0)
        try:
            self._stream.seek(0)
            shutil.copyfileobj(self._stream, new, _PIECE)
        except BaseException:
            new.close()
            with contextlib.suppress(OSError):
                path.unlink(missing_ok=True)
            raise
        self._stream.close()
        self._stream = new

    def close(self) -> None:
        """Close the file."""
        self._stream.close()
