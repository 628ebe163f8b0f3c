"""`ContactState`: force, area, pressure, penetration and slip of a contact between surfaces."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from typing import ClassVar

import numpy as np

from flexmb.errors import ModelError
from flexmb.model.kinds import Sensor
from flexmb.surfaces.detection import find_areas, find_closest
from flexmb.surfaces.records import CONTACT

__all__ = ["ContactState"]


@dataclass(frozen=True, eq=False)
class ContactState(Sensor):
    """What happens in a compliant `SurfaceContact`, over all its pairs: (nt, 6).

    Sum of the normal forces, N; area in contact, m2, and the largest pressure, Pa (with `ElasticFoundation`; of points
    they are not known, nan); deepest penetration, m; largest slip, m/s; power of friction, W. Zero without contact, and
    in phases whose model has lost the force.

    Parameters
    ----------
    name : str
    force : str
        Name of the `SurfaceContact`.
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
        law = getattr(force, "law", None)
        if not hasattr(force, "pairs") or getattr(law, "code", 9) > 1:
            raise ModelError(
                self.title,
                found=f"force = '{self.force}', a {type(force).__name__}"
                + (f" by {type(law).__name__}" if law else ""),
                expected="a SurfaceContact by ElasticFoundation or Hertz",
                remedy="Use ForceOf for other forces",
            )

    def markers_read(self, model) -> tuple[str, ...]:
        """Return the markers of the surfaces."""
        force = model.force(self.force)
        return tuple(dict.fromkeys(surface.marker for pair in force.pairs(model) for surface in pair))

    def values(self, series) -> np.ndarray:
        """Return force, area, pressure, penetration, slip and power of friction (nt, 6)."""
        force = series.model.force(self.force)
        out = np.zeros((len(series.t), 6))
        for a, b in force.pairs(series.model):
            data = np.concatenate([a.packed, b.packed])
            contacts = np.empty(len(a.points[0]) + len(b.points[0]) + 2, CONTACT)
            find = find_areas if force.law.sampled else find_closest
            first, second = series.marker(a.marker), series.marker(b.marker)
            apart = np.linalg.norm(second.r - first.r, axis=1)
            for k in np.flatnonzero(apart < a.shape.reach + b.shape.reach):
                R = first.R[k]
                between = second.r[k] - first.r[k]
                d, w = R.T @ between, R.T @ (second.w[k] - first.w[k])
                V = R.T @ (second.v[k] - first.v[k] - np.cross(first.w[k], between))
                Q = np.ascontiguousarray(R.T @ second.R[k])
                count = find(data, 0, len(a.packed), 0.0, d, Q, contacts)
                if count:
                    _add(out[k], force.law, contacts[:count], V + np.cross(w, contacts[:count]["x"] - d))
        return out


def _add(row: np.ndarray, law, contacts: np.ndarray, u: np.ndarray) -> None:
    """Add what the contacts of a pair with the relative velocities u (n, 3) tell to a row of the sensor."""
    own = law.numbers()
    depth, area, normal = -contacts["gap"], contacts["area"], contacts["n"]
    along = np.einsum("ij,ij->i", u, normal)
    pressure = own["stiffness"] * depth ** own["exponent"] * np.maximum(1.0 - own["damping"] * along, 0.0)
    slip = np.linalg.norm(u - along[:, None] * normal, axis=1)
    row[0] += np.sum(area * pressure)
    row[1] += np.sum(area) if law.sampled else np.nan
    row[2] = max(row[2], pressure.max()) if law.sampled else np.nan
    row[3] = max(row[3], depth.max())
    row[4] = max(row[4], slip.max())
    row[5] += np.sum(area * own["friction"] * pressure * slip**2 / np.hypot(slip, own["transition"]))
