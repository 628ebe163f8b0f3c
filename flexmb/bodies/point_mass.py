"""`PointMass`: three translations, no orientation."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from typing import Any, ClassVar

import numpy as np

from flexmb.bodies.rows import HEADER
from flexmb.math.tables import row_kernel
from flexmb.model.kinds import Body
from flexmb.model.pose import Pose, vector3
from flexmb.model.table import Table

__all__ = ["PointMass"]

ROW = np.dtype([*HEADER, ("mass", float), ("gravity", float, 3)], align=True)


@row_kernel
def place(raw, data, state, work):
    """The only marker moves with the point and keeps the axes of W."""
    rows = raw.view(ROW)
    for n in range(rows.shape[0]):
        row = rows[n]
        marker = work.markers[row.marker]
        for i in range(3):
            marker.r[i] = state.q[row.iq + i]
            marker.v[i] = state.u[row.iu + i]
            for j in range(3):
                marker.R[i, j] = 1.0 if i == j else 0.0
                work.J[marker.iJ + 3 * i + j] = 1.0 if i == j else 0.0


@row_kernel
def inertia(raw, data, state, work):
    """m (a - g) minus the applied force."""
    rows = raw.view(ROW)
    for n in range(rows.shape[0]):
        row = rows[n]
        marker = work.markers[row.marker]
        for i in range(3):
            work.residual[row.iu + i] += row.mass * (state.a[row.iu + i] - row.gravity[i]) - marker.wrench[i]
            if work.weights[0].wanted == 1:
                work.S[work.rows[row.iu + i] + i] += work.weights[0].mass * row.mass


@row_kernel
def energy(raw, data, state, work):
    """T = 1/2 m v.v, V = -m g.r."""
    rows = raw.view(ROW)
    for n in range(rows.shape[0]):
        row = rows[n]
        for i in range(3):
            work.energy[0].kinetic += 0.5 * row.mass * state.u[row.iu + i] ** 2
            work.energy[0].potential -= row.mass * row.gravity[i] * state.q[row.iq + i]


@dataclass(frozen=True, eq=False)
class PointMass(Body):
    """A particle; its marker ``center`` keeps the axes of W.

    Parameters
    ----------
    name : str
    mass : float, kg
        Zero for a point that joints hold in all directions.
    at : (3,), m, in W
    velocity : (3,), m/s, in W
    """

    name: str
    _: KW_ONLY
    mass: float
    at: Any = (0.0, 0.0, 0.0)
    velocity: Any = (0.0, 0.0, 0.0)

    table: ClassVar[Table] = Table("PointMass", ROW, {"place": place, "inertia": inertia, "energy": energy})
    has_frame: ClassVar[bool] = False

    def __post_init__(self):
        super().__post_init__()
        self.require_positive("mass", zero=True)
        object.__setattr__(self, "at", vector3(self.at, self.title, "at"))
        object.__setattr__(self, "velocity", vector3(self.velocity, self.title, "velocity"))

    @property
    def n_vector(self) -> int:
        """Three coordinates."""
        return 3

    def marker_poses(self) -> dict[str, Pose]:
        """Return the one marker, ``center``."""
        return {"center": Pose()}

    def initial_state(self):
        """Return position and velocity, in W."""
        return np.array(self.at), np.array(self.velocity)

    def rest_inertia(self):
        """Return its mass, kg, and no moments about itself."""
        return self.mass, np.zeros(3), np.zeros((3, 3))

    def momentum(self, q: np.ndarray, u: np.ndarray) -> np.ndarray:
        """Return linear and angular momentum about the origin of W, (nt, 6)."""
        return np.hstack([self.mass * u, np.cross(q, self.mass * u)])

    def record(self, compiler, place):
        """Return the row but for the mass."""
        return {"gravity": compiler.gravity}
