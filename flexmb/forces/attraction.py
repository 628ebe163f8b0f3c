"""The attraction of a distant centre on a body of some size: force and torque to second order over the body.

With r from the centre to the centre of mass, e = r / |r| and J the inertia about it (Hughes 1986, chapter 8):

    F = -mu m e / r^2 - 3 mu / (2 r^4) ((tr J) e + 2 J e - 5 (e . J e) e),    T = 3 mu / r^3 e x J e,
    V = -mu m / r - mu / (2 r^3) (tr J - 3 e . J e),    (sums over principal axes)

In axes whose origin falls at the place rho a body at rho + d gets the difference of two attractions that are nearly the
same. It is taken without cancellation (Encke's method with Battin's function; Battin 1999, section 9.4):

    g(rho + d) - g(rho) = -mu / r^3 (d - f rho),
    f = q (3 + 3 q + q^2) / (1 + (1 + q)^1.5),   q = d . (d + 2 rho) / rho^2.
"""

from __future__ import annotations

import numpy as np

from flexmb.math.kernel import kernel
from flexmb.math.vectors import cross, dot, norm

__all__ = ["attract", "falling", "inertia_of"]


@kernel
def falling(rho, d, mu, out):
    """Set the attraction (3,), m/s2, at the place rho + d from the centre, less that at rho; all of it if rho is 0."""
    near = dot(rho, rho)
    far = 0.0
    for i in range(3):
        far += (rho[i] + d[i]) ** 2
    f = 0.0
    if near > 0.0:
        q = 0.0
        for i in range(3):
            q += d[i] * (d[i] + 2.0 * rho[i])
        q /= near
        f = q * (3.0 + q * (3.0 + q)) / (1.0 + (1.0 + q) ** 1.5)
    for i in range(3):
        out[i] = -mu / far**1.5 * (d[i] - f * rho[i])


@kernel
def attract(rho, d, R, mu, mass, inertia, wanted, field, K):
    """Set the force and the torque (6,) and, if wanted, minus their derivatives (6, 6) by place and turn; return V.

    rho (3,) leads from the centre to a point that falls freely, whose acceleration is left out (0: none is); d (3,)
    from there to the centre of mass; R (3, 3) are the axes of the body, which its inertia refers to.
    """
    r, pull = np.empty(3), np.empty(3)
    for i in range(3):
        r[i] = rho[i] + d[i]
    falling(rho, d, mu, pull)
    h, t, unit = np.empty(3), np.empty(3), np.empty(3)
    dr, dh, dF, dT = np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    J = np.empty((3, 3))
    trace = 0.0
    for i in range(3):
        trace += inertia[i, i]
        for j in range(3):
            J[i, j] = 0.0
            for k in range(3):
                for m in range(3):
                    J[i, j] += R[i, k] * inertia[k, m] * R[j, m]
    far = norm(r)
    for i in range(3):
        h[i] = J[i, 0] * r[0] + J[i, 1] * r[1] + J[i, 2] * r[2]
    s = dot(r, h)
    a, b = mu * mass / far**3, 1.5 * mu / far**5
    cross(r, h, t)
    for i in range(3):
        field[i] = mass * pull[i] - b * (trace * r[i] + 2.0 * h[i] - 5.0 * s * r[i] / far**2)
        field[3 + i] = 2.0 * b * t[i]
    potential = -mu * mass / far - 0.5 * mu / far**3 * (trace - 3.0 * s / far**2)
    if wanted == 0:
        return potential
    for j in range(6):
        unit[:] = 0.0
        unit[j % 3] = 1.0
        dr[:] = 0.0
        dh[:] = 0.0
        if j < 3:
            dr[:] = unit
            for i in range(3):
                dh[i] = J[i, j]
        else:  # d(J r) = theta x J r - J (theta x r)
            cross(unit, h, dh)
            cross(unit, r, dT)
            for i in range(3):
                dh[i] -= J[i, 0] * dT[0] + J[i, 1] * dT[1] + J[i, 2] * dT[2]
        ds = dot(dr, h) + dot(r, dh)
        dlog = dot(r, dr) / far**2  # of |r|
        da, db = -3.0 * a * dlog, -5.0 * b * dlog
        cross(dr, h, dF)
        cross(r, dh, dT)
        for i in range(3):
            bracket = trace * r[i] + 2.0 * h[i] - 5.0 * s * r[i] / far**2
            change = trace * dr[i] + 2.0 * dh[i]
            change -= 5.0 * (ds * r[i] + s * dr[i] - 2.0 * s * r[i] * dlog) / far**2
            K[i, j] = da * r[i] + a * dr[i] + db * bracket + b * change
            K[3 + i, j] = -2.0 * (db * t[i] + b * (dF[i] + dT[i]))
    return potential


def inertia_of(body) -> np.ndarray:
    """Return the inertia (3, 3) about the centre of mass, kg m2, in body axes; a point has none."""
    return np.asarray(getattr(body, "inertia", np.zeros((3, 3))), float)
