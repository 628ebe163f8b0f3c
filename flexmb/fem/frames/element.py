"""Element matrices of straight beams with two nodes, exact for end loads (docs/theory/frames.md).

All arrays are batched over the elements (ne). Local axes: x along the element, y and z of the section.
Order of the six components: (u, v, w, theta_x, theta_y, theta_z) and (N, V_y, V_z, M_x, M_y, M_z), all on
the line of nodes. A "table" is a function of the fraction 0..1 of the element length that returns (ne, 6,
6) section matrices.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from flexmb.fem.frames.section import Section
from flexmb.model.material import Material

__all__ = ["FrameElements", "section_flexibility", "section_mass"]

Table = Callable[[float], np.ndarray]

MASS_POINTS = 4
"""Gauss points along the element: exact for the product of two cubic interpolations."""
FLEXIBILITY_POINTS = 4
"""Gauss points of the flexibility integral: exact (degree 2) for prismatic elements, degree 7 for tapered
ones."""


def section_flexibility(section: Section, material: Material, shear: bool) -> np.ndarray:
    """Return the section flexibility S (6, 6): strains and curvatures on the line of nodes per section force.

    S = T^-1 S_c T^-T (frames.md, eq. (frame-flexibility)), S_c about the area centre (axial, bending) and the
    shear centre (shear, torsion). Without shear deformation (Euler-Bernoulli) the two shear terms are zero.
    """
    e, g = material.young, material.shear
    centred = np.zeros((6, 6))
    centred[0, 0] = 1.0 / (e * section.area)
    if shear:
        centred[1, 1] = 1.0 / (g * section.area * section.shear_y)
        centred[2, 2] = 1.0 / (g * section.area * section.shear_z)
    centred[3, 3] = 1.0 / (g * section.torsion)
    determinant = section.inertia_y * section.inertia_z - section.product_yz**2
    centred[4:, 4:] = np.array([[section.inertia_z, section.product_yz], [section.product_yz, section.inertia_y]])
    centred[4:, 4:] /= e * determinant
    (ya, za), (ys, zs) = section.area_center, section.shear_center
    inverse = np.eye(6)
    inverse[0, 4], inverse[0, 5] = -za, ya
    inverse[1, 3], inverse[2, 3] = zs, -ys
    return inverse @ centred @ inverse.T


def section_mass(section: Section, material: Material, rotary_inertia: bool, polar: bool = True) -> np.ndarray:
    """Return the section mass (6, 6) per length, kg/m, kg and kg m, for the motion of the line of nodes.

    The polar inertia (torsion) is there unless `polar` is False; `rotary_inertia` adds the bending rotations rho I_y,
    rho I_z. Without both it is the mass of the points at which the section's masses have their centres.
    The section's `line_mass` has no rotary inertia of its own.
    """
    y, z = section.mass_center
    arm = np.array([[0.0, -z, y], [z, 0.0, 0.0], [-y, 0.0, 0.0]])
    mass = material.density * section.area
    own = np.zeros((3, 3))
    own[0, 0] = section.polar_inertia if polar else 0.0
    if rotary_inertia:
        own[1, 1], own[2, 2] = section.inertia_y, section.inertia_z
        own[1, 2] = own[2, 1] = -section.product_yz
    matrix = np.zeros((6, 6))
    matrix[:3, :3] = mass * np.eye(3)
    matrix[:3, 3:], matrix[3:, :3] = -mass * arm, -mass * arm.T
    matrix[3:, 3:] = mass * arm.T @ arm + material.density * own
    if section.line_mass:
        y, z = section.line_mass_center
        arm = np.array([[0.0, -z, y], [z, 0.0, 0.0], [-y, 0.0, 0.0]])
        extra = section.line_mass
        matrix[:3, :3] += extra * np.eye(3)
        matrix[:3, 3:] -= extra * arm
        matrix[3:, :3] -= extra * arm.T
        matrix[3:, 3:] += extra * arm.T @ arm
    return matrix


def chosen_rows(table: Table, chosen: np.ndarray) -> Table:
    """Return the table of the chosen beams (mask); a table with one row serves all beams."""

    def rows(fraction: float) -> np.ndarray:
        values = table(fraction)
        return values if len(values) == 1 else values[chosen]

    return rows


class FrameElements:
    """Interpolation, stiffness and mass of beams of given lengths.

    Parameters
    ----------
    lengths : (ne,), m
    flexibility : table of section flexibilities
    mass : table of section masses
    points : table of section masses or None
        Those that lumped masses take, without rotary inertia of their own; None: `mass`.
    """

    def __init__(self, lengths: np.ndarray, flexibility: Table, mass: Table, points: Table | None = None):
        self.lengths, self.flexibility, self.mass = np.asarray(lengths, float), flexibility, mass
        self.points = points
        arm = transport(self.lengths)
        self.incidence = np.concatenate([-arm, np.broadcast_to(np.eye(6), arm.shape)], axis=2)
        total = self._deflection(1.0)
        self.inverse = np.linalg.inv(0.5 * (total + total.swapaxes(1, 2)))
        self.end_forces = self.inverse @ self.incidence
        """(ne, 6, 12): section forces at the second node per local end displacement."""

    def part(self, chosen: np.ndarray) -> FrameElements:
        """Return the chosen beams (mask)."""
        points = None if self.points is None else chosen_rows(self.points, chosen)
        return FrameElements(
            self.lengths[chosen], chosen_rows(self.flexibility, chosen), chosen_rows(self.mass, chosen), points
        )

    def stiffness(self) -> np.ndarray:
        """Return the local stiffness matrices (ne, 12, 12), frames.md eq. (frame-stiffness)."""
        matrix = self.incidence.swapaxes(1, 2) @ self.end_forces
        return 0.5 * (matrix + matrix.swapaxes(1, 2))

    def consistent_mass(self) -> np.ndarray:
        """Return the local mass matrices (ne, 12, 12) of the same interpolation, eq. (frame-mass)."""
        matrix = np.zeros((len(self.lengths), 12, 12))
        for fraction, weight in gauss(MASS_POINTS):
            shape = self.interpolation(fraction)
            matrix += weight * self.lengths[:, None, None] * (shape.swapaxes(1, 2) @ self.mass(fraction) @ shape)
        return 0.5 * (matrix + matrix.swapaxes(1, 2))

    def lumped_mass(self) -> np.ndarray:
        """Return block-diagonal local mass matrices (ne, 12, 12).

        Half the section masses at each node; the bending rotations get the rho A L^3 / 78 of Hinton, Rock &
        Zienkiewicz (Earthq. Eng. Struct. Dyn. 4 (1976) 245-249), so that the matrix is positive definite. With `points`
        they have no more than the masses beside the line of nodes.
        """
        matrix = np.zeros((len(self.lengths), 12, 12))
        for node, fraction in enumerate((0.25, 0.75)):
            section = (self.points or self.mass)(fraction)
            rows = slice(6 * node, 6 * node + 6)
            matrix[:, rows, rows] = 0.5 * self.lengths[:, None, None] * section
            if self.points is not None:
                continue
            rotation = section[:, 0, 0] * self.lengths**3 / 78.0
            matrix[:, 6 * node + 4, 6 * node + 4] += rotation
            matrix[:, 6 * node + 5, 6 * node + 5] += rotation
        return matrix

    def interpolation(self, fraction: float) -> np.ndarray:
        """Return the shape functions (ne, 6, 12) at a fraction of the length: exact static lines, eq.
        (frame-shape)."""
        shape = self._deflection(fraction) @ self.end_forces
        shape[:, :, :6] += transport(fraction * self.lengths)
        return shape

    def gradient(self, fraction: float) -> np.ndarray:
        """Return d/dx of the shape functions (ne, 6, 12), 1/m: strains plus the rigid part v' = theta_z, w'
        = -theta_y."""
        shape = self.interpolation(fraction)
        slope = self.flexibility(fraction) @ self.section_forces(fraction)
        slope[:, 1] += shape[:, 5]
        slope[:, 2] -= shape[:, 4]
        return slope

    def section_forces(self, fraction: float) -> np.ndarray:
        """Return the section forces (ne, 6, 12) per local end displacement at a fraction of the length."""
        return transport((1.0 - fraction) * self.lengths).swapaxes(1, 2) @ self.end_forces

    def _deflection(self, fraction: float) -> np.ndarray:
        """Displacement (ne, 6, 6) at a fraction, first node clamped, per force at the second node (eq.
        (frame-deflection))."""
        total = np.zeros((len(self.lengths), 6, 6))
        for inner, weight in gauss(FLEXIBILITY_POINTS):
            at = inner * fraction
            carry = transport((fraction - at) * self.lengths)
            force = transport((1.0 - at) * self.lengths).swapaxes(1, 2)
            total += weight * fraction * self.lengths[:, None, None] * (carry @ self.flexibility(at) @ force)
        return total


def transport(distance: np.ndarray) -> np.ndarray:
    """Return R (ne, 6, 6): the rigid motion of a point seen at a distance (ne,), m, further along x.

    v grows by theta_z, w shrinks by theta_y per length; R^T carries section forces back along the beam.
    """
    matrix = np.tile(np.eye(6), (len(distance), 1, 1))
    matrix[:, 1, 5] = distance
    matrix[:, 2, 4] = -distance
    return matrix


def gauss(count: int) -> list[tuple[float, float]]:
    """Return Gauss points and weights on 0..1."""
    points, weights = np.polynomial.legendre.leggauss(count)
    return [(float(0.5 + 0.5 * x), float(0.5 * w)) for x, w in zip(points, weights, strict=True)]
