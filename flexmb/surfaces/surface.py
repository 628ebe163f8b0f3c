"""`Surface`: what of a body can touch."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from functools import cached_property
from typing import Any, ClassVar

import numpy as np

from flexmb.errors import ModelError
from flexmb.model.part import Part
from flexmb.surfaces.distances import signed_distance
from flexmb.surfaces.edges import packed_edges
from flexmb.surfaces.records import FAR, HEADER
from flexmb.surfaces.shape import Points, Shape
from flexmb.surfaces.trees import built, slabs

__all__ = ["Surface"]

MOST_SAMPLES = 1_000_000
AROUND = 8
"""Points of a thin bar, at least, for each spacing along half of it."""


@dataclass(frozen=True, eq=False)
class Surface(Part):
    """Give a body a surface that can touch others: a shape in the axes of a marker.

    A surface touches nothing by itself; a `SurfaceContact` says which surfaces meet, and by which law.

    Parameters
    ----------
    name : str
    marker : str
        "body.marker" in whose axes the shape is given.
    shape : Shape
        `Plane`, `Sphere`, `Cylinder`, `Capsule`, `Cuboid`, ...
    spacing : float, m, optional
        Distance of the points by which an `ElasticFoundation` samples it; without it the surface is not sampled, and
        the other one must be.
    """

    name: str
    _: KW_ONLY
    marker: str
    shape: Any
    spacing: float | None = None

    family: ClassVar[str] = "Surface"

    def __post_init__(self):
        super().__post_init__()
        if not isinstance(self.shape, Shape):
            raise ModelError(
                self.title,
                found=f"shape = {self.shape!r:.80}",
                expected="a shape that can touch: Plane, Sphere, Cylinder, Capsule, Cuboid, ...",
                remedy="Write shape=fmb.Sphere(radius=0.1); Box, Tube and Extrusion are only drawn",
            )
        if self.spacing is not None:
            self.require_positive("spacing")
            if np.isfinite(self.shape.reach) and self._many() > MOST_SAMPLES:
                raise ModelError(
                    self.title,
                    found=f"spacing = {self.spacing} m on a shape of {self.shape.area:.3g} m2",
                    expected=f"at most about {MOST_SAMPLES} points",
                    remedy="Give a larger spacing",
                )

    def _many(self) -> float:
        """Return about how many points its spacing asks for: by its area, and by its length where it is thin."""
        shape, along = self.shape, self.shape.reach / self.spacing
        return max((shape.area**0.5 / self.spacing) ** 2, AROUND * along) if along < MOST_SAMPLES else AROUND * along

    def check(self, model) -> None:
        """Raise ModelError if the marker does not exist."""
        model.marker(self.marker, self.title)

    @cached_property
    def points(self) -> Points:
        """Places (n, 3), m, normals (n, 3) and areas (n,), m2, by which it is sampled; none without spacing."""
        if self.spacing is None:
            return np.zeros((0, 3)), np.zeros((0, 3)), np.zeros(0)
        return self.shape.samples(self.spacing)

    @cached_property
    def packed(self) -> np.ndarray:
        """All that kernels need, see `flexmb.surfaces.records`."""
        own = self.shape.numbers()
        places, normals, areas = self.points
        corners, radius = self.shape.corners()
        samples_at = HEADER + own.size
        corners_at = samples_at + 7 * len(places)
        reach = min(self.shape.reach, FAR)
        order, nodes = built(places, places)
        tree_at = corners_at + 3 * len(corners)
        header = [self.shape.code, reach, len(places), samples_at, len(corners), corners_at, radius, tree_at]
        header += [float(self.shape.convex), min(self.shape.thickness, FAR)]
        table = np.column_stack([places, normals, areas])[order]
        tree = slabs(places[order], normals[order], nodes)
        return np.concatenate([header, own, table.ravel(), corners.ravel(), tree.ravel()])

    @cached_property
    def packed_edges(self) -> np.ndarray:
        """Its edges and faces as kernels need them, see `flexmb.surfaces.edges`."""
        return packed_edges(self.shape.edges)

    @cached_property
    def depth(self) -> float:
        """A lower bound, m, of how far its deepest point lies below it; infinite for a half-space, and points alone.

        It is exact for sheets, and where the marker is the deepest point; of others the volume per area is known.
        """
        at_marker = -signed_distance(self.packed, 0, np.zeros(3), np.inf, np.empty(3), np.empty((3, 3)))
        return float(max(0.5 * self.shape.thickness, at_marker)) if at_marker > -FAR else np.inf
