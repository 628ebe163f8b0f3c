"""`SkinContact`: the skins of two deforming bodies that press on, and rub against, each other."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import KW_ONLY, dataclass
from typing import Any, ClassVar

import numpy as np

from flexmb.errors import ModelError
from flexmb.forces.contact_laws import ElasticFoundation
from flexmb.forces.skin_matrix import add_to_pair, own_parts, projected
from flexmb.forces.skin_wrench import COLUMNS, SPOT, act_on_skins
from flexmb.math.energies import Energy
from flexmb.math.kernel import inner_kernel, kernel
from flexmb.math.switches import GAP, IDLE, SLIP, sweep_kernel, switch_kernel
from flexmb.math.tables import DIRECT, MARKER, row_kernel
from flexmb.math.vectors import cross, dot, matvec
from flexmb.model.kinds import Force
from flexmb.model.spots import Spots
from flexmb.model.table import Table
from flexmb.surfaces.detection import faced
from flexmb.surfaces.skin_faces import FACET, PLACE, TOUCHING, corner_boxes, nearest_face, packed_faces, signed_place
from flexmb.surfaces.skin_surface import SkinSurface

__all__ = ["SkinContact", "find_spot", "moved_corners"]

MOST_SPANS = 80
"""Groups of coordinates that move two skins; each pair of them has its places in the iteration matrix."""

ROW = np.dtype(
    [
        ("points", np.int64),  # where the points begin in the bulk data, `POINT` numbers each
        ("count", np.int64),
        ("corners", np.int64),  # where the markers of the corners of faces begin, with the group that moves each
        ("n_corners", np.int64),
        ("facets", np.int64),
        ("nodes", np.int64),
        ("n_nodes", np.int64),
        ("spans", np.int64),  # where the places of the blocks begin: four times a pair plus a block of it
        ("n_spans", np.int64),
        ("radius", float),  # m, by which the faces are thickened
        ("depth", float),  # m, beyond which a point has passed through
        ("stiffness", float),  # N/m^3
        ("exponent", float),
        ("damping", float),  # s/m
        ("friction", float),
        ("transition", float),  # m/s
    ],
    align=True,
)
POINT = 9
"""Marker, place from it (3), normal (3), area of a point, and the group that moves it."""


@kernel
def moved_corners(row, data, markers, X):
    """Write the places of the corners X (c, 3), and return the boxes (k, 6) of the tree of faces around them."""
    for k in range(row.n_corners):
        marker = markers[int(data[row.corners + 2 * k])]
        for i in range(3):
            X[k, i] = marker.r[i]
    boxes = np.empty((row.n_nodes, 6))
    corner_boxes(data, row.facets, row.nodes, row.n_nodes, X, boxes)
    return boxes


@kernel
def find_spot(row, data, markers, X, boxes, k, within, place, spot):
    """Find the face nearest to point k; return if there is one `within`, m, of its middle, and fill the spot."""
    point = data[row.points + POINT * k : row.points + POINT * (k + 1)]
    marker = markers[int(point[0])]
    z = np.empty(3)
    matvec(marker.R, point[1:4], spot.y)
    for i in range(3):
        z[i] = marker.r[i] + spot.y[i]
    nearest_face(data, row.facets, row.nodes, X, boxes, z, within, place)
    if place.facet < 0:
        return False
    solid = row.radius == 0.0
    signed_place(data, row.facets, X, z, solid, place)
    # beyond the rim of an open skin there is nothing, and in the edge itself no normal
    if (solid and place.free == 1) or (place.where > 0 and abs(place.distance) <= TOUCHING * point[7] ** 0.5):
        return False
    matvec(marker.R, point[4:7], spot.m)
    spot.area, spot.radius = point[7], row.radius
    for c in range(4):
        own = marker
        if c > 0:
            corner = int(data[row.facets + FACET * place.facet + c - 1])
            own = markers[int(data[row.corners + 2 * max(corner, 0)])]
        for i in range(3):
            spot.r[c, i], spot.v[c, i], spot.w[c, i] = own.r[i], own.v[i], own.w[i]
    return True


@inner_kernel
def _spread(row, data, k, place, wrench, K, D, wanted, work):
    """Let the wrenches of a spot act on its markers, and add its derivatives to the iteration matrix."""
    numbers, spans, firsts = np.empty(4, np.int64), np.empty(4, np.int64), np.empty(4, np.int64)
    point = row.points + POINT * k
    numbers[0], spans[0] = int(data[point]), int(data[point + 8])
    for c in range(3):
        corner = max(int(data[row.facets + FACET * place.facet + c]), 0)
        numbers[1 + c], spans[1 + c] = int(data[row.corners + 2 * corner]), int(data[row.corners + 2 * corner + 1])
    for c in range(4):
        marker = work.markers[numbers[c]]
        for i in range(6):
            marker.wrench[i] += wrench[c, i]
    if not wanted:
        return
    total = own_parts(spans, numbers, work.markers, firsts)
    M = projected(numbers, firsts, total, K, D, work)
    for c in range(4):
        for d in range(4):
            again = False
            for e in range(4):
                again = again or (e < c and spans[e] == spans[c]) or (e < d and spans[e] == spans[d])
            code = int(data[row.spans + row.n_spans * spans[c] + spans[d]])
            if code >= 0 and not again:
                add_to_pair(code, M, firsts[c], firsts[d], work)


@row_kernel
def apply(raw, data, state, work):
    """Pressure and friction at every point inside the other skin, eq. (skin-contact)."""
    rows = raw.view(ROW)
    places, spots = np.zeros(1, PLACE), np.zeros(1, SPOT)
    wrench = np.empty((4, 6))
    K = np.zeros((COLUMNS, COLUMNS))
    D = np.zeros((COLUMNS, COLUMNS))
    weights = work.weights[0]
    wanted = weights.wanted == 1 and (weights.stiffness != 0.0 or weights.damping != 0.0)
    for m in range(rows.shape[0]):
        row = rows[m]
        X = np.empty((row.n_corners, 3))
        boxes = moved_corners(row, data, work.markers, X)
        within = row.radius + row.depth
        for k in range(row.count):
            place, spot = places[0], spots[0]  # here: a row does not keep its table alive
            if not find_spot(row, data, work.markers, X, boxes, k, within, place, spot):
                continue
            if place.distance >= row.radius:
                continue
            act_on_skins(row, place, spot, wanted, wrench, K, D, work.energy)
            _spread(row, data, k, place, wrench, K, D, wanted, work)


@switch_kernel
def switch(raw, data, state, work, out):
    """The least gap between the skins, and the slip where they touch."""
    rows = raw.view(ROW)
    places, spots = np.zeros(1, PLACE), np.zeros(1, SPOT)
    u = np.empty(3)
    t = np.empty(3)
    for m in range(rows.shape[0]):
        row = rows[m]
        gap, slip = out[2 * m], out[2 * m + 1]
        gap[:] = 0.0
        slip[:] = 0.0
        gap[0], slip[0] = IDLE, IDLE
        X = np.empty((row.n_corners, 3))
        boxes = moved_corners(row, data, work.markers, X)
        least = np.inf
        for k in range(row.count):
            place, spot = places[0], spots[0]
            # deeper points of a solid are farther from its faces
            within = max(least + row.radius, row.radius + row.depth)
            if not find_spot(row, data, work.markers, X, boxes, k, within, place, spot):
                continue
            if dot(spot.m, place.n) >= 0.0 or place.distance < -row.depth:
                continue
            if place.distance - row.radius >= least:
                continue
            least = place.distance - row.radius
            for i in range(3):
                u[i] = spot.v[0, i]
                for c in range(3):
                    u[i] -= place.share[c] * spot.v[1 + c, i]
            cross(spot.w[0], spot.y, t)
            for i in range(3):
                u[i] += t[i]
            rate = dot(place.n, u)
            gap[0], gap[1], gap[4], gap[9] = GAP, least, rate, 0.0
            slip[0] = IDLE
            if least < 0.0 and row.friction > 0.0:
                slip[0], slip[8] = SLIP, row.transition
                for i in range(3):
                    slip[4 + i] = u[i] - rate * place.n[i]


@sweep_kernel
def sweep(raw, data, now, then, h, floor, part):
    """Contacts that begin and end within a step, as far as the least gap, a cubic of time, tells of them."""
    for m in range(raw.view(ROW).shape[0]):
        a, b = now[2 * m], then[2 * m]
        if a[0] != GAP or b[0] != GAP or a[1] <= 0.0 or b[1] <= 0.0 or a[4] >= 0.0 or b[4] <= 0.0:
            continue
        for n in range(1, 64):
            s = n / 64.0
            p, q = 1.0 - 3.0 * s * s + 2.0 * s**3, 3.0 * s * s - 2.0 * s**3
            gap = p * a[1] + q * b[1] + h * ((s - 2.0 * s * s + s**3) * a[4] + (s**3 - s * s) * b[4])
            if gap < -floor:
                part[0] = min(part[0], s)
                break


@kernel
def _touching(rows, data, markers, energy):
    """Return number, depth, pressure, slip and area of all points that touch."""
    row = rows[0]
    places, spots = np.zeros(1, PLACE), np.zeros(1, SPOT)
    wrench = np.empty((4, 6))
    unused = np.empty((0, 0))
    point = np.empty(row.count, np.int64)
    found = np.empty((4, row.count))
    X = np.empty((row.n_corners, 3))
    boxes = moved_corners(row, data, markers, X)
    n = 0
    for k in range(row.count):
        place, spot = places[0], spots[0]
        if not find_spot(row, data, markers, X, boxes, k, row.radius + row.depth, place, spot):
            continue
        if place.distance >= row.radius:
            continue
        share, _ = faced(-dot(spot.m, place.n))
        if share > 0.0:
            depth, pressure, slip = act_on_skins(row, place, spot, False, wrench, unused, unused, energy)
            point[n], found[0, n], found[1, n], found[2, n] = k, depth, pressure, slip
            found[3, n] = spot.area * share
            n += 1
    return point[:n], found[0, :n], found[1, :n], found[2, :n], found[3, :n]


@dataclass(frozen=True, eq=False)
class SkinContact(Force):
    """Let the skins of two deforming bodies touch: the points of the first and the faces of the second.

    Of two skins the finer one should be the first. A body does not touch itself.

    Parameters
    ----------
    name : str
    surfaces : (str, str)
        Names of two `SkinSurface`; the skin of the second needs ``faces=True``.
    law : ElasticFoundation
        Its pressure acts on the areas of the points.

    Source: Wriggers, Computational Contact Mechanics, ch. 6 and 9 (points against faces and their linearisation).
    """

    name: str
    _: KW_ONLY
    surfaces: Any
    law: Any

    table: ClassVar[Table] = Table("SkinContact", ROW, {"apply": apply, "switch": switch, "sweep": sweep}, switches=2)
    strikes: ClassVar[bool] = True
    impulsive: ClassVar[bool] = False

    def __post_init__(self):
        super().__post_init__()
        given = self.surfaces
        if not isinstance(given, list | tuple) or len(given) != 2 or not all(isinstance(s, str) for s in given):
            raise ModelError(
                self.title,
                found=f"surfaces = {given!r:.80}",
                expected="the names of two SkinSurfaces",
                remedy="Write surfaces=('pad', 'tooth')",
            )
        object.__setattr__(self, "surfaces", tuple(given))
        if not isinstance(self.law, ElasticFoundation):
            raise ModelError(
                self.title,
                found=f"law = {self.law!r:.80}",
                expected="an ElasticFoundation: skins have areas",
                remedy="Write law=fmb.ElasticFoundation(modulus=1e9, thickness=0.01)",
            )

    def sides(self, model) -> tuple[tuple[Any, str], tuple[Any, str]]:
        """Return bodies and names of the two skins; ModelError if one is no skin, or the second has no faces."""
        found = []
        for name in self.surfaces:
            surface = model.surface(name, self.title)
            if not isinstance(surface, SkinSurface):
                raise ModelError(
                    self.title,
                    found=f"'{name}' is a {type(surface).__name__}",
                    expected="two SkinSurfaces",
                    remedy="A skin meets other surfaces by a SurfaceContact",
                )
            found.append(surface.body_and_skin(model))
        (first, _), (second, skin) = found
        if first is second:
            raise ModelError(
                self.title,
                found=f"two skins of {first.title}",
                expected="skins of two bodies",
                remedy="A body does not touch itself",
            )
        if skin not in second.skin_facets:
            raise ModelError(
                self.title,
                found=f"skin '{skin}' of {second.title} has no faces",
                expected="a second skin whose faces the points of the first can meet",
                remedy=f"Write '{skin}': fmb.Skin(..., faces=True), or exchange the two",
            )
        return found[0], found[1]

    def check(self, model) -> None:
        """Raise ModelError if the skins cannot touch."""
        self.sides(model)

    def measure(self, model) -> None:
        """Return None: it acts on many markers; `ContactState` tells the resultants."""
        return

    def touching_markers(self, model) -> list[str]:
        """Return all markers on which it may act."""
        (first, own), (second, other) = self.sides(model)
        points = [f"{first.name}.{patch.marker}" for patch in first.skin_patches[own]]
        return points + [f"{second.name}.{corner}" for corner in second.skin_facets[other].corners]

    def points(self, model) -> tuple[list[str], np.ndarray]:
        """Return the markers of the points, and their places, normals and areas (n, 7) in the axes of these."""
        (body, skin), _ = self.sides(model)
        names, table = [], []
        for patch in body.skin_patches[skin]:
            names += [f"{body.name}.{patch.marker}"] * len(patch.places)
            table.append(np.column_stack([patch.places, patch.normals, patch.areas]))
        return names, np.concatenate(table)

    def record(self, compiler) -> dict[str, Any]:
        """Return the row: points, corners, faces with their tree, and the places of all blocks."""
        tables, facets, numbers = self._packed(compiler.model, compiler.marker)
        points, corners = (tables[name][:, 0].astype(int) for name in ("points", "corners"))
        groups = {compiler.span(k): int(k) for k in [*corners[::-1], *points[::-1]]}
        number = {span: k for k, span in enumerate(groups)}
        for name, markers in (("points", points), ("corners", corners)):
            tables[name][:, -1] = [number[compiler.span(k)] for k in markers]
        own = [tables[name][:, -1].astype(int) for name in ("points", "corners")]
        tables["spans"] = self._blocks(compiler, list(groups.values()), own, facets)
        return {**numbers, "n_spans": len(groups), **{name: compiler.bulk(table) for name, table in tables.items()}}

    def _packed(self, model, number) -> tuple[dict[str, np.ndarray], np.ndarray, dict[str, Any]]:
        """Return the tables of points, corners, faces and nodes, the corners of the faces, and the numbers of the row.

        `number` gives the number of a marker; the groups of coordinates are left 0.
        """
        _, (body, skin) = self.sides(model)
        names, table = self.points(model)
        own = body.skin_facets[skin]
        places = np.array([model.marker(f"{body.name}.{corner}")[1].at for corner in own.corners])
        faces, nodes, _ = packed_faces(places, own.facets)
        corners = np.array([number(f"{body.name}.{corner}") for corner in own.corners])
        tables = {
            "points": np.column_stack([[number(name) for name in names], table, np.zeros(len(table))]),
            "corners": np.column_stack([corners, np.zeros(len(corners))]),
            "facets": faces,
            "nodes": nodes,
        }
        sizes = {"count": len(table), "n_corners": len(corners), "n_nodes": len(nodes)}
        depth = body.skin_thickness[skin] if own.radius == 0.0 else 0.0
        law = {name: value for name, value in self.law.numbers().items() if name != "restitution"}
        return tables, own.facets, {**sizes, "radius": own.radius, "depth": depth, **law}

    def spots(self, series) -> Iterator[Spots]:
        """Yield what touches at every sample of a phase."""
        model = series.model
        names = list(dict.fromkeys(self.touching_markers(model)))
        tables, _, numbers = self._packed(model, {name: k for k, name in enumerate(names)}.__getitem__)
        starts = np.cumsum([0] + [table.size for table in tables.values()])
        data = np.concatenate([table.ravel() for table in tables.values()])
        row = np.zeros(1, ROW)
        for name, value in {**numbers, **dict(zip(tables, starts.tolist(), strict=False))}.items():
            row[name] = value
        motions, energy = [series.marker(name) for name in names], np.zeros(1, Energy.dtype)
        for k in range(len(series.t)):
            markers = np.zeros(len(names), MARKER)
            for field in ("r", "R", "v", "w"):
                markers[field] = [getattr(motion, field)[k] for motion in motions]
            yield Spots(*_touching(row, data, markers, energy))

    def _blocks(self, compiler, markers: list[int], own, facets) -> np.ndarray:
        """Return for every two groups of coordinates where their block of the matrix is, -1 where none is needed."""
        n = len(markers)
        if n > MOST_SPANS:
            raise ModelError(
                self.title,
                found=f"skins moved by {n} groups of coordinates (elements)",
                expected=f"at most {MOST_SPANS}: each with each has its places in the iteration matrix",
                remedy="Let the skins cover what can meet: between=(0.4, 0.6), a set of nodes, fewer elements",
            )
        codes = np.full((n, n), -1.0)
        needed = {(int(a), int(b)) for a in np.unique(own[0]) for b in np.unique(own[1])}
        ends = own[1][np.where(facets < 0, facets[:, :1], facets)]
        needed |= {
            (min(a, b), max(a, b)) for row in np.unique(ends, axis=0).tolist() for a in row for b in row if a != b
        }
        for a, b in sorted(needed):
            pair = compiler.pair(markers[a], markers[b], DIRECT)
            for k, (i, j) in enumerate(((a, a), (a, b), (b, a), (b, b))):
                codes[i, j] = 4 * pair + k
        return codes
