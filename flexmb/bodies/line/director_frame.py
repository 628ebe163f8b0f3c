"""The frame of two directors a, b: ``e3 = b/|b|``, ``e1 = a x b/|a x b|``, ``e2 = e3 x e1``; its spin; markers on it.

Beams take the axes of their section as directors, plates the normal and a direction in the plane. All functions pass a
complex step.
"""

from __future__ import annotations

import numpy as np

from flexmb.math.kernel import inner_kernel, kernel
from flexmb.math.vectors import cross, dot

__all__ = ["frame_stiffness", "place_frame", "section_frame", "section_spin", "spin_gradient"]

STEP = 1e-30


@kernel
def section_frame(a, b, E):
    """Write the frame e1, e2, e3 as rows of `E`; return |b|, a . e2 and a . e3."""
    length = dot(b, b) ** 0.5
    c = np.empty_like(a)
    cross(a, b, c)
    area = dot(c, c) ** 0.5
    for i in range(3):
        E[2, i] = b[i] / length
        E[0, i] = c[i] / area
    cross(E[2], E[0], E[1])
    return length, dot(a, E[1]), dot(a, E[2])


@kernel
def section_spin(E, length, across, along, da, db, out):
    """Write the turn of the frame, in the frame, for changes `da`, `db` of the directors: eq. (beam-spin)."""
    out[0] = -dot(E[1], db) / length
    out[1] = dot(E[0], db) / length
    out[2] = (along * out[1] - dot(E[0], da)) / across


@kernel
def spin_gradient(E, length, across, along, torque, ga, gb):
    """Add the forces on the directors of a torque (3,) in the frame: the transpose of `section_spin`."""
    second = torque[1] + torque[2] * along / across
    for i in range(3):
        ga[i] -= torque[2] / across * E[0, i]
        gb[i] += (second * E[0, i] - torque[0] * E[1, i]) / length


@inner_kernel
def _angular_velocity(a, b, da, db, w):
    """Write the angular velocity, in W, of the frame of directors a, b with the rates da, db."""
    E = np.empty((3, 3), a.dtype)
    turn = np.empty(3, a.dtype)
    length, across, along = section_frame(a, b, E)
    section_spin(E, length, across, along, da, db, turn)
    for i in range(3):
        w[i] = turn[0] * E[0, i] + turn[1] * E[1, i] + turn[2] * E[2, i]


@kernel
def place_frame(marker, a, b, da, db, fixed, E):
    """Write axes, angular velocity and its bias of a marker whose axes are `fixed` (9,) in the frame, and the frame E.

    Returns what `spin_gradient` needs: |b|, a . e2 and a . e3.
    """
    za = np.empty(3, np.complex128)
    zb = np.empty(3, np.complex128)
    w = np.empty(3, np.complex128)
    for i in range(3):
        za[i], zb[i] = a[i] + STEP * 1j * da[i], b[i] + STEP * 1j * db[i]
    # the change of the spin along the motion is the bias: complex step in time
    _angular_velocity(za, zb, da.astype(np.complex128), db.astype(np.complex128), w)
    length, across, along = section_frame(a, b, E)
    for i in range(3):
        marker.w[i] = w[i].real
        marker.bias[3 + i] = w[i].imag / STEP
        for j in range(3):
            marker.R[i, j] = E[0, i] * fixed[j] + E[1, i] * fixed[3 + j] + E[2, i] * fixed[6 + j]
    return length, across, along


@kernel
def frame_stiffness(a, b, moment, scale, H):
    """Write -scale d(forces of a moment in W on the frame)/d(a, b) to H (6, 6), by complex step."""
    x = np.empty((2, 3), np.complex128)
    g = np.empty((2, 3), np.complex128)
    E = np.empty((3, 3), np.complex128)
    torque = np.empty(3, np.complex128)
    for i in range(3):
        x[0, i], x[1, i] = a[i], b[i]
    for column in range(6):
        kept = x[column // 3, column % 3]
        x[column // 3, column % 3] += STEP * 1j
        length, across, along = section_frame(x[0], x[1], E)
        x[column // 3, column % 3] = kept
        for m in range(3):
            torque[m] = E[m, 0] * moment[0] + E[m, 1] * moment[1] + E[m, 2] * moment[2]
        g[:] = 0.0
        spin_gradient(E, length, across, along, torque, g[0], g[1])
        for i in range(6):
            H[i, column] = -scale * g[i // 3, i % 3].imag / STEP
