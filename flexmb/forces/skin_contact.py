"""`SkinContact`: the skins of two deforming bodies that press on, and rub against, each other."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import KW_ONLY, dataclass
from typing import Any, ClassVar

import numpy as np

from flexmb.constraints.marker_blocks import block_codes
from flexmb.errors import ModelError
from flexmb.forces.contact_laws import ElasticFoundation
from flexmb.forces.skin_rows import ROW, apply, sweep, switch, touching_points
from flexmb.forces.skin_sweep import rows_of_paths
from flexmb.math.energies import Energy
from flexmb.math.tables import MARKER
from flexmb.model.kinds import Force
from flexmb.model.spots import Spots
from flexmb.model.table import Table
from flexmb.surfaces.skin_faces import packed_faces
from flexmb.surfaces.skin_surface import SkinSurface

__all__ = ["SkinContact"]

MOST_SPANS = 80
"""Groups of coordinates that move two skins; each pair of them has its places in the iteration matrix."""


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
        "SkinContact", ROW, {"apply": apply, "switch": switch, "sweep": sweep}, switches="switches"
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

    def slip_unit(self, model) -> str:
        """Return m, if its law has regularised friction."""
        return "m" if getattr(self.law, "transition", None) is not None and self.law.friction > 0.0 else ""

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
        sizes["switches"] = 2 + rows_of_paths(len(table), len(corners))
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
            yield Spots(*touching_points(row, data, markers, energy))

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
        needed = {(int(a), int(b)) for a in np.unique(own[0]) for b in np.unique(own[1])}
        ends = own[1][np.where(facets < 0, facets[:, :1], facets)]
        needed |= {
            (min(a, b), max(a, b)) for row in np.unique(ends, axis=0).tolist() for a in row for b in row if a != b
        }
        return block_codes(compiler, markers, needed)
