"""Forces in the axes of marker a that depend on how marker b moves relative to it: bushings, contacts, user forces.

The relative displacement and rotation vary as E times the variations of (r_a, theta_a, r_b, theta_b), E (6, 12)::

    dd = R^T (dr_b - dr_a - dtheta_a x d),   dpsi = R^T (dtheta_b - dtheta_a)

so force and moment f (6,) in the axes of a, on b at its marker, are the wrenches E^T f. Theory: eq. (relative-wrench).
"""

from __future__ import annotations

import numpy as np

from flexmb.constraints.rows import add_block
from flexmb.math.kernel import inner_kernel, kernel
from flexmb.math.vectors import add_skew, cross, dot, matvec, matvec_t

__all__ = ["act_at_point", "act_relative", "add_point_tangent", "add_relative_tangent", "relative_motion"]


@kernel
def relative_motion(a, b, motion, Q):
    """Write d, its rate, the angular velocity (3 each) of b relative to a to `motion` (9,), and R_a^T R_b to `Q`."""
    d = np.empty(3)
    v = np.empty(3)
    w = np.empty(3)
    t = np.empty(3)
    for i in range(3):
        d[i] = b.r[i] - a.r[i]
        w[i] = b.w[i] - a.w[i]
        for j in range(3):
            Q[i, j] = 0.0
            for k in range(3):
                Q[i, j] += a.R[k, i] * b.R[k, j]
    cross(a.w, d, t)
    for i in range(3):
        v[i] = b.v[i] - a.v[i] - t[i]
    matvec_t(a.R, d, motion[0:3])
    matvec_t(a.R, v, motion[3:6])
    matvec_t(a.R, w, motion[6:9])


@kernel
def act_relative(a, b, f):
    """Let f (6,), force and moment in the axes of a, act on b at its marker, and back on a."""
    F = np.empty(3)
    M = np.empty(3)
    d = np.empty(3)
    t = np.empty(3)
    matvec(a.R, f[0:3], F)
    matvec(a.R, f[3:6], M)
    for i in range(3):
        d[i] = b.r[i] - a.r[i]
    cross(d, F, t)
    for i in range(3):
        b.wrench[i] += F[i]
        b.wrench[3 + i] += M[i]
        a.wrench[i] -= F[i]
        a.wrench[3 + i] -= M[i] + t[i]


@inner_kernel
def _map(a, d, E):
    """Write E (6, 12)."""
    E[:] = 0.0
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        for m in range(3):
            E[m, i] = -a.R[i, m]
            E[m, 6 + i] = a.R[i, m]
            E[3 + m, 3 + i] = -a.R[i, m]
            E[3 + m, 9 + i] = a.R[i, m]
            # R^T d~: column i of d~ is d x e_i with the sign of -(e_i x d)
            E[m, 3 + i] = a.R[k, m] * -d[j] + a.R[j, m] * d[k]


@kernel
def add_relative_tangent(pair, a, b, f, stiffness, damping):
    """Add the tangent: stiffness = -df/d(d, psi), damping = -df/d(d', w), both (6, 6) in the axes of a."""
    E = np.empty((6, 12))
    left = np.empty(6)
    right = np.empty(6)
    d = np.empty(3)
    F = np.empty(3)
    M = np.empty(3)
    for i in range(3):
        d[i] = b.r[i] - a.r[i]
    _map(a, d, E)
    for j in range(12):
        for k in range(6):
            left[k] = 0.0
            right[k] = 0.0
            for m in range(6):
                left[k] += stiffness[k, m] * E[m, j]
                right[k] += damping[k, m] * E[m, j]
        for i in range(12):
            for k in range(6):
                pair.K[i, j] += E[k, i] * left[k]
                pair.D[i, j] += E[k, i] * right[k]
    matvec(a.R, f[0:3], F)
    matvec(a.R, f[3:6], M)
    _add_turning(pair, d, F)
    add_skew(pair.K, 9, 3, 1.0, M)
    add_skew(pair.K, 3, 3, -1.0, M)


@inner_kernel
def _add_turning(pair, d, F):
    """Add what a force F (in W) on b at d from a changes by where its axes turn with a,
    and its lever about a changes.
    """
    add_skew(pair.K, 6, 3, 1.0, F)
    add_skew(pair.K, 0, 3, -1.0, F)
    add_block(pair.K, 3, 3, -1.0, F, d, -dot(F, d))
    add_skew(pair.K, 3, 6, -1.0, F)
    add_skew(pair.K, 3, 0, 1.0, F)


@kernel
def act_at_point(a, b, f):
    """Let the force f (3,), in the axes of a, act on b at its marker, and back on a at the same point."""
    F = np.empty(3)
    d = np.empty(3)
    t = np.empty(3)
    matvec(a.R, f, F)
    for i in range(3):
        d[i] = b.r[i] - a.r[i]
    cross(d, F, t)
    for i in range(3):
        b.wrench[i] += F[i]
        a.wrench[i] -= F[i]
        a.wrench[3 + i] -= t[i]


@kernel
def add_point_tangent(pair, a, b, f, stiffness, damping):
    """Add the tangent of `act_at_point`: stiffness = -df/dd and damping = -df/dd', both (3, 3) in the axes of a.

    The rows of the moment on a are d x the rows of the force on b, its columns come by dd = dr_b - dr_a + d x dtheta_a.
    """
    d = np.empty(3)
    F = np.empty(3)
    row = np.empty((2, 9))  # of the force on b: by r_a, theta_a, r_b
    for i in range(3):
        d[i] = b.r[i] - a.r[i]
    matvec(a.R, f, F)
    force = np.empty((3, 2, 9))
    for i in range(3):
        for j in range(3):
            k, c = 0.0, 0.0
            for m in range(3):
                for n in range(3):
                    x = a.R[i, m] * a.R[j, n]
                    k += x * stiffness[m, n]
                    c += x * damping[m, n]
            row[0, j], row[1, j] = -k, -c
            row[0, 6 + j], row[1, 6 + j] = k, c
        for h in range(2):
            for j in range(3):
                m, n = (j + 1) % 3, (j + 2) % 3
                # column j of d~: -(e_j x d)
                row[h, 3 + j] = row[h, 6 + n] * -d[m] + row[h, 6 + m] * d[n]
        force[i] = row
    for i in range(3):
        m, n = (i + 1) % 3, (i + 2) % 3
        for j in range(9):
            pair.K[6 + i, j] += force[i, 0, j]
            pair.D[6 + i, j] += force[i, 1, j]
            pair.K[i, j] -= force[i, 0, j]
            pair.D[i, j] -= force[i, 1, j]
            pair.K[3 + i, j] -= d[m] * force[n, 0, j] - d[n] * force[m, 0, j]
            pair.D[3 + i, j] -= d[m] * force[n, 1, j] - d[n] * force[m, 1, j]
    _add_turning(pair, d, F)
