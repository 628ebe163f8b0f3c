"""Markers on a curve whose only gradient is its tangent: a frame from the tangent t and a fixed direction d.

The frame is (t, y, z) with z along ``d - (d . t) t`` and ``y = z x t``; a marker is fixed to it. Where the curve bends
and swings across d, the frame does not spin about the tangent; it does not exist for t parallel to d.
"""

from __future__ import annotations

import numpy as np

from flexmb.math.kernel import kernel
from flexmb.math.vectors import cross, dot

__all__ = ["add_frame_stiffness", "tangent_axes", "tangent_frame"]

CLOSEST = 1e-12
"""Smallest 1 - (d . t)^2: nearer to d the frame of this value is taken."""


def tangent_axes(t: np.ndarray, d: np.ndarray) -> np.ndarray:
    """Return the frame (3, 3) of a unit tangent and a fixed direction."""
    z = d - np.dot(d, t) * t
    z /= np.linalg.norm(z)
    return np.stack([t, np.cross(z, t), z], axis=1)


@kernel
def tangent_frame(d, fixed, rho, rate, R, w, bias, B):
    """Write axes, angular velocity, bias acceleration and d(w)/d(rho') of the frame at `rho` with its `rate`.

    `fixed` (3, 3) are the marker's axes in the frame. eq. (tangent-frame) and eq. (tangent-spin):
    ``w = t x t' + s ((d x t) . t') t``, ``s = (d . t) / (1 - (d . t)^2)``.
    """
    length = dot(rho, rho) ** 0.5
    t = np.empty(3)
    y = np.empty(3)
    dt = np.empty(3)
    second = np.empty(3)
    for i in range(3):
        t[i] = rho[i] / length
    stretch = dot(t, rate)
    for i in range(3):
        dt[i] = (rate[i] - t[i] * stretch) / length
    turn = dot(dt, dt)
    for i in range(3):
        second[i] = -2.0 * dt[i] * stretch / length - t[i] * turn
    tau = dot(d, t)
    square = max(1.0 - tau * tau, CLOSEST)
    root = square**0.5
    cross(d, t, y)
    for i in range(3):
        z = (d[i] - tau * t[i]) / root
        for j in range(3):
            R[i, j] = t[i] * fixed[0, j] + y[i] / root * fixed[1, j] + z * fixed[2, j]
    s = tau / square
    swing, rise = dot(y, dt), dot(d, dt)
    cross(t, dt, w)
    cross(t, second, bias)
    spin = rise * (1.0 + tau * tau) / square**2 * swing + s * dot(y, second)
    for i in range(3):
        w[i] += s * swing * t[i]
        bias[i] += spin * t[i] + s * swing * dt[i]
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        for m in range(3):
            B[i, m] = s * t[i] * y[m] / length
        B[i, j] -= t[k] / length
        B[i, k] += t[j] / length


@kernel
def add_frame_stiffness(d, rho, moment, scale, block):
    """Add scale * d(-B^T N)/d(rho) of a moment N (in W) to the block; ``B^T N = (N x t + s (t . N) d x t) / |rho|``."""
    length = dot(rho, rho) ** 0.5
    t = np.empty(3)
    y = np.empty(3)
    h = np.empty(3)
    dt = np.empty(3)
    dy = np.empty(3)
    dh = np.empty(3)
    for i in range(3):
        t[i] = rho[i] / length
    tau = dot(d, t)
    square = max(1.0 - tau * tau, CLOSEST)
    s, along = tau / square, dot(t, moment)
    cross(d, t, y)
    cross(moment, t, h)
    for i in range(3):
        h[i] += s * along * y[i]
    for m in range(3):
        # derivative along the unit vector m of rho
        for i in range(3):
            dt[i] = ((1.0 if i == m else 0.0) - t[i] * t[m]) / length
        cross(moment, dt, dh)
        cross(d, dt, dy)
        ds = dot(d, dt) * (1.0 + tau * tau) / square**2
        change = ds * along + s * dot(dt, moment)
        for i in range(3):
            value = dh[i] + change * y[i] + s * along * dy[i] - h[i] * t[m] / length
            block[i, m] -= scale * value / length
