"""`SurfaceContact`: surfaces that press on, and rub against, each other."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import KW_ONLY, dataclass
from typing import Any, ClassVar

import numpy as np

from flexmb.errors import ModelError
from flexmb.forces.contact_laws import ContactLaw
from flexmb.forces.contact_wrench import act_at_contact
from flexmb.forces.relative import act_relative, add_relative_tangent, relative_motion
from flexmb.forces.surface_spots import sampled_points, surface_spots
from flexmb.math.kernel import inner_kernel
from flexmb.math.switches import GAP, IDLE, SLIP, sweep_kernel, switch_kernel
from flexmb.math.tables import DAMPED, row_kernel
from flexmb.math.vectors import cross, dot
from flexmb.model.kinds import Force
from flexmb.model.spots import Spots
from flexmb.model.table import Table
from flexmb.surfaces.advancement import first_touch
from flexmb.surfaces.detection import find_areas, find_closest, nearest_sample
from flexmb.surfaces.patch import Patch
from flexmb.surfaces.records import CONTACT, REACH
from flexmb.surfaces.skin_surface import pieces_of

__all__ = ["PAIR_STRIDE", "SurfaceContact"]

MOST_PAIRS = 5000


def _kind(surface) -> str:
    return type(surface.shape).__name__


ROW = np.dtype(
    [
        ("pairs", np.int64),  # where the pairs of surfaces begin in the bulk data, `PAIR_STRIDE` numbers each
        ("count", np.int64),  # how many they are
        ("switches", np.int64),  # two of each pair
        ("capacity", np.int64),  # most contacts of a pair, and one more
        ("law", np.int64),
        ("stiffness", float),  # N/m^e, or per area
        ("exponent", float),
        ("damping", float),  # s/m
        ("friction", float),
        ("transition", float),  # m/s
        ("restitution", float),
    ],
    align=True,
)
PAIR_STRIDE = 8
"""Marker of a and of b, number of the pair in the matrix, place of surface a and of b in the bulk data, most contacts,
weight of the gap among the switches (0: one of many points), 0."""


@inner_kernel
def _found(row, data, at_a, at_b, margin, d, Q, contacts):
    """Write the contacts of a pair; return how many."""
    if row.law == 0:
        return find_areas(data, at_a, at_b, margin, d, Q, contacts)
    return find_closest(data, at_a, at_b, margin, d, Q, contacts)


@inner_kernel
def _far(a, b, reach):
    """Are two markers farther apart than the balls around their surfaces reach?"""
    square = 0.0
    for i in range(3):
        square += (b.r[i] - a.r[i]) ** 2
    return square >= reach * reach


@inner_kernel
def _act_as_kept(row, data, state, work):
    """Let the wrenches act on markers that a method found for its rigid contacts; they stand in the last coordinates.

    A method of impulses has none there while it looks for them.
    """
    first = len(state.q) - len(work.branches)
    for k in range(row.count):
        at = row.pairs + PAIR_STRIDE * k
        marker, branch = work.markers[int(data[at])], int(data[at + 1])
        for i in range(6):
            wrench = state.q[first + branch + i]
            marker.wrench[i] += wrench
            work.branches[branch + i] = wrench


@row_kernel
def apply(raw, data, state, work):
    """Force and friction at every contact, eq. (surface-contact), as a wrench on the markers of the surfaces."""
    rows = raw.view(ROW)
    motion = np.empty(9)
    Q = np.empty((3, 3))
    f = np.empty(6)
    K = np.empty((6, 6))
    C = np.empty((6, 6))
    for m in range(rows.shape[0]):
        row = rows[m]
        if row.law > 1:
            _act_as_kept(row, data, state, work)
            continue
        contacts = np.empty(row.capacity, CONTACT)
        wanted = work.weights[0].wanted == 1
        for k in range(row.count):
            at = row.pairs + PAIR_STRIDE * k
            a, b = work.markers[int(data[at])], work.markers[int(data[at + 1])]
            at_a, at_b = int(data[at + 3]), int(data[at + 4])
            if wanted:
                # most pairs touch nothing: their blocks need neither clearing nor adding
                work.pairs[int(data[at + 2])].active = 0
            if _far(a, b, data[at_a + REACH] + data[at_b + REACH]):
                continue
            relative_motion(a, b, motion, Q)
            count = _found(row, data, at_a, at_b, 0.0, motion[0:3], Q, contacts)
            if count == 0:
                continue
            f[:] = 0.0
            K[:] = 0.0
            C[:] = 0.0
            for c in range(count):
                act_at_contact(row, contacts[c], motion, wanted, f, K, C, work.energy)
            act_relative(a, b, f)
            if wanted:
                pair = work.pairs[int(data[at + 2])]
                pair.active = DAMPED
                pair.K[:] = 0.0
                pair.D[:] = 0.0
                add_relative_tangent(pair, a, b, f, K, C)


@switch_kernel
def switch(raw, data, state, work, out):
    """The least gap of every pair, and the slip where it touches."""
    rows = raw.view(ROW)
    motion = np.empty(9)
    Q = np.empty((3, 3))
    u = np.empty(3)
    lever = np.empty(3)
    contacts = np.empty(2, CONTACT)
    first = 0
    for m in range(rows.shape[0]):
        row = rows[m]
        for k in range(row.count):
            gap, slip = out[first + 2 * k], out[first + 2 * k + 1]
            gap[:] = 0.0
            slip[:] = 0.0
            gap[0], slip[0] = IDLE, IDLE
            if row.law > 1:
                continue
            at = row.pairs + PAIR_STRIDE * k
            relative_motion(work.markers[int(data[at])], work.markers[int(data[at + 1])], motion, Q)
            at_a, at_b = int(data[at + 3]), int(data[at + 4])
            if row.law == 0:
                nearest_sample(data, at_a, at_b, np.inf, motion[0:3], Q, contacts)
            else:
                find_closest(data, at_a, at_b, np.inf, motion[0:3], Q, contacts)
            nearest = contacts[0]
            for i in range(3):
                lever[i] = nearest.x[i] - motion[i]
            cross(motion[6:9], lever, u)
            for i in range(3):
                u[i] += motion[3 + i]
            rate = dot(nearest.n, u)
            gap[0], gap[1], gap[4], gap[9] = GAP, nearest.gap, rate, data[at + 6]
            gap[10:19] = motion
            for i in range(9):
                gap[19 + i] = Q[i // 3, i % 3]
            if nearest.gap < 0.0 and row.friction > 0.0:
                slip[0], slip[8] = SLIP, row.transition
                for i in range(3):
                    slip[4 + i] = u[i] - rate * nearest.n[i]
        first += 2 * row.count


@sweep_kernel
def sweep(raw, data, now, then, h, floor, part):
    """Contacts that begin and end within a step."""
    rows = raw.view(ROW)
    contacts = np.empty(2, CONTACT)
    first = 0
    for m in range(rows.shape[0]):
        row = rows[m]
        for k in range(row.count):
            a, b = now[first + 2 * k], then[first + 2 * k]
            if a[0] == GAP and b[0] == GAP and a[1] > 0.0 and b[1] > 0.0:
                at = row.pairs + PAIR_STRIDE * k
                at_a, at_b = int(data[at + 3]), int(data[at + 4])
                touch = first_touch(data, row.law == 0, at_a, at_b, a, b, h, floor, contacts)
                if touch < 1.0:
                    part[0] = min(part[0], touch)
        first += 2 * row.count


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
        """Return the surfaces that may touch, two by two: those of different bodies, each pair once."""
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

    def check(self, model) -> None:
        """Raise ModelError if a surface does not exist, none can touch, or the law cannot be used for a pair."""
        self._check_skins(*(next((s for s in g if _kind(s) == "Patch"), None) for g in self._surfaces(model)))
        if self.impulsive:
            self._check_rigid(model)
            return
        pairs = self.pairs(model)
        if not pairs:
            raise ModelError(
                self.title,
                found=f"surfaces = {self.surfaces!r}, all on one body",
                expected="surfaces of two bodies",
                remedy="A body does not touch itself: name the surface of another one",
            )
        if len(pairs) > MOST_PAIRS:
            raise ModelError(
                self.title,
                found=f"{len(pairs)} pairs of surfaces",
                expected=f"at most {MOST_PAIRS}: each has its places in the iteration matrix",
                remedy="Name smaller groups, of surfaces that can meet",
            )
        for a, b in pairs:
            self._check_pair(a, b)

    def _check_rigid(self, model) -> None:
        """Raise ModelError if a surface does not exist, or all are on one body or on the ground."""
        groups = self._surfaces(model)
        bodies = [{surface.marker.partition(".")[0] for surface in group} for group in groups]
        both = bodies[0] | bodies[1]
        if len(both) == 1:
            raise ModelError(
                self.title,
                found=f"surfaces = {self.surfaces!r}, all on one body",
                expected="surfaces of two bodies",
                remedy="A body does not touch itself: name the surface of another one",
            )
        endless = [[s for s in group if not np.isfinite(s.shape.reach)] for group in groups]
        if endless[0] and endless[1]:
            self._check_pair(endless[0][0], endless[1][0])
        self._check_points(groups)

    def _check_pair(self, a, b) -> None:
        if all(not np.isfinite(s.shape.reach) for s in (a, b)):
            raise ModelError(
                self.title,
                found=f"'{a.name}' and '{b.name}' are both half-spaces",
                expected="at most one surface without end",
                remedy="Use a Cuboid",
            )
        if self.law.sampled and a.spacing is None and b.spacing is None:
            raise ModelError(
                self.title,
                found=f"neither '{a.name}' nor '{b.name}' is sampled",
                expected="a spacing of at least one of them: the law acts on areas",
                remedy=f"Give the smaller one a spacing: fmb.Surface('{b.name}', ..., spacing=1e-3)",
            )
        if self.law.code == 1 and ({_kind(a), _kind(b)} == {"Sphere", "Patch"} or "Sphere" not in (_kind(a), _kind(b))):
            raise ModelError(
                self.title,
                found=f"'{a.name}' is a {type(a.shape).__name__}, '{b.name}' a {type(b.shape).__name__}",
                expected="a Sphere with the law of Hertz, and a Surface as the other",
                remedy="Use ElasticFoundation",
            )

    def _check_skins(self, a, b) -> None:
        """Raise ModelError if both sides are pieces of skins."""
        if a is not None and b is not None:
            raise ModelError(
                self.title,
                found=f"'{a.name}' and '{b.name}' are both points of skins",
                expected="a Surface on one side: points of a skin need the distance from a solid",
                remedy="Two skins meet by a SkinContact",
            )

    def _check_points(self, groups) -> None:
        """Raise ModelError if surfaces would meet between the points at which a rigid law acts."""
        for own, others in (groups, groups[::-1]):
            blunt = next((s for s in own if np.isfinite(s.shape.reach) and not len(s.shape.corners()[0])), None)
            fits = ("Sphere", "Patch", "Plane") if blunt and _kind(blunt) == "Cylinder" else ("Sphere", "Patch")
            rest = next((s for s in others if _kind(s) not in fits), None)
            if blunt and rest:
                raise ModelError(
                    self.title,
                    found=f"'{blunt.name}' is a {_kind(blunt)}, which has no corners; '{rest.name}' a {_kind(rest)}",
                    expected="with a rigid law, which acts at points: corners, a Sphere, or a Cylinder on a Plane",
                    remedy="Use a Hull of points on both rims, an ExtrudedProfile of a Disc, or ElasticFoundation",
                )
        capsules = [next((s.name for s in group if _kind(s) == "Capsule"), "") for group in groups]
        if all(capsules):
            raise ModelError(
                self.title,
                found=f"'{capsules[0]}' and '{capsules[1]}' are both capsules",
                expected="a Capsule on one side only with a rigid law, which looks at its ends",
                remedy="Describe one side by spheres on a line, or use ElasticFoundation",
            )

    def unseen_in(self, model) -> str:
        """Return that edges that cross are not seen, for a rigid law where there are some."""
        groups = self._surfaces(model)
        edged = [
            next((s.name for s in group if np.isfinite(s.shape.reach) and _kind(s) != "Sphere"), "") for group in groups
        ]
        boxes = all(_kind(s) in ("Cuboid", "Plane", "Sphere") for group in groups for s in group)
        if not self.impulsive or not all(edged) or boxes:
            return ""
        return (
            f"edges of '{edged[0]}' and '{edged[1]}' that cross are not seen: except between two cuboids, a rigid law "
            "acts where a corner of one surface meets the other. Where edges can meet first, use ElasticFoundation, or "
            "put spheres on an edge"
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

    def record(self, compiler) -> dict[str, Any]:
        """Return the row."""
        if self.impulsive:
            return self._kept_record(compiler)
        table, capacity = [], 1
        for pair in self.pairs(compiler.model):
            (a, at_a), (b, at_b) = (compiler.surface(surface) for surface in pair)
            weight = 0.0 if any(isinstance(surface.shape, Patch) for surface in pair) else 1.0
            most = sum(len(s.points[0]) for s in pair) if self.law.sampled else 1
            capacity = max(capacity, most + 1)
            table.append([a, b, compiler.pair(a, b, alone=True), at_a, at_b, most, weight, 0])
        at = compiler.bulk(np.array(table, float))
        numbers = self.law.numbers()
        own = {"pairs": at, "count": len(table), "switches": 2 * len(table), "capacity": capacity}
        return {**own, "law": self.law.code, **numbers}

    def _kept_record(self, compiler) -> dict[str, Any]:
        """Return the row of a rigid law, with a place for the wrench on every marker."""
        table = []
        for marker in self.touching_markers(compiler.model):
            branches = [compiler.branch(name) for name in self.kept_names(marker)]
            table.append([compiler.marker(marker), branches[0], 0, 0, 0, 0, 0, 0])
        at = compiler.bulk(np.array(table, float))
        own = {"pairs": at, "count": len(table), "switches": 0, "capacity": 1, "law": self.law.code}
        return {**own, **self.law.numbers()}
