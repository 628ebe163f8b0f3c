"""Recursive inverse dynamics: the forces of joints and modes that a motion of the tree needs, one visit per body."""

from __future__ import annotations

import numpy as np

from flexmb.math.kernel import inner_kernel, kernel
from flexmb.math.rotations import euler_to_matrix
from flexmb.math.vectors import add_cross, matvec
from flexmb.tree.coordinates.joint_kinematics import joint_axes, relative_pose

__all__ = ["gather_torques"]

HINGED = 0


@inner_kernel
def _on_rates(row, work, W, tau):
    """Write S^T W, the force on each rate of the joint; W (6,) acts on the body at its own marker, in W."""
    axes = np.zeros((6, 6))
    d, R, s, L = np.empty(3), np.empty((3, 3)), np.empty(3), W.copy()
    one, two = row.own, row.other
    if row.forward == 1:
        one, two = row.other, row.own
    a, b = work.markers[one], work.markers[two]
    relative_pose(a, b, d, R)
    joint_axes(row, R, axes)
    if row.forward == 0:  # what acts on a at its origin acts on b, reversed, at b's origin
        for i in range(3):
            s[i] = a.r[i] - b.r[i]
        add_cross(s, W[0:3], L[3:6])
        for i in range(6):
            L[i] = -L[i]
    for k in range(row.rates):
        tau[row.iv + k] = 0.0
        for j in range(3):
            x, y = 0.0, 0.0
            for i in range(3):
                x += a.R[i, j] * L[i]
                y += a.R[i, j] * L[3 + i]
            tau[row.iv + k] += axes[k, j] * x + axes[k, 3 + j] * y


@inner_kernel
def _marker_entry(marker, work, i, j, stiffened):
    """Return entry (i, j) of what a wrench at the marker multiplies: J, less what stiffens the body."""
    x = work.J[marker.iJ + i * marker.nu + j]
    if stiffened == 1 and marker.iH >= 0:
        x -= work.H[marker.iH + i * marker.nu + j]
    return x


@kernel
def gather_torques(rows, state, work, force, tau, stiffened):
    """Write the forces on all rates, eq. (tree-torques); `force` (nu,) is M a - f of the bodies, and is overwritten.

    stiffened : 1 for wrenches, which stiffen bodies at their interfaces; 0 for the transposed Jacobian alone
    """
    W, s, R = np.empty(6), np.empty(3), np.empty((3, 3))
    for k in range(len(rows) - 1, -1, -1):
        row = rows[k]
        u, at = row.u, row.iv + row.rates
        if row.held != HINGED:
            for i in range(row.rates + row.modes):
                tau[row.iv + i] = force[u + i]
            continue
        C, Q = work.markers[row.own], work.markers[row.other]
        euler_to_matrix(state.q[row.q + 3 : row.q + 7], R)
        matvec(R, force[u : u + 3], W[0:3])
        matvec(R, force[u + 3 : u + 6], W[3:6])
        for i in range(3):
            s[i] = state.q[row.q + i] - C.r[i]
        add_cross(s, W[0:3], W[3:6])
        _on_rates(row, work, W, tau)
        for j in range(row.modes):
            x = force[u + 6 + j]
            for i in range(6):
                x -= _marker_entry(C, work, i, 6 + j, stiffened) * W[i]
            tau[at + j] = x
        if Q.nu == 0:
            continue
        for i in range(3):
            s[i] = C.r[i] - Q.r[i]
        add_cross(s, W[0:3], W[3:6])
        for j in range(Q.nu):
            for i in range(6):
                force[Q.iu + j] += _marker_entry(Q, work, i, j, stiffened) * W[i]
