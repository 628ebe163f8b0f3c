"""`ThirdBody`: the attraction of a further body (the Sun, the Moon) in axes that fall with the central one.

F = m mu ((s - r) / |s - r|^3 - s / |s|^3), s its place from the origin of W (Vallado 2013, section 8.6), and what the
field does to the size of the body, see `attract`.
"""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from typing import Any, ClassVar

import numpy as np

from flexmb.forces.attraction import attract, inertia_of
from flexmb.forces.rows import require_center_of_mass, store_three_signals
from flexmb.math.kepler import ELEMENTS, follow_orbit
from flexmb.math.tables import STIFF, row_kernel
from flexmb.model.kinds import Force
from flexmb.model.orbit import elements_of
from flexmb.model.table import Table

__all__ = ["ThirdBody"]

ROW = np.dtype(
    [
        ("marker", np.int64),
        ("pair", np.int64),
        ("mu", float),  # m3/s2
        ("mass", float),  # kg
        ("inertia", float, (3, 3)),  # kg m2, about the centre of mass, in body axes
        ("at", np.int64, 3),  # signals, m
        ("orbit", ELEMENTS),
    ],
    align=True,
)


@row_kernel
def apply(raw, data, state, work):
    """The attraction less what the origin gets; its power is that of a load, the potential moves."""
    rows = raw.view(ROW)
    d, away, field, K = np.empty(3), np.empty(3), np.empty(6), np.empty((6, 6))
    origin, speed = np.empty(3), np.empty(3)
    wanted = work.weights[0].wanted
    for n in range(rows.shape[0]):
        row = rows[n]
        marker = work.markers[row.marker]
        follow_orbit(state.t, row.orbit, origin, speed)
        for i in range(3):
            away[i] = -state.signals[row.at[i], 0]
            d[i] = origin[i] + marker.r[i]
        attract(away, d, marker.R, row.mu, row.mass, row.inertia, wanted, field, K)
        for i in range(3):
            marker.wrench[i] += field[i]
            marker.wrench[3 + i] += field[3 + i]
            work.energy[0].load_power += field[i] * marker.v[i] + field[3 + i] * marker.w[i]
        if wanted != 0:
            for i in range(6):
                for j in range(6):
                    work.pairs[row.pair].K[i, j] += K[i, j]


@dataclass(frozen=True, eq=False)
class ThirdBody(Force):
    """Attract a rigid body or point mass to a body that moves as given, less what it gives the origin of W.

    A rigid body feels the gradient of the field too, its torque and its force to second order, as by `CentralGravity`.

    Parameters
    ----------
    name : str
    body : str
        A `RigidBody` or `PointMass`.
    mu : float, N m2/kg
        Gravitational constant times the mass of the third body.
    at : three signals, m
        Its place, in the axes of W. Without an orbit the origin of W is the centre of the central body, which falls
        freely; with `Model(origin=Orbit(...))` it is the place from that centre all the same.
    """

    name: str
    _: KW_ONLY
    body: str
    mu: float
    at: Any

    lasting: ClassVar[bool] = True
    table: ClassVar[Table] = Table("ThirdBody", ROW, {"apply": apply})

    def __post_init__(self):
        super().__post_init__()
        self.require_positive("mu")
        store_three_signals(self, "at")

    def check(self, model) -> None:
        """Raise ModelError unless the body has a centre of mass, and a centre of attraction is on the ground."""
        require_center_of_mass(self, model)

    def in_world_axes(self, model) -> str:
        """Return the name of the field that is given in the axes of W."""
        return "at"

    def measure(self, model) -> str:
        """Return the centre of mass."""
        return f"{self.body}.center"

    def record(self, compiler):
        """Return the row."""
        body = compiler.model.body(self.body)
        marker = compiler.marker(f"{self.body}.center")
        at = tuple(compiler.signal(signal) for signal in self.at)
        pair = compiler.pair(marker, marker, STIFF)
        return {
            "marker": marker,
            "pair": pair,
            "mass": float(body.mass),
            "inertia": inertia_of(body),
            "at": at,
            "orbit": elements_of(compiler.model),
        }
