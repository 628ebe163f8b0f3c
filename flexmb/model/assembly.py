"""Assemblies: a model placed as a whole, under new names, and joined with others to a larger one.

``track.placed("t2", at=(0, 4.2, 0))`` gives every part the name "t2_..." and moves what is described in world axes. The
ground is one: its markers keep their names with the prefix ("ground.t2_A"), and "ground.t2_origin" is the placement.
"""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from copy import copy
from dataclasses import fields, is_dataclass, replace
from typing import Any

import numpy as np

from flexmb.errors import FlexmbError, ModelError
from flexmb.model.part import Part
from flexmb.model.pose import Pose
from flexmb.model.sensor_columns import sensor_columns, without_unit
from flexmb.model.signal import Signal

__all__ = ["joined", "placed"]

FAMILIES = ("bodies", "surfaces", "joints", "forces", "sensors", "events")
GROUND = "ground"

_PART_REFERENCES = (
    "body",
    "bodies",
    "joint",
    "joints",
    "force",
    "forces",
    "surface",
    "surfaces",
    "sensor",
    "sensors",
    "event",
    "part",
    "parts",
)
_MARKER_REFERENCES = (
    "source",
    "marker",
    "markers",
    "axes",
    "curve_marker",
    "load",
    "loads",
    "relative_to",
    "origin",
    "of",
    "through",
)
_READS = ("sensor", "sensors", "of")
"""Fields that may name a column of a sensor."""
_WORLD_VECTORS = ("velocity", "angular_velocity")


def placed(model, prefix: str, *, at=(0.0, 0.0, 0.0), rotation: Any = None):
    """Return `model` with prefixed names, moved and turned as a whole in W.

    Parameters
    ----------
    model : Model
    prefix : str
        Put before each name with an underscore: "t2" makes "lever" to "t2_lever".
    at : (3,), m
        Where the origin of the model comes to lie.
    rotation : rotation vector, matrix or scipy Rotation
        How its axes are turned.
    """
    if not isinstance(prefix, str) or not prefix or "." in prefix:
        raise ModelError(
            f"Assembly of model '{model.name}'",
            found=f"prefix = {prefix!r}",
            expected="a non-empty text without dots",
            remedy='Write prefix="t2"',
        )
    pose = Pose(at, rotation)
    _require_own_axes(model, prefix, pose)
    names = _names_in(model)
    renamed = {
        family: tuple(_placed_part(part, prefix, names, pose) for part in getattr(model, family)) for family in FAMILIES
    }
    parameters = {f"{prefix}_{name}": value for name, value in model.parameters.items()}
    return replace(model, **renamed, name=f"{prefix}_{model.name}", parameters=parameters)


def _names_in(model) -> set[str]:
    """Return the names of parts, and what names columns of its sensors.

    A sensor of the model around may begin with the name of a part in here: "mast tip" is no column of body "mast".
    """
    titles: dict[str, tuple[str, ...]] = {}
    for sensor in model.sensors:
        with suppress(FlexmbError):  # it reads a part of the model around, which is not known yet
            titles[sensor.name] = tuple(map(str, sensor.columns(model)))
    parts = {part.name for family in FAMILIES for part in getattr(model, family)} - {GROUND}
    return parts | set(sensor_columns(titles))


def _require_own_axes(model, prefix: str, pose: Pose) -> None:
    """Raise ModelError if an equation reads components in the axes of W, which would not move with the model."""
    moved = any(pose.at) or not np.array_equal(pose.matrix, np.eye(3))
    if moved and model.origin is not None:
        raise ModelError(
            f"Assembly '{prefix}'",
            found=f"a model whose origin falls along {model.origin!r}, placed at {pose.at} or turned",
            expected="places relative to the orbit as they are",
            remedy="Place the bodies themselves, and give the orbit to the whole",
        )
    for part in (*model.joints, *model.forces) if moved else ():
        read = part.in_world_axes(model) if hasattr(part, "in_world_axes") else None
        if read is not None:
            raise ModelError(
                f"Assembly '{prefix}': {part.title}",
                found=f"'{read}' is a component in the axes of W, and the model is placed at {pose.at} or turned",
                expected="quantities that move with their model",
                remedy="Measure along the axes of a ground marker: Distance(along=...), Velocity(axes=...)",
            )


def joined(*models):
    """Return one model of the parts of all; the grounds become one, name and gravity come from the first.

    Raises
    ------
    ModelError
        Two parts, or two ground markers in different places, have one name; or gravities differ.
    """
    first, *others = models
    parts: dict[str, list[Any]] = {family: list(getattr(first, family)) for family in FAMILIES}
    parameters, gravity, origin = dict(first.parameters), first.gravity, first.origin
    for other in others:
        origin = _one_origin(first, origin, other)
        gravity = _one_gravity(first, gravity, other)
        parameters = {**other.parameters, **parameters}
        for family in FAMILIES:
            parts[family].extend(getattr(other, family))
    grounds = [body for body in parts["bodies"] if body.name == GROUND]
    if len(grounds) > 1:
        shapes = tuple(shape for ground in grounds for shape in ground.shape)
        whole = grounds[0].replaced(markers=_one_set_of_markers(grounds), shape=shapes)
        parts["bodies"] = [whole, *(body for body in parts["bodies"] if body.name != GROUND)]
    return replace(
        first,
        **{family: tuple(members) for family, members in parts.items()},
        parameters=parameters,
        gravity=gravity,
        origin=origin,
    )


def _one_origin(first, origin, other):
    if origin is not None and other.origin is not None and repr(origin.fields()) != repr(other.origin.fields()):
        raise ModelError(
            f"Model '{first.name}' + '{other.name}'",
            found=f"two origins, {origin!r} and {other.origin!r}",
            expected="one orbit that the origin of W follows",
            remedy="Set origin in one of them only",
        )
    return other.origin if origin is None else origin


def _one_gravity(first, gravity, other):
    if not any(gravity):
        return other.gravity
    if any(other.gravity) and not np.allclose(other.gravity, gravity, atol=1e-9 * max(map(abs, gravity))):
        raise ModelError(
            f"Model '{first.name}' + '{other.name}'",
            found=f"gravity {gravity} and {other.gravity} m/s2",
            expected="one gravity",
            remedy="Set gravity in one of them only",
        )
    return gravity


def _one_set_of_markers(grounds) -> dict[str, Pose]:
    markers: dict[str, Pose] = {}
    for ground in grounds:
        for name, pose in ground.markers.items():
            old = markers.setdefault(name, pose)
            if not (np.allclose(old.at, pose.at, atol=1e-12) and np.allclose(old.matrix, pose.matrix, atol=1e-12)):
                raise ModelError(
                    f"Ground marker '{name}'",
                    found=f"it lies at {old.at} and at {pose.at}",
                    expected="one place for one name",
                    remedy='Give the models different prefixes: model.placed("t2", ...)',
                )
    return markers


def _placed_part(part: Any, prefix: str, names: set[str], pose: Pose) -> Part:
    """Return the part with its own and all referred names prefixed, and world vectors turned."""
    values: dict[str, Any] = {}
    for name, value in part.fields().items():
        new = _renamed(name, value, prefix, names)
        if new is not value:
            values[name] = new
    if part.name == GROUND:
        shapes = tuple(replace(shape, on=f"{prefix}_{shape.on or 'origin'}") for shape in part.shape)
        values.update(name=GROUND, markers=_placed_ground(part, prefix, pose), shape=shapes)
    else:
        values["name"] = f"{prefix}_{part.name}"
        values.update(_moved(part, prefix, pose))
    return replace(part, **values)


def _placed_ground(ground, prefix: str, pose: Pose) -> dict[str, Pose]:
    """Return the ground's markers under their new names; ``origin`` becomes the placement itself."""
    moved = {f"{prefix}_{name}": _times(pose, own) for name, own in ground.markers.items()}
    return {f"{prefix}_origin": pose, **moved}


def _times(outer: Pose, inner: Pose) -> Pose:
    """Return the pose `inner` (in the axes of `outer`) in the parent of `outer`."""
    at = np.array(outer.at) + outer.matrix @ np.array(inner.at)
    return Pose(tuple(at), outer.matrix @ inner.matrix)


def _moved(part: Part, prefix: str, pose: Pose) -> dict[str, Any]:
    """Return the fields that are given in W, moved with the placement."""
    values: dict[str, Any] = {}
    known, R = part.fields(), pose.matrix
    if part.family == "Body":
        if "rotation" in known:
            own = _times(pose, Pose(known["at"], known["rotation"]))
            values.update(at=own.at, rotation=own.matrix)
        elif "at" in known:
            values["at"] = _times(pose, Pose(known["at"])).at
        values.update({name: tuple(R @ np.array(known[name])) for name in _WORLD_VECTORS if name in known})
    elif part.family == "Force" and "axes" in known and known["axes"] is None and not np.array_equal(R, np.eye(3)):
        values["axes"] = f"{GROUND}.{prefix}_origin"  # components in W turn with the assembly
    return values


def _renamed(field: str, value: Any, prefix: str, names: set[str]) -> Any:
    """Return the value of a field with the names of parts and markers prefixed; the same object if there are none."""
    if isinstance(value, str):
        return _renamed_text(field, value, prefix, names)
    if isinstance(value, tuple | list):
        new = [_renamed(field, entry, prefix, names) for entry in value]
        return value if all(a is b for a, b in zip(new, value)) else type(value)(new)
    if is_dataclass(value) and not isinstance(value, type) and field == "then":  # actions of events
        twin = copy(value)
        for f in fields(value):
            object.__setattr__(twin, f.name, _renamed(f.name, getattr(value, f.name), prefix, names))
        return twin
    if isinstance(value, Signal):  # a table over the coordinate of a joint
        own_fields = {f.name: _renamed(f.name, getattr(value, f.name), prefix, names) for f in fields(value)}
        changed = {name: own for name, own in own_fields.items() if own is not getattr(value, name)}
        return replace(value, **changed) if changed else value
    return _renamed_entries(field, value, prefix, names) if isinstance(value, Mapping) else value


def _renamed_text(field: str, value: str, prefix: str, names: set[str]) -> str:
    """Return a text of a field: "body.marker", the name of a part, or anything else, which stays."""
    if field in _MARKER_REFERENCES:
        body, dot, marker = value.partition(".")
        if dot and body == GROUND:
            return f"{GROUND}.{prefix}_{marker}"
        if dot and body in names:
            return f"{prefix}_{value}"
    if field in (*_PART_REFERENCES, *_MARKER_REFERENCES):
        return _prefixed(value, prefix, names, field in _READS)
    return value


def _renamed_entries(field: str, value: Mapping, prefix: str, names: set[str]) -> Mapping:
    """Return a mapping of a field with names in its entries, or of its keys, prefixed."""
    if field == "values":  # new values of fields
        return {key: _renamed(key, entry, prefix, names) for key, entry in value.items()}
    if field == "over":  # what an equation reads keeps its name there
        return {key: _measured(entry, prefix, names) for key, entry in value.items()}
    if field in _PART_REFERENCES:
        return {f"{prefix}_{key}" if key in names else key: entry for key, entry in value.items()}
    return value


def _prefixed(value: str, prefix: str, names: set[str], column: bool) -> str:
    """Return a name with the prefix if a part has it; with `column` also one with a unit, "tip dz [m]"."""
    named = value in names or (column and without_unit(value) in names)
    return f"{prefix}_{value}" if named else value


def _measured(given: Any, prefix: str, names: set[str]) -> Any:
    """Return a sensor, or the name of one, with the names of parts and markers prefixed."""
    if isinstance(given, str):
        return _prefixed(given, prefix, names, column=True)
    return replace(given, **{name: _renamed(name, value, prefix, names) for name, value in given.fields().items()})
