"""Text of MBDyn's ``.fem`` files: record groups, each a line ``** RECORD GROUP n`` and numbers in free format."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from flexmb.errors import DataFileError
from flexmb.found import no_file_because

__all__ = ["Record", "group_text", "read_groups"]

TITLES = {
    1: "HEADER",
    2: "FINITE ELEMENT NODE LIST",
    3: "INITIAL MODAL DISPLACEMENTS",
    4: "INITIAL MODAL VELOCITIES",
    5: "NODAL X COORDINATES",
    6: "NODAL Y COORDINATES",
    7: "NODAL Z COORDINATES",
    8: "MODE SHAPES",
    9: "MODAL MASS MATRIX",
    10: "MODAL STIFFNESS MATRIX",
    11: "DIAGONAL OF LUMPED MASS MATRIX",
    12: "GLOBAL INERTIA",
    13: "MODAL DAMPING MATRIX",
    14: "INVARIANT 3",
    15: "INVARIANT 4",
    16: "INVARIANT 8",
    17: "INVARIANT 5",
    18: "INVARIANT 9",
    19: "MODAL STRESS STIFFENING MATRICES",
}
NEEDED = (1, 2, 5, 6, 7, 8, 9, 10)
PER_LINE = 6
_GROUP = re.compile(r"\*\*\s*RECORD GROUP\s+(\d+)")
_END = re.compile(r"\*\*\s*END OF FILE")


@dataclass(eq=False)
class Record:
    """Contents of a file: labels of its nodes, positions (k, 3), shapes (k, 6, m), flat numbers of the other groups."""

    labels: tuple[str, ...]
    n_modes: int
    positions: np.ndarray
    shapes: np.ndarray
    groups: dict[int, np.ndarray]
    stress_stiffness: dict[int, np.ndarray] = field(default_factory=dict)


def group_text(name: str, labels: list[str], frequencies: np.ndarray, groups: Mapping[int, np.ndarray]) -> str:
    """Return the text of a file.

    Parameters
    ----------
    groups : mapping of record group to numbers
        Group 8 as (nodes, 6, modes), group 19 as (12 + 6 ni, modes, modes), the others in the order of the file.
    """
    m = len(frequencies)
    lines = [
        f"** {name}: {len(labels)} nodes, {m} modes, SI units, body axes",
        "**",
        _title(1),
        "**   REVISION, NODES, NORMAL, ATTACHMENT, CONSTRAINT, REJECTED MODES",
        f"  REV0 {len(labels)} {m} 0 0 0",
        "**",
        _title(2),
        *(f"  {label}" for label in labels),
    ]
    for number in sorted(groups):
        lines += ["**", _title(number)]
        if number == 8:
            for j, frequency in enumerate(frequencies):
                lines.append(f"**    NORMAL MODE SHAPE # {j + 1}: {frequency:.6g} Hz")
                lines += _rows(groups[8][:, :, j])
        elif number == 19:
            lines.append(f"  {len(groups[19])}")
            for index, matrix in enumerate(groups[19], 1):
                lines += [f"  {index}", *_rows(matrix)]
        else:
            lines += _rows(np.atleast_2d(groups[number]))
    return "\n".join([*lines, "** END OF FILE", ""])


def _title(number: int) -> str:
    return f"** RECORD GROUP {number}, {TITLES[number]}"


def _rows(matrix: np.ndarray) -> Iterable[str]:
    """Yield lines of at most six numbers; a row of the matrix begins a line."""
    for row in matrix:
        for start in range(0, len(row), PER_LINE):
            yield "  " + " ".join(f"{x: .16e}" for x in row[start : start + PER_LINE])


def read_groups(path: Path, part: str) -> Record:
    """Read a file; `part` names it in messages."""
    if (found := no_file_because(path, (".fem",), "the file does not exist")) is not None:
        remedy = found.remedy or "Check the path"
        raise DataFileError(part, found=found.what, expected="a .fem file of MBDyn", remedy=remedy)
    lines = _split(path.read_text(encoding="latin-1"))
    missing = [number for number in NEEDED if number not in lines]
    if missing:
        raise DataFileError(
            part,
            found=f"no record group {', '.join(map(str, missing))}",
            expected="record groups 1, 2 and 5 to 10",
            remedy="The file is cut off or of another kind: write it again",
        )
    n, m, rejected = _sizes(lines[1], part)
    needed = 6 * n * (m + rejected) + 2 * m * m
    if needed > sum(map(len, lines[8])) + sum(map(len, lines[9])) + sum(map(len, lines[10])):  # a number is a character
        raise DataFileError(
            part,
            found=f"a header of {n} nodes and {m + rejected} modes, which make {needed} numbers, in a shorter file",
            expected="the shapes and matrices that the header announces",
            remedy="The file is cut off, or the header belongs to other data",
        )
    sizes = {3: m, 4: m, 5: n, 6: n, 7: n, 9: m * m, 10: m * m, 11: 6 * n, 12: 13, 13: m * m}
    sizes |= {14: 3 * m, 15: 3 * m, 16: 9 * m, 17: 3 * m * m, 18: 9 * m * m}
    groups = {number: _numbers(lines[number], sizes[number], number, part) for number in lines if number in sizes}
    labels = tuple(" ".join(line for line in lines[2] if not line.startswith("**")).split()[:n])
    if len(labels) < n:
        raise _short(part, 2, n, len(labels))
    positions = np.column_stack([groups[5], groups[6], groups[7]])
    record = Record(labels, m, positions, _shapes(lines[8], n, m, rejected, part), groups)
    if 19 in lines:
        record.stress_stiffness = _indexed(lines[19], m, part)
    return record


def _split(text: str) -> dict[int, list[str]]:
    """Return the lines of each group without its title."""
    groups: dict[int, list[str]] = {}
    lines: list[str] = []
    for line in text.splitlines():
        if _END.match(line):
            break
        title = _GROUP.match(line)
        if title:
            lines = groups.setdefault(int(title[1]), [])
        else:
            lines.append(line)
    return groups


def _sizes(lines: list[str], part: str) -> tuple[int, int, int]:
    """Return the numbers of nodes, of modes in use and of rejected modes; a comment line comes first."""
    words = " ".join(lines[1:]).split()
    try:
        nodes, *modes = (int(word) for word in words[1:6])
        used = modes[0] + modes[1] + modes[2] - modes[3]
        if nodes < 1 or min(*modes, used) < 0:
            raise ValueError("a negative number")
        return nodes, used, modes[3]
    except (ValueError, IndexError, TypeError):
        raise DataFileError(
            part,
            found=f"the header '{' '.join(words[:6])[:80]}'",
            expected="a revision and five whole numbers >= 0 after one comment line, not all modes rejected",
            remedy="Write REV0 NNODES NNORMAL NATTACHED NCONSTRAINT NREJECTED",
        ) from None


def _short(part: str, number: int, expected: int, found: int) -> DataFileError:
    return DataFileError(
        part,
        found=f"{found} of {expected} values in record group {number}",
        expected=f"{expected}, as the header says",
        remedy="The file is cut off, or the header belongs to other data",
    )


def _numbers(lines: list[str], count: int, number: int, part: str) -> np.ndarray:
    """Return the first so many numbers of a group; what follows is comment."""
    words: list[str] = []
    for line in lines:
        words += line.split() if not line.startswith("**") else []
        if len(words) >= count:
            break
    found: list[float] = []
    for word in words[:count]:
        try:
            value = float(word.replace("D", "e").replace("d", "e"))
        except ValueError:
            break
        if not math.isfinite(value):
            break
        found.append(value)
    if len(found) < count:
        raise _short(part, number, count, len(found))
    return np.array(found)


def _shapes(lines: list[str], n: int, m: int, rejected: int, part: str) -> np.ndarray:
    """Return the shapes (n, 6, m): one comment line, then six numbers per node, for each mode; rejected ones first."""
    shapes, line = np.zeros((n, 6, rejected + m)), 0
    for j in range(rejected + m):
        line += 1
        start, words = line, 0
        while line < len(lines) and words < 6 * n:
            words += len(lines[line].split())
            line += 1
        shapes[:, :, j] = _numbers(lines[start:line], 6 * n, 8, part).reshape(n, 6)
    return shapes[:, :, rejected:]


def _indexed(lines: list[str], m: int, part: str) -> dict[int, np.ndarray]:
    """Return the matrices of group 19 by their index."""
    count = int(_numbers(lines, 1, 19, part)[0])
    if not 0 <= count <= sum(map(len, lines)):
        raise _short(part, 19, count, sum(map(len, lines)))
    values = _numbers(lines, 1 + count * (1 + m * m), 19, part)[1:].reshape(count, 1 + m * m)
    return {int(row[0]): row[1:].reshape(m, m) for row in values}
