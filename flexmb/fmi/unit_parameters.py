"""Parameters of units that are written: numbers of parts that a host may set before the start."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from flexmb.errors import ModelError, did_you_mean, listed
from flexmb.model.described import check_mapping, is_number
from flexmb.model.model import Model

__all__ = ["PARAMETERS_FILE", "TUNABLE_FILE", "read_places", "start_values", "with_values", "write_places"]

PARAMETERS_FILE = "parameters.json"
"""Name of their file among the resources of the unit: variable to "part.field"."""
TUNABLE_FILE = "tunable.json"
"""The same of those that may be set between steps."""
FAMILIES = ("bodies", "joints", "forces", "sensors", "events", "surfaces")


def start_values(model: Model, places: Mapping[str, str]) -> dict[str, float]:
    """Return the numbers of the model by the name of the parameter.

    Parameters
    ----------
    model : Model
    places : mapping of parameter to "part.field"

    Raises
    ------
    ModelError
        There is no such part or field, or it holds no number.
    """
    check_mapping(places, "FMU", "parameters", '{"stiffness": "spring.stiffness"}')
    return {name: _value(model, name, place) for name, place in places.items()}


def _value(model: Model, name: str, place: Any) -> float:
    part, dot, field = str(place).rpartition(".")
    known = {one.name: one for family in FAMILIES for one in getattr(model, family)}
    if not dot or part not in known:
        raise ModelError(
            f"FMU, parameter '{name}'",
            found=f"'{place}'",
            expected=f"'part.field' of: {listed(part, sorted(known))}",
            remedy=did_you_mean(part, known) or 'Write parameters={"stiffness": "spring.stiffness"}',
        )
    numbers = {key: float(value) for key, value in known[part].fields().items() if is_number(value)}
    if field not in numbers:
        raise ModelError(
            f"FMU, parameter '{name}'",
            found=f"'{field}' of {known[part].title}",
            expected=f"a field that is a number: {', '.join(numbers) or 'it has none'}",
            remedy=did_you_mean(field, numbers) or "Name such a field; signals are inputs",
        )
    return numbers[field]


def with_values(model: Model, places: Mapping[str, str], values: Mapping[str, float]) -> Model:
    """Return the model with the values of its parameters."""
    for name, place in places.items():
        part, _, field = place.rpartition(".")
        model = model.changed(part, **{field: values[name]})
    return model


def write_places(folder: Path, places: Mapping[str, str], name: str = PARAMETERS_FILE) -> None:
    """Write the places of parameters into a folder of resources."""
    (folder / name).write_text(json.dumps(dict(places)), encoding="utf-8")


def read_places(folder: Path, name: str = PARAMETERS_FILE) -> dict[str, str]:
    """Return the places of parameters in a folder of resources; none if there is no such file."""
    path = folder / name
    return json.loads(path.read_text(encoding="utf-8")) if path.is_file() else {}
