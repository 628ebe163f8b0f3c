"""Joint Jacobian: the twist of a marker per rate of the tree, along the path from its body to the root."""

from __future__ import annotations

import numpy as np

from flexmb.math.kernel import inner_kernel, kernel
from flexmb.tree.coordinates.joint_kinematics import joint_axes, relative_pose

__all__ = ["write_jacobian"]

HINGED = 0


@inner_kernel
def _add_column(work, number, j, r, sign, out, at):
    """Add column j of a marker's own Jacobian, moved to r (3,), times a sign, to column `at` of out."""
    marker, J = work.markers[number], work.J
    first, n = marker.iJ + j, marker.nu
    a, b, c = J[first + 3 * n], J[first + 4 * n], J[first + 5 * n]
    x, y, z = r[0] - marker.r[0], r[1] - marker.r[1], r[2] - marker.r[2]
    out[0, at] += sign * (J[first] + b * z - c * y)
    out[1, at] += sign * (J[first + n] + c * x - a * z)
    out[2, at] += sign * (J[first + 2 * n] + a * y - b * x)
    out[3, at] += sign * a
    out[4, at] += sign * b
    out[5, at] += sign * c


@inner_kernel
def _add_joint(row, work, r, axes, d, R, out):
    """Write the unit twists of a body's joint, moved to r (3,), to the columns of its rates."""
    one, two, sign = row.own, row.other, -1.0
    if row.forward == 1:
        one, two, sign = row.other, row.own, 1.0
    first, second = work.markers[one], work.markers[two]
    relative_pose(first, second, d, R)
    joint_axes(row, R, axes)
    x, y, z = r[0] - second.r[0], r[1] - second.r[1], r[2] - second.r[2]
    for k in range(row.rates):
        at = row.iv + k
        for i in range(3):
            p, q, s = first.R[i, 0], first.R[i, 1], first.R[i, 2]
            out[i, at] = sign * (p * axes[k, 0] + q * axes[k, 1] + s * axes[k, 2])
            out[3 + i, at] = sign * (p * axes[k, 3] + q * axes[k, 4] + s * axes[k, 5])
        a, b, c = out[3, at], out[4, at], out[5, at]
        out[0, at] += b * z - c * y
        out[1, at] += c * x - a * z
        out[2, at] += a * y - b * x


@kernel
def write_jacobian(rows, parents, work, body, marker, out):
    """Write the Jacobian of a marker on the body at place `body` of the tree (-1: it stands still) to out (6, nv).

    Each joint on the path contributes its unit twists, moved to the marker; each mode what it does at the marker while
    the body's own marker of its joint stays, eq. (tree-jacobian). `work` holds an evaluation; out is zero before.
    """
    axes, d, R = np.zeros((6, 6)), np.empty(3), np.empty((3, 3))
    r, through, k = work.markers[marker].r, marker, body
    while k >= 0:
        row = rows[k]
        if row.held != HINGED:
            for j in range(row.rates + row.modes):
                _add_column(work, through, j, r, 1.0, out, row.iv + j)
            return
        _add_joint(row, work, r, axes, d, R, out)
        for j in range(row.modes):
            _add_column(work, through, 6 + j, r, 1.0, out, row.iv + row.rates + j)
            _add_column(work, row.own, 6 + j, r, -1.0, out, row.iv + row.rates + j)
        through, k = row.other, parents[k]
