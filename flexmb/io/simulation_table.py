"""The table ``[simulation]`` of a model file."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from flexmb.errors import ModelError, did_you_mean
from flexmb.io import kind_lists
from flexmb.io.field_values import Context, call, find_kind
from flexmb.io.file_parameters import resolve
from flexmb.io.simulation_settings import Simulation

__all__ = ["simulation_of"]


def simulation_of(tables: dict[str, Any], path: Path, parameters, own: Mapping[str, Any]) -> Simulation:
    """Return the settings of a file's tables; what is given in `own` replaces them."""
    where = f"{path.name}, [simulation]"
    own = {name: value for name, value in own.items() if value is not None}
    raw = tables.get("simulation", {})
    if not isinstance(raw, dict) or not (raw or "t_end" in own):
        raise ModelError(
            where,
            found="the table is missing",
            expected="the table [simulation] with t_end",
            remedy="Add [simulation] and t_end = 1.0, or give the end time otherwise",
        )
    integrators = kind_lists.integrators()
    kinds = {**kind_lists.values(), **integrators, **kind_lists.formulations()}
    context = Context(path, resolve(tables, parameters, path.name), kinds)
    values = {
        name: entry if name == "integrator" else context.value(entry, f"{where}, {name}") for name, entry in raw.items()
    }
    if "integrator" in values:
        values["integrator"] = _integrator(values["integrator"], context, integrators, f"{where}, integrator")
    return call(Simulation, {**values, **own}, where)


def _integrator(raw: Any, context: Context, integrators: Mapping[str, type], where: str) -> Any:
    """Return the integrator that is named, or described by a table with ``kind``."""
    given = dict(raw) if isinstance(raw, dict) else {"kind": raw}
    if not isinstance(given.get("kind"), str):
        word = next(iter(given), "") if "kind" not in given else ""
        raise ModelError(
            where,
            found="the field 'kind' is missing" if "kind" not in given else repr(raw),
            expected=f"One of: {', '.join(integrators)}, as a text or in a table with its settings",
            remedy=did_you_mean(word, integrators)
            if word not in integrators and did_you_mean(word, integrators)
            else f'Write integrator = {{ kind = "{word if word in integrators else "GeneralizedAlpha"}", ... }}',
        )
    make = find_kind(given.pop("kind"), integrators, where)
    values = {name: context.value(entry, f"{where}.{name}") for name, entry in given.items()}
    if isinstance(values.get("formulation"), str):
        name = values["formulation"]
        values["formulation"] = call(find_kind(name, kind_lists.formulations(), f"{where}.formulation"), {}, where)
    return call(make, values, where)
