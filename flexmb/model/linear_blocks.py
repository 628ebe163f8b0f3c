"""Linear blocks: state space, transfer functions. Source: Kailath, Linear Systems, 1980, sec. 2.1 (controller form)."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from typing import Any, ClassVar

import numpy as np

from flexmb.errors import ModelError
from flexmb.model.block import Block, linear, matrix
from flexmb.model.described import entries_of, finite_array
from flexmb.model.measurement import Formula, signals_of
from flexmb.model.signal import Signal

__all__ = ["StateSpace", "TransferFunction"]


@dataclass(frozen=True, eq=False)
class StateSpace(Block):
    """x' = A x + B u, y = C x + D u of one or several signals u; one output y.

    Parameters
    ----------
    of : signal, or list of signals
    A, B, C, D : (n, n), (n, m), (p, n), (p, m)
        Or, as A alone, an object with these: a system of scipy.signal or python-control in continuous time.
    row : int
        Which output.
    start : (n,), optional
    sizes_of_states : (n,), optional
        Values up to which errors are absolute.
    name : str, optional
    """

    of: Any
    _: KW_ONLY
    A: Any
    B: Any = None
    C: Any = None
    D: Any = None
    row: int = 0
    start: Any = None
    sizes_of_states: Any = None
    name: str | None = None
    word: ClassVar[str] = "state_space"

    def __post_init__(self):
        object.__setattr__(self, "of", signals_of(self.of, self.title, "of"))
        system = self.A
        if hasattr(system, "to_ss"):
            system = system.to_ss()
        if hasattr(system, "A") and hasattr(system, "D"):
            if getattr(system, "dt", None):
                raise ModelError(
                    self.title,
                    found=f"a system in discrete time, dt = {system.dt!r}",
                    expected="a system in continuous time",
                    remedy="Convert it, or design it in continuous time",
                )
            for name in "ABCD":
                object.__setattr__(self, name, getattr(system, name))
        A, m = finite_array(self.A), len(self.of)
        n = len(np.atleast_2d(A)) if A.size else 0 if len(entries_of(self.A)) == 0 else 1  # what is wrong is refused
        shapes = {"A": (n, n), "B": (n, m), "C": (None, n), "D": (None, m)}
        for name, shape in shapes.items():
            given = getattr(self, name)
            if name == "D" and given is None:
                given = np.zeros((len(self.C), m))
            array = matrix(given, *shape, self.title, name)
            object.__setattr__(self, name, tuple(map(tuple, array.tolist())))
        row = self.row if isinstance(self.row, int) and not isinstance(self.row, bool) else -1
        if not 0 <= row < len(self.D) or (n and len(self.C) != len(self.D)):
            raise ModelError(
                self.title,
                found=f"row = {self.row!r}; C has {len(self.C)} rows, D {len(self.D)}",
                expected="one of the outputs, counted from 0; as many rows in C as in D",
                remedy="Correct row, C or D",
            )
        for name, usual in (("start", 0.0), ("sizes_of_states", 1.0)):
            given = getattr(self, name)
            array = np.full(n, usual) if given is None else finite_array(given)
            if array.shape != (n,):
                raise ModelError(
                    self.title, found=f"{name} = {given!r}", expected=f"{n} numbers", remedy=f"Correct {name}"
                )
            object.__setattr__(self, name, tuple(array.tolist()))

    def states(self):
        return {f"x{k + 1}": x for k, x in enumerate(self.start)}

    def sizes(self):
        return {f"x{k + 1}": x for k, x in enumerate(self.sizes_of_states)}

    def _sum(self, of_states, of_inputs) -> Signal:
        terms = {f"x{k + 1}": (a, self.state(f"x{k + 1}")) for k, a in enumerate(of_states)}
        return linear({**terms, **{f"u{k + 1}": (b, u) for k, (b, u) in enumerate(zip(of_inputs, self.of))}})

    def rates(self):
        return tuple(self._sum(a, b) for a, b in zip(self.A, self.B))

    def output(self) -> Signal:
        return self._sum(self.C[self.row] if self.C else (), self.D[self.row])


@dataclass(frozen=True, eq=False)
class TransferFunction(Block):
    """The rational transfer function numerator(s) / denominator(s) of a signal, in controller form.

    Parameters
    ----------
    of : signal
    numerator, denominator : (m + 1,), (n + 1,)
        Coefficients, highest power of s first, m <= n: as scipy.signal and python-control have them.
    start : (n,), optional
        Of the states.
    name : str, optional
    """

    of: Any
    _: KW_ONLY
    numerator: Any
    denominator: Any
    start: Any = None
    name: str | None = None
    word: ClassVar[str] = "transfer_function"

    def __post_init__(self):
        self.follow("of")
        for name in ("numerator", "denominator"):
            given = np.atleast_1d(finite_array(getattr(self, name)))
            if given.ndim != 1 or not np.any(given):
                raise ModelError(
                    self.title,
                    found=f"{name} = {getattr(self, name)!r}",
                    expected="finite coefficients, highest power of s first, not all zero",
                    remedy=f"Write {name}=[1.0, 2.0]",
                )
            object.__setattr__(self, name, tuple(np.trim_zeros(given, "f").tolist()))
        if len(self.numerator) > len(self.denominator):
            raise ModelError(
                self.title,
                found=f"a numerator of degree {len(self.numerator) - 1} over a denominator of degree "
                f"{len(self.denominator) - 1}",
                expected="a numerator of no higher degree: derivatives of signals are not known",
                remedy="Add a pole that is fast enough, or measure the rate",
            )
        object.__setattr__(self, "_form", self._controller_form())

    def _controller_form(self) -> StateSpace:
        lead, n = self.denominator[0], len(self.denominator) - 1
        a = np.array(self.denominator[1:]) / lead
        b = np.concatenate([np.zeros(n + 1 - len(self.numerator)), self.numerator]) / lead
        A = np.vstack([-a, np.eye(n)[:-1]]) if n else np.zeros((0, 0))
        B, C = np.eye(n)[:, :1], (b[1:] - a * b[0])[None]
        return StateSpace(self.of, A=A, B=B, C=C, D=[[b[0]]], start=self.start, name=self.name)

    def states(self):
        return self._form.states()  # type: ignore[attr-defined]

    def rates(self):
        return tuple(self.own(rate, self) for rate in self.forms()[0])

    def output(self) -> Signal:
        return self.own(self.forms()[1], self)

    def forms(self) -> tuple[tuple[Any, ...], Any]:
        """Return rates and output of the state space."""
        return self._form.rates(), self._form.output()  # type: ignore[attr-defined]

    @staticmethod
    def own(of_form: Any, block: Block) -> Signal:
        """Return a formula of the state space with the states of a block."""
        over = {name: block.state(name) if name.startswith("x") else u for name, u in of_form.over.items()}
        return Formula(of_form.text, over, of_form.parameters)
