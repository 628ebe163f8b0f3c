"""Rigid links by constants and numbers of a state: where each one is in its parent, how it moves, its own inertia.

Each link has a frame on its joint. Where the joint has one freedom, the z-axis of that frame is the axis of motion; a
ball or a free frame moves freely about or with its frame. Joints of two or more slides and turns are several links, of
which the last one carries the body. Source: Featherstone 2008, section 4.4.
"""

from __future__ import annotations

import numpy as np

from flexmb.math.kernel import inner_kernel, kernel
from flexmb.math.rotations import euler_to_matrix

__all__ = [
    "BALL",
    "BIAS",
    "BLOCK",
    "COUPLING",
    "DIVISOR",
    "DRIVE",
    "FIXED",
    "FORCE",
    "FRAME",
    "GAIN",
    "INERTIA",
    "LINK",
    "LOAD",
    "MOMENT",
    "RATE",
    "SCRATCH",
    "SINGLE",
    "SPEED",
    "SWING",
    "TURN",
    "WAY",
    "carry",
    "place_links",
    "reach_axes",
    "read_axes",
]

FIXED, SINGLE, BALL, FRAME = -1, 1, 3, 6
"""Kinds of links, by their number of freedoms."""

LINK = np.dtype(
    [
        ("parent", np.int64),  # place of the parent, -1: the ground
        ("kind", np.int64),  # FIXED, SINGLE, BALL or FRAME
        ("coordinate", np.int64),  # place of its first coordinate
        ("rate", np.int64),  # place of its first rate
        ("driven", np.int64),  # 1: the second rate is given
        ("body", np.int64),  # place of the body that it carries, or helps to carry, in the order of the tree
        ("block", np.int64),  # place of its factor, for several freedoms
        ("sign", float),  # -1.0 where the tree goes through the joint backwards
        ("turn", float),  # 1.0: turns about z
        ("slide", float),  # 1.0: slides along z; m/rad of a screw
        ("R", float, (3, 3)),  # axes at coordinate zero, in axes of the parent's frame
        ("r", float, 3),  # m, origin at coordinate zero, there
        ("mass", float),  # kg
        ("h", float, 3),  # kg m, first moment about the origin, in link axes
        ("J", float, 6),  # kg m2, xx xy xz yy yz zz about the origin, in link axes
    ],
    align=True,
)

# Places in the scratch row of a link; vectors are (angular, linear) in link axes.
TURN, WAY, SPEED, SWING, BIAS, FORCE, RATE, DIVISOR, DRIVE = 0, 9, 12, 18, 24, 30, 36, 42, 43
MOMENT, COUPLING, INERTIA = 44, 50, 59  # J (6,), H (9,), M (6,)
SCRATCH = 66

# Places in the row of a link of several freedoms.
LOAD, GAIN = 36, 42  # after the Cholesky factor of the leading block (n, n): its load, H^T J^-1 (3, 3)
BLOCK = 52


@inner_kernel
def _place(link, row, q, Q):
    """Write the axes R and the origin r of a link in its parent at coordinates q."""
    at = link.coordinate
    if link.kind == BALL or link.kind == FRAME:
        if link.kind == FRAME:
            row[WAY], row[WAY + 1], row[WAY + 2] = q[at], q[at + 1], q[at + 2]
            at += 3
        else:
            row[WAY], row[WAY + 1], row[WAY + 2] = link.r[0], link.r[1], link.r[2]
        euler_to_matrix(q[at : at + 4], Q)
        for i in range(3):
            for j in range(3):
                x = 0.0
                for k in range(3):
                    x += link.R[i, k] * (Q[k, j] if link.sign > 0.0 else Q[j, k])
                row[TURN + 3 * i + j] = x
        return
    x = link.sign * q[at] if link.kind == SINGLE else 0.0
    c, s = (np.cos(x), np.sin(x)) if link.turn != 0.0 else (1.0, 0.0)
    along = x * link.slide
    for i in range(3):
        a, b, z = link.R[i, 0], link.R[i, 1], link.R[i, 2]
        row[TURN + 3 * i] = a * c + b * s
        row[TURN + 3 * i + 1] = b * c - a * s
        row[TURN + 3 * i + 2] = z
        row[WAY + i] = link.r[i] + along * z


@kernel
def carry(row, of_parent, at, to):
    """Write a twist or acceleration of the parent, moved to the link and turned into its axes, from `at` to `to`."""
    a, b, c = of_parent[at], of_parent[at + 1], of_parent[at + 2]
    x, y, z = row[WAY], row[WAY + 1], row[WAY + 2]
    u = of_parent[at + 3] + b * z - c * y
    v = of_parent[at + 4] + c * x - a * z
    w = of_parent[at + 5] + a * y - b * x
    for i in range(3):
        p, q, r = row[TURN + i], row[TURN + 3 + i], row[TURN + 6 + i]
        row[to + i] = p * a + q * b + r * c
        row[to + 3 + i] = p * u + q * v + r * w


@kernel
def reach_axes(link, row, x, y, z):
    """Return what the rates (or forces) x, y, z of a ball are in link axes: they refer to marker b."""
    if link.sign > 0.0:
        return x, y, z
    R = link.R
    a, b, c = (
        -R[0, 0] * x - R[0, 1] * y - R[0, 2] * z,
        -R[1, 0] * x - R[1, 1] * y - R[1, 2] * z,
        -R[2, 0] * x - R[2, 1] * y - R[2, 2] * z,
    )
    return (
        row[TURN] * a + row[TURN + 3] * b + row[TURN + 6] * c,
        row[TURN + 1] * a + row[TURN + 4] * b + row[TURN + 7] * c,
        row[TURN + 2] * a + row[TURN + 5] * b + row[TURN + 8] * c,
    )


@kernel
def read_axes(link, row, x, y, z):
    """Return the rates of a ball of an angular velocity in link axes: the inverse of `reach_axes`."""
    if link.sign > 0.0:
        return x, y, z
    a, b, c = (
        -row[TURN] * x - row[TURN + 1] * y - row[TURN + 2] * z,
        -row[TURN + 3] * x - row[TURN + 4] * y - row[TURN + 5] * z,
        -row[TURN + 6] * x - row[TURN + 7] * y - row[TURN + 8] * z,
    )
    R = link.R
    return (
        R[0, 0] * a + R[1, 0] * b + R[2, 0] * c,
        R[0, 1] * a + R[1, 1] * b + R[2, 1] * c,
        R[0, 2] * a + R[1, 2] * b + R[2, 2] * c,
    )


@inner_kernel
def _move(link, row, v, a):
    """Add the joint's own motion to the twist, and write the velocity terms of the acceleration."""
    s, at = row[SPEED : SPEED + 6], link.rate
    row[SWING : SWING + 6] = 0.0
    if link.kind == SINGLE:
        turn, slide = link.sign * link.turn * v[at], link.sign * link.slide * v[at]
        s[2] += turn
        s[5] += slide
        row[SWING], row[SWING + 1] = s[1] * turn, -s[0] * turn
        row[SWING + 3], row[SWING + 4] = s[4] * turn + s[1] * slide, -s[3] * turn - s[0] * slide
        if link.driven == 1:
            row[SWING + 2] = link.sign * link.turn * a[at]
            row[SWING + 5] = link.sign * link.slide * a[at]
    elif link.kind == BALL:
        x, y, z = reach_axes(link, row, v[at], v[at + 1], v[at + 2])
        row[SWING], row[SWING + 1], row[SWING + 2] = s[1] * z - s[2] * y, s[2] * x - s[0] * z, s[0] * y - s[1] * x
        row[SWING + 3], row[SWING + 4], row[SWING + 5] = s[4] * z - s[5] * y, s[5] * x - s[3] * z, s[3] * y - s[4] * x
        s[0] += x
        s[1] += y
        s[2] += z
    elif link.kind == FRAME:
        for i in range(3):
            s[i], s[3 + i] = v[at + 3 + i], v[at + i]


@inner_kernel
def _own(link, row):
    """Write the link's inertia and its gyroscopic force."""
    a, b, c = row[SPEED], row[SPEED + 1], row[SPEED + 2]
    u, v, w = row[SPEED + 3], row[SPEED + 4], row[SPEED + 5]
    m, x, y, z = link.mass, link.h[0], link.h[1], link.h[2]
    J = link.J
    # momentum l = m v + w x h, spin k = J w + h x v
    p, q, r = m * u + b * z - c * y, m * v + c * x - a * z, m * w + a * y - b * x
    d = J[0] * a + J[1] * b + J[2] * c + y * w - z * v
    e = J[1] * a + J[3] * b + J[4] * c + z * u - x * w
    f = J[2] * a + J[4] * b + J[5] * c + x * v - y * u
    row[FORCE] = b * f - c * e + v * r - w * q
    row[FORCE + 1] = c * d - a * f + w * p - u * r
    row[FORCE + 2] = a * e - b * d + u * q - v * p
    row[FORCE + 3], row[FORCE + 4], row[FORCE + 5] = b * r - c * q, c * p - a * r, a * q - b * p
    for i in range(6):
        row[MOMENT + i] = J[i]
        row[INERTIA + i] = 0.0
    row[INERTIA], row[INERTIA + 3], row[INERTIA + 5] = m, m, m
    row[COUPLING], row[COUPLING + 4], row[COUPLING + 8] = 0.0, 0.0, 0.0
    row[COUPLING + 1], row[COUPLING + 2], row[COUPLING + 3] = -z, y, z
    row[COUPLING + 5], row[COUPLING + 6], row[COUPLING + 7] = -x, -y, x


@kernel
def place_links(links, rows, q, v, a):
    """Place all links in their parents, write their twists, own inertias and gyroscopic forces; parents first.

    Of driven links the second rate is read from `a`.

    rows (n + 1, SCRATCH) : scratch; the last row stands for the ground
    """
    Q = np.empty((3, 3))
    rows[len(links)] = 0.0
    for k in range(len(links)):
        link, row = links[k], rows[k]
        _place(link, row, q, Q)
        carry(row, rows[link.parent], SPEED, SPEED)
        _move(link, row, v, a)
        _own(link, row)
