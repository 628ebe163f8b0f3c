"""Collecting samples phase by phase, in memory and in the run file."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from flexmb.model.model import Model
from flexmb.results import Phase, RunFile, Solution, Status, floating_data

__all__ = ["Recorder", "joined_rows"]


def joined_rows(rows: Sequence[dict[str, np.ndarray]]) -> dict[str, Any]:
    """Return blocks of rows as one block."""
    return {name: np.concatenate([block[name] for block in rows]) for name in rows[0]}


class Recorder:
    """Collects the rows of all phases and, if a path is given, writes them to a run file as they come."""

    def __init__(self, model: Model, path, write_model: Callable[[Model], str] | None):
        self.phases: list[Phase] = []
        self.rows: list[dict[str, np.ndarray]] = []
        self.model: Model | None = None
        self.system: Any = None
        self.write_model = write_model
        self.file = None if path is None else RunFile(path, floating_data(model))

    def begin(self, model: Model, system) -> None:
        """Begin a phase."""
        self.model, self.system, self.rows = model, system, []
        if self.file is not None:
            self.file.begin(self.write_model(model) if self.write_model is not None else "")

    def add(self, rows: dict[str, np.ndarray]) -> None:
        """Keep a block of samples."""
        if len(rows["t"]):
            self.rows.append(rows)
            if self.file is not None:
                self.file.append(*rows.values())

    def end(self, reason: str) -> None:
        """End the phase; its sensors are stored with it."""
        if not self.rows:
            return
        phase = Phase(model=self.model, system=self.system, ended=reason, **joined_rows(self.rows))
        self.phases.append(phase)
        if self.file is not None and self.model is not None:
            one = Solution(phases=(phase,))
            names = [sensor.name for sensor in self.model.sensors]
            columns = {name: one.column_titles(name) for name in names}
            self.file.end(reason, {name: one[name] for name in names}, columns)

    def solution(self, status: Status, statistics: dict[str, Any]) -> Solution:
        """Return the solution of all phases and finish the file."""
        if self.file is not None:
            self.file.finish(status, statistics)
        return Solution(phases=tuple(self.phases), status=status, statistics=statistics)
