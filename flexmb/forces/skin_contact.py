"""`SkinContact`: the skins of two deforming bodies that press on, and rub against, each other."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from typing import Any, ClassVar

import numpy as np

from flexmb.errors import ModelError
from flexmb.forces.contact_laws import ElasticFoundation
from flexmb.forces.skin_wrench import COLUMNS, SPOT, act_on_skins
from flexmb.math.kernel import inner_kernel, kernel
from flexmb.math.switches import GAP, IDLE, SLIP, sweep_kernel, switch_kernel
from flexmb.math.tables import DIRECT, row_kernel
from flexmb.math.vectors import cross, dot, matvec
from flexmb.model.kinds import Force
from flexmb.model.table import Table
from flexmb.surfaces.skin_faces import FACET, PLACE, corner_boxes, nearest_face, packed_faces, signed_place
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
    if (solid and place.free == 1) or (place.where > 0 and abs(place.distance) < 1e-14):
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
def _add_block(code, first, second, K, D, work):
    """Add J_a^T (ck K + cd D) J_b of two markers to the iteration matrix, at a block of a pair."""
    ck, cd = work.weights[0].stiffness, work.weights[0].damping
    pair, block = work.pairs[code // 4], code % 4
    if first.nu == 0 or second.nu == 0:
        return
    a, b = work.markers[pair.a], work.markers[pair.b]
    start = pair.iS
    for k in range(block):
        before, after = (a if k < 2 else b), (a if k % 2 == 0 else b)
        if before.nu > 0 and after.nu > 0:
            start += before.nu * (after.nu // after.width)
    column = np.empty(second.nu)
    blocks = second.nu // second.width
    for k in range(6):
        used = False
        for m in range(6):
            x = ck * K[k, m] + cd * D[k, m]
            if x == 0.0:
                continue
            if not used:
                column[:] = 0.0
                used = True
            at = second.iJ + m * second.nu
            for j in range(second.nu):
                column[j] += x * work.J[at + j]
        if not used:
            continue
        for i in range(first.nu):
            x = work.J[first.iJ + k * first.nu + i]
            if x != 0.0:
                for n in range(blocks):
                    at = work.pair_rows[start + i * blocks + n]
                    for j in range(second.width):
                        work.S[at + j] += x * column[n * second.width + j]


@inner_kernel
def _spread(row, data, k, place, wrench, K, D, wanted, work):
    """Let the wrenches of a spot act on its markers, and add its derivatives to the iteration matrix."""
    numbers, spans = np.empty(4, np.int64), np.empty(4, np.int64)
    point = row.points + POINT * k
    numbers[0], spans[0] = int(data[point]), int(data[point + 8])
    for c in range(3):
        corner = max(int(data[row.facets + FACET * place.facet + c]), 0)
        numbers[1 + c], spans[1 + c] = int(data[row.corners + 2 * corner]), int(data[row.corners + 2 * corner + 1])
    for c in range(4):
        if c == 0 or place.share[c - 1] != 0.0:
            marker = work.markers[numbers[c]]
            for i in range(6):
                marker.wrench[i] += wrench[c, i]
    if not wanted:
        return
    for c in range(4):
        for d in range(4):
            code = int(data[row.spans + row.n_spans * spans[c] + spans[d]])
            if code >= 0:
                own, other = slice(6 * c, 6 * c + 6), slice(6 * d, 6 * d + 6)
                _add_block(
                    code, work.markers[numbers[c]], work.markers[numbers[d]], K[own, other], D[own, other], work
                )


@row_kernel
def apply(raw, data, state, work):
    """Pressure and friction at every point inside the other skin, eq. (skin-contact)."""
    rows = raw.view(ROW)
    places, spots = np.zeros(1, PLACE), np.zeros(1, SPOT)
    place, spot = places[0], spots[0]
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
    place, spot = places[0], spots[0]
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
            if not find_spot(row, data, work.markers, X, boxes, k, least + row.radius, place, spot):
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

    table: ClassVar[Table] = Table(
        "SkinContact", ROW, {"apply": apply, "switch": switch, "sweep": sweep}, switches=2
    )
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
        _, (body, skin) = self.sides(compiler.model)
        names, table = self.points(compiler.model)
        facets = body.skin_facets[skin]
        points = np.array([compiler.marker(name) for name in names])
        corners = np.array([compiler.marker(f"{body.name}.{corner}") for corner in facets.corners])
        groups = {compiler.span(k): int(k) for k in [*corners[::-1], *points[::-1]]}
        number = {span: k for k, span in enumerate(groups)}
        own = [np.array([number[compiler.span(k)] for k in markers]) for markers in (points, corners)]
        places = np.array([compiler.position(k) for k in corners])
        faces, nodes, _ = packed_faces(places, facets.facets)
        codes = self._blocks(compiler, list(groups.values()), own, facets.facets)
        return {
            "points": compiler.bulk(np.column_stack([points, table, own[0]])),
            "count": len(points),
            "corners": compiler.bulk(np.column_stack([corners, own[1]])),
            "n_corners": len(corners),
            "facets": compiler.bulk(faces),
            "nodes": compiler.bulk(nodes),
            "n_nodes": len(nodes),
            "spans": compiler.bulk(codes),
            "n_spans": len(groups),
            "radius": facets.radius,
            "depth": body.skin_thickness[skin] if facets.radius == 0.0 else 0.0,
            **{name: value for name, value in self.law.numbers().items() if name != "restitution"},
        }

    def _blocks(self, compiler, markers: list[int], own, facets) -> np.ndarray:
        """Return for every two groups of coordinates where their block of the matrix is, -1 where none is needed."""
        n = len(markers)
        if n > MOST_SPANS:
            raise ModelError(
                self.title,
                found=f"skins moved by {n} groups of coordinates (elements)",
                expected=f"at most {MOST_SPANS}: each with each has its places in the iteration matrix",
                remedy="Let the skins cover the parts that can meet: between=(0.4, 0.6), a set of nodes, fewer elements",
            )
        codes = np.full((n, n), -1.0)
        needed = {(int(a), int(b)) for a in np.unique(own[0]) for b in np.unique(own[1])}
        ends = own[1][np.where(facets < 0, facets[:, :1], facets)]
        needed |= {(min(a, b), max(a, b)) for row in np.unique(ends, axis=0).tolist() for a in row for b in row if a != b}
        for a, b in sorted(needed):
            pair = compiler.pair(markers[a], markers[b], DIRECT)
            for k, (i, j) in enumerate(((a, a), (a, b), (b, a), (b, b))):
                codes[i, j] = 4 * pair + k
        return codes
