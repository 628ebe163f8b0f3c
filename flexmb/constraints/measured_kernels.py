"""Kernels of measured scalars: value, time derivatives, push, slope and curvature (see `constraints.measured`).

A scalar z has a *push* p (12,): dz/d(displacement and rotation of a, of b) where z is a position, dz/d(twist of a, of
b) where it is a velocity. A force F on it is the wrench F p. A velocity also has a *slope* s (12,), its derivative by
displacements at twists that are constant in body axes, as velocity-level equations need it. For a rate z = x' of a
position x with gradient g and curvature H = dg/d(...): p = g, and s = H^T twist + what turned twists do, g . (theta x
twist). Theory: eq. (measured-rate).

An acceleration has both, at accelerations of the bodies that stay, and the gradient of a position by the accelerations
of the markers. The wrench of a force has the derivatives that its own kernel writes (`constraints.wrench`).
"""

from __future__ import annotations

import numpy as np

from flexmb.constraints.coordinate import COORDINATE
from flexmb.constraints.coordinate_kernels import add_curvature, measure, second_rate
from flexmb.constraints.rows import add_block, rotating_product
from flexmb.math.kernel import inner_kernel, kernel
from flexmb.math.vectors import add_skew, cross, dot

__all__ = [
    "ACCELERATION",
    "MEASURED",
    "POSITION",
    "REACTION",
    "SIGNAL",
    "VELOCITY",
    "WHATS",
    "add_measured_curvature",
    "measure_scalar",
]

MEASURED = np.dtype(
    [
        ("what", np.int64),  # one of `WHATS`, by number
        ("rate", np.int64),  # 1: the rate of the position
        ("axis", np.int64),  # of a, or of W
        ("other", np.int64),  # cosine: axis of b
        ("signal", np.int64),  # number of the signal, of the branch that is held, of a channel or of an equation
        ("last", np.int64),  # reaction: the equation after the joint's own; wrench: channel of the derivatives
        ("source", np.int64),  # the scalar of which this one has more derivatives, or -1
        ("frame", np.int64),  # acceleration: 1 if velocities of the body are in its own axes
        ("a", np.int64),  # -1: axes of W
        ("b", np.int64),
        ("leg_a", np.int64),  # which leg of an equation belongs to a, or -1
        ("leg_b", np.int64),
        ("c", COORDINATE),
    ],
    align=True,
)
"""How a kernel measures a scalar; every field has eight bytes, so rows of any number may stand in bulk data."""

WHATS = (
    "coordinate",
    "cosine",
    "place",
    "velocity",
    "spin",
    "signal",
    "state",
    "held",
    "acceleration",
    "wrench",
    "reaction",
    "multiplier",
)
_COORDINATE, _COSINE, _PLACE, _VELOCITY, _SPIN, _SIGNAL, _STATE, _HELD = range(8)
_ACCELERATION, _WRENCH, _REACTION, _MULTIPLIER = range(8, 12)
POSITION, VELOCITY, SIGNAL, ACCELERATION, REACTION = range(5)


@inner_kernel
def _along(z, work, n):
    """Write the axis along which a component is taken to `n`, and return if it turns with a marker."""
    n[:] = 0.0
    if z.a < 0:
        n[z.axis] = 1.0
        return False
    for i in range(3):
        n[i] = work.markers[z.a].R[i, z.axis]
    return True


@inner_kernel
def _position(z, state, work, jet, g):
    """Write value, rate and second rate (with markers that do not accelerate) to `jet`, the gradient to `g`."""
    if z.what == _COORDINATE:
        jet[0], jet[1] = measure(z.c, state, work, g)
        jet[2] = second_rate(z.c, work)
        return
    g[:] = 0.0
    b = work.markers[z.b]
    if z.what == _PLACE:
        jet[0], jet[1], jet[2] = b.r[z.axis], b.v[z.axis], 0.0
        g[6 + z.axis] = 1.0
        return
    m, spin, t = np.empty(3), np.zeros(3), np.empty(3)
    if _along(z, work, m):
        spin[:] = work.markers[z.a].w
    e = b.R[:, z.other]
    scratch = np.empty((2, 3))
    cross(m, e, t)
    for i in range(3):  # d(m . e) = theta_a . (m x e) + theta_b . (e x m)
        g[3 + i] = t[i]
        g[9 + i] = -t[i]
    jet[0] = dot(m, e)
    jet[1], jet[2] = rotating_product(m, spin, e, b.w, scratch)


@inner_kernel
def _position_curvature(z, scale, work, K):
    """Add scale dg/d(displacement of a, of b) of a position to `K` (12, 12)."""
    if z.what == _COORDINATE:
        add_curvature(z.c, work, scale, K)
    elif z.what == _COSINE:
        m, e = np.empty(3), work.markers[z.b].R[:, z.other]
        _along(z, work, m)
        zero = np.zeros(3)
        # d(m x e) = (theta_a x m) x e + m x (theta_b x e)
        me = dot(m, e)
        add_block(K, 3, 3, scale, m, e, 0.0)
        add_block(K, 3, 3, -scale * me, zero, zero, 1.0)
        add_block(K, 3, 9, -scale, e, m, 0.0)
        add_block(K, 3, 9, scale * me, zero, zero, 1.0)
        add_block(K, 9, 3, -scale, m, e, 0.0)
        add_block(K, 9, 3, scale * me, zero, zero, 1.0)
        add_block(K, 9, 9, scale, e, m, 0.0)
        add_block(K, 9, 9, -scale * me, zero, zero, 1.0)


@inner_kernel
def _twists(z, work, out):
    """Write the twists of a and b in W to `out` (12,)."""
    for i in range(3):
        out[i] = out[3 + i] = 0.0
    first, b = z.c.a if z.what == _COORDINATE else z.a, work.markers[z.c.b if z.what == _COORDINATE else z.b]
    if first >= 0:
        a = work.markers[first]
        for i in range(3):
            out[i], out[3 + i] = a.v[i], a.w[i]
    for i in range(3):
        out[6 + i], out[9 + i] = b.v[i], b.w[i]


@inner_kernel
def _beyond_velocity(z, state, work, jet, push, slope):
    """`measure_scalar` of an acceleration, a wrench, a reaction or a multiplier."""
    jet[:] = 0.0
    if z.what == _MULTIPLIER:
        jet[0] = state.lam[z.signal]
        return REACTION
    if z.what == _REACTION:
        for n in range(len(work.legs)):
            leg = work.legs[n]
            if leg.marker == z.b and z.signal <= leg.equation < z.last:
                jet[0] += leg.gradient[z.axis] * state.lam[leg.equation]
        return REACTION
    if z.what == _WRENCH:
        jet[0] = work.channels[z.signal, z.axis]
        if z.last >= 0:
            at = z.last + 4 * z.axis
            for i in range(6):
                slope[i], slope[6 + i] = work.channels[at, i], work.channels[at + 1, i]
                push[i], push[6 + i] = work.channels[at + 2, i], work.channels[at + 3, i]
        return VELOCITY
    b, total, t, n = work.markers[z.b], np.empty(3), np.empty(3), np.zeros(3)
    for i in range(3):
        total[i] = b.bias[i]
        for j in range(b.nu):
            total[i] += work.J[b.iJ + i * b.nu + j] * state.a[b.iu + j]
    jet[0] = total[z.axis]
    if z.frame == 1:
        n[z.axis] = 1.0
        cross(total, n, t)  # n . (theta x a) with what stays constant in body axes
        for i in range(3):
            slope[9 + i] = t[i]
        cross(b.v, n, t)  # the bias is w x v, and more by the small Coriolis terms of deformation
        for i in range(3):
            push[9 + i] = t[i]
        cross(n, b.w, t)
        for i in range(3):
            push[6 + i] = t[i]
    return ACCELERATION


@kernel
def measure_scalar(z, state, work, jet, push, slope):
    """Write value and time derivatives to `jet` (3,), push and slope (12,) of a scalar; return its sort.

    The derivatives are those at accelerations of the markers that are zero: of positions the first and the second, of
    velocities the first. Sorts: POSITION, VELOCITY, SIGNAL, ACCELERATION, REACTION.
    """
    push[:] = 0.0
    slope[:] = 0.0
    if z.what == _SIGNAL:
        for k in range(3 - z.rate):
            jet[k] = state.signals[z.signal, z.rate + k]
        if z.rate == 1:
            jet[2] = 0.0
        return SIGNAL
    if z.what == _HELD:
        jet[0], jet[1], jet[2] = state.q[len(state.q) - len(work.branches) + z.signal], 0.0, 0.0
        return SIGNAL
    if z.what == _STATE:
        b = work.markers[z.b]
        jet[0], jet[1], jet[2] = b.v[z.axis] if z.axis < 3 else b.w[z.axis - 3], 0.0, 0.0
        push[6 + z.axis] = 1.0
        return VELOCITY
    if z.what < _VELOCITY:
        _position(z, state, work, jet, push)
        if z.rate == 0:
            return POSITION
        jet[0], jet[1], jet[2] = jet[1], jet[2], 0.0
        K, twist = np.zeros((12, 12)), np.empty(12)
        _position_curvature(z, 1.0, work, K)
        _twists(z, work, twist)
        for j in range(12):
            for i in range(12):
                slope[j] += twist[i] * K[i, j]
        t = np.empty(3)
        for at in range(0, 12, 3):  # p . (theta x twist) = theta . (twist x p)
            cross(twist[at : at + 3], push[at : at + 3], t)
            turned = 3 if at < 6 else 9
            for i in range(3):
                slope[turned + i] += t[i]
        return VELOCITY
    if z.what >= _ACCELERATION:
        return _beyond_velocity(z, state, work, jet, push, slope)
    n, t = np.empty(3), np.empty(3)
    turns = _along(z, work, n)
    b = work.markers[z.b]
    x = b.v if z.what == _VELOCITY else b.w
    first = 6 if z.what == _VELOCITY else 9
    cross(x, n, t)
    for i in range(3):
        push[first + i] = n[i]
        slope[9 + i] = t[i]  # n . (theta_b x x)
    jet[0], jet[1], jet[2] = dot(n, x), 0.0, 0.0
    if turns:
        cross(n, x, t)
        for i in range(3):
            slope[3 + i] += t[i]  # (theta_a x n) . x
        jet[1] = dot(work.markers[z.a].w, t)
    return VELOCITY


@kernel
def add_measured_curvature(z, scale, work, K):
    """Add scale dp/d(displacement of a, of b) of the push of a scalar to `K` (12, 12)."""
    if z.what < _VELOCITY:
        _position_curvature(z, scale, work, K)
    elif z.what < _SIGNAL and z.a >= 0:
        n = work.markers[z.a].R[:, z.axis]
        add_skew(K, 6 if z.what == _VELOCITY else 9, 3, -scale, n)  # theta_a x n
