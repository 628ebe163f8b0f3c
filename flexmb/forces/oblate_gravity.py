"""`OblateGravity`: what the flattening of a central body adds to its attraction, J2.

phi = mu J2 R^2 / 2 (3 z^2 - r^2) / r^5, z along the axis of the central body (Vallado 2013, section 8.6); what the
field does to the size of the body, see `elastic_attraction`.
"""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from typing import ClassVar

import numpy as np

from flexmb.errors import ModelError
from flexmb.forces.elastic_attraction import BodyAttraction, act_elastic, attract_elastic, attracted_row
from flexmb.math.harmonic_field import HIGHEST, falling_oblate, oblate_field
from flexmb.math.kepler import ELEMENTS, follow_orbit
from flexmb.math.kernel import inner_kernel
from flexmb.math.rotations import euler_to_matrix
from flexmb.math.tables import row_kernel
from flexmb.math.vectors import cross, matvec, matvec_t
from flexmb.model.orbit import EARTH, RADIUS, elements_of
from flexmb.model.table import Table

__all__ = ["OblateGravity"]

J2 = 1.0826267e-3
ROW = np.dtype(
    [
        ("marker", np.int64),  # centre of mass; of a reduced body any marker
        ("source", np.int64),
        ("pair", np.int64),
        ("strength", float),  # mu J2 R^2 / 2, m5/s2
        ("orbit", ELEMENTS),
        ("modes", np.int64),  # -1: a rigid body or point
        ("iq", np.int64),  # first coordinate of a reduced body
        ("moments", np.int64),  # its moments in the bulk data
    ],
    align=True,
)


@inner_kernel
def _on_rigid(row, data, P, uniform, falls, state, work):
    """Attract a rigid body or point at its centre of mass; P and `uniform` are in its axes, wrenches in those of W."""
    marker, wanted = work.markers[row.marker], work.weights[0].wanted
    R, Q, K = marker.R, np.empty(6), np.empty((6, 6))
    field, unit, turned = np.empty(6), np.empty(3), np.empty(3)
    V = attract_elastic(data[row.moments :], 0, state.q[:0], P, uniform, wanted, Q, K)
    matvec(R, Q[:3], field[:3])
    matvec(R, Q[3:], field[3:])
    for i in range(6):
        marker.wrench[i] += field[i]
    if falls:
        for i in range(3):
            work.energy[0].load_power += field[i] * marker.v[i] + field[3 + i] * marker.w[i]
    else:
        work.energy[0].potential += V
    if wanted == 0:
        return
    slope = work.pairs[row.pair].K
    for a in range(0, 6, 3):
        for b in range(0, 6, 3):
            for i in range(3):
                for j in range(3):
                    for m in range(3):
                        for n in range(3):
                            slope[6 + a + i, 6 + b + j] -= R[i, m] * K[a + m, b + n] * R[j, n]
        for j in range(3):  # the wrench turns with the body
            unit[:] = 0.0
            unit[j] = 1.0
            cross(unit, field[a : a + 3], turned)
            for i in range(3):
                slope[6 + a + i, 9 + j] -= turned[i]


@row_kernel
def apply(raw, data, state, work):
    """The field over the body, relative to what an origin gets that falls in it."""
    rows = raw.view(ROW)
    rho, d, place, fall, k = np.empty(3), np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    x, axis, uniform, R = np.empty(3), np.empty(3), np.empty(3), np.empty((3, 3))
    none, P = np.zeros(3), np.empty((HIGHEST + 1, HIGHEST + 1, HIGHEST + 1))
    for n in range(rows.shape[0]):
        row = rows[n]
        marker, source = work.markers[row.marker], work.markers[row.source]
        follow_orbit(state.t, row.orbit, data, rho, fall)
        if row.modes >= 0:
            euler_to_matrix(state.q[row.iq + 3 : row.iq + 7], R)
        else:
            R[:] = marker.R
        for i in range(3):
            d[i] = (state.q[row.iq + i] if row.modes >= 0 else marker.r[i]) - source.r[i]
            place[i] = rho[i] + d[i]
            k[i] = source.R[i, 2]
        if row.orbit.strength > 0.0:
            falling_oblate(rho, d, k, row.strength, fall)
        else:
            falling_oblate(none, place, k, row.strength, fall)
        matvec_t(R, place, x)
        matvec_t(R, k, axis)
        matvec_t(R, fall, uniform)
        oblate_field(x, axis, row.strength, P)
        if row.modes >= 0:
            act_elastic(row, data, P, uniform, row.orbit.follows == 1, state, work)
        else:
            _on_rigid(row, data, P, uniform, row.orbit.follows == 1, state, work)


@dataclass(frozen=True, eq=False)
class OblateGravity(BodyAttraction):
    """Add the attraction of a central body's flattening (J2).

    A body of some size feels the gradient of the field too, its torque and its force to second order, as by
    `CentralGravity`. With `Model(origin=Orbit(..., j2=...))` it gets the difference that the fall of the origin leaves.

    Parameters
    ----------
    name : str
    body : str
        A `RigidBody`, a `PointMass`, or a `FloatingBody` whose inertia loads do not stiffen it (free fall is no load).
    mu : float, N m2/kg
        By default the Earth's.
    radius : float, m
        Equatorial radius, by default the Earth's.
    j2 : float, -
        By default the Earth's.
    source : str
        "ground.marker" of the centre; its z-axis is the axis of the central body. With `Model(origin=Orbit(...))` it
        stands at the origin of W, and only its axes count.
    """

    name: str
    _: KW_ONLY
    body: str
    mu: float = EARTH
    radius: float = RADIUS
    j2: float = J2
    source: str = "ground.origin"

    flattens: ClassVar[bool] = True
    largest: ClassVar[float] = 1e60  # m, as all places of a model
    table: ClassVar[Table] = Table("OblateGravity", ROW, {"apply": apply})

    def __post_init__(self):
        super().__post_init__()
        self.require_positive("mu", "radius", "j2")
        if self.radius > self.largest:
            raise ModelError(
                self.title,
                found=f"radius = {self.radius!r} m",
                expected=f"at most {self.largest:.0e} m, as all places of a model",
                remedy="Give the radius of the equator in m",
            )

    def record(self, compiler):
        """Return the row."""
        source = compiler.marker(self.source)
        what = attracted_row(compiler, self.body, source)
        own = {name: what[name] for name in ("marker", "pair", "modes", "iq", "moments")}
        strength = 0.5 * self.mu * self.j2 * self.radius**2
        return {"source": source, "strength": strength, "orbit": elements_of(compiler), **own}
