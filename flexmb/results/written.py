"""What a solution file holds, phase by phase: the HDF5 part, and the records added behind it since."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any, BinaryIO

import numpy as np

from flexmb import hdf5
from flexmb.results.journal import Record, records
from flexmb.results.memory import Memory

__all__ = ["FIELDS", "Written", "WrittenPhase", "add_records", "joined", "read_group", "says_of", "upto_damage"]

FIELDS = ("t", "q", "u", "a", "lam", "works")
SAMPLES, REACHED, MEMORY, PHASE, ENDED, FINISHED, GOES_ON = "SA", "RE", "ME", "PH", "EN", "FI", "GO"
"""Kinds of records: samples, the state reached after them, what the integrator knew there beside it, a phase begins, it
ends, the run ends, a run goes on."""

Rows = dict[str, np.ndarray]


@dataclass
class WrittenPhase:
    """A phase as it stands in a file.

    group: its HDF5 group, or None; own: how many rows of it count
    blocks: rows that were added, as records
    reached: the state reached after the last sample, a row that is no sample, or None
    memory: what the integrator knew beside the last row, or None
    cost: samples behind the last one that damage has cost
    tables: values of sensors by name, columns: titles of their columns
    """

    text: str
    group: Any = None
    own: int = 0
    blocks: list[Record] = field(default_factory=list)
    latest: float = -np.inf
    reached: Rows | None = None
    memory: Memory | None = None
    ended: str | None = None
    cost: int = 0
    tables: dict[str, np.ndarray] = field(default_factory=dict)
    columns: dict[str, tuple[str, ...]] = field(default_factory=dict)

    @property
    def count(self) -> int:
        """Number of samples."""
        return self.own + sum(block.says["n"] for block in self.blocks)

    @property
    def latest_time(self) -> float:
        """Time of the last sample, s; -inf without samples."""
        return float(self.group["t"][self.own - 1]) if self.own and not self.blocks else self.latest

    def add(self, block: Record, stream: BinaryIO) -> None:
        """Add a block of samples; ValueError if it has changed places: by its number, in old files by its times."""
        times = block.numbers(stream, 0, block.says["n"])
        before = self.latest_time
        follows = "serial" in block.says or np.all(np.diff(np.concatenate([[before], times])) > 0.0)
        if block.missing < 0 or not follows:
            raise ValueError(f"samples at t = {times.min():.9g} s that do not follow those up to {before:.9g} s")
        self.blocks.append(block)
        self.latest, self.reached, self.memory = float(times[-1]), None, None

    def pieces(self, stream: BinaryIO, most: int) -> Iterator[list[Rows]]:
        """Yield the samples, and the state reached after them, as lists of blocks with about so many rows in all."""
        for start in range(0, self.own, most):
            yield [_rows_of(self.group, start, min(start + most, self.own))]
        waiting: list[Rows] = []
        for block in self.blocks:
            waiting.append(_rows_in(block, stream))
            if sum(len(rows["t"]) for rows in waiting) >= most:
                yield waiting
                waiting = []
        if self.reached is not None:
            waiting.append(self.reached)
        if waiting:
            yield waiting

    def rows(self, stream: BinaryIO) -> Rows:
        """Return all rows: the samples, and the state reached after them."""
        blocks = [rows for piece in self.pieces(stream, max(self.own, 1)) for rows in piece]
        return joined(blocks) if blocks else {name: np.zeros((0, 0)[: 1 + (name != "t")]) for name in FIELDS}


@dataclass
class Written:
    """Phases, and how the run ended: status and statistics as text, None while it runs or after it was cut off.

    behind: the phases, or pieces of them, that follow a gap in the records; they are no part of the run that is read
    """

    phases: list[WrittenPhase]
    behind: list[WrittenPhase] = field(default_factory=list)
    status: str | None = None
    statistics: str = "{}"


def add_records(written: Written, stream: BinaryIO, start: int) -> None:
    """Add to `written` what the records from byte `start` on say."""
    with _sound():
        _add(written, stream, start)


@contextmanager
def _sound() -> Iterator[None]:
    """Tell of records that are whole, but not what a run writes, as of a file that cannot be read."""
    try:
        yield
    except (KeyError, TypeError, ValueError, IndexError, OverflowError, RecursionError) as error:
        raise OSError(f"a record behind the HDF5 part makes no sense: {error}") from error


def _add(written: Written, stream: BinaryIO, start: int) -> None:
    for number, record in enumerate(records(stream, start)):
        if record.missing > 0 and not written.behind:
            written.behind.append(WrittenPhase(""))
            written.status, written.statistics = None, "{}"
        if not written.behind:
            _take(written, record, stream)
        elif record.kind == PHASE:
            written.behind.append(WrittenPhase(""))
        elif record.kind == SAMPLES:
            written.behind[-1].add(record, stream)
        if record.missing < 0:
            raise ValueError(f"record {number} should stand {-record.missing} places before")


def _take(written: Written, record: Record, stream: BinaryIO) -> None:
    """Add what one record says."""
    if record.kind == PHASE:
        written.phases.append(WrittenPhase(str(record.says["model"])))
    elif record.kind == FINISHED:
        written.status, written.statistics = record.says["status"], record.says["statistics"]
    elif record.kind == GOES_ON:
        _go_on(written, record)
    elif record.kind == SAMPLES:
        written.phases[-1].add(record, stream)
    elif record.kind == REACHED:
        written.phases[-1].reached, written.phases[-1].memory = _rows_in(record, stream), None
    elif record.kind == MEMORY:
        written.phases[-1].memory = Memory(of=str(record.says["of"]), numbers=record.numbers(stream))
    elif record.kind == ENDED:
        _end(written.phases[-1], record, stream)


def _go_on(written: Written, record: Record) -> None:
    """The run goes on: in its last phase with samples, or with another one."""
    written.status, written.statistics = None, "{}"
    while written.phases and not written.phases[-1].count and written.phases[-1].reached is None:
        written.phases.pop()
    if record.says["phase"] == "last" and written.phases:
        last = written.phases[-1]
        last.ended, last.tables, last.columns = None, {}, {}


def _end(phase: WrittenPhase, record: Record, stream: BinaryIO) -> None:
    phase.ended = record.says["reason"]
    first = 0
    for table in record.says["tables"]:
        count = int(np.prod(table["shape"], dtype=int))
        phase.tables[table["name"]] = record.numbers(stream, first, count).reshape(table["shape"])
        phase.columns[table["name"]] = tuple(table["columns"])
        first += count


def read_group(group) -> WrittenPhase:
    """Return a phase of the HDF5 part."""
    # a kill of an older release between two datasets left rows of different number: what all have is complete
    own = min((len(group[name]) for name in FIELDS if name in group), default=0)
    phase = WrittenPhase(group.attrs["model"], group, own, ended=group.attrs.get("ended"))
    damaged = [hdf5.lost_rows(group[name]) for name in FIELDS if name in group]
    first = min((rows[0] for rows in damaged if rows is not None), default=own)
    if first < own:  # what stands behind it is no part of the run that is read
        phase.own, phase.ended, phase.cost = first, None, own - first
        return phase
    if group.attrs.get("cut_off", False) and own:
        phase.own -= 1
        phase.reached = _rows_of(group, own - 1, own)
    if "memory" in group:
        kept = group["memory"]
        phase.memory = Memory(of=str(kept.attrs["of"]), numbers=np.asarray(kept[()], float))
    for table in group["sensors"].values() if "sensors" in group else ():
        if hdf5.lost_rows(table) is not None:  # it follows from the samples
            continue
        phase.tables[table.attrs["name"]] = table[()]
        phase.columns[table.attrs["name"]] = tuple(json.loads(table.attrs["columns"]))
    return phase


def upto_damage(phases: list[WrittenPhase]) -> tuple[list[WrittenPhase], list[WrittenPhase]]:
    """Return the phases of the HDF5 part up to the first row that damage has cost, and what is behind it."""
    for number, phase in enumerate(phases):
        if phase.cost:
            return phases[: number + 1], [WrittenPhase("", phase.group, phase.cost), *phases[number + 1 :]]
    return phases, []


def says_of(blocks: Sequence[Rows]) -> dict[str, Any]:
    """Return what the text of a record of rows says: their number and widths."""
    return {"n": sum(len(rows["t"]) for rows in blocks), "widths": [blocks[0][name].shape[1] for name in FIELDS[1:]]}


def _rows_in(record: Record, stream: BinaryIO) -> Rows:
    with _sound():
        n, numbers = record.says["n"], record.numbers(stream)
        rows, first = {"t": numbers[:n].reshape(n)}, n
        for name, width in zip(FIELDS[1:], record.says["widths"], strict=True):
            rows[name] = numbers[first : first + n * width].reshape(n, width)
            first += n * width
        return rows


def _rows_of(group, start: int, stop: int) -> Rows:
    n = stop - start
    rows = {name: group[name][start:stop] if name in group else np.zeros((n, 0)) for name in FIELDS}
    if "t" not in group:
        rows["t"] = np.zeros(n)
    return rows


def joined(blocks: Sequence[Rows]) -> Rows:
    """Return blocks of rows as one."""
    if len(blocks) == 1:
        return blocks[0]
    with _sound():
        return {name: np.concatenate([rows[name] for rows in blocks]) for name in FIELDS}
