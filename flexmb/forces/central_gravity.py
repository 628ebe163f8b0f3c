"""`CentralGravity`: the attraction of a distant centre on a body, with the torque of its gradient.

The field is taken to second order over the body, see `attract`.
"""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from typing import ClassVar

import numpy as np

from flexmb.forces.attraction import attract, inertia_of
from flexmb.forces.rows import require_center_of_mass
from flexmb.math.tables import STIFF, row_kernel
from flexmb.model.kinds import Force
from flexmb.model.table import Table

__all__ = ["CentralGravity"]

EARTH = 3.986004418e14
ROW = np.dtype(
    [
        ("marker", np.int64),
        ("source", np.int64),
        ("pair", np.int64),
        ("mu", float),  # m3/s2
        ("mass", float),  # kg
        ("inertia", float, (3, 3)),  # kg m2, about the centre of mass, in body axes
    ],
    align=True,
)


@row_kernel
def apply(raw, data, state, work):
    """Force and torque of `attract` at the centre of mass, and their derivatives by place and turn."""
    rows = raw.view(ROW)
    r, field, K = np.empty(3), np.empty(6), np.empty((6, 6))
    wanted = work.weights[0].wanted
    for n in range(rows.shape[0]):
        row = rows[n]
        marker = work.markers[row.marker]
        for i in range(3):
            r[i] = marker.r[i] - work.markers[row.source].r[i]
        work.energy[0].potential += attract(r, marker.R, row.mu, row.mass, row.inertia, wanted, field, K)
        for i in range(6):
            marker.wrench[i] += field[i]
        if wanted != 0:
            for i in range(6):
                for j in range(6):
                    work.pairs[row.pair].K[6 + i, 6 + j] += K[i, j]


@dataclass(frozen=True, eq=False)
class CentralGravity(Force):
    """Attract a rigid body or a point mass to a centre, with the torque of the gradient and its force to second order.

    Parameters
    ----------
    name : str
    body : str
        A `RigidBody` or `PointMass`.
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

    table: ClassVar[Table] = Table("CentralGravity", ROW, {"apply": apply})

    def __post_init__(self):
        super().__post_init__()
        self.require_positive("mu")

    def check(self, model) -> None:
        """Raise ModelError unless the body has a centre of mass, and a centre of attraction is on the ground."""
        require_center_of_mass(self, model)

    def measure(self, model) -> str:
        """Return the centre of mass."""
        return f"{self.body}.center"

    def record(self, compiler):
        """Return the row."""
        body = compiler.model.body(self.body)
        marker, source = compiler.marker(f"{self.body}.center"), compiler.marker(self.source)
        return {
            "marker": marker,
            "source": source,
            "pair": compiler.pair(source, marker, STIFF),
            "mass": float(body.mass),
            "inertia": inertia_of(body),
        }
