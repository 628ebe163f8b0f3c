"""Reading a solution file, complete or cut off."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from flexmb import hdf5
from flexmb.errors import DataFileError, did_you_mean
from flexmb.model import modal_neutral_file
from flexmb.results.phase import Phase
from flexmb.results.run_file import FIELDS, SCHEMA, VERSION
from flexmb.results.status import Status

__all__ = ["read_solution_file", "stored_body"]


def read_solution_file(path: str | Path, *, model=None, read_model: Callable[[str, dict], Any] | None = None):
    """Read a solution file.

    Parameters
    ----------
    path : path
    model : Model or sequence of Models, one per phase, optional
    read_model : callable (text, {body name: ModalNeutralData}) -> Model, optional
        Makes the model of a phase from the text in the file, if `model` is not given.

    Returns
    -------
    phases, status, statistics, columns
        `columns` maps sensor names to the titles of their columns.

    Raises
    ------
    DataFileError
        Missing, foreign, truncated, or of another version; or no phase has a sample.
    """
    with hdf5.reading(path, schema=SCHEMA, version=VERSION) as file:
        bodies = _read_bodies(file) if model is None and read_model is not None else {}
        phases, columns = [], {}
        for number in range(len(file["phases"])):
            group = file["phases"][str(number)]
            own = _model_of(model, number, group.attrs["model"], read_model, bodies)
            phases.append(_read_phase(group, own, columns))
        status = Status.from_text(file.attrs["status"]) if "status" in file.attrs else None
        statistics = json.loads(file.attrs.get("statistics", "{}"))
    phases = [phase for phase in phases if len(phase.t)]
    if not phases:
        raise DataFileError(
            f"Solution file '{path}'",
            found="there are no samples",
            expected="at least one",
            remedy="The run was cut off before its first sample: run it again",
        )
    return tuple(phases), status or Status.interrupted(float(phases[-1].t[-1])), statistics, columns


def stored_body(path: str | Path, body: str):
    """Return the ModalNeutralData of one body of a solution file; DataFileError if the file or the body is missing."""
    with hdf5.reading(path, schema=SCHEMA, version=VERSION) as file:
        numbers = json.loads(file.attrs["bodies"])
        if body not in numbers:
            raise DataFileError(
                f"Solution file '{path}'",
                found=f"there is no body '{body}'",
                expected=f"One of: {', '.join(numbers) or 'none'}",
                remedy=did_you_mean(body, numbers) or "Name a body of the run",
            )
        return modal_neutral_file.read(file["data"][str(numbers[body])])


def _read_bodies(file):
    loaded: dict[int, Any] = {}
    bodies = {}
    for name, number in json.loads(file.attrs["bodies"]).items():
        if number not in loaded:
            loaded[number] = modal_neutral_file.read(file["data"][str(number)])
        bodies[name] = loaded[number]
    return bodies


def _model_of(model, number, text, read_model, bodies):
    if isinstance(model, list | tuple):
        return model[min(number, len(model) - 1)]
    if model is not None:
        return model
    return read_model(text, bodies) if read_model is not None and text else None


def _read_phase(group, model, columns) -> Phase:
    # a kill between two datasets leaves rows of different number: what all of them have is complete
    nt = min((len(group[name]) for name in FIELDS if name in group), default=0)
    rows = {name: group[name][:nt] if name in group else np.zeros((nt, 0)) for name in FIELDS}
    if "t" not in group:
        rows["t"] = np.zeros(nt)
    tables = {}
    for table in group["sensors"].values() if "sensors" in group else ():
        tables[table.attrs["name"]] = table[()]
        columns[table.attrs["name"]] = tuple(json.loads(table.attrs["columns"]))
    return Phase(model=model, ended=group.attrs.get("ended", "interrupted"), tables=tables, **rows)
