"""`sweep`: a model or function, computed for every variant of a plan."""

from __future__ import annotations

import multiprocessing
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Executor
from pathlib import Path
from typing import Any, NamedTuple

from flexmb.broken_pipes import keep_broken_pipes_errors
from flexmb.errors import FlexmbError, ModelError
from flexmb.files import resolved
from flexmb.math import cores
from flexmb.model.methods import require_time_limit
from flexmb.parts.watchers import Count, watching
from flexmb.study.cluster import rows_by_executor
from flexmb.study.ensemble import Ensemble, require_plain, rows_by_threads
from flexmb.study.folder import StudyFolder
from flexmb.study.plan import Plan, grid
from flexmb.study.processes import rows_by_processes
from flexmb.study.sources import FunctionSource, ModelFile
from flexmb.study.table import DIED, DONE, Results, Row
from flexmb.study.variants import Task

__all__ = ["Progress", "sweep"]

COMPILED = "compiled"
ENGINES = ("processes", COMPILED)


class Progress(NamedTuple):
    """How far a study is: rows that are there, all rows, rows without a result, seconds left (None: not known)."""

    done: int
    total: int
    failed: int
    seconds_left: float | None


def sweep(
    source: str | Path | Callable[..., Any],
    over: Plan | Mapping[str, Sequence[Any]],
    *,
    outputs: Sequence[str] | None = None,
    parameters: Mapping[str, Any] | None = None,
    t_end: float | None = None,
    samples: int | None = None,
    time_limit: float | None = None,
    folder: str | Path | None = None,
    keep_runs: bool = False,
    trust: bool = False,
    retry: bool = False,
    jobs: int | None = None,
    timeout: float | None = None,
    executor: Executor | None = None,
    engine: str = "processes",
    progress: Callable[[Progress], None] | None = None,
) -> Results:
    """Compute every variant of a plan and return the table; a variant that fails is a row with its error.

    Parameters
    ----------
    source : path or callable
        A model file, or a function of the parameters that returns a Model, a Solution, a number, or a mapping of names
        to numbers.
    over : Plan or mapping
        `grid`, `latin_hypercube`, `listed`, `read_plan`; a mapping of parameter to values means their grid.
    outputs : sequence of str, optional
        ``"max(strut force fx)"``: see `REDUCTIONS`; ``"load = peak(strut force fx)"`` gives the column a title. By
        default max, min and final of every sensor.
    trust : bool
        May functions be imported that a model file names? See `flexmb.load_model`.
    parameters : mapping, optional
        Parameters that have the same other value in all variants.
    t_end, samples, time_limit : float, s; int; float, s; optional
        Replace the values of the model file. A variant that needs more clock time than its limit is a row that failed.
    folder : path, optional
        Where the table and all rows are stored. If it holds this very study already, only missing rows are computed.
    keep_runs : bool
        Keep a run folder for every variant, ``<folder>/runs/0001``.
    retry : bool
        Compute rows that failed once more; rows whose process died always are.
    jobs : int, optional
        Processes; as many as there are cores unless given. They have one BLAS thread each.
    timeout : float, s, optional
        Time that a variant may take on a process, which is ended then, whatever it does.
    executor : Executor, optional
        Of `concurrent.futures`, instead of processes of this machine: `dask_executor`, mpi4py's, threads.
    engine : "processes" or "compiled"
        "compiled": variants of one mechanism in this process. What does not change from variant to variant is found
        once, threads (`jobs`) run the compiled loops of the integrator side by side, and no process has to start. The
        numbers are the same. For many short runs of small mechanisms by `GeneralizedAlpha` or `Explicit`.
    progress : callable (Progress), optional
        Called after every row.

    Raises
    ------
    ModelError
        An unknown parameter, sensor or reduction, before anything is computed.
    DataFileError
        The folder holds something else, or a study with other settings.
    """
    plan = over if isinstance(over, Plan) else grid(over)
    _check(jobs, timeout, keep_runs, folder, engine)
    if engine == COMPILED:
        require_plain(
            timeout=(timeout, "threads cannot be ended"),
            keep_runs=(keep_runs, "files are written under one lock"),
            executor=(executor, "its workers would be given variants one by one"),
        )
    require_time_limit(time_limit, "Study")
    common = (dict(parameters or {}), t_end, samples, time_limit)
    origin = FunctionSource(source, *common) if callable(source) else ModelFile(str(source), *common, trust=trust)
    count = Count()
    with watching(count):  # the first variant is looked at here, and its parts are reduced for it
        origin.check(plan.names, outputs, plan.variant(0))
        kept = _opened(folder, plan, origin, outputs, keep_runs)
    known = {} if kept is None else {k: row for k, row in kept.rows.items() if not _again(row, retry)}
    pending = [(k, plan.variant(k - 1)) for k in range(1, len(plan) + 1) if k not in known]
    keep_broken_pipes_errors()  # a worker that dies must not take this process with it
    task = Task(origin, outputs, str(resolved(kept.runs)) if kept is not None and keep_runs else "")
    rows: Iterator[Row] = iter(())
    if engine == COMPILED and pending:
        rows = rows_by_threads(Task(Ensemble(origin), outputs), pending, jobs or cores())
    elif executor is not None:
        rows = rows_by_executor(task, pending, executor)
    elif pending:
        rows = rows_by_processes(task, pending, jobs or cores(), timeout)
    return _collected(rows, plan, known, kept, progress, count.reduced)


def _opened(folder, plan: Plan, origin, outputs, keep_runs: bool) -> StudyFolder | None:
    """Return the folder of the study, new or to continue."""
    if folder is None:
        return None
    asked = {"outputs": list(outputs) if outputs is not None else None, "runs": keep_runs}
    return StudyFolder(folder, plan, {**origin.identity(plan.variant(0)), **asked})


def _collected(
    rows: Iterator[Row], plan: Plan, known: dict[int, Row], kept: StudyFolder | None, progress, reduced: int
) -> Results:
    """Take the rows as they come, store and count them; `reduced` parts were made before."""
    began, first, cut = time.monotonic(), len(known), True
    try:
        if progress is not None:
            progress(_progress(known, plan, None))
        for row in rows:
            known[row.number] = row
            reduced += row.reduced
            if kept is not None:
                kept.add(row)
            if progress is not None:
                each = (time.monotonic() - began) / (len(known) - first)
                progress(_progress(known, plan, each * (len(plan) - len(known))))
        cut = False
    finally:
        close = getattr(rows, "close", None)
        if close is not None:
            close()  # ends the processes now, not when the generator is collected
        if kept is not None:
            kept.close(cut=cut)
    return Results(plan.names, list(known.values()), reduced)


def _progress(known: Mapping[int, Row], plan: Plan, left: float | None) -> Progress:
    return Progress(len(known), len(plan), sum(row.status != DONE for row in known.values()), left)


def _again(row: Row, retry: bool) -> bool:
    """A process that died says nothing about the variant, an error does."""
    return row.status == DIED or (retry and row.status != DONE)


def _check(jobs, timeout, keep_runs, folder, engine) -> None:
    if engine not in ENGINES:
        raise ModelError(
            "Study",
            found=f"engine = {engine!r}",
            expected=f"one of {', '.join(map(repr, ENGINES))}",
            remedy="Leave it out to compute the variants on processes",
        )
    if getattr(multiprocessing.current_process(), "_inheriting", False):
        raise FlexmbError(
            "Study",
            found="it is started while a worker process imports the script",
            expected="a study below 'if __name__ == \"__main__\":'",
            remedy="Put the call there: every worker imports the script once",
        )
    if jobs is not None and (isinstance(jobs, bool) or jobs != int(jobs) or jobs < 1):
        raise ModelError(
            "Study",
            found=f"jobs = {jobs!r}",
            expected="a whole number of at least 1",
            remedy="Write --jobs 2",
        )
    if timeout is not None and not timeout > 0.0:
        raise ModelError(
            "Study",
            found=f"timeout = {timeout!r} s",
            expected="a positive time",
            remedy="Write --timeout 600",
        )
    if keep_runs and folder is None:
        raise ModelError(
            "Study",
            found="run folders are to be kept, but no folder is given",
            expected="a folder",
            remedy="Give folder='runs/sweep'",
        )
