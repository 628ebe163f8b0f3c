"""`TriangleMesh`: a closed surface of triangles. `Hull`: the convex one around points."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from flexmb.errors import MeshError
from flexmb.math.triangles import centres_of_parts
from flexmb.model.described import finite_array
from flexmb.surfaces.closed_mesh import FARTHEST, checked_mesh, mean_normals
from flexmb.surfaces.edges import Edges, edges_of_solid
from flexmb.surfaces.mesh_crossings import crossings, shells_of
from flexmb.surfaces.mesh_distance import TRIANGLE
from flexmb.surfaces.shape import Points, Shape
from flexmb.surfaces.trees import built

__all__ = ["Hull", "Meshed", "TriangleMesh"]


class Meshed(Shape):
    """What shapes of triangles share."""

    code: ClassVar[int] = 5
    edged: ClassVar[bool] = True
    _mesh: tuple[np.ndarray, np.ndarray]

    @cached_property
    def _numbers(self) -> np.ndarray:
        vertices, triangles = self._mesh
        corners = vertices[triangles]
        order, nodes = built(corners.min(axis=1), corners.max(axis=1))
        triangles = triangles[order]
        faces, edges, tips = mean_normals(vertices, triangles)
        table = np.empty((len(triangles), TRIANGLE))
        table[:, :9] = vertices[triangles].reshape(-1, 9)
        table[:, 9:12] = faces
        table[:, 12:21] = edges.reshape(-1, 9)
        table[:, 21:] = tips[triangles].reshape(-1, 9)
        head = [len(triangles), len(nodes), 4, 4 + table.size]
        return np.concatenate([head, table.ravel(), nodes.ravel()])

    def numbers(self) -> np.ndarray:
        """Return triangles and tree, see `flexmb.surfaces.mesh_distance`."""
        return self._numbers

    @cached_property
    def convex(self) -> bool:  # type: ignore[override]
        """Does it fill its convex hull, up to 1e-9 of the volume?"""
        from scipy.spatial import ConvexHull

        vertices, triangles = self._mesh
        a, b, c = (vertices[triangles[:, k]] for k in range(3))
        volume = np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0
        return bool(volume >= (1.0 - 1e-9) * ConvexHull(vertices).volume)

    @property
    def reach(self) -> float:
        """Distance of the farthest vertex, m."""
        return float(np.linalg.norm(self._mesh[0], axis=1).max())

    def corners(self) -> tuple[np.ndarray, float]:
        """Return the vertices, which are sharp."""
        return self._mesh[0], 0.0

    @cached_property
    def edges(self) -> Edges:  # type: ignore[override]
        """The edges that stand out; of a convex solid the faces, triangles in one plane joined."""
        return edges_of_solid(*self._mesh, self.thickness, self.convex)

    def samples(self, spacing: float) -> Points:
        """Return the centres of the triangles, which are divided where they are longer than the spacing."""
        vertices, triangles = self._mesh
        a, b, c = (vertices[triangles[:, k]] for k in range(3))
        longest = np.max([np.linalg.norm(x - y, axis=1) for x, y in ((a, b), (b, c), (c, a))], axis=0)
        cuts = np.maximum(1, np.ceil(longest / spacing)).astype(int)
        cross = np.cross(b - a, c - a)
        size = np.linalg.norm(cross, axis=1)
        if np.sum(cuts.astype(float) ** 2) > 5e6:
            self._fail(
                f"{np.sum(cuts.astype(float) ** 2):.3g} samples", "at most 5e6", "Give the surface a larger spacing"
            )
        places, normals, areas = [], [], []
        for n in np.unique(cuts):
            own = np.flatnonzero(cuts == n)
            for weights in centres_of_parts(n):
                u, v, w = weights
                places.append(u * a[own] + v * b[own] + w * c[own])
                normals.append(cross[own] / size[own, None])
                areas.append(0.5 * size[own] / n**2)
        return np.concatenate(places), np.concatenate(normals), np.concatenate(areas)

    def drawing(self) -> tuple[np.ndarray, np.ndarray]:
        """Return vertices and triangles."""
        return self._mesh


@dataclass(frozen=True, eq=False)
class TriangleMesh(Meshed):
    """A closed surface of triangles, from a file or as arrays, in the axes of the marker.

    Parameters
    ----------
    vertices : (n, 3), m
    triangles : (m, 3)
        Numbers of vertices, round the outward normal.
    file : path, optional
        In place of both: STL, OBJ, PLY, VTK, OFF and what else meshio reads; GLB and glTF with `trimesh`.
    scale : float
        Metres per unit of the file.

    Raises
    ------
    MeshError
        If the mesh is open, inverted, has degenerate triangles or numbers that are none: which, and where.
    """

    vertices: Any = None
    triangles: Any = None
    file: Any = None
    scale: float = 1.0

    files: ClassVar[tuple[str, ...]] = ("file",)
    """Fields that hold files, named relative to the model file."""

    def __post_init__(self):
        self._require_lengths("scale")
        vertices, triangles, title = self.vertices, self.triangles, "Shape TriangleMesh"
        if (self.file is None) == (vertices is None or triangles is None):
            self._fail(
                "both a file and arrays" if self.file is not None else "neither a file nor vertices and triangles",
                "a file, or vertices and triangles",
                "Write fmb.TriangleMesh(file='part.stl', scale=1e-3)",
            )
        if self.file is not None:
            from flexmb.fem.surface_file import read_triangles

            object.__setattr__(self, "file", Path(self.file))
            vertices, triangles = read_triangles(self.file, self.scale)
            title = f"Surface file '{self.file}'"
        elif self.scale != 1.0:
            self._fail(f"scale = {self.scale} of arrays", "arrays in m", "Scale the vertices")
        object.__setattr__(self, "_mesh", checked_mesh(vertices, triangles, title))

    @cached_property
    def doubt(self) -> str:  # type: ignore[override]
        """Where the mesh passes through or touches itself, or has a solid within one: distances have a wrong sign."""
        count, place = crossings(*self._mesh)
        near = "near there points of the solid may count as outside, and the other way round. Join its parts into one"
        if count:
            return (
                f"its mesh passes through or touches itself: {count} pair(s) of triangles meet, one near "
                f"{np.round(place, 9).tolist()} m; {near}"
            )
        shells = shells_of(*self._mesh)
        if len(shells.doubled):
            return (
                f"{len(shells.doubled)} of the {len(shells.volumes)} closed shells of its mesh lie within another one, "
                f"a point of the first at {np.round(shells.places[shells.doubled[0]], 9).tolist()} m, with outward "
                f"normals as of solids; {near}, or flip those that are cavities"
            )
        return ""


@dataclass(frozen=True, eq=False)
class Hull(Meshed):
    """The convex hull of `points` (n, 3), m, in the axes of the marker."""

    points: Any

    def __post_init__(self):
        from scipy.spatial import ConvexHull, QhullError

        title = "Shape Hull"
        points = finite_array(self.points)
        if points.ndim != 2 or points.shape[1:] != (3,) or not np.abs(points).max(initial=0.0) <= FARTHEST:
            raise MeshError(
                title,
                found=f"points of the shape {points.shape}" if points.size else "points that are no finite numbers",
                expected=f"points (n, 3) within {FARTHEST:.0e} m",
                remedy="Give points around a solid",
            )
        try:
            hull = ConvexHull(points)
        except (QhullError, ValueError) as error:
            raise MeshError(
                title,
                found=f"points of the shape {points.shape} ({str(error).splitlines()[0][:80]})",
                expected="four or more points that do not lie in a plane",
                remedy="Give points around a solid",
            ) from None
        triangles = hull.simplices.copy()
        a, b, c = (points[triangles[:, k]] for k in range(3))
        inward = np.einsum("ij,ij->i", np.cross(b - a, c - a), hull.equations[:, :3]) < 0.0
        triangles[inward] = triangles[inward][:, ::-1]
        object.__setattr__(self, "points", points)
        object.__setattr__(self, "_mesh", checked_mesh(points, triangles, title))
