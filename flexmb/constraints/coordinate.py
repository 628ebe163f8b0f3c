"""`Coordinate`: one scalar that two markers have, a turn, a slide or a distance, and how its row is written."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from flexmb.math.tables import DAMPED

__all__ = ["COORDINATE", "DISTANCE", "NO_COORDINATE", "SLIDE", "TURN", "Coordinate"]

TURN, SLIDE, DISTANCE = 0, 1, 2
"""Kinds of coordinates in rows."""

KINDS = {"turn": TURN, "slide": SLIDE, "distance": DISTANCE}

COORDINATE = np.dtype(
    [
        ("kind", np.int64),  # TURN, SLIDE or DISTANCE
        ("axis", np.int64),  # turn: axis of b that is followed; slide: axis of a
        ("sign", float),  # -1 where the markers are exchanged
        ("a", np.int64),
        ("b", np.int64),
        ("pair", np.int64),
        ("branch", np.int64),  # number of the branch coordinate that counts full turns, or -1
    ],
    align=True,
)
"""How a kernel measures a coordinate."""

NO_COORDINATE: dict[str, Any] = {"kind": TURN, "axis": 0, "sign": 1.0, "a": 0, "b": 0, "pair": 0, "branch": -1}
"""In rows that measure none."""


@dataclass(frozen=True)
class Coordinate:
    """What is measured between two markers: a turn about z, a slide along an axis of a, or a distance.

    Parameters
    ----------
    kind : "turn", "slide" or "distance"
    axis : "x", "y" or "z"
        Turn: the axis of b whose direction is followed. Slide: the axis of a.
    swapped : bool
        Measured from b to a with opposite sign: the turn about the z-axis of b.
    """

    kind: str
    axis: str = "x"
    swapped: bool = False

    @property
    def unit(self) -> str:
        """Return rad or m."""
        return "rad" if self.kind == "turn" else "m"

    def branch(self, a: str, b: str) -> str:
        """Return the name of the branch that counts the full turns between two markers."""
        return f"turn {'back' if self.swapped else 'on'} {self.axis}: {a}, {b}"

    def value(self, compiler, a: int, b: int) -> float:
        """Return the coordinate of markers a and b as described."""
        (r_a, R_a), (r_b, R_b) = (compiler.pose(m) for m in ((b, a) if self.swapped else (a, b)))
        if self.kind == "distance":
            return float(np.linalg.norm(r_b - r_a))
        if self.kind == "slide":
            return float(R_a[:, "xyz".index(self.axis)] @ (r_b - r_a))
        e = R_b[:, "xyz".index(self.axis)]
        return float(np.arctan2(R_a[:, 1] @ e, R_a[:, 0] @ e)) * (-1.0 if self.swapped else 1.0)

    def record(self, compiler, a: int, b: int, counts: bool = True, writes: int = DAMPED) -> dict[str, Any]:
        """Return the row of the coordinate; with `counts`, turns are followed through full turns.

        `writes` says whether the kernel adds stiffness (STIFF) or also damping (DAMPED) to the pair of markers; 0:
        neither.
        """
        branch = -1
        if counts and self.kind == "turn":
            name = self.branch(compiler.marker_name(a), compiler.marker_name(b))
            branch = compiler.branch(name, self.value(compiler, a, b))
        first, second = (b, a) if self.swapped else (a, b)
        sign = -1.0 if self.swapped else 1.0
        pair = compiler.pair(first, second, writes) if writes else -1
        return {
            "kind": KINDS[self.kind],
            "axis": "xyz".index(self.axis),
            "sign": sign,
            "a": first,
            "b": second,
            "pair": pair,
            "branch": branch,
        }
