"""`LaminateBlock`: flat shell elements with a layup: membrane, bending and their coupling, offset from the nodes.

Classical lamination theory (R. M. Jones, Mechanics of Composite Materials, 2nd ed. 1999, eq. (4.22)): forces and
moments per length N = A e + B k, M = B e + D k about the reference plane; transverse shear by `shell_shear`. It
interpolates as `ShellBlock` does.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np

from flexmb.fem.shells.block import ShellBlock
from flexmb.fem.shells.membrane import strain_rows
from flexmb.fem.shells.shear import edge_softness, shear_rows

__all__ = ["LaminateBlock", "laminate", "shear_stiffness", "turned_plane"]


ISOTROPIC = 1e-9
"""Share of the largest elasticity by which that of turned axes may differ."""
FLAT = 1e-9
"""Share of the thickness by which offsets may differ."""


@dataclass(frozen=True, kw_only=True, eq=False)
class LaminateBlock(ShellBlock):
    """Shell elements whose section is given by its stiffness matrices; an `ElementBlock`.

    Parameters
    ----------
    membrane, coupling, bending : (ne, 3, 3), N/m, N, N m
        A, B, D in the local axes of each element, about the reference plane.
    shear : (ne,), N/m
        Transverse shear stiffness per width; inf for thin shells.
    surface_mass : (ne,), kg/m2
    faces : (ne, 2, 3, 3), Pa
        Plane stress elasticity of the bottom and the top layer in local axes.
    depths : (ne, 2), m
        Height of the bottom and of the top over the reference plane.
    poisson : float
        Of the triangle's in-plane bending modes (shells.md); any value keeps the patch test.
    spring : float or None
        Share of the in-plane shear stiffness that holds the rotation about the normal, where the membrane has none of
        its own; None: the membrane turns with its corners.
    point_masses : bool
        Lumped masses have no rotary inertia, as those of Nastran.
    heights : (ne, c), m
        Of the nodes over the *reference plane*, an offset of the layup included.
    """

    membrane: np.ndarray
    coupling: np.ndarray
    bending: np.ndarray
    shear: np.ndarray
    surface_mass: np.ndarray
    faces: np.ndarray
    depths: np.ndarray
    poisson: float = 0.3
    spring: float | None = None  # type: ignore[misc]
    point_masses: bool = False  # type: ignore[misc]
    ROWS: ClassVar[tuple[str, ...]] = (
        *ShellBlock.ROWS,
        *("membrane", "coupling", "bending", "shear", "surface_mass", "faces", "depths"),
    )
    material: object = None  # type: ignore[assignment]

    @cached_property
    def elasticity(self) -> np.ndarray:  # type: ignore[override]
        """Mean membrane elasticity (ne, 3, 3), Pa, for (e_xx, e_yy, 2 e_xy)."""
        return self.membrane / self.thickness[:, None, None]

    @property
    def modulus(self) -> float:
        """Largest elastic stiffness, Pa."""
        return float(np.abs(self.faces).max())

    @cached_property
    def strains(self):
        """Function (xi, eta) -> membrane strains per local displacement of the projected corners."""
        stiff = self.membrane
        floor = 1e-9 * np.abs(stiff).max() if np.abs(stiff).max() > 0.0 else 1.0
        return strain_rows(self.corners, stiff + floor * np.eye(3), self.poisson, self.spring is None)

    @cached_property
    def softness(self) -> np.ndarray:  # type: ignore[override]
        """Shear parameter phi (ne, c) of every edge."""
        return edge_softness(self.corners, self.bending, self.shear)

    def sections(self) -> tuple[np.ndarray, np.ndarray | None, np.ndarray]:
        """Return A, B and D (ne, 3, 3) of ``int e^T A e - e^T B w - w^T B e + w^T D w dA``, w = -k."""
        return self.membrane, self.coupling, self.bending

    def _sheared(self, at) -> np.ndarray | float:
        """Return ``g^T H g`` at a point, (ne, 6 c, 6 c)."""
        finite = np.isfinite(self.shear)
        if not finite.any():
            return 0.0
        rows = shear_rows(self.corners, at, self.softness)
        stiff = np.where(finite, self.shear, 0.0)
        return (at.weight * stiff)[:, None, None] * (rows.swapaxes(1, 2) @ rows)

    def areal_mass(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return mass per area, depth and height of its middle; the mass lies in the middle between bottom and top."""
        return self.surface_mass, self.depths[:, 1] - self.depths[:, 0], self.depths.mean(axis=1)

    def layer(self, side: float) -> tuple[np.ndarray, np.ndarray]:
        """Return elasticity (ne, 3, 3), Pa, and height (ne,), m: side -1 bottom layer, 0 mean, +1 top layer."""
        height = 0.5 * (self.depths[:, 0] * (1.0 - side) + self.depths[:, 1] * (1.0 + side))
        return self.elasticity if side == 0.0 else self.faces[:, 0 if side < 0.0 else 1], height

    def fits(self, side: float) -> bool:
        """Whether stress may be fitted over cells: isotropic layers, whose axes do not matter, and one offset."""
        elasticity, _ = self.layer(side)
        turned = turned_plane(elasticity, 0.5)
        same = np.abs(turned - elasticity).max() <= ISOTROPIC * np.abs(elasticity).max()
        return bool(same) and float(np.ptp(self.heights)) <= FLAT * float(self.thickness.max())


def laminate(plies: list[tuple[np.ndarray, float, float]], bottom: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return A, B, D (3, 3) of plies (elasticity (3, 3) in the ply's own axes, thickness, angle in rad), upwards.

    `bottom` is the height of the lowest face over the reference plane (Jones 1999, eqs. (4.22) to (4.24)).
    """
    a, b, d = np.zeros((3, 3)), np.zeros((3, 3)), np.zeros((3, 3))
    low = bottom
    for elasticity, thickness, angle in plies:
        high = low + thickness
        q = turned_plane(elasticity, angle)
        a += q * (high - low)
        b += q * (high**2 - low**2) / 2.0
        d += q * (high**3 - low**3) / 3.0
        low = high
    return a, b, d


def shear_stiffness(plies: list[tuple[np.ndarray, float, float]], across: list[tuple[float, float]]) -> float:
    """Return the transverse shear stiffness per width, N/m, of plies as in `laminate`; inf where no ply shears.

    Cylindrical bending about either axis: ``1 / H = int F^2 / G dz / (int E z^2 dz)^2`` with the first moment F(z) of
    E above z, z from the neutral plane; the mean of both (J. M. Whitney, J. Compos. Mater. 6 (1972) 426-440).
    `across` are the shear moduli (G_1z, G_2z) of each ply in its own axes, inf for rigid ones.
    """
    compliance = []
    for axis in range(2):
        low, layers = 0.0, []
        for (q, thickness, angle), moduli in zip(plies, across, strict=True):
            modulus = turned_plane(q, angle)[axis, axis]
            c2 = np.cos(angle) ** 2
            g1, g2 = moduli if axis == 0 else moduli[::-1]
            layers.append((modulus, low, low + thickness, c2 / g1 + (1.0 - c2) / g2))
            low += thickness
        weight = sum(e * (b - a) for e, a, b, _ in layers)
        if not weight > 0.0:
            return float(np.inf)
        neutral = sum(e * (b**2 - a**2) / 2.0 for e, a, b, _ in layers) / weight
        inertia = sum(e * ((b - neutral) ** 3 - (a - neutral) ** 3) / 3.0 for e, a, b, _ in layers)
        moment, energy = 0.0, 0.0
        points, weights = np.polynomial.legendre.leggauss(3)  # exact: F^2 is of degree 4
        for e, a, b, soft in layers:
            z = 0.5 * (a + b) + 0.5 * (b - a) * points - neutral
            first = moment - e * (z**2 - (a - neutral) ** 2) / 2.0
            energy += soft * 0.5 * (b - a) * float(weights @ first**2)
            moment -= e * ((b - neutral) ** 2 - (a - neutral) ** 2) / 2.0
        compliance.append(energy / inertia**2)
    mean = 0.5 * sum(compliance)
    return float(1.0 / mean) if mean > 0.0 else float(np.inf)


def turned_plane(elasticity: np.ndarray, angle) -> np.ndarray:
    """Return plane stress matrices (..., 3, 3) in axes from which the material axes are turned by `angle` (...), rad.

    ``T^-1 Q T^-T`` of Jones 1999, eq. (2.84), for engineering shear.
    """
    c, s = np.cos(angle), np.sin(angle)
    # strain in material axes from strain in the given axes: e' = R e
    rows = np.array([[c * c, s * s, c * s], [s * s, c * c, -c * s], [-2 * c * s, 2 * c * s, c * c - s * s]])
    turn = np.moveaxis(rows, (0, 1), (-2, -1))
    return turn.swapaxes(-1, -2) @ elasticity @ turn
