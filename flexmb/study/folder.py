"""The folder of a study: what was asked, every row as soon as it is there, and the table.

``study.json`` holds the settings, ``rows.jsonl`` one line per row in the order of completion: an interrupted study
continues where it stopped. ``results.csv`` (and ``results.parquet``) is the table.
"""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any, BinaryIO

from flexmb.errors import DataFileError
from flexmb.files import complaints, remove_parts, text_of, write_all, write_text
from flexmb.lock import Lock
from flexmb.study.plan import Plan
from flexmb.study.table import Results, Row, read_row
from flexmb.told import tell
from flexmb.whereabouts import place_of, places_for

__all__ = ["StudyFolder"]

SETTINGS, ROWS, TABLE, PARQUET, RUNS = "study.json", "rows.jsonl", "results.csv", "results.parquet", "runs"
SCHEMA, VERSION = "flexmb.study", 1
_CHANGED = {
    "model": "the model file, its fixed parameters or its reduced bodies have changed",
    "function": "the function has changed",
    "outputs": "other outputs are requested",
    "plan": "the parameters or their values have changed",
}


class StudyFolder:
    """Opens a folder for a study: a new one, or the folder of the same study, to continue it.

    Parameters
    ----------
    path : path
    plan : Plan
    identity : mapping
        Everything else that decides the results, as text or numbers.

    Raises
    ------
    DataFileError
        The folder holds something else, or a study with other settings.
    """

    def __init__(self, path: str | Path, plan: Plan, identity: Mapping[str, Any]):
        self._part = f"Study folder '{path}'"
        self.path, self.plan = Path(path).absolute(), plan  # what is computed may change the working folder
        self.runs = self.path / RUNS
        settings = {**identity, "plan": {"names": list(plan.names), "rows": [list(row) for row in plan.rows]}}
        try:
            self.path.mkdir(parents=True, exist_ok=True)
            self._lock = Lock(self.path, self._part)
        except OSError as error:
            raise self._unusable(error) from error
        try:
            self._open(settings)
        except BaseException:
            self._lock.release()
            raise

    def _open(self, settings: Mapping[str, Any]) -> None:
        """Look at what the folder holds, and open the file of the rows to add to it."""
        self._content = {"schema": SCHEMA, "schema_version": VERSION, "settings": dict(settings)}
        try:
            self._home = os.stat(self.path)
            if (self.path / SETTINGS).is_file():
                self._check(settings)
            else:
                self._begin()
            self.rows = self._stored()
            self._stream = (self.path / ROWS).open("ab", buffering=0)
        except OSError as error:
            raise self._unusable(error) from error

    def _unusable(self, error: OSError) -> DataFileError:
        return self._error(
            f"it cannot be used ({error.strerror or error})",
            "a folder that can be written",
            "Give another one with --out",
        )

    def add(self, row: Row) -> None:
        """Store a row; once this returns, it survives the end of the process."""
        with complaints(self._part, "add a row to", kept=". The rows so far are kept"):
            self._find_again()
            _add_line(self._stream, row)
            os.fsync(self._stream.fileno())
        self.rows[row.number] = row

    def _find_again(self) -> None:
        """Follow the folder where it was moved, write its rows again where it was removed, and say so."""
        place = place_of(self._stream.fileno(), self.path / ROWS)
        if place == self.path / ROWS:
            return
        before, removed = self.path, place is None
        if place is None:
            ours = self.path.is_dir() and {entry.name for entry in self.path.iterdir()} <= {RUNS}  # made by a variant
            home = os.stat(self.path) if ours else self._home
            place = next(path for path in places_for(self.path / ROWS, home) if not path.exists())
            self._write_again(place)
        self.path, self.runs, self._part = place.parent, place.parent / RUNS, f"Study folder '{place.parent}'"
        kept = f"its rows were written again in '{self.path}'" if removed else f"it is '{self.path}'"
        tell(f"Study folder '{before}' was {'removed' if removed else 'moved'} during the study: {kept}.", UserWarning)

    def _write_again(self, place: Path) -> None:
        """Write all rows to a new file and go on there. If that fails, the next row tries it once more."""
        place.parent.mkdir(parents=True, exist_ok=True)
        self._home = os.stat(place.parent)
        self._lock.release()
        self._lock = Lock(place.parent, f"Study folder '{place.parent}'")
        stream = place.open("ab", buffering=0)
        try:
            write_text(place.parent / SETTINGS, json.dumps(self._content, indent=1) + "\n")
            for row in self.rows.values():
                _add_line(stream, row)
        except BaseException:
            stream.close()
            place.unlink(missing_ok=True)
            raise
        self._stream.close()
        self._stream = stream

    def close(self, *, cut: bool = False) -> None:
        """Write the table of the rows so far.

        Of a study that is `cut` off, by an error or by Ctrl-C, as CSV alone, if there is no Parquet file: loading its
        package takes seconds, and whoever presses Ctrl-C waits for them.
        """
        try:
            with complaints(self._part, "write"):
                self._find_again()
            self._stream.close()
            results = Results(self.plan.names, list(self.rows.values()))
            results.write_csv(self.path / TABLE)
            if not cut or (self.path / PARQUET).exists():
                results.write_parquet(self.path / PARQUET)
        finally:
            self._stream.close()
            self._lock.release()

    def _begin(self) -> None:
        remove_parts(self.path)
        there = sorted(entry.name for entry in self.path.iterdir() if entry.name != self._lock.file.name)
        if there:
            raise self._error(
                f"it holds {', '.join(there[:4])}{', ...' if len(there) > 4 else ''}",
                "a new or empty folder, or the folder of the same study",
                "Give another one with --out",
            )
        write_text(self.path / SETTINGS, json.dumps(self._content, indent=1) + "\n", part=self._part)

    def _check(self, settings: Mapping[str, Any]) -> None:
        try:
            content = json.loads(text_of(self.path / SETTINGS))
            known = content["schema"] == SCHEMA and content["schema_version"] == VERSION
            stored = dict(content["settings"])
        except (ValueError, KeyError, TypeError, RecursionError) as error:
            raise self._error(f"{SETTINGS} is damaged ({error})", "what flexmb wrote", "Give another folder") from error
        if not known:
            raise self._error(
                f"{SETTINGS} has the schema {content['schema']} {content['schema_version']}",
                f"{SCHEMA} {VERSION}",
                "Give another folder with --out",
            )
        now = json.loads(json.dumps(settings))
        different = [name for name in sorted({*stored, *now}) if stored.get(name) != now.get(name)]
        if different:
            raise self._error(
                "it holds another study: "
                + "; ".join(_CHANGED.get(name) or _difference(name, stored, now) for name in different),
                "the same settings, to continue it",
                "Give another folder with --out; what was computed stays in this one",
            )

    def _stored(self) -> dict[int, Row]:
        """Return the rows by number; a line that was cut off by the end of the process is not one."""
        rows: dict[int, Row] = {}
        path = self.path / ROWS
        if not path.is_file():
            return rows
        whole = path.read_bytes()
        kept = whole[: whole.rfind(b"\n") + 1]
        if len(kept) < len(whole):
            os.truncate(path, len(kept))
        for number, line in enumerate(kept.splitlines(), 1):
            try:
                row = read_row(json.loads(line))
                if not row.parameters.keys() >= {*self.plan.names}:
                    raise ValueError(f"row {row.number} lacks parameters of the plan")
            except (ValueError, TypeError, RecursionError) as error:
                raise self._error(
                    f"line {number} of {ROWS} is damaged ({error})",
                    "rows as flexmb wrote them",
                    "Remove this line",
                ) from error
            rows[row.number] = row
        return rows

    def _error(self, found: str, expected: str, remedy: str) -> DataFileError:
        return DataFileError(self._part, found=found, expected=expected, remedy=remedy)


def _add_line(stream: BinaryIO, row: Row) -> None:
    write_all(stream, (json.dumps(row.plain()) + "\n").encode())


def _difference(name: str, stored: Mapping[str, Any], now: Mapping[str, Any]) -> str:
    return f"{name} was {stored.get(name, 'not given')}, now {now.get(name, 'not given')}"
