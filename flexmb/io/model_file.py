"""Model files: a mechanism as TOML, whose tables are the fields of the parts.

There is no second schema: ``[[joint]]`` with ``kind = "Revolute"`` holds the fields of `flexmb.Revolute`. See
docs/howto/model-files.md.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import MISSING, replace
from pathlib import Path
from typing import Any

from flexmb.errors import FlexmbError, ModelError, did_you_mean
from flexmb.files import resolved
from flexmb.io import kind_lists
from flexmb.io.field_values import Context, call, find_kind, located
from flexmb.io.file_parameters import resolve
from flexmb.io.file_tables import read_tables
from flexmb.io.inherited import inherited
from flexmb.io.limits import ASSEMBLIES, NESTED, named_file
from flexmb.io.measured_names import check_measured
from flexmb.io.moving_loads import moving_forces
from flexmb.io.notes import tell_note
from flexmb.io.part_tables import body_data
from flexmb.io.simulation_settings import Simulation
from flexmb.io.simulation_table import simulation_of
from flexmb.io.toml_text import parse_toml
from flexmb.model.assembly import joined, placed
from flexmb.model.foreign import Foreign
from flexmb.model.material import MATERIALS
from flexmb.model.modal_neutral_data import ModalNeutralData
from flexmb.model.model import Model
from flexmb.model.orbit import Orbit
from flexmb.model.part import LONGEST
from flexmb.model.pose import as_pose
from flexmb.model.signal import as_signal
from flexmb.told import Told, listening, repeat

__all__ = ["OpenModelFile", "load_model", "load_simulation", "read_model_text"]

_ASSEMBLY_FIELDS = ("file", "prefix", "at", "rotation", "x", "y", "z", "parameters", "inherit")


def load_model(path: str | Path, parameters: Mapping[str, Any] | None = None, *, trust: bool = False) -> Model:
    """Return the model of a TOML file.

    Parameters
    ----------
    path : path
        Model file; files it names (reduced bodies, assemblies) are relative to it.
    parameters : mapping of str to number, text or list
        Values that replace the table ``[parameters]``.
    trust : bool
        May Python functions be imported that the file names (`UserForce`)? They can do whatever you can; without trust
        the model can be looked at, but not computed.

    Raises
    ------
    ModelError
        With the file, the table and the field, what was found, what is expected and what to do.
    DataFileError
        A reduced body cannot be read.
    """
    return OpenModelFile(path, trust=trust).model(parameters)


class OpenModelFile:
    """A model file that is read once, for many values of its parameters.

    Parameters
    ----------
    path, trust
        As of `load_model`.
    """

    def __init__(self, path: str | Path, *, trust: bool = False):
        self.path, self.trust = Path(path), trust
        self.tables = read_tables(self.path)
        self._kept: dict[tuple[Path, str], tuple[str, Any, tuple[Told, ...]]] = {}
        self._settings: dict[tuple[tuple[str, float | None], ...], Simulation] = {}

    def model(self, parameters: Mapping[str, Any] | None = None) -> Model:
        """Return the model; parts without expressions are the same objects every time."""
        given = dict(parameters or {})
        context = Context(
            self.path, given, kind_lists.values(), trust=self.trust, read_model=read_model_text, kept=self._kept
        )
        return _load(dict(self.tables), context, ())

    def simulation(self, parameters: Mapping[str, Any] | None = None, **own: float | None) -> Simulation:
        """Return the settings of the table ``[simulation]``; see `load_simulation`."""
        if _computed(self.tables.get("simulation", {})):
            return simulation_of(self.tables, self.path, parameters or {}, own)
        known = tuple(sorted(own.items()))
        if known not in self._settings:  # the same for all values of the parameters, whose names the model checks
            self._settings[known] = simulation_of(self.tables, self.path, parameters or {}, own)
        return self._settings[known]


def read_model_text(text: str, bodies: Mapping[str, ModalNeutralData] | None = None, *, trust: bool = False) -> Model:
    """Return the model of a text written by `model_text`; `bodies` holds the reduced bodies by body name.

    For `trust` see `load_model`.
    """
    context = Context(Path("stored model"), {}, kind_lists.values(), stored=dict(bodies or {}), trust=trust)
    return _load(parse_toml(text, "Stored model"), context, ())


def load_simulation(
    path: str | Path,
    parameters: Mapping[str, Any] | None = None,
    *,
    t_end: float | None = None,
    samples: int | None = None,
    time_limit: float | None = None,
) -> Simulation:
    """Return the settings of the table ``[simulation]`` of a model file.

    A given `t_end` (s), number of `samples` or `time_limit` (s) replaces the file's; with `t_end` the table may be
    missing.
    """
    own = {"t_end": t_end, "samples": samples, "time_limit": time_limit}
    return simulation_of(read_tables(Path(path)), Path(path), parameters or {}, own)


def _load(tables: dict[str, Any], given: Context, chain: tuple[Path, ...]) -> Model:
    """Return the model of a file's tables; `given` has the overriding parameters, `chain` the files around this one."""
    path = given.path
    own = resolved(path)
    if own in chain:
        circle = " -> ".join(p.name for p in (*chain[chain.index(own) :], own))
        raise ModelError(
            f"{path.name}, [[assembly]]",
            found=f"the files form a circle: {circle}",
            expected="files that do not contain themselves",
            remedy="Remove one of these assemblies",
        )
    _check_top(tables, path.name)
    stated = tables.get("parameters", {})
    context = replace(given, parameters=resolve(tables, given.parameters, path.name), stated=stated)
    context = replace(context, signals=_signals(tables, context))
    for where, raw in _present(tables, "note", context):
        tell_note(raw, where)
    others = [_assembly(raw, where, context, (*chain, own)) for where, raw in _present(tables, "assembly", context)]
    families: dict[str, list[Any]] = {
        family: [_part(where, raw, context) for where, raw in _present(tables, table, context)]
        for table, family in kind_lists.FAMILIES.items()
    }
    gravity = context.value(tables.get("gravity", [0.0, 0.0, 0.0]), f"{path.name}, gravity")
    name = str(tables.get("name", path.stem))
    loads = list(_present(tables, "moving_load", context))
    of_model: dict[str, Any] = {"name": name, "gravity": gravity, "parameters": dict(context.parameters)}
    try:
        if others or loads:  # bodies first: joints, forces and sensors of this file may act on parts of assemblies
            whole = Model(bodies=tuple(families.pop("bodies")), **of_model)
            if others:
                whole = replace(joined(whole, *others), parameters=of_model["parameters"])
            for where, raw in loads:
                families["forces"] += moving_forces(raw, where, context, whole)
            made = whole.with_parts(**families)
        else:
            of_model |= {family: tuple(parts) for family, parts in families.items()}
            made = Model(**of_model)
        origin = _origin(tables, context, made.origin)
        if origin is not made.origin:
            made = replace(made, origin=origin)
    except FlexmbError as error:
        raise located(error, path.name) from None
    for table in () if chain else kind_lists.FAMILIES:  # sensors of an assembly may be those of the file around it
        for where, raw in _present(tables, table, context):
            check_measured(raw, where, made)
    return made


def _origin(tables: dict[str, Any], context: Context, given: Orbit | None) -> Orbit | None:
    """Return the orbit of the table [origin], or of an assembly."""
    where = f"{context.path.name}, [origin]"
    raw = tables.get("origin")
    if raw is None:
        return given
    if not isinstance(raw, dict):
        raise ModelError(
            where,
            found=repr(raw),
            expected="a table with place and velocity",
            remedy="Write [origin], place = [6.9e6, 0, 0], velocity = [0, 7600.0, 0]",
        )
    return call(Orbit, {name: context.value(entry, f"{where}.{name}") for name, entry in raw.items()}, where)


def _check_top(tables: dict[str, Any], file: str) -> None:
    for name in tables:
        if name not in kind_lists.TABLES:
            near = did_you_mean(name, kind_lists.TABLES)
            plural = next((t for t, family in kind_lists.FAMILIES.items() if family == name), "")
            raise ModelError(
                file,
                found=f"there is no table '{name}'",
                expected=f"One of: {', '.join(kind_lists.TABLES)}",
                remedy=f"Did you mean '{plural}'?" if plural else near or "Values of your own go into [parameters]",
            )


def _signals(tables: dict[str, Any], context: Context) -> dict[str, Any]:
    """Return the signals of the table [signals] by name; each may use those above it."""
    where, signals = f"{context.path.name}, [signals]", {}
    given = tables.get("signals", {})
    if not isinstance(given, dict):
        raise ModelError(
            where,
            found="it is no table",
            expected="[signals] and one line for each",
            remedy="Write [signals] with single brackets",
        )
    for name, raw in given.items():
        if name in context.parameters or not name.isidentifier():
            raise ModelError(
                f"{where}, {name}",
                found=f"'{name}' is {'a parameter too' if name in context.parameters else 'not a name'}",
                expected="letters, digits and _, no parameter's name",
                remedy="Choose another name",
            )
        value = replace(context, signals=signals).value(raw, f"{where}, {name}")
        signals[name] = as_signal(value, where, name)
    return signals


def _rows(tables: dict[str, Any], name: str, file: str) -> list[dict[str, Any]]:
    rows = tables.get(name, [])
    if not isinstance(rows, list) or not all(isinstance(row, dict) for row in rows):
        raise ModelError(
            file,
            found=f"[{name}] is a single table or a value",
            expected=f"[[{name}]], one for each",
            remedy=f"Write [[{name}]] with two brackets",
        )
    return rows


def _present(tables: dict[str, Any], table: str, context: Context) -> Iterator[tuple[str, dict[str, Any]]]:
    """Return place and entries of the tables of one name, without those whose `if` or `unless` leaves them out."""
    for number, raw in enumerate(_rows(tables, table, context.path.name), 1):
        name = raw.get("name")
        told = isinstance(name, str) and name.isprintable() and len(name) <= LONGEST
        where = f"{context.path.name}, [[{table}]] " + (f"'{name}'" if told else str(number))
        if _holds(raw, "if", True, where, context) and not _holds(raw, "unless", False, where, context):
            yield where, {field: entry for field, entry in raw.items() if field not in ("if", "unless")}


def _holds(raw: dict[str, Any], field: str, default: bool, where: str, context: Context) -> bool:
    value = context.value(raw.get(field, default), f"{where}, {field}")
    if not isinstance(value, bool | int | float):
        raise ModelError(
            f"{where}, {field}",
            found=repr(value),
            expected="true, false or a number",
            remedy=f'Write {field} = "= rigid" with a parameter that is true or false',
        )
    return bool(value)


def _part(where: str, raw: dict[str, Any], context: Context) -> Any:
    """Return the part that one table describes."""
    place = context.path, where
    if context.kept is None or _computed(raw):
        return _made(where, raw, context)
    known, written = context.kept.get(place), repr(raw)  # a text: true and 1 are equal, and mean different things
    if known is None or known[0] != written:  # of two tables of one name, `if` and `unless` choose one
        with listening() as told:
            part = _made(where, raw, context)
        context.kept[place] = written, part, tuple(told)
        return part
    repeat(known[2])
    return known[1]


def _computed(raw: Any) -> bool:
    """Is there an expression among values?"""
    if isinstance(raw, dict | list):
        return any(map(_computed, raw.values() if isinstance(raw, dict) else raw))
    return isinstance(raw, str) and raw.lstrip().startswith("=")


def _made(where: str, raw: dict[str, Any], context: Context) -> Any:
    """Make the part that one table describes."""
    table = where.partition("[[")[2].partition("]]")[0]
    if "kind" not in raw:
        raise ModelError(
            where,
            found="the field 'kind' is missing",
            expected=f"One of: {', '.join(sorted(kind_lists.parts()[table]))}",
            remedy='Add kind = "..."',
        )
    make = find_kind(context.value(raw["kind"], f"{where}, kind"), kind_lists.parts()[table], where)
    values: dict[str, Any] = {}
    for field, entry in raw.items():
        place = f"{where}, {field}"
        if field == "kind":
            continue
        if field == "data":
            values[field] = body_data(context, entry, place, str(raw.get("name", table)))
        elif field == "points" and isinstance(entry, str) and not entry.lstrip().startswith("="):
            values[field], ring = context.line(entry, place)
            values |= {"closed": True} if ring else {}
        elif field == "markers" and isinstance(entry, dict):
            values[field] = {m: _marker(pose, f"{place}.{m}", context) for m, pose in entry.items()}
        else:
            values[field] = context.value(entry, place)
        if field in getattr(make, "imports", ()) and isinstance(values[field], str) and not context.trust:
            values[field] = Foreign(values[field])
        if field == "material" and isinstance(values[field], str):
            values[field] = _material(values[field], place)
    return call(make, values, where)


def _marker(raw: Any, where: str, context: Context) -> Any:
    """Return what a marker is given by; the pose itself where another variant has it too."""
    if context.kept is None or not isinstance(raw, dict) or _computed(raw):
        return context.value(raw, where, poses=True)
    place, written = (context.path, where), repr(raw)
    known = context.kept.get(place)
    if known is None or known[0] != written:
        given = context.value(raw, where, poses=True)
        try:
            known = context.kept[place] = written, as_pose(given, where, "marker"), ()
        except FlexmbError:  # the body's own message is the better one
            return given
    return known[1]


def _material(name: str, where: str):
    if name not in MATERIALS:
        raise ModelError(
            where,
            found=f"the material '{name}' is unknown",
            expected=f"One of: {', '.join(MATERIALS)}",
            remedy=did_you_mean(name, MATERIALS)
            or 'Write {kind = "Material", young = ..., poisson = ..., density = ...}',
        )
    return MATERIALS[name]


def _assembly(raw: dict[str, Any], where: str, context: Context, chain: tuple[Path, ...]) -> Model:
    """Return the model of another file, with its parameters, prefix and placement."""
    for field in raw:
        if field not in _ASSEMBLY_FIELDS:
            raise ModelError(
                where,
                found=f"there is no field '{field}'",
                expected=f"Fields: {', '.join(_ASSEMBLY_FIELDS)}",
                remedy=did_you_mean(field, _ASSEMBLY_FIELDS) or "Remove it",
            )
    values = {field: context.value(entry, f"{where}, {field}", poses=True) for field, entry in raw.items()}
    for field in ("file", "prefix"):
        if not isinstance(values.get(field), str):
            raise ModelError(
                where,
                found=f"{field} = {values.get(field, MISSING)!r}"
                if field in values
                else f"the field '{field}' is missing",
                expected="a text",
                remedy='Write file = "track.toml", prefix = "t2"',
            )
    given = values.get("parameters", {})
    if not isinstance(given, dict):
        raise ModelError(
            f"{where}, parameters",
            found=repr(given),
            expected="a table",
            remedy="Write parameters = {span = 1.2}",
        )
    path = named_file(context.path.parent, values["file"], f"{where}, file")
    context.assemblies.append(where)
    if len(chain) > NESTED or len(context.assemblies) > ASSEMBLIES:
        deep = len(chain) > NESTED
        raise ModelError(
            where,
            found=f"more than {NESTED} assemblies inside each other" if deep else f"more than {ASSEMBLIES} assemblies",
            expected=f"at most {NESTED} inside each other and {ASSEMBLIES} in all",
            remedy="Look for files that contain each other twice" if not deep else "Nest less deeply",
        )
    try:
        tables = read_tables(path)
        if values.get("inherit", False):
            given = inherited(tables, path.name, context.parameters, context.stated, given, where)
        model = _load(tables, replace(context, path=path, parameters=given), chain)
        pose = as_pose({k: v for k, v in values.items() if k in ("at", "rotation", "x", "y", "z")}, where, "placement")
        return placed(model, values["prefix"], at=pose.at, rotation=pose.rotation)
    except FlexmbError as error:
        raise located(error, where) from None
