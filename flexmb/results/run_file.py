"""The solution file: HDF5, written while the simulation runs, readable at any time, also after a kill.

Layout (schema ``flexmb.solution``, version 1)::

    attributes      status (JSON; absent while running), statistics (JSON), bodies (JSON: body name -> data number)
    data/0 ...      modal neutral data of the floating bodies, each once
    phases/0 ...    attributes model (text), ended; datasets t, q, u, a, lam, works: one row per sample
    phases/0/sensors/0 ...   values of a sensor; attributes name, columns (JSON)

A chunk of rows is flushed as a whole; a killed process loses at most the rows that were not flushed yet.
"""

from __future__ import annotations

import json
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from flexmb import hdf5
from flexmb.errors import DataFileError
from flexmb.model import modal_neutral_file
from flexmb.results.status import Status

__all__ = ["FIELDS", "SCHEMA", "VERSION", "RunFile", "floating_data"]

SCHEMA = "flexmb.solution"
VERSION = 1
FIELDS = ("t", "q", "u", "a", "lam", "works")
ROWS = 256
"""Samples that are collected before they are written."""
ROOM = 4_000_000
"""Bytes that must be free beyond the samples that are written: started chunks and what HDF5 notes about them."""
SECONDS = 2.0
"""Collected samples are not held back longer than this."""


def floating_data(model) -> dict[str, Any]:
    """Return the modal neutral data of a model's floating bodies by body name."""
    return {body.name: body.data for body in model.bodies if hasattr(body, "reduced")}


class RunFile:
    """A solution file that is being written.

    Parameters
    ----------
    path : path
        An existing file is replaced.
    bodies : mapping of body name to ModalNeutralData
        See `floating_data`.
    rows, seconds : int, float
        Samples are written and flushed after so many rows, or so many seconds.

    Raises
    ------
    DataFileError
        The file cannot be created or the disk is full; what was flushed before stays readable.

    Examples
    --------
    ::

        with RunFile("run.h5", floating_data(model)) as run:
            run.begin(model_text)
            run.append(t, q, u, a, lam, works)      # one sample, or blocks of samples
            run.end("finished")
            run.finish(Status.finished(t), {"steps": 100})
    """

    def __init__(
        self, path: str | Path, bodies: Mapping[str, Any] | None = None, *, rows: int = ROWS, seconds: float = SECONDS
    ):
        self.path = Path(path)
        self._rows, self._seconds = rows, seconds
        self._waiting: list[tuple[np.ndarray, ...]] = []
        self._phase: Any = None
        self._n_phases = self._reserved = 0
        self._last = time.monotonic()
        self._file: Any = None
        with self._complaints("create"):
            self._file = hdf5.streaming(self.path, schema=SCHEMA, version=VERSION)
            self._write_bodies(bodies or {})
            self._file.create_group("phases")
            self._file.flush()

    @classmethod
    def continued(cls, path: str | Path, *, new_phase: bool = False) -> RunFile:
        """Open the file of a run that was cut off, to add samples to its last phase, or a `new_phase`.

        Rows that a kill left incomplete are cut away; what said how the run and its phase ended is taken back.
        """
        run = cls.__new__(cls)
        run.path, run._rows, run._seconds, run._waiting = Path(path), ROWS, SECONDS, []
        run._last, run._phase, run._reserved = time.monotonic(), None, 0
        with run._complaints("continue"):
            run._file = file = hdf5.appending(run.path, schema=SCHEMA, version=VERSION)
            for name in ("status", "statistics"):
                file.attrs.pop(name, None)
            numbers = [n for n in range(len(file["phases"])) if "t" in file["phases"][str(n)]]
            run._n_phases = 1 + max(numbers, default=-1)
            for number in range(run._n_phases, len(file["phases"])):
                del file["phases"][str(number)]  # begun, but without a sample
            if not new_phase and numbers:
                run._phase = (None, _reopened(file["phases"][str(numbers[-1])]))
            file.flush()
        return run

    def begin(self, model_text: str = "") -> None:
        """Begin a phase; `model_text` is the model as its model file."""
        self._phase = (model_text, None)

    def append(self, t, q, u, a, lam, works) -> None:
        """Add one sample (a number and vectors) or a block of samples (vector and matrices) to the phase."""
        t = np.atleast_1d(np.asarray(t, float))
        block = (t, *(np.asarray(x, float).reshape(len(t), -1) for x in (q, u, a, lam, works)))
        # copies: integrators reuse their arrays
        self._waiting.append(tuple(np.array(x) for x in block))
        waiting = sum(len(b[0]) for b in self._waiting)
        if waiting >= self._rows or time.monotonic() - self._last > self._seconds:
            self.flush()

    def flush(self) -> None:
        """Write what has been collected; after this it survives a kill."""
        if self._waiting:
            block = [np.concatenate(parts) for parts in zip(*self._waiting, strict=True)]
            self._waiting = []
            with self._complaints("write"):
                self._reserve(sum(rows.nbytes for rows in block))
                group = self._group(block)
                for name, rows in zip(FIELDS, block, strict=True):
                    if name in group:
                        data = group[name]
                        n = len(data)
                        data.resize(n + len(rows), axis=0)
                        data[n:] = rows
                self._file.flush()
        self._last = time.monotonic()

    def end(
        self,
        reason: str = "finished",
        tables: Mapping[str, np.ndarray] | None = None,
        columns: Mapping[str, Sequence[str]] | None = None,
    ) -> None:
        """End the phase: why it ended, and the values of its sensors by name with the titles of their columns."""
        self.flush()
        with self._complaints("write"):
            self._reserve(sum(np.asarray(values).nbytes for values in (tables or {}).values()))
            group = self._group([np.empty(0)] + [np.empty((0, 0))] * 5)
            group.attrs["ended"] = reason
            sensors = group.create_group("sensors")
            for number, (name, values) in enumerate((tables or {}).items()):
                table = sensors.create_dataset(str(number), data=np.asarray(values, float))
                table.attrs["name"] = name
                table.attrs["columns"] = json.dumps(list((columns or {}).get(name, ())))
            self._file.flush()
        self._phase = None

    def finish(self, status: Status, statistics: Mapping[str, Any] | None = None) -> Path:
        """Write the status, close the file and return its path."""
        if self._phase is not None:
            self.end(status.kind)
        with self._complaints("write"):
            self._file.attrs["status"] = status.to_text()
            self._file.attrs["statistics"] = json.dumps(dict(statistics or {}), default=_plain)
            self._file.flush()
        self.close()
        return self.path

    def close(self) -> None:
        """Write what is waiting and close; without `finish` the run counts as interrupted."""
        if self._file:
            try:
                self.flush()
            finally:
                self._file.close()
                self._file = None
                hdf5.shorten(self.path)

    def __enter__(self) -> RunFile:
        return self

    def __exit__(self, *exception) -> None:
        self.close()

    def _reserve(self, size: int) -> None:
        """Take space for `size` bytes unless what was taken before suffices."""
        if self._reserved < size:
            hdf5.reserve(self.path, size + ROOM)
            self._reserved = size + ROOM // 2
        self._reserved -= size

    def _group(self, block):
        """Return the group of the phase; make it when the first block tells the widths."""
        text, group = self._phase
        if group is None:
            group = self._file["phases"].create_group(str(self._n_phases))
            group.attrs["model"] = text
            for name, rows in zip(FIELDS, block, strict=True):
                width = rows.shape[1:]
                if 0 not in width:  # HDF5 has no empty chunks: a width of zero is a dataset that is not there
                    chunk = int(np.clip(8192 // max(1, *width, 1), 16, 1024))
                    group.create_dataset(
                        name, shape=(0, *width), maxshape=(None, *width), chunks=(chunk, *width), dtype=float
                    )
            self._phase = (text, group)
            self._n_phases += 1
        return group

    def _write_bodies(self, bodies):
        """Store every modal neutral data once, however many bodies are made of it."""
        numbers: dict[int, int] = {}
        store = self._file.create_group("data")
        for data in bodies.values():
            if id(data) not in numbers:
                numbers[id(data)] = len(numbers)
                modal_neutral_file.write(data, store.create_group(str(numbers[id(data)])))
        self._file.attrs["bodies"] = json.dumps({name: numbers[id(data)] for name, data in bodies.items()})

    def _complaints(self, doing: str):
        return _Complaints(self, doing)


def _reopened(group):
    """Return the group of a phase with rows of equal number, without its end and its sensors."""
    data = [group[name] for name in FIELDS if name in group]
    complete = min(len(rows) for rows in data)
    for rows in data:
        rows.resize(complete, axis=0)
    group.attrs.pop("ended", None)
    if "sensors" in group:
        del group["sensors"]
    return group


class _Complaints:
    """Turns errors of the file system into a DataFileError that says what is kept."""

    def __init__(self, run: RunFile, doing: str):
        self.run, self.doing = run, doing

    def __enter__(self):
        return self

    def __exit__(self, kind, error, trace):
        # HDF5 reports a write that failed as OSError or, from some of its functions, as RuntimeError
        if not isinstance(error, OSError | RuntimeError) or isinstance(error, DataFileError):
            return False
        kept = " What was written before stays readable." if self.doing == "write" else ""
        raise DataFileError(
            f"Solution file '{self.run.path}'",
            found=f"cannot {self.doing} it ({error})",
            expected="a writable folder with free space" + kept,
            remedy="Free space, or choose another folder for the results",
        ) from error


def _plain(value):
    return value.tolist() if hasattr(value, "tolist") else str(value)
