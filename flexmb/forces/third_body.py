"""`ThirdBody`: the attraction of a further body (the Sun, the Moon) in axes that fall with the central one.

F = m mu ((s - r) / |s - r|^3 - s / |s|^3), s its place from the origin of W (Vallado 2013, section 8.6).
"""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from typing import Any, ClassVar

import numpy as np

from flexmb.forces.rows import require_center_of_mass, store_three_signals
from flexmb.math.tables import STIFF, row_kernel
from flexmb.math.vectors import norm
from flexmb.model.kinds import Force
from flexmb.model.table import Table

__all__ = ["ThirdBody"]

ROW = np.dtype(
    [
        ("marker", np.int64),
        ("pair", np.int64),
        ("strength", float),  # mu m, N m2
        ("at", np.int64, 3),  # signals, m
    ],
    align=True,
)


@row_kernel
def apply(raw, data, state, work):
    """F = m mu ((s - r) / |s - r|^3 - s / |s|^3); its power is that of a load, the potential moves."""
    rows = raw.view(ROW)
    d, s = np.empty(3), np.empty(3)
    for n in range(rows.shape[0]):
        row = rows[n]
        marker = work.markers[row.marker]
        for i in range(3):
            s[i] = state.signals[row.at[i], 0]
            d[i] = s[i] - marker.r[i]
        far, away = norm(d), norm(s)
        for i in range(3):
            force = row.strength * (d[i] / far**3 - s[i] / away**3)
            marker.wrench[i] += force
            work.energy[0].load_power += force * marker.v[i]
        if work.weights[0].wanted == 0:
            continue
        K = work.pairs[row.pair].K
        for i in range(3):
            K[i, i] += row.strength / far**3
            for j in range(3):
                K[i, j] -= 3.0 * row.strength * d[i] * d[j] / far**5


@dataclass(frozen=True, eq=False)
class ThirdBody(Force):
    """Attract a rigid body or point mass to a body that moves as given, less what it gives the origin of W.

    Parameters
    ----------
    name : str
    body : str
        A `RigidBody` or `PointMass`.
    mu : float, N m2/kg
        Gravitational constant times the mass of the third body.
    at : three signals, m
        Its place in W. The origin of W falls freely: it is the centre of the central body.
    """

    name: str
    _: KW_ONLY
    body: str
    mu: float
    at: Any

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
        mass = float(compiler.model.body(self.body).mass)
        marker = compiler.marker(f"{self.body}.center")
        at = tuple(compiler.signal(signal) for signal in self.at)
        pair = compiler.pair(marker, marker, STIFF)
        return {"marker": marker, "pair": pair, "strength": self.mu * mass, "at": at}
