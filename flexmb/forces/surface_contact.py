"""`SurfaceContact`: surfaces that press on, and rub against, each other."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import KW_ONLY, dataclass
from typing import Any, ClassVar

import numpy as np

from flexmb.errors import ModelError
from flexmb.forces.contact_laws import ContactLaw
from flexmb.forces.crowd import gaps_in_crowd
from flexmb.forces.surface_checks import check_pair, check_rigid, check_skins, check_two_bodies, kind_of
from flexmb.forces.surface_rows import PAIR_STRIDE, ROW, apply, sweep, switch
from flexmb.forces.surface_spots import sampled_points, surface_spots
from flexmb.model.kinds import Force
from flexmb.model.spots import Spots
from flexmb.model.table import Table
from flexmb.surfaces.advancement import POSE
from flexmb.surfaces.neighbours import near_among
from flexmb.surfaces.records import REACH
from flexmb.surfaces.skin_surface import pieces_of

__all__ = ["MOST_PAIRS", "PAIR_STRIDE", "SurfaceContact"]

MOST_PAIRS = 5000
"""Pairs of surfaces that have their own places in the iteration matrix; more are a crowd."""


def _count_pairs(side: np.ndarray, body: np.ndarray) -> int:
    """Return how many pairs surfaces of different bodies make, from their groups and bodies, see `members`."""
    in_first, in_second, in_both = (np.bincount(body, weights=side & k == k) for k in (1, 2, 3))
    twice = 0.5 * (in_both.sum() ** 2 - in_both @ in_both)
    return int(in_first.sum() * in_second.sum() - in_first @ in_second - twice)


@dataclass(frozen=True, eq=False)
class SurfaceContact(Force):
    """Let surfaces touch: each of the first with each of the second, by one law.

    Parameters
    ----------
    name : str
    surfaces : (str, str), or two groups of names
        Names of surfaces a and b; either may be a tuple of names. Surfaces of one body never touch each other.
    law : ContactLaw
        `ElasticFoundation`, `Hertz`, or `Rigid` for the integrator `MoreauJean`.
    """

    name: str
    _: KW_ONLY
    surfaces: Any
    law: Any

    table: ClassVar[Table] = Table(
        "SurfaceContact", ROW, {"apply": apply, "switch": switch, "sweep": sweep}, switches="switches"
    )
    strikes: ClassVar[bool] = True

    def __post_init__(self):
        super().__post_init__()
        given = self.surfaces
        groups = []
        for entry in given if isinstance(given, tuple | list) else ():
            names = (entry,) if isinstance(entry, str) else tuple(entry) if isinstance(entry, tuple | list) else ()
            groups.append(names if all(isinstance(name, str) for name in names) else ())
        if len(groups) != 2 or not all(groups):
            raise ModelError(
                self.title,
                found=f"surfaces = {given!r}",
                expected="two names of surfaces, or two groups of names",
                remedy="Write surfaces=('floor', 'ball'), or surfaces=('floor', ('ball_1', 'ball_2'))",
            )
        object.__setattr__(self, "surfaces", tuple(g[0] if len(g) == 1 else g for g in groups))
        if not isinstance(self.law, ContactLaw):
            raise ModelError(
                self.title,
                found=f"law = {self.law!r:.80}",
                expected="a law of contact: ElasticFoundation, Hertz, Rigid",
                remedy="Write law=fmb.ElasticFoundation(modulus=1e7, thickness=0.01)",
            )

    def pairs(self, model) -> list[tuple[Any, Any]]:
        """Return the surfaces of different bodies that may touch, two by two, each pair once."""
        groups = self._surfaces(model)
        found: dict[tuple[str, str], tuple[Any, Any]] = {}
        for a in groups[0]:
            for b in groups[1]:
                apart = a.marker.partition(".")[0] != b.marker.partition(".")[0]
                if apart and (b.name, a.name) not in found:
                    found[a.name, b.name] = (a, b)
        return list(found.values())

    def _surfaces(self, model) -> tuple[list[Any], list[Any]]:
        """Return the surfaces of both sides, skins as their pieces."""
        first, second = self.groups
        return pieces_of(model, first, self.title), pieces_of(model, second, self.title)

    def crowded(self, model) -> bool:
        """Are there so many pairs that those near each other are looked for?"""
        first, second = self._surfaces(model)
        if self.impulsive or len(first) * len(second) <= MOST_PAIRS:
            return False
        _, side, body = self.members(model)
        return _count_pairs(side, body) > MOST_PAIRS

    def check(self, model) -> None:
        """Raise ModelError if a surface does not exist, none can touch, or the law cannot be used for a pair."""
        groups = self._surfaces(model)
        check_skins(self, groups)
        if self.impulsive:
            check_rigid(self, groups)
            return
        check_two_bodies(self, groups)
        for a, b in self._unlike_pairs(groups) if self.crowded(model) else self.pairs(model):
            check_pair(self, a, b)

    def _unlike_pairs(self, groups) -> list[tuple[Any, Any]]:
        """Return pairs of surfaces of different bodies, of each kind that may meet another one."""
        some: list[dict[Any, Any]] = [{}, {}]
        for found, group in zip(some, groups, strict=True):
            for s in group:  # two of every kind, of different bodies
                key, body = (kind_of(s), s.spacing is None), s.marker.partition(".")[0]
                first = found.setdefault((*key, 0), s)
                if first.marker.partition(".")[0] != body:
                    found.setdefault((*key, 1), s)
        both = [(a, b) for a in some[0].values() for b in some[1].values()]
        return [(a, b) for a, b in both if a.marker.partition(".")[0] != b.marker.partition(".")[0]]

    def unseen_in(self, model) -> str:
        """Return that edges that cross are not seen, for a rigid law where there are such."""
        first, second = (
            [s for s in group if np.isfinite(s.shape.reach) and kind_of(s) != "Sphere"]
            for group in self._surfaces(model)
        )
        unknown = [next((s for s in group if not s.shape.edged), None) for group in (first, second)]
        if not self.impulsive or not first or not second or not any(unknown):
            return ""
        a, b = unknown[0] or first[0], unknown[1] or second[0]
        return (
            f"edges of '{a.name}' and '{b.name}' that cross are not seen: except between cuboids, hulls, meshes and "
            "capsules, a rigid law acts where a corner of one surface meets the other. Where edges can meet first, use "
            "a TriangleMesh, an ElasticFoundation, or put spheres on an edge"
        )

    def measure(self, model) -> str | None:
        """Return the marker of the second surface, where `ForceOf` reports; None if there are several."""
        markers = {surface.marker for surface in self._surfaces(model)[1]}
        return markers.pop() if len(markers) == 1 else None

    def points(self, model) -> tuple[list[str], np.ndarray]:
        """Return the markers of all sampled points, and their places, normals and areas (n, 7) in the axes of these."""
        return sampled_points(self, model)

    def spots(self, series) -> Iterator[Spots]:
        """Yield what touches at every sample of a phase."""
        return surface_spots(self, series)

    @property
    def groups(self) -> tuple[tuple[str, ...], tuple[str, ...]]:
        """The names of the surfaces on both sides."""
        first, second = ((entry,) if isinstance(entry, str) else entry for entry in self.surfaces)
        return first, second

    @property
    def impulsive(self) -> bool:
        """Does its law need a method of impulses?"""
        return self.law.impulsive

    def touching_markers(self, model) -> list[str]:
        """Return the markers of all its surfaces, each once."""
        return list(dict.fromkeys(surface.marker for group in self._surfaces(model) for surface in group))

    def kept_names(self, marker: str) -> list[str]:
        """Return the names of the coordinates that keep the wrench on a marker."""
        return [f"{self.title}: {part} on {marker}" for part in ("fx", "fy", "fz", "mx", "my", "mz")]

    def slip_unit(self, model) -> str:
        """Return m, if its law has regularised friction."""
        return "m" if getattr(self.law, "transition", None) is not None and self.law.friction > 0.0 else ""

    def record(self, compiler) -> dict[str, Any]:
        """Return the row."""
        if self.impulsive:
            return self._kept_record(compiler)
        if self.crowded(compiler.model):
            return self._crowd_record(compiler)
        table, capacity = [], 1
        for pair in self.pairs(compiler.model):
            (a, at_a), (b, at_b) = (compiler.surface(surface) for surface in pair)
            most = sum(len(s.points[0]) for s in pair) if self.law.sampled else 1
            capacity = max(capacity, most + 1)
            table.append([a, b, compiler.pair(a, b, alone=True), at_a, at_b])
        at = compiler.bulk(np.array(table, float))
        numbers = self.law.numbers()
        own = {"pairs": at, "count": len(table), "crowd": 0, "switches": 2 * len(table), "capacity": capacity}
        return {**own, "law": self.law.code, **numbers}

    def members(self, model) -> tuple[list[Any], np.ndarray, np.ndarray]:
        """Return all surfaces, each once, their groups (1, 2 or both: 3), and the numbers of their bodies."""
        groups = self._surfaces(model)
        surfaces = list({s.name: s for group in groups for s in group}.values())
        named = [{s.name for s in group} for group in groups]
        side = np.array([(s.name in named[0]) + 2 * (s.name in named[1]) for s in surfaces], np.int64)
        bodies: dict[str, int] = {}
        body = np.array([bodies.setdefault(s.marker.partition(".")[0], len(bodies)) for s in surfaces], np.int64)
        return surfaces, side, body

    def gaps(self, model, rows: np.ndarray) -> list[tuple[tuple[Any, Any], float]]:
        """Return pairs of surfaces, those of a crowd that are near each other, each with its gap (m)."""
        if not self.crowded(model):
            return list(zip(self.pairs(model), rows[::2, 1].tolist(), strict=True))
        surfaces, side, body = self.members(model)
        packed = [s.packed for s in surfaces]
        reach = np.array([numbers[REACH] for numbers in packed])
        pairs = near_among(np.ascontiguousarray(rows[:, POSE : POSE + 3]), reach, side, body)
        starts = np.concatenate([[0], np.cumsum([len(numbers) for numbers in packed])])
        found = np.zeros(len(pairs))
        gaps_in_crowd(np.concatenate(packed), starts, int(self.law.sampled), rows, pairs, found)
        return [((surfaces[i], surfaces[j]), gap) for (i, j), gap in zip(pairs, found.tolist(), strict=True)]

    def _crowd_record(self, compiler) -> dict[str, Any]:
        """Return the row of a crowd, see `flexmb.forces.crowd`."""
        surfaces, side, body = self.members(compiler.model)
        table = []
        for s, groups, number in zip(surfaces, side, body, strict=True):
            marker, place = compiler.surface(s)
            table.append([marker, place, groups, number, compiler.pair(marker, marker)])
        samples = sorted(len(s.points[0]) for s in surfaces)[-2:]
        at = compiler.bulk(np.array(table, float))
        own = {"pairs": at, "count": len(table), "crowd": 1, "switches": len(table)}
        most = sum(samples) if self.law.sampled else 1
        return {**own, "capacity": most + 1, "law": self.law.code, **self.law.numbers()}

    def _kept_record(self, compiler) -> dict[str, Any]:
        """Return the row of a rigid law, with a place for the wrench on every marker."""
        table = []
        for marker in self.touching_markers(compiler.model):
            branches = [compiler.branch(name) for name in self.kept_names(marker)]
            table.append([compiler.marker(marker), branches[0], 0, 0, 0])
        at = compiler.bulk(np.array(table, float))
        own = {"pairs": at, "count": len(table), "crowd": 0, "switches": 0, "capacity": 1, "law": self.law.code}
        return {**own, **self.law.numbers()}
