"""`Distance`: how far two markers are apart."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from typing import ClassVar

import numpy as np

from flexmb.constraints import Coordinate, Measured
from flexmb.errors import ModelError
from flexmb.model.described import entries_of
from flexmb.model.kinds import Sensor

__all__ = ["Distance"]


@dataclass(frozen=True, eq=False)
class Distance(Sensor):
    """Distance of two markers, ``|r_b - r_a|``, or its component along an axis of the first one, with sign; (nt,), m.

    Parameters
    ----------
    name : str
    markers : (str, str)
        a and b, "body.marker".
    along : "x", "y", "z" or None
        Axis of marker a; None: the length of the line between them.
    """

    _: KW_ONLY
    markers: tuple[str, str]
    along: str | None = None

    titles: ClassVar[tuple[str, ...]] = ("distance [m]",)

    def __post_init__(self):
        super().__post_init__()
        if len(entries_of(self.markers)) != 2 or not all(isinstance(m, str) for m in self.markers):
            raise ModelError(
                self.title,
                found=f"markers = {self.markers!r}",
                expected="two names 'body.marker'",
                remedy="Write markers=('ground.A', 'crank.A')",
            )
        if self.along not in ("x", "y", "z", None):
            raise ModelError(
                self.title,
                found=f"along = {self.along!r}",
                expected="'x', 'y', 'z' or nothing",
                remedy="Name an axis of the first marker, or leave it out for the length of the line",
            )
        object.__setattr__(self, "markers", tuple(self.markers))

    def markers_read(self, model) -> tuple[str, ...]:
        """Return the two markers."""
        return self.markers

    def measured(self, model) -> tuple[Measured, ...]:
        """Return the distance or the component."""
        coordinate = Coordinate("distance") if self.along is None else Coordinate("slide", self.along)
        return (Measured("coordinate", self.markers, coordinate=coordinate),)

    def values(self, series) -> np.ndarray:
        """Return the distance (nt,), m."""
        a, b = (series.marker(name) for name in self.markers)
        if self.along is None:
            return np.linalg.norm(b.r - a.r, axis=1)
        return np.einsum("ti,ti->t", a.R[:, :, "xyz".index(self.along)], b.r - a.r)
