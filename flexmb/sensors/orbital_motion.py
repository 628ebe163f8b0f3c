"""`OrbitalPosition`, `OrbitalVelocity`: the motion of a marker as seen from the centre that an orbit goes around."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from flexmb.errors import ModelError
from flexmb.sensors.marker_motion import MarkerSensor

__all__ = ["OrbitalPosition", "OrbitalVelocity"]


@dataclass(frozen=True, eq=False)
class _Orbital(MarkerSensor):
    """What a marker tells together with the origin of W."""

    def check(self, model) -> None:
        """Raise ModelError if the marker does not exist, or the origin of W follows no orbit."""
        super().check(model)
        if model.origin is None:
            raise ModelError(
                self.title,
                found="a model whose origin rests",
                expected="Model(origin=flexmb.Orbit(...))",
                remedy=f"Use {type(self).__name__.removeprefix('Orbital')}: W is all there is",
            )


@dataclass(frozen=True, eq=False)
class OrbitalPosition(_Orbital):
    """Position of a marker from the centre of the orbit that the origin of W follows, (nt, 3), m, along the axes of W.

    `Position` is that from the origin of W: near it, it has more digits.

    Parameters
    ----------
    name : str
    marker : str
        "body.marker".
    """

    titles: ClassVar[tuple[str, ...]] = ("x [m]", "y [m]", "z [m]")

    def values(self, series) -> np.ndarray:
        """Return r (nt, 3), m."""
        return series.marker(self.marker).r + series.model.origin.at(series.t)[0]


@dataclass(frozen=True, eq=False)
class OrbitalVelocity(_Orbital):
    """Velocity of a marker against the centre of the orbit that the origin of W follows, (nt, 3), m/s, along W.

    Parameters
    ----------
    name : str
    marker : str
        "body.marker".
    """

    titles: ClassVar[tuple[str, ...]] = ("vx [m/s]", "vy [m/s]", "vz [m/s]")

    def values(self, series) -> np.ndarray:
        """Return v (nt, 3), m/s."""
        return series.marker(self.marker).v + series.model.origin.at(series.t)[1]
