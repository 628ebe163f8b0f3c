"""`Plate`: a plate or curved shell from its corner points, meshed in rows."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from flexmb.errors import ModelError
from flexmb.fem.fe_model import FEModel
from flexmb.fem.meshes.mesh import Mesh
from flexmb.fem.shells.shell import shell
from flexmb.model.described import Described, finite_array, is_number
from flexmb.parts.limits import check_count, largest_size
from flexmb.parts.materials import material_of

__all__ = ["Plate"]

CLOSE = 1e-9
"""Fractions of an edge nearer than this are one line of the mesh."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Plate(metaclass=Described):
    """A plate or shell between four corners, with straight or parabolic edges.

    Parameters
    ----------
    corners : (4, 3) or (8, 3), m
        Going round; of eight the last four are points at the middles of the edges, edge k beginning at corner k: then
        the edges are parabolas, and the surface the serendipity surface between them.
    thickness : float, or four of them, m
        Four are those at the corners, with a linear change between.
    material : Material, or the name of one
        "steel", "aluminium", "titanium" and others are ready-made.
    size : float, m
        Largest length of an element's edge.
    nodes : mapping of name to (u, v), or to several, -
        Named nodes at fractions 0..1 along edge 1 (u) and along edge 4 backwards (v); (0, 0) is corner 1.
    lumped : bool
        Diagonal mass.
    stress_side : float or None, -
        Side whose stress is kept: 1 (top, from where the corners go round counterclockwise), 0 (middle) or -1 (bottom);
        without it the middle, with a warning.
    name : str
        Set of all nodes and of the surface (for pressures). The sets ``edge_1`` ... ``edge_4`` and
        ``corner_1`` ... ``corner_4`` carry it before their names, "skin.edge_1".
    """

    corners: Any
    thickness: Any
    material: Any
    size: float
    nodes: Mapping[str, Any] = field(default_factory=dict)
    lumped: bool = False
    stress_side: float | None = None
    name: str = "plate"

    @property
    def title(self) -> str:
        """How messages call it."""
        return f"Plate '{self.name}'"

    def __post_init__(self):
        corners = finite_array(self.corners)
        if corners.shape not in ((4, 3), (8, 3)):
            raise ModelError(
                self.title,
                found=f"corners of the shape {corners.shape}" if corners.size else f"corners = {self.corners!r:.80}",
                expected="four points going round, or these and the middles of the four edges, m",
                remedy="Write corners = [[0, 0, 0], [1, 0, 0], [1, 0.4, 0], [0, 0.4, 0]]",
            )
        object.__setattr__(self, "corners", corners)
        object.__setattr__(self, "material", material_of(self.material, self.title))
        thickness = finite_array(self.thickness)
        if thickness.shape not in ((), (4,)) or not np.all(thickness > 0.0) or not thickness.size:
            raise ModelError(
                self.title,
                found=f"thickness = {self.thickness!r} m",
                expected="a positive number, or four of them at the corners",
                remedy="Write thickness = 0.002",
            )
        object.__setattr__(self, "thickness", thickness)
        self._check_order()
        size = largest_size(self.size, self.title)
        u, v = self._edges()
        check_count(u / size * v / size, self.title, "shell elements")
        if self.stress_side is not None and not (is_number(self.stress_side) and abs(self.stress_side) <= 1.0):
            raise ModelError(
                self.title,
                found=f"stress_side = {self.stress_side!r}",
                expected="-1, 0 or 1",
                remedy="0 is the middle of the thickness",
            )
        object.__setattr__(self, "nodes", self._places())

    def _check_order(self) -> None:
        """Raise ModelError where the corners do not go round: two opposite edges cross, as in a bow tie.

        Of corners that go round, seen from one side, at most one is turned in (an arrow head); of a bow tie two are.
        """
        corners = np.asarray(self.corners)
        if len(corners) > 4:  # edges may bend
            return
        normals = np.cross(np.roll(corners, -1, axis=0) - corners, np.roll(corners, 1, axis=0) - corners)
        largest = normals[np.linalg.norm(normals, axis=1).argmax()]
        turned = normals @ largest
        if np.count_nonzero(turned < -1e-9 * (largest @ largest)) == 2:
            right = corners[[0, 1, 3, 2]] if turned[0] * turned[1] > 0.0 else corners[[0, 2, 1, 3]]
            raise ModelError(
                f"{self.title}, corners",
                found="corners that do not go round: two opposite edges cross",
                expected="the corners in order along the edge of the plate",
                remedy=f"Write corners = {right.tolist()}",
            )

    def _edges(self) -> tuple[float, float]:
        """Return the longer of opposite edges along u and along v, m."""
        line = np.linspace(0.0, 1.0, 9)
        lengths = [
            np.linalg.norm(np.diff(self._surface(*edge), axis=0), axis=1).sum()
            for edge in ((line, 0 * line), (line, 0 * line + 1), (0 * line, line), (0 * line + 1, line))
        ]
        return max(lengths[:2]), max(lengths[2:])

    def _places(self) -> dict[str, np.ndarray]:
        if not isinstance(self.nodes, Mapping):
            raise ModelError(
                self.title,
                found=f"nodes = {self.nodes!r:.80}",
                expected="names with fractions (u, v)",
                remedy="Write nodes = { bolt = [0.5, 0.1] }",
            )
        places = {}
        for name, value in self.nodes.items():
            given = np.atleast_2d(finite_array(value))
            if given.shape[1:] != (2,) or not given.size or given.min() < 0.0 or given.max() > 1.0:
                raise ModelError(
                    f"{self.title}, node '{name}'",
                    found=f"{value!r:.80}",
                    expected="two fractions 0..1, or a list of such pairs: nodes lie on the plate",
                    remedy="(0, 0) is corner 1, (1, 0) corner 2, (1, 1) corner 3",
                )
            places[str(name)] = given
        return places

    def finite_elements(self) -> FEModel:
        """Return the FE model of the plate."""
        named = np.vstack([np.zeros((0, 2)), *self.nodes.values()])
        u, v = (self._rows(length, named[:, k]) for k, length in enumerate(self._edges()))
        uu, vv = (x.ravel() for x in np.meshgrid(u, v, indexing="ij"))
        number = np.arange(len(uu)).reshape(len(u), len(v))
        quads = np.column_stack(
            [number[:-1, :-1].ravel(), number[1:, :-1].ravel(), number[1:, 1:].ravel(), number[:-1, 1:].ravel()]
        )
        edges = (number[:, 0], number[-1, :], number[:, -1], number[0, :])
        ends = (number[0, 0], number[-1, 0], number[-1, -1], number[0, -1])
        sets = {f"{self.name}.edge_{k}": edge for k, edge in enumerate(edges, 1)}
        sets |= {f"{self.name}.corner_{k}": np.array([end]) for k, end in enumerate(ends, 1)}
        for name, places in self.nodes.items():
            nearest = [number[np.abs(u - a).argmin(), np.abs(v - b).argmin()] for a, b in places]
            sets[name] = np.unique(nearest)
        mesh = Mesh(
            points=self._surface(uu, vv),
            cells=(("quad", quads),),
            node_sets={self.name: np.arange(len(uu)), **sets},
            facet_sets={self.name: quads},
            name=self.name,
        )
        middle = np.column_stack([uu[quads].mean(axis=1), vv[quads].mean(axis=1)])
        return shell(mesh, self.material, self._thickness(*middle.T), lumped=self.lumped, stress_side=self.stress_side)

    def _rows(self, length: float, named: np.ndarray) -> np.ndarray:
        """Return the lines of the mesh across an edge: at named places, and between them as `size` asks."""
        fixed = np.unique(np.round(np.concatenate([[0.0, 1.0], named]), 9))
        counts = np.maximum(1, np.ceil(np.diff(fixed) * length / float(self.size) * (1.0 - CLOSE))).astype(int)
        parts = [np.linspace(a, b, n, endpoint=False) for a, b, n in zip(fixed, fixed[1:], counts)]
        return np.concatenate([*parts, [1.0]])

    def _thickness(self, u: np.ndarray, v: np.ndarray) -> Any:
        if not np.ndim(self.thickness):
            return float(self.thickness)
        return _bilinear(u, v) @ self.thickness

    def _surface(self, u: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Return points (n, 3): bilinear between four corners, quadratic serendipity between eight points."""
        if len(self.corners) == 4:
            return _bilinear(u, v) @ self.corners
        r, s = 2.0 * u - 1.0, 2.0 * v - 1.0
        corner = [
            0.25 * (1.0 + a * r) * (1.0 + b * s) * (a * r + b * s - 1.0)
            for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1))
        ]
        middle = [
            0.5 * (1.0 - r**2) * (1.0 - s),
            0.5 * (1.0 + r) * (1.0 - s**2),
            0.5 * (1.0 - r**2) * (1.0 + s),
            0.5 * (1.0 - r) * (1.0 - s**2),
        ]
        return np.column_stack([*corner, *middle]) @ self.corners


def _bilinear(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Return the shares (n, 4) of the corners at fractions u and v."""
    return np.column_stack([(1.0 - u) * (1.0 - v), u * (1.0 - v), u * v, (1.0 - u) * v])
