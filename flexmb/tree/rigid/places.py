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
    "BEND",
    "FIXED",
    "FRAME",
    "LINK",
    "LINK_FACTOR",
    "LINK_POSE",
    "LINK_STATE",
    "MOUNT",
    "SINGLE",
    "carry",
    "place_light",
    "place_links",
    "reach_axes",
    "read_axes",
]

FIXED, SINGLE, BALL, FRAME = -1, 1, 3, 6
"""Kinds of links, by their number of freedoms."""
BEND, MOUNT = -2, -3
"""The frame of a flexible body, which moves against its joint with the modes, and a marker of it that carries links."""

LINK = np.dtype(
    [
        ("parent", np.int64),  # place of the parent, -1: the ground
        ("kind", np.int64),  # FIXED, SINGLE, BALL or FRAME
        ("coordinate", np.int64),  # place of its first coordinate
        ("rate", np.int64),  # place of its first rate
        ("driven", np.int64),  # 1: the second rate is given
        ("body", np.int64),  # place of the body that it carries, or helps to carry, in the order of the tree
        ("block", np.int64),  # place of its factor, for several freedoms; of the flexible body, or its marker
        ("modes", np.int64),  # of a flexible body
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

LINK_STATE = np.dtype(
    [
        ("R", float, (3, 3)),  # axes, in axes of the parent
        ("r", float, 3),  # m, origin, there
        ("twist", float, 6),  # m/s, rad/s
        ("bias", float, 6),  # what velocities make of its rate
        ("rate", float, 6),  # of the twist
        ("force", float, 6),  # that holds it at rate zero
        ("gain", float, 6),  # of one freedom: column of the inertia times mobility
        ("mobility", float),  # 1 over the inertia of its one freedom
        ("load", float),  # what is left for its one freedom
        ("J", float, 6),  # articulated inertia [J, H; H^T, M]: xx xy xz yy yz zz
        ("H", float, (3, 3)),
        ("M", float, 6),  # as J
    ],
    align=True,
)
"""The numbers of a link at a state. Vectors are (angular, linear) in link axes, about its origin.

Frames and markers of flexible bodies use those before the gain, their joints without inertia those before J.
"""

LINK_FACTOR = np.dtype(
    [
        ("L", float, 36),  # Cholesky factor (n, n), flat, of the inertia of its freedoms
        ("load", float, 6),  # what is left for them
        ("gain", float, (3, 3)),  # of a ball: H^T J^-1
    ],
    align=True,
)
"""The numbers of a link of several freedoms at a state."""

LINK_POSE = np.dtype([("R", float, (3, 3)), ("r", float, 3)], align=True)
"""Where a link is in W: axes, and origin in m."""


@inner_kernel
def _place(link, row, q, Q):
    """Write the axes R and the origin r of a link in its parent at coordinates q."""
    at = link.coordinate
    if link.kind == BALL or link.kind == FRAME:
        if link.kind == FRAME:
            row.r[0], row.r[1], row.r[2] = q[at], q[at + 1], q[at + 2]
            at += 3
        else:
            row.r[0], row.r[1], row.r[2] = link.r[0], link.r[1], link.r[2]
        euler_to_matrix(q[at : at + 4], Q)
        for i in range(3):
            for j in range(3):
                x = 0.0
                for k in range(3):
                    x += link.R[i, k] * (Q[k, j] if link.sign > 0.0 else Q[j, k])
                row.R[i, j] = x
        return
    x = link.sign * q[at] if link.kind == SINGLE else 0.0
    c, s = (np.cos(x), np.sin(x)) if link.turn != 0.0 else (1.0, 0.0)
    along = x * link.slide
    for i in range(3):
        a, b, z = link.R[i, 0], link.R[i, 1], link.R[i, 2]
        row.R[i, 0] = a * c + b * s
        row.R[i, 1] = b * c - a * s
        row.R[i, 2] = z
        row.r[i] = link.r[i] + along * z


@kernel
def carry(row, of_parent, out):
    """Write a twist or rate (6,) of the parent, moved to the link and turned into its axes, to `out`."""
    a, b, c = of_parent[0], of_parent[1], of_parent[2]
    x, y, z = row.r[0], row.r[1], row.r[2]
    u = of_parent[3] + b * z - c * y
    v = of_parent[4] + c * x - a * z
    w = of_parent[5] + a * y - b * x
    for i in range(3):
        p, q, r = row.R[0, i], row.R[1, i], row.R[2, i]
        out[i] = p * a + q * b + r * c
        out[3 + i] = p * u + q * v + r * w


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
        row.R[0, 0] * a + row.R[1, 0] * b + row.R[2, 0] * c,
        row.R[0, 1] * a + row.R[1, 1] * b + row.R[2, 1] * c,
        row.R[0, 2] * a + row.R[1, 2] * b + row.R[2, 2] * c,
    )


@kernel
def read_axes(link, row, x, y, z):
    """Return the rates of a ball of an angular velocity in link axes: the inverse of `reach_axes`."""
    if link.sign > 0.0:
        return x, y, z
    a, b, c = (
        -row.R[0, 0] * x - row.R[0, 1] * y - row.R[0, 2] * z,
        -row.R[1, 0] * x - row.R[1, 1] * y - row.R[1, 2] * z,
        -row.R[2, 0] * x - row.R[2, 1] * y - row.R[2, 2] * z,
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
    s, at = row.twist, link.rate
    row.bias[:] = 0.0
    if link.kind == SINGLE:
        turn, slide = link.sign * link.turn * v[at], link.sign * link.slide * v[at]
        s[2] += turn
        s[5] += slide
        row.bias[0], row.bias[1] = s[1] * turn, -s[0] * turn
        row.bias[3], row.bias[4] = s[4] * turn + s[1] * slide, -s[3] * turn - s[0] * slide
        if link.driven == 1:
            row.bias[2] = link.sign * link.turn * a[at]
            row.bias[5] = link.sign * link.slide * a[at]
    elif link.kind == BALL:
        x, y, z = reach_axes(link, row, v[at], v[at + 1], v[at + 2])
        row.bias[0], row.bias[1], row.bias[2] = s[1] * z - s[2] * y, s[2] * x - s[0] * z, s[0] * y - s[1] * x
        row.bias[3], row.bias[4], row.bias[5] = s[4] * z - s[5] * y, s[5] * x - s[3] * z, s[3] * y - s[4] * x
        s[0] += x
        s[1] += y
        s[2] += z
    elif link.kind == FRAME:
        for i in range(3):
            s[i], s[3 + i] = v[at + 3 + i], v[at + i]


@inner_kernel
def _own(link, row):
    """Write the link's inertia and its gyroscopic force."""
    a, b, c = row.twist[0], row.twist[1], row.twist[2]
    u, v, w = row.twist[3], row.twist[4], row.twist[5]
    m, x, y, z = link.mass, link.h[0], link.h[1], link.h[2]
    J = link.J
    # momentum l = m v + w x h, spin k = J w + h x v
    p, q, r = m * u + b * z - c * y, m * v + c * x - a * z, m * w + a * y - b * x
    d = J[0] * a + J[1] * b + J[2] * c + y * w - z * v
    e = J[1] * a + J[3] * b + J[4] * c + z * u - x * w
    f = J[2] * a + J[4] * b + J[5] * c + x * v - y * u
    row.force[0] = b * f - c * e + v * r - w * q
    row.force[1] = c * d - a * f + w * p - u * r
    row.force[2] = a * e - b * d + u * q - v * p
    row.force[3], row.force[4], row.force[5] = b * r - c * q, c * p - a * r, a * q - b * p
    for i in range(6):
        row.J[i] = J[i]
        row.M[i] = 0.0
    row.M[0], row.M[3], row.M[5] = m, m, m
    row.H[0, 0], row.H[1, 1], row.H[2, 2] = 0.0, 0.0, 0.0
    row.H[0, 1], row.H[0, 2], row.H[1, 0] = -z, y, z
    row.H[1, 2], row.H[2, 0], row.H[2, 1] = -x, -y, x


@kernel
def place_light(link, row, of_parent, q, v, a, Q):
    """Place a link without inertia in its parent and write its twist; see `place_links`. Q (3, 3) is scratch."""
    _place(link, row, q, Q)
    carry(row, of_parent.twist, row.twist)
    _move(link, row, v, a)
    row.force[:] = 0.0


@kernel
def place_links(links, rows, q, v, a, first, last):
    """Place the links from `first` to before `last` in their parents, write their twists, own inertias and gyroscopic
    forces; parents first.

    Of driven links the second rate is read from `a`.

    rows (n + 1,) of LINK_STATE : the last one stands for the ground
    """
    Q = np.empty((3, 3))
    rows[len(links)].twist[:] = 0.0
    for k in range(first, last):
        link, row = links[k], rows[k]
        _place(link, row, q, Q)
        carry(row, rows[link.parent].twist, row.twist)
        _move(link, row, v, a)
        _own(link, row)
