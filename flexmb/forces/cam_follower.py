"""`CamFollower`: a roller or a flat face on a profile, between flanges, by penalty."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from typing import Any, ClassVar

import numpy as np

from flexmb.errors import ModelError
from flexmb.forces.gap_contact import GAP_LAW, add_gap_contact, angle_derivatives, clear_gap
from flexmb.forces.on_coordinate import check_number
from flexmb.forces.relative import act_relative, add_relative_tangent, relative_motion
from flexmb.math.kernel import inner_kernel
from flexmb.math.switches import GAP, IDLE, SLIP, switch_kernel
from flexmb.math.tables import row_kernel
from flexmb.model.described import check_kind, finite_array
from flexmb.model.kinds import Force
from flexmb.model.table import Table
from flexmb.profiles import Profile
from flexmb.profiles.feet import FOOT, MOST_FEET, find_feet
from flexmb.profiles.supports import MOST_SUPPORTS, SUPPORT, find_supports

__all__ = ["CamFollower"]

ROW = np.dtype(
    [
        ("a", np.int64),
        ("b", np.int64),
        ("pair", np.int64),
        ("profile", np.int64),  # where its table begins in the bulk data, and how long it is
        ("numbers", np.int64),
        ("roller", float),  # m, 0 for a flat face
        ("low", float),  # m, between which places along z flanges hold the roller; infinite: none
        ("high", float),
        *GAP_LAW,
    ],
    align=True,
)
REACH = 3.0
"""Radii from the centre of the roller within which gaps are watched."""


@inner_kernel
def _roller_gap(row, foot, G, H, T, dT):
    """Write the derivatives of the gap of the roller at a foot, and of its slips along the profile and along z."""
    r, n, bend = row.roller, foot[2:4], foot[5]
    t = (-n[1], n[0])
    clear_gap(G, H, T, dT)
    for i in range(2):
        G[i] = n[i]
        T[0, i] = t[i]
        for j in range(2):
            H[i, j] = bend * t[i] * t[j]
            dT[0, i, j] = -bend * n[i] * t[j]
    T[0, 5] = -r
    T[1, 2], T[1, 3], T[1, 4] = 1.0, -r * n[1], r * n[0]
    for j in range(2):
        dT[1, 3, j] = -r * bend * t[1] * t[j]
        dT[1, 4, j] = r * bend * t[0] * t[j]
    return foot[4] - r


@inner_kernel
def _face_normal(Q, A, B):
    """Write the y-axis of b in the plane of the profile, as an angle's derivatives; return its two components."""
    S, D = np.empty((4, 3)), np.empty((4, 3))
    x, y, z = Q[0, 1], Q[1, 1], Q[2, 1]
    # e_i x q, and e_i x (e_j x q) = e_j q_i - q delta_ij
    S[0, 0], S[0, 1], S[0, 2] = -z, 0.0, x
    D[0, 0], D[0, 1], D[0, 2] = 0.0, z, -y
    q = (x, y, z)
    for j in range(3):
        for i in range(3):
            S[1 + j, i] = (q[i] if j == 1 else 0.0) - (y if i == j else 0.0)
            D[1 + j, i] = (q[i] if j == 0 else 0.0) - (x if i == j else 0.0)
    angle_derivatives(y, x, S, D, A, B)
    size = (x * x + y * y) ** 0.5
    return x / size, y / size


@inner_kernel
def _face_gap(d, nx, ny, A, B, support, G, H, T, dT):
    """Write the derivatives of the gap of the face at a support, and of its slips along the profile and along z."""
    n, t, rho = (nx, ny), (-ny, nx), support[2]
    y = (support[0] - d[0], support[1] - d[1])
    out, along = n[0] * y[0] + n[1] * y[1], t[0] * y[0] + t[1] * y[1]
    clear_gap(G, H, T, dT)
    for i in range(2):
        G[i] = n[i]
        T[0, i] = t[i]
    T[0, 5] = out
    T[1, 2], T[1, 3], T[1, 4] = 1.0, y[1], -y[0]
    dT[1, 3, 1], dT[1, 4, 0] = -1.0, 1.0
    for j in range(3):
        G[3 + j] = -along * A[j]
        for i in range(2):
            H[i, 3 + j] = t[i] * A[j]
            H[3 + j, i] = A[j] * t[i]
            dT[0, i, 3 + j] = -n[i] * A[j]
        for i in range(3):
            H[3 + i, 3 + j] = (out - rho) * A[i] * A[j] - along * B[i, j]
        dT[0, 5, 3 + j] = along * A[j]
        dT[1, 3, 3 + j] = rho * t[1] * A[j]
        dT[1, 4, 3 + j] = -rho * t[0] * A[j]
    for j in range(2):
        dT[0, 5, j] = -n[j]
    return -out


@inner_kernel
def _flange_gap(row, side, z, G, H, T, dT):
    """Write the derivatives of the gap of the lower (0) or upper (1) flange; it rubs at the centre of the roller."""
    clear_gap(G, H, T, dT)
    G[2] = 1.0 if side == 0 else -1.0
    T[0, 0] = T[1, 1] = 1.0
    return z - row.low if side == 0 else row.high - z


@inner_kernel
def _inside(foot, row):
    """Is the centre of the roller inside the material? Then only the nearest foot counts."""
    return row.roller > 0.0 and foot[4] < 0.0


@row_kernel
def apply(raw, data, state, work):
    """f = k p^e (1 + D p') n - mu f v_t / sqrt(v_t^2 + v_0^2) where follower and profile touch, eq. (gap-contact)."""
    rows = raw.view(ROW)
    motion, Q = np.empty(9), np.empty((3, 3))
    feet, supports = np.empty((MOST_FEET, FOOT)), np.empty((MOST_SUPPORTS, SUPPORT))
    G, H, T, dT = np.empty(6), np.empty((6, 6)), np.empty((2, 6)), np.empty((2, 6, 6))
    A, B = np.empty(3), np.empty((3, 3))
    f, K, C = np.empty(6), np.empty((6, 6)), np.empty((6, 6))
    wanted = work.weights[0].wanted == 1
    for m in range(rows.shape[0]):
        row = rows[m]
        a, b = work.markers[row.a], work.markers[row.b]
        relative_motion(a, b, motion, Q)
        table = data[row.profile : row.profile + row.numbers]
        f[:] = 0.0
        K[:] = 0.0
        C[:] = 0.0
        touching = False
        nx, ny = 0.0, 0.0
        if row.roller > 0.0:
            count = find_feet(table, motion[0], motion[1], row.roller, feet)
        else:
            nx, ny = _face_normal(Q, A, B)
            count = find_supports(table, nx, ny, supports)
        for k in range(count):
            if row.roller > 0.0:
                g = _roller_gap(row, feet[k], G, H, T, dT)
            else:
                g = _face_gap(motion[0:2], nx, ny, A, B, supports[k], G, H, T, dT)
            if g >= 0.0 or (row.roller > 0.0 and k > 0 and feet[k, 4] < 0.0):
                continue
            touching = True
            add_gap_contact(row, motion[3:9], g, G, H, T, dT, work.energy[0], wanted, f, K, C)
            if k == 0 and _inside(feet[k], row):
                break
        for side in range(2):
            g = _flange_gap(row, side, motion[2], G, H, T, dT)
            if g < 0.0:
                touching = True
                add_gap_contact(row, motion[3:9], g, G, H, T, dT, work.energy[0], wanted, f, K, C)
        if touching:
            act_relative(a, b, f)
            if wanted:
                add_relative_tangent(work.pairs[row.pair], a, b, f, K, C)


@switch_kernel
def switch(raw, data, state, work, out):
    """The two smallest gaps, the slip where the follower touches, and the gaps of the flanges."""
    rows = raw.view(ROW)
    motion, Q = np.empty(9), np.empty((3, 3))
    feet, supports = np.empty((MOST_FEET, FOOT)), np.empty((MOST_SUPPORTS, SUPPORT))
    G, H, T, dT = np.empty(6), np.empty((6, 6)), np.empty((2, 6)), np.empty((2, 6, 6))
    A, B = np.empty(3), np.empty((3, 3))
    for m in range(rows.shape[0]):
        row = rows[m]
        relative_motion(work.markers[row.a], work.markers[row.b], motion, Q)
        table = data[row.profile : row.profile + row.numbers]
        nx, ny = 0.0, 0.0
        if row.roller > 0.0:
            count = find_feet(table, motion[0], motion[1], REACH * row.roller, feet)
        else:
            nx, ny = _face_normal(Q, A, B)
            count = find_supports(table, nx, ny, supports)
        slip = out[5 * m + 2]
        slip[:] = 0.0
        slip[0] = IDLE
        for side in range(2):
            gap = out[5 * m + 3 + side]
            gap[:] = 0.0
            g = _flange_gap(row, side, motion[2], G, H, T, dT)
            gap[0] = GAP if g < np.inf else IDLE
            gap[1], gap[4], gap[9] = (g if g < np.inf else 0.0), G[2] * motion[5], 1.0
        for k in range(2):
            gap = out[5 * m + k]
            gap[:] = 0.0
            gap[0] = IDLE
            if k >= count:
                continue
            if row.roller > 0.0:
                g = _roller_gap(row, feet[k], G, H, T, dT)
            else:
                g = _face_gap(motion[0:2], nx, ny, A, B, supports[k], G, H, T, dT)
            gap[0], gap[1], gap[9] = GAP, g, 1.0
            for i in range(6):
                gap[4] += G[i] * motion[3 + i]
            if k == 0 and g < 0.0 and row.friction > 0.0:
                slip[0], slip[8] = SLIP, row.transition
                for i in range(6):
                    slip[4] += T[0, i] * motion[3 + i]
                    slip[5] += T[1, i] * motion[3 + i]


@dataclass(frozen=True, eq=False)
class CamFollower(Force):
    """Let a roller or a flat face touch a profile: cam and follower, wheel and track, pawl and ratchet.

    The profile lies in the x-y plane of marker a and is extruded along its z-axis, as long as it is needed. A roller is
    a cylinder around marker b whose axis is parallel; it touches at every place of the profile that is nearest among
    its neighbours, so at two in a groove. A flat face is the x-z plane of marker b with its body on the side of y,
    as wide as it is needed; it touches where the profile stands out. Nothing else guides the follower: joints do.

    The normal force of a penetration p is ``stiffness p^exponent (1 + damping p')``, never pulling, eq. (gap-contact);
    friction is Coulomb's, regularised below the speed `transition`. Steps end where a contact begins and ends.

    Parameters
    ----------
    name : str
    markers : (str, str)
        Marker a of the cam, marker b of the follower.
    profile : Profile
        `Cam`, `Outline`, `SmoothOutline`, `Disc`, ...: in model files ``{ kind = "Disc", radius = 0.03 }``.
    roller : float, m
        Radius of the roller; 0: a flat face.
    flanges : (float, float), m, optional
        Between which places along the z-axis of marker a flanges hold marker b, by the same law.
    stiffness : float, N/m^e
    exponent : float, -
        1 for a line contact as far as it is linear, 1.5 for a crowned roller.
    damping : float, s/m
        `Contact.damping_for(e, v)` for a coefficient of restitution e at the impact speed v.
    friction : float, -
    transition : float, m/s
        Slip at which friction has reached 71 % of its full size.

    Source: Hunt & Crossley 1975, eq. 12; Norton, Cam Design and Manufacturing Handbook, 2nd ed., ch. 8 to 10.
    """

    name: str
    _: KW_ONLY
    markers: tuple[str, str]
    profile: Any
    roller: float = 0.0
    flanges: Any = None
    stiffness: float
    exponent: float = 1.0
    damping: float = 0.0
    friction: float = 0.0
    transition: float = 1e-3

    table: ClassVar[Table] = Table("CamFollower", ROW, {"apply": apply, "switch": switch}, switches=5)
    strikes: ClassVar[bool] = True

    def __post_init__(self):
        super().__post_init__()
        self.require_marker_pair()
        self.require_positive("stiffness", "transition")
        self.require_positive("roller", "damping", "friction", zero=True)
        check_number(self, "exponent", 1.0, "a number >= 1", "Leave exponent out for a linear penalty")
        _check_flanges(self)
        check_kind(self.profile, Profile, f"{self.title}, profile", "Write profile=Disc(radius=0.03)")
        if self.roller == 0.0 and not self.profile.closed:
            raise ModelError(
                self.title,
                found="a flat face on an open profile",
                expected="a closed profile, whose every side can stand out",
                remedy="Close the profile, or give the radius of a roller",
            )

    def check(self, model) -> None:
        """Raise ModelError if a marker does not exist."""
        for marker in self.markers:
            model.marker(marker, self.title)

    def slip_unit(self, model) -> str:
        """Return m, if there is friction."""
        return "m" if self.friction > 0.0 else ""

    def record(self, compiler):
        """Return the row."""
        a, b = (compiler.marker(name) for name in self.markers)
        table = self.profile.table
        low, high = (-np.inf, np.inf) if self.flanges is None else self.flanges
        return {
            "low": low,
            "high": high,
            "a": a,
            "b": b,
            "pair": compiler.pair(a, b),
            "profile": compiler.bulk(table),
            "numbers": len(table),
        }


def _check_flanges(follower: CamFollower) -> None:
    """Raise ModelError unless the flanges are two places in order, of a roller; store them as a tuple."""
    if follower.flanges is None:
        return
    flanges = finite_array(follower.flanges)
    if flanges.shape != (2,) or not flanges[0] < flanges[1] or follower.roller == 0.0:
        raise ModelError(
            follower.title,
            found=f"flanges = {follower.flanges!r}, roller = {follower.roller!r} m",
            expected="(lowest, highest) place along z of a roller, m",
            remedy="Write flanges=(-0.001, 0.001)",
        )
    object.__setattr__(follower, "flanges", tuple(flanges.tolist()))
