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
from flexmb.fem.shells.shear import edge_softness, shear_rows, stiffness_of

__all__ = ["LaminateBlock", "laminate", "turned_plane"]


ISOTROPIC = 1e-9
"""Share of the largest elasticity by which turned axes may change it."""
FLAT = 1e-9
"""Share of the thickness by which offsets may differ."""


@dataclass(frozen=True, kw_only=True, eq=False)
class LaminateBlock(ShellBlock):
    """Shell elements whose section is given by its stiffness matrices; an `ElementBlock`.

    Parameters
    ----------
    membrane, coupling, bending : (ne, 3, 3), N/m, N, N m
        A, B, D in the local axes of each element, about the reference plane.
    shear : (ne, 2, 2), m/N
        Transverse shear compliance ``g = S q`` of forces per width, in local axes; zero for thin shells.
    surface_mass : (ne,), kg/m2
    faces : (ne, 2, 3, 3), Pa
        Plane stress elasticity of the bottom and the top layer in local axes.
    depths : (ne, 2), m
        Height of the bottom and of the top over the reference plane.
    poisson : float
        Of the triangle's in-plane bending modes (shells.md); any value keeps the patch test.
    spring : (ne,) or None
        Share of the in-plane shear stiffness that holds the rotation about the normal, where the membrane has none of
        its own; None: the membrane turns with its corners.
    point_masses : bool
        Lumped masses have no rotary inertia, as in Nastran.
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
    spring: np.ndarray | None = None  # type: ignore[misc]
    point_masses: bool = False  # type: ignore[misc]
    ROWS: ClassVar[tuple[str, ...]] = (
        *ShellBlock.ROWS,
        *("membrane", "coupling", "bending", "shear", "surface_mass", "faces", "depths", "spring"),
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
        if not self.shear.any():
            return 0.0
        rows = shear_rows(self.corners, at, self.softness)
        return at.weight[:, None, None] * (rows.swapaxes(1, 2) @ self.shear_stiffness @ rows)

    @cached_property
    def shear_stiffness(self) -> np.ndarray:
        """Transverse shear stiffness (ne, 2, 2), N/m, in local axes; zero where nothing shears."""
        return stiffness_of(self.shear)

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


def turned_plane(elasticity: np.ndarray, angle) -> np.ndarray:
    """Return plane stress matrices (..., 3, 3) in axes from which the material axes are turned by `angle` (...), rad.

    ``T^-1 Q T^-T`` of Jones 1999, eq. (2.84), for engineering shear.
    """
    c, s = np.cos(angle), np.sin(angle)
    # strain in material axes from strain in the given axes: e' = R e
    rows = np.array([[c * c, s * s, c * s], [s * s, c * c, -c * s], [-2 * c * s, 2 * c * s, c * c - s * s]])
    turn = np.moveaxis(rows, (0, 1), (-2, -1))
    return turn.swapaxes(-1, -2) @ elasticity @ turn
