"""What descriptions have in common: clear errors for misspelt, missing or unnamed fields, and checked numbers."""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable, Mapping
from dataclasses import MISSING, fields, is_dataclass
from functools import cache, wraps
from typing import Any, NamedTuple

import numpy as np

from flexmb.errors import FlexmbError, ModelError, did_you_mean

__all__ = [
    "Described",
    "check_flags",
    "check_kind",
    "check_mapping",
    "entries_of",
    "finite_array",
    "has_flag",
    "is_number",
    "named_arguments",
    "whole",
]


EXACT = 2.0**53
"""Below this every whole number is a float, and a float is one number."""


def is_number(value: Any) -> bool:
    """Is it one finite real number? Booleans do not count."""
    if type(value) is float:
        return math.isfinite(value)
    real = isinstance(value, int | float | np.number) and not isinstance(value, bool | np.complexfloating)
    try:
        return real and math.isfinite(value)
    except OverflowError:  # an integer beyond all floats
        return False


def whole(value: Any) -> Any:
    """Return a whole number that arithmetic made a float, 8.0, as the integer; lists by entries, the rest as it is.

    Parameters of model files are floats as soon as they are computed, swept or set from outside.
    """
    if isinstance(value, list | tuple):
        return type(value)(map(whole, value)) if type(value) in (list, tuple) else value
    counted = isinstance(value, float | np.floating) and abs(float(value)) < EXACT and float(value).is_integer()
    return int(value) if counted else value


def finite_array(value: Any) -> np.ndarray:
    """Return finite numbers as an array; an empty one for anything else, so that the check of the shape tells."""
    try:
        array = np.asarray(value, float)
    except (TypeError, ValueError, OverflowError):
        return np.empty(0)
    return np.empty(0) if has_flag(value) or not np.all(np.isfinite(array)) else array


def entries_of(value: Any) -> tuple[Any, ...]:
    """Return the entries of a list, tuple or array; none of None, and anything else as the only one."""
    value = value.tolist() if isinstance(value, np.ndarray) else value
    return () if value is None else tuple(value) if isinstance(value, list | tuple) else (value,)


def has_flag(value: Any) -> bool:
    """Is True or False among the entries of an array or a nested list?"""
    if isinstance(value, np.ndarray) and value.dtype != object:
        return value.dtype == bool
    if isinstance(value, list | tuple):
        return any(has_flag(entry) for entry in value)
    return isinstance(value, bool | np.bool_)


def check_mapping(value: Any, part: str, field: str, example: str, error: type[FlexmbError] = ModelError) -> None:
    """Raise an error unless `value` is a mapping of names."""
    if not isinstance(value, Mapping) or not all(isinstance(name, str) for name in value):
        raise error(
            part,
            found=f"{field} = {value!r:.200}",
            expected="a mapping of names to values",
            remedy=f"Write {field}={example}",
        )


def check_kind(value: Any, kind: type, part: str, remedy: str, error: type[FlexmbError] = ModelError) -> None:
    """Raise an error unless `value` is of the class `kind`."""
    if not isinstance(value, kind):
        found = f"an object of the class {type(value).__name__}"
        if value is None or isinstance(value, str):
            found = "nothing (None)" if value is None else f"the text {value!r}"
        elif isinstance(value, type):
            found = f"the class {value.__name__} itself"
        raise error(part, found=found, expected=f"a {kind.__name__}", remedy=remedy)


def _complaint(title: str, known: Mapping[str, inspect.Parameter], args, kwargs) -> ModelError | None:
    """Return what is wrong with the arguments of a call, or None if they fit the parameters."""
    first = args[0] if args else kwargs.get("name")
    part = f"{title} '{first}'" if isinstance(first, str) else title
    fields = f"{title} has: {', '.join(known)}"
    for name in kwargs:
        if name not in known:
            return ModelError(
                part,
                found=f"there is no field '{name}'",
                expected=fields,
                remedy=did_you_mean(name, known) or "Correct the field's name, or remove it",
            )
    places = [n for n, p in known.items() if p.kind in (p.POSITIONAL_ONLY, p.POSITIONAL_OR_KEYWORD)]
    if len(args) > len(places):
        named = sorted(
            (name for name in known if name not in places), key=lambda n: known[n].default is not known[n].empty
        )
        return ModelError(
            part,
            found="1 value without a name" if len(args) == 1 else f"{len(args)} values without names",
            expected=f"at most {len(places)} without a name ({', '.join(places)})" if places else "a name for each",
            remedy=_named_remedy(named, args[len(places) :]),
        )
    given = {*places[: len(args)], *kwargs}
    missing = [name for name, p in known.items() if p.default is p.empty and name not in given]
    if missing:
        return ModelError(
            part,
            found=f"the field {' and '.join(repr(m) for m in missing)} is missing",
            expected=fields,
            remedy=f"Give {missing[0]} a value",
        )
    return None


def _named_remedy(named: list[str], values: tuple) -> str:
    """Return what to do about values without names that no place takes."""
    if not named:
        return "Remove the others" if len(values) > 1 else "Remove the last"
    if len(values) > 1:
        return f"Write {named[0]}=..., and so on"
    return f"Write {named[0]}={values[0]!r}" if is_number(values[0]) else f"Give its name: {named[0]}=... for example"


class _Plain(NamedTuple):
    """A field whose annotation says in one word what it holds."""

    name: str
    word: str
    optional: bool
    default: Any


def _is_real(value: Any) -> bool:
    """Is it a real number, which may be infinite but not NaN?"""
    return is_number(value) or (isinstance(value, float | np.floating) and math.isinf(value))


_HOLDS: dict[str, tuple[Callable[[Any], bool], str]] = {
    "str": (lambda value: isinstance(value, str) and "\0" not in value, "a text"),
    "bool": (lambda value: isinstance(value, bool | np.bool_), "True or False"),
    "float": (_is_real, "a number"),
    "int": (
        lambda value: isinstance(value, int | np.integer) and not isinstance(value, bool) and abs(int(value)) < 2**63,
        "a whole number",
    ),
    "Mapping": (lambda value: isinstance(value, Mapping), "names and their values"),
}
"""What a value of an annotation is, and how messages call it."""


@cache
def _plain_fields(cls: type) -> tuple[_Plain, ...]:
    """Return the fields of a kind that hold one text, flag, number or mapping."""
    found = []
    for f in fields(cls) if is_dataclass(cls) else ():
        text = f.type if isinstance(f.type, str) else getattr(f.type, "__name__", "")
        word, _, rest = text.partition(" | ")
        word = word.partition("[")[0]
        if f.init and word in _HOLDS and rest in ("", "None"):
            found.append(_Plain(f.name, word, rest == "None" or f.default is None, f.default))
    return tuple(found)


@cache
def _counts(cls: type) -> frozenset[str]:
    """Return the fields of a kind that hold one whole number."""
    return frozenset(f.name for f in _plain_fields(cls) if f.word == "int")


def _wrong_value(cls: type, values: Mapping[str, Any]) -> ModelError | None:
    """Return what is wrong with the first of the values that is not what its field's annotation says."""
    for f in _plain_fields(cls):
        if f.name not in values:
            continue
        value, (holds, expected) = values[f.name], _HOLDS[f.word]
        if (value is None and f.optional) or holds(value):
            continue
        name = values.get("name")
        title = getattr(cls, "family", cls.__name__)
        found = "nothing (None)" if value is None else f"{value!r:.200}"
        usual = f"Leave {f.name} out" + (f" for {f.default!r}" if f.default not in (MISSING, None) else "")
        needed = f"Write {f.name}='...'" if f.word == "str" else f"Give {f.name} {expected}"
        return ModelError(
            f"{title} '{name}'" if isinstance(name, str) and name and f.name != "name" else title,
            found=f"{f.name} = {found}",
            expected=expected,
            remedy=needed if f.default is MISSING and not f.optional else usual,
        )
    return None


def check_flags(part: Any) -> None:
    """Raise ModelError for a field that is no flag but should be: a text of a model file, "false", would count as true.

    For kinds whose other checks look at their flags.
    """
    kind: type = type(part)
    for f in _plain_fields(kind):
        given = {"name": part.name, f.name: getattr(part, f.name)}
        complaint = _wrong_value(kind, given) if f.word == "bool" else None
        if complaint is not None:
            raise complaint


class Described(type):
    """The class of descriptions: wrong arguments become a ModelError that names the fields, and the nearest one.

    Fields whose annotation is a text, a flag, a number or a mapping hold one: anything else is an error by name.
    Where a whole number is asked, 8.0 is 8.
    """

    def __call__(cls, *args: Any, **kwargs: Any) -> Any:
        if counts := _counts(cls):
            places = _places(cls)
            named = zip(places, args)
            args = (*(whole(value) if name in counts else value for name, value in named), *args[len(places) :])
            kwargs = {name: whole(value) if name in counts else value for name, value in kwargs.items()}
        given = {**dict(zip(_places(cls), args)), **kwargs}
        complaint = None
        try:
            made = super().__call__(*args, **kwargs)
        except (TypeError, ValueError, ArithmeticError, AttributeError, LookupError) as error:
            if isinstance(error, TypeError):
                known = inspect.signature(cls).parameters
                collects = any(p.kind in (p.VAR_KEYWORD, p.VAR_POSITIONAL) for p in known.values())
                complaint = None if collects else _complaint(cls.__name__, known, args, kwargs)
            complaint = complaint or _wrong_value(cls, given)
            if complaint is None:
                raise
        else:
            own = {f.name: getattr(made, f.name, f.default) for f in _plain_fields(cls)}
            complaint = _wrong_value(cls, own)
            if complaint is None:
                return made
        raise complaint

    @property
    def __signature__(cls) -> inspect.Signature:
        """That of the constructor: without it, help() and the model files would see the call above."""
        signature = inspect.signature(cls.__init__)  # type: ignore[misc]
        return signature.replace(parameters=list(signature.parameters.values())[1:])


@cache
def _places(cls: type) -> tuple[str, ...]:
    """Return the names of the arguments that need no name, in their order."""
    parameters = inspect.signature(cls).parameters.values()
    return tuple(p.name for p in parameters if p.kind in (p.POSITIONAL_ONLY, p.POSITIONAL_OR_KEYWORD))


def named_arguments(function: Callable) -> Callable:
    """Give the constructor of a class (below @classmethod) the same messages;
    it passes other fields on to the class.
    """

    @wraps(function)
    def checked(cls, *args, **kwargs):
        own = {
            name: p
            for name, p in list(inspect.signature(function).parameters.items())[1:]
            if p.kind is not p.VAR_KEYWORD
        }
        passed = {name: p.replace(default=None) for name, p in inspect.signature(cls).parameters.items()}
        complaint = _complaint(f"{cls.__name__}.{function.__name__}", {**passed, **own}, args, kwargs)
        if complaint is not None:
            raise complaint
        return function(cls, *args, **kwargs)

    return checked
