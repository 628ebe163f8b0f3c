"""Coordinates: one scalar that two markers have, a turn, a slide or a distance, with its derivatives.

Drives, couplers, springs, stops, friction and actuators all act on a coordinate x of markers a and b. With its gradient
g = dx/d(displacement and rotation of a, of b), a force F on the coordinate is the wrench ``F g``, its rate is ``g``
times the twists, and the tangent of the wrench is ``-dF/dx g g^T - F H`` with the curvature H = dg/d(...).
Theory: eq. (coordinate-turn), (coordinate-slide) and (coordinate-distance).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from flexmb.constraints.freedoms import Slide, Turn, TurnOfSecond
from flexmb.constraints.rows import add_block, add_skew, centripetal, rotating_product
from flexmb.errors import ModelError, did_you_mean
from flexmb.math.kernel import kernel
from flexmb.math.tables import DAMPED, row_kernel
from flexmb.math.vectors import cross, dot, norm
from flexmb.model.kinds import Table

__all__ = [
    "COORDINATE",
    "FOLLOWED",
    "FREEDOMS",
    "Coordinate",
    "act",
    "add_curvature",
    "add_tangent",
    "joint_coordinate",
    "measure",
    "second_rate",
]

COORDINATE = np.dtype(
    [
        ("kind", np.int64),  # 0 turn, 1 slide, 2 distance
        ("axis", np.int64),  # turn: axis of b that is followed; slide: axis of a
        ("sign", float),  # -1 where the markers are exchanged
        ("a", np.int64),
        ("b", np.int64),
        ("pair", np.int64),
        ("branch", np.int64),  # number of the branch coordinate that counts full turns, or -1
    ],
    align=True,
)
"""How a kernel measures a coordinate."""

FREEDOMS: dict[str, Any] = {
    "turn": Turn("z"),
    "turn_b": TurnOfSecond("z"),
    "slide": Slide("z"),
    "slide_x": Slide("x"),
    "slide_y": Slide("y"),
}
"""Names of the freedoms of joints that have a coordinate."""


@kernel
def measure(c, state, work, g):
    """Return coordinate and rate, write its gradient to `g` (12,).

    Turn: theta = atan2(s, c), s = y_a . e, c = x_a . e with e an axis of b, continuous through full turns where the row
    has a branch. Slide: n . d with n an axis of a, d = r_b - r_a. Distance: |d|.
    """
    a, b = work.markers[c.a], work.markers[c.b]
    d = np.empty(3)
    t = np.empty(3)
    g[:] = 0.0
    for i in range(3):
        d[i] = b.r[i] - a.r[i]
    if c.kind == 0:
        x_a, y_a, e = a.R[:, 0], a.R[:, 1], b.R[:, c.axis]
        sine, cosine = dot(y_a, e), dot(x_a, e)
        scale = c.sign / (sine * sine + cosine * cosine)
        for i in range(3):
            d[i] = scale * (cosine * y_a[i] - sine * x_a[i])
        cross(d, e, t)
        for i in range(3):
            g[3 + i] = t[i]
            g[9 + i] = -t[i]
        x = c.sign * np.arctan2(sine, cosine)
        if c.branch >= 0:
            near = state.q[len(state.q) - len(work.branches) + c.branch]
            x += 2.0 * np.pi * np.round((near - x) / (2.0 * np.pi))
            work.branches[c.branch] = x
    elif c.kind == 1:
        n = a.R[:, c.axis]
        x = c.sign * dot(n, d)
        cross(n, d, t)
        for i in range(3):
            g[i] = -c.sign * n[i]
            g[3 + i] = c.sign * t[i]
            g[6 + i] = c.sign * n[i]
    else:
        x = max(norm(d), 1e-150)
        for i in range(3):
            g[6 + i] = d[i] / x
            g[i] = -g[6 + i]
    rate = dot(g[0:3], a.v) + dot(g[3:6], a.w) + dot(g[6:9], b.v) + dot(g[9:12], b.w)
    return x, rate


@row_kernel
def follow(raw, data, state, work):
    """Count the turns of coordinates that a sensor reads; they exert nothing."""
    rows = raw.view(COORDINATE)
    g = np.empty(12)
    for n in range(rows.shape[0]):
        measure(rows[n], state, work, g)


FOLLOWED = Table("FollowedTurn", COORDINATE, {"apply": follow})
"""Turns of joints that only a sensor reads."""


@kernel
def second_rate(c, work):
    """Return x'' at accelerations of the markers that are zero."""
    a, b = work.markers[c.a], work.markers[c.b]
    d = np.empty(3)
    rate = np.empty(3)
    swing = np.empty(3)
    scratch = np.empty((2, 3))
    for i in range(3):
        d[i] = b.r[i] - a.r[i]
        rate[i] = b.v[i] - a.v[i]
    if c.kind == 0:
        x_a, y_a, e = a.R[:, 0], a.R[:, 1], b.R[:, c.axis]
        sine, cosine = dot(y_a, e), dot(x_a, e)
        r2 = sine * sine + cosine * cosine
        ds, dds = rotating_product(y_a, a.w, e, b.w, scratch)
        dc, ddc = rotating_product(x_a, a.w, e, b.w, scratch)
        turn = (cosine * ds - sine * dc) / r2
        return c.sign * (cosine * dds - sine * ddc - 2.0 * turn * (sine * ds + cosine * dc)) / r2
    if c.kind == 1:
        n = a.R[:, c.axis]
        centripetal(a.w, n, swing)
        second = dot(swing, d)
        cross(a.w, n, swing)
        return c.sign * (second + 2.0 * dot(swing, rate))
    length = max(norm(d), 1e-150)
    along = dot(d, rate) / length
    return (dot(rate, rate) - along * along) / length


@kernel
def act(c, work, g, force):
    """Let the force on the coordinate act on both markers."""
    a, b = work.markers[c.a], work.markers[c.b]
    for i in range(6):
        a.wrench[i] += force * g[i]
        b.wrench[i] += force * g[6 + i]


@kernel
def add_curvature(c, work, scale, K):
    """Add scale * H to `K` (12, 12)."""
    a, b = work.markers[c.a], work.markers[c.b]
    d = np.empty(3)
    zero = np.zeros(3)
    for i in range(3):
        d[i] = b.r[i] - a.r[i]
    if c.kind == 0:
        x_a, y_a, e = a.R[:, 0], a.R[:, 1], b.R[:, c.axis]
        sine, cosine = dot(y_a, e), dot(x_a, e)
        r2 = sine * sine + cosine * cosine
        S, C, p, n, s = np.empty(3), np.empty(3), np.empty(3), np.empty(3), np.empty(3)
        cross(y_a, e, S)
        cross(x_a, e, C)
        for i in range(3):
            p[i] = cosine * y_a[i] - sine * x_a[i]
            n[i] = (cosine * S[i] - sine * C[i]) / r2
            s[i] = 2.0 * (sine * S[i] + cosine * C[i])
        k = scale * c.sign / r2
        for i in range(3):
            for j in range(3):
                change = S[i] * C[j] - C[i] * S[j] - n[i] * s[j]
                by_a = k * (change + p[i] * e[j])
                by_b = -k * (change + e[i] * p[j])
                K[3 + i, 3 + j] += by_a
                K[3 + i, 9 + j] += by_b
                K[9 + i, 3 + j] -= by_a
                K[9 + i, 9 + j] -= by_b
    elif c.kind == 1:
        n = a.R[:, c.axis]
        k = scale * c.sign
        add_skew(K, 0, 3, k, n)
        add_skew(K, 6, 3, -k, n)
        add_skew(K, 3, 0, -k, n)
        add_skew(K, 3, 6, k, n)
        add_block(K, 3, 3, k, n, d, -dot(n, d))
    else:
        length = max(norm(d), 1e-150)
        k = scale / length
        for i in range(3):
            zero[i] = d[i] / length
        for row in (0, 6):
            for column in (0, 6):
                sign = k if row == column else -k
                add_block(K, row, column, -sign, zero, zero, -1.0)


@kernel
def add_tangent(c, work, g, force, stiffness, damping):
    """Add the tangent of a force on the coordinate; stiffness = -dF/dx, damping = -dF/dx'."""
    pair = work.pairs[c.pair]
    for i in range(12):
        for j in range(12):
            pair.K[i, j] += stiffness * g[i] * g[j]
            pair.D[i, j] += damping * g[i] * g[j]
    add_curvature(c, work, -force, pair.K)


@dataclass(frozen=True)
class Coordinate:
    """What is measured between two markers: a turn about z, a slide along an axis of a, or a distance.

    Parameters
    ----------
    kind : "turn", "slide" or "distance"
    axis : "x", "y" or "z"
        Turn: the axis of b whose direction is followed. Slide: the axis of a.
    swapped : bool
        Measured from b to a with opposite sign: the turn about the z-axis of b.
    """

    kind: str
    axis: str = "x"
    swapped: bool = False

    @classmethod
    def of(cls, freedom) -> Coordinate:
        """Return the coordinate of a primitive freedom."""
        if isinstance(freedom, Slide):
            return cls("slide", freedom.axis)
        if isinstance(freedom, TurnOfSecond):
            return cls("turn", "z", swapped=True)
        return cls("turn", freedom.to)

    @property
    def unit(self) -> str:
        """Return rad or m."""
        return "rad" if self.kind == "turn" else "m"

    def branch(self, a: str, b: str) -> str:
        """Return the name of the branch that counts the full turns between two markers."""
        return f"turn {'back' if self.swapped else 'on'} {self.axis}: {a}, {b}"

    def value(self, compiler, a: int, b: int) -> float:
        """Return the coordinate of markers a and b as described."""
        (r_a, R_a), (r_b, R_b) = (compiler.pose(m) for m in ((b, a) if self.swapped else (a, b)))
        if self.kind == "distance":
            return float(np.linalg.norm(r_b - r_a))
        if self.kind == "slide":
            return float(R_a[:, "xyz".index(self.axis)] @ (r_b - r_a))
        e = R_b[:, "xyz".index(self.axis)]
        return float(np.arctan2(R_a[:, 1] @ e, R_a[:, 0] @ e)) * (-1.0 if self.swapped else 1.0)

    def record(self, compiler, a: int, b: int, counts: bool = True, writes: int = DAMPED) -> tuple:
        """Return the row of the coordinate; with `counts`, turns are followed through full turns.

        `writes` says whether the kernel adds stiffness (STIFF) or also damping (DAMPED) to the pair of markers; 0:
        neither.
        """
        branch = -1
        if counts and self.kind == "turn":
            name = self.branch(compiler.marker_name(a), compiler.marker_name(b))
            branch = compiler.branch(name, self.value(compiler, a, b))
        first, second = (b, a) if self.swapped else (a, b)
        kind = ("turn", "slide", "distance").index(self.kind)
        sign = -1.0 if self.swapped else 1.0
        pair = compiler.pair(first, second, writes) if writes else -1
        return (kind, "xyz".index(self.axis), sign, first, second, pair, branch)


def joint_coordinate(joint, asker: str, freedom: str | None = None, kind: str | None = None) -> Coordinate:
    """Return the coordinate of a freedom that a joint permits.

    Parameters
    ----------
    joint : Joint
    asker : str
        Title of the part that asks, for messages.
    freedom : one of `FREEDOMS`, optional
        By default the first turn that the joint permits, or its first slide.
    kind : "turn" or "slide", optional
        What the freedom must be.
    """
    known = {
        name: match
        for name, wanted in FREEDOMS.items()
        for match in joint.coordinates
        if type(match) is type(wanted) and match.axis == wanted.axis and (kind is None or name.startswith(kind))
    }
    if freedom is None and known:
        return Coordinate.of(next(iter(known.values())))
    if freedom not in known:
        what = f"{type(joint).__name__} permits no {freedom or kind or 'turn or slide'}"
        permitted = ", ".join(str(f) for f in joint.permits) or "nothing"
        raise ModelError(
            asker,
            found=f"joint '{joint.name}' ({what})",
            expected=f"one of: {', '.join(known)}" if known else f"a {kind or 'turn or slide'}",
            remedy=did_you_mean(str(freedom), known) or f"Name another joint; this one permits {permitted}",
        )
    return Coordinate.of(known[freedom])
