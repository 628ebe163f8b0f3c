"""`CentralGravity`: the attraction of a distant centre on a body, with the torque of its gradient.

The field is taken to second order over the body, see `attract`, and `attract_elastic` for reduced bodies.
"""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from typing import ClassVar

import numpy as np

from flexmb.errors import ModelError
from flexmb.forces.attraction import attract, falling, inertia_of
from flexmb.forces.elastic_attraction import attract_elastic, moments_of
from flexmb.forces.rows import require_center_of_mass
from flexmb.math.kepler import ELEMENTS, follow_orbit
from flexmb.math.kernel import inner_kernel
from flexmb.math.rotations import euler_to_matrix
from flexmb.math.tables import STIFF, row_kernel
from flexmb.math.vectors import matvec_t
from flexmb.model.kinds import Force
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
    """Subtract the generalised forces from the residual of a reduced body; `away` is the centre's marker from W."""
    m, iu, weights = row.modes, work.markers[row.marker].iu, work.weights[0]
    q = state.q[row.iq : row.iq + 7 + m]
    R, d, place, uniform, x = np.empty((3, 3)), np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    Q, K = np.empty(6 + m), np.zeros((6 + m, 6 + m))
    euler_to_matrix(q[3:7], R)
    for i in range(3):
        d[i] = q[i] - away[i]
        place[i] = rho[i] + d[i]
    falling(rho, d, row.mu, x)
    matvec_t(R, x, uniform)
    matvec_t(R, place, x)
    wanted = 1 if weights.wanted == 1 and weights.stiffness != 0.0 else 0
    V = attract_elastic(data[row.moments :], m, q[7:], x, uniform, row.mu, wanted, Q, K)
    for i in range(6 + m):
        work.residual[iu + i] -= Q[i]
        if row.orbit.follows == 1:  # the potential moves: its power is that of a load
            work.energy[0].load_power += Q[i] * state.u[iu + i]
        if wanted == 1:
            start = work.rows[iu + i]
            for j in range(6 + m):
                work.S[start + j] -= weights.stiffness * K[i, j]
    if row.orbit.follows == 0:
        work.energy[0].potential += V


@row_kernel
def apply(raw, data, state, work):
    """Force and torque of `attract` at the centre of mass, and their derivatives by place and turn."""
    rows = raw.view(ROW)
    rho, speed, d, field, K = np.empty(3), np.empty(3), np.empty(3), np.empty(6), np.empty((6, 6))
    wanted = work.weights[0].wanted
    for n in range(rows.shape[0]):
        row = rows[n]
        marker, source = work.markers[row.marker], work.markers[row.source]
        follow_orbit(state.t, row.orbit, rho, speed)
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
        else:  # the potential moves: its power is that of a load
            for i in range(3):
                work.energy[0].load_power += field[i] * marker.v[i] + field[3 + i] * marker.w[i]
        if wanted != 0:
            for i in range(6):
                for j in range(6):
                    work.pairs[row.pair].K[6 + i, 6 + j] += K[i, j]


@dataclass(frozen=True, eq=False)
class CentralGravity(Force):
    """Attract a body to a centre, with the torque of the gradient and its force to second order.

    With `Model(origin=Orbit(...))` the centre is that of the orbit, and the body gets the difference that the fall of
    the origin leaves.

    Parameters
    ----------
    name : str
    body : str
        A `RigidBody`, a `PointMass`, or a `FloatingBody` whose inertia loads do not stiffen it (free fall is no load).
    mu : float, N m2/kg
        Gravitational constant times the mass of the centre; by default that of the Earth.
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

    def check(self, model) -> None:
        """Raise ModelError unless the body has a centre of mass, and a centre of attraction is on the ground."""
        require_center_of_mass(self, model, elastic=True)
        body = model.body(self.body)
        if body.reduced is not None and "inertia" in body.stiffening_groups and body.reduced.geometric is not None:
            raise ModelError(
                self.title,
                found=f"'{self.body}', whose inertia loads stiffen it",
                expected="a body without stiffening by inertia loads: that of free fall loads nothing, and the "
                "acceleration of the frame would count as a load",
                remedy=f"Give '{self.body}' geometric_stiffness=('interface', 'loads', 'preload'), or False",
            )

    def measure(self, model) -> str | None:
        """Return the centre of mass; the field over a reduced body has no place."""
        return None if model.body(self.body).reduced is not None else f"{self.body}.center"

    def record(self, compiler):
        """Return the row."""
        body = compiler.model.body(self.body)
        source, reduced = compiler.marker(self.source), body.reduced
        row = {"source": source, "orbit": elements_of(compiler.model), "modes": -1, "iq": 0, "moments": 0}
        if reduced is not None:
            row["marker"] = compiler.marker(f"{self.body}.{next(iter(body.marker_poses()))}")
            row |= {"pair": 0, "mass": float(reduced.mass), "inertia": np.zeros((3, 3)), "modes": reduced.n_modes}
            return row | {"iq": compiler.coordinate(self.body), "moments": compiler.bulk(moments_of(reduced))}
        marker = compiler.marker(f"{self.body}.center")
        row |= {"marker": marker, "mass": float(body.mass), "inertia": inertia_of(body)}
        return row | {"pair": compiler.pair(source, marker, STIFF)}
