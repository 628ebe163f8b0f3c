"""`OrbitalPosition`, `OrbitalVelocity`: the motion of a marker as seen from the centre that an orbit goes around."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from flexmb.sensors.marker_motion import MarkerSensor

__all__ = ["OrbitalPosition", "OrbitalVelocity"]


@dataclass(frozen=True, eq=False)
class OrbitalPosition(MarkerSensor):
    """Position of a marker from the centre of the orbit that the origin of W follows, (nt, 3), m, along the axes of W.

    `Position` is that from the origin of W: near it, it has more digits. Without an orbit both are the same.

    Parameters
    ----------
    name : str
    marker : str
        "body.marker".
    """

    titles: ClassVar[tuple[str, ...]] = ("x [m]", "y [m]", "z [m]")

    def values(self, series) -> np.ndarray:
        """Return r (nt, 3), m."""
        origin, r = series.model.origin, series.marker(self.marker).r
        return r if origin is None else r + origin.at(series.t)[0]


@dataclass(frozen=True, eq=False)
class OrbitalVelocity(MarkerSensor):
    """Velocity of a marker against the centre of the orbit that the origin of W follows, (nt, 3), m/s, along W.

    Without an orbit it equals `Velocity`.

    Parameters
    ----------
    name : str
    marker : str
        "body.marker".
    """

    titles: ClassVar[tuple[str, ...]] = ("vx [m/s]", "vy [m/s]", "vz [m/s]")

    def values(self, series) -> np.ndarray:
        """Return v (nt, 3), m/s."""
        origin, v = series.model.origin, series.marker(self.marker).v
        return v if origin is None else v + origin.at(series.t)[1]
