"""`Rod`: a massless rigid rod between two markers."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from typing import ClassVar

import numpy as np

from flexmb.constraints import Distance
from flexmb.model.kinds import Joint

__all__ = ["Rod"]


@dataclass(frozen=True, eq=False)
class Rod(Joint):
    """Keep the distance between two markers, as a massless rod with ball ends does.

    Parameters
    ----------
    name : str
    markers : (str, str)
        Marker a and marker b; the reaction on b points along the rod, positive multiplier = compression.
    length : float, m, optional
        Distance kept; by default the distance in the undeformed model as described.
    """

    _: KW_ONLY
    length: float | None = None

    drawn: ClassVar[str] = "link"

    def __post_init__(self):
        super().__post_init__()
        if self.length is not None:
            self.require_positive("length")

    def resolved(self, positions) -> Rod:
        """Return the rod with its length taken from the marker positions (2, 3), m, in W, if it has none."""
        if self.length is not None:
            return self
        return self.replaced(length=float(np.linalg.norm(positions[1] - positions[0])))

    def equations(self):
        """Return the one distance equation."""
        return (Distance(self.length),)
