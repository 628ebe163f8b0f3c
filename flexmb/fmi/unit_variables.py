"""Variables of units as numbers: reals, integers, booleans, enumerations, and elements of arrays of them.

A number goes to an integer or an enumeration as the nearest one, and to a boolean as true from 0.5 on; from a boolean
come 0.0 and 1.0. Elements of arrays are named "x[1]", "A[2,3]": from 1 on, by rows. Source: FMI 3.0.1, 2.4.7 and 2.4.6.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from itertools import islice
from typing import Any, NamedTuple

import numpy as np

from flexmb.errors import DataFileError, IntegrationError, ModelError, did_you_mean, listed

__all__ = ["REALS", "SMOOTH", "Element", "UnitVariables", "elements_of", "failed_reading"]

SMOOTH = ("Real", "Float64")
"""Reals whose differences are derivatives: those of 32 bits have seven digits."""
REALS = (*SMOOTH, "Float32")
LARGEST = float(np.finfo(np.float32).max)
WHOLE = {
    "Integer": (-(2**31), 2**31 - 1),
    "Enumeration": (-(2**31), 2**31 - 1),
    **{f"Int{n}": (-(2 ** (n - 1)), 2 ** (n - 1) - 1) for n in (8, 16, 32, 64)},
    **{f"UInt{n}": (0, 2**n - 1) for n in (8, 16, 32, 64)},
}
"""Whole numbers of FMI 2 and 3, with their bounds."""
NUMBERS = (*REALS, *WHOLE, "Boolean")
MOST_NAMES = 50
"""Elements of an array up to which a message is looked for among all of them."""


def failed_reading(names: Collection[str]) -> str:
    """Return what a message says of a unit that fails when variables are read: the first three by name."""
    told = ", ".join(f"'{name}'" for name in islice(names, 3))
    rest = f" and {len(names) - 3} others" if len(names) > 3 else ""
    return f"failed when {told}{rest} {'was' if len(names) == 1 else 'were'} read"


class Element(NamedTuple):
    """A number of a unit: a variable, or an element of an array (`at`, its place by rows; None: no array)."""

    variable: Any
    at: int | None


def _shape(variable: Any) -> tuple[int, ...]:
    """Return the dimensions of a variable at the start; () of no array."""
    return tuple(variable.shape or ()) if variable.dimensions else ()


def elements_of(variable: Any) -> list[str]:
    """Return the names of the numbers of a variable: its own, or those of the elements of an array."""
    shape = _shape(variable)
    if not shape:
        return [variable.name]
    return [f"{variable.name}[{','.join(str(i + 1) for i in place)}]" for place in np.ndindex(*shape)]


def _some_elements(variable: Any) -> list[str]:
    """Return the names of the numbers of a variable for a message, of a large array those at its ends."""
    shape = _shape(variable)
    if int(np.prod(shape)) <= MOST_NAMES:
        return elements_of(variable)
    ends = ([1] * len(shape), [1] * (len(shape) - 1) + [2], list(shape))
    return [f"{variable.name}[{','.join(map(str, place))}]" for place in ends]


class UnitVariables:
    """Sets and reads variables of a unit that has been loaded.

    Parameters
    ----------
    title : str
        Of the unit, for messages.
    described : sequence of variables
        As fmpy reads them.
    old : bool
        FMI 2.
    """

    def __init__(self, title: str, described: Any, old: bool):
        self.title, self.old = title, old
        self.by_name = {v.name: v for v in described}
        self.unit: Any = None
        self._arrays: dict[int, list[Any]] = {}
        self._found: dict[tuple[str, ...], Element] = {}
        self._places: dict[str, dict[str, int]] = {}

    def find(self, name: str, *causalities: str) -> Element:
        """Return a number of one of these causalities; ModelError with those that there are."""
        key = (name, *causalities)
        if key not in self._found:
            self._found[key] = self._looked_up(name, *causalities)
        return self._found[key]

    def _place(self, variable: Any, name: str) -> int | None:
        """Return the place of an element by rows, or None if the array has no such one."""
        if variable.name not in self._places:
            self._places[variable.name] = {one: k for k, one in enumerate(elements_of(variable))}
        return self._places[variable.name].get(name)

    def _looked_up(self, name: str, *causalities: str) -> Element:
        variable, at = self.by_name.get(name), None
        if variable is None and name.endswith("]"):
            variable = self.by_name.get(name.partition("[")[0])
            at = None if variable is None else self._place(variable, name)
            variable = variable if at is not None else None
        if variable is not None and variable.causality not in causalities:
            variable = None
        if variable is not None and variable.type not in NUMBERS:
            raise ModelError(
                self.title,
                found=f"{causalities[0]} '{name}' of the type {variable.type}",
                expected="a real number, an integer, a boolean or an enumeration",
                remedy="Connect a number; strings, binaries and clocks have no counterpart here",
            )
        if variable is None or (at is None and _shape(variable)):
            usable = [v for v in self.by_name.values() if v.causality in causalities and v.type in NUMBERS]
            known = [one for v in usable for one in _some_elements(v)]
            whole = [] if variable is None else _some_elements(variable)
            raise ModelError(
                self.title,
                found=f"{causalities[0]} '{name}', an array" if whole else f"no {causalities[0]} '{name}'",
                expected=f"one of: {listed(whole[0] if whole else name, known)}" if known
                else f"a unit with an {causalities[0]} that is a number",
                remedy=did_you_mean(name, known) or "Correct the connection",
            )  # fmt: skip
        return Element(variable, at)

    def set(self, name: str, value: float, *causalities: str) -> None:
        """Set a number; parameters must be what they are set to."""
        self.set_all({name: value}, *causalities)

    def set_all(self, given: Mapping[str, float], *causalities: str) -> None:
        """Set numbers, arrays by one call each."""
        arrays: dict[int, Any] = {}
        for name, value in given.items():
            variable, at = self.find(name, *causalities)
            value = self._as_type(variable, name, value)
            if at is None:
                self._call("set", variable)([variable.valueReference], [value])
            else:
                self._kept(variable)[at] = value
                arrays[variable.valueReference] = variable
        for reference, variable in arrays.items():
            self._call("set", variable)([reference], self._kept(variable))

    def get(self, name: str, *causalities: str) -> float:
        """Return a number."""
        return self.get_all((name,), *causalities)[0]

    def get_all(self, names: Iterable[str], *causalities: str) -> list[float]:
        """Return numbers, arrays by one call each."""
        arrays: dict[int, Any] = {}
        values = []
        for name in names:
            variable, at = self.find(name, *causalities)
            reference = variable.valueReference
            if at is None:
                values.append(float(self._call("get", variable)([reference])[0]))
                continue
            if reference not in arrays:
                arrays[reference] = self._call("get", variable)([reference], int(np.prod(_shape(variable))))
            values.append(float(arrays[reference][at]))
        return values

    def _call(self, verb: str, variable: Any) -> Any:
        kind = variable.type
        if self.old:
            kind = {"Enumeration": "Integer"}.get(kind, kind)
        else:
            kind = {"Enumeration": "Int64", "Real": "Float64"}.get(kind, kind)
        return getattr(self.unit, verb + kind)

    def _as_type(self, variable: Any, name: str, value: float) -> Any:
        """Return a number as the type of a variable has it."""
        exact = variable.causality == "parameter"
        if variable.type in REALS:
            value = float(value)
            if variable.type == "Float32" and LARGEST < abs(value) < np.inf:
                raise self._unfit(variable, name, f"{value:.9g}", exact, f"at most {LARGEST:.9g} in size")
            return value
        value = int(value) if isinstance(value, (int, np.integer)) else float(value)  # 2^53 + 1 is no float
        finite = isinstance(value, int) or np.isfinite(value)
        if variable.type == "Boolean" and not exact and finite:
            return int(value >= 0.5)
        low, high = WHOLE.get(variable.type, (0, 1))
        if finite and low <= round(value) <= high and (not exact or value == round(value)):
            return round(value)
        found = f"{value:.9g}" if isinstance(value, float) else f"{value!s:.40}"
        raise self._unfit(variable, name, found, exact, f"a whole number from {low} to {high}")

    def _unfit(self, variable: Any, name: str, value: str, exact: bool, expected: str) -> Exception:
        """Return the error of a number that the type of a variable cannot hold."""
        return (ModelError if exact else IntegrationError)(
            self.title,
            found=f"{variable.causality} {name} = {value}",
            expected=f"{variable.type}: {expected}",
            remedy="Correct the value" if exact else "Limit what it is connected to, with a Limit or a formula",
        )

    def _kept(self, variable: Any) -> list[Any]:
        """Return all elements of an array as they were set last: at first, as the unit describes them."""
        if variable.valueReference not in self._arrays:
            size, start = int(np.prod(_shape(variable))), variable.start
            text = start if isinstance(start, str) else " ".join(map(str, start or ()))
            words = {"true": "1", "false": "0"}
            found = [words.get(word, word) for word in text.split()]
            kind = float if variable.type in REALS else int
            try:
                values = [kind(word) for word in found]
            except ValueError:
                values = []
            if len(values) == 1:
                values *= size
            if len(values) != size:
                raise DataFileError(
                    self.title,
                    found=f"start of '{variable.name}': {text!r:.80}",
                    expected=f"{size} numbers",
                    remedy="Export the unit again: its description is damaged",
                )
            self._arrays[variable.valueReference] = values
        return self._arrays[variable.valueReference]
