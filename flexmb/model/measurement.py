"""Signals that are measured while the motion is computed: the columns of sensors, and formulas of them.

A sensor stands wherever a signal may follow what is measured. A formula gives names to several of them::

    force = fmb.formula("-k*x - d*rate(x)", over={"x": fmb.JointCoordinate("x", joint="rail")}, k=400.0, d=12.0)
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, ClassVar

from flexmb.errors import ModelError
from flexmb.math import operations as op
from flexmb.model.described import check_mapping
from flexmb.model.equation_text import FormulaReader, Input, read_equation
from flexmb.model.expression import SignalProgram
from flexmb.model.signal import Signal, as_signal

__all__ = ["Formula", "Measurement", "complaint_of", "formula", "measured"]


class Following(Signal):
    """A signal that depends on what is measured, so that no function of time alone computes it."""

    @cached_property
    def follows(self) -> bool:
        return True

    @cached_property
    def extent(self) -> tuple[int, int]:
        return 1, 1

    def program(self) -> SignalProgram:
        raise ModelError(
            f"Signal {self.word}",
            found="a signal that follows what is measured, where the motion must be known in advance",
            expected="a function of time; effort of an Actuator, force and moment of a PointLoad follow measurements",
            remedy="Let an Actuator or a PointLoad follow the measurement",
        )


@dataclass(frozen=True, eq=False)
class Measurement(Following):
    """A column of a sensor, or its rate.

    Parameters
    ----------
    of : sensor, or name of a sensor of the model
    column : int
        Counted from 0.
    rate : bool
        The rate of a position.
    """

    of: Any
    column: int = 0
    rate: bool = False
    word: ClassVar[str] = "measured"

    def __post_init__(self):
        if not (isinstance(self.of, str) or hasattr(self.of, "reading")):
            raise ModelError(
                "Signal measured",
                found=f"of = {self.of!r:.60}",
                expected="a sensor, or the name of a sensor",
                remedy='Write measured("tip"), in a model file { measured = "tip" }, with the name of a sensor',
            )
        if isinstance(self.column, bool) or not isinstance(self.column, int) or self.column < 0:
            raise ModelError(
                "Signal measured",
                found=f"column = {self.column!r}",
                expected="a whole number >= 0",
                remedy="Count the columns of the sensor from 0",
            )


@dataclass(frozen=True, eq=False)
class Formula(Following):
    """A formula of measured quantities, of time and of parameters.

    Parameters
    ----------
    text : str
        As in expressions; ``p[1]`` is a component, counted from 0, ``rate(x)`` the rate of a position.
    over : mapping of name to sensor, signal or name of a sensor
    parameters : mapping of name to number
    """

    text: str
    over: Mapping[str, Any]
    parameters: Mapping[str, Any] = field(default_factory=dict)
    word: ClassVar[str] = "formula"

    def __post_init__(self):
        check_mapping(self.over, "Signal formula", "over", '{"x": fmb.JointCoordinate("x", joint="rail")}')
        check_mapping(self.parameters, "Signal formula", "parameters", '{"k": 400.0}')
        if not isinstance(self.text, str):
            raise ModelError(
                "Signal formula",
                found=f"text = {self.text!r}",
                expected="a formula between quotes",
                remedy='Write formula("-k*x", over={"x": sensor}, k=400.0)',
            )
        object.__setattr__(self, "text", self.text.strip().removeprefix("=").strip())
        for name, given in self.over.items():
            if not isinstance(given, str | Signal) and not hasattr(given, "reading"):
                raise ModelError(
                    "Signal formula",
                    found=f"over holds {name!r}: {given!r:.60}",
                    expected="sensors, signals or names of sensors",
                    remedy='Write over={"x": fmb.JointCoordinate("x", joint="rail")}',
                )

    def read(self, sizes: Mapping[str, int]) -> tuple[SignalProgram, list[Input]]:
        """Return the program and its inputs, where `sizes` tells how many columns each name of `over` has."""
        inputs: list[Input] = []
        own = {name: given for name, given in self.over.items() if isinstance(given, Signal)}
        if "=" in self.text.replace("==", "").replace("<=", "").replace(">=", "").replace("!=", ""):
            raise ModelError(
                "Signal formula",
                found=f"'{self.text}', an equation",
                expected="a formula that gives a number",
                remedy="Leave out the equals sign; equations are constraints",
            )
        program = read_equation(self.text, sizes, {**self.parameters, **own}, inputs, "Signal formula", FormulaReader)
        return program, inputs


def measured(of: Any, column: int = 0, rate: bool = False) -> Measurement:
    """Return a column of a sensor (or of the sensor of this name in the model) as a signal, or its rate."""
    return Measurement(of, column, rate)


def formula(text: str, /, over: Mapping[str, Any], **parameters: float) -> Formula:
    """Return a formula of measured quantities: ``formula("-k*x", over={"x": sensor}, k=400.0)``."""
    return Formula(text, over, parameters)


def complaint_of(value: Any) -> str:
    """Return what went wrong in a function of the user in a signal, or in signals within other values."""
    if hasattr(value, "complaint"):
        return value.complaint()
    if isinstance(value, tuple | Mapping):
        inner = value.values() if isinstance(value, Mapping) else value
    else:
        inner = vars(value).values() if isinstance(value, Signal) else ()
    return next((told for one in inner if (told := complaint_of(one))), "")


def input_program(number: int) -> SignalProgram:
    """Return the program that reads an input."""
    return SignalProgram.of((op.INPUT, float(number)))


def signals_of(values: Any, part: str, name: str) -> tuple[Signal, ...]:
    """Return a list of signals; one alone is a list of one."""
    given = values if isinstance(values, list | tuple) else (values,)
    return tuple(as_signal(value, part, name) for value in given)
