"""Passes over the tree between relative and absolute coordinates: each body is visited once, parents first.

What a marker is in its own body follows from the kernels of the bodies, evaluated wherever their frames happen to be.
"""

from __future__ import annotations

import numpy as np

from flexmb.math.kernel import inner_kernel, kernel
from flexmb.math.rotations import euler_to_matrix, matrix_to_euler
from flexmb.math.vectors import cross, matvec, matvec_t, rotate_columns
from flexmb.tree.coordinates.joint_kinematics import (
    joint_acceleration,
    joint_pose,
    joint_twist,
    read_acceleration,
    read_pose,
    read_twist,
    relative_acceleration,
    relative_pose,
    relative_twist,
)

__all__ = ["accelerate_bodies", "marker_rate", "move_bodies", "place_bodies", "read_second_rates", "read_state"]

HINGED = 0


@kernel
def marker_rate(marker, J, u, out):
    """Write J u (6,): the twist of a marker, or its acceleration without bias."""
    for i in range(6):
        out[i] = 0.0
        start = marker.iJ + i * marker.nu
        for j in range(marker.nu):
            out[i] += J[start + j] * u[marker.iu + j]


@inner_kernel
def _marker_acceleration(marker, J, a, out):
    """Write the acceleration (6,) of a marker in W."""
    marker_rate(marker, J, a, out)
    for i in range(6):
        out[i] += marker.bias[i]


@inner_kernel
def _joint_axes_of(row, work, d, R):
    """Write the relative pose of the joint and return the numbers of its markers a and b."""
    one, two = row.own, row.other
    if row.forward == 1:
        one, two = row.other, row.own
    relative_pose(work.markers[one], work.markers[two], d, R)
    return one, two


@kernel
def read_second_rates(rows, state, work, v, a):
    """Write the second rates of a state whose rates are v; `work` holds an evaluation of it."""
    d, R = np.empty(3), np.empty((3, 3))
    twist, change = np.empty(6), np.empty(6)
    A, B = np.empty(6), np.empty(6)
    for k in range(len(rows)):
        row = rows[k]
        nr, own = row.rates, row.u
        if row.held == HINGED:
            one, two = _joint_axes_of(row, work, d, R)
            first, second = work.markers[one], work.markers[two]
            relative_twist(first, second, twist)
            _marker_acceleration(first, work.J, state.a, A)
            _marker_acceleration(second, work.J, state.a, B)
            relative_acceleration(first, second, A, B, twist, change)
            read_acceleration(row, R, v[row.iv : row.iv + nr], change, a[row.iv : row.iv + nr])
            own += 6
        else:
            for i in range(nr):
                a[row.iv + i] = state.a[own + i]
            own += nr
        for i in range(row.modes):
            a[row.iv + nr + i] = state.a[own + i]


@kernel
def read_state(rows, state, work, q, v, a):
    """Write relative coordinates, rates and second rates of a state that `work` holds an evaluation of."""
    d, R, twist = np.empty(3), np.empty((3, 3)), np.empty(6)
    for k in range(len(rows)):
        row = rows[k]
        nc, nr = row.coordinates, row.rates
        own_q, own_u = row.q, row.u
        if row.held == HINGED:
            one, two = _joint_axes_of(row, work, d, R)
            read_pose(row, d, R, q[row.iq : row.iq + nc])
            relative_twist(work.markers[one], work.markers[two], twist)
            read_twist(row, R, twist, v[row.iv : row.iv + nr])
            own_q, own_u = own_q + 7, own_u + 6
            nm = row.modes
        else:
            nm, nc, nr = row.coordinates + row.modes, 0, 0
        for i in range(nm):
            q[row.iq + nc + i] = state.q[own_q + i]
        nm = nm - (row.coordinates - row.rates if row.held != HINGED else 0)
        for i in range(nm):
            v[row.iv + nr + i] = state.u[own_u + i]
    read_second_rates(rows, state, work, v, a)


@inner_kernel
def _in_body(marker, q, R, s, axes):
    """Write position and axes of a marker in its body, whose frame is q (7,); R (3, 3) is scratch."""
    d = np.empty(3)
    euler_to_matrix(q[3:7], R)
    for i in range(3):
        d[i] = marker.r[i] - q[i]
    matvec_t(R, d, s)
    rotate_columns(R.T.copy(), marker.R, axes)


@kernel
def place_bodies(rows, work, before, q, out):
    """Write the coordinates of all bodies to `out`; `work` holds an evaluation at `before`, with modes as in q."""
    d, s, r, t = np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    R_ab, R, A, B = np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3))
    for k in range(len(rows)):
        row = rows[k]
        nc, at = row.coordinates, row.q
        if row.held != HINGED:
            for i in range(nc + row.modes):
                out[at + i] = q[row.iq + i]
            continue
        for i in range(row.modes):
            out[at + 7 + i] = q[row.iq + nc + i]
        # Q of the parent, where it has come to be
        p = row.parent_q
        if row.fixed[1] == 1:
            s[:] = row.place[1]
            B[:] = row.axes[1]
        else:
            _in_body(work.markers[row.other], before[p : p + 7], R, s, B)
        if p < 0:
            r[:] = s
            A[:] = B
        else:
            euler_to_matrix(out[p + 3 : p + 7], R)
            matvec(R, s, r)
            for i in range(3):
                r[i] += out[p + i]
            rotate_columns(R, B, A)
        joint_pose(row, q[row.iq : row.iq + nc], d, R_ab)
        if row.forward == 1:
            matvec(A, d, t)
            rotate_columns(A, R_ab, B)
            for i in range(3):
                r[i] += t[i]
        else:
            rotate_columns(A, R_ab.T.copy(), B)
            matvec(B, d, t)
            for i in range(3):
                r[i] -= t[i]
        if row.fixed[0] == 1:
            s[:] = row.place[0]
            A[:] = row.axes[0]
        else:
            _in_body(work.markers[row.own], before[at : at + 7], R, s, A)
        rotate_columns(B, A.T.copy(), R)
        matrix_to_euler(R, out[at + 3 : at + 7])
        matvec(R, s, t)
        for i in range(3):
            out[at + i] = r[i] - t[i]


@inner_kernel
def _own_frame(row, work, q, u, twist, out):
    """Write the frame's six of `out`, given J u (6,) of its marker C:
    the modes' part subtracted, moved to the origin.
    """
    C, at = work.markers[row.own], row.u
    s, t, R = np.empty(3), np.empty(3), np.empty((3, 3))
    for i in range(6):
        start = C.iJ + i * C.nu + 6
        for j in range(row.modes):
            twist[i] -= work.J[start + j] * u[at + 6 + j]
    euler_to_matrix(q[row.q + 3 : row.q + 7], R)
    for i in range(3):
        s[i] = C.r[i] - q[row.q + i]
    cross(twist[3:6], s, t)
    for i in range(3):
        twist[i] -= t[i]
    matvec_t(R, twist[0:3], out[at : at + 3])
    matvec_t(R, twist[3:6], out[at + 3 : at + 6])


@inner_kernel
def _plain(row, v, u):
    """Write the velocities that are the same in both coordinates; True if the body hangs on no joint."""
    nr = row.rates
    if row.held != HINGED:
        for i in range(nr + row.modes):
            u[row.u + i] = v[row.iv + i]
        return True
    for i in range(row.modes):
        u[row.u + 6 + i] = v[row.iv + nr + i]
    return False


@kernel
def move_bodies(rows, work, q, v, u):
    """Write the velocities of all bodies; `work` holds an evaluation at their coordinates q,
    whatever the velocities.
    """
    d, R = np.empty(3), np.empty((3, 3))
    twist, V, s, t = np.empty(6), np.empty(6), np.empty(3), np.empty(3)
    for k in range(len(rows)):
        row = rows[k]
        if _plain(row, v, u):
            continue
        one, _ = _joint_axes_of(row, work, d, R)
        a, C, Q = work.markers[one], work.markers[row.own], work.markers[row.other]
        joint_twist(row, R, v[row.iv : row.iv + row.rates], twist)
        marker_rate(Q, work.J, u, V)
        # the second of two markers moves with the first, and relative to it; backwards, the first without the second
        sign = 1.0 if row.forward == 1 else -1.0
        matvec(a.R, twist[3:6], t)
        for i in range(3):
            V[3 + i] += sign * t[i]
        w = V[3:6] if row.forward == 0 else V[3:6] - t
        for i in range(3):
            s[i] = C.r[i] - Q.r[i]
        cross(w, s, t)
        for i in range(3):
            V[i] += t[i]
        matvec(a.R, twist[0:3], t)
        for i in range(3):
            V[i] += sign * t[i]
        _own_frame(row, work, q, u, V, u)


@kernel
def accelerate_bodies(rows, work, q, v, a, out):
    """Write the accelerations of all bodies; `work` holds an evaluation at their coordinates and velocities."""
    d, R = np.empty(3), np.empty((3, 3))
    twist, change, A = np.empty(6), np.empty(6), np.empty(6)
    s, t, c, w, alpha = np.empty(3), np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    for k in range(len(rows)):
        row = rows[k]
        if _plain(row, a, out):
            continue
        one, two = _joint_axes_of(row, work, d, R)
        first, second = work.markers[one], work.markers[two]
        C, Q = work.markers[row.own], work.markers[row.other]
        relative_twist(first, second, twist)
        rates = slice(row.iv, row.iv + row.rates)
        joint_acceleration(row, R, v[rates], a[rates], change)
        _marker_acceleration(Q, work.J, out, A)
        sign = 1.0 if row.forward == 1 else -1.0
        matvec(first.R, change[3:6], t)
        cross(first.w, second.w, c)
        for i in range(3):
            A[3 + i] += sign * (t[i] + c[i])
            alpha[i] = A[3 + i] - (t[i] + c[i] if row.forward == 1 else 0.0)
            s[i] = C.r[i] - Q.r[i]
        cross(alpha, s, c)
        for i in range(3):
            A[i] += c[i]
        cross(first.w, s, c)
        matvec(first.R, twist[0:3], w)
        for i in range(3):
            c[i] += 2.0 * sign * w[i]
        cross(first.w, c, t)
        matvec(first.R, change[0:3], w)
        for i in range(3):
            A[i] += t[i] + sign * w[i]
        for i in range(6):
            A[i] -= C.bias[i]
        _own_frame(row, work, q, out, A, out)
