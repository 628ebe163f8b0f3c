"""The blocks: limits and dead zones, lags, integrators, controllers.

Source: Åström & Hägglund, Advanced PID Control, 2006 (sec. 3.5: tracking against windup; 3.3: filtered derivative).
"""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from typing import Any, ClassVar

from flexmb.model.block import Block, limited, linear
from flexmb.model.linear_blocks import StateSpace, TransferFunction
from flexmb.model.measurement import Formula
from flexmb.model.signal import Signal

__all__ = ["BLOCKS", "DeadZone", "Integral", "Lag", "Limit", "Pid", "RateLimit", "StateSpace", "TransferFunction"]


@dataclass(frozen=True, eq=False)
class _BetweenLimits(Block):
    """What changes its law where a signal meets one of two limits."""

    of: Any
    _: KW_ONLY
    limits: tuple[float, float]

    def __post_init__(self):
        self.follow("of")
        self.require_limits(optional=False)


@dataclass(frozen=True, eq=False)
class Limit(_BetweenLimits):
    """A signal within limits (saturation).

    Parameters
    ----------
    of : signal
    limits : (float, float)
    """

    word: ClassVar[str] = "limit"

    def output(self) -> Signal:
        return limited(self.of, self.limits)


@dataclass(frozen=True, eq=False)
class DeadZone(_BetweenLimits):
    """Zero between two limits, and the distance from them outside.

    Parameters
    ----------
    of : signal
    limits : (float, float)
    """

    word: ClassVar[str] = "dead_zone"

    def output(self) -> Signal:
        return self.of - limited(self.of, self.limits)


@dataclass(frozen=True, eq=False)
class Lag(Block):
    """First-order lag, T x' = u - x: a filter, an actuator that needs time.

    Parameters
    ----------
    of : signal
    time : float, s
        Time constant T.
    start : float
    size : float
        Value up to which errors are absolute.
    name : str, optional
    """

    of: Any
    _: KW_ONLY
    time: float
    start: float = 0.0
    size: float = 1.0
    name: str | None = None
    word: ClassVar[str] = "lag"

    def __post_init__(self):
        self.follow("of")
        self.require("time", "size", positive=True)
        self.require("start")

    def states(self):
        return {"x": self.start}

    def sizes(self):
        return {"x": self.size}

    def rates(self):
        return (Formula("(u - x)/T", {"u": self.of, "x": self.state("x")}, {"T": self.time}),)

    def output(self) -> Signal:
        return self.state("x")


@dataclass(frozen=True, eq=False)
class Integral(Block):
    """The integral of a signal, x' = gain u, within limits.

    Beyond a limit the state is drawn back within the time `tracking`, so that it does not wind up.

    Parameters
    ----------
    of : signal
    gain : float
    start : float
    limits : (float, float), optional
        Of the output.
    tracking : float, s
    size : float
        Value up to which errors are absolute.
    name : str, optional
    """

    of: Any
    _: KW_ONLY
    gain: float = 1.0
    start: float = 0.0
    limits: tuple[float, float] | None = None
    tracking: float = 0.1
    size: float = 1.0
    name: str | None = None
    word: ClassVar[str] = "integral"

    def __post_init__(self):
        self.follow("of")
        self.require("gain", "start")
        self.require("tracking", "size", positive=True)
        self.require_limits()

    def states(self):
        return {"x": self.start}

    def sizes(self):
        return {"x": self.size}

    def rates(self):
        if self.limits is None:
            return (linear({"u": (self.gain, self.of)}),)
        over = {"u": self.of, "x": self.state("x"), "y": self.output()}
        return (Formula("k*u + (y - x)/T", over, {"k": self.gain, "T": self.tracking}),)

    def output(self) -> Signal:
        return self.state("x") if self.limits is None else limited(self.state("x"), self.limits)


@dataclass(frozen=True, eq=False)
class Pid(Block):
    """Proportional, integral and derivative control of an error e: the output is v = kp e + i + kd e', within limits.

    i is the integral part, i' = ki e, which begins at `start`. e' is the signal `rate`, exact where it is measured, or
    the rate of a filtered error, (e - f) / T with T f' = e - f, which begins at f = 0.
    With `limits` the output is y, the nearest value to v within them, and i' = ki e + (y - v) / `tracking`, against
    windup: within the limits that is ki e (Åström & Hägglund 2006, sec. 3.5).

    Parameters
    ----------
    of : signal
        The error, wanted minus measured.
    kp, ki, kd : float
    rate : signal, optional
        Rate of the error.
    filter : float, s
        T of the filter where no rate is given.
    limits : (float, float), optional
        Of the output.
    tracking : float, s, optional
        By default kp / ki, the integral time.
    start : float
        Of the integral part, in units of the output.
    size : float
        Value of the output up to which errors are absolute.
    name : str, optional
    """

    of: Any
    _: KW_ONLY
    kp: float = 0.0
    ki: float = 0.0
    kd: float = 0.0
    rate: Any = None
    filter: float = 0.01
    limits: tuple[float, float] | None = None
    tracking: float | None = None
    start: float = 0.0
    size: float = 1.0
    name: str | None = None
    word: ClassVar[str] = "pid"

    def __post_init__(self):
        self.follow("of", *(["rate"] if self.rate is not None else []))
        self.require("kp", "ki", "kd", "start")
        self.require("filter", "size", *(["tracking"] if self.tracking is not None else []), positive=True)
        self.require_limits()

    @property
    def _filters(self) -> bool:
        return self.kd != 0.0 and self.rate is None

    def states(self):
        own = {"integral": self.start} if self.ki != 0.0 else {}
        return {**own, "filtered": 0.0} if self._filters else own

    def sizes(self):
        return {"integral": self.size, "filtered": self.size / max(abs(self.kp), abs(self.kd) / self.filter, 1e-300)}

    def _free(self) -> Signal:
        """The output without limits."""
        terms = {"p": (self.kp, self.of), "i": (0.0, self.of), "d": (0.0, self.of)}
        if self.ki != 0.0:
            terms["i"] = (1.0, self.state("integral"))
        if self._filters:
            terms["p"] = (self.kp + self.kd / self.filter, self.of)
            terms["d"] = (-self.kd / self.filter, self.state("filtered"))
        elif self.rate is not None:
            terms["d"] = (self.kd, self.rate)
        return linear(terms)

    def rates(self):
        found = []
        if self.ki != 0.0 and self.limits is None:
            found.append(linear({"e": (self.ki, self.of)}))
        elif self.ki != 0.0:
            free = self._free()
            given = abs(self.kp / self.ki) if self.tracking is None else self.tracking
            over = {"e": self.of, "y": limited(free, self.limits), "v": free}
            found.append(Formula("ki*e + (y - v)/T", over, {"ki": self.ki, "T": given or 1.0}))
        if self._filters:
            over = {"e": self.of, "f": self.state("filtered")}
            found.append(Formula("(e - f)/T", over, {"T": self.filter}))
        return tuple(found)

    def output(self) -> Signal:
        return self._free() if self.limits is None else limited(self._free(), self.limits)


@dataclass(frozen=True, eq=False)
class RateLimit(Block):
    """A signal that is followed with a limited rate, x' = (u - x) / T within the limits: a servo valve, a ramp.

    Parameters
    ----------
    of : signal
    limits : (float, float), per second
        Of the rate.
    time : float, s
        T, with which it follows what changes slowly.
    start : float
    size : float
        Value up to which errors are absolute.
    name : str, optional
    """

    of: Any
    _: KW_ONLY
    limits: tuple[float, float]
    time: float = 0.01
    start: float = 0.0
    size: float = 1.0
    name: str | None = None
    word: ClassVar[str] = "rate_limit"

    def __post_init__(self):
        self.follow("of")
        self.require("time", "size", positive=True)
        self.require("start")
        self.require_limits(optional=False)

    def states(self):
        return {"x": self.start}

    def sizes(self):
        return {"x": self.size}

    def rates(self):
        return (limited(self._free(), self.limits),)

    def _free(self) -> Signal:
        """The rate without limits."""
        return Formula("(u - x)/T", {"u": self.of, "x": self.state("x")}, {"T": self.time})

    def output(self) -> Signal:
        return self.state("x")


BLOCKS: dict[str, type[Signal]] = {
    kind.word: kind for kind in (Limit, DeadZone, Lag, Integral, Pid, RateLimit, StateSpace, TransferFunction)
}
"""Kinds of blocks by the word that makes them in model files."""
