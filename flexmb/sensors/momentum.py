"""`Momentum`: linear and angular momentum of the whole system."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from flexmb.model.kinds import Sensor

__all__ = ["Momentum"]


@dataclass(frozen=True, eq=False)
class Momentum(Sensor):
    """Linear momentum and angular momentum about the origin of W, (nt, 6), kg m/s and kg m2/s, in W.

    A body with the momenta ``P = m v + ...``, ``h`` (about its origin), in body axes, adds ``R P`` and
    ``r x R P + R h``; for a floating body they are the first six rows of its mass matrix times its velocity.

    Parameters
    ----------
    name : str
    """

    titles: ClassVar[tuple[str, ...]] = (
        "px [kg m/s]",
        "py [kg m/s]",
        "pz [kg m/s]",
        "Lx [kg m2/s]",
        "Ly [kg m2/s]",
        "Lz [kg m2/s]",
    )

    def values(self, series) -> np.ndarray:
        """Return the momenta (nt, 6)."""
        total = np.zeros((len(series.t), 6))
        for body in series.model.bodies:
            if body.n_velocities:
                total += body.momentum(*series.coordinates(body.name))
        return total
