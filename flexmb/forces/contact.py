"""`Contact`: a sphere against a plane, a sphere, a cylinder, or inside a socket or a bore, by penalty."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from typing import ClassVar

import numpy as np

from flexmb.errors import ModelError, did_you_mean
from flexmb.forces.on_coordinate import check_number
from flexmb.forces.relative import act_relative, add_relative_tangent, relative_motion
from flexmb.forces.rows import hunt_crossley
from flexmb.math.kernel import inner_kernel
from flexmb.math.switches import DISTANCE, GAP, IDLE, SLIP, switch_kernel
from flexmb.math.tables import row_kernel
from flexmb.math.vectors import cross, dot
from flexmb.model.described import is_number
from flexmb.model.kinds import Force
from flexmb.model.table import Table

__all__ = ["Contact"]

AGAINST = ("plane", "sphere", "cylinder", "socket", "bore")
HOLLOW = ("socket", "bore")
"""Those around the sphere."""

ROW = np.dtype(
    [
        ("a", np.int64),
        ("b", np.int64),
        ("pair", np.int64),
        ("against", np.int64),
        ("radius", float),  # m, of the sphere at b
        ("other", float),  # m, of the sphere or cylinder at a
        ("stiffness", float),  # N/m^e
        ("exponent", float),
        ("damping", float),  # s/m
        ("friction", float),
        ("transition", float),  # m/s
    ],
    align=True,
)


@inner_kernel
def _normal(row, d, n, N):
    """Write the normal at the contact and its derivative dn/dd to `n`, `N`; return the penetration."""
    N[:] = 0.0
    if row.against == 0:
        n[0], n[1], n[2] = 0.0, 0.0, 1.0
        return row.radius - d[2]
    for i in range(3):
        n[i] = d[i]
    if row.against == 2 or row.against == 4:
        n[2] = 0.0
    length = max(dot(n, n) ** 0.5, 1e-150)
    sense = 1.0 if row.against < 3 else -1.0  # in a hollow the normal points inwards
    for i in range(3):
        n[i] *= sense / length
    for i in range(3):
        for j in range(3):
            N[i, j] = -sense * n[i] * n[j] / length
        if i < 2 or row.against == 1 or row.against == 3:
            N[i, i] += sense / length
    return row.radius + sense * (row.other - length)


@inner_kernel
def _tangent(row, V, w, n, N, slip, f, fp, fr, f_t, K, C):
    """Write -df/d(d, psi) and -df/d(d', w) to `K` and `C` (6, 6); see `apply` for the symbols."""
    mu, r = row.friction, row.radius
    q = (dot(slip, slip) + row.transition**2) ** 0.5
    u = np.empty(3)
    cross(w, n, u)
    for i in range(3):
        u[i] = V[i] - r * u[i]
    un = dot(u, n)
    K[:] = 0.0
    C[:] = 0.0
    dn = np.empty(3)
    du = np.empty(3)
    ds = np.empty(3)
    dF = np.empty(3)
    t = np.empty(3)
    e = np.zeros(3)
    for j in range(9):  # d, d' and w, one component after another
        e[:] = 0.0
        e[j % 3] = 1.0
        dn[:] = 0.0
        du[:] = 0.0
        if j < 3:
            for i in range(3):
                dn[i] = N[i, j]
            cross(w, dn, t)
            for i in range(3):
                du[i] = -r * t[i]
            force = -fp * n[j] - fr * dot(V, dn)
        elif j < 6:
            du[j - 3] = 1.0
            force = -fr * n[j - 3]
        else:
            cross(e, n, t)
            for i in range(3):
                du[i] = -r * t[i]
            force = 0.0
        dun = dot(du, n) + dot(u, dn)
        for i in range(3):
            ds[i] = du[i] - dun * n[i] - un * dn[i]
        along = dot(slip, ds)
        for i in range(3):
            dF[i] = -mu * (force * slip[i] + f * (ds[i] - slip[i] * along / (q * q))) / q
        cross(n, dF, t)
        cross(dn, f_t, e)
        for i in range(3):
            total = force * n[i] + f * dn[i] + dF[i]
            moment = -r * (t[i] + e[i])
            if j < 3:
                K[i, j] = -total
                K[3 + i, j] = -moment
            else:
                C[i, j - 3] = -total
                C[3 + i, j - 3] = -moment


@row_kernel
def apply(raw, data, state, work):
    """f = k p^e (1 + D p') n - mu f v_t / sqrt(v_t^2 + v_0^2) at the contact, eq. (contact); all in the axes of a.

    p is the penetration, n the normal from a to b, v_t = (I - n n^T) (d' - r w x n) the slip.
    """
    rows = raw.view(ROW)
    motion = np.empty(9)
    Q = np.empty((3, 3))
    n = np.empty(3)
    N = np.empty((3, 3))
    slip = np.empty(3)
    f_t = np.empty(3)
    t = np.empty(3)
    f = np.empty(6)
    K = np.empty((6, 6))
    C = np.empty((6, 6))
    for m in range(rows.shape[0]):
        row = rows[m]
        a, b = work.markers[row.a], work.markers[row.b]
        relative_motion(a, b, motion, Q)
        p = _normal(row, motion[0:3], n, N)
        if p <= 0.0:
            continue
        V, w = motion[3:6], motion[6:9]
        rate = -dot(n, V)
        force, slope, damping, elastic = hunt_crossley(p, rate, row.stiffness, row.exponent, row.damping)
        work.energy[0].potential += elastic * p / (row.exponent + 1.0)
        cross(w, n, t)
        for i in range(3):
            slip[i] = V[i] + rate * n[i] - row.radius * t[i]
        share = row.friction * force / (dot(slip, slip) + row.transition**2) ** 0.5
        for i in range(3):
            f_t[i] = -share * slip[i]
            f[i] = force * n[i] + f_t[i]
        cross(n, f_t, t)
        for i in range(3):
            f[3 + i] = -row.radius * t[i]
        work.energy[0].dissipation += (force - elastic) * rate - dot(f_t, slip)
        act_relative(a, b, f)
        if work.weights[0].wanted == 1:
            _tangent(row, V, w, n, N, slip, force, slope, damping, f_t, K, C)
            add_relative_tangent(work.pairs[row.pair], a, b, f, K, C)


@switch_kernel
def switch(raw, data, state, work, out):
    """The gap between the surfaces, and the slip where they touch."""
    rows = raw.view(ROW)
    motion = np.empty(9)
    Q = np.empty((3, 3))
    n = np.empty(3)
    N = np.empty((3, 3))
    t = np.empty(3)
    for m in range(rows.shape[0]):
        row = rows[m]
        relative_motion(work.markers[row.a], work.markers[row.b], motion, Q)
        p = _normal(row, motion[0:3], n, N)
        gap, slip = out[2 * m], out[2 * m + 1]
        gap[:] = 0.0
        slip[:] = 0.0
        gap[9] = 1.0
        gap[7] = row.radius + (row.other if row.against > 0 else 0.0)
        if row.against == 0:
            gap[0], gap[1], gap[4] = GAP, motion[2], motion[5]
        elif row.against > 2:
            gap[0], gap[1], gap[4], gap[7] = GAP, -p, dot(n, motion[3:6]), 0.0
        else:
            gap[0] = DISTANCE
            gap[1:7] = motion[0:6]
            if row.against == 2:
                gap[3], gap[6] = 0.0, 0.0
        slip[0] = SLIP if p > 0.0 and row.friction > 0.0 else IDLE
        rate = dot(n, motion[3:6])
        cross(motion[6:9], n, t)
        for i in range(3):
            slip[4 + i] = motion[3 + i] - rate * n[i] - row.radius * t[i]
        slip[8] = row.transition


@dataclass(frozen=True, eq=False)
class Contact(Force):
    """Let a sphere around marker b touch a plane, sphere or cylinder of marker a, or a wall around it, eq. (contact).

    The normal force of a penetration p is ``stiffness p^exponent (1 + damping p')``, never pulling (Hertz; Hunt &
    Crossley); friction is Coulomb's, regularised below the speed `transition`. The plane is the x-y plane of marker a
    with the body below it; the axis of the cylinder is z. Inside a "socket" (a hollow sphere) or a "bore" (a hollow
    cylinder) the sphere has the clearance ``other_radius - radius``: a ball joint or a journal with play; a long
    journal is two contacts, at its ends. Steps end where a contact begins and ends, and resolve what is between.

    Parameters
    ----------
    name : str
    markers : (str, str)
        Marker a of the plane, sphere or cylinder; marker b, the centre of the sphere.
    radius : float, m
        Of the sphere at b.
    against : "plane", "sphere", "cylinder", "socket" or "bore"
    other_radius : float, m, optional
        Of what is at a.
    stiffness : float, N/m^e
        See `Contact.hertz_stiffness`.
    exponent : float, -
        1.5 for Hertzian contact.
    damping : float, s/m
        `Contact.damping_for(e, v)` for a coefficient of restitution e at the impact speed v; 3/2 (1 - e) / v near 1.
        The law of Lankarani & Nikravesh (1990) is 3/4 (1 - e^2) / v.
    friction : float, -
    transition : float, m/s
        Slip at which friction has reached 71 % of its full size.

    Source: Johnson, Contact Mechanics, ch. 4; Hunt & Crossley 1975, eq. 12.
    """

    name: str
    _: KW_ONLY
    markers: tuple[str, str]
    radius: float
    against: str = "plane"
    other_radius: float | None = None
    stiffness: float
    exponent: float = 1.5
    damping: float = 0.0
    friction: float = 0.0
    transition: float = 1e-3

    table: ClassVar[Table] = Table("Contact", ROW, {"apply": apply, "switch": switch}, switches=2)
    strikes: ClassVar[bool] = True

    def __post_init__(self):
        super().__post_init__()
        self.require_marker_pair()
        self.require_positive("radius", "stiffness", "transition")
        self.require_positive("damping", "friction", zero=True)
        check_number(self, "exponent", 1.0, "a number >= 1", "Use 1.5 for Hertzian contact")
        if self.against not in AGAINST:
            raise ModelError(
                self.title,
                found=f"against = {self.against!r}",
                expected=f"One of: {', '.join(AGAINST)}",
                remedy=did_you_mean(str(self.against), AGAINST) or "Use 'plane'",
            )
        if (self.against == "plane") == (self.other_radius is not None):
            raise ModelError(
                self.title,
                found=f"against a {self.against}, other_radius = {self.other_radius!r}",
                expected="other_radius for all but a plane",
                remedy="Give the radius at marker a as other_radius, m",
            )
        if self.other_radius is not None:
            self.require_positive("other_radius")
            if self.against in HOLLOW and self.other_radius <= self.radius:
                raise ModelError(
                    self.title,
                    found=f"a sphere of {self.radius:.6g} m in a {self.against} of {self.other_radius:.6g} m",
                    expected="an other_radius larger than radius: the difference is the clearance",
                    remedy="Without clearance use a Spherical or a Revolute joint",
                )

    @staticmethod
    def damping_for(restitution: float, speed: float) -> float:
        """Return the damping, s/m, with which a body bounces back at `restitution` times its impact `speed`, m/s.

        Of ``m v dv = -k p^n (1 + c v) dp`` from speed v to zero and back to e v follows, whatever the exponent,
        ``c (1 + e) v = ln((1 + c v) / (1 - c e v))``; near e = 1 that is c v = 3/2 (1 - e) (Hunt & Crossley 1975).
        """
        if not is_number(restitution) or not 0.0 < restitution <= 1.0 or not is_number(speed) or speed <= 0.0:
            raise ModelError(
                "Contact",
                found=f"restitution = {restitution!r} at the speed {speed!r} m/s",
                expected="0 < restitution <= 1, speed > 0",
                remedy="Write Contact.damping_for(0.6, 2.0)",
            )
        e, low, high = float(restitution), 0.0, 1.0 / float(restitution)
        if e > 1.0 - 1e-6:
            return 1.5 * (1.0 - e) / speed
        for _ in range(200):  # the right side grows without bound towards c v = 1 / e
            middle = 0.5 * (low + high)
            more = np.log1p(middle) - np.log1p(-e * middle) < (1.0 + e) * middle
            low, high = (middle, high) if more else (low, middle)
        return 0.5 * (low + high) / float(speed)

    @staticmethod
    def hertz_stiffness(radius: float, material, other_radius: float = np.inf, other_material=None) -> float:
        """Return 4/3 E* sqrt(R*), N/m^1.5, of two spheres (or a sphere on a half-space), 1/R* = 1/R + 1/R'.

        In a socket R' is negative. Where the clearance is small beside the radius, the patch grows so large that Hertz'
        theory is too stiff.

        Parameters
        ----------
        radius, other_radius : float, m
        material, other_material : Material
            One material unless a second is given; 1/E* = (1 - nu^2)/E + (1 - nu'^2)/E'.
        """
        second = other_material or material
        compliance = sum((1.0 - m.poisson**2) / m.young for m in (material, second))
        curvature = 1.0 / radius + 1.0 / other_radius
        if not curvature > 0.0:
            raise ModelError(
                "Contact",
                found=f"radii of {radius!r} and {other_radius!r} m, which fit without clearance",
                expected="1/radius + 1/other_radius > 0",
                remedy="The radius of a socket is negative, and larger than its ball's",
            )
        return 4.0 / 3.0 / compliance * curvature**-0.5

    def check(self, model) -> None:
        """Raise ModelError if a marker does not exist."""
        for marker in self.markers:
            model.marker(marker, self.title)

    def slip_unit(self, model) -> str:
        """Return m, if there is friction."""
        return "m" if self.friction > 0.0 else ""

    def depth_of_ball(self, gap: np.ndarray) -> tuple[float, float]:
        """Return the penetration, m, of its switch, and the distance of the markers where there must be one."""
        if gap[0] == DISTANCE:
            way = float(np.linalg.norm(gap[1:4]))
            return float(gap[7]) - way, way
        return float(gap[7] - gap[1]), np.inf

    def record(self, compiler):
        """Return the row."""
        a, b = (compiler.marker(name) for name in self.markers)
        return {
            "a": a,
            "b": b,
            "pair": compiler.pair(a, b),
            "against": AGAINST.index(self.against),
            "other": self.other_radius or 0.0,
        }
