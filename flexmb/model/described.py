"""What descriptions have in common: clear errors for misspelt, missing or unnamed fields, and checked numbers."""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable, Mapping
from functools import wraps
from typing import Any

import numpy as np

from flexmb.errors import FlexmbError, ModelError, did_you_mean

__all__ = [
    "Described",
    "check_kind",
    "check_mapping",
    "entries_of",
    "finite_array",
    "has_flag",
    "is_number",
    "named_arguments",
]


def is_number(value: Any) -> bool:
    """Is it one finite real number? Booleans do not count."""
    real = isinstance(value, int | float | np.number) and not isinstance(value, bool | np.complexfloating)
    try:
        return real and math.isfinite(value)
    except OverflowError:  # an integer beyond all floats
        return False


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
    if not isinstance(value, Mapping):
        raise error(
            part,
            found=f"{field} = {value!r}",
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
            found=f"{len(args)} values without names",
            expected=f"at most {len(places)} without a name ({', '.join(places) or 'none'})",
            remedy=f"Write {named[0]}=..., and so on" if named else "Remove the others",
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


class Described(type):
    """The class of descriptions: wrong arguments become a ModelError that names the fields, and the nearest one."""

    def __call__(cls, *args: Any, **kwargs: Any) -> Any:
        try:
            return super().__call__(*args, **kwargs)
        except TypeError:
            known = inspect.signature(cls).parameters
            collects = any(p.kind in (p.VAR_KEYWORD, p.VAR_POSITIONAL) for p in known.values())
            complaint = None if collects else _complaint(cls.__name__, known, args, kwargs)
            if complaint is None:
                raise
        raise complaint

    @property
    def __signature__(cls) -> inspect.Signature:
        """That of the constructor: without it, help() and the model files would see the call above."""
        signature = inspect.signature(cls.__init__)  # type: ignore[misc]
        return signature.replace(parameters=list(signature.parameters.values())[1:])


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
