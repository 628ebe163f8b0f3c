"""What a text or header announces against what the file holds, for readers that believe it: looked at before them."""

from __future__ import annotations

import base64
import math
import re
import struct
import zipfile
from pathlib import Path

from flexmb.fem.foreign_memory import no_more_than

__all__ = ["require_counts", "require_unpacked"]

HEADER = 1_000_000
"""bytes, within which the header of a PLY file, and the dimensions of a grid in a VTK file, stand."""
GRID = 1_000_000
"""Cells of a regular grid in a file of any size: they need no bytes."""
PER_BYTE, FEW = 100, 100_000_000
"""Bytes of all unpacked arrays for a byte of an .npz file, and of any file."""
FEW_UNPACKED = 600_000_000
"""Bytes of all unpacked arrays of a VTU file of any size: what its reader may take."""
READING, PER_READ = 200_000_000, 20
"""Bytes that the reader of a compressed VTU file may take, of any size and for each byte of it and of what its headers
announce: up to six were seen. What unpacks to more than its headers say is not unpacked to its end."""
ARRAY = re.compile(rb"<DataArray\b[^>]{0,2000}>\s*")
DIMENSIONS = re.compile(rb"^DIMENSIONS[ \t]+(\d+)[ \t]+(\d+)[ \t]+(\d+)", re.MULTILINE | re.IGNORECASE)


def require_counts(path: Path) -> None:
    """Raise ValueError if a PLY, OFF, VTK or VTU file lacks its counts, or if they cannot be true or are far too large.

    meshio seeks the end of a PLY header, and the counts of OFF, for ever, makes all points of a regular grid, and
    unpacks arrays until its memory is used up.
    """
    suffix, size = path.suffix.lower(), path.stat().st_size
    if suffix == ".ply":
        with path.open("rb") as stream:
            head, ends, _ = stream.read(HEADER).partition(b"end_header")
        if not ends:
            raise ValueError("its header has no end")
        _require([int(line.split()[-1]) for line in head.splitlines() if line.startswith(b"element ")], size)
    elif suffix == ".off":
        with path.open(encoding="utf-8") as text:
            text.readline()
            sizes = next((line.split() for line in text if line.strip() and line.strip()[0] != "#"), [])
        if not sizes:
            raise ValueError("it has no line of counts")
        _require([int(count) for count in sizes[:2]], size)
    elif suffix == ".vtk":
        with path.open("rb") as stream:
            grid = DIMENSIONS.search(stream.read(HEADER))
        if grid is not None:
            cells = [max(int(count) - 1, 1) for count in grid.groups()]  # a byte for each of them may be all there is
            _require([math.prod(cells)], max(size, GRID))
    elif suffix == ".vtu" and (unpacked := _unpacked(path.read_bytes())) is not None:
        most = FEW_UNPACKED + PER_BYTE * size
        if unpacked > most:
            raise ValueError(f"its arrays unpack to {unpacked / 1e6:.4g} MB; at most {most / 1e6:.4g} MB are read")
        no_more_than(READING + PER_READ * (size + unpacked))


def _unpacked(text: bytes) -> int | None:
    """Return how many bytes the arrays of a compressed VTU file have, by the headers of their blocks; else None."""
    root = re.search(rb"<VTKFile\b[^>]*>", text[:HEADER])
    if root is None or b"compressor=" not in root.group():
        return None
    number = "Q" if b'"UInt64"' in root.group() else "I"
    order = ">" if b'"BigEndian"' in root.group() else "<"
    head = struct.Struct(order + 3 * number)  # number of blocks, bytes of one, bytes of the last
    appended = re.search(rb"<AppendedData\b[^>]*>\s*_", text)
    found = 0
    for array in ARRAY.finditer(text):
        tag, start, coded = array.group(), array.end(), True
        if b'"appended"' in tag:
            offset = re.search(rb'offset="(\d{1,18})"', tag)
            if appended is None or offset is None:
                continue
            start, coded = appended.end() + int(offset.group(1)), b'"raw"' not in appended.group()
        elif b'"binary"' not in tag:
            continue
        begin = text[start : start + (head.size * 4 // 3 if coded else head.size)]
        try:
            blocks, size, last = head.unpack(base64.b64decode(begin) if coded else begin)
        except (ValueError, struct.error):  # what its reader says of it
            continue
        found += max(blocks - 1, 0) * size + (last or size) if blocks else 0
    return found


def require_unpacked(path: Path) -> None:
    """Raise ValueError if the arrays of an .npz file are far larger than it."""
    with zipfile.ZipFile(path) as archive:
        unpacked = sum(file.file_size for file in archive.infolist())
    most = FEW + PER_BYTE * path.stat().st_size
    if unpacked > most:
        raise ValueError(f"its arrays unpack to {unpacked / 1e6:.4g} MB; at most {most / 1e6:.4g} MB are read")


def _require(counts: list[int], most: int) -> None:
    if any(count > most for count in counts):
        raise ValueError(f"it announces {max(counts)} points or cells, more than it holds")
