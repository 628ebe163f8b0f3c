"""Equations between measured quantities, read from text: ``"p[0]**2 + p[1]**2 - L**2"``, ``"rate(phi) = 3*t"``.

A text may hold the same as expressions (see `flexmb.model.expression`), and

- the names of what is measured: ``phi`` for one number, ``p[0]`` for a component, counted from 0;
- ``rate(phi)``, ``rate(p[0])``: the rate of a measured position, or of a signal;
- the names of signals; what depends on ``t`` alone is one, so its kinks are known to integrators;
- one ``=``: left side minus right side.
"""

from __future__ import annotations

import ast
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from flexmb.errors import ModelError, did_you_mean
from flexmb.math import operations as op
from flexmb.model.expression import Reader, SignalProgram, parse
from flexmb.model.signal import Expression, Signal

__all__ = ["EquationReader", "FormulaReader", "Input", "read_equation"]


@dataclass(frozen=True)
class Input:
    """What an equation reads.

    Parameters
    ----------
    name : str
        Of the sensor, or of the signal.
    column : int
    rate : bool
    signal : Signal, optional
    """

    name: str
    column: int = 0
    rate: bool = False
    signal: Any = None


class EquationReader(Reader):
    """Reads names of measured quantities as inputs; `sizes` is how many columns each has."""

    smooth = True
    """May measured quantities not be compared?"""

    def __init__(self, text: str, sizes: Mapping[str, int], parameters: Mapping[str, Any], inputs: list[Input]):
        signals = {name: value for name, value in parameters.items() if isinstance(value, Signal)}
        numbers = {name: value for name, value in parameters.items() if name not in signals}
        super().__init__(text, numbers, time=True)
        self.sizes, self.signals, self.inputs = sizes, signals, inputs
        self.known = (*sizes, *signals)

    def node(self, node: ast.expr) -> list[tuple[int, float]]:
        used = {n.id for n in ast.walk(node) if isinstance(n, ast.Name)}
        if self.smooth and isinstance(node, ast.Compare) and used & {*self.sizes}:
            raise self.error(
                f"the comparison '{ast.unparse(node)}' of a measured quantity",
                "What holds on one side only is a force: Contact or BiStop",
                "an equation, left = right",
            )
        if "t" in used and not used & {*self.sizes, *self.signals}:
            text = ast.unparse(node)
            super().node(node)  # its messages name the whole equation
            signal = Expression(text, {name: self.parameters[name] for name in used if name in self.parameters})
            return self._input(Input(text, signal=signal))
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "rate":
            if len(node.args) != 1 or node.keywords:
                raise self.error(f"rate with {len(node.args)} arguments", "Write rate(phi)", "one measured quantity")
            found = self._quantity(node.args[0])
            if found is None or found.rate:
                raise self.error(
                    f"rate of '{ast.unparse(node.args[0])}'",
                    "Write rate(phi) of a measured quantity or a signal",
                    f"One of: {', '.join(self.known) or 'nothing is measured'}",
                )
            return self._input(Input(found.name, found.column, True, found.signal))
        found = self._quantity(node)
        return super().node(node) if found is None else self._input(found)

    def _quantity(self, node: ast.expr) -> Input | None:
        """Return what a name, or a name with an index, measures; None for anything else."""
        if isinstance(node, ast.Name) and node.id in self.signals:
            return Input(node.id, signal=self.signals[node.id])
        if isinstance(node, ast.Name) and node.id in self.sizes:
            size = self.sizes[node.id]
            if size > 1:
                raise self.error(
                    f"'{node.id}', which has {size} components",
                    f"Write {node.id}[0] to {node.id}[{size - 1}]",
                    "one number",
                )
            return Input(node.id)
        if not isinstance(node, ast.Subscript) or not isinstance(node.value, ast.Name):
            return None
        name = node.value.id
        if name not in self.sizes and name not in self.parameters and name not in self.signals:
            raise self.error(
                f"the name '{name}' is unknown",
                did_you_mean(name, self.known) or f"Add a sensor of the name {name} to over",
                f"Measured: {', '.join(self.sizes)}",
            )
        if name not in self.sizes:
            return None
        index = node.slice.value if isinstance(node.slice, ast.Constant) else None
        if type(index) is not int or not index < self.sizes[name]:
            raise self.error(
                f"{ast.unparse(node)} of a quantity with {self.sizes[name]} components",
                f"Count from 0 to {self.sizes[name] - 1}",
            )
        return Input(name, index)

    def _input(self, wanted: Input) -> list[tuple[int, float]]:
        if wanted not in self.inputs:
            self.inputs.append(wanted)
        return [(op.INPUT, float(self.inputs.index(wanted)))]


class FormulaReader(EquationReader):
    """Reads what gives a number: steps end where a comparison changes."""

    smooth = False


def read_equation(
    text: str,
    sizes: Mapping[str, int],
    parameters: Mapping[str, Any],
    inputs: list[Input],
    part: str,
    reader: type[EquationReader] = EquationReader,
) -> SignalProgram:
    """Return the program of an equation's residual; what it reads is appended to `inputs`.

    Parameters
    ----------
    text : str
    sizes : mapping of name to int
        Measured quantities, and how many components each has.
    parameters : mapping of name to number or Signal
    inputs : list of Input
    part : str
        Title of the part that asks, for messages.
    reader : class
        `FormulaReader` for what gives a number.

    Raises
    ------
    ModelError
        Unknown names, something else than arithmetic.
    """
    shared = sorted({*sizes} & {*parameters})
    if shared or "t" in sizes or "t" in parameters:
        name = shared[0] if shared else "t"
        raise ModelError(
            part,
            found=f"the name '{name}' has two meanings",
            expected="names of measured quantities and parameters that differ, and are not t",
            remedy=f"Rename one '{name}'",
        )
    left, equals, right = text.partition("=")
    try:
        if equals and not right.startswith("=") and not left.endswith(("<", ">", "!")):
            for side in (left, right):
                parse(side)
            text = f"({left.strip()}) - ({right.strip()})"
        return SignalProgram.of(*reader(text, sizes, parameters, inputs).read())
    except ModelError as error:
        raise ModelError(
            part, found=f"in '{text}': {error.found}", expected=error.expected, remedy=error.remedy
        ) from None
