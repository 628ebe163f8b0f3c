"""Orthotropic linear elastic material with an orientation."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flexmb.errors import ModelError
from flexmb.math.definiteness import definite
from flexmb.model.described import Described, finite_array, is_number
from flexmb.model.pose import rotation3

__all__ = ["OrthotropicMaterial"]

PAIRS = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0))
"""Tensor indices of the stress components xx, yy, zz, xy, yz, zx."""


@dataclass(frozen=True, kw_only=True, eq=False)
class OrthotropicMaterial(metaclass=Described):
    """Three planes of symmetry: wood, rolled sheet, a unidirectional ply.

    The compliance (Jones, Mechanics of Composite Materials, eq. (2.25)): strain_1 = stress_1 / E_1
    - nu_12 stress_2 / E_1 - nu_13 stress_3 / E_1 and so on, with nu_21 / E_2 = nu_12 / E_1 by symmetry.

    Parameters
    ----------
    young : (3,), Pa
        E_1, E_2, E_3 along the material axes.
    poisson : (3,), -
        nu_12, nu_23, nu_13: nu_ij is the contraction along j per extension along i under stress along i.
    shear : (3,), Pa
        G_12, G_23, G_13.
    density : float, kg/m3
    rotation : rotation vector (3,), matrix (3, 3) or scipy Rotation
        Turns the material axes from the body axes; the columns of the matrix are the material axes in body axes.
    name : str
        Used in messages and reports.

    Examples
    --------
    >>> ply = OrthotropicMaterial(young=(135e9, 10e9, 10e9), poisson=(0.3, 0.45, 0.3),
    ...                           shear=(5e9, 3.4e9, 5e9), density=1600.0, rotation=(0, 0, np.pi / 2))
    >>> bool(ply.elasticity[1, 1] > ply.elasticity[0, 0])  # the fibres point along y
    True
    """

    young: tuple[float, float, float]
    poisson: tuple[float, float, float]
    shear: tuple[float, float, float]
    density: float
    rotation: object = (0.0, 0.0, 0.0)
    name: str = "orthotropic material"

    def __post_init__(self):
        part = f"Material '{self.name}'"
        for field, unit in (("young", "Pa"), ("shear", "Pa")):
            values = finite_array(getattr(self, field))
            if values.shape != (3,) or not np.all(values > 0.0):
                raise ModelError(
                    part,
                    found=f"{field} = {getattr(self, field)!r} {unit}",
                    expected="three positive numbers",
                    remedy="Give the values of the axes in SI units",
                )
        if not is_number(self.density) or not self.density > 0.0:
            raise ModelError(
                part, found=f"density = {self.density!r} kg/m3", expected="a positive number", remedy="Use SI units"
            )
        if finite_array(self.poisson).shape != (3,) or not definite(self.compliance[:3, :3]):
            raise ModelError(
                part,
                found=f"poisson = {self.poisson!r} makes the strain energy negative",
                expected="nu_ij^2 < E_i / E_j and a positive definite compliance",
                remedy="Check the order nu_12, nu_23, nu_13 and which index carries the load",
            )

    @property
    def compliance(self) -> np.ndarray:
        """Compliance in material axes, (6, 6), 1/Pa, for stress 11, 22, 33, 12, 23, 31 and engineering shear."""
        (e1, e2, e3), (nu12, nu23, nu13) = self.young, self.poisson
        s = np.diag([1 / e1, 1 / e2, 1 / e3, *(1 / np.asarray(self.shear, float))])
        s[0, 1] = s[1, 0] = -nu12 / e1
        s[1, 2] = s[2, 1] = -nu23 / e2
        s[0, 2] = s[2, 0] = -nu13 / e1
        return s

    @property
    def elasticity(self) -> np.ndarray:
        """Elasticity in body axes, (6, 6), Pa: stress xx, yy, zz, xy, yz, zx from strain with engineering shear."""
        from scipy.spatial.transform import Rotation

        if isinstance(self.rotation, Rotation):
            turn = self.rotation.as_matrix()
        else:
            turn = rotation3(self.rotation, f"Material '{self.name}'", "rotation")
        c = np.linalg.inv(self.compliance)
        # stress' = T stress: row (i, j), column (k, l) of the turn of a symmetric tensor, shear counted twice.
        t = np.array(
            [
                [turn[i, k] * turn[j, m] + (turn[i, m] * turn[j, k] if k != m else 0.0) for k, m in PAIRS]
                for i, j in PAIRS
            ]
        )
        return t @ c @ t.T
