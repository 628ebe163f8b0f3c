"""`ThirdBody`: the attraction of a further body (the Sun, the Moon) in axes that fall with the central one.

F = m mu ((s - r) / |s - r|^3 - s / |s|^3), s its place from the origin of W (Vallado 2013, section 8.6), and what the
field does to the size of the body, see `attract`.
"""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from typing import Any, ClassVar

import numpy as np

from flexmb.forces.attraction import attract, falling
from flexmb.forces.elastic_attraction import BodyAttraction, act_elastic, attracted_row
from flexmb.forces.rows import store_three_signals
from flexmb.math.harmonic_field import HIGHEST, point_field
from flexmb.math.kepler import ELEMENTS, follow_orbit
from flexmb.math.kernel import inner_kernel
from flexmb.math.rotations import euler_to_matrix
from flexmb.math.tables import row_kernel
from flexmb.math.vectors import matvec_t
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
        ("modes", np.int64),  # -1: a rigid body or point
        ("iq", np.int64),  # first coordinate of a reduced body
        ("moments", np.int64),  # its moments in the bulk data
    ],
    align=True,
)


@inner_kernel
def _on_elastic(row, data, away, origin, state, work):
    """Attract a reduced body; `away` leads from the third body to the centre, `origin` from there to W."""
    q = state.q[row.iq : row.iq + 7]
    R, d, uniform = np.empty((3, 3)), np.empty(3), np.empty(3)
    x, P = np.empty(3), np.empty((HIGHEST + 1, HIGHEST + 1, HIGHEST + 1))
    euler_to_matrix(q[3:7], R)
    for i in range(3):
        d[i] = origin[i] + q[i]
    falling(away, d, row.mu, x)
    matvec_t(R, x, uniform)
    for i in range(3):
        d[i] += away[i]
    matvec_t(R, d, x)
    point_field(x, row.mu, P)
    act_elastic(row, data, P, uniform, True, state, work)


@row_kernel
def apply(raw, data, state, work):
    """The attraction less what the origin gets; its power counts as a load's, as the potential moves."""
    rows = raw.view(ROW)
    d, away, field, K = np.empty(3), np.empty(3), np.empty(6), np.empty((6, 6))
    origin, speed = np.empty(3), np.empty(3)
    wanted = work.weights[0].wanted
    for n in range(rows.shape[0]):
        row = rows[n]
        marker = work.markers[row.marker]
        follow_orbit(state.t, row.orbit, data, origin, speed)
        for i in range(3):
            away[i] = -state.signals[row.at[i], 0]
        if row.modes >= 0:
            _on_elastic(row, data, away, origin, state, work)
            continue
        for i in range(3):
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
class ThirdBody(BodyAttraction):
    """Attract a body to another one that moves as given, less what that gives the central body.

    A body of some size feels the gradient of the field too, its torque and its force to second order, as by
    `CentralGravity`; the gradient stretches and bends a reduced body.

    Parameters
    ----------
    name : str
    body : str
        A `RigidBody`, a `PointMass`, or a `FloatingBody` whose inertia loads do not stiffen it (free fall is no load).
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

    def in_world_axes(self, model) -> str:
        """Return the name of the field that is given in the axes of W."""
        return "at"

    def record(self, compiler):
        """Return the row."""
        at = tuple(compiler.signal(signal) for signal in self.at)
        return {"at": at, "orbit": elements_of(compiler)} | attracted_row(compiler, self.body)
