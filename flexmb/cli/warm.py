"""Compile all kernels now, on all cores, instead of when they are first used.

Examples:
  flexmb warm
  flexmb warm --into kernels                           then: NUMBA_CACHE_DIR=kernels flexmb run ...
  flexmb warm --into kernels --processor x86-64-v3     code for every processor of that level
  flexmb warm --ship                                   put such code into the package, for a wheel

What is compiled already is passed over. Compiled kernels are kept in the user's cache folder, or below NUMBA_CACHE_DIR.
"""

from __future__ import annotations

import argparse
import multiprocessing
import os
import platform
import time
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory, TemporaryFile

from flexmb.cli.progress import ProgressBar
from flexmb.ctrl_c import ctrl_c_ignored
from flexmb.errors import FlexmbError, ModelError
from flexmb.files import complaints, resolved
from flexmb.math import SWITCH, cores, ship_kernels, shipped_level

NAME = "warm"
SUMMARY = "compile all kernels now, on all cores"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--jobs", type=int, metavar="N", help="processes; default: one per core")
    parser.add_argument("--into", metavar="FOLDER", help="keep the kernels below this folder")
    parser.add_argument(
        "--processor", metavar="NAME", help="compile for this processor instead of the one that runs, as x86-64-v3"
    )
    parser.add_argument(
        "--ship", action="store_true", help="compile for all usual processors, into the folder of the package"
    )


def execute(arguments: argparse.Namespace) -> int:
    jobs = cores() if arguments.jobs is None else arguments.jobs
    if jobs < 1:
        raise ModelError(
            "flexmb warm",
            found=f"--jobs {jobs}",
            expected="a number of processes, 1 or more",
            remedy="Omit it for one per core",
        )
    if arguments.into:
        _require_folder(arguments.into)
    began = time.perf_counter()
    if arguments.ship:
        count = _ship(jobs, arguments)
    else:
        with _environment(arguments.into, arguments.processor):
            count = _in_processes(jobs)
    print(f"{count} kernels and analyses are ready, {time.perf_counter() - began:.0f} s on {jobs} cores")
    return 0


def _ship(jobs: int, arguments: argparse.Namespace) -> int:
    """Compile for the baseline of this architecture and put the kernels into the package."""
    level = shipped_level()
    if not level or arguments.into or arguments.processor:
        raise ModelError(
            "flexmb warm --ship",
            found=f"architecture {platform.machine()}" if not level else "--into or --processor",
            expected="one of x86_64, aarch64, and no other folder or processor",
            remedy="Use --into and --processor without --ship",
        )
    with TemporaryDirectory(prefix="flexmb-kernels-") as folder:
        with _environment(folder, level):
            count = _in_processes(jobs)
        ship_kernels(Path(folder) / "flexmb")
    return count


@contextmanager
def _environment(into: str | None, processor: str | None) -> Iterator[None]:
    """Let the processes that are started meanwhile compile for a processor and keep kernels below a folder."""
    wanted = {"NUMBA_CACHE_DIR": str(resolved(into))} if into else {}
    wanted |= {"NUMBA_CPU_NAME": processor, "NUMBA_CPU_FEATURES": ""} if processor else {}
    wanted |= {name: os.environ.get(name, "1") for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS")}
    wanted[SWITCH] = "0"  # all cores are in use
    before = {name: os.environ.get(name) for name in wanted}
    os.environ.update(wanted)
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name)
            else:
                os.environ[name] = value


def _in_processes(jobs: int) -> int:
    """Compile the declared kernels in equal shares, then what each analysis needs beyond them; return the number."""
    from flexmb.cli.warm_models import ANALYSES

    tasks = len(ANALYSES) + jobs
    count = 0
    with _complete(), ProgressBar() as progress, _pool(jobs) as pool:
        done = 0
        with ctrl_c_ignored():
            declared = [pool.submit(_declared, part, jobs) for part in range(jobs)]
            analyses = [pool.submit(_analysis, name) for name in ANALYSES]
        for wave in (declared, analyses):
            for one in as_completed(wave):
                done += 1
                count += one.result()
                progress("compiling kernels", done / tasks)
    return count


@contextmanager
def _pool(jobs: int) -> Iterator[ProcessPoolExecutor]:
    """Give processes that compile; an interruption ends them at once, who finish their share would take minutes."""
    others = set(multiprocessing.active_children())
    pool = ProcessPoolExecutor(jobs, mp_context=multiprocessing.get_context("spawn"))
    try:
        yield pool
    except BaseException:
        for child in set(multiprocessing.active_children()) - others:
            child.kill()
        raise
    finally:
        pool.shutdown(cancel_futures=True)


@contextmanager
def _complete() -> Iterator[None]:
    """Say it if a process that compiles is ended from outside."""
    try:
        yield
    except BrokenProcessPool:
        raise FlexmbError(
            "flexmb warm",
            found="a process that compiles was ended, often because memory ran out",
            expected="about 1 GB for each process",
            remedy="Use --jobs 1; what was compiled until then is kept",
        ) from None


def _require_folder(into: str) -> None:
    """Raise DataFileError unless kernels can be kept below a folder: compiling takes minutes."""
    with complaints(f"Folder '{into}'", "write into"):
        resolved(into).mkdir(parents=True, exist_ok=True)
        with TemporaryFile(dir=resolved(into)) as file:
            file.write(bytes(1 << 16))


def _declared(part: int, parts: int) -> int:
    from flexmb.math import compile_declared

    return compile_declared("flexmb", part, parts)


def _analysis(name: str) -> int:
    from flexmb.cli.warm_models import ANALYSES

    ANALYSES[name]()
    return 1
