"""`ModalCoordinate` and `StrainGauge`: what a reduced body tells by its flexible coordinates, also in the loop."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from typing import Any, ClassVar

import numpy as np

from flexmb.constraints import Combination, Measured
from flexmb.errors import ModelError
from flexmb.model.described import finite_array
from flexmb.model.kinds import Sensor

__all__ = ["ModalCoordinate", "StrainGauge", "combined", "reduced_data"]


def reduced_data(model, body: str, title: str):
    """Return the data with the modes in use of a reduced body that deforms; ModelError for others."""
    found = model.body(body, title)
    data = getattr(found, "reduced", None)
    if data is None or not data.n_modes:
        raise ModelError(
            title,
            found=f"body '{body}' ({type(found).__name__}), which has no flexible coordinates",
            expected="a FloatingBody with modes",
            remedy="Name a reduced body; cables and beams have SectionStrains",
        )
    return data


def combined(body: str, weights: np.ndarray, constant: float = 0.0) -> Measured:
    """Return the scalar weights (m,) . eta + constant of a reduced body."""
    combination = Combination(body, tuple(float(w) for w in weights), constant)
    return Measured("place", combination=combination)


@dataclass(frozen=True, eq=False)
class ModalCoordinate(Sensor):
    """A flexible coordinate of a reduced body, (nt,), m: the share of one of its modes.

    Parameters
    ----------
    name : str
    body : str
    mode : int
        Of the modes in use, counted from 0.
    """

    _: KW_ONLY
    body: str
    mode: int = 0

    titles: ClassVar[tuple[str, ...]] = ("eta [m]",)

    def check(self, model) -> None:
        """Raise ModelError if the body has no such mode."""
        n = reduced_data(model, self.body, self.title).n_modes
        if isinstance(self.mode, bool) or not isinstance(self.mode, int) or not 0 <= self.mode < n:
            raise ModelError(
                self.title,
                found=f"mode = {self.mode!r}",
                expected=f"a whole number from 0 to {n - 1}",
                remedy=f"Body '{self.body}' uses {n} modes; count them from 0",
            )

    def measured(self, model) -> tuple[Measured, ...]:
        """Return the coordinate."""
        self.check(model)
        n = reduced_data(model, self.body, self.title).n_modes
        return (combined(self.body, np.eye(n)[self.mode]),)

    def values(self, series) -> np.ndarray:
        """Return the coordinate (nt,), m."""
        return series.modal_coordinates(self.body)[:, self.mode]


@dataclass(frozen=True, eq=False)
class StrainGauge(Sensor):
    """Strain between two markers of a reduced body, (nt,): elongation of the line between them over its length.

    The ends of the line may lie off the markers, by the same offset, and turn with them: on the upper side of a frame
    whose nodes are in its axis, the mean of the bending strain there. Small deformation, as of all reduced bodies.

    Parameters
    ----------
    name : str
    markers : (str, str)
        "body.marker", interfaces or stations of one body.
    offset : (3,), m
        From both markers to the ends of the gauge, in body axes.
    """

    _: KW_ONLY
    markers: tuple[str, str]
    offset: Any = (0.0, 0.0, 0.0)

    titles: ClassVar[tuple[str, ...]] = ("strain [-]",)

    def __post_init__(self):
        super().__post_init__()
        markers, offset = self.markers, finite_array(self.offset)
        named = isinstance(markers, tuple | list) and all(isinstance(m, str) and "." in m for m in markers)
        if not named or len(markers) != 2 or len({m.partition(".")[0] for m in markers}) != 1 or offset.shape != (3,):
            raise ModelError(
                self.title,
                found=f"markers = {self.markers!r}, offset = {self.offset!r}",
                expected="two markers of one body, and three numbers, m",
                remedy='Write markers=("beam.left", "beam.right"), offset=(0, 0, 0.02)',
            )
        object.__setattr__(self, "markers", tuple(markers))
        object.__setattr__(self, "offset", tuple(offset.tolist()))

    def check(self, model) -> None:
        """Raise ModelError if a marker does not exist, or both are at one place."""
        self._combination(model)

    def _combination(self, model) -> tuple[str, np.ndarray]:
        """Return the body, and the weights (m,), 1/m, of its flexible coordinates."""
        body = self.markers[0].partition(".")[0]
        data = reduced_data(model, body, self.title)
        ends = []
        for marker in self.markers:
            _, pose = model.marker(marker, self.title)
            k = data.marker_names.index(marker.partition(".")[2])
            turned = np.cross(data.marker_rotations[k], np.array(self.offset), axis=0)
            ends.append((np.array(pose.at), data.marker_translations[k] + turned))
        line = ends[1][0] - ends[0][0]
        length = float(np.linalg.norm(line))
        if not length > 0.0:
            raise ModelError(
                self.title,
                found=f"'{self.markers[0]}' and '{self.markers[1]}' at one place",
                expected="two places",
                remedy="Add stations to the reduction, one at each end of the gauge",
            )
        return body, line @ (ends[1][1] - ends[0][1]) / length**2

    def measured(self, model) -> tuple[Measured, ...]:
        """Return the strain."""
        return (combined(*self._combination(model)),)

    def values(self, series) -> np.ndarray:
        """Return the strain (nt,)."""
        body, weights = self._combination(series.model)
        return series.modal_coordinates(body) @ weights
