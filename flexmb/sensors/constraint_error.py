"""`ConstraintError`: how well the constraint equations are met."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from flexmb.model.kinds import Sensor

__all__ = ["ConstraintError"]


@dataclass(frozen=True, eq=False)
class ConstraintError(Sensor):
    """Largest residual ``max |g|`` of all constraint equations, (nt,), m or rad.

    Parameters
    ----------
    name : str
    """

    titles: ClassVar[tuple[str, ...]] = ("largest |g|",)

    def values(self, series) -> np.ndarray:
        """Return the largest residual (nt,)."""
        return series.constraint_error
