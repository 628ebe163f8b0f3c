"""Relative motion of the two markers of a joint: pose, twist and acceleration from its coordinates, and back.

All in the axes of marker a: d from a to b, R the axes of b; w the angular velocity of b relative to a.
"""

from __future__ import annotations

import numpy as np

from flexmb.math.kernel import inner_kernel, kernel
from flexmb.math.rotations import euler_to_matrix, matrix_to_euler
from flexmb.math.vectors import cross, matvec, matvec_t, rotate_columns

__all__ = [
    "joint_acceleration",
    "joint_axes",
    "joint_pose",
    "joint_twist",
    "read_acceleration",
    "read_pose",
    "read_twist",
]


@inner_kernel
def _turned(angle, A, out):
    """Write R_z(angle) A to `out`."""
    c, s = np.cos(angle), np.sin(angle)
    for j in range(3):
        x, y = A[0, j], A[1, j]
        out[0, j], out[1, j], out[2, j] = c * x - s * y, s * x + c * y, A[2, j]


@kernel
def joint_pose(row, q, d, R):
    """Write the pose (3,), (3, 3) of b in axes of a at the joint's coordinates q, eq. (tree-pose)."""
    right = np.zeros((3, 3))
    if row.ball >= 0:
        euler_to_matrix(q[row.ball : row.ball + 4], right)
    elif row.turn_b >= 0:
        right[0, 0], right[1, 1], right[2, 2] = 1.0, 1.0, 1.0
        _turned(q[row.turn_b], right.copy(), right)
    else:
        for i in range(3):
            right[i, i] = 1.0
    rotate_columns(row.C, right, R)
    for i in range(3):
        d[i] = row.d[i]
        if row.slide[i] >= 0:
            d[i] += q[row.slide[i]]
    if row.turn >= 0:
        _turned(q[row.turn], R.copy(), R)
        d[2] += row.advance * q[row.turn]


@kernel
def joint_axes(row, R, axes):
    """Write the unit twists (rates, 6) of b relative to a, at b, in axes of a, eq. (tree-rates)."""
    axes[: row.rates] = 0.0
    for i in range(3):
        if row.slide[i] >= 0:
            axes[row.slide[i], i] = 1.0
        if row.turn_b >= 0:
            axes[row.turn_b, 3 + i] = R[i, 2]
        if row.ball >= 0:
            for k in range(3):
                axes[row.ball + k, 3 + i] = R[i, k]
    if row.turn >= 0:
        axes[row.turn, 5] = 1.0
        axes[row.turn, 2] = row.advance


@kernel
def joint_twist(row, R, rates, twist):
    """Write velocity and angular velocity (6,) of b relative to a."""
    axes = np.zeros((6, 6))
    joint_axes(row, R, axes)
    twist[:] = 0.0
    for k in range(row.rates):
        for i in range(6):
            twist[i] += rates[k] * axes[k, i]


@kernel
def joint_acceleration(row, R, rates, seconds, out):
    """Write the rate (6,) of the relative twist, as seen from a: one axis turns another in a universal joint only."""
    joint_twist(row, R, seconds, out)
    if row.turn >= 0 and row.turn_b >= 0:
        x = rates[row.turn] * rates[row.turn_b]
        out[3] -= x * R[1, 2]
        out[4] += x * R[0, 2]


@kernel
def read_pose(row, d, R, q):
    """Write the joint's coordinates of a pose; angles in (-pi, pi], of a screw by its advance."""
    M = np.empty((3, 3))
    x = np.empty(3)
    for i in range(3):
        if row.slide[i] >= 0:
            q[row.slide[i]] = d[i] - row.d[i]
    angle = 0.0
    if row.turn >= 0:
        if row.turn_b >= 0:
            angle = np.arctan2(R[1, 2], R[0, 2]) - np.arctan2(row.C[1, 2], row.C[0, 2])
        else:
            rotate_columns(R, row.C.T.copy(), M)
            angle = np.arctan2(M[1, 0] - M[0, 1], M[0, 0] + M[1, 1])
        near = (d[2] - row.d[2]) / row.advance if row.advance != 0.0 else 0.0
        angle += 2.0 * np.pi * np.round((near - angle) / (2.0 * np.pi))
        q[row.turn] = angle
    if row.turn_b >= 0 or row.ball >= 0:
        _turned(-angle, R, M)
        if row.turn_b >= 0:
            for i in range(3):
                x[i] = M[i, 0]
            c, s = 0.0, 0.0
            for i in range(3):
                c += row.C[i, 0] * x[i]
                s += row.C[i, 1] * x[i]
            q[row.turn_b] = np.arctan2(s, c)
        else:
            matrix_to_euler(R, q[row.ball : row.ball + 4])


@kernel
def read_twist(row, R, twist, rates):
    """Write the joint's rates of a relative twist (6,), in axes of a; what the joint forbids is left out."""
    for i in range(3):
        if row.slide[i] >= 0:
            rates[row.slide[i]] = twist[i]
    if row.turn >= 0:
        rates[row.turn] = twist[5]
    if row.turn_b >= 0:
        rates[row.turn_b] = R[0, 2] * twist[3] + R[1, 2] * twist[4] + R[2, 2] * twist[5]
    if row.ball >= 0:
        matvec_t(R, twist[3:6], rates[row.ball : row.ball + 3])


@kernel
def read_acceleration(row, R, rates, change, seconds):
    """Write the joint's second rates of the rate (6,) of the relative twist, as seen from a."""
    rest = change.copy()
    if row.turn >= 0 and row.turn_b >= 0:
        x = rates[row.turn] * rates[row.turn_b]
        rest[3] += x * R[1, 2]
        rest[4] -= x * R[0, 2]
    read_twist(row, R, rest, seconds)


@kernel
def relative_pose(a, b, d, R):
    """Write the pose of marker b in the axes of marker a."""
    s = np.empty(3)
    for i in range(3):
        s[i] = b.r[i] - a.r[i]
    matvec_t(a.R, s, d)
    rotate_columns(a.R.T.copy(), b.R, R)


@kernel
def relative_twist(a, b, twist):
    """Write d', w of b relative to a in axes of a: d' is the rate of d as seen from a."""
    s, t, w = np.empty(3), np.empty(3), np.empty(3)
    for i in range(3):
        s[i] = b.r[i] - a.r[i]
        w[i] = b.w[i] - a.w[i]
    cross(a.w, s, t)
    for i in range(3):
        t[i] = b.v[i] - a.v[i] - t[i]
    matvec_t(a.R, t, twist[0:3])
    matvec_t(a.R, w, twist[3:6])


@kernel
def relative_acceleration(a, b, accelerations_a, accelerations_b, twist, change):
    """Write the rate (6,) of the relative twist as seen from a, from the accelerations (6,) of both markers in W."""
    s, t, c, v = np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    for i in range(3):
        s[i] = b.r[i] - a.r[i]
    matvec(a.R, twist[0:3], v)
    cross(a.w, s, t)
    for i in range(3):
        t[i] += 2.0 * v[i]
    cross(a.w, t, c)
    cross(accelerations_a[3:6], s, t)
    for i in range(3):
        t[i] = accelerations_b[i] - accelerations_a[i] - t[i] - c[i]
    matvec_t(a.R, t, change[0:3])
    cross(a.w, b.w, c)
    for i in range(3):
        t[i] = accelerations_b[3 + i] - accelerations_a[3 + i] - c[i]
    matvec_t(a.R, t, change[3:6])
