"""`ContactState`: force, area, pressure, penetration and slip of a contact between surfaces."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from typing import Any, ClassVar

import numpy as np

from flexmb.errors import ModelError
from flexmb.model.kinds import Sensor

__all__ = ["ContactState"]


@dataclass(frozen=True, eq=False)
class ContactState(Sensor):
    """What happens in a compliant `SurfaceContact` or `SkinContact`, over all its points: (nt, 6).

    Sum of the normal forces, N; area in contact, m2, and the largest pressure, Pa (with `ElasticFoundation`; of points
    they are not known, nan); deepest penetration, m; largest slip, m/s; power of friction, W. Zero without contact, and
    in phases whose model has lost the force.

    Parameters
    ----------
    name : str
    force : str
        Name of the contact.
    """

    _: KW_ONLY
    force: str

    titles: ClassVar[tuple[str, ...]] = (
        "force [N]",
        "area [m2]",
        "pressure [Pa]",
        "penetration [m]",
        "slip [m/s]",
        "friction [W]",
    )
    absent: ClassVar[float] = 0.0

    def check(self, model) -> None:
        """Raise ModelError if the force is no compliant contact of surfaces."""
        force = model.force(self.force, self.title)
        law: Any = getattr(force, "law", None)
        if not hasattr(force, "spots") or getattr(law, "code", 9) > 1:
            raise ModelError(
                self.title,
                found=f"force = '{self.force}', a {type(force).__name__}"
                + (f" by {type(law).__name__}" if law else ""),
                expected="a SurfaceContact by ElasticFoundation or Hertz, or a SkinContact",
                remedy="Use ForceOf for other forces",
            )

    def markers_read(self, model) -> tuple[str, ...]:
        """Return the markers of the surfaces."""
        return tuple(dict.fromkeys(model.force(self.force).touching_markers(model)))

    def values(self, series) -> np.ndarray:
        """Return force, area, pressure, penetration, slip and power of friction (nt, 6)."""
        force = series.model.force(self.force)
        law, sampled = force.law.numbers(), force.law.sampled
        out = np.zeros((len(series.t), 6))
        for row, spots in zip(out, force.spots(series), strict=True):
            if not len(spots.point):
                continue
            forces = spots.area * spots.pressure
            row[0] = forces.sum()
            row[1] = spots.area.sum() if sampled else np.nan
            row[2] = spots.pressure.max() if sampled else np.nan
            row[3], row[4] = spots.depth.max(), spots.slip.max()
            row[5] = np.sum(law["friction"] * forces * spots.slip**2 / np.hypot(spots.slip, law["transition"]))
        return out
