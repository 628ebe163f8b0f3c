"""Rotations: Euler parameters (scalar first, unit norm), the exponential map of SO(3) and SE(3).

Conventions: p maps body to world axes, R = R_WB; velocities and increments are in body axes, so an increment
multiplies from the right: ``R <- R exp(theta~)``. Source: Brüls, Cardona & Arnold 2012, appendix.
"""

from __future__ import annotations

import numpy as np

from flexmb.math.kernel import inner_kernel, kernel
from flexmb.math.vectors import cross, dot

__all__ = [
    "advance_frame",
    "euler_product",
    "euler_to_matrix",
    "exp_euler",
    "log_euler",
    "matrix_to_euler",
    "relative_frame",
    "rotation_matrix",
    "rotation_tangent",
]


@kernel
def euler_to_matrix(p, R):
    """Write the rotation matrix of the Euler parameters `p` (4,) to `R` (3, 3)."""
    p0, p1, p2, p3 = p[0], p[1], p[2], p[3]
    R[0, 0] = p0 * p0 + p1 * p1 - p2 * p2 - p3 * p3
    R[1, 1] = p0 * p0 - p1 * p1 + p2 * p2 - p3 * p3
    R[2, 2] = p0 * p0 - p1 * p1 - p2 * p2 + p3 * p3
    R[0, 1] = 2.0 * (p1 * p2 - p0 * p3)
    R[1, 0] = 2.0 * (p1 * p2 + p0 * p3)
    R[0, 2] = 2.0 * (p1 * p3 + p0 * p2)
    R[2, 0] = 2.0 * (p1 * p3 - p0 * p2)
    R[1, 2] = 2.0 * (p2 * p3 - p0 * p1)
    R[2, 1] = 2.0 * (p2 * p3 + p0 * p1)


@kernel
def matrix_to_euler(R, p):
    """Write the Euler parameters of `R` to `p`, scalar part >= 0 (Shepperd 1978: largest pivot)."""
    trace = R[0, 0] + R[1, 1] + R[2, 2]
    k = 0
    largest = trace
    for i in range(3):
        if R[i, i] > largest:
            largest = R[i, i]
            k = i + 1
    if k == 0:
        p[0] = 1.0 + trace
        p[1] = R[2, 1] - R[1, 2]
        p[2] = R[0, 2] - R[2, 0]
        p[3] = R[1, 0] - R[0, 1]
    else:
        i = k - 1
        j = (i + 1) % 3
        n = (i + 2) % 3
        p[0] = R[n, j] - R[j, n]
        p[1 + i] = 1.0 + 2.0 * R[i, i] - trace
        p[1 + j] = R[i, j] + R[j, i]
        p[1 + n] = R[i, n] + R[n, i]
    length = (p[0] * p[0] + p[1] * p[1] + p[2] * p[2] + p[3] * p[3]) ** 0.5
    if p[0] < 0.0:
        length = -length
    for i in range(4):
        p[i] /= length


@kernel
def euler_product(a, b, out):
    """Write the product a o b (first b, then a, seen from world) to `out`."""
    out[0] = a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3]
    out[1] = a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2]
    out[2] = a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1]
    out[3] = a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0]


@kernel
def exp_euler(theta, p):
    """Write the Euler parameters of the rotation vector `theta` (rad) to `p`."""
    angle = (theta[0] ** 2 + theta[1] ** 2 + theta[2] ** 2) ** 0.5
    s = 0.5 - angle * angle / 48.0 if angle < 1e-4 else np.sin(0.5 * angle) / angle
    p[0] = np.cos(0.5 * angle)
    p[1] = s * theta[0]
    p[2] = s * theta[1]
    p[3] = s * theta[2]


@kernel
def log_euler(p, theta):
    """Write the rotation vector (rad, length <= pi) of the Euler parameters `p` to `theta`."""
    s = (p[1] * p[1] + p[2] * p[2] + p[3] * p[3]) ** 0.5
    sign = 1.0 if p[0] >= 0.0 else -1.0
    scale = 2.0 * sign if s < 1e-8 else 2.0 * np.arctan2(s, sign * p[0]) * sign / s
    for i in range(3):
        theta[i] = scale * p[1 + i]


@inner_kernel
def _series(angle):
    """Coefficients a = (1 - cos x)/x^2 and b = (x - sin x)/x^3 of the exponential's tangent."""
    if angle < 1e-3:
        x2 = angle * angle
        return 0.5 - x2 / 24.0, 1.0 / 6.0 - x2 / 120.0
    return (1.0 - np.cos(angle)) / angle**2, (angle - np.sin(angle)) / angle**3


@kernel
def rotation_tangent(theta, T):
    """Write T = I + a theta~ + b theta~^2 to `T`: exp(theta + d) ~ exp((T d)~) exp(theta).

    T is the left tangent; T^T is the right one. It also is the integral of exp(s theta~) over s = 0..1, which maps
    the translation part of an SE(3) increment.
    """
    x, y, z = theta[0], theta[1], theta[2]
    x2 = x * x + y * y + z * z
    a, b = _series(x2**0.5)
    T[0, 0] = 1.0 + b * (x * x - x2)
    T[1, 1] = 1.0 + b * (y * y - x2)
    T[2, 2] = 1.0 + b * (z * z - x2)
    T[0, 1] = -a * z + b * x * y
    T[1, 0] = a * z + b * x * y
    T[0, 2] = a * y + b * x * z
    T[2, 0] = -a * y + b * x * z
    T[1, 2] = -a * x + b * y * z
    T[2, 1] = a * x + b * y * z


@kernel
def advance_frame(frame, d, scale, out):
    """Write (r, p) [+] scale d to `out`: frame (7,) = r in W and p; d (6,) = translation and rotation in body axes."""
    theta = np.empty(3)
    T = np.empty((3, 3))
    R = np.empty((3, 3))
    step = np.empty(4)
    shift = np.empty(3)
    for i in range(3):
        theta[i] = scale * d[3 + i]
    rotation_tangent(theta, T)
    euler_to_matrix(frame[3:7], R)
    for i in range(3):
        shift[i] = scale * (T[i, 0] * d[0] + T[i, 1] * d[1] + T[i, 2] * d[2])
    exp_euler(theta, step)
    a0, a1, a2, a3 = frame[3], frame[4], frame[5], frame[6]
    q0 = a0 * step[0] - a1 * step[1] - a2 * step[2] - a3 * step[3]
    q1 = a0 * step[1] + a1 * step[0] + a2 * step[3] - a3 * step[2]
    q2 = a0 * step[2] - a1 * step[3] + a2 * step[0] + a3 * step[1]
    q3 = a0 * step[3] + a1 * step[2] - a2 * step[1] + a3 * step[0]
    # renormalised by construction: round-off of a long run would otherwise shrink the axes
    length = (q0 * q0 + q1 * q1 + q2 * q2 + q3 * q3) ** 0.5
    for i in range(3):
        out[i] = frame[i] + R[i, 0] * shift[0] + R[i, 1] * shift[1] + R[i, 2] * shift[2]
    out[3] = q0 / length
    out[4] = q1 / length
    out[5] = q2 / length
    out[6] = q3 / length


@kernel
def relative_frame(a, b, d):
    """Write the increment d (6,) with b = a [+] d to `d`: the inverse of `advance_frame`."""
    R = np.empty((3, 3))
    inverse = np.empty(4)
    step = np.empty(4)
    T = np.empty((3, 3))
    shift = np.empty(3)
    inverse[0] = a[3]
    for i in range(1, 4):
        inverse[i] = -a[3 + i]
    euler_product(inverse, b[3:7], step)
    log_euler(step, d[3:6])
    euler_to_matrix(a[3:7], R)
    for i in range(3):
        shift[i] = R[0, i] * (b[0] - a[0]) + R[1, i] * (b[1] - a[1]) + R[2, i] * (b[2] - a[2])
    rotation_tangent(d[3:6], T)
    # T x = shift by Cramer's rule: det T = 2 (1 - cos a) / a^2 is at least 0.4, as a <= pi
    cofactors = np.empty((3, 3))
    cross(T[1], T[2], cofactors[0])
    cross(T[2], T[0], cofactors[1])
    cross(T[0], T[1], cofactors[2])
    determinant = dot(T[0], cofactors[0])
    for i in range(3):
        d[i] = (cofactors[0, i] * shift[0] + cofactors[1, i] * shift[1] + cofactors[2, i] * shift[2]) / determinant


def rotation_matrix(rotation) -> np.ndarray:
    """Return the rotation matrix (3, 3) of a rotation vector (3,), rad, a matrix (3, 3), a scipy Rotation, or None."""
    if rotation is None:
        return np.eye(3)
    if hasattr(rotation, "as_matrix"):
        return np.asarray(rotation.as_matrix(), float)
    array = np.asarray(rotation, float)
    if array.shape == (3, 3):
        return array.copy()
    p, R = np.empty(4), np.empty((3, 3))
    exp_euler(array, p)
    euler_to_matrix(p, R)
    return R
