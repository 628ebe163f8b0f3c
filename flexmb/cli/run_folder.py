"""The run folder: the resolved model, the solution, the sensor table and the log of one simulation."""

from __future__ import annotations

import os
import platform
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import partial
from pathlib import Path
from types import TracebackType

import flexmb as fmb
from flexmb.errors import DataFileError, ModelError, did_you_mean
from flexmb.files import complaints, remove_parts, resolved
from flexmb.found import folder_in_words, no_file_because, runs_below
from flexmb.lock import Lock
from flexmb.results import STORED

__all__ = [
    "LOG",
    "MODEL",
    "SOLUTION",
    "TABLE",
    "VERIFICATION",
    "Log",
    "alone",
    "new_run",
    "open_run",
    "stored_in",
    "stored_verification",
]

MODEL, SOLUTION, TABLE, LOG = "model.toml", "solution.h5", "sensors.csv", "log.txt"
VERIFICATION = "verification.json"
MOST = 4
"""Runs that a message proposes."""


@contextmanager
def new_run(folder: Path, model_file: Path, *, overwrite: bool = False) -> Iterator[Path]:
    """Make a folder for a run, for this process alone; the files of an earlier run in it are removed if that is
    allowed.

    Raises
    ------
    ModelError
        The folder cannot be made, it holds a run that must not be overwritten, or the model file of this run.
    DataFileError
        Another process is writing it.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise ModelError(
            f"Run folder '{folder}'",
            found=f"it cannot be made ({error.strerror})",
            expected="a folder that can be written",
            remedy="Give another one with --out",
        ) from None
    with alone(folder):
        _clear(folder, model_file, overwrite)
        yield folder


@contextmanager
def alone(folder: Path) -> Iterator[None]:
    """Keep other processes from writing a run folder; what a killed one has left unfinished is removed."""
    part = f"Run folder '{folder}'"
    with complaints(part, "write"):
        lock = Lock(folder, part)
    with lock:
        remove_parts(folder)
        yield


def _clear(folder: Path, model_file: Path, overwrite: bool) -> None:
    """Remove the files of an earlier run if that is allowed."""
    if resolved(folder / MODEL) == resolved(model_file):
        raise ModelError(
            f"Run folder '{folder}'",
            found="the model file lies in it",
            expected="another folder",
            remedy="Give one with --out",
        )
    if (folder / SOLUTION).exists() and not overwrite:
        raise ModelError(
            f"Run folder '{folder}'",
            found="it holds a run",
            expected="a new folder",
            remedy="Give another one with --out, or --overwrite to replace it",
        )
    with complaints(f"Run folder '{folder}'", "clear"):
        for name in (SOLUTION, TABLE, VERIFICATION, MODEL, LOG):
            (folder / name).unlink(missing_ok=True)


def open_run(folder: str | Path, *, trust: bool = False) -> fmb.Solution:
    """Return the solution of a run folder with its model, also of a run that was cut off; for `trust` see
    `flexmb.load_model`.
    """
    folder = Path(folder)
    if not os.path.isfile(folder / SOLUTION):
        raise _no_run(folder)
    stored = fmb.Solution.load(folder / SOLUTION, read_model=partial(fmb.read_model_text, trust=trust))
    if stored.model is not None or not os.path.isfile(folder / MODEL):
        return stored
    return fmb.Solution.load(folder / SOLUTION, model=fmb.load_model(folder / MODEL, trust=trust))


def _no_run(folder: Path) -> DataFileError:
    """Return what is said of a path that is no run folder: what is there, and which folder may be meant."""
    beside = sorted(p.parent.name for p in folder.parent.glob(f"*/{SOLUTION}")) if os.path.isdir(folder.parent) else []
    inside = runs_below(folder) if os.path.isdir(folder) else []
    remedy = did_you_mean(folder.name, beside) or "Correct the path, or run the model first"
    if os.path.isdir(folder):
        kind = folder_in_words(folder)
        found = f"there is no {SOLUTION}" + ("" if kind == "a folder" else f", it is {kind}")
        if inside:
            remedy = f"Name one of the runs in it: {', '.join(inside[:MOST])}{', ...' if len(inside) > MOST else ''}"
    elif os.path.isfile(folder):
        found = "it is a file"
        if os.path.isfile(folder.parent / SOLUTION):
            found, remedy = "it is a file in a run folder", f"Name the folder: {folder.parent}"
        elif folder.suffix.lower() == ".toml":
            found, usual = "it is a model file", Path("runs") / folder.stem
            made = os.path.isfile(usual / SOLUTION)
            remedy = f"Name its run folder: {usual}" if made else f"Run it first: flexmb run {folder}"
        elif folder.suffix.lower() == ".h5":
            remedy = f"Name a folder; what a data file holds: flexmb show {folder}"
    else:
        found, known = no_file_because(folder, missing="it does not exist") or ("it is no folder", "")
        remedy = known if folder.is_symlink() or "entered" in found or "way" in found else remedy
    return DataFileError(
        f"Run folder '{folder}'",
        found=found,
        expected="a folder written by `flexmb run`" + (f"; beside it: {', '.join(beside)}" if beside else ""),
        remedy=remedy,
    )


def stored_in(solution: fmb.Solution, folder: Path) -> Path | None:
    """Return where the solution file of a run is, which may have lost its place meanwhile; None if it is nowhere."""
    stored = solution.statistics.get(STORED)
    if stored is None:
        return folder / SOLUTION
    return Path(stored) if stored else None


def stored_verification(folder: str | Path) -> fmb.Verification | None:
    """Return what `flexmb verify` has found about a run folder, or None if it was not asked."""
    path = Path(folder) / VERIFICATION
    return fmb.Verification.load(path) if path.is_file() else None


class Log:
    """Writes lines with the seconds since the start to the log file, and prints them where asked."""

    def __init__(self, path: Path, *, goes_on: bool = False):
        with complaints(f"Log '{path}'", "write"):
            self._file = path.open("a" if goes_on else "w", encoding="utf-8")
        self._start, self._lines = time.monotonic(), []
        self.line(f"{time.strftime('%Y-%m-%d %H:%M:%S')}, Python {platform.python_version()}, {platform.platform()}")

    def __enter__(self) -> Log:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if error is not None:
            self.line(f"{type(error).__name__}: {error}")
        with suppress(OSError):
            self._file.close()

    def line(self, text: str, *, show: bool = False) -> None:
        """Write a line; with `show` print it too. A full disk costs the line, not the run."""
        self._lines.append(f"[{time.monotonic() - self._start:8.2f} s] {text}\n")
        with suppress(OSError):
            self._file.write(self._lines[-1])
            self._file.flush()
        if show:
            print(text)

    def keep(self, path: Path) -> None:
        """Write the lines once more to a path where there is no log: the folder was removed meanwhile."""
        with suppress(OSError), path.open("x", encoding="utf-8") as file:
            file.writelines(self._lines)
