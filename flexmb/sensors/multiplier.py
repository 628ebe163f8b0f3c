"""`Multiplier`: the Lagrange multipliers of a joint or constraint."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from typing import ClassVar

import numpy as np

from flexmb.constraints import Measured
from flexmb.model.kinds import Sensor

__all__ = ["Multiplier"]


@dataclass(frozen=True, eq=False)
class Multiplier(Sensor):
    """Multipliers of the equations of a joint, (nt,) for one equation, else (nt, n).

    The force of an equation on what it reads is its gradient times the multiplier: N for one whose residual is a
    length, N m for an angle, N/m for a squared length. Zero in phases whose model has lost the joint.

    Parameters
    ----------
    name : str
    joint : str
        Name of the joint, drive or constraint.
    """

    _: KW_ONLY
    joint: str

    absent: ClassVar[float] = 0.0
    reads_reactions: ClassVar[bool] = True

    def check(self, model) -> None:
        """Raise ModelError if the joint does not exist."""
        model.joint(self.joint, self.title)

    def columns(self, model) -> tuple[str, ...]:
        """Return one title for each equation."""
        joint = model.joint(self.joint, self.title)
        counts = sum(equation.count for equation in joint.equations_in(model))
        return ("multiplier",) if counts == 1 else tuple(f"multiplier {k + 1}" for k in range(counts))

    def measured(self, model) -> tuple[Measured, ...]:
        """Return the multipliers, for what samples them."""
        return tuple(Measured("multiplier", axis=k, part=self.joint) for k in range(len(self.columns(model))))

    def values(self, series) -> np.ndarray:
        """Return the multipliers."""
        found = series.multipliers(self.joint)
        return found[:, 0] if found.shape[1] == 1 else found
