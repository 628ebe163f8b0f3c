"""Signals: given functions of time, described by frozen records and compiled to programs.

A signal is sampled with its first two time derivatives (`flexmb.math.jets`), because a prescribed motion enters the
constraint with its value, their rates with its rate, and the accelerations with its second rate. Plain numbers are
signals too. Signals are added, subtracted, negated, multiplied, and divided by numbers::

    lift = fmb.table([0.0, 0.4, 0.7], [2e3, 5e3, 9e3], of=fmb.ramp(rate=0.7, rise=0.2))
    gust = lift * 1.3 + fmb.harmonic(amplitude=50.0, frequency=4.0)
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields
from functools import cached_property
from typing import Any, ClassVar

import numpy as np

from flexmb.errors import ModelError, did_you_mean
from flexmb.math import operations as op
from flexmb.model.described import Described, is_number
from flexmb.model.expression import SignalProgram, compile_expression, joined_arrays

__all__ = [
    "Constant",
    "Expression",
    "Product",
    "Signal",
    "Sum",
    "as_signal",
    "expression",
    "pack",
]

MOST_OPERATIONS = 20_000
"""Operations of one signal; each costs about a nanosecond at every evaluation."""
DEEPEST = 60
"""Signals inside each other."""

WORDS = ("ramp", "step", "harmonic", "table", "expression", "input", "sum", "product")
"""Names of the signals, in Python and in model files."""


@dataclass(frozen=True, eq=False)
class Signal(metaclass=Described):
    """A given function of time."""

    word: ClassVar[str] = ""
    """Name of the constructor, in Python and in model files."""

    def program(self) -> SignalProgram:
        """Return the operations that compute the signal."""
        return self.program_of([part.program() for part in self.parts()])

    def parts(self) -> tuple[Signal, ...]:
        """Return the signals that this one is made of."""
        return ()

    def program_of(self, parts: Sequence[SignalProgram]) -> SignalProgram:
        """Return the operations that compute the signal from the operations of its parts."""
        raise TypeError(f"{type(self).__name__} has no program")

    @cached_property
    def follows(self) -> bool:
        """Does it depend on what is measured, not on time alone?"""
        return any(part.follows for part in self.parts())

    @cached_property
    def extent(self) -> tuple[int, int]:
        """Number of operations, and how deeply signals are nested."""
        return len(self.program().ops), 1

    def _require_extent(self) -> None:
        """Raise ModelError for signals of signals that double with every line: they would fill the memory."""
        operations, depth = self.extent
        if operations > MOST_OPERATIONS or depth > DEEPEST:
            raise ModelError(
                f"Signal {self.word}",
                found=f"{operations} operations, signals {depth} deep",
                expected=f"at most {MOST_OPERATIONS} operations, and signals {DEEPEST} deep",
                remedy="Write the function as a table",
            )

    def sample(self, t) -> np.ndarray:
        """Return value, rate and second rate at the times `t` (nt,): (nt, 3); one time gives (3,)."""
        from flexmb.math.jets import SignalCode, sample_signals

        code, out = SignalCode(*pack([self.program()])), np.empty((np.size(t), 1, 3))
        for time, row in zip(np.ravel(np.asarray(t, float)), out):
            sample_signals(float(time), code, row)
        return out[:, 0].reshape((*np.shape(t), 3))

    def fields(self) -> dict[str, Any]:
        """Return the fields by name."""
        return {f.name: getattr(self, f.name) for f in fields(self)}

    def _numbers(self, *names: str) -> None:
        """Make the named fields floats; ModelError unless they are finite numbers."""
        for name in names:
            object.__setattr__(self, name, _number(getattr(self, name), f"Signal {self.word}", name))

    def _require(self, name: str, holds: bool, expected: str) -> None:
        if not holds:
            raise ModelError(
                f"Signal {self.word}",
                found=f"{name} = {getattr(self, name)!r}",
                expected=expected,
                remedy=f"Correct {name}",
            )

    def __add__(self, other):
        return Sum((*_terms(self, Sum), *_terms(as_signal(other, "Signal", "sum"), Sum)))

    def __mul__(self, other):
        return Product((*_terms(self, Product), *_terms(as_signal(other, "Signal", "product"), Product)))

    __radd__, __rmul__ = __add__, __mul__

    def __neg__(self):
        return self * -1.0

    def __sub__(self, other):
        return self + as_signal(other, "Signal", "difference") * -1.0

    def __rsub__(self, other):
        return -self + other

    def __truediv__(self, other):
        divisor = _number(other, "Signal", "divisor")
        if divisor == 0.0:
            raise ModelError(
                "Signal",
                found="a division by zero",
                expected="a divisor other than 0",
                remedy="Correct the divisor",
            )
        return self * (1.0 / divisor)


def _terms(signal: Signal, kind: type) -> tuple[Signal, ...]:
    return signal.terms if isinstance(signal, kind) else (signal,)  # type: ignore[attr-defined]


def _number(value: Any, part: str, name: str) -> float:
    if not is_number(value):
        raise ModelError(
            part,
            found=f"{name} = {value!r}",
            expected="a finite number",
            remedy="Use SI units and radians; numbers without quotes",
        )
    return float(value)


@dataclass(frozen=True, eq=False)
class Constant(Signal):
    """The same value at all times."""

    value: float
    word: ClassVar[str] = "constant"

    def __post_init__(self):
        self._numbers("value")

    def program(self) -> SignalProgram:
        return SignalProgram.of((op.CONSTANT, self.value))


@dataclass(frozen=True, eq=False)
class Expression(Signal):
    """A formula in ``t`` (s) and named parameters (see `flexmb.model.expression`).

    Parameters
    ----------
    text : str
        ``"lift*sin(omega*t)"``; a leading ``=`` is allowed.
    parameters : mapping of str to float
        Values of the names.
    """

    text: str
    parameters: Mapping[str, float] = field(default_factory=dict)
    word: ClassVar[str] = "expression"

    def __post_init__(self):
        if not isinstance(self.text, str):
            raise ModelError(
                "Signal expression",
                found=f"text = {self.text!r}",
                expected="a formula between quotes",
                remedy='Write expression("2*sin(3*t)")',
            )
        object.__setattr__(self, "text", self.text.strip().removeprefix("=").strip())
        object.__setattr__(self, "parameters", dict(self.parameters))
        self.program()

    def program(self) -> SignalProgram:
        return compile_expression(self.text, self.parameters)


@dataclass(frozen=True, eq=False)
class _OfTerms(Signal):
    """Signals that one operation joins, from the first to the last."""

    terms: tuple[Signal, ...]
    operation: ClassVar[int]

    def __post_init__(self):
        object.__setattr__(self, "terms", _all_signals(self.terms, self.word))
        self._require_extent()

    @cached_property
    def extent(self) -> tuple[int, int]:
        sizes, depths = zip(*(term.extent for term in self.terms))
        return sum(sizes) + len(sizes) - 1, 1 + max(depths)

    def parts(self) -> tuple[Signal, ...]:
        return self.terms

    def program_of(self, parts):
        return parts[0].then(*(p.then(SignalProgram.of((self.operation, 0.0))) for p in parts[1:]))


@dataclass(frozen=True, eq=False)
class Sum(_OfTerms):
    """The sum of signals."""

    word: ClassVar[str] = "sum"
    operation: ClassVar[int] = op.ADD


@dataclass(frozen=True, eq=False)
class Product(_OfTerms):
    """The product of signals."""

    word: ClassVar[str] = "product"
    operation: ClassVar[int] = op.MULTIPLY


def _all_signals(terms: Any, word: str) -> tuple[Signal, ...]:
    if isinstance(terms, str | Mapping) or not isinstance(terms, Sequence) or not terms:
        raise ModelError(
            f"Signal {word}",
            found=f"terms = {terms!r}",
            expected="a list of signals",
            remedy=f"Write {word} = [first, second]",
        )
    return tuple(as_signal(term, f"Signal {word}", "terms") for term in terms)


def expression(text: str, /, **parameters: float) -> Expression:
    """Return the signal of a formula in ``t`` and named parameters: ``expression("a*t**2", a=3.0)``."""
    return Expression(text, parameters)


def as_signal(value: Any, part: str, field: str) -> Signal:
    """Return a signal from a signal, a number, or an ``"= expression"``; ModelError naming part and field otherwise."""
    if isinstance(value, Signal):
        return value
    if hasattr(value, "reading"):  # a sensor
        return value.reading()
    if isinstance(value, str) and value.lstrip().startswith("="):
        return Expression(value)
    if is_number(value):
        return Constant(float(value))
    remedy = f"Write {field} = fmb.ramp(rate=1.0), or a finite number"
    if isinstance(value, Mapping):  # from a model file
        near = did_you_mean(next(iter(value)), WORDS) if len(value) == 1 else ""
        remedy = near or f"Write {field} = {{ ramp = {{ rate = 1.0 }} }}, or a number"
    elif isinstance(value, str):
        word = value.strip()
        own = f'"= {word}" for a signal or parameter of this name, ' if word.isidentifier() else ""
        remedy = f'Write {field} = {own}"= 0.5*t" for an expression in a model file, a number without quotes'
    raise ModelError(
        part,
        found=f"{field} = {value!r}",
        expected=f"a signal: a number, a sensor, {', '.join(WORDS)}",
        remedy=remedy,
    )


def pack(programs: Sequence[SignalProgram]) -> tuple[np.ndarray, ...]:
    """Return the fields of `flexmb.math.jets.SignalCode` for all programs."""
    starts = np.cumsum([0] + [len(p.ops) for p in programs]).astype(np.int64)
    ops, args, tables = joined_arrays(programs)
    table_starts = np.cumsum([0] + [len(table) for table in tables]).astype(np.int64)
    return starts, ops, args, np.concatenate([*tables, np.empty(0)]), table_starts
