"""Blocks whose values jump: relays, quantisers, and what computers do at sample times.

Source: Åström & Wittenmark, Computer-Controlled Systems, 3rd ed. 1997 (sec. 2.3: zero-order hold; 2.4: state space).
"""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from typing import Any, ClassVar

import numpy as np

from flexmb.errors import ModelError
from flexmb.model.block import matrix
from flexmb.model.described import finite_array
from flexmb.model.held_block import HeldBlock
from flexmb.model.measurement import Formula, signals_of
from flexmb.model.signal import Signal

__all__ = ["HELD_BLOCKS", "Quantiser", "Relay", "Sampled", "SampledStateSpace"]


@dataclass(frozen=True, eq=False)
class Relay(HeldBlock):
    """A switch with hysteresis: on when the signal rises above the higher limit, off when it falls below the lower one.

    The times of switching are located like events, and steps end there.

    Parameters
    ----------
    of : signal
    limits : (float, float)
        At which it switches off, and on.
    values : (float, float)
        Off and on.
    on : bool
        At the start, if the signal lies between the limits.
    name : str, optional
    """

    of: Any
    _: KW_ONLY
    limits: tuple[float, float]
    values: tuple[float, float] = (0.0, 1.0)
    on: bool = False
    name: str | None = None
    word: ClassVar[str] = "relay"

    def __post_init__(self):
        self.follow("of")
        self.require_limits()
        if self.limits is None or not isinstance(self.on, bool):
            raise ModelError(
                self.title,
                found=f"limits = {self.limits!r}, on = {self.on!r}",
                expected="two numbers, at which it switches off and on, and true or false",
                remedy="Write limits=(-0.1, 0.1); with limits that are equal it would switch without end",
            )
        values = finite_array(self.values)
        if values.shape != (2,):
            raise ModelError(
                self.title,
                found=f"values = {self.values!r}",
                expected="two numbers, off and on",
                remedy="Write values=(-1.0, 1.0)",
            )
        object.__setattr__(self, "values", (float(values[0]), float(values[1])))

    def held(self):
        return {"on": float(self.on)}

    def reads(self):
        return (self.of,)

    def crossing(self) -> Signal:
        over = {"u": self.of, "on": self.value("on")}
        return Formula("where(on > 0.5, low - u, u - high)", over, {"low": self.limits[0], "high": self.limits[1]})

    def following(self, held: np.ndarray, read: np.ndarray) -> np.ndarray:
        return 1.0 - held

    def output(self) -> Signal:
        off, on = self.values
        return Formula("off + by*on", {"on": self.value("on")}, {"off": off, "by": on - off})


@dataclass(frozen=True, eq=False)
class Quantiser(HeldBlock):
    """A signal in whole steps: the nearest one, as an encoder or a converter tells it.

    It goes on when the signal is further away than half a step and half the `hysteresis`; that time is located, and
    steps of the integrator end there.

    Parameters
    ----------
    of : signal
    step : float
    hysteresis : float
        Relative to the step.
    name : str, optional
    """

    of: Any
    _: KW_ONLY
    step: float
    hysteresis: float = 0.0
    name: str | None = None
    word: ClassVar[str] = "quantiser"

    def __post_init__(self):
        self.follow("of")
        self.require("step", positive=True)
        self.require("hysteresis")
        if not 0.0 <= self.hysteresis < 1.0:
            raise ModelError(
                self.title,
                found=f"hysteresis = {self.hysteresis!r}",
                expected="0 to less than 1, relative to the step",
                remedy="Leave it out for none",
            )

    def held(self):
        return {"level": 0.0}

    def reads(self):
        return (self.of,)

    def crossing(self) -> Signal:
        over = {"u": self.of, "level": self.value("level")}
        return Formula("abs(u/step - level) - half", over, {"step": self.step, "half": 0.5 * (1.0 + self.hysteresis)})

    def following(self, held: np.ndarray, read: np.ndarray) -> np.ndarray:
        away = read[0] / self.step - held[0]
        return held + np.sign(away) * np.maximum(1.0, np.ceil(np.abs(away) - 0.5))

    def output(self) -> Signal:
        return Formula("step*level", {"level": self.value("level")}, {"step": self.step})


class _Periodic(HeldBlock):
    """What happens at sample times."""

    def _require_period(self) -> None:
        self.require("period", positive=True)
        self.require("offset")


@dataclass(frozen=True, eq=False)
class Sampled(_Periodic):
    """A signal that is sampled and held (zero-order hold): at ``offset + k period`` it takes the signal's value.

    Parameters
    ----------
    of : signal
    period : float, s
    offset : float, s
        Of one sample.
    start : float
        Until the first sample.
    name : str, optional
    """

    of: Any
    _: KW_ONLY
    period: float
    offset: float = 0.0
    start: float = 0.0
    name: str | None = None
    word: ClassVar[str] = "sampled"

    def __post_init__(self):
        self.follow("of")
        self._require_period()
        self.require("start")

    def held(self):
        return {"y": self.start}

    def reads(self):
        return (self.of,)

    def following(self, held: np.ndarray, read: np.ndarray) -> np.ndarray:
        return read

    def output(self) -> Signal:
        return self.value("y")


@dataclass(frozen=True, eq=False)
class SampledStateSpace(_Periodic):
    """A controller in discrete time, y = C x + D u, then x <- A x + B u, at ``offset + k period``; y is held between.

    Parameters
    ----------
    of : signal, or list of signals
    A, B, C, D : (n, n), (n, m), (p, n), (p, m)
        Or, as A alone, an object with these and a time step `dt`: a system of scipy.signal or python-control in
        discrete time.
    period : float, s, optional
        By default the `dt` of the object.
    offset : float, s
        Of one sample.
    row : int
        Which output.
    start : (n,), optional
        x at the first sample.
    name : str, optional
    """

    of: Any
    _: KW_ONLY
    A: Any
    B: Any = None
    C: Any = None
    D: Any = None
    period: float | None = None  # type: ignore[assignment]
    offset: float = 0.0
    row: int = 0
    start: Any = None
    name: str | None = None
    word: ClassVar[str] = "sampled_state_space"

    def __post_init__(self):
        object.__setattr__(self, "of", signals_of(self.of, self.title, "of"))
        system = self.A.to_ss() if hasattr(self.A, "to_ss") else self.A
        if hasattr(system, "A") and hasattr(system, "D"):
            step = getattr(system, "dt", None)
            if self.period is None and isinstance(step, float | int) and not isinstance(step, bool):
                object.__setattr__(self, "period", float(step))
            for name in "ABCD":
                object.__setattr__(self, name, getattr(system, name))
        self._require_period()
        m = len(self.of)
        A = matrix(self.A, None, None, self.title, "A")
        n = len(A)
        for name, shape in {"A": (n, n), "B": (n, m), "C": (None, n), "D": (None, m)}.items():
            given = getattr(self, name)
            if name == "D" and given is None:
                given = np.zeros((len(self.C), m))
            array = matrix(given, *shape, self.title, name)
            object.__setattr__(self, name, tuple(map(tuple, array.tolist())))
        row = self.row if isinstance(self.row, int) and not isinstance(self.row, bool) else -1
        if not 0 <= row < len(self.D) or len(self.C) != len(self.D):
            raise ModelError(
                self.title,
                found=f"row = {self.row!r}; C has {len(self.C)} rows, D {len(self.D)}",
                expected="one of the outputs, counted from 0; as many rows in C as in D",
                remedy="Correct row, C or D",
            )
        start = np.zeros(n) if self.start is None else finite_array(self.start)
        if start.shape != (n,):
            raise ModelError(
                self.title, found=f"start = {self.start!r}", expected=f"{n} numbers", remedy="Correct start"
            )
        object.__setattr__(self, "start", tuple(start.tolist()))

    def held(self):
        return {**{f"x{k + 1}": x for k, x in enumerate(self.start)}, "y": 0.0}

    def reads(self):
        return self.of

    def following(self, held: np.ndarray, read: np.ndarray) -> np.ndarray:
        x = held[:-1]
        y = np.array(self.C[self.row]) @ x + np.array(self.D[self.row]) @ read
        return np.append(np.array(self.A) @ x + np.array(self.B) @ read, y)

    def output(self) -> Signal:
        return self.value("y")


HELD_BLOCKS: dict[str, type[Signal]] = {kind.word: kind for kind in (Relay, Quantiser, Sampled, SampledStateSpace)}
"""Kinds of held blocks by the word that makes them in model files."""
