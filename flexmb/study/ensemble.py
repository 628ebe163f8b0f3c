"""Variants in this process: one mechanism is prepared once, its variants are computed by threads in compiled loops."""

from __future__ import annotations

import threading
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

from flexmb.errors import ModelError
from flexmb.integrate import Family
from flexmb.study.cluster import rows_by_executor
from flexmb.study.outputs import columns
from flexmb.study.processes import Pending
from flexmb.study.sources import require_end
from flexmb.study.table import Row
from flexmb.study.variants import Task, warnings_by_thread

__all__ = ["Ensemble", "require_plain", "rows_by_threads"]


class Ensemble:
    """A source of variants (see `flexmb.study.sources`) that computes them as one family.

    Parameters
    ----------
    source : ModelFile or FunctionSource
        Of models.
    """

    def __init__(self, source: Any):
        self.described, self.family = source.opened(), Family()
        self.stopped = threading.Event()

    def values(self, parameters: Mapping[str, Any], outputs: Sequence[str] | None, folder: Path | None):
        """Return the numbers of one variant."""
        model, settings = self.described(parameters)
        wanted = columns(outputs, model)
        solution = self.family.solution(model, **settings, progress=self._look)
        require_end(solution)
        return {column.title: column.value(solution) for column in wanted}

    def _look(self, t: float, t_end: float) -> None:
        """End the run if nobody waits for it any more."""
        if self.stopped.is_set():
            raise KeyboardInterrupt


def rows_by_threads(task: Task, pending: Pending, threads: int) -> Iterator[Row]:
    """Yield the row of each variant as it is done; the first goes ahead, and compiles what is missing.

    Parameters
    ----------
    task : Task
        Whose source is an `Ensemble`.
    pending : sequence of (number, parameters)
    threads : int
    """
    first, *others = pending
    yield task.row(*first)
    with warnings_by_thread(), ThreadPoolExecutor(threads, "flexmb study") as executor:
        try:
            yield from rows_by_executor(task, others, executor)
        finally:
            task.source.stopped.set()


def require_plain(**settings: Any) -> None:
    """Raise ModelError for what needs a process or a folder for every variant."""
    for name, (value, why) in settings.items():
        if value:
            raise ModelError(
                "sweep, engine 'compiled'",
                found=f"{name} is given: {why}",
                expected="variants that are computed in this process, and of which a row is kept",
                remedy=f"Leave out {name}, or leave out the engine",
            )
