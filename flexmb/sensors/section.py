"""`SectionForces`, `SectionStrains`: what a cable or beam carries at a place along its length."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from typing import ClassVar

import numpy as np

from flexmb.errors import ModelError
from flexmb.model.described import is_number
from flexmb.model.kinds import Sensor

__all__ = ["SectionForces", "SectionStrains"]


@dataclass(frozen=True, eq=False)
class _AtSection(Sensor):
    """A quantity of the section at a fraction of the length."""

    _: KW_ONLY
    body: str
    at: float = 0.0

    quantity: ClassVar[str]
    """ "forces" or "strains" of the body's sections."""

    def __post_init__(self):
        super().__post_init__()
        if not is_number(self.at) or not 0.0 <= self.at <= 1.0:
            raise ModelError(
                self.title,
                found=f"at = {self.at!r}",
                expected="a fraction of the length, 0 to 1",
                remedy="Write at=0.5 for the middle",
            )

    def columns(self, model) -> tuple[str, ...]:
        """Return the titles with units."""
        return getattr(model.body(self.body), f"{self.quantity.removesuffix('s')}_titles")

    def values(self, series) -> np.ndarray:
        """Return the quantity (nt, number of titles)."""
        quantity = getattr(series.model.body(self.body), f"section_{self.quantity}")
        return np.array([quantity(q, self.at)[0] for q in series.coordinates(self.body)[0]])

    def check(self, model) -> None:
        """Raise ModelError if the body is not a line."""
        body = model.body(self.body, self.title)
        if body.drawn != "line":
            raise ModelError(
                self.title,
                found=f"body '{self.body}' is a {type(body).__name__}",
                expected="an AncfCable or AncfBeam",
                remedy="Reduced frames have flexmb.results.recover.section_forces",
            )


@dataclass(frozen=True, eq=False)
class SectionForces(_AtSection):
    """Section forces of a cable or beam at a fraction of its length, without damping forces.

    Beams: N, Qy, Qz (N), Mx, My, Mz (N m), (nt, 6), in the axes of the section, exerted by the part with the larger
    fraction on the other one. Cables: axial force N, shear force Q (N) and bending moment M (N m), (nt, 3).

    Parameters
    ----------
    name : str
    body : str
    at : float, -
        Fraction of the length, 0 to 1.
    """

    quantity: ClassVar[str] = "forces"


@dataclass(frozen=True, eq=False)
class SectionStrains(_AtSection):
    """Strains of a cable or beam at a fraction of its length, relative to the stress-free line.

    Beams: axial strain, shears y and z (-), twist, curvatures y and z (1/m), (nt, 6). Cables: axial strain (-) and
    curvature (1/m), (nt, 2).

    Parameters
    ----------
    name : str
    body : str
    at : float, -
        Fraction of the length, 0 to 1.
    """

    quantity: ClassVar[str] = "strains"
