"""Reading a solution file, complete or cut off."""

from __future__ import annotations

import json
import os
import warnings
from collections.abc import Callable
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from flexmb import hdf5
from flexmb.errors import DataFileError, did_you_mean
from flexmb.lock import holder
from flexmb.model import modal_neutral_file
from flexmb.model.modal_neutral_data import ModalNeutralData
from flexmb.results.hdf5_part import SCHEMA, VERSION, read_written
from flexmb.results.phase import INPUTS, Phase
from flexmb.results.status import SHARED, Status
from flexmb.results.written import Written, WrittenPhase

__all__ = ["read_solution_file", "stored_body", "stored_samples"]


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

    Warns
    -----
    UserWarning
        Samples follow a gap: part of the file was dropped or damaged. They are left out, and the run counts as
        interrupted at the gap.
    """
    with _opened(path) as (file, stream):
        bodies = _read_bodies(file) if model is None and read_model is not None else {}
        phases, columns = [], {}
        written = read_written(file, stream)
        for number, phase in enumerate(written.phases):
            own = _model_of(model, number, phase.text, read_model, bodies)
            phases.append(_read_phase(phase, stream, own))
            columns.update(phase.columns)
        status = Status.from_text(written.status) if written.status is not None else None
        statistics, lost = _statistics(written.statistics), _lost(written)
    phases = [phase for phase in phases if len(phase.t)]
    running = holder(path)
    if not phases:
        raise DataFileError(
            f"Solution file '{path}'",
            found=f"there are no samples{f' ({lost})' if lost else ''}",
            expected="at least one",
            remedy="Copy the file once more from where it was written, or run the model again"
            if lost
            else f"The run has not come to its first sample yet: {running} is writing it"
            if running
            else "The run was cut off before its first sample: run it again",
        )
    if lost:
        remedy = "Copy the file once more from where it was written; `flexmb resume` computes what is missing again"
        warnings.warn(f"Solution file '{path}': {lost}. {remedy}.", stacklevel=3)
        status = Status("interrupted", lost, remedy)
    if status is None:
        t = float(phases[-1].t[-1])
        status = Status.running(t, running) if running else Status.interrupted(t)
    return tuple(phases), status, statistics, columns


def _statistics(text: str) -> dict[str, Any]:
    """Return the statistics of a run; ValueError where lists of sentences and names are something else.

    Numbers that are none are left out: what was not counted, a resumed run cannot count on.
    """
    found = json.loads(text)
    if not isinstance(found, dict):
        raise ValueError("its statistics are no table")
    for name in ("warnings", "notes", SHARED):
        if not (isinstance(found.get(name, []), list) and all(isinstance(one, str) for one in found.get(name, []))):
            raise ValueError(f"its statistics have '{name}' that are no texts")
    return {name: value for name, value in found.items() if _is_statistic(name, value)}


def _is_statistic(name: str, value: Any) -> bool:
    """Is this what a run writes: integers of 64 bits, shares by body and measure?"""
    if name == "share of validity":
        return isinstance(value, dict) and all(isinstance(measures, dict) for measures in value.values())
    if name == "errors of reactions":
        return isinstance(value, dict) and all(isinstance(share, float) for share in value.values())
    return value is not None and not (isinstance(value, int) and abs(value) >= 2**63)


def _lost(written: Written) -> str:
    """Return what is known of the samples behind a gap in the records; empty if there is none."""
    if not written.behind:
        return ""
    last = next((phase.latest_time for phase in reversed(written.phases) if phase.count), None)
    count = sum(phase.count for phase in written.behind)
    return (
        f"part of the file is missing or damaged {'at its start' if last is None else f'behind t = {last:.9g} s'}, and "
        f"{count} samples that follow there are left out"
    )


@contextmanager
def _opened(path: str | Path):
    """Open a solution file as HDF5 and as bytes; between the two openings a run that ends may replace it."""
    while True:
        before = os.stat(path) if os.path.exists(path) else None
        with hdf5.reading(path, schema=SCHEMA, version=VERSION) as file, Path(path).open("rb") as stream:
            if before is None or os.path.samestat(before, os.fstat(stream.fileno())):
                yield file, stream
                return


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
        return modal_neutral_file.read(file["data"][str(numbers[body])], ModalNeutralData)


def stored_samples(path: str | Path) -> int:
    """Return how many samples a solution file holds; DataFileError if it cannot be read."""
    with _opened(path) as (file, stream):
        written = read_written(file, stream)
        return sum(phase.count for phase in (*written.phases, *written.behind))


def _read_bodies(file):
    loaded: dict[int, Any] = {}
    bodies = {}
    for name, number in json.loads(file.attrs["bodies"]).items():
        if number not in loaded:
            loaded[number] = modal_neutral_file.read(file["data"][str(number)], ModalNeutralData)
        bodies[name] = loaded[number]
    return bodies


def _model_of(model, number, text, read_model, bodies):
    if isinstance(model, list | tuple):
        return model[min(number, len(model) - 1)]
    if model is not None:
        return model
    return read_model(text, bodies) if read_model is not None and text else None


def _read_phase(phase: WrittenPhase, stream, model) -> Phase:
    """Return a phase with its rows; "interrupted" where nothing says how it ended."""
    tables, rows = dict(phase.tables), phase.rows(stream)
    for name in ("t", "q", "u"):
        if not np.all(np.isfinite(rows[name])):
            raise ValueError(f"samples whose {name} are no numbers")
    return Phase(
        model=model,
        ended=phase.ended or "interrupted",
        inputs=tables.pop(INPUTS, None),
        tables=tables,
        cut_off=phase.reached is not None,
        memory=phase.memory,
        **rows,
    )
