"""`LineTable` and `PressureTable`: loads given by tables over the span, and over span and chord, on any mesh."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from flexmb.errors import ReductionError
from flexmb.fem.fe_model import FEModel
from flexmb.model.described import entries_of, finite_array, is_number
from flexmb.reduction.load_clouds import LoadCloud, Target, mapped_forces, target_of
from flexmb.reduction.loads import Load, facets_of
from flexmb.reduction.selection import nodes_of

__all__ = ["LineTable", "MappedLoad", "PressureTable"]

GAUSS = np.array([0.5 - np.sqrt(0.15), 0.5, 0.5 + np.sqrt(0.15)]), np.array([5.0, 8.0, 5.0]) / 18.0
"""Three points and weights on 0..1, exact to the fifth degree."""
MOST = 200_000
"""Points of a table's integration."""
REACH = 0.5
"""Largest distance of a load from the elements, over the diagonal of their box, by default."""


class MappedLoad(Load):
    """A load that is given in space, not on a mesh. Fields `on` and `reach`; `cloud` tells its forces at points."""

    on: Any = None
    reach: float | None = None

    def cloud(self, spacing: float) -> LoadCloud:
        """Return the forces at points, at most `spacing`, m, apart where they can be chosen."""
        raise TypeError(f"{type(self).__name__} does not tell its forces at points")

    def nodal(self, fe: FEModel, part: str) -> np.ndarray:
        """Return the nodal forces and moments of the unit load (n, 6), N and N m, in body axes."""
        target = self._target(fe, part)
        reach = self.reach if self.reach is not None else REACH * target.size(fe.nodes)
        return mapped_forces(fe, target, self.cloud(target.spacing(fe.nodes)), reach, part)

    def _target(self, fe: FEModel, part: str) -> Target:
        if self.on is None:
            return target_of(fe, np.arange(len(fe.nodes)), [], part)
        if isinstance(self.on, str) and self.on in fe.facet_sets:
            return target_of(fe, np.arange(0), facets_of(fe, self.on, part), part)
        return target_of(fe, nodes_of(fe, self.on, part), [], part)

    def check_reach(self, title: str) -> None:
        """Raise ReductionError unless `reach` is None or positive."""
        if self.reach is not None and (not is_number(self.reach) or self.reach <= 0.0):
            raise ReductionError(
                title, found=f"reach = {self.reach!r} m", expected="a positive length", remedy="Leave reach out"
            )


@dataclass(frozen=True, kw_only=True, eq=False)
class LineTable(MappedLoad):
    """Force and moment per length along a line, linear between the stations of a table.

    Mapped onto beams, shells or facets of solids with the same resultant force and moment.

    Parameters
    ----------
    points : (n, 3), m
        Stations of the table, in body axes; the line goes straight from one to the next.
    force : (3,), N/m
        Every component is a number for all stations, or a list with one for each.
    moment : (3,), N m/m
        Likewise, about the line.
    on : set name or node numbers, optional
        Beams or shells whose nodes all lie in the set, or a facet set; by default all beams and shells.
    reach : float, m, optional
        Farther from the elements no load may lie; by default half of the diagonal of their box.
    turns_with : str, optional
        As in `LineLoad`.
    """

    points: Any
    force: Any = (0.0, 0.0, 0.0)
    moment: Any = (0.0, 0.0, 0.0)
    on: Any = None
    reach: float | None = None
    turns_with: str | None = None

    def __post_init__(self):
        points = finite_array(self.points)
        if points.ndim != 2 or points.shape[1:] != (3,) or len(points) < 2:
            raise ReductionError(
                "LineTable",
                found=f"points = {self.points!r:.80}",
                expected="two or more stations of three numbers, m",
                remedy="Write points = [[0, 0, 0], [0, 5.75, 0]]",
            )
        if not np.all(np.linalg.norm(np.diff(points, axis=0), axis=1) > 0.0):
            raise ReductionError(
                "LineTable",
                found="two neighbouring stations at the same place",
                expected="stations one behind the other",
                remedy="Remove one of them",
            )
        object.__setattr__(self, "points", points)
        for field in ("force", "moment"):
            object.__setattr__(self, field, _columns(getattr(self, field), len(points), field))
        self.check_reach("LineTable")

    def cloud(self, spacing: float) -> LoadCloud:
        """Return the loads at three points of every piece, which is at most `spacing`, m, long."""
        lengths = np.linalg.norm(np.diff(self.points, axis=0), axis=1)
        counts = np.maximum(1, np.ceil(np.minimum(lengths / spacing, MOST / 3 / len(lengths)))).astype(int)
        stations, weights = [], []
        for k, (length, count) in enumerate(zip(lengths, counts)):
            stations.append(k + (np.arange(count)[:, None] + GAUSS[0]).ravel() / count)
            weights.append(np.tile(GAUSS[1], count) * length / count)
        at, weight = np.concatenate(stations), np.concatenate(weights)[:, None]
        number = np.arange(len(self.points))
        point, force, moment = (
            np.column_stack([np.interp(at, number, table[:, k]) for k in range(3)])
            for table in (self.points, self.force, self.moment)
        )
        return LoadCloud(point, weight * force, weight * moment)


@dataclass(frozen=True, kw_only=True, eq=False)
class PressureTable(MappedLoad):
    """A pressure over span and chord of a plane or twisted surface with four corners, bilinear between table entries.

    The difference of pressure between lower and upper side, or on one side. Mapped onto beams, shells or facets of
    solids with the same resultant force and moment.

    Parameters
    ----------
    corners : (4, 3), m
        Leading edge at the root, trailing edge at the root, trailing edge at the tip, leading edge at the tip; in body
        axes. A positive pressure pushes along the chord x (root to tip): upwards for x aft, y outboard, z up.
    span, chord : (n,) and (m,), -
        Fractions 0..1 of span and chord of the table, ascending; beyond the first and last the pressure is constant.
    pressure : (n, m), Pa
        A row for each station of the span.
    on, reach, turns_with
        As in `LineTable`.
    """

    corners: Any
    span: Any
    chord: Any
    pressure: Any
    on: Any = None
    reach: float | None = None
    turns_with: str | None = None

    def __post_init__(self):
        corners = finite_array(self.corners)
        if corners.shape != (4, 3):
            raise ReductionError(
                "PressureTable",
                found=f"corners = {self.corners!r:.80}",
                expected="four points: leading and trailing edge at the root, trailing and leading edge at the tip, m",
                remedy="Write corners = [[0, 0, 0], [1, 0, 0], [1, 5, 0], [0, 5, 0]]",
            )
        object.__setattr__(self, "corners", corners)
        for field in ("span", "chord"):
            given = finite_array(getattr(self, field))
            if given.ndim != 1 or not len(given) or np.any(np.diff(given) <= 0) or given[0] < 0 or given[-1] > 1:
                raise ReductionError(
                    "PressureTable",
                    found=f"{field} = {getattr(self, field)!r:.80}",
                    expected="ascending fractions 0..1",
                    remedy=f"Write {field} = [0, 0.5, 1]",
                )
            object.__setattr__(self, field, given)
        pressure = finite_array(self.pressure)
        if pressure.shape != (len(self.span), len(self.chord)):
            raise ReductionError(
                "PressureTable",
                found=f"a table of finite pressures of the shape {pressure.shape}",
                expected=f"{len(self.span)} rows over the span with {len(self.chord)} values over the chord",
                remedy="Give one row for each station of the span",
            )
        object.__setattr__(self, "pressure", pressure)
        self.check_reach("PressureTable")

    def cloud(self, spacing: float) -> LoadCloud:
        """Return the forces at three by three points of every field, which is at most `spacing`, m, wide."""
        a, b, c, d = self.corners
        width, depth = max(_far(a, d), _far(b, c)), max(_far(a, b), _far(d, c))
        share = max(1.0, np.sqrt(width * depth / spacing**2 * 9.0 / MOST))
        (v, weight_v), (u, weight_u) = (
            _divided(table, size / (share * spacing)) for table, size in ((self.span, width), (self.chord, depth))
        )
        v, u = v[:, None, None], u[None, :, None]
        along, across = (1 - v) * (b - a) + v * (c - d) + 0 * u, (1 - u) * (d - a) + u * (c - b) + 0 * v
        points = (1 - u) * ((1 - v) * a + v * d) + u * ((1 - v) * b + v * c)
        rows = np.array([np.interp(u[0, :, 0], self.chord, row) for row in self.pressure])
        pressure = np.array([np.interp(v[:, 0, 0], self.span, rows[:, k]) for k in range(rows.shape[1])]).T
        weight = (pressure * weight_v[:, None] * weight_u)[:, :, None]
        forces = (weight * np.cross(along, across)).reshape(-1, 3)
        return LoadCloud(points.reshape(-1, 3), forces, np.zeros_like(forces))


def _far(a: np.ndarray, b: np.ndarray) -> float:
    return float(np.linalg.norm(b - a))


def _divided(table: np.ndarray, pieces: float) -> tuple[np.ndarray, np.ndarray]:
    """Return places 0..1 and weights of an integral over kinks at the entries of a table."""
    ends = np.unique(np.concatenate([[0.0, 1.0], table]))
    places, weights = [], []
    for low, high in pairwise(ends):
        count = max(1, int(np.ceil(pieces * (high - low))))
        places.append(low + (high - low) * (np.arange(count)[:, None] + GAUSS[0]).ravel() / count)
        weights.append(np.tile(GAUSS[1], count) * (high - low) / count)
    return np.concatenate(places), np.concatenate(weights)


def _columns(value: Any, count: int, field: str) -> np.ndarray:
    """Return (count, 3) from three components, each a number or a list of one for each station."""
    given = finite_array(value)
    if given.shape == (count, 3) and count != 3:
        return given
    entries = [finite_array(entry) for entry in entries_of(value)]
    if len(entries) != 3 or any(entry.shape not in ((), (count,)) for entry in entries):
        raise ReductionError(
            "LineTable",
            found=f"{field} = {value!r:.80}",
            expected=f"three components, each a number or a list of {count}, one for each station",
            remedy=f"Write {field} = [0, 0, [100.0, 80.0]]",
        )
    return np.column_stack([np.broadcast_to(entry, (count,)) for entry in entries])
