"""`Position`, `Velocity`, `AngularVelocity`, `Acceleration`, `Orientation`: the motion of a marker, in W."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from typing import ClassVar

import numpy as np

from flexmb.constraints import Measured
from flexmb.math.rotations import matrix_to_euler
from flexmb.model.kinds import Sensor

__all__ = ["Acceleration", "AngularVelocity", "Orientation", "Position", "Velocity"]


@dataclass(frozen=True, eq=False)
class MarkerSensor(Sensor):
    """Anything that one marker tells."""

    _: KW_ONLY
    marker: str

    def markers_read(self, model) -> tuple[str, ...]:
        """Return the marker."""
        return (self.marker,)


@dataclass(frozen=True, eq=False)
class Position(MarkerSensor):
    """Position of a marker in W, (nt, 3), m.

    Parameters
    ----------
    name : str
    marker : str
        "body.marker".
    """

    titles: ClassVar[tuple[str, ...]] = ("x [m]", "y [m]", "z [m]")

    def measured(self, model) -> tuple[Measured, ...]:
        """Return the three components."""
        return tuple(Measured("place", (self.marker,), axis) for axis in range(3))

    def values(self, series) -> np.ndarray:
        """Return r (nt, 3), m, in W."""
        return series.marker(self.marker).r


@dataclass(frozen=True, eq=False)
class _Rate(MarkerSensor):
    """A velocity of a marker, its components in W or along the axes of a marker."""

    axes: str | None = None

    def markers_read(self, model) -> tuple[str, ...]:
        """Return the marker, and the marker of the axes."""
        return (self.marker,) if self.axes is None else (self.marker, self.axes)

    def _measured(self, what: str) -> tuple[Measured, ...]:
        markers = (self.marker,) if self.axes is None else (self.axes, self.marker)
        return tuple(Measured(what, markers, axis) for axis in range(3))

    def _turned(self, series, vector: np.ndarray) -> np.ndarray:
        """Return vectors (nt, 3) of W in the axes asked for."""
        return vector if self.axes is None else np.einsum("tji,tj->ti", series.marker(self.axes).R, vector)


@dataclass(frozen=True, eq=False)
class Velocity(_Rate):
    """Velocity of a marker against W, (nt, 3), m/s.

    Parameters
    ----------
    name : str
    marker : str
        "body.marker".
    axes : str, optional
        "body.marker" whose axes the components refer to, by default W: in its own axes, a blade has no
        velocity across.
    """

    titles: ClassVar[tuple[str, ...]] = ("vx [m/s]", "vy [m/s]", "vz [m/s]")

    def measured(self, model) -> tuple[Measured, ...]:
        """Return the three components."""
        return self._measured("velocity")

    def values(self, series) -> np.ndarray:
        """Return v (nt, 3), m/s."""
        return self._turned(series, series.marker(self.marker).v)


@dataclass(frozen=True, eq=False)
class AngularVelocity(_Rate):
    """Angular velocity of a marker against W, (nt, 3), rad/s: of a shaft, of the section of a beam.

    Parameters
    ----------
    name : str
    marker : str
        "body.marker".
    axes : str, optional
        "body.marker" whose axes the components refer to, by default W.
    """

    titles: ClassVar[tuple[str, ...]] = ("wx [rad/s]", "wy [rad/s]", "wz [rad/s]")

    def measured(self, model) -> tuple[Measured, ...]:
        """Return the three components."""
        return self._measured("spin")

    def values(self, series) -> np.ndarray:
        """Return w (nt, 3), rad/s."""
        return self._turned(series, series.marker(self.marker).w)


@dataclass(frozen=True, eq=False)
class Acceleration(MarkerSensor):
    """Acceleration of a marker in W, (nt, 3), m/s2; gravity is not subtracted.

    Parameters
    ----------
    name : str
    marker : str
        "body.marker".
    """

    titles: ClassVar[tuple[str, ...]] = ("ax [m/s2]", "ay [m/s2]", "az [m/s2]")

    def measured(self, model) -> tuple[Measured, ...]:
        """Return the three components: a force that follows them has its share in the masses."""
        return tuple(Measured("acceleration", (self.marker,), axis) for axis in range(3))

    def values(self, series) -> np.ndarray:
        """Return a (nt, 3), m/s2, in W."""
        return series.marker(self.marker).a


@dataclass(frozen=True, eq=False)
class Orientation(MarkerSensor):
    """Orientation of a marker: Euler parameters, scalar first, (nt, 4), which map the marker's axes to W.

    p and -p are the same orientation; the sign is chosen so that the values are continuous from sample to sample, with
    a scalar part >= 0 at the start.

    Parameters
    ----------
    name : str
    marker : str
        "body.marker".
    """

    titles: ClassVar[tuple[str, ...]] = ("p0", "p1", "p2", "p3")

    def values(self, series) -> np.ndarray:
        """Return p (nt, 4)."""
        R = series.marker(self.marker).R
        p = np.empty((len(R), 4))
        for k in range(len(R)):
            matrix_to_euler(np.ascontiguousarray(R[k]), p[k])
        return _continuous(p)

    def joined(self, pieces) -> np.ndarray:
        """Return the values of consecutive phases, continuous in sign."""
        return _continuous(np.concatenate(pieces))


def _continuous(p):
    """Flip signs so that neighbours point the same way."""
    flips = np.einsum("ti,ti->t", p[1:], p[:-1]) < 0.0
    signs = np.concatenate([[1.0], np.where(np.cumsum(flips) % 2, -1.0, 1.0)])
    return p * signs[: len(p), None]
