"""The attraction of a distant centre on a reduced elastic body: a field over the moments of its mesh.

With x the place of the body's frame from the centre, in body axes, s(eta) the first and J(eta) the second moments of
mass about the frame, the potential is exact to second order in the size of the body (Hughes 1986, chapter 8):

    V = -mu m / |x| + mu s . x / |x|^3 - mu / (2 |x|^3) (tr J - 3 e . J e),    e = x / |x|.

s is linear and J quadratic in eta, both known from the reduction (theory: floating frame), so the forces on all
coordinates, -dV, cost nothing that grows with the mesh. The uniform part of the field is taken relative to an
origin that falls (see `falling`).
"""

from __future__ import annotations

import numpy as np

from flexmb.math.kernel import inner_kernel, kernel
from flexmb.math.vectors import cross, dot

__all__ = ["attract_elastic", "moments_of"]


def moments_of(data) -> np.ndarray:
    """Return mass, s (3,), its rates (3, m), J (3, 3), its linear (m, 3, 3) and quadratic part (m, m, 3, 3), flat."""
    i = data.invariants
    m = data.n_modes
    second = 0.5 * (i.ww2 + np.swapaxes(i.ww2, 0, 1)) if m else np.zeros((0, 0, 3, 3))
    arrays = [
        [i.vv[0, 0]],
        np.asarray(data.center_of_mass) * i.vv[0, 0],
        i.vn,
        _symmetric(i.ww0),
        _symmetric(i.ww1),
        _symmetric(second),
    ]
    return np.concatenate([np.asarray(a, float).ravel() for a in arrays])


def _symmetric(J) -> np.ndarray:
    return 0.5 * (np.asarray(J) + np.swapaxes(np.asarray(J), -1, -2))


@inner_kernel
def _times(J, x, out):
    for i in range(3):
        out[i] = J[i, 0] * x[0] + J[i, 1] * x[1] + J[i, 2] * x[2]


@inner_kernel
def _of_second_moment(J, x, mu, far, out):
    """Write the force -dV/dx of the second moment J; return what multiplies J in -V."""
    h = np.empty(3)
    _times(J, x, h)
    trace, s, b = J[0, 0] + J[1, 1] + J[2, 2], dot(x, h), 1.5 * mu / far**5
    for i in range(3):
        out[i] = -b * (trace * x[i] + 2.0 * h[i] - 5.0 * s * x[i] / far**2)
    return 0.5 * mu / far**3 * (trace - 3.0 * s / far**2)


@inner_kernel
def _of_second_moment_slope(J, x, dx, mu, far, out):
    """Write the change of `_of_second_moment` with x by dx."""
    h, dh = np.empty(3), np.empty(3)
    _times(J, x, h)
    _times(J, dx, dh)
    trace, s, b = J[0, 0] + J[1, 1] + J[2, 2], dot(x, h), 1.5 * mu / far**5
    log, ds = dot(x, dx) / far**2, 2.0 * dot(dx, h)
    for i in range(3):
        change = trace * dx[i] + 2.0 * dh[i] - 5.0 * (ds * x[i] + s * dx[i] - 2.0 * s * x[i] * log) / far**2
        out[i] = -b * (change - 5.0 * log * (trace * x[i] + 2.0 * h[i] - 5.0 * s * x[i] / far**2))


@inner_kernel
def _gradient(x, y, mu, far, out):
    """Write the gradient of the field times y: -mu / r^3 (y - 3 e (e . y))."""
    along = dot(x, y) / far**2
    for i in range(3):
        out[i] = -mu / far**3 * (y[i] - 3.0 * along * x[i])


@inner_kernel
def _gradient_slope(x, dx, y, mu, far, out):
    """Write the change of `_gradient` with x by dx."""
    log, along = dot(x, dx) / far**2, dot(x, y) / far**2
    change = dot(dx, y) / far**2 - 2.0 * log * along
    for i in range(3):
        out[i] = -mu / far**3 * (-3.0 * (change * x[i] + along * dx[i]) - 3.0 * log * (y[i] - 3.0 * along * x[i]))


@kernel
def attract_elastic(data, m, eta, x, uniform, mu, wanted, Q, K):
    """Set the forces Q (6 + m,) in body axes and, if wanted, their derivatives K by place, turn and eta; return V.

    x (3,) leads from the centre to the frame, `uniform` (3,) is the acceleration there that counts, both in body axes.
    """
    mass, s0, vn = data[0], data[1:4], data[4 : 4 + 3 * m].reshape((3, m))
    a = 4 + 3 * m
    J0, a = data[a : a + 9].reshape((3, 3)), a + 9
    J1, a = data[a : a + 9 * m].reshape((m, 3, 3)), a + 9 * m
    J2 = data[a : a + 9 * m * m].reshape((m, m, 3, 3))
    s, J, W = s0.copy(), J0.copy(), J1.copy()
    for j in range(m):
        for i in range(3):
            s[i] += vn[i, j] * eta[j]
        for k in range(m):
            W[j] += 2.0 * eta[k] * J2[j, k]
        J += 0.5 * eta[j] * (J1[j] + W[j])
    far = dot(x, x) ** 0.5
    force, part, turn, h = np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    V = -mu * mass / far + mu * dot(s, x) / far**3 - _of_second_moment(J, x, mu, far, force)
    _gradient(x, s, mu, far, part)
    for i in range(3):
        Q[i] = mass * uniform[i] + part[i] + force[i]
    _times(J, x, h)
    cross(x, h, turn)
    cross(s, uniform, part)
    for i in range(3):
        Q[3 + i] = part[i] + 3.0 * mu / far**5 * turn[i]
    for j in range(m):
        Q[6 + j] = _of_second_moment(W[j], x, mu, far, part)
        for i in range(3):
            Q[6 + j] += vn[i, j] * uniform[i]
    if wanted == 0:
        return V
    dx, da, ds, dh, own = np.empty(3), np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    unit, dJ = np.empty(3), np.empty((3, 3))
    for c in range(6 + m):
        dx[:], da[:], ds[:], dJ[:] = 0.0, 0.0, 0.0, 0.0
        if c < 3:
            dx[c] = 1.0
            _gradient(x, dx, mu, far, da)
        elif c < 6:  # the body turns: x and the acceleration turn backwards in its axes
            unit[:] = 0.0
            unit[c - 3] = 1.0
            cross(x, unit, dx)
            cross(uniform, unit, da)
        else:
            ds[:] = vn[:, c - 6]
            dJ[:] = W[c - 6]
        _gradient_slope(x, dx, s, mu, far, part)
        for i in range(3):
            K[i, c] = mass * da[i] + part[i]
        _gradient(x, ds, mu, far, part)
        _of_second_moment_slope(J, x, dx, mu, far, own)
        for i in range(3):
            K[i, c] += part[i] + own[i]
        _of_second_moment(dJ, x, mu, far, own)
        for i in range(3):
            K[i, c] += own[i]
        cross(ds, uniform, part)
        cross(s, da, own)
        for i in range(3):
            K[3 + i, c] = part[i] + own[i]
        b, log = 3.0 * mu / far**5, dot(x, dx) / far**2
        _times(J, dx, dh)
        _times(dJ, x, own)
        for i in range(3):
            dh[i] += own[i]
        cross(dx, h, part)
        cross(x, dh, own)
        for i in range(3):
            K[3 + i, c] += b * (part[i] + own[i] - 5.0 * log * turn[i])
        for j in range(m):
            _of_second_moment(W[j], x, mu, far, own)
            K[6 + j, c] = dot(own, dx)
            for i in range(3):
                K[6 + j, c] += vn[i, j] * da[i]
            if c >= 6:
                dJ[:] = 2.0 * J2[j, c - 6]
                K[6 + j, c] += _of_second_moment(dJ, x, mu, far, own)
                dJ[:] = W[c - 6]
    return V
