"""Measured scalars: numbers that depend on the motion of at most two markers, with all derivatives that a loop needs.

A joint coordinate, a component of a position or a velocity, the cosine between two axes: whatever reads the motion
while it is computed (constraints of the user) reads such scalars. A signal of time is one whose gradient is zero.
Their derivatives are written by `constraints.measured_kernels`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

from flexmb.constraints.coordinate import NO_COORDINATE, Coordinate
from flexmb.constraints.measured_kernels import ACCELERATION, POSITION, REACTION, SIGNAL, VELOCITY, WHATS

__all__ = ["IN_LOOPS", "Combination", "Measured", "Projected", "in_axes"]

IN_LOOPS = ("state", "acceleration", "wrench", "reaction", "multiplier")
"""What loops alone can read."""


@dataclass(frozen=True)
class Combination:
    """weights . eta + constant, with the flexible coordinates eta of a reduced body.

    Parameters
    ----------
    body : str
    weights : (m,)
    constant : float
    """

    body: str
    weights: tuple[float, ...]
    constant: float = 0.0


@dataclass(frozen=True)
class Measured:
    """A scalar that is measured while the motion is computed.

    Parameters
    ----------
    what : one of `WHATS`
    markers : tuple of str
        (a, b) of a coordinate or cosine; (b,) of a place, velocity or spin in the axes of W; (a, b) of a velocity or
        spin along an axis of a.
    axis, other : int
        Number of the axis of a (or of W), and of the axis of b.
    coordinate : Coordinate, optional
        What is measured between a and b.
    signal : Signal, optional
    state : (str, str or None), optional
        Name of a part and of its state: a velocity to whoever reads it, without the rate that depends on the forces.
    rate : bool
        The rate of a position or of a signal.
    held : int
        Number of the branch that holds a value.
    combination : Combination, optional
        Of flexible coordinates: a "place".
    part : str
        Name of the force, or of the joint.
    pair : int
        Of a wrench: the pair of the force by whose markers it changes.
    """

    what: str
    markers: tuple[str, ...] = ()
    axis: int = 0
    other: int = 0
    coordinate: Coordinate | None = None
    signal: Any = None
    rate: bool = False
    state: tuple[str, str | None] | None = None
    held: int = -1
    combination: Combination | None = None
    part: str = ""
    pair: int = 0

    @property
    def sort(self) -> int:
        """POSITION, VELOCITY, SIGNAL, ACCELERATION or REACTION."""
        if self.what in ("signal", "held"):
            return SIGNAL
        if self.what in ("reaction", "multiplier"):
            return REACTION
        if self.what == "acceleration":
            return ACCELERATION
        return VELOCITY if self.rate or self.what in ("velocity", "spin", "state", "wrench") else POSITION

    @property
    def alone(self) -> bool:
        """Can loops alone read it, not constraints?"""
        return self.what in IN_LOOPS or self.combination is not None

    def of_rate(self) -> Measured:
        """Return the rate of a position or of a signal."""
        return replace(self, rate=True)

    def record(self, compiler, leg_of: Callable[[int], int]) -> dict[str, Any]:
        """Return the row of the scalar by field name; `leg_of` a marker is its leg, -1: of none."""
        c: dict[str, Any] = NO_COORDINATE
        signal = self.held if self.signal is None else compiler.signal(self.signal)
        numbers = [compiler.marker(name) for name in self.markers]
        a, b = numbers if len(numbers) == 2 else (-1, *numbers) if numbers else (-1, -1)
        if self.coordinate is not None:
            c = self.coordinate.record(compiler, a, b, writes=0)
            a, b = c["a"], c["b"]  # exchanged where the coordinate is measured backwards
        axis, last, frame = self.axis, -1, 0
        if self.state is not None:
            b, axis = compiler.state_place(*self.state)
        if self.combination is not None:
            b, axis = compiler.combined(self.combination), 0
        if self.what == "acceleration":
            frame = int(compiler.model.body(self.markers[0].partition(".")[0]).has_frame)
        if self.sort == REACTION:
            equations = compiler.equations[self.part]
            signal, last = equations.start + (axis if self.what == "multiplier" else 0), equations.stop
        if self.what == "wrench":
            signal, last, a, b = compiler.loops.wrenches.place(self.part, self.pair)
        at = [leg_of(m) for m in (a, b)]
        return {
            "what": WHATS.index(self.what),
            "rate": int(self.rate),
            "axis": axis,
            "other": self.other,
            "signal": signal,
            "last": last,
            "source": -1,
            "frame": frame,
            "a": a,
            "b": b,
            "leg_a": at[0],
            "leg_b": at[1],
            "c": c,
        }


@dataclass(frozen=True)
class Projected:
    """The component of a vector of W along an axis of a marker: a sum of products of scalars.

    Parameters
    ----------
    vector : three Measured
    axes : str
        "body.marker".
    axis : int
    """

    vector: tuple[Measured, Measured, Measured]
    axes: str
    axis: int
    alone: bool = True

    @property
    def sort(self) -> int:
        """That of the components."""
        return self.vector[0].sort

    @property
    def products(self) -> tuple[tuple[Measured, Measured], ...]:
        """The factors of each term."""
        return tuple((z, Measured("cosine", (self.axes,), k, self.axis)) for k, z in enumerate(self.vector))


def in_axes(vectors: tuple[Measured, ...], axes: str | None) -> tuple[Measured | Projected, ...]:
    """Return the components of vectors (three each) in the axes of a marker, or in W."""
    if axes is None:
        return vectors
    threes = [vectors[k : k + 3] for k in range(0, len(vectors), 3)]
    return tuple(Projected(three, axes, axis) for three in threes for axis in range(3))  # type: ignore[arg-type]
