"""`AncfBeam`: a beam with large deformation, shear and torsion, in absolute nodal coordinates."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from itertools import pairwise
from typing import Any, ClassVar

import numpy as np

from flexmb.bodies.line import beam_kernels as kernels
from flexmb.bodies.line.ancf_line import AncfLine, between_middles
from flexmb.bodies.line.beam_element import strains
from flexmb.bodies.line.curve import minimal_rotation
from flexmb.bodies.line.director_frame import section_frame
from flexmb.errors import ModelError
from flexmb.model.described import finite_array
from flexmb.model.pose import Pose
from flexmb.model.table import Table

__all__ = ["AncfBeam"]

GAUSS = 0.5 * (1.0 + np.array([-1.0, 1.0]) / np.sqrt(3.0))


def _quadratic(x) -> np.ndarray:
    """Return the shape functions at x in 0..1 and their derivatives by x, (2, 3, n): eq. (beam-shapes)."""
    x = np.atleast_1d(np.asarray(x, float))
    return np.array([[(1 - x) * (1 - 2 * x), 4 * x * (1 - x), x * (2 * x - 1)], [4 * x - 3, 4 - 8 * x, 4 * x - 1]])


@dataclass(frozen=True, eq=False)
class AncfBeam(AncfLine):
    """A beam that stretches, shears, twists and bends, with constant mass matrix and no limit of rotation.

    An element has three nodes with position and two directors, axes y and z of the section. It has the strains of a
    geometrically exact beam, integrated at two points: thin beams do not lock.

    Parameters
    ----------
    name : str
    points : (n, 3), m, in the body's axes
        The stress-free line: straight between two points, a cubic spline through more.
    elements : int
        All of equal length, with a node at both ends and in the middle.
    section : fem.Section, or several
        Area, moments of inertia, torsion constant, shear factors; all about the line. Several at equal distances from
        the start to the end make a taper: two equal shapes interpolate their dimensions.
    material : Material
    orientation : (3,), -, optional
        Direction of the section's y-axis at the start, in the body's axes (made perpendicular to the line); from there
        it goes along the line without twist. By default the body's y-axis, turned by the smallest rotation from x to
        the line.
    at, rotation : (3,) m; rotation vector, matrix or scipy Rotation
        Where the body's axes are at the start, in W.
    tangents : (2, 3), -, optional
        Directions of the line at both ends, in the body's axes.
    initial_strain : float, -
        Axial strain that the line has as drawn; positive: it is under tension.
    straight : bool
        The line is bent into its shape: without load it is straight and not twisted, instead of curved.
    damping : float, s
        Stress resultants per rate of strain, as a multiple of the stiffness.
    rotary_inertia : (2,), kg m, optional
        Moment of inertia per length about the section's axes y and z; by default density times the section's moments of
        inertia.
    velocity, angular_velocity : (3,), m/s and rad/s, in W
        Rigid motion at the start, of the origin of the body's axes.
    lumped_masses : pairs (fraction, kg)
        Masses without size, fixed to the line.
    stretches : mapping of name to (from, to)
        Parts of the line, as fractions of its length, on which a `LineLoad` acts.
    skins : mapping of name to Skin
        Round tubes about the line that can touch, for a `SkinSurface`.
    markers : mapping of name to fraction or (fraction, rotation)
        Places on the line, 0 to 1 of its length, with the axes of the section: x across it, along the undeformed line.
        `rotation` turns them further. ``start`` and ``end`` always exist.

    Source: Nachbagauer, Gruber & Gerstmayr 2013.
    """

    _: KW_ONLY
    orientation: Any = None
    damping: float = 0.0
    rotary_inertia: Any = None

    table: ClassVar[Table] = Table(
        "AncfBeam", kernels.ROW, {"place": kernels.place, "inertia": kernels.inertia, "energy": kernels.energy}
    )
    node_size: ClassVar[int] = 9
    intervals: ClassVar[int] = 2
    needs: ClassVar[tuple[str, ...]] = ("area", "inertia_y", "inertia_z", "torsion", "shear_y", "shear_z")
    force_titles: ClassVar[tuple[str, ...]] = ("N [N]", "Qy [N]", "Qz [N]", "Mx [N m]", "My [N m]", "Mz [N m]")
    strain_titles: ClassVar[tuple[str, ...]] = (
        "strain [-]",
        "shear y [-]",
        "shear z [-]",
        "twist [1/m]",
        "curvature y [1/m]",
        "curvature z [1/m]",
    )

    def __post_init__(self):
        super().__post_init__()
        self.require_positive("damping", zero=True)
        self._check_centres()
        inertia = finite_array((1.0, 1.0) if self.rotary_inertia is None else self.rotary_inertia)
        if inertia.shape != (2,) or inertia.min() <= 0.0:
            raise ModelError(
                self.title,
                found=f"rotary_inertia = {self.rotary_inertia!r}",
                expected="two positive numbers, kg m, about the section's axes y and z",
                remedy="Leave rotary_inertia out for density times moments of inertia",
            )
        object.__setattr__(self, "_directors", self._initial_directors())

    def _check_centres(self) -> None:
        for section in self.sections:
            off = {
                name: value
                for name in ("area_center", "shear_center", "mass_center")
                if np.any(value := np.asarray(getattr(section, name, (0.0, 0.0))))
            }
            if off or getattr(section, "product_yz", 0.0) != 0.0:
                raise ModelError(
                    self.title,
                    found=f"a section with centres off the line, {off}, or a product of inertia",
                    expected="area, shear and mass centre on the line, and principal axes",
                    remedy="Move the line to the centre, and turn the section with orientation=",
                )

    def _initial_directors(self) -> np.ndarray:
        """Return the axes y and z of the section at the nodes, in W, (n, 2, 3)."""
        t, R = self.curve.t, np.asarray(self.rotation)
        if self.orientation is None:
            y = R @ minimal_rotation(np.array([1.0, 0.0, 0.0]), R.T @ t[0])[:, 1]
        else:
            given = finite_array(self.orientation)
            across = np.cross(R.T @ t[0], given) if given.shape == (3,) else np.zeros(3)
            if not np.linalg.norm(across) > 1e-6 * np.linalg.norm(given):
                raise ModelError(
                    self.title,
                    found=f"orientation = {self.orientation!r}",
                    expected="a direction (3,) across the line at its start",
                    remedy="Give the direction of the section's y-axis",
                )
            y = R @ np.cross(across, R.T @ t[0])
            y /= np.linalg.norm(y)
        rows = [y]
        for before, after in pairwise(t):
            rows.append(minimal_rotation(before, after) @ rows[-1])
        y = np.array(rows)
        y -= np.sum(y * t, axis=1)[:, None] * t
        y /= np.linalg.norm(y, axis=1)[:, None]
        return np.stack([y, np.cross(t, y)], axis=1)

    def initial_state(self):
        """Return positions and directors of the nodes, and their velocities in the rigid motion."""
        directors = self._directors  # type: ignore[attr-defined]
        q = np.concatenate([self.curve.r[:, None], directors], axis=1)
        return q.ravel(), self.rigid_velocities(directors).ravel()

    def line(self, q: np.ndarray, fractions) -> np.ndarray:
        """Return r', r_y, r_z, r_y', r_z' (per m as drawn) and r at fractions (n,) of the length, (6, n, 3)."""
        e, x = self.elements_at(fractions)
        N, D = _quadratic(x)
        own = np.asarray(q, float).reshape(-1, 3, 3)[self.element_nodes()[e]]
        value = np.einsum("kn,nkvi->vni", N, own)
        slope = np.einsum("kn,nkvi->vni", D, own) / self.element_length
        return np.stack([slope[0], value[1], value[2], slope[1], slope[2], value[0]])

    def section_axes(self, q: np.ndarray, fractions) -> tuple[np.ndarray, np.ndarray]:
        """Return position (n, 3), m, and section axes (n, 3, 3) in W at fractions (n,) of the length."""
        line = self.line(q, fractions)
        axes = np.empty((line.shape[1], 3, 3))
        for k in range(len(axes)):
            section_frame(np.ascontiguousarray(line[1, k]), np.ascontiguousarray(line[2, k]), axes[k])
        return line[5], np.swapaxes(axes, 1, 2)

    def marker_poses(self) -> dict[str, Pose]:
        """Return the markers as drawn: positions from the first node, axes in W."""
        q = self.initial_state()[0]
        poses = {}
        for name, (fraction, rotation) in self.places.items():
            r, axes = self.section_axes(q, fraction)
            poses[name] = Pose(tuple(r[0] - self.curve.r[0]), axes[0] if rotation is None else axes[0] @ rotation)
        return poses

    def stiffness(self, fractions) -> np.ndarray:
        """Return stiffness of stretch, shear y, shear z (N), torsion, bending about y, about z (N m2), (n, 6)."""
        A, Iy, Iz, J, ky, kz = self.constants(fractions, *self.needs)
        E, G = self.material.young, self.material.shear
        return np.stack([E * A, G * A * ky, G * A * kz, G * J, E * Iy, E * Iz], axis=1)

    def _strains(self, q: np.ndarray, fractions) -> np.ndarray:
        """Return stretch and shears, torsion and bendings per length as drawn, (n, 6)."""
        line = self.line(q, fractions)
        out = np.empty((line.shape[1], 6))
        for k in range(len(out)):
            strains(np.ascontiguousarray(line[:5, k]), out[k])
        return out

    def _rest(self, fractions) -> tuple[np.ndarray, np.ndarray]:
        """Return the strains without stress (n, 6), and the stretch of the line as drawn (n,)."""
        q = self.initial_state()[0]
        rest = self._strains(q, fractions)
        rest[:, 0] *= 1.0 - self.initial_strain
        if self.straight:
            rest[:, 3:] = 0.0
        return rest, self._drawn(fractions)

    def shares_of_size(self, q: np.ndarray) -> np.ndarray:
        """Return the least volume, det(r', r_y, r_z), in each element (elements,) by that as drawn, q (nq,)."""
        points = ((np.arange(self.elements)[:, None] + np.array([1e-9, *GAUSS, 1.0 - 1e-9])) / self.elements).ravel()
        line = self.line(q, points)
        volume = np.einsum("ni,ni->n", line[0], np.cross(line[1], line[2])) / self._drawn(points)
        return volume.reshape(self.elements, -1).min(axis=1)

    def _drawn(self, fractions) -> np.ndarray:
        """Return |r'| of the line as drawn, (n,)."""
        return np.linalg.norm(self.line(self.initial_state()[0], fractions)[0], axis=1)

    def element_data(self) -> np.ndarray:
        """Return the bulk data of all elements (elements, 70), see `ELEMENT`."""
        L, density = self.element_length, self.material.density
        x, w = np.polynomial.legendre.leggauss(4)
        N = _quadratic(0.5 * (1.0 + x))[0]
        rows = []
        for e in range(self.elements):
            points = (e + 0.5 * (1.0 + x)) / self.elements
            weight = 0.5 * w * L * self._drawn(points)
            line_mass, rho_y, rho_z = density * self.constants(points, "area", "inertia_y", "inertia_z")
            if self.rotary_inertia is not None:
                rho_y, rho_z = (np.full(len(x), value) for value in self.rotary_inertia)
            # int y^2 dm moves with r_y: the moment of inertia about z
            mass = [np.einsum("n,sn,tn->st", weight * m, N, N) for m in (line_mass, rho_z, rho_y)]
            moments = N @ (weight * line_mass)
            for at, lumped in self.masses_of(e):
                shape = _quadratic(at)[0, :, 0]
                mass[0], moments = mass[0] + lumped * np.outer(shape, shape), moments + lumped * shape
            gauss = (e + GAUSS) / self.elements
            K, (rest, stretch) = self.stiffness(gauss), self._rest(gauss)
            mean = L * K.mean(axis=0)
            wall = np.array([mean[0], mean[0], 0.5 * (mean[1] + mean[2])])
            strains = [
                np.concatenate([0.5 * L * K[g] / stretch[g], rest[g], self.damping * 0.5 * L * K[g] / stretch[g]])
                for g in range(2)
            ]
            rows.append(np.concatenate([[L], *(m.ravel() for m in mass), moments, wall, *strains]))
        return np.array(rows)

    def element_mass(self) -> tuple[np.ndarray, np.ndarray]:
        """Return masses (elements, 9, 9) and moments (elements, 9) of r, r_y, r_z of three nodes, kg (m, m2)."""
        data = self.element_data()
        mass, moments = np.zeros((self.elements, 9, 9)), np.zeros((self.elements, 9))
        for v in range(3):
            mass[:, v::3, v::3] = data[:, 1 + 9 * v : 10 + 9 * v].reshape(-1, 3, 3)
        moments[:, 0::3] = data[:, 28:31]
        return mass, moments

    def record(self, compiler, place):
        """Return the row: elements and markers as bulk data."""
        q = self.initial_state()[0]
        geometry = []
        for (fraction, _), pose in zip(self.places.values(), self.marker_poses().values(), strict=True):
            nodes = self.marker_nodes(fraction)
            _, x = self.element_at(fraction)
            N = _quadratic(x)[0, :, 0] if len(nodes) == 3 else np.array([1.0, 0.0, 0.0])
            fixed = self.section_axes(q, fraction)[1][0].T @ pose.matrix
            geometry.append(np.concatenate([[nodes[0], len(nodes)], N, fixed.ravel()]))
        return {
            "data": place.bulk(self.element_data()),
            "geometry": place.bulk(np.array(geometry)),
            "couplings": compiler.couplings(self.name),
            "gravity": compiler.gravity,
        }

    def section_forces(self, q: np.ndarray, fractions) -> np.ndarray:
        """Return N, Q_y, Q_z (N), M_x, M_y, M_z (N m), in the axes of the section, at fractions (n,), (n, 6).

        The damping forces are not among them; see `section_strains`.
        """
        points = self._gauss_fractions()
        return self._smoothed(self.stiffness(points) * self._elastic(q, points), fractions)

    def section_strains(self, q: np.ndarray, fractions) -> np.ndarray:
        """Return axial strain, shears y and z (-), twist, curvatures y and z (1/m) beyond the stress-free, (n, 6).

        Means of the two points of each element, at its middle; between and beyond middles a straight line.
        """
        return self._smoothed(self._elastic(q, self._gauss_fractions()), fractions)

    def _gauss_fractions(self) -> np.ndarray:
        return (np.arange(self.elements)[:, None] + GAUSS).ravel() / self.elements

    def _elastic(self, q, points) -> np.ndarray:
        """Return the strains that make stress, per length as drawn, (n, 6)."""
        rest, stretch = self._rest(points)
        return (self._strains(np.asarray(q, float), points) - rest) / stretch[:, None]

    def _smoothed(self, values, fractions) -> np.ndarray:
        return between_middles(values.reshape(-1, 2, 6).mean(axis=1), fractions)
