"""`StressResultants`: membrane forces, moments and shear forces of a plate at a place."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from typing import Any, ClassVar

import numpy as np

from flexmb.errors import ModelError
from flexmb.model.described import is_number
from flexmb.model.kinds import Sensor

__all__ = ["StressResultants"]


@dataclass(frozen=True, eq=False)
class StressResultants(Sensor):
    """Membrane forces, moments and shear forces per length of an `AncfPlate`, (nt, 8), without damping forces.

    In the axes of the element, 1 along s and 2 across; moments are positive where they stretch the side of the normal.
    Between the middles of the elements they are bilinear. Thin plates have no law for Q1, Q2: zero.

    Parameters
    ----------
    name : str
    body : str
    at : (2,), -
        Fractions s and t of the plate, 0 to 1.
    """

    _: KW_ONLY
    body: str
    at: Any = (0.5, 0.5)

    titles: ClassVar[tuple[str, ...]] = (
        "N11 [N/m]",
        "N22 [N/m]",
        "N12 [N/m]",
        "M11 [N]",
        "M22 [N]",
        "M12 [N]",
        "Q1 [N/m]",
        "Q2 [N/m]",
    )

    def __post_init__(self):
        super().__post_init__()
        at = self.at
        if not isinstance(at, tuple | list) or len(at) != 2 or not all(is_number(z) and 0.0 <= z <= 1.0 for z in at):
            raise ModelError(
                self.title,
                found=f"at = {at!r}",
                expected="two fractions (s, t), 0 to 1",
                remedy="Write at=(0.5, 0.5) for the middle",
            )
        object.__setattr__(self, "at", tuple(at))

    def check(self, model) -> None:
        """Raise ModelError if the body is not a plate."""
        body = model.body(self.body, self.title)
        if body.drawn != "sheet":
            raise ModelError(
                self.title,
                found=f"body '{self.body}' is a {type(body).__name__}",
                expected="an AncfPlate",
                remedy="Cables and beams have SectionForces, reduced bodies Stress",
            )

    def values(self, series) -> np.ndarray:
        """Return the resultants (nt, 8)."""
        body = series.model.body(self.body)
        return np.array([body.resultants(q, [self.at])[0] for q in series.coordinates(self.body)[0]])
