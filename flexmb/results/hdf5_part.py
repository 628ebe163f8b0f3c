"""The HDF5 part of a solution file: what of a run is complete.

Layout (schema ``flexmb.solution``, version 1)::

    attributes      status (JSON; absent of a run that was cut off), statistics (JSON), bodies (JSON: body name ->
                    data number)
    data/0 ...      modal neutral data of the floating bodies, each once
    phases/0 ...    attributes model (text), ended, cut_off (the last row is no sample, but how far the run came when
                    it was interrupted); datasets t, q, u, a, lam, works: one row per sample
    phases/0/memory what the integrator knew beside the last row, where the run was interrupted
    phases/0/sensors/0 ...   values of a sensor; attributes name, columns (JSON)
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from flexmb import hdf5
from flexmb.errors import DataFileError
from flexmb.model import modal_neutral_file
from flexmb.results.written import Written, add_records, joined, read_group, upto_damage

__all__ = ["SCHEMA", "VERSION", "fold", "read_written", "write_bodies"]

SCHEMA = "flexmb.solution"
VERSION = 1
PIECE = 8192
"""Rows that are copied at a time."""


def read_written(file, stream) -> Written:
    """Return what a solution file holds, from its open HDF5 part and a binary stream of the same file."""
    groups = [file["phases"][str(number)] for number in range(len(file["phases"]))]
    written = Written(*upto_damage([read_group(group) for group in groups]))
    if "status" in file.attrs and not written.behind:
        written.status, written.statistics = file.attrs["status"], file.attrs.get("statistics", "{}")
    add_records(written, stream, hdf5.end_of(stream.name))
    return written


def write_bodies(file, bodies: Mapping[str, Any]) -> None:
    """Store every modal neutral data once, however many bodies are made of it."""
    numbers: dict[int, int] = {}
    store = file.create_group("data")
    for data in bodies.values():
        if id(data) not in numbers:
            numbers[id(data)] = len(numbers)
            modal_neutral_file.write(data, store.create_group(str(numbers[id(data)])))
    file.attrs["bodies"] = json.dumps({name: numbers[id(data)] for name, data in bodies.items()})


def fold(path: Path, part: str, behind_too: bool = False) -> None:
    """Make the records behind the HDF5 part of a solution file part of it; what stands behind damage is an error, or
    is left out.
    """
    with hdf5.writing(path, schema=SCHEMA, version=VERSION, part=part, doing="complete") as file:  # noqa: SIM117
        # closed before the new file takes the place: Windows would refuse
        with hdf5.reading(path, schema=SCHEMA, version=VERSION) as old, path.open("rb") as stream:
            written = read_written(old, stream)
            if written.behind and not behind_too:  # whoever saves the rest of the file finds the samples behind the gap
                raise DataFileError(
                    part,
                    found="records that were written during the run are missing or damaged",
                    expected="a file that nothing else changes",
                    remedy="Look after the disk; reading the file tells how many samples are lost",
                )
            file.attrs["bodies"] = old.attrs["bodies"]
            old.copy("data", file)
            phases = file.create_group("phases")
            for phase in written.phases:
                _write_phase(phases.create_group(str(len(phases))), phase, stream)
            if written.status is not None:
                file.attrs["status"], file.attrs["statistics"] = written.status, written.statistics


def _write_phase(group, phase, stream) -> None:
    """Write a phase into its group: samples as datasets, and what is said about them."""
    group.attrs["model"] = phase.text
    if phase.ended is not None:
        group.attrs["ended"] = phase.ended
    if phase.reached is not None:
        group.attrs["cut_off"] = True
    if phase.memory is not None:
        group.create_dataset("memory", data=phase.memory.numbers).attrs["of"] = phase.memory.of
    count, done = phase.count + (phase.reached is not None), 0
    for piece in phase.pieces(stream, PIECE):
        rows = joined(piece)
        for name, values in rows.items():
            width = values.shape[1:]
            if 0 in width:  # a width of zero is a dataset that is not there
                continue
            if name not in group:
                group.create_dataset(name, shape=(count, *width), dtype=float)
            group[name][done : done + len(values)] = values
        done += len(rows["t"])
    sensors = group.create_group("sensors")
    for number, (name, values) in enumerate(phase.tables.items()):
        table = sensors.create_dataset(str(number), data=values)
        table.attrs["name"] = name
        table.attrs["columns"] = json.dumps(phase.columns.get(name, ()))
