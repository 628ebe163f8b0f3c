"""`Plan`: which values the parameters take, one row per variant: a grid, a Latin hypercube, or a list."""

from __future__ import annotations

import csv
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

from flexmb.errors import ModelError
from flexmb.found import no_file_because
from flexmb.io import parse_setting

__all__ = ["Plan", "grid", "latin_hypercube", "listed", "range_values", "read_plan"]


@dataclass(frozen=True)
class Plan:
    """Names of parameters and their values, one row per variant.

    Parameters
    ----------
    names : tuple of str
    rows : tuple of tuple
        Numbers, texts or booleans, in the order of the names.

    Examples
    --------
    >>> plan = grid({"pressure": [4e3, 5e3], "mass": [1.0, 2.0, 3.0]})
    >>> len(plan), plan.rows[1]
    (6, (4000.0, 2.0))
    """

    names: tuple[str, ...]
    rows: tuple[tuple[Any, ...], ...]

    def __post_init__(self):
        names = tuple(self.names)
        if not names or not self.rows:
            raise ModelError(
                "Plan",
                found="it has no parameter" if not names else "it has no variant",
                expected="at least one parameter with at least one value",
                remedy='Write {"pressure": [4e3, 5e3]}, or --over pressure=4e3:6e3:5',
            )
        twice = sorted({name for name in names if names.count(name) > 1})
        if twice:
            raise ModelError(
                f"Plan, {twice[0]}",
                found="the parameter is given twice",
                expected="each parameter once",
                remedy="Leave one of them out",
            )
        object.__setattr__(self, "names", names)
        object.__setattr__(self, "rows", tuple(self._row(k, row) for k, row in enumerate(self.rows, 1)))

    def _row(self, number: int, row: Sequence[Any]) -> tuple[Any, ...]:
        if len(row) != len(self.names):
            raise ModelError(
                f"Plan, row {number}",
                found=f"{len(row)} values",
                expected=f"{len(self.names)}: {', '.join(self.names)}",
                remedy="Give every parameter a value in every row",
            )
        return tuple(_plain(value, f"Plan, row {number}, {name}") for name, value in zip(self.names, row))

    def __len__(self) -> int:
        return len(self.rows)

    def variant(self, k: int) -> dict[str, Any]:
        """Return the parameters of row `k` by name."""
        return dict(zip(self.names, self.rows[k]))


def grid(values: Mapping[str, Iterable[Any]]) -> Plan:
    """Return every combination of the values; the last parameter varies fastest.

    Parameters
    ----------
    values : mapping of parameter name to its values
    """
    lists = {name: _values(entry, f"Plan, {name}") for name, entry in values.items()}
    for name, entry in lists.items():
        if not entry:
            raise ModelError(
                f"Plan, {name}",
                found="the list of values is empty",
                expected="at least one value",
                remedy=f"Write {name}=1,2,3 or {name}=1:3:3",
            )
    return Plan(tuple(lists), tuple(product(*lists.values())))


def latin_hypercube(ranges: Mapping[str, tuple[float, float]], samples: int, *, seed: int = 0) -> Plan:
    """Return a Latin hypercube: each of `samples` equal slices of every range has exactly one value.

    Source: M. D. McKay, R. J. Beckman, W. J. Conover, Technometrics 21 (1979) 239-245.

    Parameters
    ----------
    ranges : mapping of parameter name to (low, high)
    samples : int
        Number of variants.
    seed : int
        The same seed gives the same plan.
    """
    from scipy.stats import qmc

    if isinstance(samples, bool) or samples != int(samples) or samples < 1:
        raise ModelError(
            "Latin hypercube",
            found=f"samples = {samples!r}",
            expected="a whole number of at least 1",
            remedy="Write --latin 50",
        )
    for name, entry in ranges.items():
        _check_range(name, entry)
    if not ranges:
        return Plan((), ())
    low, high = np.array([ranges[name] for name in ranges], float).T
    points = qmc.LatinHypercube(len(ranges), rng=np.random.default_rng(seed)).random(int(samples))
    return Plan(tuple(ranges), tuple(map(tuple, (low + points * (high - low)).tolist())))


def listed(rows: Iterable[Mapping[str, Any]]) -> Plan:
    """Return the given variants: mappings with the same names."""
    rows = list(rows)
    names = tuple(rows[0]) if rows else ()
    for number, row in enumerate(rows, 1):
        if set(row) != set(names):
            raise ModelError(
                f"Plan, row {number}",
                found=f"it has {', '.join(row) or 'no parameters'}",
                expected=f"the parameters of the first row: {', '.join(names)}",
                remedy="Give the same parameters in every row",
            )
    return Plan(names, tuple(tuple(row[name] for name in names) for row in rows))


def read_plan(path: str | Path) -> Plan:
    """Return the variants of a CSV file: a line with the names, then a line for each variant.

    Values are numbers, expressions (``38*deg``) or texts, as with ``--set``.
    """
    path = Path(path)
    if (lacking := no_file_because(path, (".csv",))) is not None:  # a pipe would be waited for
        raise ModelError(
            f"Plan '{path}'",
            found=f"it cannot be read ({lacking.what})",
            expected="a CSV file: a line with names, then a line for each variant",
            remedy=lacking.remedy or "Correct the path",
        )
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            lines = [[cell.strip() for cell in line] for line in csv.reader(file) if any(map(str.strip, line))]
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise ModelError(
            f"Plan '{path}'",
            found=f"it cannot be read ({error})",
            expected="a CSV file: a line with names, then a line for each variant",
            remedy="Correct the path",
        ) from error
    if len(lines) < 2:
        raise ModelError(
            f"Plan '{path}'",
            found=f"{len(lines)} lines",
            expected="a line with the names and at least one with values",
            remedy="Write the names of the parameters into the first line",
        )
    names, *rows = lines
    for number, row in enumerate(rows, 2):
        if len(row) != len(names) or not all(row):
            raise ModelError(
                f"Plan '{path}', line {number}",
                found=f"{sum(map(bool, row))} values",
                expected=f"{len(names)}: {', '.join(names)}",
                remedy="Give every parameter a value, separated by commas",
            )
    return Plan(
        tuple(names),
        tuple(tuple(parse_setting(f"{n}={v}")[1] for n, v in zip(names, row)) for row in rows),
    )


def range_values(name: str, start: Any, stop: Any, count: Any) -> list[float]:
    """Return `count` equally spaced values from `start` to `stop`, both included."""
    numbers = [x for x in (start, stop, count) if isinstance(x, int | float) and math.isfinite(x)]
    whole = len(numbers) == 3 and numbers[2] == int(numbers[2])
    if not whole or count < 1 or (count > 1) != (start != stop):
        raise ModelError(
            f"Range of '{name}'",
            found=f"start {start}, stop {stop}, count {count}",
            expected="two different numbers and how many values to take, at least 2",
            remedy=f"Write {name}=3e3:6e3:7",
        )
    return np.linspace(start, stop, int(count)).tolist()


def _check_range(name: str, entry: Any) -> None:
    good = (
        isinstance(entry, Sequence | np.ndarray)
        and len(entry) == 2
        and all(isinstance(x, int | float | np.number) and math.isfinite(x) for x in entry)
        and entry[0] < entry[1]
    )
    if not good:
        raise ModelError(
            f"Range of '{name}'",
            found=repr(entry),
            expected="two numbers, the lower one first",
            remedy=f"Write {name}=3e3:6e3",
        )


def _values(entry: Any, where: str) -> list[Any]:
    if isinstance(entry, str) or not isinstance(entry, Iterable):
        raise ModelError(
            where,
            found=repr(entry),
            expected="a list of values",
            remedy="Write [4e3, 5e3]; a value that stays the same is a setting",
        )
    return list(entry)


def _plain(value: Any, where: str) -> Any:
    """Return a value as files can hold it."""
    if isinstance(value, np.generic):
        value = value.item()
    if not isinstance(value, bool | int | float | str) or (isinstance(value, float) and not math.isfinite(value)):
        raise ModelError(
            where,
            found=repr(value),
            expected="a finite number, a text or a boolean",
            remedy="Leave this variant out, or give it a value",
        )
    return value
