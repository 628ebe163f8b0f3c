"""`Reaction` and `ForceOf`: force and moment that a joint or a force exerts on the body of its second marker."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from typing import ClassVar

import numpy as np

from flexmb.model.kinds import Sensor

__all__ = ["ForceOf", "Reaction"]

WRENCH = ("fx [N]", "fy [N]", "fz [N]", "mx [N m]", "my [N m]", "mz [N m]")


@dataclass(frozen=True, eq=False)
class Reaction(Sensor):
    """Force and moment that a joint exerts on the body of its second marker, at that marker, in W, (nt, 6), N and N m.

    Zero in phases whose model has lost the joint.

    Parameters
    ----------
    name : str
    joint : str
        Name of the joint (or drive).
    """

    _: KW_ONLY
    joint: str

    titles: ClassVar[tuple[str, ...]] = WRENCH
    absent: ClassVar[float] = 0.0

    def check(self, model) -> None:
        """Raise ModelError if the joint does not exist."""
        model.joint(self.joint, self.title)

    def values(self, series) -> np.ndarray:
        """Return the wrench (nt, 6), N and N m, in W."""
        return series.reaction(self.joint)


@dataclass(frozen=True, eq=False)
class ForceOf(Sensor):
    """Force and moment that a force exerts on the body of its second (or only) marker, there, in W, (nt, 6), N, N m.

    Zero in phases whose model has lost the force.

    Parameters
    ----------
    name : str
    force : str
        Name of the force.
    """

    _: KW_ONLY
    force: str

    titles: ClassVar[tuple[str, ...]] = WRENCH
    absent: ClassVar[float] = 0.0

    def check(self, model) -> None:
        """Raise ModelError if the force does not exist."""
        model.force(self.force, self.title)

    def values(self, series) -> np.ndarray:
        """Return the wrench (nt, 6), N and N m, in W."""
        return series.force(self.force)
