"""Geometric stiffness of a floating body: inertia loads, interface loads, load shapes, preload (Banerjee 1993).

The modal rows gain ``sum_i s_i G_i eta``; the scales s_i are the acceleration field ``a(x) = A + B x`` of the body
(gravity included in A), the total wrench on each interface in body axes, the amounts of the load shapes, 1. v' and w'
in it belong to the mean motion of the mass, not to the frame. A frame that is clamped to an interface follows its
vibration, and inertia loads of its acceleration would not be in equilibrium with anything (eq. (mean-motion)).
"""

from __future__ import annotations

import numpy as np

from flexmb.math.kernel import inner_kernel, kernel
from flexmb.math.vectors import add_combination, matvec_t

__all__ = ["add_stiffening", "add_stiffening_tangent", "load_scales", "mean_acceleration"]


@kernel
def mean_acceleration(mean, A, out):
    """Write the acceleration (v', w') (6,) of the mean motion of the mass, from frame and modes (6 + m,).

    `mean` (6, m) is the rigid motion with the momenta of each mode. Velocities stay the frame's: what the modes
    add to them is of third order in the energy, and half of it would not do.
    """
    for i in range(6):
        out[i] = A[i]
        for j in range(mean.shape[1]):
            out[i] += mean[i, j] * A[6 + j]


@kernel
def load_scales(u, acceleration, R, wrenches, amounts, s):
    """Write the scales of all unit loads to `s` (12 + 6 ni + nl + 1,); `acceleration` is the mean one, less gravity."""
    v = u[0:3]
    w = u[3:6]
    alpha = acceleration[3:6]
    ww = w[0] * w[0] + w[1] * w[1] + w[2] * w[2]
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        s[i] = acceleration[i] + w[j] * v[k] - w[k] * v[j]
        for m in range(3):
            s[3 + 3 * i + m] = w[i] * w[m]
        s[3 + 3 * i + i] -= ww
        s[3 + 3 * i + j] -= alpha[k]
        s[3 + 3 * i + k] += alpha[j]
    at = 12
    for n in range(len(wrenches)):
        wrench = wrenches[n].wrench
        matvec_t(R, wrench[0:3], s[at : at + 3])
        matvec_t(R, wrench[3:6], s[at + 3 : at + 6])
        at += 6
    for n in range(len(amounts)):
        s[at + n] = amounts[n]
    s[at + len(amounts)] = 1.0


@kernel
def add_stiffening(G, s, eta, products, out):
    """Add sum_i s_i G_i eta to `out` (m,); leave the products G_i eta in `products` (n, m).

    `G` (m, n, m) has row j of every symmetric G_i in G[j].
    """
    m, n = len(eta), len(s)
    products[:] = 0.0
    add_combination(eta, G.reshape((m, n * m)), products.reshape(n * m))
    add_combination(s, products, out)


@kernel
def add_stiffening_tangent(G, s, g, mean, u, R, fall, weights, B, wrenches, H):
    """Add the derivatives of the stiffening to the body block `B`, and those by marker wrenches to `H`.

    `g` (n, m) are the products G_i eta; `mean` as in `mean_acceleration`; `weights` of mass, damping and
    stiffness.
    """
    ck = weights.stiffness
    m = g.shape[1]
    if ck != 0.0:
        scaled = ck * s
        for j in range(m):
            add_combination(scaled, G[j], B[6 + j, 6:])
    _add_motion_tangent(g, mean, u, fall, weights, B)
    for n in range(len(wrenches)):
        marker = wrenches[n]
        at = 12 + 6 * n
        for half in range(2):
            top = at + 3 * half
            for j in range(m):
                for i in range(3):
                    a, b = (i + 1) % 3, (i + 2) % 3
                    # a wrench fixed in W turns backwards in body axes: dF = F x dphi
                    B[6 + j, 3 + i] += ck * (g[top + a, j] * s[top + b] - g[top + b, j] * s[top + a])
        if marker.iH >= 0:
            nu = marker.nu
            for half in range(2):
                for i in range(3):
                    start = marker.iH + (3 * half + i) * nu + 6
                    for j in range(m):
                        H[start + j] = (
                            R[i, 0] * g[at + 3 * half, j]
                            + R[i, 1] * g[at + 3 * half + 1, j]
                            + R[i, 2] * g[at + 3 * half + 2, j]
                        )


@inner_kernel
def _add_motion_tangent(g, mean, u, fall, weights, B):
    """Add the derivatives by the motion: acceleration, spin B = w w^T - |w|^2 I + w'~, and gravity in body axes."""
    cm, cd, ck = weights.mass, weights.damping, weights.stiffness
    m = g.shape[1]
    v = u[0:3]
    w = u[3:6]
    push = np.empty(6)
    for j in range(m):
        for i in range(3):
            a, b = (i + 1) % 3, (i + 2) % 3
            push[i] = g[i, j]
            push[3 + i] = g[3 + 3 * b + a, j] - g[3 + 3 * a + b, j]  # B_ba = +alpha_i, B_ab = -alpha_i
            # A = v' + w x v - R^T g; gravity turns backwards in body axes
            B[6 + j, i] += cd * (g[a, j] * w[b] - g[b, j] * w[a])
            spin = g[b, j] * v[a] - g[a, j] * v[b]
            for k in range(3):
                spin += (g[3 + 3 * i + k, j] + g[3 + 3 * k + i, j]) * w[k] - 2.0 * w[i] * g[3 + 3 * k + k, j]
            B[6 + j, 3 + i] += cd * spin - ck * (g[a, j] * fall[b] - g[b, j] * fall[a])
        for i in range(6):
            B[6 + j, i] += cm * push[i]
            for k in range(m):
                B[6 + j, 6 + k] += cm * push[i] * mean[i, k]
