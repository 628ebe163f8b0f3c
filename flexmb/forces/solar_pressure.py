"""`SolarPressure`: the pressure of sunlight on a flat plate, see `flexmb.forces.plate_in_stream`."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from typing import Any, ClassVar

import numpy as np

from flexmb.forces.plate_in_stream import check_shares, plate_force, plate_slopes
from flexmb.forces.rows import store_three_signals
from flexmb.math.tables import STIFF, row_kernel
from flexmb.math.vectors import norm
from flexmb.model.kinds import Force
from flexmb.model.table import Table

__all__ = ["SolarPressure"]

AT_EARTH = 4.539e-6
ROW = np.dtype(
    [
        ("marker", np.int64),
        ("pair", np.int64),
        ("strength", float),  # pressure times area, N
        ("mirrored", float),
        ("recoil", float),
        ("both", np.int64),  # 1: the other face is alike
        ("sun", np.int64, 3),  # signals
    ],
    align=True,
)


@row_kernel
def apply(raw, data, state, work):
    """The force of light on the face that it meets, at the marker."""
    rows = raw.view(ROW)
    w, n, F, by_w, by_turn = np.empty(3), np.empty(3), np.empty(3), np.empty((3, 3)), np.empty((3, 3))
    for k in range(rows.shape[0]):
        row = rows[k]
        marker = work.markers[row.marker]
        for i in range(3):
            w[i] = -state.signals[row.sun[i], 0]
            n[i] = marker.R[i, 2]
        far, toward = norm(w), 0.0
        for i in range(3):
            w[i] /= far
            toward -= w[i] * n[i]
        if toward < 0.0 and row.both == 1:
            for i in range(3):
                n[i] = -n[i]
        if plate_force(row.strength, w, n, row.mirrored, row.recoil, F) <= 0.0:
            continue
        for i in range(3):
            marker.wrench[i] += F[i]
            work.energy[0].load_power += F[i] * marker.v[i]
        if work.weights[0].wanted != 0:
            plate_slopes(row.strength, w, n, row.mirrored, row.recoil, by_w, by_turn)
            for i in range(3):
                for j in range(3):
                    work.pairs[row.pair].K[i, 3 + j] -= by_turn[i, j]


@dataclass(frozen=True, eq=False)
class SolarPressure(Force):
    """Press on a flat plate by the light of the Sun; nothing shades it.

    Parameters
    ----------
    name : str
    marker : str
        "body.marker" in the middle of the plate, its z-axis the outward normal.
    area : float, m2
    sun : three signals, -
        Direction to the Sun in W, of any length.
    mirrored, diffuse : float, -
        Shares of the light that the surface mirrors and scatters; the rest is absorbed.
    pressure : float, N/m2
        On a plate across the light that absorbs all of it; by default 1361 W/m2 over the speed of light, at the Earth.
    both_faces : bool
        Are both faces alike? Otherwise light from behind gives no force: it belongs to another plate.

    Source: Wertz 1978, eq. 17-49.
    """

    name: str
    _: KW_ONLY
    marker: str
    area: float
    sun: Any
    mirrored: float = 0.0
    diffuse: float = 0.0
    pressure: float = AT_EARTH
    both_faces: bool = False

    table: ClassVar[Table] = Table("SolarPressure", ROW, {"apply": apply})

    def __post_init__(self):
        super().__post_init__()
        self.require_positive("pressure")
        check_shares(self)
        store_three_signals(self, "sun")

    def check(self, model) -> None:
        """Raise ModelError if the marker does not exist."""
        model.marker(self.marker, self.title)

    def in_world_axes(self, model) -> str:
        """Return the name of the field that is given in the axes of W."""
        return "sun"

    def record(self, compiler):
        """Return the row."""
        marker = compiler.marker(self.marker)
        return {
            "marker": marker,
            "pair": compiler.pair(marker, marker, STIFF),
            "strength": self.pressure * self.area,
            "recoil": 2.0 / 3.0 * self.diffuse,
            "both": int(self.both_faces),
            "sun": tuple(compiler.signal(signal) for signal in self.sun),
        }
