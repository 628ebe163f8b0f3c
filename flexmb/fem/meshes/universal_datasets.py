"""Universal files (.unv, .uff) cut into their datasets, and the records of nodes, elements, groups and units.

A dataset stands between two lines of -1 in columns 5 and 6; its first line is its number. The descriptions of the
datasets are public (Structural Dynamics Research Lab, University of Cincinnati). Numbers stand in fields of fixed
width, which many programs do not keep: a line is split at blanks, and by the widths only where fields touch.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path

import numpy as np

from flexmb.errors import MeshError

__all__ = ["BEAMS", "Group", "UniversalFile", "damaged", "datasets", "universal_file"]

POSITIONS = (15, 781, 2411)
"""Datasets of nodes; the coordinates of 15 and 781 refer to a system that each node names."""
GROUPS = (2435, 2452, 2467, 2477)
"""Datasets of groups with four numbers per member."""
OLD_GROUPS = (752, 2417, 2429, 2430, 2432)
BEAMS = (11, 21, 22, 23, 24)
"""Descriptors of elements with a line for orientation and sections."""
PIPES = (31, 32)
BINARY_END = re.compile(rb" {4}-1[ \t]*\r?$", re.MULTILINE)
"""Behind bytes there may be no end of a line."""
DELIMITER = re.compile(rb"^ {4}-1[ \t]*\r?$", re.MULTILINE)


@dataclass(frozen=True)
class Group:
    """Name of a group, and the numbers of its nodes and elements; `others` counts members of other kinds."""

    name: str
    nodes: np.ndarray
    elements: np.ndarray
    others: int


@dataclass(kw_only=True)
class UniversalFile:
    """What a universal file says of a mesh, with the numbers of the file.

    ``elements[descriptor, number of nodes]`` is a list of (label, property, *nodes); `unit` is in metres.
    """

    labels: list[int] = field(default_factory=list)
    points: list[list[float]] = field(default_factory=list)
    elements: dict[tuple[int, int], list[list[int]]] = field(default_factory=dict)
    groups: list[Group] = field(default_factory=list)
    unit: float | None = None
    skipped: set[int] = field(default_factory=set)


def universal_file(path: Path) -> UniversalFile:
    """Read the datasets of a mesh; the numbers of the others are in ``skipped``."""
    found, part = UniversalFile(), f"Mesh file '{path}'"
    for number, lines in datasets(path, part):
        if number in POSITIONS:
            _nodes(part, number, lines, found)
        elif number == 2412:
            _elements(part, lines, found)
        elif number in GROUPS:
            _groups(part, number, lines, found)
        elif number == 164:
            _unit(part, lines, found)
        else:
            found.skipped.add(number)
    return found


def datasets(path: Path, part: str):
    """Yield the number and the lines of every dataset; binary ones (58b) count their own bytes."""
    data, place = path.read_bytes(), 0
    while begin := DELIMITER.search(data, place):
        head_end = data.find(b"\n", begin.end() + 1) % (len(data) + 1)
        head = data[begin.end() : head_end].strip()
        word = re.match(rb"(\d{1,6})(b?)", head)
        if word is None:
            raise damaged(part, f"a dataset that begins with '{head[:40].decode('ascii', 'replace')}'", "its number")
        place = head_end
        if word[2]:
            fields = head[word.end() :].split()
            place += int(fields[3])  # the text before the binary numbers has line ends of its own
        end = (BINARY_END if word[2] else DELIMITER).search(data, place)
        if end is None:
            raise damaged(part, f"the dataset {int(word[1])} without its end", "a line -1 behind it")
        place = end.end()
        yield int(word[1]), [] if word[2] else data[head_end : end.start()].decode("utf-8", "replace").splitlines()[1:]


def _nodes(part: str, number: int, lines: list[str], found: UniversalFile) -> None:
    step = 1 if number == 15 else 2
    for k in range(0, len(lines), step):
        widths = [10] * 4 + [13] * 3 if step == 1 else [10] * 4
        words = fields_of(part, number, lines[k], widths)
        if step == 2:
            words += fields_of(part, number, lines[k + 1] if k + 1 < len(lines) else "", [25] * 3)
        label, system = int(words[0]), int(words[1])
        if number != 2411 and system > 1:
            raise MeshError(
                part,
                found=f"node {label} in the coordinate system {system} (dataset {number})",
                expected="coordinates in the global system, 0 or 1",
                remedy="Write the nodes as dataset 2411, or in the global system",
            )
        found.labels.append(label)
        found.points.append([float(word.upper().replace("D", "E")) for word in words[4:7]])


def _elements(part: str, lines: list[str], found: UniversalFile) -> None:
    k = 0
    while k < len(lines):
        label, descriptor, family, _, _, count = map(int, fields_of(part, 2412, lines[k], [10] * 6))
        if descriptor in PIPES:
            raise MeshError(
                part,
                found=f"element {label} with the descriptor {descriptor}, a pipe",
                expected="rods, beams, shells and solids",
                remedy="Write the pipes as beams, or leave them out",
            )
        if not 1 <= count <= 64:
            raise damaged(part, f"element {label} with {count} nodes", "1 to 64")
        k += 2 if descriptor in BEAMS else 1
        nodes: list[int] = []
        while len(nodes) < count:
            if k >= len(lines):
                raise damaged(part, f"element {label} with {len(nodes)} nodes at the end of the dataset", f"{count}")
            nodes += map(int, fields_of(part, 2412, lines[k], [10] * min(8, count - len(nodes))))
            k += 1
        found.elements.setdefault((descriptor, count), []).append([label, family, *nodes])


def _groups(part: str, number: int, lines: list[str], found: UniversalFile) -> None:
    k = 0
    while k < len(lines):
        head = [int(word) for word in fields_of(part, number, lines[k], [10] * 8)]
        name = lines[k + 1].strip() if k + 1 < len(lines) else ""
        k += 2
        members: list[int] = []
        while len(members) < 4 * head[7]:
            if k >= len(lines):
                raise damaged(
                    part, f"group '{name}' with {len(members) // 4} members at the end of the dataset", f"{head[7]}"
                )
            members += map(int, fields_of(part, number, lines[k], [10] * min(8, 4 * head[7] - len(members))))
            k += 1
        table = np.array(members, np.int64).reshape(-1, 4)
        nodes, elements = (table[table[:, 0] == kind, 1] for kind in (7, 8))
        others = len(table) - len(nodes) - len(elements)
        found.groups.append(Group(name or f"group_{head[0]}", nodes, elements, others))


def _unit(part: str, lines: list[str], found: UniversalFile) -> None:
    """Read the unit of length: lengths of the file divided by the factor are metres."""
    words = " ".join(lines[1:]).split()
    factor = float(words[0].upper().replace("D", "E")) if words else 0.0
    if not 1e-12 < factor < 1e12:
        raise damaged(part, f"the factor {factor:g} of lengths (dataset 164)", "a number > 0")
    if found.unit is not None and abs(found.unit * factor - 1.0) > 1e-6:
        raise damaged(part, f"units of {found.unit:g} m and of {1.0 / factor:g} m (dataset 164)", "one unit")
    found.unit = 1.0 / factor


def fields_of(part: str, number: int, line: str, widths: list[int]) -> list[str]:
    """Return the words of a line, as many as there are widths."""
    words = line.split()
    if len(words) != len(widths):
        ends = np.cumsum([0, *widths])
        words = [line[a:b].strip() for a, b in pairwise(ends)]
        if line[ends[-1] :].strip() or not all(words):
            raise damaged(part, f"the line '{line.strip()[:90]}' in dataset {number}", f"{len(widths)} fields")
    return words


def damaged(part: str, found: str, expected: str) -> MeshError:
    return MeshError(part, found=found, expected=expected, remedy="The file is cut off or damaged: write it again")
