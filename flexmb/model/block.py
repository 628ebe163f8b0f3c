"""`Block`: a signal with first-order states, x' = f(t, x, signals), and an output: filters and controllers.

A block is written in signals: its rates and its output are formulas of the signals that it follows and of its own
states (`OwnState`). So it has nothing to compile and nothing to differentiate by itself.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from flexmb.errors import ModelError
from flexmb.model.described import finite_array, is_number
from flexmb.model.measurement import Following, Formula
from flexmb.model.signal import Signal, as_signal

__all__ = ["Block", "OwnState", "limited", "linear"]


class Block(Following):
    """A signal with states.

    Its field `name` is how sensors (`State`) and messages call it; ``of`` is the signal that it follows.
    """

    name: str | None = None

    @property
    def title(self) -> str:
        """How messages call it."""
        return f"Block '{self.name}'" if self.name else f"Block {self.word}"

    def states(self) -> Mapping[str, float]:
        """Return names and starting values of the states."""
        return {}

    def sizes(self) -> Mapping[str, float]:
        """Return values of states up to which their errors are absolute, where they are not 1."""
        return {}

    def rates(self) -> tuple[Signal, ...]:
        """Return the rates of the states, in their order."""
        return ()

    def output(self) -> Signal:
        """Return the output."""
        raise TypeError(f"{type(self).__name__} has no output")

    def state(self, name: str) -> OwnState:
        """Return a state as a signal."""
        return OwnState(self, name)

    def follow(self, *names: str) -> None:
        """Make the named fields signals; ModelError if they are none."""
        for name in names:
            object.__setattr__(self, name, as_signal(getattr(self, name), self.title, name))

    def require(self, *names: str, positive: bool = False) -> None:
        """Raise ModelError unless the named fields are finite numbers (above zero)."""
        for name in names:
            value = getattr(self, name)
            if not is_number(value) or (positive and value <= 0.0):
                raise ModelError(
                    self.title,
                    found=f"{name} = {value!r}",
                    expected="a number > 0" if positive else "a finite number",
                    remedy=f"Correct {name}; SI units and radians",
                )

    def require_limits(self, *, optional: bool = True) -> None:
        """Make the field `limits` two numbers, the smaller one first, or None; ModelError if it is neither."""
        if self.limits is None and optional:  # type: ignore[attr-defined]
            return
        limits = finite_array(self.limits)  # type: ignore[attr-defined]
        if limits.shape != (2,) or not limits[0] < limits[1]:
            raise ModelError(
                self.title,
                found=f"limits = {self.limits!r}",  # type: ignore[attr-defined]
                expected="(smallest, largest)",
                remedy="Write limits=(-10.0, 10.0)",
            )
        object.__setattr__(self, "limits", (float(limits[0]), float(limits[1])))


@dataclass(frozen=True, eq=False)
class OwnState(Following):
    """A state of a block."""

    block: Block
    name: str
    word: ClassVar[str] = "state"


def linear(terms: Mapping[str, tuple[float, Signal]]) -> Signal:
    """Return the sum of signals times numbers, terms of zero left out."""
    used = {name: term for name, term in terms.items() if term[0] != 0.0}
    text = " + ".join(f"{name}_by*{name}" for name in used) or "0"
    over = {name: signal for name, (_, signal) in used.items()}
    return Formula(text, over, {f"{name}_by": float(factor) for name, (factor, _) in used.items()})


def limited(signal: Any, limits: tuple[float, float]) -> Formula:
    """Return a signal within limits."""
    return Formula("min(max(x, low), high)", {"x": signal}, {"low": limits[0], "high": limits[1]})


def matrix(value: Any, rows: int | None, columns: int | None, title: str, name: str) -> np.ndarray:
    """Return a matrix of finite numbers of this shape; ModelError with the shapes otherwise."""
    array = np.atleast_2d(finite_array(value))
    shape = tuple(n if wanted is None else wanted for n, wanted in zip(array.shape, (rows, columns)))
    if array.ndim == 2 and array.size == 0 and 0 in (rows, columns):
        return np.zeros((rows or 0, columns or 0))
    if array.ndim != 2 or array.shape != shape or not array.size:
        raise ModelError(
            title,
            found=f"{name} of the shape {array.shape}" if array.size else f"{name} = {value!r:.80}, no finite numbers",
            expected=f"finite numbers of the shape ({'any' if rows is None else rows}, "
            f"{'any' if columns is None else columns})",
            remedy="Let A be (n, n), B (n, inputs), C (outputs, n), D (outputs, inputs)",
        )
    return array
