"""Ancestors of what joints are made of: primitive equations that they demand, primitive freedoms that they permit."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

from flexmb.model.table import Compiler, Table

__all__ = ["Equation", "Freedom"]


@dataclass(frozen=True)
class Equation:
    """A primitive constraint: what one record table of equations holds."""

    table: ClassVar[Table]
    count: ClassVar[int] = 1
    level: ClassVar[int] = 0
    """0: g(q, t) = 0; 1: A(q, t) u + rate = 0."""
    stiffens: ClassVar[bool] = True

    def involved(self, markers: tuple[int, ...]) -> tuple[int, ...]:
        """Return the joint's markers on which the equation acts: one leg each, in this order."""
        return markers[:2]

    def idle(self, a: str, b: str) -> tuple[str, str, str] | None:
        """Return what is found, expected and to be done where no small motion of markers a and b changes the equation;
        None: other causes are likelier."""
        return None

    def record(self, compiler: Compiler, markers: tuple[int, ...]) -> dict[str, Any]:
        """Return fields of the row by name, where they differ from the fields of the primitive (see `Table.filled`)."""
        return {}


@dataclass(frozen=True)
class Freedom:
    """A primitive freedom that a joint permits: what it is called, what measures it, what it does in a tree."""

    turns: ClassVar[bool] = True
    """Does it turn the markers against each other, wherever they are?"""

    @property
    def word(self) -> str:
        """How drives, forces and sensors call it; empty if it has no single coordinate."""
        return ""

    @property
    def role(self) -> str:
        """What it is in the chain of a tree joint, "slide", "turn", "screw", "turn_b" or "ball"; empty: nothing."""
        return ""

    @property
    def coordinate(self):
        """The coordinate (`flexmb.constraints.Coordinate`) that measures it."""
        raise TypeError(f"{type(self).__name__} has no coordinate")

    @property
    def labels(self) -> tuple[str, ...]:
        """Names of its coordinates in a tree."""
        return (self.word,)

    @property
    def rate_labels(self) -> tuple[str, ...]:
        """Names of its rates in a tree."""
        return self.labels
