"""`read_columns`: columns of a text table, as recorders and spreadsheets write them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import NoReturn

import numpy as np

from flexmb.errors import ModelError, did_you_mean
from flexmb.io.limits import check_size, is_file

__all__ = ["read_columns"]

ROWS = 100_000
"""More are refused: a model file holds them, and a drawing of the signal shows fewer."""


def read_columns(path: str | Path, columns: Sequence[int | str] = (0, 1)) -> list[np.ndarray]:
    """Return columns (n,) of a text file: a history that was measured, a road, a load over an angle.

    A line of titles may come first; lines that begin with # are passed over. Fields are separated by semicolons, tabs,
    commas or blanks, and have decimal points.

    Parameters
    ----------
    path : path
    columns : sequence of int or str
        Numbers, counted from 0, or titles, with or without their unit: "F [N]" or "F".

    Raises
    ------
    ModelError
        The file cannot be read, a field is no finite number, rows differ in length, or a column does not exist.

    Examples
    --------
    ::

        road = fmb.table(*fmb.io.read_columns("road.csv", ["t", "z"]), kind="linear")
    """
    path = Path(path)
    part = f"Table file '{path}'"
    if not is_file(path):
        raise ModelError(part, found="no such file", expected="a text file", remedy="Correct the name or the folder")
    check_size(path, part)
    try:
        text = path.read_bytes().decode("utf-8-sig", "replace")
    except OSError as error:
        why = error.strerror or error
        raise ModelError(
            part, found=f"it cannot be read ({why})", expected="a readable text file", remedy="Check its rights"
        ) from error
    lines = [(k, line.strip()) for k, line in enumerate(text.splitlines(), start=1) if line.strip()]
    titles: list[str] = []
    if lines and not _numbers(_fields(lines[0][1].lstrip("# "), _separator(lines[0][1]))):
        titles = [one.strip("\"' ") for one in _fields(lines[0][1].lstrip("# "), _separator(lines[0][1]))]
        lines = lines[1:]
    lines = [(k, line) for k, line in lines if not line.startswith("#")]
    if not 0 < len(lines) <= ROWS:
        raise ModelError(
            part,
            found=f"{len(lines)} rows of numbers",
            expected=f"1 to {ROWS}",
            remedy="Thin the samples" if lines else "Write a row for each point, such as 0.0, 1.5",
        )
    rows = [_row(line, k, part) for k, line in lines]
    wide = len(rows[0])
    other = next((k for (k, _), row in zip(lines, rows, strict=True) if len(row) != wide), None)
    if other is not None:
        _refuse(part, other, f"another number of fields than the {wide} of the first row", "as many in every row")
    table = np.array(rows)
    return [table[:, _place(one, titles, wide, part)] for one in columns]


def _separator(line: str) -> str | None:
    """Return what separates the fields of a line; None for blanks."""
    return next((mark for mark in (";", "\t", ",") if mark in line), None)


def _fields(line: str, separator: str | None) -> list[str]:
    return [field.strip() for field in line.split(separator)]


def _numbers(fields: list[str]) -> bool:
    """Are all fields numbers, "nan" and decimal commas among them? A line with another word has titles."""
    try:
        return bool([float(field.replace(",", ".")) for field in fields if field])
    except ValueError:
        return False


def _row(line: str, k: int, part: str) -> list[float]:
    """Return the numbers of line k."""
    separator = _separator(line)
    fields = _fields(line, separator)
    if separator is not None and len(fields) > 1 and not fields[-1]:
        fields = fields[:-1]  # a separator behind the last field
    row = []
    for field in fields:
        try:
            row.append(float(field))
        except ValueError:
            comma = separator != "," and "," in field
            _refuse(part, k, f"'{field[:40]}'", "numbers with decimal points" if comma else "numbers")
        if not np.isfinite(row[-1]):
            _refuse(part, k, f"'{field[:40]}'", "finite numbers")
    return row


def _refuse(part: str, k: int, found: str, expected: str) -> NoReturn:
    raise ModelError(part, found=f"line {k} has {found}", expected=expected, remedy="Correct the line, or remove it")


def _place(one: int | str, titles: list[str], wide: int, part: str) -> int:
    """Return the number of a column."""
    if isinstance(one, str):
        plain = [title.partition("[")[0].strip() for title in titles]
        for known in (titles, plain):
            if known.count(one) == 1 and known.index(one) < wide:
                return known.index(one)
        listed = f"one of: {', '.join(titles)}" if titles else "a line of titles, or numbers of columns"
        raise ModelError(
            part,
            found=f"no column '{one}'" if one not in (*titles, *plain) else f"several columns '{one}'",
            expected=listed,
            remedy=did_you_mean(one, [*titles, *plain]) or "Name another one, or give its number, counted from 0",
        )
    if isinstance(one, bool) or not isinstance(one, int | np.integer) or not 0 <= one < wide:
        raise ModelError(
            part,
            found=f"no column {one!r}",
            expected=f"a title, or a number from 0 to {wide - 1}",
            remedy="Write columns = [0, 1]",
        )
    return int(one)
