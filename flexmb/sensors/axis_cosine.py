"""`AxisCosine`: how far two axes point the same way."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from typing import ClassVar

import numpy as np

from flexmb.constraints import Measured
from flexmb.errors import ModelError
from flexmb.model.described import entries_of
from flexmb.model.kinds import Sensor

__all__ = ["AxisCosine"]


@dataclass(frozen=True, eq=False)
class AxisCosine(Sensor):
    """Cosine of the angle between an axis of marker a and an axis of marker b, (nt,); zero if they are perpendicular.

    Nine of them are the rotation matrix of b in the axes of a; they are smooth where angles are not.

    Parameters
    ----------
    name : str
    markers : (str, str)
        a and b, "body.marker".
    axes : (str, str)
        "x", "y" or "z" of a, and of b.
    """

    _: KW_ONLY
    markers: tuple[str, str]
    axes: tuple[str, str]

    titles: ClassVar[tuple[str, ...]] = ("cosine",)

    def __post_init__(self):
        super().__post_init__()
        for field, known, example in (("markers", None, "('ground.A', 'crank.A')"), ("axes", "xyz", "('z', 'x')")):
            value = entries_of(getattr(self, field))
            if len(value) != 2 or not all(isinstance(v, str) and (not known or v in ("x", "y", "z")) for v in value):
                raise ModelError(
                    self.title,
                    found=f"{field} = {getattr(self, field)!r}",
                    expected="two names 'body.marker'" if known is None else "two of 'x', 'y', 'z'",
                    remedy=f"Write {field}={example}",
                )
            object.__setattr__(self, field, value)

    def markers_read(self, model) -> tuple[str, ...]:
        """Return the two markers."""
        return self.markers

    def measured(self, model) -> tuple[Measured, ...]:
        """Return the cosine."""
        axis, other = ("xyz".index(axis) for axis in self.axes)
        return (Measured("cosine", self.markers, axis, other),)

    def values(self, series) -> np.ndarray:
        """Return the cosine (nt,)."""
        a, b = (series.marker(name).R[:, :, "xyz".index(axis)] for name, axis in zip(self.markers, self.axes))
        return np.einsum("ti,ti->t", a, b)
