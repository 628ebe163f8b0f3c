"""Flexible bodies described in model files: the table ``data`` of a body becomes a `flexmb.parts.Part`.

Every field is an expression of the parameters, as in other parts; meshes and decks are files beside the model
file. The parameters that the table uses are noted in the data.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from typing import Any

import numpy as np

from flexmb.errors import FlexmbError, ModelError, did_you_mean
from flexmb.files import resolved
from flexmb.io.field_values import Context, call, find_kind, located
from flexmb.io.limits import named_file
from flexmb.io.run_motion import motion_of
from flexmb.model import expression
from flexmb.model.modal_neutral_data import ModalNeutralData
from flexmb.results import stored_body

__all__ = ["body_data", "check_parameters", "described_part"]

OF_MESHES = ("Pressure", "LineLoad", "Track")
"""Loads of `flexmb.reduction` on sets of a mesh."""
CLOSE = 1e-9
"""Relative difference of two values of a parameter that counts as none."""


@cache
def _kinds() -> dict[str, dict[str, type]]:
    """Return what may stand in the lists of a part by field, and under "" what may stand anywhere."""
    from flexmb import parts, reduction
    from flexmb.fem.frames.section import Section
    from flexmb.model.material import Material
    from flexmb.model.orthotropic_material import OrthotropicMaterial

    named = (reduction.Rigid, reduction.Averaging, reduction.Nodes)
    loads = (reduction.Pressure, reduction.LineLoad, reduction.Track)
    bases = (
        reduction.CraigBampton,
        reduction.Rubin,
        reduction.Krylov,
        reduction.CharacteristicModes,
        reduction.Balanced,
    )
    values = (*named, *loads, *bases, reduction.UpTo, reduction.Rayleigh, reduction.Bands, parts.Each)
    shapes = (Section, Material, OrthotropicMaterial, parts.Stretch, parts.Bore, parts.Boss)
    return {
        "pieces": parts.PIECES,
        "links": parts.LINKS,
        "masses": parts.MASSES,
        "loads": parts.LOADS,
        "": {kind.__name__: kind for kind in (*values, *shapes)},
    }


def body_data(context: Context, raw: Any, where: str, name: str) -> Any:
    """Return the reduced body of a file named relative to the model file, or of the description in a table."""
    if isinstance(raw, dict):
        part = described_part(raw, where, name, context)
        text = repr(part.recipe())
        if text not in context.made:
            try:
                context.made[text] = part.reduced()
            except FlexmbError as error:
                raise located(error, where) from None
        return context.made[text]
    value = context.value(raw, where)
    if not isinstance(value, str):
        return value
    if context.stored is not None and value in context.stored:
        return context.stored[value]
    name, _, body = value.partition("#")  # a body of a run: "solution.h5#lever"
    path = resolved(named_file(context.path.parent, name, where))
    if not path.is_file():
        held = sorted(p.name for p in path.parent.glob("*.h5") if p.is_file()) if path.parent.is_dir() else []
        raise ModelError(
            where,
            found=f"'{name}' is a folder" if path.is_dir() else f"the file '{name}' does not exist",
            expected=f"A file relative to the model file; the folder holds: {', '.join(held) or 'no .h5 file'}",
            remedy=did_you_mean(path.name, held) or "Make it with `flexmb reduce`, or correct the path",
        )
    if (path, body) not in context.cache:
        context.cache[path, body] = stored_body(path, body) if body else ModalNeutralData.load(path)
    check_parameters(context.cache[path, body], name, where, context)
    return context.cache[path, body]


def described_part(raw: Mapping[str, Any], where: str, name: str, context: Context) -> Any:
    """Return the part that a table describes; `name` is the body's."""
    from dataclasses import replace

    from flexmb import parts

    kinds = _kinds()
    inner = replace(context, kinds=kinds[""], signals={})
    values: dict[str, Any] = {"name": name}
    for field, entry in raw.items():
        place = f"{where}.{field}"
        if field in ("pieces", "links", "masses"):
            rows = entry if isinstance(entry, list) else [entry]
            values[field] = [_piece(row, f"{place}, {k}", kinds[field], inner) for k, row in enumerate(rows, 1)]
        elif field == "loads" and isinstance(entry, Mapping):
            values[field] = {n: _load(one, f"{place}.{n}", kinds[field], inner) for n, one in entry.items()}
        elif field in ("interfaces", "stations", "preload") and isinstance(entry, Mapping):
            values[field] = {n: inner.value(one, f"{place}.{n}", poses=not _is_object(one)) for n, one in entry.items()}
        elif field == "basis" and isinstance(entry, Mapping) and entry.get("kind") == "Pod":
            values[field] = _pod(entry, place, inner)
        else:
            values[field] = inner.value(entry, place)
    if isinstance(values.get("deck"), str):
        values["deck"] = resolved(named_file(context.path.parent, values["deck"], f"{where}.deck"))
    for reserved in ("parameters", "model"):
        values.pop(reserved, None)
    used = {n: context.parameters[n] for n in sorted(_names(raw)) if n in context.parameters}
    return call(parts.Part, {**values, "parameters": used, "model": context.path.stem}, where)


def _pod(raw: Mapping[str, Any], where: str, context: Context) -> Any:
    """Return the basis of what a body did in a run beside the model file, ``run = "first.h5#beam"``."""
    from flexmb import reduction

    values = {field: context.value(entry, f"{where}.{field}") for field, entry in raw.items() if field != "kind"}
    run = values.pop("run", None)
    if not isinstance(run, str) or "#" not in run or "snapshots" in values:
        raise ModelError(
            where,
            found="no field 'run'" if run is None else f"run = {run!r:.60}",
            expected="the file of a run and the body in it: what that body did are the snapshots",
            remedy='Write basis = { kind = "Pod", run = "first.h5#beam", energy = 0.9999 }',
        )
    name, _, body = run.partition("#")
    path = resolved(named_file(context.path.parent, name, f"{where}.run"))
    return call(reduction.Pod, {**values, "snapshots": motion_of(path, body, context.read_model)}, where)


def _is_object(raw: Any) -> bool:
    return isinstance(raw, Mapping) and "kind" in raw


def _load(raw: Any, where: str, kinds: Mapping[str, type], context: Context) -> Any:
    """Return a load: of a mesh, of a table, of a file; or whatever else `reduce` takes."""
    if _is_object(raw) and str(raw["kind"]) not in context.kinds:
        return _piece(raw, where, {**kinds, **{n: k for n, k in context.kinds.items() if n in OF_MESHES}}, context)
    return context.value(raw, where, poses=not _is_object(raw))


def _piece(raw: Any, where: str, kinds: Mapping[str, type], context: Context) -> Any:
    """Return a piece, link or mass of a part."""
    if not _is_object(raw):
        raise ModelError(
            where,
            found="the field 'kind' is missing" if isinstance(raw, Mapping) else repr(raw)[:80],
            expected=f"a table with kind, one of: {', '.join(kinds)}",
            remedy=f'Add kind = "{next(iter(kinds))}"',
        )
    make = find_kind(context.value(raw["kind"], f"{where}, kind"), kinds, where)
    values = {
        field: context.value(entry, f"{where}, {field}", poses=isinstance(entry, Mapping) and not _is_object(entry))
        for field, entry in raw.items()
        if field != "kind"
    }
    for field in getattr(make, "files", ()):
        if isinstance(values.get(field), str):
            values[field] = resolved(named_file(context.path.parent, values[field], f"{where}, {field}"))
    return call(make, values, where)


def _names(raw: Any) -> set[str]:
    """Return the names that the expressions of a table use."""
    if isinstance(raw, str):
        text = raw.strip()
        return expression.names(text.removeprefix("=").strip()) if text.startswith("=") else set()
    entries = raw.values() if isinstance(raw, Mapping) else raw if isinstance(raw, list) else ()
    return set().union(*(_names(entry) for entry in entries))


def check_parameters(data: ModalNeutralData, file: str, where: str, context: Context) -> None:
    """Raise ModelError if a data file was made with other values of parameters than the model has."""
    made = data.recipe.get("parameters")
    model = data.recipe.get("model") or context.path.stem
    if not isinstance(made, Mapping) or model != context.path.stem:
        return
    for name, value in made.items():
        if name in context.parameters and not _equal(value, context.parameters[name]):
            raise ModelError(
                where,
                found=f"the body in '{file}' was made with {name} = {value!r:.60}, the model has "
                f"{context.parameters[name]!r:.60}: its elements, masses and interfaces belong to the old value",
                expected="data that were made with the parameters of the model",
                remedy="Reduce the body again with the new value, or describe it in the model file: data = { pieces = "
                "[...] }",
            )


def _equal(a: Any, b: Any) -> bool:
    try:
        x, y = np.asarray(a, float), np.asarray(b, float)
    except (TypeError, ValueError):
        return bool(a == b)
    return x.shape == y.shape and bool(np.all(np.abs(x - y) <= CLOSE * np.maximum(np.abs(x), np.abs(y))))
