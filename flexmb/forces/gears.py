"""`Gears`: the teeth of two involute gears, elastic, with backlash, by their line of action."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from typing import ClassVar

import numpy as np

from flexmb.errors import ModelError
from flexmb.forces.gear_mesh import axis_in_slice, flank, pair_stiffness, turn_of_axes
from flexmb.forces.relative import act_relative, add_relative_tangent, relative_motion
from flexmb.forces.tooth_geometry import ToothGeometry, iso_range, single_stiffness
from flexmb.math.kernel import inner_kernel
from flexmb.math.switches import GAP, switch_kernel
from flexmb.math.tables import row_kernel
from flexmb.model.described import finite_array, is_number
from flexmb.model.kinds import Force
from flexmb.model.table import Table

__all__ = ["Gears"]

ROW = np.dtype(
    [
        ("a", np.int64),
        ("b", np.int64),
        ("pair", np.int64),
        ("slices", np.int64),
        ("width", float),  # m
        ("side", float),  # 1, inside a ring -1
        ("base_a", float),  # m, base radii
        ("base_b", float),
        ("pitch", float),  # m, transverse base pitch
        ("lead", float),  # tangent of the base helix angle, positive for a right-handed gear a
        ("tight", float),  # m
        ("offset", float),  # m
        ("half", float),  # rad, half a tooth of gear a on its base circle
        ("first", float),  # m, path of contact
        ("last", float),
        ("ramp", float),  # m
        ("stiffness", float),  # N/m2
        ("fall", float),
        ("damping", float),  # s/m
    ],
    align=True,
)
RAMP = 0.05
"""Of the base pitch: over which a pair of teeth comes and goes."""


@inner_kernel
def _add_slice(width, damping, v, overlap, S, d1, d2, s1, s2, energy, wanted, f, K, C):
    """Add the force of one flank in one slice, minus the gradient of width S(s) overlap^2 / 2, and its damping."""
    rate = 0.0
    for i in range(6):
        rate += d1[i] * v[i]
    growth = max(1.0 + damping * rate, 0.0)
    on = damping if growth > 0.0 else 0.0
    elastic = width * S[0] * overlap
    by_place = 0.5 * width * overlap * overlap
    energy.potential += 0.5 * elastic * overlap
    energy.dissipation += elastic * (growth - 1.0) * rate
    for i in range(6):
        f[i] -= elastic * growth * d1[i] + by_place * S[1] * s1[i]
    if not wanted:
        return
    for j in range(6):
        turned = 0.0
        for k in range(6):
            turned += d2[k, j] * v[k]
        slope = width * (S[0] * d1[j] + S[1] * overlap * s1[j]) * growth + elastic * on * turned
        for i in range(6):
            K[i, j] += slope * d1[i] + elastic * growth * d2[i, j]
            K[i, j] += width * overlap * S[1] * d1[j] * s1[i] + by_place * (S[2] * s1[i] * s1[j] + S[1] * s2[i, j])
            C[i, j] += elastic * on * d1[i] * d1[j]


@inner_kernel
def _middle(row, k):
    """Return where slice k lies along the axis of gear a."""
    return row.width * ((k + 0.5) / row.slices - 0.5)


@row_kernel
def apply(raw, data, state, work):
    """F = b c(s) overlap (1 + D overlap') along the line of action of every flank that touches, eq. (gear-force)."""
    rows = raw.view(ROW)
    motion, Q = np.empty(9), np.empty((3, 3))
    A, B, S = np.empty(3), np.empty((3, 3)), np.empty(3)
    y, Y, YY = np.empty(3), np.empty((3, 6)), np.empty((3, 6, 6))
    d1, d2, s1, s2 = np.empty(6), np.empty((6, 6)), np.empty(6), np.empty((6, 6))
    f, K, C = np.empty(6), np.empty((6, 6)), np.empty((6, 6))
    wanted = work.weights[0].wanted == 1
    for m in range(rows.shape[0]):
        row = rows[m]
        a, b = work.markers[row.a], work.markers[row.b]
        relative_motion(a, b, motion, Q)
        psi = turn_of_axes(Q, A, B)
        f[:] = 0.0
        K[:] = 0.0
        C[:] = 0.0
        for k in range(row.slices):
            z = _middle(row, k)
            axis_in_slice(z, motion[0:3], Q, y, Y, YY)
            for sigma in (-1.0, 1.0):
                overlap, place = flank(row, sigma, z, y, Y, YY, psi, A, B, d1, d2, s1, s2)
                if overlap <= 0.0:
                    continue
                pair_stiffness(row, place, S)
                _add_slice(
                    row.width / row.slices,
                    row.damping,
                    motion[3:9],
                    overlap,
                    S,
                    d1,
                    d2,
                    s1,
                    s2,
                    work.energy[0],
                    wanted,
                    f,
                    K,
                    C,
                )
        act_relative(a, b, f)
        if wanted:
            add_relative_tangent(work.pairs[row.pair], a, b, f, K, C)


@switch_kernel
def switch(raw, data, state, work, out):
    """The smallest gap of each side of the teeth."""
    rows = raw.view(ROW)
    motion, Q = np.empty(9), np.empty((3, 3))
    A, B = np.empty(3), np.empty((3, 3))
    y, Y, YY = np.empty(3), np.empty((3, 6)), np.empty((3, 6, 6))
    d1, d2, s1, s2 = np.empty(6), np.empty((6, 6)), np.empty(6), np.empty((6, 6))
    for m in range(rows.shape[0]):
        row = rows[m]
        relative_motion(work.markers[row.a], work.markers[row.b], motion, Q)
        psi = turn_of_axes(Q, A, B)
        for side in range(2):
            gap = out[2 * m + side]
            gap[:] = 0.0
            gap[0], gap[1], gap[9] = GAP, np.inf, 1.0
            for k in range(row.slices):
                z = _middle(row, k)
                axis_in_slice(z, motion[0:3], Q, y, Y, YY)
                overlap, _ = flank(row, 2.0 * side - 1.0, z, y, Y, YY, psi, A, B, d1, d2, s1, s2)
                if -overlap < gap[1]:
                    gap[1], gap[4] = -overlap, 0.0
                    for i in range(6):
                        gap[4] -= d1[i] * motion[3 + i]


@dataclass(frozen=True, eq=False)
class Gears(Force):
    """Let the involute teeth of two spur or helical gears press on each other: backlash, mesh stiffness, axial force.

    The z-axes of both markers are the axes of the gears, in the middle of the face width, both the same way and nearly
    parallel. The force acts along the line of action of the flanks that touch, so the bearings feel its radial and
    axial parts, changes of the distance of the axes change pressure angle and backlash, and a tilt moves the load to
    one end of the teeth. As described, the teeth of b stand in the middle of the gaps of a; a tooth of a is on its
    x-axis. `GearPair` rolls without play and without elasticity.

    A pair of teeth has the stiffness ``c' (1 - kappa xi^2)`` per width over its path of contact, so that the mean over
    a pitch is the mesh stiffness of ISO 6336-1, ``c' (0.75 eps + 0.25)`` with the contact ratio eps; pairs come and go
    over 5 % of the base pitch. What is left out: friction of the teeth, deviations and relief of flanks, the fillet,
    contact of tip and root, and the smaller stiffness below 100 N/mm.

    Parameters
    ----------
    name : str
    markers : (str, str)
        Marker a of the gear with the first number of teeth, marker b of the other.
    module : float, m
        Normal module.
    teeth : (int, int)
    width : float, m
        Common face width.
    inside : bool
        The second gear is a ring with teeth on its inner side.
    pressure_angle : float, rad
        Normal.
    helix : float, rad
        Helix angle, positive for a right-handed gear a.
    shifts : (float, float), -
        Profile shifts over the module.
    addendum, dedendum : float, -
        Of the basic rack over the module.
    backlash : float, m
        What the teeth of both gears together are thinner at the reference circles; the distance of the axes adds to it.
    stiffness : float, N/m2, optional
        Single stiffness c' of a pair of teeth per face width; by default from ISO 6336-1, method B, for solid gears.
    young : float, Pa
        Mean modulus 2 E E'/(E + E') for the default stiffness.
    damping : float, s/m
        The force grows by the factor ``1 + damping rate`` of the overlap.
    slices : int
        Across the face width; one is enough for spur gears on parallel axes.

    Source: ISO 6336-1:2006, clause 9 (method B); DIN 3960 (geometry).
    """

    name: str
    _: KW_ONLY
    markers: tuple[str, str]
    module: float
    teeth: tuple[int, int]
    width: float
    inside: bool = False
    pressure_angle: float = float(np.radians(20.0))
    helix: float = 0.0
    shifts: tuple[float, float] = (0.0, 0.0)
    addendum: float = 1.0
    dedendum: float = 1.25
    backlash: float = 0.0
    stiffness: float | None = None
    young: float = 206e9
    damping: float = 0.0
    slices: int = 1

    table: ClassVar[Table] = Table("Gears", ROW, {"apply": apply, "switch": switch}, switches=2)
    strikes: ClassVar[bool] = True

    def __post_init__(self):
        super().__post_init__()
        self.require_marker_pair()
        self.require_positive("module", "width", "young", "addendum", "dedendum")
        self.require_positive("backlash", "damping", zero=True)
        if self.stiffness is not None:
            self.require_positive("stiffness")
        self._require_teeth()
        for field, low, high in (("pressure_angle", 0.05, 0.8), ("helix", -1.2, 1.2)):
            value = getattr(self, field)
            if not is_number(value) or not low <= value <= high:
                raise ModelError(
                    self.title,
                    found=f"{field} = {value!r} rad",
                    expected=f"an angle from {low} to {high} rad",
                    remedy="Give it in radians: 20 degrees are 0.349",
                )
        shifts = finite_array(self.shifts)
        if shifts.shape != (2,):
            raise ModelError(
                self.title, found=f"shifts = {self.shifts!r}", expected="two numbers", remedy="Write shifts=(0.3, 0.0)"
            )
        object.__setattr__(self, "shifts", tuple(shifts.tolist()))
        if isinstance(self.slices, bool) or not isinstance(self.slices, int) or not 1 <= self.slices <= 200:
            raise ModelError(
                self.title,
                found=f"slices = {self.slices!r}",
                expected="a whole number from 1 to 200",
                remedy="11 slices follow a helix or a tilt",
            )

    def _require_teeth(self) -> None:
        teeth = finite_array(self.teeth)
        if teeth.shape != (2,) or np.any(teeth < 5) or np.any(teeth != np.round(teeth)):
            raise ModelError(
                self.title,
                found=f"teeth = {self.teeth!r}",
                expected="two whole numbers >= 5",
                remedy="Write teeth=(20, 40); a ring is inside=True",
            )
        if self.inside and teeth[1] <= teeth[0]:
            raise ModelError(
                self.title,
                found=f"a ring of {teeth[1]:g} teeth around a gear of {teeth[0]:g}",
                expected="a ring with more teeth, second",
                remedy="The ring is the gear of the second marker",
            )
        object.__setattr__(self, "teeth", tuple(int(z) for z in teeth))

    def check(self, model) -> None:
        """Raise ModelError if a marker does not exist."""
        for marker in self.markers:
            model.marker(marker, self.title)

    def geometry(self, distance: float) -> ToothGeometry:
        """Return the geometry of the pair at a distance of the axes, m: `contact_ratio`, `play`, `working_angle`, ...

        Raises
        ------
        ModelError
            The teeth do not fit each other at that distance.
        """
        first, second = self.teeth
        geometry = ToothGeometry(
            module=self.module,
            teeth=(first, -second if self.inside else second),
            pressure_angle=self.pressure_angle,
            helix=abs(self.helix),
            shifts=self.shifts,
            addendum=self.addendum,
            thinning=self.backlash,
            distance=distance,
        )
        if not geometry.play >= -1e-9 * self.module:
            raise ModelError(
                self.title,
                found=f"axes at a distance of {distance:.6g} m, where the teeth overlap",
                expected=f"a distance of {geometry.tight_distance:.6g} m, where they have no play, or one with play",
                remedy="Move a marker, or give backlash",
            )
        first_place, last_place = geometry.path
        along = geometry.distance * np.sin(geometry.working_angle)
        beyond = not self.inside and (first_place < 0.0 or last_place > along)
        if geometry.contact_ratio < 1.0 or beyond:
            raise ModelError(
                self.title,
                found=f"a contact ratio of {geometry.contact_ratio:.4g}, a path of contact from {first_place:.4g} "
                f"to {last_place:.4g} m on a line of action of {along:.4g} m",
                expected="a contact ratio of 1 or more, and tips that touch the other flank above its base circle",
                remedy="Change teeth, shifts, addendum or the distance of the axes",
            )
        return geometry

    def single_stiffness(self, distance: float) -> float:
        """Return c', N/m2: the stiffness of one pair of teeth per face width, as given or by ISO 6336-1.

        Raises
        ------
        ModelError
            The pair is outside the range of ISO 6336-1.
        """
        if self.stiffness is not None:
            return float(self.stiffness)
        geometry = self.geometry(distance)
        outside = iso_range(geometry)
        if outside:
            raise ModelError(
                self.title,
                found=outside,
                expected="the range of ISO 6336-1, method B",
                remedy="Give the stiffness of a pair of teeth, N/m2",
            )
        return single_stiffness(geometry, self.dedendum, self.young)

    def record(self, compiler):
        """Return the row; the teeth mesh as the gears are described."""
        a, b = (compiler.marker(name) for name in self.markers)
        (r_a, R_a), (r_b, R_b) = compiler.pose(a), compiler.pose(b)
        d, Q = R_a.T @ (r_b - r_a), R_a.T @ R_b
        if Q[2, 2] < 0.5:
            raise ModelError(
                self.title,
                found=f"axes {np.degrees(np.arccos(np.clip(Q[2, 2], -1, 1))):.4g} degrees apart",
                expected="z-axes of both markers the same way, nearly parallel",
                remedy="Turn a marker",
            )
        zeta = -d[2] / Q[2, 2]
        c = d[:2] + Q[:2, 2] * zeta
        geometry = self.geometry(float(np.hypot(*c)))
        (base_a, base_b), side = geometry.base_radii, geometry.side
        lead = float(np.sign(self.helix) * np.tan(geometry.base_helix))
        theta = np.arctan2(side * c[1], side * c[0])
        psi = np.arctan2(Q[1, 0] - Q[0, 1], Q[0, 0] + Q[1, 1])
        first, last = geometry.path
        return {
            "a": a,
            "b": b,
            "pair": compiler.pair(a, b),
            "side": side,
            "base_a": base_a,
            "base_b": base_b,
            "pitch": geometry.pitch,
            "lead": lead,
            "tight": geometry.tight,
            "offset": float((base_a + base_b) * theta - base_b * psi + lead * zeta),
            "half": geometry.half_tooth,
            "first": first,
            "last": last,
            "ramp": RAMP * geometry.pitch,
            "stiffness": self.single_stiffness(geometry.distance),
            "fall": 0.75 * (1.0 - 1.0 / geometry.contact_ratio),
        }
