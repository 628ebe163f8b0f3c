"""`LineContact`: a cable or beam against a plane or a cylinder, by penalty."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from typing import ClassVar

import numpy as np

from flexmb.errors import ModelError, did_you_mean
from flexmb.forces.on_coordinate import check_number
from flexmb.forces.on_stretch import check_stretch, require_stretch_name, stretch_points
from flexmb.forces.relative import act_at_point, add_point_tangent
from flexmb.forces.rows import hunt_crossley
from flexmb.math.kernel import inner_kernel
from flexmb.math.switches import DISTANCE, GAP, switch_kernel
from flexmb.math.tables import DAMPED, row_kernel
from flexmb.math.vectors import cross, dot, matvec, matvec_t
from flexmb.model.kinds import Force
from flexmb.model.table import Table

__all__ = ["LineContact"]

AGAINST = ("plane", "cylinder")

ROW = np.dtype(
    [
        ("a", np.int64),
        ("points", np.int64),  # where the stretch begins in the bulk data: marker, pair, length of each
        ("count", np.int64),
        ("against", np.int64),
        ("distance", float),  # m, of the centre line from the plane or the axis where contact begins
        ("stiffness", float),  # N/m^(e + 1)
        ("exponent", float),
        ("damping", float),  # s/m
        ("friction", float),
        ("transition", float),  # m/s
    ],
    align=True,
)


@inner_kernel
def _normal(row, d, n):
    """Write the normal at a point d in the axes of a to `n`; return the distance from the plane or the axis."""
    if row.against == 0:
        n[0], n[1], n[2] = 0.0, 0.0, 1.0
        return d[2]
    length = max((d[0] * d[0] + d[1] * d[1]) ** 0.5, 1e-150)
    n[0], n[1], n[2] = d[0] / length, d[1] / length, 0.0
    return length


@inner_kernel
def _velocity(a, b, d, V):
    """Write the position of b from a, and its velocity relative to what turns with a, to `d` and `V`,
    in the axes of a.
    """
    x = np.empty(3)
    t = np.empty(3)
    for i in range(3):
        x[i] = b.r[i] - a.r[i]
    matvec_t(a.R, x, d)
    cross(a.w, x, t)
    for i in range(3):
        x[i] = b.v[i] - a.v[i] - t[i]
    matvec_t(a.R, x, V)


@inner_kernel
def _tangent(row, distance, n, V, slip, force, slope, damping, K, C):
    """Write -dF/dd and -dF/dV to `K` and `C` (3, 3); see `apply` for the symbols.

    With q = sqrt(slip^2 + v0^2) and dn = N dd, the force f_n (n - mu slip / q) changes with f_n, n and
    slip.
    """
    mu = row.friction
    q = (dot(slip, slip) + row.transition**2) ** 0.5
    N = np.zeros((3, 3))
    by_d = np.zeros((3, 3))  # of the slip
    VN = np.zeros(3)
    if row.against == 1:
        for i in range(2):
            for j in range(2):
                N[i, j] = ((1.0 if i == j else 0.0) - n[i] * n[j]) / distance
    matvec(N, V, VN)
    across = dot(V, n)
    for i in range(3):
        for j in range(3):
            by_d[i, j] = -n[i] * VN[j] - across * N[i, j]
    for j in range(3):
        along_d, along_V = 0.0, 0.0
        for k in range(3):
            along_d += slip[k] * by_d[k, j]
            along_V += slip[k] * ((1.0 if k == j else 0.0) - n[k] * n[j])
        for i in range(3):
            direction = n[i] - mu * slip[i] / q
            share = mu * force / q
            by_V = (1.0 if i == j else 0.0) - n[i] * n[j]
            K[i, j] = (
                direction * (slope * n[j] + damping * VN[j])
                - force * N[i, j]
                + share * (by_d[i, j] - slip[i] * along_d / (q * q))
            )
            C[i, j] = direction * damping * n[j] + share * (by_V - slip[i] * along_V / (q * q))


@row_kernel
def apply(raw, data, state, work):
    """F_k = w_k f_n (n - mu v_t / sqrt(v_t^2 + v_0^2)), f_n = k p^e (1 + D p') at every point of the stretch.

    eq. (line-contact), in the axes of a; p is the penetration, w_k the length that a point stands for.
    """
    rows = raw.view(ROW)
    d = np.empty(3)
    V = np.empty(3)
    n = np.empty(3)
    slip = np.empty(3)
    f = np.empty(3)
    K = np.empty((3, 3))
    C = np.empty((3, 3))
    tangent = work.weights[0].wanted == 1
    for m in range(rows.shape[0]):
        row = rows[m]
        a = work.markers[row.a]
        for k in range(row.count):
            at = row.points + 3 * k
            b, weight = work.markers[int(data[at])], data[at + 2]
            _velocity(a, b, d, V)
            distance = _normal(row, d, n)
            p = row.distance - distance
            if tangent:
                # most points of a long line touch nothing: their blocks need neither clearing nor adding
                work.pairs[int(data[at + 1])].active = DAMPED if p > 0.0 else 0
            if p <= 0.0:
                continue
            rate = -dot(n, V)
            force, slope, damping, elastic = hunt_crossley(p, rate, weight * row.stiffness, row.exponent, row.damping)
            work.energy[0].potential += elastic * p / (row.exponent + 1.0)
            for i in range(3):
                slip[i] = V[i] + rate * n[i]
            share = row.friction * force / (dot(slip, slip) + row.transition**2) ** 0.5
            for i in range(3):
                f[i] = force * n[i] - share * slip[i]
            work.energy[0].dissipation += (force - elastic) * rate + share * dot(slip, slip)
            act_at_point(a, b, f)
            if tangent:
                _tangent(row, distance, n, V, slip, force, slope, damping, K, C)
                add_point_tangent(work.pairs[int(data[at + 1])], a, b, f, K, C)


@inner_kernel
def _fastest(row, data, work):
    """Return the largest speed, m/s, of the points of the stretch relative to the plane, or to the axis of the
    cylinder: as they turn with it, but for a turn about the axis, which moves no surface.
    """
    a, square = work.markers[row.a], 0.0
    turn = np.empty(3)
    x = np.empty(3)
    t = np.empty(3)
    about = 0.0
    for i in range(3):
        about += a.w[i] * a.R[i, 2]
    for i in range(3):
        turn[i] = a.w[i] - (about * a.R[i, 2] if row.against == 1 else 0.0)
    for k in range(row.count):
        b, one = work.markers[int(data[row.points + 3 * k])], 0.0
        for i in range(3):
            x[i] = b.r[i] - a.r[i]
        cross(turn, x, t)
        for i in range(3):
            one += (b.v[i] - a.v[i] - t[i]) ** 2
        square = max(square, one)
    return square**0.5


@switch_kernel
def switch(raw, data, state, work, out):
    """The gap at every point of the stretch, and the speed of the fastest one."""
    rows = raw.view(ROW)
    d = np.empty(3)
    V = np.empty(3)
    first = 0
    for m in range(rows.shape[0]):
        row = rows[m]
        a = work.markers[row.a]
        fastest = _fastest(row, data, work)
        for k in range(row.count):
            _velocity(a, work.markers[int(data[row.points + 3 * k])], d, V)
            gap = out[first + k]
            gap[:] = 0.0
            gap[7], gap[8], gap[9] = row.distance, fastest, 1.0
            if row.against == 0:
                gap[0], gap[1], gap[4] = GAP, d[2], V[2]
            else:
                gap[0], gap[1], gap[2], gap[4], gap[5] = DISTANCE, d[0], d[1], V[0], V[1]
        first += row.count


@dataclass(frozen=True, eq=False)
class LineContact(Force):
    """Let a stretch of a cable or beam lie on, and slide over, a plane or a cylinder: a belt on a pulley.

    The ground under a rope is a plane.

    At three points of every element the force per length on the line is, eq. (line-contact), ``k p^e (1 + D p')`` along
    the normal, never pulling, and Coulomb's friction against the slip, regularised below the speed `transition`. p is
    the penetration of the centre line, measured from where it comes to lie: on the cylinder's radius plus `offset`. The
    plane is the x-y plane of the marker with the body below it; the axis of the cylinder is z. Lengths refer to the
    line as drawn. `ForceOf` gives the wrench on the body of the marker: the torque of a belt on its pulley.

    Steps end where points begin and cease to touch, and follow their impacts. What touches with less than a tenth of
    the speed of the fastest point of the stretch is passed over, as a belt on a pulley; speeds are relative to the
    plane, or to the axis of the cylinder, with which they turn.

    Parameters
    ----------
    name : str
    stretch : str
        "body.stretch", named in the body's `stretches`.
    marker : str
        "body.marker" of the plane or the cylinder.
    against : "plane" or "cylinder"
    radius : float, m, optional
        Of the cylinder.
    offset : float, m
        Distance between the centre line and the surface in contact: half the thickness of a belt.
    stiffness : float, N/m^(e + 1)
        Force per length of the line and (with the exponent 1) per penetration.
    exponent : float, -
    damping : float, s/m
    friction : float, -
    transition : float, m/s
        Slip at which friction has reached 71 % of its full size; a belt creeps with a part of it where it would stick.

    Source: Leamy & Wasfy 2002 (penalty contact of a belt with friction that depends on the speed of creep); Hunt &
    Crossley 1975, eq. 12 (damping).
    """

    name: str
    _: KW_ONLY
    stretch: str
    marker: str
    against: str = "cylinder"
    radius: float | None = None
    offset: float = 0.0
    stiffness: float
    exponent: float = 1.0
    damping: float = 0.0
    friction: float = 0.0
    transition: float = 1e-3

    table: ClassVar[Table] = Table("LineContact", ROW, {"apply": apply, "switch": switch}, switches="count")

    def __post_init__(self):
        super().__post_init__()
        require_stretch_name(self)
        self.require_positive("stiffness", "transition")
        self.require_positive("offset", "damping", "friction", zero=True)
        check_number(self, "exponent", 1.0, "a number >= 1", "Leave exponent out for a linear penalty")
        if self.against not in AGAINST:
            raise ModelError(
                self.title,
                found=f"against = {self.against!r}",
                expected=f"One of: {', '.join(AGAINST)}",
                remedy=did_you_mean(str(self.against), AGAINST) or "Use 'cylinder'",
            )
        if (self.against == "plane") == (self.radius is not None):
            raise ModelError(
                self.title,
                found=f"against a {self.against}, radius = {self.radius!r}",
                expected="a radius for a cylinder, none for a plane",
                remedy="Give the cylinder's radius, m",
            )
        if self.radius is not None:
            self.require_positive("radius")

    def check(self, model) -> None:
        """Raise ModelError if the stretch or the marker does not exist, or both are on one body."""
        check_stretch(self, model)
        name = self.stretch.partition(".")[0]
        if model.marker(self.marker, self.title)[0].name == name:
            raise ModelError(
                self.title,
                found=f"stretch and marker are both on body '{name}'",
                expected="a marker of another body",
                remedy="A line does not touch itself",
            )

    def record(self, compiler):
        """Return the row."""
        a = compiler.marker(self.marker)
        points, count = stretch_points(self, compiler, lambda b: compiler.pair(a, b))
        return {
            "a": a,
            "points": points,
            "count": count,
            "against": AGAINST.index(self.against),
            "distance": (self.radius or 0.0) + self.offset,
        }
