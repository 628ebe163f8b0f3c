"""Markers of a floating body: kinematics with deformation, and the derivative of their loads.

Position ``r + R (s + Phi_t eta)``, axes ``R exp(theta~) R_m`` with ``theta = Phi_r eta``; T is the left tangent of the
exponential, so the angular velocity in body axes is ``w + T Phi_r eta'``. Theory: floating frame, "markers".
"""

from __future__ import annotations

import numpy as np

from flexmb.bodies.frame_markers import add_load_stiffness, place_marker
from flexmb.math.kernel import inner_kernel, kernel
from flexmb.math.rotations import euler_to_matrix, exp_euler, rotation_tangent
from flexmb.math.vectors import add_combination, cross, dot, matvec, rotate_columns

__all__ = ["add_marker_stiffness", "loaded", "place_flexible_marker"]


@inner_kernel
def _tangent_rate(theta, rate, c, d, e, out):
    """Write T' rate to `out`, where T' is the rate of the left tangent while theta changes with `rate`.

    With T = I + a theta~ + b theta~^2: T' rate = a' theta x rate + b' theta x (theta x rate) + b rate x (theta x rate).
    c, d, e (3,) are overwritten.
    """
    x2 = dot(theta, theta)
    if x2 < 2.5e-3:
        b = 1.0 / 6.0 - x2 / 120.0 + x2 * x2 / 5040.0
        da = -1.0 / 12.0 + x2 / 180.0 - x2 * x2 / 6720.0
        db = -1.0 / 60.0 + x2 / 1260.0 - x2 * x2 / 60480.0
    else:
        x = x2**0.5
        b = (x - np.sin(x)) / (x2 * x)
        da = (x * np.sin(x) - 2.0 * (1.0 - np.cos(x))) / (x2 * x2)
        db = (3.0 * np.sin(x) - 2.0 * x - x * np.cos(x)) / (x2 * x2 * x)
    speed = dot(theta, rate)
    cross(theta, rate, c)
    cross(theta, c, d)
    cross(rate, c, e)
    for i in range(3):
        out[i] = speed * (da * c[i] + db * d[i]) + b * e[i]


@kernel
def place_flexible_marker(marker, J, q, u, R, m, data, at, vectors, matrices):
    """Write position, axes, twist, Jacobian and bias acceleration of a marker of a deformed body.

    `at` is where its place (3), axes (9), translation and rotation shapes (3 m each) begin in the data, R (3, 3) the
    axes of the body. `vectors` (12, 3) and `matrices` (4, 3, 3) are overwritten: arrays made for every marker cost
    more than all the rest.
    """
    place, slide, theta, rate = vectors[0], vectors[1], vectors[2], vectors[3]
    axes, E, turned, T = matrices[0], matrices[1], matrices[2], matrices[3]
    first, second = at + 12, at + 12 + 3 * m
    still = True
    for i in range(3):
        place[i], slide[i], theta[i], rate[i] = data[at + i], 0.0, 0.0, 0.0
        for j in range(3):
            axes[i, j] = data[at + 3 + 3 * i + j]
        for j in range(m):
            translation, rotation = data[first + i * m + j], data[second + i * m + j]
            place[i] += translation * q[7 + j]
            slide[i] += translation * u[6 + j]
            theta[i] += rotation * q[7 + j]
            rate[i] += rotation * u[6 + j]
        still = still and theta[i] == 0.0
    rotation_tangent(theta, T)
    if still:
        for i in range(3):  # a whole array at once would have numba compile the text of its error message
            for j in range(3):
                turned[i, j] = axes[i, j]
    else:
        p = vectors[4:6].reshape(6)
        exp_euler(theta, p)
        euler_to_matrix(p, E)
        rotate_columns(E, axes, turned)
    place_marker(marker, J, q[0:3], R, u, place, turned, vectors[4:6])
    # what deformation adds: velocities, 2 w x (Phi_t eta'), and the spin of the material
    spin, t, extra, swing = vectors[4], vectors[5], vectors[6], vectors[7]
    matvec(T, rate, spin)
    cross(u[3:6], slide, t)
    _tangent_rate(theta, rate, vectors[8], vectors[9], vectors[10], extra)
    cross(u[3:6], spin, swing)
    for i in range(3):
        for k in range(3):
            marker.v[i] += R[i, k] * slide[k]
            marker.w[i] += R[i, k] * spin[k]
            marker.bias[i] += 2.0 * R[i, k] * t[k]
            marker.bias[3 + i] += R[i, k] * (extra[k] + swing[k])
    start, nu = marker.iJ, marker.nu
    for i in range(3):
        for k in range(3):
            E[i, k] = R[i, 0] * T[0, k] + R[i, 1] * T[1, k] + R[i, 2] * T[2, k]
    for i in range(3):
        top, bottom = start + i * nu + 6, start + (3 + i) * nu + 6
        for j in range(m):
            J[top + j] = R[i, 0] * data[first + j] + R[i, 1] * data[first + m + j] + R[i, 2] * data[first + 2 * m + j]
            J[bottom + j] = (
                E[i, 0] * data[second + j] + E[i, 1] * data[second + m + j] + E[i, 2] * data[second + 2 * m + j]
            )


@kernel
def loaded(wrench):
    """Does a wrench (6,) act?"""
    largest = 0.0
    for i in range(6):
        largest = max(largest, abs(wrench[i]))
    return largest != 0.0


@kernel
def add_marker_stiffness(B, scale, R, q, m, s, translation, rotation, wrench):
    """Add scale * d(-J^T W)/d(configuration) of one marker to the body block `B`.

    The change of T with theta is kept to first order: dT^T N = 1/2 N x dtheta, an error of second order in the small
    rotation of the marker, in the Newton matrix only.
    """
    F = np.empty(3)
    N = np.empty(3)
    place = np.empty(3)
    theta = np.zeros(3)
    T = np.empty((3, 3))
    for i in range(3):
        place[i] = s[i]
        for j in range(m):
            place[i] += translation[i, j] * q[7 + j]
            theta[i] += rotation[i, j] * q[7 + j]
    rotation_tangent(theta, T)
    add_load_stiffness(B, scale, R, place, wrench, F, N)
    t = np.empty(3)
    c = np.empty(3)
    for j in range(m):
        b = rotation[:, j]
        # a load fixed in W turns backwards in body axes: dF = F x dphi, dN = N x dphi
        cross(F, translation[:, j], t)
        for i in range(3):
            B[3 + i, 6 + j] += scale * t[i]
            B[6 + j, 3 + i] += scale * t[i]
        matvec(T, b, c)
        cross(N, c, t)
        for i in range(3):
            B[6 + j, 3 + i] += scale * t[i]
        cross(b, N, t)
        for i in range(3):
            t[i] *= -0.5 * scale
        add_combination(t, rotation, B[6 + j, 6:])
