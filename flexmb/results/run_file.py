"""The solution file: HDF5, readable at any time, also while the simulation runs and after a kill at any moment.

While the simulation runs, what comes is added behind the end of the HDF5 part as records (`flexmb.results.journal`);
nothing that is there is written again. When the file is closed they become part of a new HDF5 file, which replaces this
one in one go. A killed process loses at most what it still held in memory.
"""

from __future__ import annotations

import json
import os
import time
import warnings
from collections.abc import Mapping, Sequence
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np

from flexmb import hdf5
from flexmb.errors import DataFileError
from flexmb.files import check_folder, complaints
from flexmb.lock import Lock
from flexmb.results.hdf5_part import SCHEMA, VERSION, fold, write_bodies
from flexmb.results.journal import Journal
from flexmb.results.memory import Memory
from flexmb.results.status import Status
from flexmb.results.written import (
    ENDED,
    FIELDS,
    FINISHED,
    GOES_ON,
    MEMORY,
    PHASE,
    REACHED,
    SAMPLES,
    says_of,
)
from flexmb.told import tell
from flexmb.whereabouts import places_for

__all__ = ["RunFile", "floating_data"]

ROWS = 256
"""Samples that are collected before they are written."""
SECONDS = 2.0
"""Collected samples are not held back longer than this."""
TRIES = 100
"""Names that are tried for a file that was removed while it was written."""


def floating_data(model) -> dict[str, Any]:
    """Return the modal neutral data of a model's floating bodies by body name."""
    return {body.name: body.data for body in model.bodies if body.reduced is not None}


class RunFile:
    """A solution file that is being written.

    Parameters
    ----------
    path : path
        An existing file is replaced.
    bodies : mapping of body name to ModalNeutralData
        See `floating_data`.
    rows, seconds : int, float
        Samples are written after so many rows, or so many seconds.
    part : str
        How messages call it; "Solution file 'path'" unless given.

    Raises
    ------
    DataFileError
        The file cannot be created, another run is writing it, or the disk is full; what was written stays readable.

    Examples
    --------
    ::

        with RunFile("run.h5", floating_data(model)) as run:
            run.begin(model_text)
            run.append(t, q, u, a, lam, works)      # one sample, or blocks of samples
            run.end("finished")
            run.finish(Status.finished(t), {"steps": 100})
    """

    _part: str
    _lock: Lock
    _journal: Journal | None = None
    lost_its_place: bool = False
    """Was the file removed, moved or replaced while it was written? `path` is where it is now, if not `nowhere`."""
    nowhere: bool = False

    def __init__(
        self,
        path: str | Path,
        bodies: Mapping[str, Any] | None = None,
        *,
        rows: int = ROWS,
        seconds: float = SECONDS,
        part: str = "",
    ):
        self._open(path, rows, seconds, "create")
        self._part = part or self._part
        try:
            with hdf5.writing(self.path, schema=SCHEMA, version=VERSION, part=self._part, doing="create") as file:
                write_bodies(file, bodies or {})
                file.create_group("phases")
            with complaints(self._part, "create"):
                self._journal = Journal(self.path)
        except BaseException:
            self._lock.release()
            raise

    @classmethod
    def continued(cls, path: str | Path, *, new_phase: bool = False) -> RunFile:
        """Open the file of a run that was cut off, to add samples to its last phase, or a `new_phase`.

        What said how the run and its phase ended is taken back.
        """
        run = cls.__new__(cls)
        run._open(path, ROWS, SECONDS, "continue")
        try:
            with hdf5.reading(run.path, schema=SCHEMA, version=VERSION):
                pass
            if hdf5.is_damaged(run.path):  # what was lost, and what stands behind it, is computed again
                fold(run.path, run._part, behind_too=True)
            with complaints(run._part, "continue"):
                run._journal = Journal(run.path)
                run._journal.add(GOES_ON, {"phase": "new" if new_phase else "last"})
        except BaseException:
            run._lock.release()
            raise
        run._phase = not new_phase
        return run

    def _open(self, path: str | Path, rows: int, seconds: float, doing: str) -> None:
        self._part = f"Solution file '{path}'"
        check_folder(Path(path), self._part)
        # absolute, as the program may change its working folder meanwhile
        self.path, self._rows, self._seconds = Path(path).absolute(), rows, seconds
        self._waiting: list[dict[str, np.ndarray]] = []
        self._phase = False
        self._last = self._tried = time.monotonic()
        with complaints(self._part, doing):
            self._home = os.stat(self.path.parent)
            self._lock = Lock(self.path, self._part)

    def begin(self, model_text: str = "") -> None:
        """Begin a phase; `model_text` is the model as its model file."""
        self._add(PHASE, {"model": model_text})
        self._phase = True

    def append(self, t, q, u, a, lam, works) -> None:
        """Add one sample (a number and vectors) or a block of samples (vector and matrices) to the phase."""
        self._waiting.append(_block(t, q, u, a, lam, works))
        if sum(len(rows["t"]) for rows in self._waiting) >= self._rows:
            self.flush()
        else:
            self.look()

    def look(self) -> None:
        """Write what has been held back for too long; to be called now and then while no samples come."""
        if time.monotonic() - self._last > self._seconds:
            self.flush()

    def reached(self, t, q, u, a, lam, works) -> None:
        """Note the state that was reached after the last sample: with the next sample it is forgotten."""
        self.flush()
        block = _block(t, q, u, a, lam, works)
        self._add(REACHED, says_of([block]), list(block.values()))

    def remember(self, memory: Memory) -> None:
        """Note what the integrator knows beside the last sample, or the state reached after it: forgotten likewise."""
        self.flush()
        self._add(MEMORY, {"of": memory.of}, [memory.numbers])

    def flush(self) -> None:
        """Write what has been collected; after this it survives a kill."""
        if self._waiting:
            self._add(SAMPLES, says_of(self._waiting), [rows[name] for name in FIELDS for rows in self._waiting])
            self._waiting = []  # not before: what could not be written is tried once more when the file is closed
        self._last = time.monotonic()

    def end(
        self,
        reason: str = "finished",
        tables: Mapping[str, np.ndarray] | None = None,
        columns: Mapping[str, Sequence[str]] | None = None,
    ) -> None:
        """End the phase: why it ended, and the values of its sensors by name with the titles of their columns."""
        self.flush()
        values = {name: np.asarray(x, float) for name, x in (tables or {}).items()}
        says = [
            {"name": name, "columns": list((columns or {}).get(name, ())), "shape": list(x.shape)}
            for name, x in values.items()
        ]
        self._add(ENDED, {"reason": reason, "tables": says}, list(values.values()))
        self._phase = False

    def finish(self, status: Status, statistics: Mapping[str, Any] | None = None) -> Path:
        """Write the status, close the file and return its path."""
        if self._phase:
            self.end(status.kind)
        text = json.dumps(dict(statistics or {}), default=_plain)
        self._add(FINISHED, {"status": status.to_text(), "statistics": text})
        self.close()
        return self.path

    def close(self) -> None:
        """Write what is waiting and close; without `finish` the run counts as interrupted."""
        if self._journal is None:
            return
        try:
            self.flush()
        finally:
            try:
                self._complete()
            finally:
                self._journal.close()
                self._journal = None
                self._lock.release()

    def _complete(self) -> None:
        """Make the file one HDF5 file; what cannot be done costs nothing, since records are read as well."""
        assert self._journal is not None
        self._find_again()
        if os.name == "nt":  # no open file can be replaced there, or removed
            self._journal.close()
        for last in (False, True):
            if self.nowhere:
                return
            try:
                fold(self.path, self._part)
                return
            except (DataFileError, MemoryError) as error:
                if last or self._journal.place(self.path) == self.path:
                    # nothing is lost: what was written is there, and is read as well from the records
                    warnings.warn(f"{error} The file stays as it is, with every sample that is in it.", stacklevel=3)
                    return
                self._find_again()  # it was removed in this moment

    def _find_again(self) -> None:
        """Look where the file is: follow it where it was moved, write it again where it was removed, and say so."""
        assert self._journal is not None
        before, place = self.path, self._journal.place(self.path)
        if place == self.path or (self.nowhere and time.monotonic() - self._tried < SECONDS):
            return
        moved, problem, was_nowhere = place is not None, "", self.nowhere
        if place is None:
            place, problem = self._written_again()
        self.lost_its_place, self.nowhere = True, place is None
        if place is not None:
            kept = f"it {'is' if moved else 'was written again, with every sample, as'} '{place}'"
            self.path, self._part = place, self._part.replace(str(before), str(place))
        elif was_nowhere:
            return
        else:
            kept = f"it could not be written again ({problem}), so its samples are in this process alone"
        tell(
            f"Solution file '{before}' was {'moved' if moved else 'removed'} while it was written: {kept}.", UserWarning
        )

    def _written_again(self) -> tuple[Path | None, str]:
        """Write the file that has no name any more, and lock it; return its path, or None and the reason."""
        assert self._journal is not None
        self._tried = time.monotonic()
        self._lock.release()  # that of a file which is not there
        for place in islice(places_for(self.path, self._home), TRIES):
            try:
                place.parent.mkdir(parents=True, exist_ok=True)
                self._lock = Lock(place, self._part)
                self._journal.copy_to(place)
            except (FileExistsError, NotADirectoryError, DataFileError):  # another one is there, or writes there
                self._lock.release()
                continue
            except OSError as error:
                self._lock.release()
                return None, error.strerror or str(error)
            self._home = os.stat(place.parent)
            return place, ""
        return None, "no name is free"

    def __enter__(self) -> RunFile:
        return self

    def __exit__(self, *exception) -> None:
        self.close()

    def _add(self, kind: str, says: Mapping[str, Any], numbers: Sequence[np.ndarray] = ()) -> None:
        with complaints(self._part, "write", kept=". What was written before stays readable"):
            if self._journal is None:
                raise OSError("it is closed")
            self._journal.add(kind, says, numbers)
        self._find_again()


def _block(t, *others) -> dict[str, np.ndarray]:
    """Return samples by name, as copies: integrators reuse their arrays."""
    t = np.array(np.atleast_1d(t), float)
    return {
        "t": t,
        **{name: np.array(x, float).reshape(len(t), -1) for name, x in zip(FIELDS[1:], others, strict=True)},
    }


def _plain(value):
    return value.tolist() if hasattr(value, "tolist") else str(value)
