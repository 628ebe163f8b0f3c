"""Coordinate systems and grid points of a Nastran deck."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flexmb.errors import MeshError
from flexmb.fem.deck.nastran_text import Bulk, Card

__all__ = ["Grids", "System", "Systems", "read_grids"]

DEEPEST = 60
"""Systems that refer each to the next."""

PARALLEL = 1e-8
"""Sine of the angle below which the two directions of a coordinate system count as parallel."""


@dataclass(frozen=True, eq=False)
class System:
    """A coordinate system: kind "R", "C" or "S", origin (3,), axes (3, 3) with rows x, y, z in the basic system."""

    kind: str
    origin: np.ndarray
    axes: np.ndarray

    def points(self, values: np.ndarray) -> np.ndarray:
        """Return basic positions (n, 3) of coordinates (n, 3); angles are in degrees."""
        return self.origin + self._local(values) @ self.axes

    def _local(self, values: np.ndarray) -> np.ndarray:
        if self.kind == "R":
            return values
        r, first, second = values[:, 0], np.radians(values[:, 1]), values[:, 2]
        if self.kind == "C":
            return np.stack([r * np.cos(first), r * np.sin(first), second], axis=1)
        phi = np.radians(second)
        return np.stack([r * np.sin(first) * np.cos(phi), r * np.sin(first) * np.sin(phi), r * np.cos(first)], axis=1)

    def directions(self, points: np.ndarray) -> np.ndarray:
        """Return the local axes (n, 3, 3) at basic positions (n, 3): rows are the directions 1, 2, 3."""
        if self.kind == "R":
            return np.broadcast_to(self.axes, (len(points), 3, 3))
        x, y, z = ((points - self.origin) @ self.axes.T).T
        out = np.zeros((len(points), 3, 3))
        radius, phi = np.hypot(x, y), np.arctan2(y, x)
        phi = np.where(radius > 0.0, phi, 0.0)
        radial = np.stack([np.cos(phi), np.sin(phi), np.zeros_like(phi)], axis=1)
        around = np.stack([-np.sin(phi), np.cos(phi), np.zeros_like(phi)], axis=1)
        up = np.broadcast_to([0.0, 0.0, 1.0], radial.shape)
        if self.kind == "C":
            out[:, 0], out[:, 1], out[:, 2] = radial, around, up
        else:
            theta = np.arctan2(radius, z)[:, None]
            out[:, 0] = np.sin(theta) * radial + np.cos(theta) * up
            out[:, 1] = np.cos(theta) * radial - np.sin(theta) * up
            out[:, 2] = around
        return out @ self.axes


BASIC = System("R", np.zeros(3), np.eye(3))


class Systems:
    """All coordinate systems of a deck, resolved when asked for; they may refer to each other and to grid points."""

    def __init__(self, bulk: Bulk):
        self.cards: dict[int, Card] = {}
        for name in ("CORD1R", "CORD1C", "CORD1S", "CORD2R", "CORD2C", "CORD2S"):
            for card in bulk.of(name):
                for number in self._numbers(card):
                    if number in self.cards and self.cards[number].fields[1:] != card.fields[1:]:
                        raise card.refused(f"coordinate system {number} a second time", "one card per number")
                    self.cards[number] = card
        self.known: dict[int, System] = {0: BASIC}
        self._open: list[int] = []
        self.grids: Grids | None = None

    @staticmethod
    def _numbers(card: Card) -> list[int]:
        if card.name.startswith("CORD2"):
            return [card.integer(1)]
        return [card.integer(1)] + ([card.integer(5)] if card.text(5) else [])

    def system(self, number: int, who: str) -> System:
        """Return a system by number; MeshError if there is none, or if systems refer to each other in a circle."""
        if number in self.known:
            return self.known[number]
        if number not in self.cards:
            raise MeshError(
                who,
                found=f"the coordinate system {number}, which does not exist",
                expected=f"0, or one of: {', '.join(map(str, sorted(self.cards))) or 'none'}",
                remedy="Add its CORD card",
            )
        if number in self._open:
            raise MeshError(
                who,
                found=f"coordinate systems that refer to each other: {' -> '.join(map(str, [*self._open, number]))}",
                expected="systems that end at the basic one",
                remedy="Correct their reference systems",
            )
        if len(self._open) >= DEEPEST:
            raise MeshError(
                who,
                found=f"more than {DEEPEST} coordinate systems that refer each to the next",
                expected="systems that end at the basic one",
                remedy="Refer to the basic system",
            )
        self._open.append(number)
        try:
            made = self._made(self.cards[number], number)
        finally:
            self._open.pop()
        self.known[number] = made
        return made

    def _made(self, card: Card, number: int) -> System:
        if card.name.startswith("CORD2"):
            reference = self.system(card.integer(2, 0), card.where)
            values = np.array([[card.real(i + k, 0.0) for k in range(3)] for i in (3, 6, 9)])
            a, b, c = reference.points(values)
        else:
            assert self.grids is not None
            first = 2 if card.integer(1) == number else 6
            a, b, c = (self.grids.position(card.integer(first + k), self, card.where) for k in range(3))
        z, along = b - a, c - a
        size = np.linalg.norm(z)
        y = np.cross(z, along)
        if size == 0.0 or np.linalg.norm(y) <= PARALLEL * size * float(np.linalg.norm(along)):
            raise card.refused(
                "three points on one line", "a point on the z-axis and one in the x-z plane", "Correct the points"
            )
        z, y = z / size, y / np.linalg.norm(y)
        return System(card.name[-1], a, np.stack([np.cross(y, z), y, z]))


class Grids:
    """Grid points as written: labels (n,) ascending, cp and cd systems, coordinates."""

    def __init__(self, bulk: Bulk):
        table = bulk.tables.get("GRID")
        base = bulk.of("GRDSET")
        cp0, cd0 = (base[0].integer(2, 0), base[0].integer(6, 0)) if base else (0, 0)
        if table is None or not len(table):
            self.labels = np.zeros(0, np.int64)
            self.cp = self.cd = self.labels
            self.values = np.zeros((0, 3))
            return
        labels = table.integers(1)
        order = np.argsort(labels, kind="stable")
        self.values = np.stack([table.reals(3 + k) for k in range(3)], axis=1)[order]
        self.labels = labels[order]
        self.cp, self.cd = table.integers(2, cp0)[order], table.integers(6, cd0)[order]
        same = np.flatnonzero(np.diff(self.labels) == 0)
        if (self.labels < 1).any():
            raise table.card(int(order[0])).wrong(1, "a positive number")
        if len(same):
            different = same[
                (self.values[same] != self.values[same + 1]).any(axis=1) | (self.cp[same] != self.cp[same + 1])
            ]
            if len(different):
                k = int(different[0])
                raise MeshError(
                    table.where(int(order[k + 1])),
                    found=f"grid point {int(self.labels[k])} a second time, at another place",
                    expected="one GRID card per number",
                    remedy="Renumber one of the two",
                )
            kept = np.append(np.diff(self.labels) != 0, True)
            self.labels, self.values, self.cp, self.cd = (x[kept] for x in (self.labels, self.values, self.cp, self.cd))

    def position(self, label: int, systems: Systems, who: str) -> np.ndarray:
        """Return the basic position (3,) of one grid point."""
        at = int(np.searchsorted(self.labels, label))
        if at == len(self.labels) or self.labels[at] != label:
            raise MeshError(
                who,
                found=f"the grid point {label}, which does not exist",
                expected="a GRID card",
                remedy="Add it, or correct the number",
            )
        return systems.system(int(self.cp[at]), who).points(self.values[at : at + 1])[0]


def read_grids(bulk: Bulk, systems: Systems, part: str) -> tuple[np.ndarray, np.ndarray, dict[int, np.ndarray]]:
    """Return labels (n,), basic positions (n, 3), and by node the axes (3, 3) of its displacements if not basic."""
    grids = Grids(bulk)
    systems.grids = grids
    points = grids.values.copy()
    for number in np.unique(grids.cp):
        rows = grids.cp == number
        if number != 0:
            points[rows] = systems.system(int(number), f"{part}, grid points").points(grids.values[rows])
    frames: dict[int, np.ndarray] = {}
    for number in np.unique(grids.cd):
        if number in (0, -1):
            continue
        system = systems.system(int(number), f"{part}, grid points")
        rows = np.flatnonzero(grids.cd == number)
        for row, axes in zip(rows, system.directions(points[rows]), strict=True):
            if not np.array_equal(axes, np.eye(3)):
                frames[int(row)] = axes
    return grids.labels, points, frames
