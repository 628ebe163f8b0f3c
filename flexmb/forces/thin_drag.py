"""`ThinDrag`: the drag and lift of a flat plate in the uppermost atmosphere, see `flexmb.forces.plate_in_stream`."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from math import exp
from typing import ClassVar

import numpy as np

from flexmb.errors import ModelError
from flexmb.forces.plate_in_stream import check_shares, plate_force, plate_slopes
from flexmb.forces.rows import require_centre
from flexmb.math.kepler import ELEMENTS, follow_orbit
from flexmb.math.tables import DAMPED, row_kernel
from flexmb.math.vectors import cross, norm
from flexmb.model.described import is_number
from flexmb.model.kinds import Force
from flexmb.model.orbit import RADIUS, elements_of
from flexmb.model.table import Table

__all__ = ["ThinDrag"]

ROW = np.dtype(
    [
        ("marker", np.int64),
        ("source", np.int64),
        ("pair", np.int64),
        ("area", float),  # m2
        ("density", float),  # kg/m3, at `altitude`
        ("radius", float),  # m, of the place that has this density
        ("scale_height", float),  # m
        ("rotation", float),  # rad/s
        ("mirrored", float),
        ("recoil", float),  # m/s
        ("both", np.int64),  # 1: the other face is alike
        ("orbit", ELEMENTS),
    ],
    align=True,
)


@row_kernel
def apply(raw, data, state, work):
    """The force of the stream on the face that it meets, at the marker."""
    rows = raw.view(ROW)
    r, w, n, F = np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    spin, air, unit, moved, turned = np.empty(3), np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    by_w, by_turn = np.empty((3, 3)), np.empty((3, 3))
    for k in range(rows.shape[0]):
        row = rows[k]
        marker, source = work.markers[row.marker], work.markers[row.source]
        follow_orbit(state.t, row.orbit, data, r, w)
        for i in range(3):
            r[i] += marker.r[i] - source.r[i]
            spin[i] = row.rotation * source.R[i, 2]
        cross(spin, r, air)
        toward = 0.0
        for i in range(3):
            w[i] = air[i] - w[i] - marker.v[i]  # the stream against the plate
            n[i] = marker.R[i, 2]
            toward -= w[i] * n[i]
        if toward < 0.0 and row.both == 1:
            for i in range(3):
                n[i] = -n[i]
        far = norm(r)
        scale = row.area * row.density * exp((row.radius - far) / row.scale_height)
        if plate_force(scale, w, n, row.mirrored, row.recoil, F) <= 0.0:
            continue
        for i in range(3):
            marker.wrench[i] += F[i]
            work.energy[0].load_power += F[i] * marker.v[i]
        if work.weights[0].wanted == 0:
            continue
        plate_slopes(scale, w, n, row.mirrored, row.recoil, by_w, by_turn)
        pair = work.pairs[row.pair]
        for j in range(3):
            unit[:] = 0.0
            unit[j] = 1.0
            cross(spin, unit, moved)
            cross(marker.v, unit, turned)  # its velocity turns with the body
            for i in range(3):
                along = -F[i] * r[j] / (far * row.scale_height)
                turning = by_turn[i, j]
                for m in range(3):
                    along += by_w[i, m] * moved[m]
                    turning += by_w[i, m] * turned[m]
                pair.K[i, j] -= along
                pair.K[i, 3 + j] -= turning
                pair.D[i, j] += by_w[i, j]


@dataclass(frozen=True, eq=False)
class ThinDrag(Force):
    """Push a flat plate by the gas of the uppermost atmosphere, whose molecules meet the plate and not each other.

    The density falls exponentially with altitude, and the gas turns with the central body. A plate that absorbs has the
    drag coefficient 2 of its area across the stream. Plates do not shade each other.

    Parameters
    ----------
    name : str
    marker : str
        "body.marker" in the middle of the plate, its z-axis the outward normal.
    area : float, m2
    density : float, kg/m3
        At the `altitude`.
    altitude : float, m
        Where the density is given.
    scale_height : float, m
        Over which the density falls to 1/e.
    mirrored, diffuse : float, -
        Shares of the molecules that the surface mirrors, and that leave in all directions; the rest stays without
        recoil.
    leaving : float, m/s
        Mean normal speed of those that leave in all directions.
    rotation : float, rad/s
        Of the atmosphere about the z-axis of `source`; by default the Earth's.
    surface : float, m
        Radius from which altitudes are counted; by default the Earth's.
    source : str
        "ground.marker" of the centre; with `Model(origin=Orbit(...))` it stands at the origin of W.
    both_faces : bool
        Are both faces alike? Otherwise a stream from behind gives no force: it belongs to another plate.

    Source: Hughes 1986, section 8.1; Schaaf & Chambré 1961.
    """

    name: str
    _: KW_ONLY
    marker: str
    area: float
    density: float
    altitude: float = 0.0
    scale_height: float = 6e4
    mirrored: float = 0.0
    diffuse: float = 0.0
    leaving: float = 0.0
    rotation: float = 7.292115e-5
    surface: float = RADIUS
    source: str = "ground.origin"
    both_faces: bool = True

    table: ClassVar[Table] = Table("ThinDrag", ROW, {"apply": apply})

    def __post_init__(self):
        super().__post_init__()
        self.require_positive("density", "scale_height", "surface")
        self.require_positive("leaving", "altitude", zero=True)
        if not is_number(self.rotation):
            raise ModelError(
                self.title,
                found=f"rotation = {self.rotation!r}",
                expected="a number, rad/s",
                remedy="Write rotation=0.0 for an atmosphere that stands still",
            )
        check_shares(self)

    def check(self, model) -> None:
        """Raise ModelError if a marker does not exist, or the centre is not on the ground."""
        model.marker(self.marker, self.title)
        require_centre(self, model)

    def record(self, compiler):
        """Return the row."""
        marker, source = compiler.marker(self.marker), compiler.marker(self.source)
        return {
            "marker": marker,
            "source": source,
            "pair": compiler.pair(marker, marker, DAMPED),
            "radius": self.surface + self.altitude,
            "recoil": self.diffuse * self.leaving,
            "both": int(self.both_faces),
            "orbit": elements_of(compiler),
        }
