"""`SolarPressure`: the pressure of sunlight on a flat plate, see `flexmb.forces.plate_in_stream`."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from typing import Any, ClassVar

import numpy as np

from flexmb.errors import ModelError
from flexmb.forces.plate_in_stream import check_shares, plate_force, plate_slopes
from flexmb.forces.rows import require_centre, store_three_signals
from flexmb.forces.shadow import edges, lit
from flexmb.math.kepler import ELEMENTS, follow_orbit
from flexmb.math.kernel import inner_kernel
from flexmb.math.switches import CROSSING, KINK, switch_kernel
from flexmb.math.tables import STIFF, row_kernel
from flexmb.math.vectors import dot, norm
from flexmb.model.kinds import Force
from flexmb.model.orbit import elements_of
from flexmb.model.signal import Constant
from flexmb.model.table import Table

__all__ = ["SolarPressure"]

AT_EARTH = 4.539e-6
SUN = 4.652e-3
LARGEST = 0.5
ROW = np.dtype(
    [
        ("marker", np.int64),
        ("pair", np.int64),
        ("strength", float),  # pressure times area, N
        ("mirrored", float),
        ("recoil", float),
        ("both", np.int64),  # 1: the other face is alike
        ("sun", np.int64, 3),  # signals
        ("source", np.int64),  # marker of the centre of what shades
        ("shadow", float),  # m, its radius
        ("sun_angle", float),  # rad
        ("edges", np.int64),  # of the shadow
        ("orbit", ELEMENTS),
    ],
    align=True,
)


@inner_kernel
def _toward_sun(row, state, s, ds):
    """Write the unit vector to the Sun and its rate."""
    for i in range(3):
        s[i], ds[i] = state.signals[row.sun[i], 0], state.signals[row.sun[i], 1]
    far = norm(s)
    for i in range(3):
        s[i] /= far
        ds[i] /= far
    along = dot(s, ds)
    for i in range(3):
        ds[i] -= along * s[i]


@inner_kernel
def _place(row, data, state, work, r, v):
    """Write place and velocity of the plate from the centre of what shades it."""
    marker, source = work.markers[row.marker], work.markers[row.source]
    follow_orbit(state.t, row.orbit, data, r, v)
    for i in range(3):
        r[i] += marker.r[i] - source.r[i]
        v[i] += marker.v[i]


@row_kernel
def apply(raw, data, state, work):
    """The force of light on the face that it meets, at the marker."""
    rows = raw.view(ROW)
    w, n, F, by_w, by_turn = np.empty(3), np.empty(3), np.empty(3), np.empty((3, 3)), np.empty((3, 3))
    r, v, s, ds, slope = np.empty(3), np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    for k in range(rows.shape[0]):
        row = rows[k]
        marker = work.markers[row.marker]
        _toward_sun(row, state, s, ds)
        toward, share = 0.0, 1.0
        slope[:] = 0.0
        for i in range(3):
            w[i], n[i] = -s[i], marker.R[i, 2]
            toward -= w[i] * n[i]
        if row.edges > 0:
            _place(row, data, state, work, r, v)
            share = lit(r, s, row.shadow, row.sun_angle, slope)
        if toward < 0.0 and row.both == 1:
            for i in range(3):
                n[i] = -n[i]
        if share == 0.0 or plate_force(row.strength, w, n, row.mirrored, row.recoil, F) <= 0.0:
            continue
        for i in range(3):
            marker.wrench[i] += share * F[i]
            work.energy[0].load_power += share * F[i] * marker.v[i]
        if work.weights[0].wanted != 0:
            plate_slopes(share * row.strength, w, n, row.mirrored, row.recoil, by_w, by_turn)
            for i in range(3):
                for j in range(3):
                    work.pairs[row.pair].K[i, j] -= F[i] * slope[j]
                    work.pairs[row.pair].K[i, 3 + j] -= by_turn[i, j]


@switch_kernel
def switch(raw, data, state, work, out):
    """The edges of the shadow: light has a kink at those of a cone, and jumps at that of a cylinder."""
    rows = raw.view(ROW)
    r, v, s, ds, found = np.empty(3), np.empty(3), np.empty(3), np.empty(3), np.empty((2, 2))
    first = 0
    for n in range(rows.shape[0]):
        row = rows[n]
        if row.edges == 0:
            continue
        _toward_sun(row, state, s, ds)
        _place(row, data, state, work, r, v)
        edges(r, v, s, ds, row.shadow, row.sun_angle, found)
        for k in range(row.edges):
            place = out[first + k]
            place[:] = 0.0
            place[0], place[9] = CROSSING if row.sun_angle == 0.0 else KINK, 1.0
            place[1], place[4] = row.shadow * found[k, 0], row.shadow * found[k, 1]
        first += row.edges


@dataclass(frozen=True, eq=False)
class SolarPressure(Force):
    """Press on a flat plate by the light of the Sun. Plates do not shade each other; a planet may.

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
    shadow : float, m
        Radius of a sphere about `source` that shades the plate, 6378137.0 for the Earth; 0: nothing does. Steps end
        where umbra and penumbra begin and end.
    sun_angle : float, rad
        Half of the Sun's apparent diameter; by default that seen from the Earth. 0: the shadow is a cylinder.
    source : str
        "ground.marker" of the centre of that sphere; with `Model(origin=Orbit(...))` it stands at the origin of W.

    Source: Wertz 1978, eq. 17-49; shadow: Montenbruck & Gill 2000, section 3.4.2.
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
    shadow: float = 0.0
    sun_angle: float = SUN
    source: str = "ground.origin"

    table: ClassVar[Table] = Table("SolarPressure", ROW, {"apply": apply, "switch": switch}, switches="edges")

    def __post_init__(self):
        super().__post_init__()
        self.require_positive("pressure")
        check_shares(self)
        store_three_signals(self, "sun")
        if all(isinstance(one, Constant) and one.value == 0.0 for one in self.sun):
            raise ModelError(
                self.title,
                found="sun = (0, 0, 0), which has no direction",
                expected="a vector towards the sun, of any length, in the axes of W",
                remedy="Write sun=(1, 0, 0)",
            )
        self.require_positive("shadow", "sun_angle", zero=True)
        if self.sun_angle > LARGEST:
            raise ModelError(
                self.title,
                found=f"sun_angle = {self.sun_angle!r} rad",
                expected=f"half of an apparent diameter, at most {LARGEST} rad",
                remedy=f"Leave it out for {SUN} rad, as seen from the Earth",
            )

    def check(self, model) -> None:
        """Raise ModelError if the marker does not exist, or the centre of what shades is not on the ground."""
        model.marker(self.marker, self.title)
        if self.shadow:
            require_centre(self, model)

    def in_world_axes(self, model) -> str:
        """Return the name of the field that is given in the axes of W."""
        return "sun"

    def record(self, compiler):
        """Return the row."""
        marker = compiler.marker(self.marker)
        return {
            "source": compiler.marker(self.source) if self.shadow else marker,
            "edges": 0 if not self.shadow else 2 if self.sun_angle else 1,
            "orbit": elements_of(compiler),
            "marker": marker,
            "pair": compiler.pair(marker, marker, STIFF),
            "strength": self.pressure * self.area,
            "recoil": 2.0 / 3.0 * self.diffuse,
            "both": int(self.both_faces),
            "sun": tuple(compiler.signal(signal) for signal in self.sun),
        }
