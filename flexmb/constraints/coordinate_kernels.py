"""Coordinates: one scalar that two markers have, a turn, a slide or a distance, with its derivatives.

Drives, couplers, springs, stops, friction and actuators all act on a coordinate x of markers a and b. With its gradient
g = dx/d(displacement and rotation of a, of b), a force F on the coordinate is the wrench ``F g``, its rate is ``g``
times the twists, and the tangent of the wrench is ``-dF/dx g g^T - F H`` with the curvature H = dg/d(...).
Theory: eq. (coordinate-turn), (coordinate-slide) and (coordinate-distance).
"""

from __future__ import annotations

import numpy as np

from flexmb.constraints.coordinate import COORDINATE, SLIDE, TURN, Coordinate
from flexmb.constraints.rows import add_block, centripetal, rotating_product
from flexmb.errors import ModelError, did_you_mean
from flexmb.math.kernel import kernel
from flexmb.math.tables import row_kernel
from flexmb.math.vectors import add_skew, cross, dot, norm
from flexmb.model.table import Table

__all__ = [
    "FOLLOWED",
    "act",
    "add_curvature",
    "add_tangent",
    "joint_coordinate",
    "measure",
    "second_rate",
    "turn_or_length",
]


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
    if c.kind == TURN:
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
    elif c.kind == SLIDE:
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


@kernel
def turn_or_length(c, state, work):
    """Return the coordinate alone, see `measure`: without memory of its own, for what reads it in every evaluation."""
    a, b = work.markers[c.a], work.markers[c.b]
    if c.kind == TURN:
        e = b.R[:, c.axis]
        x = c.sign * np.arctan2(dot(a.R[:, 1], e), dot(a.R[:, 0], e))
        if c.branch >= 0:
            near = state.q[len(state.q) - len(work.branches) + c.branch]
            x += 2.0 * np.pi * np.round((near - x) / (2.0 * np.pi))
            work.branches[c.branch] = x
        return x
    x, y, z = b.r[0] - a.r[0], b.r[1] - a.r[1], b.r[2] - a.r[2]
    if c.kind == SLIDE:
        n = a.R[:, c.axis]
        return c.sign * (n[0] * x + n[1] * y + n[2] * z)
    return max((x * x + y * y + z * z) ** 0.5, 1e-150)


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
    if c.kind == TURN:
        x_a, y_a, e = a.R[:, 0], a.R[:, 1], b.R[:, c.axis]
        sine, cosine = dot(y_a, e), dot(x_a, e)
        r2 = sine * sine + cosine * cosine
        ds, dds = rotating_product(y_a, a.w, e, b.w, scratch)
        dc, ddc = rotating_product(x_a, a.w, e, b.w, scratch)
        turn = (cosine * ds - sine * dc) / r2
        return c.sign * (cosine * dds - sine * ddc - 2.0 * turn * (sine * ds + cosine * dc)) / r2
    if c.kind == SLIDE:
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
    if c.kind == TURN:
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
    elif c.kind == SLIDE:
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


def joint_coordinate(joint, asker: str, freedom: str | None = None, kind: str | None = None) -> Coordinate:
    """Return the coordinate of a freedom that a joint permits.

    Parameters
    ----------
    joint : Joint
    asker : str
        Title of the part that asks, for messages.
    freedom : str, optional
        Its word: "turn", "turn_b", "slide", "slide_x" or "slide_y".
        By default the first turn that the joint permits, or its first slide.
    kind : "turn" or "slide", optional
        What the freedom must be.
    """
    offered = sorted(
        (f for f in joint.coordinates if f.word), key=lambda f: (f.word.partition("_")[0] != "turn", f.word)
    )
    known = {f.word: f for f in offered if kind is None or f.word.startswith(kind)}
    if freedom is None and known:
        return next(iter(known.values())).coordinate
    if freedom not in known:
        what = f"{type(joint).__name__} permits no {freedom or kind or 'turn or slide'}"
        permitted = ", ".join(str(f) for f in joint.permits) or "nothing"
        raise ModelError(
            asker,
            found=f"joint '{joint.name}' ({what})",
            expected=f"one of: {', '.join(known)}" if known else f"a {kind or 'turn or slide'}",
            remedy=did_you_mean(str(freedom), known) or f"Name another joint; this one permits {permitted}",
        )
    return known[freedom].coordinate
