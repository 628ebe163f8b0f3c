"""The parity of a sealed HDF5 file, right behind its seal: damaged blocks are restored from it.

The file is cut into blocks; block i belongs to group i modulo the number of groups. The exclusive or of the blocks of a
group, and the CRC-32 of every block, are stored. A damaged block is found by its checksum, and is the exclusive or of
all others of its group: one block per group can be restored, so any one stretch as long as all groups (as RAID 4 does
it: Patterson, Gibson & Katz 1988). Where the file holds plain rows of numbers is noted, and what lies between them, the
structure, is there once more: damage that cannot be restored costs the rows in it only.
"""

from __future__ import annotations

import io
import json
import os
import struct
import zlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

__all__ = ["Mended", "MendedStream", "Rows", "described", "length_at", "mend", "rows_of", "write"]

_HEAD = struct.Struct("<8sQIIIIII")  # mark, length, block, groups, bytes of the notes, CRC of table, of notes, of these
_MARK = b"FLEXPRTY"
_FINE, _COARSE, _LARGE = 512, 4096, 1 << 20
"""Bytes of a block of small files, and of those of so many bytes."""
_LEAST, _MOST, _SHARE = 9, 16384, 32
"""Groups: at least a sector of 4096 bytes wherever it begins; at most 64 MB in memory; one for so many blocks."""
_PIECE = 1 << 20

_STRUCTURE = 1 << 24
"""Bytes between the rows of a file that are kept twice."""
Rows = tuple[str, int, int, int]
"""Dataset, its first byte in the file, its number of bytes, bytes of one row."""


@dataclass
class Mended:
    """What is known of a damaged file.

    end: where its parity ends; length: of what is sealed, bytes; block: bytes of a block
    blocks: restored blocks by their first byte
    damaged: stretches [first, last) of all bytes whose blocks were changed
    lost: stretches of those that cannot be restored
    rows: what lies where
    """

    end: int
    length: int
    block: int
    blocks: dict[int, bytes] = field(default_factory=dict)
    damaged: list[tuple[int, int]] = field(default_factory=list)
    lost: list[tuple[int, int]] = field(default_factory=list)
    rows: list[Rows] = field(default_factory=list)

    def lost_rows(self) -> dict[str, tuple[int, int]] | None:
        """Return the first and the last lost row by dataset; None if something else is lost as well."""
        found: dict[str, tuple[int, int]] = {}
        for first, last in self.lost:
            known = 0
            for name, start, size, row in self.rows:
                begin, end = max(first, start), min(last, start + size)
                if begin < end:
                    known += end - begin
                    a, b = (begin - start) // row, (end - 1 - start) // row
                    old = found.get(name, (a, b))
                    found[name] = (min(a, old[0]), max(b, old[1]))
            if known < last - first:
                return None
        return found


def write(stream: BinaryIO, length: int, rows: list[Rows]) -> None:
    """Write the parity of the first `length` bytes of an open file at its present place."""
    place = stream.tell()
    block = _COARSE if length >= _LARGE else _FINE
    groups = min(_MOST, max(_LEAST, -(-length // (block * _SHARE))))
    sums, checks = np.zeros((groups, block), np.uint8), []
    for strip in _strips(stream, length, block, groups):
        sums[: len(strip)] ^= strip
        checks += [zlib.crc32(one.data) for one in strip]
    table = np.array([*checks, *(zlib.crc32(one.data) for one in sums)], "<u4").tobytes()
    text = json.dumps(rows).encode()
    notes = len(text).to_bytes(4, "little") + text + _structure(stream, length, rows)
    head = _HEAD.pack(_MARK, length, block, groups, len(notes), zlib.crc32(table), zlib.crc32(notes), 0)[:-4]
    stream.seek(place)
    stream.write(head + zlib.crc32(head).to_bytes(4, "little") + table + notes)
    stream.write(sums.tobytes())


def length_at(stream: BinaryIO, place: int) -> int:
    """Return how many bytes of parity begin at a place; 0 if none do."""
    head = _head_at(stream, place)
    return 0 if head is None else _sizes(head)[-1]


def mend(path: str | Path) -> Mended | None:
    """Return what of a damaged file can be restored; None if it has no sound parity, or is no regular file."""
    if not Path(path).is_file():  # opening a pipe would wait for its other end
        return None
    with Path(path).open("rb") as stream:
        found = _search(stream)
        if found is None:
            return None
        place, head = found
        length, block, groups, notes_size, table_check, notes_check = head
        _, table_size, whole = _sizes(head)
        stream.seek(place + _HEAD.size)
        table, notes = stream.read(table_size), stream.read(notes_size)
        if zlib.crc32(table) != table_check:
            return None
        checks = np.frombuffer(table, "<u4")
        mended = Mended(place + whole, length, block)
        structure = _read_notes(mended, notes) if zlib.crc32(notes) == notes_check else b""
        strips = _strips(stream, length, block, groups)
        bad = [k for k, one in enumerate(one for strip in strips for one in strip) if zlib.crc32(one.data) != checks[k]]
        sums = place + _HEAD.size + table_size + notes_size
        of_group = np.bincount(np.array(bad, int) % groups, minlength=groups)
        for k in bad:
            first, last = k * block, min((k + 1) * block, length)
            restored = _restored(stream, k, head, sums, checks) if of_group[k % groups] == 1 else None
            if restored is None:
                restored = _with_structure(stream, mended, first, last, structure)
            if restored is not None:
                mended.blocks[first] = restored[: last - first]
            _extend(mended.damaged, first, last)
        return mended


def _gaps(length: int, rows: list[Rows]) -> Iterator[tuple[int, int]]:
    """Yield the stretches of a file between its rows: what HDF5 notes about them."""
    end = 0
    for _, start, size, _ in sorted(rows, key=lambda one: one[1]):
        if start > end:
            yield end, start
        end = max(end, start + size)
    if length > end:
        yield end, length


def _structure(stream: BinaryIO, length: int, rows: list[Rows]) -> bytes:
    """Return a copy of what lies between the rows; nothing if that is much."""
    gaps = list(_gaps(length, rows))
    if sum(last - first for first, last in gaps) > _STRUCTURE:
        return b""
    return b"".join(_block(stream, first, last - first).tobytes() for first, last in gaps)


def _read_notes(mended: Mended, notes: bytes) -> bytes:
    """Take the rows from the notes of a parity, and return the copy of what lies between them."""
    size = int.from_bytes(notes[:4], "little")
    try:
        rows = [(str(name), int(a), int(b), max(1, int(c))) for name, a, b, c in json.loads(notes[4 : 4 + size])]
    except (ValueError, TypeError, RecursionError, OverflowError):
        return b""
    mended.rows, structure = rows, notes[4 + size :]
    fits = len(structure) == sum(last - first for first, last in _gaps(mended.length, rows))
    return structure if fits else b""


def _with_structure(stream: BinaryIO, mended: Mended, first: int, last: int, structure: bytes) -> bytes | None:
    """Return a block that is lost with what lies between its rows as it was; note what of it stays lost. None if all of
    it does: most of a large file may be lost, and is not held in memory.
    """
    found, at, known = _block(stream, first, last - first), 0, False
    left = first
    for start, stop in _gaps(mended.length, mended.rows) if structure else ():
        a, b = max(start, first), min(stop, last)
        if a < b:
            found[a - first : b - first] = np.frombuffer(structure, np.uint8, b - a, at + a - start)
            if left < a:
                _extend(mended.lost, left, a)
            left, known = b, True
        at += stop - start
    if left < last:
        _extend(mended.lost, left, last)
    return found.tobytes() if known else None


def _restored(stream: BinaryIO, k: int, head: tuple[int, ...], sums: int, checks: np.ndarray) -> bytes | None:
    """Return block k from the others of its group; None if their exclusive or is damaged too."""
    length, block, groups, *_ = head
    count = -(-length // block)
    total = _block(stream, sums + (k % groups) * block, block)
    if zlib.crc32(total.data) != checks[count + k % groups]:
        return None
    for other in range(k % groups, count, groups):
        if other != k:
            total ^= _block(stream, other * block, min(block, length - other * block), block)
    return total.tobytes() if zlib.crc32(total.data) == checks[k] else None


def _block(stream: BinaryIO, place: int, size: int, block: int = 0) -> np.ndarray:
    found = np.zeros(max(size, block), np.uint8)
    stream.seek(place)
    stream.readinto(found[:size].data)  # type: ignore[attr-defined]
    return found


def _strips(stream: BinaryIO, length: int, block: int, groups: int) -> Iterator[np.ndarray]:
    """Yield the blocks of a file as matrices with at most one row per group; what follows its end counts as zeros."""
    for first in range(0, length, block * groups):
        size = min(block * groups, length - first)
        yield _block(stream, first, size, -(-size // block) * block).reshape(-1, block)


def _extend(stretches: list[tuple[int, int]], first: int, last: int) -> None:
    if stretches and stretches[-1][1] == first:
        first = stretches.pop()[0]
    stretches.append((first, last))


def _sizes(head: tuple[int, ...]) -> tuple[int, int, int]:
    """Return the number of blocks, the bytes of the table, and those of everything."""
    length, block, groups, notes, *_ = head
    count = -(-length // block)
    table = 4 * (count + groups)
    return count, table, _HEAD.size + table + notes + groups * block


def _head_at(stream: BinaryIO, place: int) -> tuple[int, ...] | None:
    """Return length, block, groups, bytes of the notes, their checksums; None if no sound head is at the place."""
    size = os.fstat(stream.fileno()).st_size
    if not 0 < place <= size - _HEAD.size:
        return None
    stream.seek(place)
    text = stream.read(_HEAD.size)
    mark, *numbers, own = _HEAD.unpack(text)
    if mark != _MARK or own != zlib.crc32(text[:-4]):
        return None
    length, block, groups, *_ = numbers
    sound = block in (_FINE, _COARSE) and 0 < groups <= _MOST and 0 < length <= place
    return tuple(numbers) if sound and place + _sizes(tuple(numbers))[-1] <= size else None


def _search(stream: BinaryIO) -> tuple[int, tuple[int, ...]] | None:
    """Return place and head of the parity: the file itself may no longer know its own end."""
    start = 0
    while True:
        stream.seek(start)
        piece = stream.read(_PIECE)
        at = piece.find(_MARK)
        while at >= 0:
            head = _head_at(stream, start + at)
            if head is not None:
                return start + at, head
            at = piece.find(_MARK, at + 1)
        if len(piece) < _PIECE:
            return None
        start += len(piece) - len(_MARK) + 1


class MendedStream(io.RawIOBase):
    """A damaged file as it was written, for reading: its restored blocks take the place of the damaged ones."""

    def __init__(self, path: str | Path, mended: Mended):
        super().__init__()
        self._file, self._mended, self._place = Path(path).open("rb"), mended, 0  # noqa: SIM115 - open until `close`

    def __repr__(self):
        return str(self._file.name)  # h5py calls the file so

    def readable(self) -> bool:
        """It can be read."""
        return True

    def seekable(self) -> bool:
        """It has places."""
        return True

    def seek(self, offset: int, whence: int = os.SEEK_SET) -> int:
        """Go to a place."""
        self._place = offset + (0, self._place, self._mended.length)[whence]
        return self._place

    def tell(self) -> int:
        """Return the present place."""
        return self._place

    def readinto(self, buffer: Any) -> int:
        """Read what was written at the present place."""
        whole = memoryview(buffer).cast("B")
        size = max(0, min(len(whole), self._mended.length - self._place))
        self._file.seek(self._place)
        self._file.readinto(whole[:size])
        block = self._mended.block
        for start in range(self._place // block * block, self._place + size, block):
            data = self._mended.blocks.get(start, b"")
            first, last = max(start, self._place), min(start + len(data), self._place + size)
            if first < last:
                whole[first - self._place : last - self._place] = data[first - start : last - start]
        self._place += size
        return size

    def close(self) -> None:
        """Close the file."""
        self._file.close()
        super().close()


def rows_of(file: Any) -> list[Rows]:
    """Return the datasets of an open HDF5 file whose numbers lie in one piece, and where."""
    found: list[Rows] = []

    def note(name: str, thing: Any) -> None:
        offset = getattr(thing, "id", None) is not None and hasattr(thing.id, "get_offset") and thing.id.get_offset()
        if offset and thing.ndim and thing.size:
            found.append((name, int(offset), int(thing.nbytes), int(thing.nbytes // len(thing))))

    file.visititems(note)
    return found


def described(lost: Mapping[str, tuple[int, int]]) -> str:
    """Return lost rows as words: "phases/0/q rows 3 to 17"."""
    return ", ".join(f"{name} rows {first} to {last}" for name, (first, last) in sorted(lost.items()))
