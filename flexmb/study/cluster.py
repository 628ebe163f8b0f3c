"""Variants on any executor of `concurrent.futures`: threads, MPI, a Dask cluster."""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import Executor, as_completed
from contextlib import contextmanager

from flexmb.errors import FlexmbError
from flexmb.study.processes import Pending
from flexmb.study.table import DIED, Row
from flexmb.study.variants import Task

__all__ = ["dask_executor", "rows_by_executor"]


def rows_by_executor(task: Task, pending: Pending, executor: Executor) -> Iterator[Row]:
    """Yield the row of each variant as it is done; what the executor itself reports is a worker that died."""
    futures = {executor.submit(task.row, number, given): (number, given) for number, given in pending}
    try:
        for future in as_completed(futures):
            number, parameters = futures[future]
            try:
                yield future.result()
            except Exception as error:  # BrokenProcessPool, KilledWorker, a result that cannot be sent
                yield Row(number, parameters, DIED, error=f"{type(error).__name__}: {error}")
    finally:
        for future in futures:
            future.cancel()


@contextmanager
def dask_executor(address: str, *, timeout: float = 10.0) -> Iterator[Executor]:
    """Give an executor on a Dask cluster; model files must be readable by its workers under the same path.

    Parameters
    ----------
    address : str
        Of the scheduler, "tcp://host:8786".
    timeout : float, s
        How long to wait for the scheduler.

    Raises
    ------
    FlexmbError
        Dask is not installed, the scheduler does not answer, or it has no workers.
    """
    part = f"Dask scheduler '{address}'"
    try:
        from distributed import Client
    except ImportError as error:
        raise FlexmbError(
            part,
            found=f"the package {error.name} is not installed",
            expected="the extra 'dask'",
            remedy="pip install 'flexmb[dask]', or leave out --scheduler to use processes of this machine",
        ) from error
    try:
        client = Client(address, timeout=timeout, set_as_default=False)
    except (OSError, ValueError, TypeError, RuntimeError) as error:  # the last: encryption is required, and not offered
        raise FlexmbError(
            part,
            found=f"it cannot be reached ({str(error) or type(error).__name__})",
            expected="the address of a running scheduler",
            remedy="Start one with 'dask scheduler' and workers with 'dask worker ADDRESS --nthreads 1'",
        ) from error
    with client:
        try:
            client.wait_for_workers(1, timeout=timeout)
        except TimeoutError as error:
            raise FlexmbError(
                part,
                found=f"it has no worker after {timeout:g} s",
                expected="at least one",
                remedy=f"Start workers: dask worker {address} --nthreads 1",
            ) from error
        yield client.get_executor(pure=False)
