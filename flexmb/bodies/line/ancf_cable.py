"""`AncfCable`: a cable, rope, belt or thin wire with large deformation, in absolute nodal coordinates."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np

from flexmb.bodies.line import cable_kernels as kernels
from flexmb.bodies.line.ancf_line import AncfLine, between_middles
from flexmb.bodies.line.cable_element import AXIAL, BENDING
from flexmb.bodies.line.curve import minimal_rotation
from flexmb.bodies.line.tangent_frame import tangent_axes
from flexmb.errors import ModelError
from flexmb.model.pose import Pose
from flexmb.model.table import Table

__all__ = ["AncfCable", "hermite"]


def hermite(x, length: float) -> np.ndarray:
    """Return the shape functions of (r_a, r'_a, r_b, r'_b) and their first two derivatives at x in 0..1, (3, 4, n).

    eq. (cable-shapes).
    """
    x, L = np.atleast_1d(np.asarray(x, float)), length
    N = [1 - 3 * x**2 + 2 * x**3, L * (x - 2 * x**2 + x**3), 3 * x**2 - 2 * x**3, L * (x**3 - x**2)]
    first = [(6 * x**2 - 6 * x) / L, 1 - 4 * x + 3 * x**2, (6 * x - 6 * x**2) / L, 3 * x**2 - 2 * x]
    second = [(12 * x - 6) / L**2, (6 * x - 4) / L, (6 - 12 * x) / L**2, (6 * x - 2) / L]
    return np.array([N, first, second])


@dataclass(frozen=True, eq=False)
class AncfCable(AncfLine):
    """A cable with axial and bending stiffness and constant mass matrix; it carries no torsion and no shear.

    Its freedoms are positions and gradients r' of the nodes, in W. Bending is the same in all directions: for a section
    with two different moments of inertia, or for torsion, use a beam.

    Parameters
    ----------
    name : str
    points : (n, 3), m, in the body's axes
        The stress-free line: straight between two points, a cubic spline through more.
    elements : int
        All of equal length.
    section : fem.Section, or several
        Its `area` (m2) and moment of inertia (m4); both moments must be equal. Several at equal distances from the
        start to the end make a taper.
    material : Material
    at, rotation : (3,) m; rotation vector, matrix or scipy Rotation
        Where these axes are at the start, in W.
    tangents : (2, 3), -, optional
        Directions of the line at both ends, in the body's axes.
    closed : bool
        The line returns to its first point, smoothly: a belt.
    initial_strain : float, -
        Axial strain that the line has as drawn; positive: it is under tension.
    straight : bool
        The line is bent into its shape: it is straight without load, instead of curved.
    axial_damping : float, N s
        Axial force per rate of strain.
    bending_damping : float, N m2 s
        Bending moment per rate of curvature.
    velocity, angular_velocity : (3,), m/s and rad/s, in W
        Rigid motion at the start, of the origin of the body's axes.
    lumped_masses : pairs (fraction, kg)
        Masses without size, fixed to the line.
    stretches : mapping of name to (from, to)
        Parts of the line, as fractions of its length, on which a `LineLoad` acts.
    skins : mapping of name to Skin
        Round tubes about the line that can touch, for a `SkinSurface`.
    markers : mapping of name to fraction or (fraction, rotation)
        Places on the line, 0 to 1 of its length. The axes of a marker as drawn: x along the line, the others the
        body's, turned with x by the smallest rotation; `rotation` turns them further, and then z should be the axis of
        the joint: the line may turn about it without limit. ``start`` and ``end`` always exist.

    Source: Gerstmayr & Shabana 2006 (element); Gerstmayr & Irschik 2008 (strains).

    Examples
    --------
    >>> from flexmb import MATERIALS, fem
    >>> rope = AncfCable("rope", points=((0, 0, 0), (2, 0, 0)), elements=8, section=fem.Section.solid_circle(0.01),
    ...                  material=MATERIALS["steel"])
    >>> rope.n_vector, round(rope.mass, 3)
    (54, 1.233)
    """

    _: KW_ONLY
    closed: bool = False  # type: ignore[misc]
    axial_damping: float = 0.0
    bending_damping: float = 0.0

    table: ClassVar[Table] = Table(
        "AncfCable", kernels.ROW, {"place": kernels.place, "inertia": kernels.inertia, "energy": kernels.energy}
    )
    node_size: ClassVar[int] = 6
    needs: ClassVar[tuple[str, ...]] = ("area", "inertia_y", "inertia_z")
    force_titles: ClassVar[tuple[str, ...]] = ("N [N]", "Q [N]", "M [N m]")
    strain_titles: ClassVar[tuple[str, ...]] = ("strain [-]", "curvature [1/m]")

    def __post_init__(self):
        super().__post_init__()
        self.require_positive("axial_damping", "bending_damping", zero=True)
        for section in self.sections:
            if abs(section.inertia_y - section.inertia_z) > 1e-6 * section.inertia_y:
                raise ModelError(
                    self.title,
                    found=f"moments of inertia {section.inertia_y:.6g} and {section.inertia_z:.6g} m4",
                    expected="the same bending stiffness in all directions: a cable has no sides",
                    remedy="Use AncfBeam, or for motion in a plane fem.Section.values(A, I, I, J)",
                )

    def marker_poses(self) -> dict[str, Pose]:
        """Return the markers as drawn: positions from the first node, axes in W."""
        r = self.curve.r
        q = np.hstack([r - r[0], self.curve.t])
        poses = {}
        for name, (fraction, rotation) in self.places.items():
            at, tangent = self.line(q.ravel(), fraction)[:2]
            x = self.rotation.T @ tangent[0]
            axes = self.rotation @ minimal_rotation(np.array([1.0, 0.0, 0.0]), x / np.linalg.norm(x))
            poses[name] = Pose(tuple(at[0]), axes if rotation is None else axes @ rotation)
        return poses

    def _reference(self, t, axes, rotation, gravity) -> np.ndarray:
        """Return the direction d about which a marker's frame turns without spin.

        The z-axis of a marker with given axes (the axis of its joint), the normal of a line that is bent in a plane, or
        of the plane in which gravity makes it swing; else the marker's z-axis.
        """
        normals = np.cross(self.curve.t[:-1], self.curve.t[1:]).sum(axis=0) if len(self.curve.t) > 1 else np.zeros(3)
        down = gravity / max(float(np.linalg.norm(gravity)), 1e-300)
        candidates = [axes[:, 2]] if rotation is not None else [normals, np.cross(t, down)]
        for d in (*candidates, axes[:, 2], axes[:, 1]):
            size = np.linalg.norm(d)
            if size > 1e-6 and np.linalg.norm(np.cross(d, t)) > 0.1 * size:
                return d / size
        return axes[:, 1]

    def line(self, q: np.ndarray, fractions) -> np.ndarray:
        """Return position r, r' and r'' at fractions (n,) of the length, (3, n, 3), for coordinates q (nq,)."""
        e, x = self.elements_at(fractions)
        nodes = np.asarray(q, float).reshape(-1, 2, 3)[self.couplings()[e]]
        return np.einsum("dsn,nsi->dni", hermite(x, self.element_length), nodes.reshape(len(x), 4, 3))

    def section_axes(self, q: np.ndarray, fractions) -> tuple[np.ndarray, np.ndarray]:
        """Return position (n, 3), m, and axes (n, 3, 3) in W at increasing fractions (n,): x along the line.

        A cable does not say how its sections are turned: y and z go along the line without twist, from the body's
        y-axis, or with the least uniform twist that closes a belt.
        """
        r, rho, _ = self.line(q, fractions)
        t = _unit(rho)
        axes = np.empty((len(t), 3, 3))
        R = self.rotation @ minimal_rotation(np.array([1.0, 0.0, 0.0]), self.rotation.T @ t[0])
        for k in range(len(t)):
            R = R if k == 0 else minimal_rotation(t[k - 1], t[k]) @ R
            axes[k] = R
        if self.closed:  # the axes that went around come back turned: every section takes its share of that
            back = minimal_rotation(t[-1], t[0]) @ axes[-1][:, 1]
            angle = -np.arctan2(back @ axes[0][:, 2], back @ axes[0][:, 1]) * np.asarray(fractions, float)
            c, s = np.cos(angle)[:, None], np.sin(angle)[:, None]
            y, z = axes[:, :, 1].copy(), axes[:, :, 2].copy()
            axes[:, :, 1], axes[:, :, 2] = c * y + s * z, c * z - s * y
        return r, axes

    def initial_state(self):
        """Return positions and gradients of the nodes, and their velocities in the rigid motion."""
        t = self.curve.t[:, None]
        return np.hstack([self.curve.r, self.curve.t]).ravel(), self.rigid_velocities(t).ravel()

    def shares_of_size(self, q: np.ndarray) -> np.ndarray:
        """Return the least stretch along the chord in each element (elements,), q (nq,)."""
        nodes = np.asarray(q, float).reshape(-1, 2, 3)
        ends = nodes[self.couplings()]
        chord = (ends[:, 1, 0] - ends[:, 0, 0]) / self.element_length
        z = np.stack([chord, ends[:, 0, 1], ends[:, 1, 1]], axis=1)
        rho = np.concatenate([np.einsum("gm,emi->egi", AXIAL, z), ends[:, :, 1]], axis=1)
        length = np.linalg.norm(chord, axis=1)
        along = np.einsum("egi,ei->eg", rho, chord / np.where(length > 0.0, length, 1.0)[:, None]).min(axis=1)
        return np.minimum(along, length)

    def element_data(self) -> np.ndarray:
        """Return the bulk data of all elements (elements, 45), see `ELEMENT`."""
        L, E = self.element_length, self.material.young
        (x7, w7), (x5, w5), (x3, w3) = (np.polynomial.legendre.leggauss(n) for n in (7, 5, 3))
        nodes = np.stack([self.curve.r, self.curve.t], axis=1)
        rows = []
        for e, (a, b) in enumerate(self.couplings()):
            z = np.concatenate([nodes[a], nodes[b]])
            d = np.array([(z[2] - z[0]) / L, z[1], z[3]])
            area7, area5, inertia3 = (
                self.constants((e + 0.5 * (1.0 + x)) / self.elements, name)[0]
                for x, name in ((x7, "area"), (x5, "area"), (x3, "inertia_y"))
            )
            N = hermite(0.5 * (1.0 + x7), L)
            weight = (
                0.5 * w7 * L * self.material.density * area7 * np.linalg.norm(np.einsum("sn,si->ni", N[1], z), axis=1)
            )
            mass, moments = np.einsum("n,sn,tn->st", weight, N[0], N[0]), N[0] @ weight
            for at, lumped in self.masses_of(e):
                shape = hermite(at, L)[0, :, 0]
                mass, moments = mass + lumped * np.outer(shape, shape), moments + lumped * shape
            stretch = np.linalg.norm(AXIAL @ d, axis=1)
            axial = np.stack(
                [
                    0.5 * w5 * L * E * area5 / stretch,
                    stretch * (1.0 - self.initial_strain),
                    0.5 * w5 * L * self.axial_damping / stretch,
                ],
                axis=1,
            )
            rho, sigma = BENDING[:, :3] @ d, BENDING[:, 3:] @ d / L
            square = np.sum(rho**2, axis=1)
            stretch = np.sqrt(square)
            bent = np.linalg.norm(np.cross(rho, sigma), axis=1) / square * (0.0 if self.straight else 1.0)
            bent[bent < 1e-9 / L] = 0.0
            bending = np.stack(
                [0.5 * w3 * L * E * inertia3 / stretch, bent, 0.5 * w3 * L * self.bending_damping / stretch], axis=1
            )
            rows.append(np.concatenate([[L], mass.ravel(), moments, axial.ravel(), bending.ravel()]))
        return np.array(rows)

    def element_mass(self) -> tuple[np.ndarray, np.ndarray]:
        """Return masses (elements, 4, 4) and moments (elements, 4) of r_a, r'_a, r_b, r'_b, kg (m, m2)."""
        data = self.element_data()
        return data[:, 1:17].reshape(-1, 4, 4), data[:, 17:21]

    def record(self, compiler, place):
        """Return the row: elements and markers as bulk data."""
        L = self.element_length
        geometry = []
        for (fraction, rotation), pose in zip(self.places.values(), self.marker_poses().values(), strict=True):
            e, x = self.element_at(fraction)
            N = hermite(x, L)[:2, :, 0]
            N[np.abs(N) < 1e-15] = 0.0
            nodes = np.stack([self.curve.r, self.curve.t], axis=1)
            a, b = self.couplings()[e]
            t = N[1] @ np.concatenate([nodes[a], nodes[b]])
            t /= np.linalg.norm(t)
            d = self._reference(t, pose.matrix, rotation, compiler.gravity)
            geometry.append(np.concatenate([[a, b], N.ravel(), d, (tangent_axes(t, d).T @ pose.matrix).ravel()]))
        return {
            "nodes": len(self.curve.r),
            "data": place.bulk(self.element_data()),
            "geometry": place.bulk(np.array(geometry)),
            "couplings": compiler.couplings(self.name),
            "gravity": compiler.gravity,
        }

    def section_forces(self, q: np.ndarray, fractions) -> np.ndarray:
        """Return axial force N, shear force Q (N) and bending moment M (N m) at fractions (n,), (n, 3); without
        damping.

        The force in an element is the derivative of its energy by the distance of its nodes, eq. (cable-force): what
        its neighbours balance. N and Q are its parts along and across the tangent at the middle; between and beyond
        middles they are straight lines.
        """
        middle = _unit(self.line(q, (np.arange(self.elements) + 0.5) / self.elements)[1])
        force = self._element_forces(q)
        axial = np.einsum("ei,ei->e", force, middle)
        shear = np.linalg.norm(force - axial[:, None] * middle, axis=1)
        bending = self.material.young * self.constants(fractions, "inertia_y")[0] * self._bent(q, fractions)
        return np.column_stack([between_middles(np.stack([axial, shear], axis=1), fractions), bending])

    def section_strains(self, q: np.ndarray, fractions) -> np.ndarray:
        """Return axial strain (-), N / EA, and change of curvature (1/m) at fractions (n,), (n, 2)."""
        stiffness = self.material.young * self.constants(fractions, "area")[0]
        return np.stack([self.section_forces(q, fractions)[:, 0] / stiffness, self._bent(q, fractions)], axis=1)

    def _element_forces(self, q) -> np.ndarray:
        """Return the internal force of every element, in W, (elements, 3)."""
        L, data = self.element_length, self._data
        (x5, _), (x3, _) = (np.polynomial.legendre.leggauss(n) for n in (5, 3))
        first = np.arange(self.elements)[:, None]
        rho = self.line(q, ((first + 0.5 * (1.0 + x5)) / self.elements).ravel())[1].reshape(-1, 5, 3)
        k, rest, _ = np.moveaxis(data[:, 21:36].reshape(-1, 5, 3), 2, 0)
        length = np.linalg.norm(rho, axis=2)
        force = np.einsum("eg,egi,g->ei", k * (1.0 - rest / length), rho, AXIAL[:, 0])
        _, rho, sigma = self.line(q, ((first + 0.5 * (1.0 + x3)) / self.elements).ravel())
        k, rest, _ = data[:, 36:45].reshape(-1, 3).T
        square, axis = np.sum(rho**2, axis=1), _unit(np.cross(rho, sigma))
        bend = np.linalg.norm(self._curvature(rho, sigma), axis=1)
        by_rho = (np.cross(sigma, axis) - 2.0 * bend[:, None] * rho) / square[:, None]
        by_sigma = np.cross(axis, rho) / square[:, None]
        weights = np.tile(BENDING, (self.elements, 1))
        part = (k * (bend - rest))[:, None] * (weights[:, 0:1] * by_rho + weights[:, 3:4] / L * by_sigma)
        return (force + part.reshape(-1, 3, 3).sum(axis=1)) / L

    @cached_property
    def _data(self) -> np.ndarray:
        return self.element_data()

    def _bent(self, q, fractions) -> np.ndarray:
        """Return the change of curvature per length as drawn, (n,)."""
        _, rho, sigma = self.line(q, fractions)
        now = np.linalg.norm(self._curvature(rho, sigma), axis=1) / self._drawn(fractions)
        return now - self._rest_curvature(fractions)

    @staticmethod
    def _curvature(rho, sigma) -> np.ndarray:
        """Return the turn of the tangent per x as a vector, (n, 3)."""
        return np.cross(rho, sigma) / np.sum(rho**2, axis=1)[:, None]

    def _drawn(self, fractions) -> np.ndarray:
        """Return |r'| of the line as drawn, (n,)."""
        return np.linalg.norm(self.line(self.initial_state()[0], fractions)[1], axis=1)

    def _rest_curvature(self, fractions) -> np.ndarray:
        """Return the curvature without load, per length as drawn, (n,)."""
        _, rho, sigma = self.line(self.initial_state()[0], fractions)
        bent = np.linalg.norm(self._curvature(rho, sigma), axis=1) / np.linalg.norm(rho, axis=1)
        return 0.0 * bent if self.straight else bent


def _unit(vectors: np.ndarray) -> np.ndarray:
    length = np.linalg.norm(vectors, axis=1)[:, None]
    return vectors / np.where(length > 0.0, length, 1.0)
