"""`Results`: the table of a study: parameters, outputs and errors, one row per variant."""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from flexmb.errors import FlexmbError, did_you_mean
from flexmb.files import replacing, without_formulas

__all__ = ["Results", "Row", "read_row"]

DONE, FAILED, DIED = "done", "failed", "died"
_LINES = 30


@dataclass(frozen=True)
class Row:
    """What became of one variant.

    Parameters
    ----------
    number : int
        From 1, its place in the plan.
    parameters : mapping of name to value
    status : str
        "done"; "failed": the model or the solver says why; "died": its process ended or was ended.
    values : mapping of output title to number
    seconds : float
        Time it took.
    error, warnings : str
    reduced, reused : int
        Parts of finite elements that were reduced for it, and that were found in the cache.
    """

    number: int
    parameters: Mapping[str, Any]
    status: str
    values: Mapping[str, float] = field(default_factory=dict)
    seconds: float = 0.0
    error: str = ""
    warnings: str = ""
    reduced: int = 0
    reused: int = 0

    def plain(self) -> dict[str, Any]:
        """Return the row as JSON can hold it."""
        return asdict(self)


def read_row(entry: Any) -> Row:
    """Return a row from what JSON says of it; ValueError or TypeError if a value is of another kind."""
    row = Row(**entry)
    counts, texts = (row.number, row.reduced, row.reused), (row.status, row.error, row.warnings)
    numbers = (*counts, row.seconds, *dict(row.values).values())
    if (
        not all(isinstance(n, int) and not isinstance(n, bool) for n in counts)
        or not all(isinstance(text, str) for text in texts)
        or not all(x is None or (isinstance(x, int | float) and not isinstance(x, bool)) for x in numbers)
        or not isinstance(row.parameters, dict)
    ):
        raise ValueError(f"row {str(row.number)[:20]} has values of another kind")
    return row


class Results:
    """The rows of a study in the order of its plan; ``results["max(strut force fx)"]`` is a column.

    Parameters
    ----------
    names : sequence of str
        Parameters.
    rows : sequence of Row
    reduced : int
        Parts of finite elements that were reduced in this call, in all processes.
    """

    def __init__(self, names: Sequence[str], rows: Sequence[Row], reduced: int = 0):
        self.names, self.reduced = tuple(names), reduced
        self.rows = tuple(sorted(rows, key=lambda row: row.number))

    def __len__(self) -> int:
        return len(self.rows)

    @property
    def titles(self) -> tuple[str, ...]:
        """Titles of the outputs, with units."""
        return tuple(dict.fromkeys(title for row in self.rows for title in row.values))

    @property
    def failed(self) -> tuple[Row, ...]:
        """The rows without numbers."""
        return tuple(row for row in self.rows if row.status != DONE)

    def __getitem__(self, name: str) -> np.ndarray:
        """Return a parameter or an output, (rows,); the unit in an output's title may be left out; NaN for failures."""
        if name in self.names:
            return np.array([row.parameters[name] for row in self.rows])
        titles = {title.partition(" [")[0]: title for title in self.titles}
        title = name if name in self.titles else titles.get(name)
        if title is None:
            raise FlexmbError(
                "Results",
                found=f"there is no column '{name}'",
                expected=f"One of: {', '.join((*self.names, *self.titles))}",
                remedy=did_you_mean(name, (*self.names, *titles)) or "Correct the name",
            )
        return np.array([row.values.get(title, np.nan) for row in self.rows], float)

    def columns(self) -> dict[str, list[Any]]:
        """Return all columns by title: number, parameters, status, outputs, seconds, warnings, error."""
        titles = self.titles
        table: dict[str, list[Any]] = {"number": [row.number for row in self.rows]}
        for name in self.names:
            table[name] = [row.parameters[name] for row in self.rows]
        table["status"] = [row.status for row in self.rows]
        for title in titles:
            table[title] = [row.values.get(title) for row in self.rows]
        table["seconds"] = [round(row.seconds, 3) for row in self.rows]
        table["warnings"] = [row.warnings for row in self.rows]
        table["error"] = [row.error for row in self.rows]
        return table

    def write_csv(self, path: str | Path) -> Path:
        """Write the table as CSV, replacing the file in one go, and return the path; missing numbers stay empty."""
        path = Path(path)
        table = self.columns()
        with replacing(path, f"Table '{path}'") as part, part.open("w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file)
            writer.writerow(without_formulas(table))
            writer.writerows(without_formulas("" if x is None else x for x in cells) for cells in zip(*table.values()))
        return path

    def write_parquet(self, path: str | Path) -> Path | None:
        """Write the table as Parquet and return the path; None where the package pyarrow is not installed."""
        try:
            import pyarrow
            from pyarrow import parquet
        except ImportError:
            return None
        path = Path(path)
        columns = {title: _uniform(cells) for title, cells in self.columns().items()}
        with replacing(path, f"Table '{path}'") as part:
            parquet.write_table(pyarrow.table(columns), part)
        return path

    def __str__(self) -> str:
        lines = [f"{len(self)} variants, {len(self.failed)} without a result"]
        titles = ("number", *self.names, *self.titles)
        table = self.columns()
        shown = [row for row in range(len(self)) if row < _LINES - 1 or len(self) <= _LINES]
        cells = [titles, *(tuple(_text(table[title][row]) for title in titles) for row in shown)]
        widths = [max(len(line[k]) for line in cells) for k in range(len(titles))]
        lines += ["  ".join(cell.rjust(width) for cell, width in zip(line, widths)) for line in cells]
        if len(shown) < len(self):
            lines.append(f"... and {len(self) - len(shown)} more")
        if self.reduced or any(row.reduced or row.reused for row in self.rows):
            lines.append(f"Parts of finite elements: {self.reduced} reduced, all others from the cache")
        lines += [f"{row.number}: {row.status}: {row.error}" for row in self.failed[:5]]
        if len(self.failed) > 5:
            lines.append(f"... and {len(self.failed) - 5} more without a result")
        return "\n".join(lines)


def _text(cell: Any) -> str:
    return "-" if cell is None else f"{cell:.6g}" if isinstance(cell, float) else str(cell)


def _uniform(cells: list[Any]) -> list[Any]:
    """Return cells of one type: a parameter may be a number in one row and a text in another."""
    kinds = {type(cell) for cell in cells if cell is not None}
    if len(kinds) < 2:
        return cells
    return [float(c) for c in cells] if kinds == {int, float} else [str(c) for c in cells]
