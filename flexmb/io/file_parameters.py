"""The table ``[parameters]`` of model files: numbers, texts and lists, some computed from others."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from flexmb.errors import FlexmbError, ModelError, did_you_mean, listed
from flexmb.io.field_values import located
from flexmb.io.limits import CHAIN, check_extent
from flexmb.math.operations import CONSTANTS, FUNCTIONS
from flexmb.model import expression
from flexmb.model.described import whole

__all__ = ["parse_setting", "resolve"]

_RESERVED = {"t", *CONSTANTS, *FUNCTIONS}


def resolve(tables: Mapping[str, Any], overrides: Mapping[str, Any], file: str) -> dict[str, Any]:
    """Return the values of all parameters: from the file, replaced by `overrides`, expressions evaluated.

    Raises
    ------
    ModelError
        An override has no parameter in the file, parameters depend on each other in a circle, or a name is taken.
    """
    where = f"{file}, [parameters]"
    own = tables.get("parameters", {})
    if not isinstance(own, dict):
        raise ModelError(
            where,
            found="it is no table",
            expected="[parameters] and one line for each",
            remedy="Write [parameters] with single brackets",
        )
    for name in own:
        if name in _RESERVED or not name.isidentifier():
            raise ModelError(
                f"{where}, {name}",
                found=f"'{name}' is {'taken' if name in _RESERVED else 'not a name'}",
                expected="letters, digits and _, not t, a constant or a function",
                remedy="Choose another name",
            )
    for name in overrides:
        if name not in own:
            raise ModelError(
                where,
                found=f"there is no parameter '{name}' to set",
                expected=f"The file has: {listed(name, own)}",
                remedy=did_you_mean(name, own) or f"Add {name} to [parameters]",
            )
    return _Resolver({**own, **{name: _as_stated(own[name], value) for name, value in overrides.items()}}, where).all()


def _as_stated(stated: Any, value: Any) -> Any:
    """Return a new value of a parameter; where the file writes whole numbers, 8.0 is the 8 that it would write."""
    if isinstance(stated, list) and isinstance(value, list | tuple):
        return whole(value) if stated and all(_is_count(entry) for entry in stated) else value
    return whole(value) if _is_count(stated) else value


def _is_count(value: Any) -> bool:
    return isinstance(value, int) and not isinstance(value, bool)


class _Resolver:
    """Evaluates parameters in the order in which they need each other."""

    def __init__(self, raw: Mapping[str, Any], where: str):
        self.raw, self.where, self.done = raw, where, {}

    def all(self) -> dict[str, Any]:
        return {name: self.value(name, ()) for name in self.raw}

    def value(self, name: str, asking: tuple[str, ...]) -> Any:
        if name in asking:
            circle = " -> ".join((*asking[asking.index(name) :], name))
            raise ModelError(
                f"{self.where}, {name}",
                found=f"the parameters depend on each other: {circle}",
                expected="values that can be computed one after another",
                remedy="Give one of them a number",
            )
        if name not in self.done and len(asking) >= CHAIN:
            raise ModelError(
                f"{self.where}, {name}",
                found=f"more than {CHAIN} parameters that need each other one after another",
                expected=f"at most {CHAIN}",
                remedy="Give one of them its number",
            )
        if name not in self.done:
            self.done[name] = self.plain(self.raw[name], f"{self.where}, {name}", (*asking, name))
        return self.done[name]

    def plain(self, raw: Any, where: str, asking: tuple[str, ...]) -> Any:
        if isinstance(raw, list | tuple):
            entries = tuple(self.plain(entry, where, asking) for entry in raw)
            check_extent(entries, where)
            return entries
        if isinstance(raw, bool | int | float):
            return raw
        if not isinstance(raw, str):
            raise ModelError(
                where,
                found=f"a value of type {type(raw).__name__}",
                expected="a number, a text or a list",
                remedy="Other values go into the fields of parts",
            )
        if not raw.lstrip().startswith("="):
            return raw
        text = raw.strip().removeprefix("=").strip()
        if text in self.raw:
            return self.value(text, asking)
        try:
            needed = {name: self.value(name, asking) for name in sorted(expression.names(text)) if name in self.raw}
            known = {**{name: value for name, value in self.raw.items() if name not in asking}, **needed}
            return expression.evaluate_values(text, known)
        except FlexmbError as error:
            if error.part.startswith(self.where):
                raise
            raise located(error, where) from None


def parse_setting(text: str) -> tuple[str, Any]:
    """Return name and value of ``name=value`` as the command line gives it: a number, an expression, true or false,
    or a text.
    """
    name, equals, value = text.partition("=")
    name, value = name.strip(), value.strip()
    if not equals or not name or not value:
        raise ModelError(
            f"Setting '{text}'",
            found="no name and value",
            expected="name=value",
            remedy="Write pressure=5.5e3",
        )
    if value in ("true", "false"):  # the words of TOML
        return name, value == "true"
    try:
        return name, expression.evaluate(value)
    except ModelError:
        return name, value
