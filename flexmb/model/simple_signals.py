"""Signals of a few numbers: ramps, steps and oscillations."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from flexmb.math import operations as op
from flexmb.model.expression import SignalProgram
from flexmb.model.signal import Signal

__all__ = ["Harmonic", "Ramp", "Step", "harmonic", "ramp", "step"]


@dataclass(frozen=True, eq=False, kw_only=True)
class Ramp(Signal):
    """A value whose rate grows from 0 to `rate` by a cosine during `rise` and then stays.

    With tau = t - start: x = rate/2 (tau - rise/pi sin(pi tau/rise)) for tau < rise, then x = rate (tau - rise/2).

    Parameters
    ----------
    rate : float, unit of the value per second
    rise : float, s
        Duration of the growth; 0 starts with the full rate.
    start : float, s
    """

    rate: float
    rise: float = 0.0
    start: float = 0.0
    word: ClassVar[str] = "ramp"

    def __post_init__(self):
        self._numbers("rate", "rise", "start")
        self._require("rise", self.rise >= 0.0, "a duration >= 0 s")

    def program(self) -> SignalProgram:
        if self.rise == 0.0:
            return SignalProgram.of(*_since(self.start), (op.CONSTANT, self.rate), (op.MULTIPLY, 0.0))
        return SignalProgram.of(
            *_fraction(self.start, self.rise),
            (op.SOFT_RAMP, 0.0),
            (op.CONSTANT, self.rate * self.rise),
            (op.MULTIPLY, 0.0),
        )


@dataclass(frozen=True, eq=False, kw_only=True)
class Step(Signal):
    """A change from `initial` to `value`, sudden or smooth.

    The smooth change is the quintic 10 s^3 - 15 s^4 + 6 s^5 of s = (t - at)/rise: rate and second rate are continuous.

    Parameters
    ----------
    value, initial : float
        Value after and before.
    at : float, s
        When the change begins.
    rise : float, s
        How long it lasts; 0 is sudden.
    """

    value: float
    initial: float = 0.0
    at: float = 0.0
    rise: float = 0.0
    word: ClassVar[str] = "step"

    def __post_init__(self):
        self._numbers("value", "initial", "at", "rise")
        self._require("rise", self.rise >= 0.0, "a duration >= 0 s")

    def program(self) -> SignalProgram:
        shape = (*_fraction(self.at, self.rise or 1.0), (op.SMOOTH if self.rise else op.STEP, 0.0))
        return SignalProgram.of(
            *shape,
            (op.CONSTANT, self.value - self.initial),
            (op.MULTIPLY, 0.0),
            (op.CONSTANT, self.initial),
            (op.ADD, 0.0),
        )


@dataclass(frozen=True, eq=False, kw_only=True)
class Harmonic(Signal):
    """An oscillation offset + amplitude sin(2 pi frequency (t - start) + phase).

    Its first value is held before `start`.

    Parameters
    ----------
    amplitude, offset : float
    frequency : float, Hz
    phase : float, rad
    start : float, s
    """

    amplitude: float
    frequency: float
    phase: float = 0.0
    offset: float = 0.0
    start: float = 0.0
    word: ClassVar[str] = "harmonic"

    def __post_init__(self):
        self._numbers("amplitude", "frequency", "phase", "offset", "start")

    def program(self) -> SignalProgram:
        return SignalProgram.of(
            *_since(self.start),
            (op.CONSTANT, 2.0 * np.pi * self.frequency),
            (op.MULTIPLY, 0.0),
            (op.CONSTANT, self.phase),
            (op.ADD, 0.0),
            (op.SIN, 0.0),
            (op.CONSTANT, self.amplitude),
            (op.MULTIPLY, 0.0),
            (op.CONSTANT, self.offset),
            (op.ADD, 0.0),
        )


def _since(start: float) -> tuple[tuple[int, float], ...]:
    """Operations of max(t - start, 0)."""
    return (op.TIME, 0.0), (op.CONSTANT, start), (op.SUBTRACT, 0.0), (op.CONSTANT, 0.0), (op.MAX, 0.0)


def _fraction(start: float, duration: float) -> tuple[tuple[int, float], ...]:
    """Operations of (t - start)/duration."""
    return (op.TIME, 0.0), (op.CONSTANT, start), (op.SUBTRACT, 0.0), (op.CONSTANT, duration), (op.DIVIDE, 0.0)


def ramp(rate: float, rise: float = 0.0, start: float = 0.0) -> Ramp:
    """Return a value whose rate grows smoothly from 0 to `rate` (per second) during `rise` (s) and then stays."""
    return Ramp(rate=rate, rise=rise, start=start)


def step(value: float, initial: float = 0.0, at: float = 0.0, rise: float = 0.0) -> Step:
    """Return a change from `initial` to `value` that begins `at` (s) and is smooth if `rise` (s) is positive."""
    return Step(value=value, initial=initial, at=at, rise=rise)


def harmonic(
    amplitude: float, frequency: float, phase: float = 0.0, offset: float = 0.0, start: float = 0.0
) -> Harmonic:
    """Return offset + amplitude sin(2 pi frequency (t - start) + phase); frequency in Hz, phase in rad."""
    return Harmonic(amplitude=amplitude, frequency=frequency, phase=phase, offset=offset, start=start)
