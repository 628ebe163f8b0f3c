"""Collecting samples phase by phase, in memory and in the run file."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from flexmb.model.model import Model
from flexmb.results import Phase, RunFile, Solution, Status, floating_data
from flexmb.results.memory import Memory
from flexmb.results.status import STORED
from flexmb.results.written import FIELDS

__all__ = ["Recorder", "counted_on", "joined_rows"]


_BEFORE_AND_LAST = (slice(None, -1), slice(-1, None))


def counted_on(rows: dict, works: np.ndarray, mark: float, begins: bool) -> dict:
    """Return new rows with the works of the phase so far; where the run has begun just after a mark, from it on."""
    counted = {**rows, "works": rows["works"] + works}
    if begins and len(counted["t"]):
        counted["t"][0] = mark
    return counted


def joined_rows(rows: Sequence[dict[str, np.ndarray]]) -> dict[str, Any]:
    """Return blocks of rows as one block."""
    return {name: np.concatenate([block[name] for block in rows]) for name in rows[0]}


class Recorder:
    """Collects the rows of all phases and, if there is a file, writes them to it as they come.

    Parameters
    ----------
    file : path, RunFile that is open already, or None
    before : Solution, optional
        What a resumed run has computed already; with `merge` its last phase continues.
    """

    def __init__(
        self,
        model: Model,
        file,
        write_model: Callable[[Model], str] | None,
        *,
        before: Solution | None = None,
        merge: bool = False,
    ):
        self.phases: list[Phase] = [] if before is None else list(before.phases)
        self.going_on = self.phases.pop() if merge else None
        self.rows: list[dict[str, np.ndarray]] = []
        self.reached: dict[str, np.ndarray] | None = None
        self.memory: Memory | None = None
        self.latest = time.monotonic()
        self.model: Model | None = None
        self.system: Any = None
        self.write_model = write_model
        self.file = file if file is None or isinstance(file, RunFile) else RunFile(file, floating_data(model))

    def begin(self, model: Model, system) -> None:
        """Begin a phase, or continue the last one."""
        self.model, self.system, self.rows, self.reached, self.memory = model, system, [], None, None
        if self.going_on is not None:
            rows = {name: getattr(self.going_on, name) for name in FIELDS}
            if self.going_on.cut_off:  # its last row is no sample
                rows, self.reached = ({name: x[part] for name, x in rows.items()} for part in _BEFORE_AND_LAST)
            self.rows, self.memory = [rows], self.going_on.memory
        elif self.file is not None:
            self.file.begin(self.write_model(model) if self.write_model is not None else "")

    def add(self, rows: dict[str, np.ndarray]) -> None:
        """Keep a block of samples."""
        if self.going_on is not None:  # its last sample, with which the integrator begins, is there already
            new = rows["t"] > self.going_on.t[-1]
            rows = {name: x[new] for name, x in rows.items()}
        if len(rows["t"]):
            self.rows.append(rows)
            self.reached, self.memory, self.latest = None, None, time.monotonic()
            if self.file is not None:
                self.file.append(*rows.values())

    def hold(self, row: dict[str, np.ndarray], memory: Memory | None) -> None:
        """Keep the state that was reached after the last sample, and what the integrator knows there, until the next
        one; or what it knows at the last sample."""
        self.latest = time.monotonic()
        if row["t"][-1] > self.rows[-1]["t"][-1]:
            self.reached = row
            if self.file is not None:
                self.file.reached(*row.values())
        self.memory = memory
        if memory is not None and self.file is not None:
            self.file.remember(memory)

    def look(self) -> None:
        """Write what has waited for too long."""
        if self.file is not None:
            self.file.look()

    def end(self, reason: str) -> None:
        """End the phase; its sensors are stored with it."""
        if not self.rows:
            return
        rows = [*self.rows, *([] if self.reached is None else [self.reached])]
        cut_off, self.rows = self.reached is not None, []
        phase = Phase(
            model=self.model, system=self.system, ended=reason, cut_off=cut_off, memory=self.memory, **joined_rows(rows)
        )
        self.going_on = self.reached = self.memory = None
        self.phases.append(phase)
        if self.file is not None and self.model is not None:
            one = Solution(phases=(phase,))
            names = [sensor.name for sensor in self.model.sensors]
            columns = {name: one.column_titles(name) for name in names}
            self.file.end(reason, {name: one[name] for name in names}, columns)

    def close(self) -> None:
        """Close the file if it is open: what it holds stays readable."""
        if self.file is not None:
            self.file.close()

    def solution(self, status: Status, statistics: dict[str, Any]) -> Solution:
        """Return the solution of all phases and finish the file; its statistics say if that has lost its place."""
        if self.file is not None:
            self.file.finish(status, statistics)
            if self.file.lost_its_place:
                statistics = {**statistics, STORED: "" if self.file.nowhere else str(self.file.path)}
        return Solution(phases=tuple(self.phases), status=status, statistics=statistics)
