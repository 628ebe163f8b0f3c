"""Text of SID files (Standard Input Data, Wallrapp 1993): nested keywords and Taylor blocks.

A Taylor block is a matrix m0 and, at order 1, one matrix m1 per mode: M(q) = m0 + sum_k m1[k] q_k. Only entries that
are not zero are written. Programs differ in the order of the three indices of m1: (row, mode, column) or (row, column,
mode); `read_sid_text` finds out which.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, field

import numpy as np

from flexmb.errors import DataFileError

__all__ = ["SidText", "Taylor", "read_sid_text", "taylor_text"]

_ENTRY = re.compile(r"m([01])\s*\((\s*\d{1,9}\s*(?:,\s*\d{1,9}\s*){1,2})\)\s*=\s*(\S+)", re.ASCII)
_SIZE = re.compile(r"(order|nrow|ncol|nq|nqn|structure)\s*=\s*(\d{1,9})", re.ASCII)
_FEW, _PER_BYTE = 10_000_000, 100
"""Numbers that all blocks together may have: so many, or so many per byte of the file, which holds what is not zero."""
_TAYLOR = {
    "origin",
    "phi",
    "psi",
    "AP",
    "sigma",
    "mdCM",
    "J",
    "Ct",
    "Cr",
    "Me",
    "Gr",
    "Ge",
    "Oe",
    "ksigma",
    "Ke",
    "De",
}


@dataclass(frozen=True, eq=False)
class Taylor:
    """A Taylor block: m0 (rows, columns) and m1 (modes, rows, columns)."""

    m0: np.ndarray
    m1: np.ndarray


@dataclass(eq=False)
class SidText:
    """Contents of a SID file: mass, mode labels, blocks of the body and of each node."""

    mass: float = 0.0
    labels: list[str] = field(default_factory=list)
    blocks: dict[str, Taylor] = field(default_factory=dict)
    nodes: dict[str, dict[str, Taylor]] = field(default_factory=dict)


def taylor_text(name: str, m0: np.ndarray, m1: np.ndarray | None, n_modes: int, indent: str) -> list[str]:
    """Return the lines of a Taylor block; m1 is (modes, rows, columns) or None for order 0."""
    m0 = np.atleast_2d(m0)
    order = 0 if m1 is None else 1
    empty = not m0.any() and (m1 is None or not m1.any())
    lines = [
        name,
        *(
            f"    {key:<12} = {value}"
            for key, value in {
                "order": order,
                "nrow": m0.shape[0],
                "ncol": m0.shape[1],
                "nq": n_modes if order else 0,
                "nqn": 0,
                "structure": 0 if empty else 3,
            }.items()
        ),
    ]
    lines += [f"    m0({i + 1:5d},{j + 1:5d})       = {m0[i, j]:.16e}" for i, j in np.argwhere(m0)]
    if m1 is not None:
        lines += [f"    m1({i + 1:5d},{k + 1:5d},{j + 1:5d}) = {m1[k, i, j]:.16e}" for k, i, j in np.argwhere(m1)]
    return [indent + line for line in [*lines, f"end {name}"]]


def read_sid_text(text: str, part: str) -> SidText:
    """Parse a SID file; `part` names it in messages."""
    raw, sid = _parse(text, part)
    _check_sizes(raw, len(text), part)
    mode_is_second = _mode_is_second(raw)
    for node, name, sizes, entries in raw:
        block = _taylor(sizes, entries, mode_is_second, part, name)
        held = sid.blocks if node is None else sid.nodes.setdefault(node, {})
        if name in held:
            raise DataFileError(
                part,
                found=f"a second block '{name}'" + ("" if node is None else f" of node '{node}'"),
                expected="every block once",
                remedy="The file is damaged, or two were joined: export it again",
            )
        held[name] = block
    return sid


def _check_sizes(raw, length: int, part: str) -> None:
    """Refuse sizes that do not fit the file, before memory is taken for them."""
    total = 0
    for _, name, sizes, _ in raw:
        total += sizes.get("nrow", 0) * sizes.get("ncol", 0) * (1 + sizes.get("nq", 0))
        if total > max(_FEW, _PER_BYTE * length):
            raise DataFileError(
                part,
                found=f"{total:.3g} numbers up to the block '{name}' (nrow {sizes.get('nrow', 0)}, "
                f"ncol {sizes.get('ncol', 0)}, nq {sizes.get('nq', 0)}) in a file of {length} bytes",
                expected=f"at most {max(_FEW, _PER_BYTE * length):.3g}",
                remedy="A size is damaged: export the file again",
            )


def _parse(text: str, part: str):
    """Return the raw Taylor blocks (node, name, sizes, entries) and the plain values."""
    sid, raw = SidText(), []
    node: str | None = None
    current: tuple[str | None, str, dict, list] | None = None
    lines = text.splitlines()[1:]
    for number, line in enumerate((line.strip() for line in lines), start=2):
        if line in _TAYLOR and current is None:
            current = (node, line, {}, [])
        elif current is not None and line.split() == ["end", current[1]]:
            raw.append(current)
            current = None
        elif current is not None:
            if line and number <= len(lines):  # in the last line a block has no end
                _store(current, line, number, part)
        elif line.startswith("end node"):
            node = None
        elif "=" in line:
            key, value = (side.strip() for side in line.split("=", 1))
            if key == "new node":
                if value in sid.nodes:
                    raise _broken(part, number, f"a second node '{value}'", "nodes whose names differ")
                node = value
                sid.nodes[node] = {}
            elif key == "mass":
                sid.mass = _number(value, part)
            elif key.startswith("ielastq"):
                sid.labels.append(value)
    if current is not None or not raw:
        found = f"the block '{current[1]}' has no end" if current is not None else "no Taylor block (mdCM, J, Ct, ...)"
        raise DataFileError(
            part,
            found=found,
            expected="an ASCII SID file",
            remedy="Export it again: it was cut off, or it is binary",
        )
    return raw, sid


def _store(current, line: str, number: int, part: str) -> None:
    """Store one line of a block: an entry or a size. A line that is neither is damage: its number would be lost."""
    match = _ENTRY.fullmatch(line)
    size = _SIZE.fullmatch(line)
    if size:
        if size[1] in current[2]:
            raise _broken(part, number, f"a second {size[1]} in the block '{current[1]}'", "one of each")
        current[2][size[1]] = int(size[2])
        return
    indices = tuple(int(i) for i in match[2].split(",")) if match else ()
    if match is None or len(indices) != (2 if match[1] == "0" else 3) or min(indices) < 1:
        raise _broken(
            part,
            number,
            f"the line '{line[:60]}' in the block '{current[1]}'",
            "m0(row, column) = value, m1(row, mode, column) = value, or a size",
        )
    current[3].append((int(match[1]), tuple(i - 1 for i in indices), _number(match[3], part)))


def _broken(part: str, number: int, found: str, expected: str) -> DataFileError:
    return DataFileError(
        part, found=f"line {number}: {found}", expected=expected, remedy="The file is damaged: export it again"
    )


def _number(text: str, part: str) -> float:
    try:
        value = float(text.lower().replace("d", "e"))  # Fortran writes 1.0D+03
        if math.isfinite(value):
            return value
    except ValueError:
        pass
    raise DataFileError(
        part,
        found=f"'{text[:60]}' in place of a number",
        expected="a decimal number",
        remedy="Look for overflowed fields (****) or a broken line",
    )


def _mode_is_second(raw) -> bool:
    """Tell the index order of m1 from blocks with one column (mdCM, J, origin), else from the bounds."""
    for one_column in (True, False):
        for _, _, sizes, entries in raw:
            if (sizes.get("ncol") == 1) != one_column:
                continue
            for order, indices, _ in entries:
                columns, modes = sizes.get("ncol", 0), sizes.get("nq", 0)
                if order == 1 and (indices[1] >= columns or indices[2] >= modes):
                    return True
                if order == 1 and (indices[2] >= columns or indices[1] >= modes):
                    return False
    return True


def _taylor(sizes, entries, mode_is_second: bool, part: str, name: str) -> Taylor:
    rows, columns, modes = sizes.get("nrow", 0), sizes.get("ncol", 0), sizes.get("nq", 0)
    m0, m1 = np.zeros((rows, columns)), np.zeros((modes, rows, columns))
    try:
        for order, indices, value in entries:
            if order == 0:
                m0[indices] = value
            else:
                row, second, third = indices
                k, column = (second, third) if mode_is_second else (third, second)
                m1[k, row, column] = value
    except (IndexError, ValueError) as error:
        raise DataFileError(
            part,
            found=f"an index outside of block '{name}' ({rows} x {columns}, {modes} modes)",
            expected="indices within nrow, ncol, nq",
            remedy="Export the file again",
        ) from error
    if sizes.get("structure") == 2 and rows == columns and not np.tril(m0, -1).any() * np.triu(m0, 1).any():
        m0 = m0 + m0.T - np.diag(np.diag(m0))  # one triangle of a symmetric block
        m1 = m1 + m1.transpose(0, 2, 1) - np.einsum("kii->ki", m1)[:, :, None] * np.eye(rows)
    if sizes.get("structure") == 4:
        m0 = np.eye(rows)
    return Taylor(m0, m1)
