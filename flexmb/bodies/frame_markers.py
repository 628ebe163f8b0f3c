"""Markers fixed to a rigid frame: kinematics and the derivative of their loads."""

from __future__ import annotations

import numpy as np

from flexmb.bodies.rows import add_product_skew
from flexmb.math.kernel import kernel
from flexmb.math.vectors import add_skew, cross, matvec, matvec_t, rotate_columns

__all__ = ["MARKER_SIZE", "add_load_stiffness", "pack_markers", "place_marker"]

MARKER_SIZE = 12
"""Numbers per marker in the bulk data: position (3) and axes (9) in body axes."""


def pack_markers(poses) -> np.ndarray:
    """Return positions and axes of the poses, one after another, as bulk data."""
    return np.concatenate([np.concatenate([pose.at, pose.matrix.ravel()]) for pose in poses.values()] or [np.empty(0)])


@kernel
def place_marker(marker, J, r, R, u, s, axes, scratch):
    """Write position, axes, twist, Jacobian and bias acceleration of a marker at `s` with `axes` in body axes.

    ``r_m = r + R s``, ``v_m = R (v + w x s)``, ``bias = R (w x v + w x (w x s))``; `scratch` (2, 3).
    """
    v = u[0:3]
    w = u[3:6]
    matvec(R, s, marker.r)
    for i in range(3):
        marker.r[i] += r[i]
    rotate_columns(R, axes, marker.R)
    cross(w, s, scratch[0])
    for i in range(3):
        scratch[0, i] += v[i]
    matvec(R, scratch[0], marker.v)
    matvec(R, w, marker.w)
    cross(w, scratch[0], scratch[1])
    matvec(R, scratch[1], marker.bias[0:3])
    start, nu = marker.iJ, marker.nu
    for i in range(3):
        marker.bias[3 + i] = 0.0
        top, bottom = start + i * nu, start + (3 + i) * nu
        for j in range(3):
            J[top + j] = R[i, j]
            J[bottom + j] = 0.0
            J[bottom + 3 + j] = R[i, j]
        # -R s~
        J[top + 3] = R[i, 2] * s[1] - R[i, 1] * s[2]
        J[top + 4] = R[i, 0] * s[2] - R[i, 2] * s[0]
        J[top + 5] = R[i, 1] * s[0] - R[i, 0] * s[1]


@kernel
def add_load_stiffness(B, scale, R, s, wrench, F, N):
    """Add scale * d(-J^T W)/d(rotation) to the body block `B`; leave force and moment in body axes in `F`, `N`.

    In body axes a force fixed in W turns backwards: dF = F~ dphi.
    """
    matvec_t(R, wrench[0:3], F)
    matvec_t(R, wrench[3:6], N)
    add_skew(B, 0, 3, -scale, F)
    add_product_skew(B, 3, 3, -scale, s, F)
    add_skew(B, 3, 3, -scale, N)
