"""`ConstraintError`: how well the constraint equations are met."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass

import numpy as np

from flexmb.errors import ModelError, did_you_mean
from flexmb.model.kinds import Sensor

__all__ = ["ConstraintError"]

LEVELS = {"position": "largest |g|", "velocity": "largest |g'|", "acceleration": "largest |g''|"}


@dataclass(frozen=True, eq=False)
class ConstraintError(Sensor):
    """Largest residual of all constraint equations, (nt,).

    Parameters
    ----------
    name : str
    level : str
        "position" (``max |g|``, m or rad), "velocity" (``max |G u + dg/dt|``, per s) or "acceleration" (``max |G u' +
        ...|``, per s2).
    """

    _: KW_ONLY
    level: str = "position"

    def __post_init__(self):
        super().__post_init__()
        if self.level not in LEVELS:
            raise ModelError(
                self.title,
                found=f"level = {self.level!r}",
                expected=f"One of: {', '.join(LEVELS)}",
                remedy=did_you_mean(str(self.level), LEVELS) or "Omit it for positions",
            )

    def columns(self, model) -> tuple[str, ...]:
        """Return the title."""
        return (LEVELS[self.level],)

    def values(self, series) -> np.ndarray:
        """Return the largest residual (nt,)."""
        return series.constraint_error[:, list(LEVELS).index(self.level)]
