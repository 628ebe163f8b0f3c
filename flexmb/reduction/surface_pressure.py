"""`SurfacePressure`: the pressure field of a flow solver on a surface of its own, mapped onto any mesh."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from flexmb.errors import ReductionError
from flexmb.model.described import finite_array, is_number
from flexmb.reduction.load_clouds import LoadCloud
from flexmb.reduction.load_tables import MappedLoad

__all__ = ["SurfacePressure"]

INSIDE = np.array([[4.0, 1.0, 1.0], [1.0, 4.0, 1.0], [1.0, 1.0, 4.0]]) / 6.0
"""Area coordinates of three points, of equal weight: exact to the second degree (Strang & Fix 1973)."""


@dataclass(frozen=True, kw_only=True, eq=False)
class SurfacePressure(MappedLoad):
    """Pressures on points with area vectors, or on triangles, that act against the outward normal.

    Mapped onto beams, shells or facets of solids with the same resultant force and moment. On triangles the pressure is
    linear between the corners, or constant in each.

    Parameters
    ----------
    points : (n, 3), m
        In body axes.
    pressure : (n,) or (nt,), Pa
    areas : (n, 3), m2
        Outward normals of the size of the area around each point; instead of triangles.
    triangles : (nt, 3) int
        Numbers of the points (from 0), going round the outward normal.
    reference : float, Pa
        Pressure on the other side, which is subtracted.
    factor : float, -
        Times which pressures count: the dynamic pressure for coefficients.
    on, reach, turns_with
        As in `LineTable`.
    """

    points: Any
    pressure: Any
    areas: Any = None
    triangles: Any = None
    by_triangle: bool = False
    reference: float = 0.0
    factor: float = 1.0
    on: Any = None
    reach: float | None = None
    turns_with: str | None = None

    def __post_init__(self):
        points, pressure = finite_array(self.points), finite_array(self.pressure)
        if points.ndim != 2 or points.shape[1:] != (3,):
            self._refuse(f"points = {self.points!r:.80}", "finite places (n, 3), m")
        if (self.areas is None) == (self.triangles is None):
            self._refuse("neither areas nor triangles" if self.areas is None else "areas and triangles", "one of them")
        if self.areas is not None:
            areas = finite_array(self.areas)
            if areas.shape != points.shape or pressure.shape != (len(points),):
                self._refuse(
                    f"{len(points)} points, pressures {pressure.shape}, areas {areas.shape}",
                    "a finite pressure and area vector for each point",
                )
            object.__setattr__(self, "areas", areas)
        else:
            cells = finite_array(self.triangles)  # rows of different lengths are no array
            numbered = cells.ndim == 2 and cells.shape[1:] == (3,) and np.all(cells == np.round(cells)) and len(cells)
            cells = cells.astype(np.int64) if numbered else cells
            if not numbered or cells.min() < 0 or cells.max() >= len(points):
                self._refuse(f"triangles of the shape {cells.shape}", f"numbers (nt, 3) from 0 to {len(points) - 1}")
            if pressure.shape != (len(cells) if self.by_triangle else len(points),):
                self._refuse(
                    f"{pressure.size} finite pressures for {len(points)} points and {len(cells)} triangles",
                    "one for each triangle" if self.by_triangle else "one for each point",
                )
            object.__setattr__(self, "triangles", cells)
        object.__setattr__(self, "points", points)
        object.__setattr__(self, "pressure", pressure)
        for field in ("reference", "factor"):
            if not is_number(getattr(self, field)):
                self._refuse(f"{field} = {getattr(self, field)!r}", "a number")
        self.check_reach("SurfacePressure")

    def _refuse(self, found: str, expected: str) -> None:
        raise ReductionError(
            "SurfacePressure", found=found, expected=expected, remedy="Look at the table, and at what exported it"
        )

    def cloud(self, spacing: float) -> LoadCloud:
        """Return the forces at the points, or at three points of every triangle; `spacing` plays no part."""
        amount = self.factor * (self.pressure - self.reference)
        if self.areas is not None:
            forces = -amount[:, None] * self.areas
            return LoadCloud(self.points, forces, np.zeros_like(forces))
        corners = self.points[self.triangles]
        area = 0.5 * np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        inside = np.repeat(amount[:, None], 3, axis=1) if self.by_triangle else amount[self.triangles] @ INSIDE.T
        forces = (-inside[:, :, None] * area[:, None] / 3.0).reshape(-1, 3)
        points = np.einsum("qa,tai->tqi", INSIDE, corners).reshape(-1, 3)
        return LoadCloud(points, forces, np.zeros_like(forces))
