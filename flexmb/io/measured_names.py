"""Sensors that the signals of a model file follow: a name that no sensor has is told with its table and field."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from flexmb.errors import ModelError
from flexmb.model.model import Model
from flexmb.model.sensor_columns import found_in, not_found_in

__all__ = ["check_measured"]


def check_measured(raw: Any, where: str, model: Model) -> None:
    """Raise ModelError if ``{ measured = "x" }`` somewhere in a table of a file names none of the sensors or columns.

    This is for the file that is loaded. Within the file of an assembly the sensor may be one of the file around it: a
    name that no sensor has is told there when the model is checked or simulated, with the part that follows it
    ("Force 'left_push': sensor 'tipp' does not exist"), not with file and table.
    """
    for name, place in _named(raw, where):
        if not name.lstrip().startswith("=") and found_in(model, name) is None:
            said = not_found_in(model, name)
            raise ModelError(
                place,
                found=said.found,
                expected=said.expected,
                remedy=said.remedy or "Add the sensor to the model",
            )


def _named(raw: Any, where: str) -> Iterator[tuple[str, str]]:
    """Yield the names that are measured within a value, and their places."""
    if isinstance(raw, list):
        for entry in raw:
            yield from _named(entry, where)
    elif isinstance(raw, dict):
        for field, entry in raw.items():
            place = f"{where}, {field}"
            if field == "measured" and len(raw) == 1:
                name = entry.get("of") if isinstance(entry, dict) else entry
                if isinstance(name, str):
                    yield name, place
            elif field == "formula" and isinstance(entry, dict) and isinstance(entry.get("over"), dict):
                for own, given in entry["over"].items():
                    yield from [(given, f"{place}, over.{own}")] if isinstance(given, str) else _named(given, place)
            else:
                yield from _named(entry, place)
