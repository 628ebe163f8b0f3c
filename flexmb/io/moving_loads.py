"""Loads that travel along tracks of reduced bodies, in model files: a table ``[[moving_load]]`` becomes its forces."""

from __future__ import annotations

from typing import Any

from flexmb.errors import ModelError
from flexmb.forces.moving_load import moving_load
from flexmb.io.field_values import Context, call
from flexmb.model.model import Model

__all__ = ["FIELDS", "moving_forces"]

FIELDS = ("name", "load", "amount", "along")


def moving_forces(raw: dict[str, Any], where: str, context: Context, model: Model) -> tuple[Any, ...]:
    """Return the forces of one table: the fields of `flexmb.moving_load`, with the data of the body in `model`.

    ``along`` is a signal, or the name of a joint as a text.
    """
    values = {field: context.value(entry, f"{where}, {field}") for field, entry in raw.items()}
    load = values.get("load")
    if "data" in values or not isinstance(load, str) or "." not in load:
        raise ModelError(
            where,
            found="a field 'data'"
            if "data" in values
            else f"load = {load!r}"
            if "load" in values
            else "no field 'load'",
            expected=f"'body.track', and the fields {', '.join(FIELDS)}: the body brings its data",
            remedy="Write load = 'beam.rail'",
        )
    data = getattr(model.body(load.partition(".")[0], where), "data", None)
    if not hasattr(data, "quality"):
        raise ModelError(
            f"{where}, load",
            found=f"the body of {load!r} has no reduced data",
            expected="a FloatingBody, whose loads have a Track",
            remedy="Name the body that was reduced with loads = { rail = { kind = 'Track', ... } }",
        )
    return tuple(call(moving_load, {**values, "data": data}, where))
