"""Values of fields in model files: from TOML to what parts take, and back.

A text that begins with ``=`` is an expression of the parameters, and a signal if it contains ``t``. A table with one
entry named after a signal is that signal, ``{ramp = {rate = 30, rise = 0.2}}``. A table with ``kind`` is an object
described by its fields, ``{kind = "Release", joint = "strut"}``; ``kind = "Section.tube"`` calls a constructor.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from dataclasses import MISSING, dataclass, field, fields, is_dataclass
from functools import cache, partial
from pathlib import Path
from typing import Any

import numpy as np

from flexmb.bodies.line.chains import single_chain
from flexmb.errors import FlexmbError, ModelError, did_you_mean
from flexmb.files import resolved
from flexmb.io.column_files import read_columns
from flexmb.io.limits import check_extent, named_file
from flexmb.model import expression
from flexmb.model.foreign import Foreign
from flexmb.model.modal_neutral_data import ModalNeutralData
from flexmb.model.pose import Pose
from flexmb.model.signal import Constant, Expression, Signal
from flexmb.model.signal_words import SIGNAL_WORDS
from flexmb.told import Told

__all__ = ["Context", "call", "find_kind", "located", "own_kind", "same", "toml_fields", "toml_value"]


@dataclass(frozen=True)
class Context:
    """What the values of one model file are read with.

    Parameters
    ----------
    path : Path
        The model file; other files are named relative to it.
    parameters : mapping of name to number, text or list
    kinds : mapping of str to class
        Objects that may stand in fields.
    cache : dict of (Path, body of a solution file or "") to ModalNeutralData
        Files read so far: bodies of one file share their data.
    stored : mapping of body name to ModalNeutralData, optional
        Where reduced bodies come from instead of files.
    signals : mapping of name to Signal
        Those of the table [signals]; ``"= name"`` is the signal.
    trust : bool
        May functions be imported that the file names?
    assemblies : list of str
        Places of the assemblies read so far, in all files.
    made : dict of str to ModalNeutralData
        Bodies reduced from descriptions so far: equal ones share their data.
    read_model : callable, optional
        Makes the model of a stored run from its text: see `Solution.load`.
    kept : dict of (Path, place) to (text of the table, part, what was told as it was made), optional
        Parts without expressions that were made before, from equal tables.
    stated : mapping of name to TOML value
        The parameters as the file writes them.
    """

    path: Path
    parameters: Mapping[str, Any]
    kinds: Mapping[str, type]
    cache: dict[tuple[Path, str], ModalNeutralData] = field(default_factory=dict)
    stored: Mapping[str, ModalNeutralData] | None = None
    signals: Mapping[str, Signal] = field(default_factory=dict)
    trust: bool = False
    assemblies: list[str] = field(default_factory=list)
    made: dict[str, ModalNeutralData] = field(default_factory=dict)
    read_model: Callable[..., Any] | None = None
    kept: dict[tuple[Path, str], tuple[str, Any, tuple[Told, ...]]] | None = None
    stated: Mapping[str, Any] = field(default_factory=dict)

    def value(self, raw: Any, where: str, *, poses: bool = False) -> Any:
        """Return what a TOML value stands for; with `poses` a table is never a signal (markers have any name)."""
        if isinstance(raw, str):
            return self._text(raw, where) if raw.lstrip().startswith("=") else raw
        if isinstance(raw, list):
            entries = tuple(self.value(entry, where) for entry in raw)
            check_extent(entries, where)
            return entries
        if isinstance(raw, dict):
            if len(raw) == 1 and not poses:
                ((word, given),) = raw.items()
                if word in SIGNAL_WORDS:
                    return self._signal(word, given, f"{where}, {word}")
            values = {name: self.value(entry, f"{where}.{name}") for name, entry in raw.items()}
            return self._object(values, where) if "kind" in values and not poses else values
        return raw

    def _text(self, raw: str, where: str) -> Any:
        text = raw.strip().removeprefix("=").strip()
        if text in self.parameters:
            return self.parameters[text]
        if text in self.signals:
            return self.signals[text]
        try:
            used = expression.names(text)
            if "t" in used:
                return Expression(text, {name: self.parameters[name] for name in used if name in self.parameters})
            return expression.evaluate_values(text, self.parameters)
        except FlexmbError as error:
            raise located(error, where) from None

    def _signal(self, word: str, given: Any, where: str) -> Signal:
        kind = SIGNAL_WORDS[word]
        if isinstance(given, dict):
            values = {name: self.value(entry, f"{where}.{name}") for name, entry in given.items()}
            if word == "table" and "file" in values:
                values = self._with_columns(values, where)
            for name in getattr(kind, "imports", ()):
                if isinstance(values.get(name), str) and not self.trust:
                    values[name] = Foreign(values[name])
            return call(kind, values, where)
        first = fields(kind)[0].name
        return call(kind, {first: self.value(given, where)}, where)

    def _with_columns(self, values: dict[str, Any], where: str) -> dict[str, Any]:
        """Return the fields of a table whose points stand in two columns of a file beside the model file."""
        name, columns = values.pop("file"), values.pop("columns", (0, 1))
        pair = isinstance(columns, tuple) and len(columns) == 2
        both = [field for field in ("x", "y") if field in values]
        if not isinstance(name, str) or not pair or both:
            raise ModelError(
                where,
                found=f"file = {name!r:.60}, columns = {columns!r:.60}"
                + (f", and {' and '.join(both)}" if both else ""),
                expected="the name of a file, and the two columns of x and y",
                remedy='Write table = { file = "road.csv", columns = ["t", "z"] }',
            )
        x, y = read_columns(resolved(named_file(self.path.parent, name, f"{where}.file")), columns)
        return {**values, "x": tuple(x.tolist()), "y": tuple(y.tolist())}

    def _object(self, values: dict[str, Any], where: str) -> Any:
        make = find_kind(values.pop("kind"), self.kinds, where)
        for name in getattr(make, "files", ()):
            if isinstance(values.get(name), str):
                values[name] = resolved(named_file(self.path.parent, values[name], f"{where}.{name}"))
        return call(make, values, where)

    def line(self, raw: str, where: str) -> tuple[Any, bool]:
        """Return the points of the one line in a mesh file, or in a group of it ("rope.msh#upper"),
        and if it is a ring.
        """
        from flexmb import fem

        name, _, group = raw.partition("#")
        mesh = fem.read_mesh(resolved(named_file(self.path.parent, name, where)))
        mesh = mesh.only(group) if group else mesh
        return single_chain(mesh.points, mesh.cells_of("line"), f"{where} = '{raw}'")


def located(error: FlexmbError, where: str) -> ModelError:
    """Return the error with the place in the file before the part."""
    return ModelError(f"{where}: {error.part}", found=error.found, expected=error.expected, remedy=error.remedy)


def find_kind(name: Any, kinds: Mapping[str, type], where: str) -> Callable[..., Any]:
    """Return the class called `name`, or its constructor for "Class.constructor".

    A class that has a field ``kind`` itself takes its value after the dot: "Energy.strain".
    """
    text, dot, constructor = str(name).partition(".")
    if text not in kinds:
        raise ModelError(
            where,
            found=f"kind = {name!r} is unknown",
            expected=f"One of: {', '.join(sorted(kinds))}",
            remedy=did_you_mean(text, kinds) or "Correct the kind",
        )
    kind = kinds[text]
    if not dot:
        return kind
    if own_kind(kind):
        return partial(kind, kind=constructor)
    known = sorted(
        n for n, entry in vars(kind).items() if isinstance(entry, classmethod | staticmethod) and n[0] != "_"
    )
    if constructor not in known:
        raise ModelError(
            where,
            found=f"{text} has no constructor '{constructor}'",
            expected=f"One of: {', '.join(known) or 'none'}",
            remedy=did_you_mean(constructor, known) or f'Write kind = "{text}" and its fields',
        )
    return getattr(kind, constructor)


def own_kind(kind: type) -> bool:
    """Has a class a field ``kind``? In a file that word names the class."""
    return is_dataclass(kind) and any(f.name == "kind" for f in fields(kind))


def call(make: Callable[..., Any], values: Mapping[str, Any], where: str) -> Any:
    """Return make(**values); ModelError for unknown and missing fields, and with the place for any other."""
    signature = _parameters(make)
    title = getattr(make, "__qualname__", str(make))
    for name in values:
        if name not in signature and not _takes_any(make):
            raise ModelError(
                where,
                found=f"there is no field '{name}'",
                expected=f"{title} has: {', '.join(signature)}",
                remedy=did_you_mean(name, signature) or "Correct the field's name, or remove it",
            )
    missing = [name for name, p in signature.items() if p.default is p.empty and name not in values]
    if missing:
        raise ModelError(
            where,
            found=f"the field {' and '.join(repr(m) for m in missing)} is missing",
            expected=f"{title} has: {', '.join(signature)}",
            remedy=f"Give {missing[0]} a value",
        )
    try:
        return make(**values)
    except FlexmbError as error:
        raise located(error, where) from None
    except (TypeError, ValueError, AttributeError, ArithmeticError, LookupError, RecursionError) as error:
        raise ModelError(
            where,
            found=f"{title} cannot be made of these fields ({' '.join(str(error).split())[:200]})",
            expected=f"values as in the reference of {title}",
            remedy="Compare the fields with the reference",
        ) from error


def _parameters(make: Callable[..., Any]) -> dict[str, inspect.Parameter]:
    """Return the parameters that may be given by name; a constructor that passes on others also has its class's."""
    if isinstance(make, type):
        return _parameters_of_class(make)
    own = inspect.signature(make).parameters
    named = {name: p for name, p in own.items() if p.kind is not p.VAR_KEYWORD}
    if len(named) < len(own) and not _takes_any(make):
        passed = inspect.signature(make.__self__).parameters  # type: ignore[attr-defined]
        return {**{name: p.replace(default=None) for name, p in passed.items()}, **named}
    return named


@cache
def _parameters_of_class(kind: type) -> dict[str, inspect.Parameter]:
    """Return the parameters of a class that may be given by name: asked for every part of every variant."""
    return {name: p for name, p in inspect.signature(kind).parameters.items() if p.kind is not p.VAR_KEYWORD}


def _takes_any(make: Callable[..., Any]) -> bool:
    """Does a class itself take any name, as `Change` does?"""
    return isinstance(make, type) and _collected(make) is not None


def _collected(kind: type) -> str | None:
    """Return the name of the parameter ``**name`` of a class, or None."""
    own = inspect.signature(kind).parameters.values()
    return next((p.name for p in own if p.kind is p.VAR_KEYWORD), None)


def toml_value(value: Any, where: str, data_name: Callable[[Any], str]) -> Any:
    """Return a field's value as TOML can hold it; ModelError for what a file cannot hold.

    `data_name` stores reduced bodies and returns the file name to write, of another file how to name it; of a signal it
    returns what to write in its place, or "" where it is written out.
    """
    if isinstance(value, bool | int | float | str):
        return value
    if isinstance(value, np.generic | np.ndarray):
        return value.tolist()
    if isinstance(value, Constant):
        return value.value
    if isinstance(value, Signal):
        return data_name(value) or {value.word: toml_fields(value, where, data_name)}
    if isinstance(value, Pose):
        at = list(value.at)
        return at if value.rotation is None else {"at": at, "rotation": toml_value(value.rotation, where, data_name)}
    if isinstance(value, ModalNeutralData):
        return data_name(value)
    if isinstance(value, Path):
        return data_name(value)
    if isinstance(value, Mapping):
        return {str(k): toml_value(v, f"{where}.{k}", data_name) for k, v in value.items() if v is not None}
    if isinstance(value, list | tuple):
        return [toml_value(entry, where, data_name) for entry in value]
    if hasattr(value, "as_matrix"):
        return value.as_matrix().tolist()
    if is_dataclass(value) and not isinstance(value, type):
        entries = toml_fields(value, where, data_name)
        own = f".{entries.pop('kind')}" if "kind" in entries else ""  # the word names the class
        return {"kind": f"{type(value).__name__}{own}", **entries}
    raise ModelError(
        where,
        found=f"a value of type {type(value).__name__}",
        expected="numbers, text, lists, signals, poses",
        remedy="A model file cannot hold Python objects: save the model without this part",
    )


def toml_fields(value: Any, where: str, data_name: Callable[[Any], str]) -> dict[str, Any]:
    """Return the fields of a dataclass that differ from their defaults, as TOML can hold them."""
    entries: dict[str, Any] = {}
    collected = _collected(type(value))
    for f in fields(value):
        own = getattr(value, f.name)
        if f.name == collected:
            entries.update({name: toml_value(entry, f"{where}.{name}", data_name) for name, entry in own.items()})
            continue
        default = f.default_factory() if f.default_factory is not MISSING else f.default
        unturned = f.name == "rotation" and default is None and same(own, np.eye(3))
        if f.init and own is not None and not unturned and not same(own, default):
            entries[f.name] = toml_value(own, f"{where}.{f.name}", data_name)
    return entries


def same(a: Any, b: Any) -> bool:
    """Are two values of fields equal? Arrays by their entries, descriptions by their fields."""
    if isinstance(a, Pose) and isinstance(b, Pose):
        return a.at == b.at and np.array_equal(a.matrix, b.matrix)
    if isinstance(a, Constant) and isinstance(b, int | float):
        return a.value == b
    if is_dataclass(a) and type(a) is type(b):
        return all(same(getattr(a, f.name), getattr(b, f.name)) for f in fields(a))
    if isinstance(a, np.ndarray) or isinstance(b, np.ndarray):
        return np.shape(a) == np.shape(b) and bool(np.all(np.asarray(a) == np.asarray(b)))
    if isinstance(a, list | tuple) and isinstance(b, list | tuple):
        return len(a) == len(b) and all(same(x, y) for x, y in zip(a, b))
    if isinstance(a, Mapping) and isinstance(b, Mapping):
        return a.keys() == b.keys() and all(same(a[k], b[k]) for k in a)
    try:
        return bool(a == b)
    except (TypeError, ValueError):
        return False
