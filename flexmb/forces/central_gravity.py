"""`CentralGravity`: the attraction of a distant centre on a body, with the torque of its gradient.

With r from the centre to the centre of mass, e = r / |r| and J the inertia about it (the field to second order
over the body, as in Hughes 1986, chapter 8):

    F = -mu m e / r^2 - 3 mu / (2 r^4) ((tr J) e + 2 J e - 5 (e . J e) e),    T = 3 mu / r^3 e x J e,
    V = -mu m / r - mu / (2 r^3) (tr J - 3 e . J e),    (sums over principal axes)
"""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from typing import ClassVar

import numpy as np

from flexmb.forces.rows import require_center_of_mass
from flexmb.math.tables import STIFF, row_kernel
from flexmb.math.vectors import cross, dot, norm
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
    """Force and torque of the module's docstring at the centre of mass, and their derivatives by place and turn."""
    rows = raw.view(ROW)
    r, h, t, unit = np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    dr, dh, dF, dT = np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    J = np.empty((3, 3))
    for n in range(rows.shape[0]):
        row = rows[n]
        marker = work.markers[row.marker]
        for i in range(3):
            r[i] = marker.r[i] - work.markers[row.source].r[i]
        trace = 0.0
        for i in range(3):
            trace += row.inertia[i, i]
            for j in range(3):
                J[i, j] = 0.0
                for k in range(3):
                    for m in range(3):
                        J[i, j] += marker.R[i, k] * row.inertia[k, m] * marker.R[j, m]
        far = norm(r)
        for i in range(3):
            h[i] = J[i, 0] * r[0] + J[i, 1] * r[1] + J[i, 2] * r[2]
        s = dot(r, h)
        a, b = row.mu * row.mass / far**3, 1.5 * row.mu / far**5
        cross(r, h, t)
        for i in range(3):
            force = -a * r[i] - b * (trace * r[i] + 2.0 * h[i] - 5.0 * s * r[i] / far**2)
            marker.wrench[i] += force
            marker.wrench[3 + i] += 2.0 * b * t[i]
        work.energy[0].potential += -row.mu * row.mass / far - 0.5 * row.mu / far**3 * (trace - 3.0 * s / far**2)
        if work.weights[0].wanted == 0:
            continue
        K = work.pairs[row.pair].K
        for j in range(6):
            unit[:] = 0.0
            unit[j % 3] = 1.0
            dr[:] = 0.0
            dh[:] = 0.0
            if j < 3:
                dr[:] = unit
                for i in range(3):
                    dh[i] = J[i, j]
            else:  # d(J r) = theta x J r - J (theta x r)
                cross(unit, h, dh)
                cross(unit, r, dT)
                for i in range(3):
                    dh[i] -= J[i, 0] * dT[0] + J[i, 1] * dT[1] + J[i, 2] * dT[2]
            ds = dot(dr, h) + dot(r, dh)
            dlog = dot(r, dr) / far**2  # of |r|
            da, db = -3.0 * a * dlog, -5.0 * b * dlog
            cross(dr, h, dF)
            cross(r, dh, dT)
            for i in range(3):
                bracket = trace * r[i] + 2.0 * h[i] - 5.0 * s * r[i] / far**2
                change = trace * dr[i] + 2.0 * dh[i]
                change -= 5.0 * (ds * r[i] + s * dr[i] - 2.0 * s * r[i] * dlog) / far**2
                moment = 2.0 * (db * t[i] + b * (dF[i] + dT[i]))
                K[6 + i, 6 + j] += da * r[i] + a * dr[i] + db * bracket + b * change
                K[9 + i, 6 + j] -= moment


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
        inertia = np.asarray(getattr(body, "inertia", np.zeros((3, 3))), float)
        return {
            "marker": marker,
            "source": source,
            "pair": compiler.pair(source, marker, STIFF),
            "mass": float(body.mass),
            "inertia": inertia,
        }
