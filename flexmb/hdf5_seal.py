"""The seal of an HDF5 file: its length and checksum, right behind its end, where HDF5 takes no notice of it.

A file with a right seal is what was written. One with a wrong seal was changed: nobody can say which of its numbers are
still right. One without a seal is older than the seal, of another program, or cut off: it is read in a child process
first (`flexmb.hdf5_probe`).
"""

from __future__ import annotations

import os
import struct
import subprocess
import sys
import zlib
from pathlib import Path
from typing import BinaryIO

from flexmb import hdf5_parity

__all__ = ["BROKEN", "NONE", "WHOLE", "end_of", "probe", "seal", "state_of"]

_SEAL = struct.Struct("<8sQII")  # mark, length of what is sealed, its CRC-32, CRC-32 of the three
_MARK = b"FLEXSEAL"
_PIECE = 1 << 20
WHOLE, BROKEN, NONE = "whole", "broken", "none"
"""States of a seal."""
PATIENCE, PACE = 30.0, 4e6
"""Seconds that a probe may take, and bytes of the file for each further second."""
MEMORY = 2_000_000_000
"""Bytes that a probe may take, with its libraries."""


def seal(path: str | Path, rows: list[hdf5_parity.Rows] | None = None) -> None:
    """Put the seal behind the end of a closed HDF5 file, and the parity behind that; `rows` is what lies where."""
    with Path(path).open("r+b") as stream:
        end = _end(stream)
        head = _MARK + end.to_bytes(8, "little") + _checksum(stream, end).to_bytes(4, "little")
        stream.seek(end)
        stream.write(head + zlib.crc32(head).to_bytes(4, "little"))
        hdf5_parity.write(stream, end, rows or [])
        stream.truncate()


def end_of(path: str | Path) -> int:
    """Return where a closed HDF5 file ends with its seal and parity, bytes: what follows are records.

    Of a damaged file, which may no longer know its own end, it is where its parity ends.
    """
    with Path(path).open("rb") as stream:
        end = _end(stream)
        if _seal_at(stream, end):
            return end + _SEAL.size + hdf5_parity.length_at(stream, end + _SEAL.size)
    mended = hdf5_parity.mend(path)
    return end if mended is None else mended.end


def state_of(path: str | Path) -> str:
    """Return what the seal says: WHOLE, BROKEN or NONE."""
    with Path(path).open("rb") as stream:
        size = os.fstat(stream.fileno()).st_size
        for end in (_end(stream), size - _SEAL.size):  # the end that the file itself names may be what is damaged
            found = _seal_at(stream, end)
            if found:
                whole = found == (end, _checksum(stream, end)) and end == _end(stream)
                return WHOLE if whole else BROKEN
        if (end := _end(stream)) < size:
            stream.seek(end)
            if stream.read(_SEAL.size) == bytes(_SEAL.size):  # a copy that broke off, filled up with zeros
                return BROKEN
    mended = hdf5_parity.mend(path)
    return BROKEN if mended is not None and mended.damaged else NONE


def probe(path: str | Path) -> str:
    """Read a file in a child process; return "" if that went well, else what happened."""
    if not sys.executable:
        return ""
    script = Path(__file__).with_name("hdf5_probe.py")
    limit = PATIENCE + os.path.getsize(path) / PACE
    try:
        child = subprocess.run(
            [sys.executable, "-I", str(script), str(path), str(MEMORY)],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            timeout=limit,
            check=False,
        )
    except subprocess.TimeoutExpired:
        return f"the HDF5 library does not come to its end within {limit:.0f} s"
    except OSError:  # no process can be started: reading is all that is left
        return ""
    if child.returncode == 0:
        return ""
    return child.stdout.decode(errors="replace").strip() or "the HDF5 library cannot read it without crashing"


def _end(stream: BinaryIO) -> int:
    """Return where the HDF5 file ends by its superblock."""
    stream.seek(0)
    head = stream.read(48)
    start = 40 if head[8:9] < b"\x02" else 28  # by the version of the superblock
    return int.from_bytes(head[start : start + 8], "little")


def _seal_at(stream: BinaryIO, place: int) -> tuple[int, int] | None:
    """Return length and checksum of the seal at a place, or None if there is none."""
    if not 0 < place <= os.fstat(stream.fileno()).st_size - _SEAL.size:
        return None
    stream.seek(place)
    text = stream.read(_SEAL.size)
    mark, length, checksum, own = _SEAL.unpack(text)
    return (length, checksum) if mark == _MARK and own == zlib.crc32(text[:-4]) else None


def _checksum(stream: BinaryIO, end: int) -> int:
    stream.seek(0)
    found = 0
    while end > 0:
        piece = stream.read(min(end, _PIECE))
        if not piece:
            return -1
        found, end = zlib.crc32(piece, found), end - len(piece)
    return found
