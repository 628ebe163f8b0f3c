"""`input`: a signal whose value comes from outside while a run goes on."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from typing import Any, ClassVar

from flexmb.errors import ModelError
from flexmb.math import operations as op
from flexmb.model.expression import SignalProgram
from flexmb.model.signal import Signal

__all__ = ["Input", "input", "inputs_of", "with_more"]


@dataclass(frozen=True, eq=False)
class Input(Signal):
    """A value that another program sets, step by step (`flexmb.stepper`), and that is held until it is set again.

    In all other analyses it has the value given here. Several signals may read one input; all must give it the same
    value. An input jumps when it is set, so it can be a load, or a part of one, but not a prescribed motion.

    Parameters
    ----------
    name : str
        By which it is set: ``run.set("torque", 3.0)``.
    value : float
        Until it is set.
    """

    name: str
    value: float = 0.0
    word: ClassVar[str] = "input"

    def __post_init__(self):
        if not isinstance(self.name, str) or not self.name.strip():
            raise ModelError(
                "Signal input",
                found=f"name = {self.name!r}",
                expected="the name by which it is set, a text",
                remedy='Write input("torque", 0.0)',
            )
        self._numbers("value")

    def program(self) -> SignalProgram:
        one = SignalProgram.of((op.CONSTANT, self.value))
        return SignalProgram(one.ops, one.args, (), ((0, self.name),))


def input(name: str, value: float = 0.0) -> Input:
    """Return the signal whose value is set from outside by its name, `value` until then."""
    return Input(name, value)


def inputs_of(value: Any) -> dict[str, Input]:
    """Return the inputs by name in a signal and all that it follows, or in the fields of a part."""
    if isinstance(value, Input):
        return {value.name: value}
    return {name: one for part in _inner(value).values() for name, one in inputs_of(part).items()}


def with_more(value: Any, name: str, more: Signal, made: dict[int, Any] | None = None) -> Any:
    """Return a signal, or a part, in which another signal is added to an input wherever it is read.

    `made` holds by identity what was made so far: a block that several parts follow stays one block.
    """
    made = {} if made is None else made
    if id(value) in made:
        return made[id(value)]
    if name not in inputs_of(value):
        return value
    if isinstance(value, Input):
        found: Any = value + more
    else:
        parts = {key: with_more(one, name, more, made) for key, one in _inner(value).items()}
        if isinstance(value, tuple):
            found = tuple(parts[k] for k in range(len(value)))
        elif isinstance(value, Mapping):
            found = parts
        else:
            found = replace(value, **parts)
    made[id(value)] = found
    return found


def _inner(value: Any) -> Mapping[Any, Any]:
    """Return what a value is made of: the entries of a tuple or mapping, the fields of a signal or a part that are or
    hold signals, or sensors of them.
    """
    if isinstance(value, tuple):
        return dict(enumerate(value))
    if isinstance(value, Mapping):
        return value
    if not hasattr(value, "__dataclass_fields__") or isinstance(value, type):
        return {}
    found = {f.name: getattr(value, f.name) for f in fields(value) if f.init}
    return {field: one for field, one in found.items() if isinstance(one, Signal | Mapping) or _holds_signals(one)}


def _holds_signals(value: Any) -> bool:
    """Is it a tuple with signals, or a sensor (what measures has readings)?"""
    return hasattr(value, "reading") or (isinstance(value, tuple) and any(isinstance(one, Signal) for one in value))
