"""`AncfPlate`: a plate or shell with large deformation in absolute nodal coordinates, thin or shear-deformable."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import KW_ONLY, dataclass, field
from typing import Any, ClassVar

import numpy as np

from flexmb.bodies.frame_state import check_frame, check_initial_strain
from flexmb.bodies.line.ancf_line import COLLAPSED, element_momentum
from flexmb.bodies.plate import kernels
from flexmb.bodies.plate.axes import held_edge, marker_axes
from flexmb.bodies.plate.data import shell_elements, thin_elements
from flexmb.bodies.plate.forces import at_fractions, least_areas, thin_strains, with_director_strains
from flexmb.bodies.plate.places import (
    Place,
    add_masses,
    checked_masses,
    functional,
    place_of,
)
from flexmb.bodies.plate.quad_grid import grid_of_mesh
from flexmb.bodies.plate.row import LOADS, coupled_nodes, plate_row
from flexmb.bodies.plate.skin import face_patches
from flexmb.bodies.plate.surface import (
    Surface,
    checked_elements,
    checked_points,
    checked_thickness,
    surface_through,
)
from flexmb.errors import ModelError
from flexmb.model.kinds import Body
from flexmb.model.material import Material
from flexmb.model.plausibility import material_doubts, section_doubts
from flexmb.model.pose import Pose
from flexmb.model.skin import SkinFacets, SkinPatch, checked_skins
from flexmb.model.table import Table
from flexmb.told import tell

__all__ = ["AncfPlate"]

CORNER_MARKERS = {"corner_00": (0.0, 0.0), "corner_10": (1.0, 0.0), "corner_11": (1.0, 1.0), "corner_01": (0.0, 1.0)}


@dataclass(frozen=True, eq=False)
class AncfPlate(Body):
    """A plate or shell that stretches and bends through large rotations, with constant mass matrix.

    Thin (Kirchhoff): nodes with position and two gradients, no shear across the thickness. With ``shear=True``: nodes
    with position and a director, transverse shear (Reissner-Mindlin) taken from the middles of the edges, so that thin
    plates do not lock.

    Parameters
    ----------
    name : str
    points : (p, q, 3), m, in the body's axes
        A grid of points on the stress-free middle surface, at least 2 x 2. Along the first index runs the fraction s,
        along the second t; the normal is s x t. Straight between two points, a cubic spline through more.
    thickness : float or grid (a, b), m
        One number, or values at equal steps of s and t, bilinear between.
    material : Material
    elements : (2,) int, optional
        Along s and t; by default a node at every point.
    shear : bool
        Shear-deformable instead of thin.
    shear_factor : float, -
        Share of the thickness that carries the transverse shear; for shear-deformable plates.
    at, rotation : (3,) m; rotation vector, matrix or scipy Rotation
        Where the body's axes are at the start, in W.
    initial_strain : float, -
        Strain in all directions of the surface that the plate has as drawn; positive: it is under tension.
    flat : bool
        The plate is bent into its shape: without load it has no curvature.
    damping : float, s
        Stress resultants per rate of strain, as a multiple of the stiffness.
    velocity, angular_velocity : (3,), m/s and rad/s, in W
        Rigid motion at the start, of the origin of the body's axes.
    lumped_masses : pairs ((s, t), kg)
        Masses fixed to the surface, without inertia of their own against turning.
    markers : mapping of name to (s, t) or ((s, t), rotation)
        Places on the surface by two fractions of the grid. Axes: x along s, z normal; `rotation` turns them further.
        With "mean" for one fraction, ``(1.0, "mean")``, the marker is the mean of a line: a force on it is spread
        evenly along that line. ``corner_00``, ``corner_10``, ``corner_11``, ``corner_01`` always exist.
    skins : mapping of name to Skin
        Both faces, half the thickness from the middle surface, that can touch, for a `SkinSurface`.

    Notes
    -----
    `Pressure` takes the loads "body.pressure" (along the normal, it turns with the surface) and "body.load_x",
    "load_y", "load_z" (force per area as drawn, along the axes of W).

    Source: Dufva & Shabana 2005, Dmitrochenko & Pogorelov 2003 (thin); Yamashita, Valkeapaeae, Jayakumar & Sugiyama
    2015 with the shear of Dvorkin & Bathe 1984 (shear-deformable).

    Examples
    --------
    >>> from flexmb import MATERIALS
    >>> plate = AncfPlate.rectangle("wing", edges=(2.0, 0.5), elements=(8, 2), thickness=0.01,
    ...                             material=MATERIALS["steel"])
    >>> plate.n_vector, round(plate.mass, 3)
    (243, 78.5)
    """

    name: str
    _: KW_ONLY
    points: Any
    thickness: Any
    material: Material
    elements: Any = None
    shear: bool = False
    shear_factor: float = 5.0 / 6.0
    at: Any = (0.0, 0.0, 0.0)
    rotation: Any = None
    initial_strain: float = 0.0
    flat: bool = False
    damping: float = 0.0
    lumped_masses: Any = ()
    velocity: Any = (0.0, 0.0, 0.0)
    angular_velocity: Any = (0.0, 0.0, 0.0)
    markers: Mapping[str, Any] = field(default_factory=dict)
    skins: Mapping[str, Any] = field(default_factory=dict)

    table: ClassVar[Table] = Table(
        "AncfPlate", kernels.ROW, {"place": kernels.place, "inertia": kernels.inertia, "energy": kernels.energy}
    )
    has_frame: ClassVar[bool] = False
    drawn: ClassVar[str] = "sheet"
    load_names: ClassVar[tuple[str, ...]] = LOADS

    def __post_init__(self):
        super().__post_init__()
        self.require_positive("damping", zero=True)
        self.require_positive("shear_factor")
        if not isinstance(self.material, Material):
            raise ModelError(
                self.title,
                found=f"material = {self.material!r}",
                expected="a Material",
                remedy="Write material=fmb.MATERIALS['steel']",
            )
        check_frame(self)
        check_initial_strain(self)
        points = checked_points(self.points, self.title)
        object.__setattr__(self, "points", points)
        object.__setattr__(self, "elements", checked_elements(self.elements, points, self.title))
        object.__setattr__(self, "_thickness", checked_thickness(self.thickness, self.title))
        self._doubt(float(np.linalg.norm(np.ptp(points.reshape(-1, 3), axis=0))))
        object.__setattr__(
            self,
            "_surface",
            surface_through(np.array(self.at) + points @ np.asarray(self.rotation).T, self.elements, self.title),
        )
        object.__setattr__(self, "markers", dict(self.markers or {}))
        places = {name: place_of(value, name, self.title) for name, value in {**CORNER_MARKERS, **self.markers}.items()}
        object.__setattr__(
            self, "skins", checked_skins(self.skins, self.title, needs=(), lacks=("nodes", "radius", "between"))
        )
        more, patches, facets = face_patches(self, self.skins)
        object.__setattr__(self, "_places", places | more)
        object.__setattr__(self, "_patches", patches)
        object.__setattr__(self, "_facets", facets)
        object.__setattr__(self, "lumped_masses", checked_masses(self.lumped_masses, self.title))
        heads, element_points = (shell_elements if self.shear else thin_elements)(
            self.surface, self._nodal_vectors(), self
        )
        add_masses(self, heads)
        object.__setattr__(self, "_data", (heads, element_points))
        drawn = {name: functional(self, place) for name, place in self.places.items()}
        object.__setattr__(self, "_drawn", drawn)
        object.__setattr__(
            self, "_pairs", coupled_nodes([*self.surface.cells, *(nodes for nodes, _ in drawn.values())])
        )

    def _doubt(self, length: float) -> None:
        """Warn of a material, or of a thickness beside the size, m, that can hardly be meant."""
        found = material_doubts(self.material.young, self.material.density)
        found += section_doubts(float(np.max(self._thickness)), length, "a thickness")  # type: ignore[attr-defined]
        for text in found:
            tell(f"{self.title}: {text}")

    @classmethod
    def rectangle(cls, name: str, *, edges, thickness, material, corner=(0.0, 0.0, 0.0), **fields) -> AncfPlate:
        """Return a flat rectangle in the x-y plane of the body's axes: edges (2,), m, along x and y from a corner."""
        (a, b), at = edges, np.asarray(corner, float)
        points = at + np.array([[(0.0, 0.0, 0.0), (0.0, b, 0.0)], [(a, 0.0, 0.0), (a, b, 0.0)]])
        return cls(name, points=points, thickness=thickness, material=material, **fields)

    @classmethod
    def cylinder(
        cls, name: str, *, radius: float, angle: float, length: float, elements, thickness, material, **fields
    ) -> AncfPlate:
        """Return a part of a cylinder about the body's z-axis: s runs by `angle`, rad, from the x-axis, t along z."""
        along, across = checked_elements(elements, np.empty((2, 2, 3)), f"Body '{name}'")
        turn = np.linspace(0.0, angle, along + 1)
        ring = np.stack([radius * np.cos(turn), radius * np.sin(turn), np.zeros_like(turn)], axis=1)
        points = ring[:, None] + np.linspace(0.0, length, across + 1)[:, None] * np.array([0.0, 0.0, 1.0])
        return cls(name, points=points, thickness=thickness, material=material, **fields)

    @classmethod
    def from_mesh(cls, name: str, mesh, *, thickness, material, group: str | None = None, **fields) -> AncfPlate:
        """Return a plate on the quadrilaterals of a mesh (`fem.read_mesh`), in rows and columns: a node at every node.

        `group` names the cells; by default all quadrilaterals. s runs along the first row, from the lowest corner.
        """
        points = grid_of_mesh(mesh, group, f"Body '{name}'")
        return cls(name, points=points, thickness=thickness, material=material, **fields)

    @property
    def surface(self) -> Surface:
        """Nodes and elements as drawn, in W."""
        return self._surface  # type: ignore[attr-defined]

    @property
    def places(self) -> dict[str, Place]:
        """Fractions and given rotation of every marker."""
        return self._places  # type: ignore[attr-defined]

    @property
    def skin_patches(self) -> Mapping[str, tuple[SkinPatch, ...]]:
        """The pieces of every skin."""
        return self._patches  # type: ignore[attr-defined]

    @property
    def skin_facets(self) -> Mapping[str, SkinFacets]:
        """The faces of the skins that have them."""
        return self._facets  # type: ignore[attr-defined]

    @property
    def skin_thickness(self) -> Mapping[str, float]:
        """Twice the volume per area behind every skin, m."""
        return dict.fromkeys(self.skins, float(np.min(self._thickness)))  # type: ignore[attr-defined]

    @property
    def vectors(self) -> int:
        """Vectors per node: r, r_s, r_t of a thin plate; r, d of a shear-deformable one."""
        return 2 if self.shear else 3

    @property
    def mass(self) -> float:
        """Mass, kg."""
        return float(self.element_mass()[1][:, :: self.vectors].sum())

    @property
    def n_vector(self) -> int:
        """Coordinates of all nodes."""
        return 3 * self.vectors * len(self.surface.r)

    @property
    def block_size(self) -> int:
        """A node is a block of the iteration matrix."""
        return 3 * self.vectors

    def thickness_in(self, x: float, y: float) -> np.ndarray:
        """Return the thickness (ne,), m, at x, y in -1..1 of all elements."""
        s, t = ((np.arange(n) + 0.5 + 0.5 * z) / n for n, z in zip(self.elements, (x, y), strict=True))
        return self.thickness_at(*np.meshgrid(s, t, indexing="ij")).ravel()

    def thickness_at(self, s, t) -> np.ndarray:
        """Return the thickness, m, at fractions."""
        from scipy.interpolate import RegularGridInterpolator

        h = self._thickness  # type: ignore[attr-defined]
        grid = RegularGridInterpolator(tuple(np.linspace(0.0, 1.0, n) for n in h.shape), h)
        return grid(np.stack([s, t], axis=-1))

    def _nodal_vectors(self) -> np.ndarray:
        s = self.surface
        others = s.normals[:, None] if self.shear else s.tangents
        return np.concatenate([s.r[:, None], others], axis=1)

    def couplings(self) -> np.ndarray:
        """Return the pairs of nodes in every element."""
        return np.array(list(self._pairs), int)  # type: ignore[attr-defined]

    def marker_blocks(self) -> dict[str, tuple[int, int]]:
        """Return the first node and the number of nodes between which those lie that move each marker."""
        drawn = self._drawn  # type: ignore[attr-defined]
        return {name: (int(min(nodes)), int(max(nodes) - min(nodes) + 1)) for name, (nodes, _) in drawn.items()}

    def element_at(self, s: float, t: float) -> tuple[int, float, float]:
        """Return the element and the place in it, x and y in -1..1, of two fractions."""
        at = []
        for fraction, n in zip((s, t), self.elements, strict=True):
            z = fraction * n
            z = round(z) if abs(z - round(z)) < 1e-9 * max(1.0, z) else z
            k = min(int(z), n - 1)
            at.append((k, 2.0 * (z - k) - 1.0))
        return at[0][0] * self.elements[1] + at[1][0], at[0][1], at[1][1]

    def held(self, name: str, edge: str, joint, rotation=None):
        """Return what holds the nodes of an edge on the ground: the plate with markers, the ground's markers, joints.

        Parameters
        ----------
        name : str
            The markers are ``name_0``, ``name_1``, ... on plate and ground, the joints as well.
        edge : str
            "s0", "s1", "t0" or "t1": where the fraction s or t is 0 or 1.
        joint : class
            ``flexmb.Fixed`` clamps, ``flexmb.Spherical`` supports, ``flexmb.Planar`` is a symmetry.
        rotation : rotation vector, matrix or scipy Rotation
            Axes of all these markers in W, as drawn: z is the axis of a hinge, the normal of a plane.

        Examples
        --------
        >>> from flexmb import MATERIALS, Fixed
        >>> plate = AncfPlate.rectangle("wing", edges=(2, 1), elements=(8, 4), thickness=0.01,
        material=MATERIALS["steel"])
        >>> plate, supports, clamps = plate.held("root", "s0", Fixed)
        >>> len(supports), clamps[4].markers
        (5, ('ground.root_4', 'wing.root_4'))
        """
        return held_edge(self, name, edge, joint, rotation)

    def drawn_at(self, nodes, weights) -> np.ndarray:
        """Return position and two directions (3, 3) as drawn."""
        return np.einsum("kvf,kvi->fi", weights, self._nodal_vectors()[nodes])

    def initial_state(self):
        """Return the vectors of the nodes, and their rates in the rigid motion."""
        nodal, w = self._nodal_vectors(), np.array(self.angular_velocity)
        rates = np.cross(w, nodal)
        rates[:, 0] = np.array(self.velocity) + np.cross(w, nodal[:, 0] - np.array(self.at))
        return nodal.ravel(), rates.ravel()

    def marker_poses(self) -> dict[str, Pose]:
        """Return the markers as drawn: positions from the first node, axes in W."""
        origin, poses = self.surface.r[0], {}
        for name, (nodes, weights) in self._drawn.items():  # type: ignore[attr-defined]
            r, a, b = self.drawn_at(nodes, weights)
            axes = marker_axes(a, b, self.shear)
            turned = self.places[name].rotation
            poses[name] = Pose(tuple(r - origin), axes if turned is None else axes @ turned)
        return poses

    def element_mass(self) -> tuple[np.ndarray, np.ndarray]:
        """Return masses of the elements' vectors (ne, nv, nv) and their moments (ne, nv), kg (m, m2)."""
        heads, V = self._data[0], 4 * self.vectors  # type: ignore[attr-defined]
        return heads[:, : V * V].reshape(-1, V, V), heads[:, V * V : V * V + V]

    def momentum(self, q: np.ndarray, u: np.ndarray) -> np.ndarray:
        """Return linear and angular momentum about the origin of W, (nt, 6), for q, u (nt, nq)."""
        return element_momentum(self.surface.cells, *self.element_mass(), q, u)

    def record(self, compiler, place):
        """Return the row: elements and markers as bulk data."""
        return plate_row(self, compiler, place, self._data, self._drawn, self._pairs)  # type: ignore[attr-defined]

    def inversion(self, q: np.ndarray) -> tuple[int, str] | None:
        """Return the first sample (nt, nq) at which an element has collapsed or turned inside out,
        and which; or None.
        """
        points = self._data[1]  # type: ignore[attr-defined]
        for k, row in enumerate(q):
            share = least_areas(points, self._of_elements(row))
            if not share.min() > COLLAPSED:
                e = int(np.argmin(np.where(np.isfinite(share), share, -np.inf)))
                how = "turned inside out" if share[e] < 0.0 else f"collapsed to {100.0 * share[e]:.2g} % of its area"
                return k, f"element {divmod(e, self.elements[1])} of {self.elements} has {how}"
        return None

    def _of_elements(self, q) -> np.ndarray:
        """Return the vectors of the nodes of every element (ne, V, 3)."""
        cells = self.surface.cells
        return np.asarray(q, float).reshape(-1, self.vectors, 3)[cells].reshape(len(cells), -1, 3)

    def surface_points(self, q: np.ndarray, nodes, weights) -> tuple[np.ndarray, np.ndarray]:
        """Return positions and unit normals (n, 3) of places with nodes (n, k) and weights (n, k, v, 3),
        see `functional`.
        """
        r, a, b = np.einsum("nkvf,nkvi->fni", weights, np.asarray(q, float).reshape(-1, self.vectors, 3)[nodes])
        normal = a if self.shear else np.cross(a, b)
        return r, normal / np.linalg.norm(normal, axis=1)[:, None]

    def strains(self, q: np.ndarray) -> np.ndarray:
        """Return changes of membrane strain and of curvature 11, 22, 2 x 12, and shear 1, 2, of all elements, (ne, 8).

        In the middle, in its axes: 1 along s, 2 across; -, 1/m and -. Curvature is positive where the side of the
        normal is stretched. Thin plates have no shear.
        """
        points = self._data[1]  # type: ignore[attr-defined]
        return (with_director_strains if self.shear else thin_strains)(points, self._of_elements(q))

    def resultants(self, q: np.ndarray, fractions=None) -> np.ndarray:
        """Return N11, N22, N12 (N/m), M11, M22, M12 (N) and Q1, Q2 (N/m), (n, 8).

        At fractions (n, 2) of s and t: bilinear between the middles of the elements, and beyond; without fractions in
        the middles (ne, 8). Per length as drawn, without damping. Thin plates have no law for Q: zero.
        """
        s, h = self.strains(q), self.thickness_in(0.0, 0.0)[:, None]
        E, nu = self.material.young, self.material.poisson
        C = np.array([[1.0, nu, 0.0], [nu, 1.0, 0.0], [0.0, 0.0, 0.5 * (1.0 - nu)]]) * E / (1.0 - nu**2)
        shear = self.shear_factor * self.material.shear * h * s[:, 6:]
        forces = np.hstack([h * s[:, :3] @ C, h**3 / 12.0 * s[:, 3:6] @ C, shear])
        return forces if fractions is None else at_fractions(forces, self.elements, fractions)
