"""`OblateGravity`: what the flattening of a central body adds to its attraction, J2.

V = mu J2 R^2 m / 2 (3 z^2 - r^2) / r^5, F = -dV/dr, z along the axis of the central body (Vallado 2013, section 8.6).
"""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from typing import ClassVar

import numpy as np

from flexmb.forces.rows import require_center_of_mass
from flexmb.math.kepler import ELEMENTS, follow_orbit
from flexmb.math.tables import STIFF, row_kernel
from flexmb.math.vectors import dot, norm
from flexmb.model.kinds import Force
from flexmb.model.orbit import EARTH, elements_of
from flexmb.model.table import Table

__all__ = ["OblateGravity"]

RADIUS, J2 = 6378137.0, 1.0826267e-3
ROW = np.dtype(
    [
        ("marker", np.int64),
        ("source", np.int64),
        ("pair", np.int64),
        ("strength", float),  # mu J2 R^2 m / 2, N m4
        ("orbit", ELEMENTS),
    ],
    align=True,
)


@row_kernel
def apply(raw, data, state, work):
    """F = -c grad f, f = 3 z^2 / r^5 - 1 / r^3, and the second derivatives of f."""
    rows = raw.view(ROW)
    r, k, speed = np.empty(3), np.empty(3), np.empty(3)
    for n in range(rows.shape[0]):
        row = rows[n]
        marker, source = work.markers[row.marker], work.markers[row.source]
        follow_orbit(state.t, row.orbit, r, speed)
        for i in range(3):
            r[i] += marker.r[i] - source.r[i]
            k[i] = source.R[i, 2]
        far, z, c = norm(r), dot(k, r), row.strength
        for i in range(3):
            slope = 6.0 * z * k[i] / far**5 - 15.0 * z * z * r[i] / far**7 + 3.0 * r[i] / far**5
            marker.wrench[i] -= c * slope
            if row.orbit.follows == 1:  # the potential moves: its power is that of a load
                work.energy[0].load_power -= c * slope * marker.v[i]
        if row.orbit.follows == 0:
            work.energy[0].potential += c * (3.0 * z * z / far**5 - 1.0 / far**3)
        if work.weights[0].wanted == 0:
            continue
        K = work.pairs[row.pair].K
        for i in range(3):
            for j in range(3):
                one = 1.0 if i == j else 0.0
                x = 6.0 * k[i] * k[j] / far**5 - 30.0 * z * (k[i] * r[j] + r[i] * k[j]) / far**7
                x += -15.0 * z * z * (one / far**7 - 7.0 * r[i] * r[j] / far**9)
                x += 3.0 * (one / far**5 - 5.0 * r[i] * r[j] / far**7)
                K[6 + i, 6 + j] += c * x


@dataclass(frozen=True, eq=False)
class OblateGravity(Force):
    """Add the attraction of a central body's flattening (J2) to a rigid body or point mass, at its centre of mass.

    Parameters
    ----------
    name : str
    body : str
        A `RigidBody` or `PointMass`.
    mu : float, N m2/kg
        By default that of the Earth.
    radius : float, m
        Equatorial radius, by default that of the Earth.
    j2 : float, -
        By default that of the Earth.
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

    table: ClassVar[Table] = Table("OblateGravity", ROW, {"apply": apply})

    def __post_init__(self):
        super().__post_init__()
        self.require_positive("mu", "radius", "j2")

    def check(self, model) -> None:
        """Raise ModelError unless the body has a centre of mass, and a centre of attraction is on the ground."""
        require_center_of_mass(self, model)

    def measure(self, model) -> str:
        """Return the centre of mass."""
        return f"{self.body}.center"

    def record(self, compiler):
        """Return the row."""
        mass = float(compiler.model.body(self.body).mass)
        marker, source = compiler.marker(f"{self.body}.center"), compiler.marker(self.source)
        strength = 0.5 * self.mu * self.j2 * self.radius**2 * mass
        pair = compiler.pair(source, marker, STIFF)
        orbit = elements_of(compiler.model)
        return {"marker": marker, "source": source, "pair": pair, "strength": strength, "orbit": orbit}
