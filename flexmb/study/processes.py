"""Variants on processes of this machine; a process that dies costs its variant, not the study."""

from __future__ import annotations

import pickle
import time
from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from multiprocessing.connection import wait
from typing import Any

from flexmb.errors import FlexmbError
from flexmb.study.table import DIED, Row
from flexmb.study.variants import Task
from flexmb.study.worker import Worker

__all__ = ["rows_by_processes"]

QUIET = 0.5
"""Seconds without compiling after which the first worker's kernels are taken to be there: of its processor time, since
by the clock it may not have got as far as to compile."""
IDLE = 5.0
"""Seconds after which that is believed of a worker that computes nothing: it waits for something else."""
FALSE_STARTS = 2

Pending = Sequence[tuple[int, Mapping[str, Any]]]


def rows_by_processes(task: Task, pending: Pending, jobs: int, timeout: float | None) -> Iterator[Row]:
    """Yield the row of each variant as it is done.

    Parameters
    ----------
    task : Task
    pending : sequence of (number, parameters)
    jobs : int
        Processes at a time.
    timeout : float, s, or None
        A variant that takes longer is ended.

    Raises
    ------
    FlexmbError
        The processes cannot start.
    """
    crew = _Crew(pickle.dumps(task), pending, timeout)
    try:
        yield from crew.rows(min(jobs, len(pending)))
    finally:
        crew.end()


class _Crew:
    """The workers, and what is still to be done.

    The first worker goes ahead until it has stopped compiling; so kernels that are not in the cache yet are compiled
    once, and the others, which import meanwhile, read them from there.
    """

    def __init__(self, task: bytes, pending: Pending, timeout: float | None):
        self.task, self.timeout = task, timeout
        self.pending = deque(pending)
        self.workers: list[Worker] = []
        self.warm = False
        self.false_starts = 0
        self.compiled = 0.0

    def end(self) -> None:
        for worker in self.workers:
            worker.end()

    def rows(self, jobs: int) -> Iterator[Row]:
        self.workers = [Worker(self.task) for _ in range(jobs)]
        while self.pending or any(worker.number is not None for worker in self.workers):
            self._feed()
            by_pipe = {worker.pipe: worker for worker in self.workers}
            for pipe in wait(list(by_pipe), timeout=0.1):
                row = self._heard(by_pipe[pipe])  # type: ignore[index]
                if row is not None:
                    yield row
            yield from self._overdue()

    def _feed(self) -> None:
        """Give variants to the workers that wait for one."""
        now = time.monotonic()
        leader = next((worker for worker in self.workers if worker.number is not None), None)
        if leader is not None and not leader.compiling:
            quiet = now - max(leader.began, self.compiled)
            self.warm |= quiet > IDLE or (quiet > QUIET and leader.spent() - leader.spent_before > QUIET)
        for worker in self.workers:
            if not self.pending or (not self.warm and leader is not None):
                return
            if worker.ready and worker.number is None:
                number, parameters = self.pending.popleft()
                worker.number, worker.parameters, worker.began = number, parameters, now
                worker.spent_before = worker.spent()
                leader = leader or worker
                try:
                    worker.pipe.send((number, parameters))
                except OSError:  # it died while it waited; `_heard` will see its pipe's end
                    continue

    def _heard(self, worker: Worker) -> Row | None:
        """Take a message; return a row if it is one, or if the worker has died over it."""
        message = worker.receive()
        if message is None:
            return self._dead(worker, worker.cause_of_death())
        kind, content = message
        if kind == "ready":
            worker.ready, self.false_starts = True, 0
        elif kind == "compiling":
            worker.compiling, self.compiled = content, time.monotonic()
            worker.spent_before = worker.spent()
        elif kind == "useless":
            raise _cannot_start(f"the worker does not find the function to compute: {content}")
        else:
            worker.number, self.warm = None, True
            return content
        return None

    def _overdue(self) -> Iterator[Row]:
        if self.timeout is None:
            return
        now = time.monotonic()
        for worker in list(self.workers):
            if worker.number is not None and now - worker.began > self.timeout:
                row = self._dead(worker, f"it took longer than {self.timeout:g} s")
                if row is not None:
                    yield row

    def _dead(self, worker: Worker, cause: str) -> Row | None:
        """Replace a worker, and return the row of the variant it was working on."""
        worker.end()
        self.workers.remove(worker)
        if not worker.ready:
            self.false_starts += 1
            if self.false_starts >= FALSE_STARTS:
                raise _cannot_start(cause)
        if self.pending:
            self.workers.append(Worker(self.task))
        if worker.number is None:
            return None
        return Row(worker.number, worker.parameters, DIED, seconds=time.monotonic() - worker.began, error=cause)


def _cannot_start(found: str) -> FlexmbError:
    return FlexmbError(
        "Study",
        found=f"worker processes cannot start: {found}",
        expected="a function that a new Python process can import",
        remedy="In a script, call the study below 'if __name__ == \"__main__\":'; the output of the worker is above",
    )
