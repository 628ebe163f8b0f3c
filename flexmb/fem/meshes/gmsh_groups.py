"""Physical groups of a Gmsh file: all names by dimension, all groups of every entity.

meshio keeps one dimension of a name that several dimensions share, and of the groups of an entity without names only
the first. Both are read here from the sections $PhysicalNames and $Entities (Gmsh reference manual, "MSH file format",
version 4.1).
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

__all__ = ["entity_groups", "physical_names"]

NAME = re.compile(rb'^\s*(\d+)\s+(-?\d+)\s+"(.*)"\s*$')


def physical_names(path: Path) -> dict[tuple[int, int], str]:
    """Return the name of every named group by (dimension, number)."""
    text = _section(path.read_bytes(), b"PhysicalNames")
    found = (NAME.match(line) for line in text.splitlines())
    return {(int(m[1]), int(m[2])): m[3].decode("utf-8", "replace") for m in found if m}


def entity_groups(path: Path) -> dict[tuple[int, int], list[int]] | None:
    """Return the numbers of all groups of every entity by (dimension, entity); None before version 4.1."""
    data = path.read_bytes()
    words = _section(data, b"MeshFormat").split(maxsplit=3)
    if not words or words[0] != b"4.1":
        return None
    section = _section(data, b"Entities")
    if words[1] == b"0":
        return _groups(_Words(section))
    return _groups(_Bytes(section, int(words[2])))


def _section(data: bytes, name: bytes) -> bytes:
    """Return what stands between $name and $Endname, empty if there is no such section."""
    begin = data.find(b"$" + name)
    if begin < 0:
        return b""
    begin = data.index(b"\n", begin) + 1
    end = data.find(b"$End" + name, begin)
    return data[begin:end] if end >= 0 else data[begin:]


class _Words:
    """Numbers of an ASCII section, one after another."""

    def __init__(self, text: bytes):
        self.words = text.split()
        self.at = 0

    def skip_reals(self, count: int) -> None:
        self.at += count

    def integers(self, count: int) -> list[int]:
        found = self.words[self.at : self.at + count]
        if len(found) < count:
            raise ValueError("the section $Entities ends too early")
        self.at += count
        return [int(word) for word in found]

    sizes = integers


class _Bytes:
    """Numbers of a binary section: reals of 8 bytes, integers of 4, sizes as the header says."""

    def __init__(self, data: bytes, size: int):
        self.data, self.size, self.at = data, size, 0

    def skip_reals(self, count: int) -> None:
        self.at += 8 * count

    def integers(self, count: int) -> list[int]:
        return self._numbers("i4", count)

    def sizes(self, count: int) -> list[int]:
        return self._numbers(f"u{self.size}", count)

    def _numbers(self, kind: str, count: int) -> list[int]:
        kind_of = np.dtype(kind)
        end = self.at + kind_of.itemsize * count
        if end > len(self.data):
            raise ValueError("the section $Entities ends too early")
        found = np.frombuffer(self.data, kind_of, count, self.at)
        self.at = end
        return [int(number) for number in found]


def _groups(numbers: _Words | _Bytes) -> dict[tuple[int, int], list[int]]:
    found: dict[tuple[int, int], list[int]] = {}
    for dimension, count in enumerate(numbers.sizes(4)):
        for _ in range(count):
            (entity,) = numbers.integers(1)
            numbers.skip_reals(3 if dimension == 0 else 6)  # its box
            (n,) = numbers.sizes(1)
            found[dimension, entity] = [abs(tag) for tag in numbers.integers(n)]  # negative: turned round
            if dimension:
                (n,) = numbers.sizes(1)
                numbers.integers(n)  # its boundary
    return found
