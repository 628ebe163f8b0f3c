"""The articulated-body algorithm in link axes, for rigid links on hinges and slides (Featherstone 2008, table 7.1).

Each link has a frame on its joint whose z-axis is the axis of motion, so the motion is one coordinate axis and the
inertia a column. Inertias are symmetric: ``[[J, H], [H^T, M]]`` in (angular, linear), stored as 6 + 9 + 6 numbers.
"""

from __future__ import annotations

import numpy as np

from flexmb.math.kernel import inner_kernel, kernel

__all__ = ["LINK", "SCRATCH", "link_accelerations"]

LINK = np.dtype(
    [
        ("parent", np.int64),  # place of the parent, -1: the ground
        ("slides", np.int64),  # 1: along z, 0: turns about z, -1: fixed
        ("rate", np.int64),  # place of its coordinate and rate
        ("driven", np.int64),  # 1: the second rate is given
        ("sign", float),  # -1.0 where the tree goes through the joint backwards
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


@inner_kernel
def _place(link, row, x):
    """Write the axes R and the origin r of a link in its parent at the coordinate x (with its sign)."""
    c, s = (np.cos(x), np.sin(x)) if link.slides == 0 else (1.0, 0.0)
    along = x if link.slides == 1 else 0.0
    for i in range(3):
        a, b, z = link.R[i, 0], link.R[i, 1], link.R[i, 2]
        row[TURN + 3 * i] = a * c + b * s
        row[TURN + 3 * i + 1] = b * c - a * s
        row[TURN + 3 * i + 2] = z
        row[WAY + i] = link.r[i] + along * z


@inner_kernel
def _carry(row, of_parent, at, to):
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


@inner_kernel
def _own(link, row, rate):
    """Write the link's inertia, the velocity terms c of its joint and its gyroscopic force."""
    a, b, c = row[SPEED], row[SPEED + 1], row[SPEED + 2]
    u, v, w = row[SPEED + 3], row[SPEED + 4], row[SPEED + 5]
    turn, slide = (rate, 0.0) if link.slides == 0 else (0.0, rate)
    row[SWING], row[SWING + 1], row[SWING + 2] = b * turn, -a * turn, 0.0
    row[SWING + 3], row[SWING + 4], row[SWING + 5] = v * turn + b * slide, -u * turn - a * slide, 0.0
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


@inner_kernel
def _column(link, row):
    """Return the column of the inertia (6,) that belongs to the joint's motion."""
    if link.slides == 0:
        return row[MOMENT + 2], row[MOMENT + 4], row[MOMENT + 5], row[COUPLING + 6], row[COUPLING + 7], row[COUPLING + 8]
    return row[COUPLING + 2], row[COUPLING + 5], row[COUPLING + 8], row[INERTIA + 2], row[INERTIA + 4], row[INERTIA + 5]


@inner_kernel
def _open(link, row, tau):
    """Subtract what the joint's motion takes from inertia and force; False if it moves no inertia."""
    if link.slides == -1 or link.driven == 1:
        for i in range(6):
            row[BIAS + i] = 0.0
        return True
    U = _column(link, row)
    D, load = (U[2], tau - row[FORCE + 2]) if link.slides == 0 else (U[5], tau - row[FORCE + 5])
    if not D > 1e-300:
        return False
    D = 1.0 / D
    for i in range(6):
        row[BIAS + i] = U[i] * D
    row[DIVISOR], row[DRIVE] = D, load
    k = 0
    for i in range(3):
        for j in range(i, 3):
            row[MOMENT + k] -= row[BIAS + i] * U[j]
            row[INERTIA + k] -= row[BIAS + 3 + i] * U[3 + j]
            k += 1
        for j in range(3):
            row[COUPLING + 3 * i + j] -= row[BIAS + i] * U[3 + j]
    return True


@inner_kernel
def _force_with_swing(row):
    """Add P c and the driven part U D load to the force."""
    a, b, c = row[SWING], row[SWING + 1], row[SWING + 2]
    u, v, w = row[SWING + 3], row[SWING + 4], row[SWING + 5]
    J, H, M = MOMENT, COUPLING, INERTIA
    load = row[DRIVE]
    row[FORCE] += row[J] * a + row[J + 1] * b + row[J + 2] * c + row[H] * u + row[H + 1] * v + row[H + 2] * w
    row[FORCE + 1] += row[J + 1] * a + row[J + 3] * b + row[J + 4] * c + row[H + 3] * u + row[H + 4] * v + row[H + 5] * w
    row[FORCE + 2] += row[J + 2] * a + row[J + 4] * b + row[J + 5] * c + row[H + 6] * u + row[H + 7] * v + row[H + 8] * w
    row[FORCE + 3] += row[H] * a + row[H + 3] * b + row[H + 6] * c + row[M] * u + row[M + 1] * v + row[M + 2] * w
    row[FORCE + 4] += row[H + 1] * a + row[H + 4] * b + row[H + 7] * c + row[M + 1] * u + row[M + 3] * v + row[M + 4] * w
    row[FORCE + 5] += row[H + 2] * a + row[H + 5] * b + row[H + 8] * c + row[M + 2] * u + row[M + 4] * v + row[M + 5] * w
    for i in range(6):
        row[FORCE + i] += row[BIAS + i] * load


@inner_kernel
def _turned(row, at, symmetric, out, half):
    """Write R A R^T to `out` (9,); A at row[at] has 6 numbers if symmetric, else 9."""
    if symmetric:
        A = (row[at], row[at + 1], row[at + 2], row[at + 1], row[at + 3], row[at + 4], row[at + 2], row[at + 4], row[at + 5])
    else:
        A = (row[at], row[at + 1], row[at + 2], row[at + 3], row[at + 4], row[at + 5], row[at + 6], row[at + 7], row[at + 8])
    for j in range(3):
        x, y, z = row[TURN + 3 * j], row[TURN + 3 * j + 1], row[TURN + 3 * j + 2]
        half[j] = A[0] * x + A[1] * y + A[2] * z
        half[3 + j] = A[3] * x + A[4] * y + A[5] * z
        half[6 + j] = A[6] * x + A[7] * y + A[8] * z
    for i in range(3):
        x, y, z = row[TURN + 3 * i], row[TURN + 3 * i + 1], row[TURN + 3 * i + 2]
        for j in range(3):
            out[3 * i + j] = x * half[j] + y * half[3 + j] + z * half[6 + j]


@inner_kernel
def _give(row, of_parent, M, H, J, half):
    """Add inertia and force to the parent's: turned, then moved by r: H + r~ M, J + r~ H^T - (H + r~ M) r~."""
    x, y, z = row[WAY], row[WAY + 1], row[WAY + 2]
    _turned(row, INERTIA, True, M, half)
    _turned(row, COUPLING, False, H, half)
    _turned(row, MOMENT, True, J, half)
    for j in range(3):
        # r~ H^T: the cross product of r with row j of H, as column j
        a, b, c = H[3 * j], H[3 * j + 1], H[3 * j + 2]
        J[j] += y * c - z * b
        J[3 + j] += z * a - x * c
        J[6 + j] += x * b - y * a
    for j in range(3):
        a, b, c = M[j], M[3 + j], M[6 + j]
        H[j] += y * c - z * b
        H[3 + j] += z * a - x * c
        H[6 + j] += x * b - y * a
    k = 0
    for i in range(3):
        a, b, c = H[3 * i], H[3 * i + 1], H[3 * i + 2]
        # row i of -H r~ is r x (row i of H) with the opposite sign of (row i of H) x r
        shift = (y * c - z * b, z * a - x * c, x * b - y * a)
        for j in range(i, 3):
            of_parent[MOMENT + k] += J[3 * i + j] + shift[j]
            of_parent[INERTIA + k] += M[3 * i + j]
            k += 1
        for j in range(3):
            of_parent[COUPLING + 3 * i + j] += H[3 * i + j]
    for i in range(3):
        p, q, r = row[TURN + 3 * i], row[TURN + 3 * i + 1], row[TURN + 3 * i + 2]
        half[i] = p * row[FORCE] + q * row[FORCE + 1] + r * row[FORCE + 2]
        half[3 + i] = p * row[FORCE + 3] + q * row[FORCE + 4] + r * row[FORCE + 5]
    of_parent[FORCE] += half[0] + y * half[5] - z * half[4]
    of_parent[FORCE + 1] += half[1] + z * half[3] - x * half[5]
    of_parent[FORCE + 2] += half[2] + x * half[4] - y * half[3]
    for i in range(3):
        of_parent[FORCE + 3 + i] += half[3 + i]


@kernel
def link_accelerations(links, gravity, rows, q, v, tau, a):
    """Write the second rates `a` (nv,) at coordinates, rates and joint forces; return -1, or a link without inertia.

    Of driven links the second rate is read from `a`, and the force that it needs is written to `tau`.

    rows (n + 1, SCRATCH) : scratch; the last row stands for the ground, which falls upwards with gravity
    """
    n = len(links)
    M, H, J, half = np.empty(9), np.empty(9), np.empty(9), np.empty(9)
    ground = rows[n]
    ground[:] = 0.0
    for i in range(3):
        ground[RATE + 3 + i] = -gravity[i]
    for k in range(n):
        link, row = links[k], rows[k]
        x, rate = 0.0, 0.0
        if link.slides >= 0:
            x, rate = link.sign * q[link.rate], link.sign * v[link.rate]
        _place(link, row, x)
        _carry(row, rows[link.parent], SPEED, SPEED)
        row[SPEED + (5 if link.slides == 1 else 2)] += rate
        _own(link, row, rate)
        if link.driven == 1:
            row[SWING + (5 if link.slides == 1 else 2)] += link.sign * a[link.rate]
        row[DRIVE] = 0.0
    for k in range(n - 1, -1, -1):
        link, row = links[k], rows[k]
        if not _open(link, row, link.sign * tau[link.rate] if link.slides >= 0 else 0.0):
            return k
        _force_with_swing(row)
        if link.parent >= 0:
            _give(row, rows[link.parent], M, H, J, half)
    for k in range(n):
        link, row = links[k], rows[k]
        _carry(row, rows[link.parent], RATE, RATE)
        if link.driven == 1:
            U = _column(link, row)
            x = row[FORCE + (5 if link.slides == 1 else 2)]
            for i in range(6):
                x += U[i] * row[RATE + i]
            tau[link.rate] = link.sign * x
        for i in range(6):
            row[RATE + i] += row[SWING + i]
        if link.slides < 0 or link.driven == 1:
            continue
        x = row[DRIVE] * row[DIVISOR]
        for i in range(6):
            x -= row[BIAS + i] * row[RATE + i]
        row[RATE + (5 if link.slides == 1 else 2)] += x
        a[link.rate] = link.sign * x
    return -1
