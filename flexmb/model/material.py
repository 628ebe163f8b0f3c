"""Isotropic linear elastic material."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flexmb.errors import ModelError
from flexmb.model.described import Described, is_number

__all__ = ["MATERIALS", "Material"]


@dataclass(frozen=True, kw_only=True)
class Material(metaclass=Described):
    """Isotropic, linear elastic, homogeneous.

    Parameters
    ----------
    young : float, Pa
        Young's modulus E > 0.
    poisson : float, -
        Poisson's ratio, -1 < nu < 0.5.
    density : float, kg/m3
        Mass density rho > 0.
    name : str
        Used in messages and reports.

    Examples
    --------
    >>> steel = Material(young=210e9, poisson=0.3, density=7850.0)
    >>> round(steel.shear / 1e9, 3)
    80.769
    """

    young: float
    poisson: float
    density: float
    name: str = "material"

    def __post_init__(self):
        part = f"Material '{self.name}'"
        for field, unit in (("young", "Pa"), ("density", "kg/m3")):
            value = getattr(self, field)
            if not is_number(value) or value <= 0.0:
                raise ModelError(
                    part,
                    found=f"{field} = {value!r} {unit}",
                    expected="a positive number",
                    remedy="Use SI units: steel has young=210e9 Pa, density=7850 kg/m3",
                )
        if not is_number(self.poisson) or not -1.0 < self.poisson < 0.5:
            raise ModelError(
                part,
                found=f"poisson = {self.poisson!r}",
                expected="-1 < poisson < 0.5",
                remedy="For a nearly incompressible material use 0.49 at most",
            )

    @property
    def shear(self) -> float:
        """Shear modulus G = E / (2 (1 + nu)), Pa."""
        return self.young / (2.0 * (1.0 + self.poisson))

    @property
    def elasticity(self) -> np.ndarray:
        """Elasticity (6, 6), Pa: stress xx, yy, zz, xy, yz, zx from strain with engineering shear."""
        c = np.diag([2.0 * self.shear] * 3 + [self.shear] * 3)
        c[:3, :3] += self.young * self.poisson / ((1.0 + self.poisson) * (1.0 - 2.0 * self.poisson))
        return c


MATERIALS = {
    material.name: material
    for material in (
        Material(young=210e9, poisson=0.3, density=7850.0, name="steel"),
        Material(young=71.7e9, poisson=0.33, density=2800.0, name="aluminium"),
        Material(young=114e9, poisson=0.31, density=4430.0, name="titanium"),
    )
}
"""Ready-made materials by name (for the command line)."""
