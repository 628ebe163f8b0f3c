"""`CentralGravity`: the attraction of a distant centre on a body, with the torque of its gradient.

The field is taken to second order over the body, see `attract`, and `elastic_attraction` for reduced bodies.
"""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from typing import ClassVar

import numpy as np

from flexmb.forces.attraction import attract, falling
from flexmb.forces.elastic_attraction import BodyAttraction, act_elastic, attracted_row
from flexmb.math.harmonic_field import HIGHEST, point_field
from flexmb.math.kepler import ELEMENTS, follow_orbit
from flexmb.math.kernel import inner_kernel
from flexmb.math.rotations import euler_to_matrix
from flexmb.math.tables import row_kernel
from flexmb.math.vectors import matvec_t
from flexmb.model.orbit import EARTH, elements_of
from flexmb.model.table import Table

__all__ = ["CentralGravity"]

ROW = np.dtype(
    [
        ("marker", np.int64),  # centre of mass; of a reduced body any marker
        ("source", np.int64),
        ("pair", np.int64),
        ("mu", float),  # m3/s2
        ("mass", float),  # kg
        ("inertia", float, (3, 3)),  # kg m2, about the centre of mass, in body axes
        ("orbit", ELEMENTS),
        ("modes", np.int64),  # -1: a rigid body or point
        ("iq", np.int64),  # first coordinate of a reduced body
        ("moments", np.int64),  # its moments in the bulk data
    ],
    align=True,
)


@inner_kernel
def _on_elastic(row, data, rho, away, state, work):
    """Attract a reduced body; `away` is the centre's marker from W."""
    q = state.q[row.iq : row.iq + 7]
    R, d, place, uniform = np.empty((3, 3)), np.empty(3), np.empty(3), np.empty(3)
    x, P = np.empty(3), np.empty((HIGHEST + 1, HIGHEST + 1, HIGHEST + 1))
    euler_to_matrix(q[3:7], R)
    for i in range(3):
        d[i] = q[i] - away[i]
        place[i] = rho[i] + d[i]
    falling(rho, d, row.mu, x)
    matvec_t(R, x, uniform)
    matvec_t(R, place, x)
    point_field(x, row.mu, P)
    act_elastic(row, data, P, uniform, row.orbit.follows == 1, state, work)


@row_kernel
def apply(raw, data, state, work):
    """Force and torque of `attract` at the centre of mass, and their derivatives by place and turn."""
    rows = raw.view(ROW)
    rho, speed, d, field, K = np.empty(3), np.empty(3), np.empty(3), np.empty(6), np.empty((6, 6))
    wanted = work.weights[0].wanted
    for n in range(rows.shape[0]):
        row = rows[n]
        marker, source = work.markers[row.marker], work.markers[row.source]
        follow_orbit(state.t, row.orbit, data, rho, speed)
        if row.modes >= 0:
            _on_elastic(row, data, rho, source.r, state, work)
            continue
        for i in range(3):
            d[i] = marker.r[i] - source.r[i]
        V = attract(rho, d, marker.R, row.mu, row.mass, row.inertia, wanted, field, K)
        for i in range(6):
            marker.wrench[i] += field[i]
        if row.orbit.follows == 0:
            work.energy[0].potential += V
        else:  # the potential moves: its power counts as a load's
            for i in range(3):
                work.energy[0].load_power += field[i] * marker.v[i] + field[3 + i] * marker.w[i]
        if wanted != 0:
            for i in range(6):
                for j in range(6):
                    work.pairs[row.pair].K[6 + i, 6 + j] += K[i, j]


@dataclass(frozen=True, eq=False)
class CentralGravity(BodyAttraction):
    """Attract a body to a centre, with the torque of the gradient and its force to second order.

    With `Model(origin=Orbit(...))` the orbit gives the centre, and the body gets the difference that the fall of
    the origin leaves.

    Parameters
    ----------
    name : str
    body : str
        A `RigidBody`, a `PointMass`, or a `FloatingBody` whose inertia loads do not stiffen it (free fall is no load).
    mu : float, N m2/kg
        Gravitational constant times the mass of the centre; by default the Earth's.
    source : str
        "ground.marker" of the centre.
    """

    name: str
    _: KW_ONLY
    body: str
    mu: float = EARTH
    source: str = "ground.origin"

    attracts: ClassVar[bool] = True
    lasting: ClassVar[bool] = True
    table: ClassVar[Table] = Table("CentralGravity", ROW, {"apply": apply})

    def __post_init__(self):
        super().__post_init__()
        self.require_positive("mu")

    def record(self, compiler):
        """Return the row."""
        source = compiler.marker(self.source)
        row = {"source": source, "orbit": elements_of(compiler)}
        return row | attracted_row(compiler, self.body, source)
