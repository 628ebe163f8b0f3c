"""`Function`: a signal that a function of the user computes from other signals; `Delay`: a signal that comes later."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from math import factorial
from typing import Any, ClassVar

import numpy as np

from flexmb.errors import ModelError
from flexmb.math.callbacks import Repeats, callback
from flexmb.model.block import Block
from flexmb.model.foreign import imported
from flexmb.model.linear_blocks import TransferFunction
from flexmb.model.measurement import signals_of

__all__ = ["Delay", "Function"]

TINY = 1e-30
"""Complex step: f(x + i h) = f + i h f' without anything else left (Squire & Trapp 1998)."""
LOOK = 1e-6
"""Step of the differences by which derivatives are looked at, relative."""


@dataclass(frozen=True, eq=False)
class Function(Block):
    """A signal f(t, x) of signals x, by a Python function or a compiled C function.

    A Python function takes t and x (n,) and returns a number, some 20 us a call; its derivatives come from `jacobian`,
    or are exact by complex steps, so that it must pass complex numbers then. A C function, an object with an
    ``address`` such as a `numba.cfunc` of ``void(CPointer(double), CPointer(double))``, reads t, x1, ..., xn and writes
    f, df/dx1, ..., df/dxn; it costs what it computes. Functions depend on their arguments only, and have no memory:
    they are called several times in a step, for a `Sampled` too. One call of 32 is made twice, and another answer ends
    the run.

    Parameters
    ----------
    of : signal, or list of signals
    function : callable, C function, or "module:function" in model files, which is imported only if the file is trusted
    jacobian : callable, or "module:function", optional
        Derivatives (n,) by x, with the same arguments.
    name : str, optional
    """

    of: Any
    _: KW_ONLY
    function: Any
    jacobian: Any = None
    name: str | None = None
    word: ClassVar[str] = "function"
    imports: ClassVar[tuple[str, ...]] = ("function", "jacobian")

    def __post_init__(self):
        object.__setattr__(self, "of", signals_of(self.of, self.title, "of"))
        for name in self.imports:
            value = getattr(self, name)
            wanted = value is None and name == "jacobian"
            if not (wanted or callable(value) or hasattr(value, "address") or isinstance(value, str)):
                raise ModelError(
                    self.title,
                    found=f"{name} = {value!r:.60}",
                    expected="a function (t, x), a C function with an address, or 'module:function'",
                    remedy=f"Write {name}=lambda t, x: ...",
                )
        object.__setattr__(self, "_state", {"failure": "", "looked": False, "kept": None, "repeats": Repeats()})

    def complaint(self) -> str:
        """Return what went wrong in the function, if anything did."""
        return self._state["failure"]  # type: ignore[attr-defined]

    def address(self) -> int:
        """Return the address of the C function."""
        if hasattr(self.function, "address"):
            return int(self.function.address)
        kept = self._state  # type: ignore[attr-defined]
        if kept["kept"] is None:
            object.__setattr__(self, "_function", imported(self.function, self.title))
            jacobian = None if self.jacobian is None else imported(self.jacobian, self.title)
            object.__setattr__(self, "_jacobian", jacobian)
            kept["kept"] = callback(self._run)
        return kept["kept"][1]

    def _run(self, inputs, outputs) -> None:
        n = len(self.of)
        given = np.ctypeslib.as_array(inputs, (1 + n,)).copy()
        out = np.ctypeslib.as_array(outputs, (1 + n,))
        state = self._state  # type: ignore[attr-defined]
        try:
            out[:] = self._derivatives(float(given[0]), given[1:])
            if not np.all(np.isfinite(out)) and not state["failure"]:
                state["failure"] = f"its function has no finite value or derivative at t = {given[0]:.6g} s"
        except Exception as error:  # whatever a user's function raises: it cannot pass through compiled code
            state["failure"] = state["failure"] or f"{type(error).__name__}: {error} at t = {given[0]:.6g} s"
            out[:] = np.nan

    def _derivatives(self, t: float, x: np.ndarray) -> np.ndarray:
        """Return f and its derivatives (1 + n,)."""
        f, jacobian = self._function, self._jacobian  # type: ignore[attr-defined]
        returned = f(t, x.copy())  # the function may write to its arguments
        if np.shape(returned):
            raise ValueError(
                f"the function returns an array {np.shape(returned)} in the place of a number; x holds the values "
                f"of all arguments ({len(x)}): read x[0], x[1], ..."
            )
        self._state["repeats"].require(returned, lambda: f(t, x.copy()))  # type: ignore[attr-defined]
        value = float(np.real(returned))
        if jacobian is not None:
            slopes = np.array(jacobian(t, x), float).reshape(len(x))
        else:
            moved = x.astype(complex) + 1j * TINY * np.eye(len(x))
            slopes = np.array([float(np.imag(f(t, row))) for row in moved]) / TINY
        if not self._state["looked"]:  # type: ignore[attr-defined]
            self._compare(t, x, slopes)
            self._state["looked"] = True  # type: ignore[attr-defined]
        return np.concatenate([[value], slopes])

    def _compare(self, t: float, x: np.ndarray, slopes: np.ndarray) -> None:
        """Raise ValueError where derivatives contradict differences, as of a function that drops imaginary
        parts.
        """
        f = self._function  # type: ignore[attr-defined]
        for k, slope in enumerate(slopes):
            step = LOOK * max(1.0, abs(x[k])) * (np.arange(len(x)) == k)
            ends = [float(np.real(f(t, x + way * step))) for way in (1.0, -1.0)]
            difference = (ends[0] - ends[1]) / (2.0 * step[k])
            rounding = 1e-8 * max(map(abs, ends)) / max(1.0, abs(x[k]))
            if abs(difference - slope) > 1e-3 * max(abs(difference), abs(slope)) + rounding:
                raise ValueError(
                    f"the derivative by argument {k} is {slope:.6g} by the function and {difference:.6g} by a "
                    "difference; give jacobian=, or use functions that pass complex numbers"
                )


@dataclass(frozen=True, eq=False)
class Delay(Block):
    """A signal that comes later, by Padé's approximation of exp(-T s) as a transfer function.

    Right up to frequencies of about `order` / T rad/s; of a step it makes some ripple before the step arrives.

    Parameters
    ----------
    of : signal
    time : float, s
        T.
    order : int
        1 to 8: number of states.
    name : str, optional
    """

    of: Any
    _: KW_ONLY
    time: float
    order: int = 3
    name: str | None = None
    word: ClassVar[str] = "delay"

    def __post_init__(self):
        self.follow("of")
        self.require("time", positive=True)
        if isinstance(self.order, bool) or self.order not in range(1, 9):
            raise ModelError(
                self.title, found=f"order = {self.order!r}", expected="1 to 8", remedy="Leave order out for 3"
            )
        n = self.order
        of_s = [factorial(2 * n - k) * factorial(n) / (factorial(2 * n) * factorial(k) * factorial(n - k)) for k in
                range(n, -1, -1)]  # fmt: skip
        powers = self.time ** np.arange(n, -1, -1.0)
        signs = (-1.0) ** np.arange(n, -1, -1.0)
        form = TransferFunction(self.of, numerator=of_s * powers * signs, denominator=of_s * powers, name=self.name)
        object.__setattr__(self, "_form", form)

    def states(self):
        return self._form.states()  # type: ignore[attr-defined]

    def rates(self):
        return tuple(self._form.own(rate, self) for rate in self._form.forms()[0])  # type: ignore[attr-defined]

    def output(self):
        return self._form.own(self._form.forms()[1], self)  # type: ignore[attr-defined]
