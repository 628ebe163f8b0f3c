"""Inertia of a floating body from its invariants: mass matrix, quadratic velocity terms and their derivatives.

With u = (v, w, eta'), momentum ``P = M_b(eta) u`` and W_j = dM_ww/deta_j (theory: floating frame)::

    force  = d/dt P_v + w x P_v
    moment = d/dt P_w + w x P_w + v x P_v
    modal  = d/dt P_eta - dT/deta
    dT/deta_j = v . S_j w + 1/2 w . W_j w + w . c_j eta',      S_j = vw1[j], c_j = wn1[j]

The cost is of second order in the number of modes and independent of the mesh.
"""

from __future__ import annotations

import numpy as np

from flexmb.math.kernel import kernel
from flexmb.math.vectors import add_cross, cross, dot, matvec, matvec_t

__all__ = ["add_inertia", "add_inertia_damping", "add_inertia_stiffness", "mass_matrix"]


@kernel
def symmetric_product(a, x, out):
    """Write A x to `out`, A stored as xx, yy, zz, xy, yz, zx."""
    out[0] = a[0] * x[0] + a[3] * x[1] + a[5] * x[2]
    out[1] = a[3] * x[0] + a[1] * x[1] + a[4] * x[2]
    out[2] = a[5] * x[0] + a[4] * x[1] + a[2] * x[2]


@kernel
def mass_matrix(terms, eta, M, W):
    """Write M_b(eta) (6 + m, 6 + m) to `M` and W_j (m, 6) to `W`."""
    vv, vw0, vw1, vn, ww0, ww1, ww2, wn0, wn1, nn = terms
    m = len(eta)
    ww = np.zeros(6)
    for j in range(m):
        for e in range(6):
            total = ww1[j, e]
            for k in range(m):
                total += 2.0 * eta[k] * ww2[j, k, e]
            W[j, e] = total
            ww[e] += 0.5 * eta[j] * (total + ww1[j, e])
    for i in range(3):
        for k in range(3):
            M[i, k] = vv[i, k]
            s = vw0[i, k]
            for j in range(m):
                s += eta[j] * vw1[j, i, k]
            M[i, 3 + k] = s
            M[3 + k, i] = s
            M[3 + i, 3 + k] = ww0[i, k]
        M[3 + i, 3 + i] += ww[i]
    for i in range(3):
        k = (i + 1) % 3
        M[3 + i, 3 + k] += ww[3 + i]
        M[3 + k, 3 + i] += ww[3 + i]
    for i in range(3):
        for j in range(m):
            c = wn0[i, j]
            for k in range(m):
                c += eta[k] * wn1[k, i, j]
            M[i, 6 + j] = vn[i, j]
            M[6 + j, i] = vn[i, j]
            M[3 + i, 6 + j] = c
            M[6 + j, 3 + i] = c
    for j in range(m):
        for k in range(m):
            M[6 + j, 6 + k] = nn[j, k]


@kernel
def rates(terms, W, u, wnd, vwd, wwd):
    """Write the rates of M_wn (3, m), M_vw (3, 3) and M_ww (6,) to the last three arguments."""
    vw1, wn1 = terms[2], terms[8]
    m = len(W)
    wnd[:] = 0.0
    vwd[:] = 0.0
    wwd[:] = 0.0
    for k in range(m):
        rate = u[6 + k]
        if rate == 0.0:
            continue
        for i in range(3):
            for j in range(m):
                wnd[i, j] += rate * wn1[k, i, j]
            for j in range(3):
                vwd[i, j] += rate * vw1[k, i, j]
        for e in range(6):
            wwd[e] += rate * W[k, e]


@kernel
def add_inertia(terms, M, W, u, A, wnd, vwd, wwd, P, out):
    """Add M A plus the quadratic velocity terms to `out` (6 + m,); A is the acceleration less gravity.

    `wnd`, `vwd`, `wwd` are the rates of the mass matrix; the momentum is left in `P` (6 + m,).
    """
    vw1, wn1 = terms[2], terms[8]
    m, n = len(W), 6 + len(W)
    v = u[0:3]
    w = u[3:6]
    t = np.empty(3)
    for i in range(n):
        momentum = 0.0
        force = 0.0
        for j in range(n):
            momentum += M[i, j] * u[j]
            force += M[i, j] * A[j]
        P[i] = momentum
        out[i] += force
    matvec(vwd, w, t)
    for i in range(3):
        out[i] += t[i]
    add_cross(w, P[0:3], out[0:3])
    matvec_t(vwd, v, t)
    for i in range(3):
        out[3 + i] += t[i]
        for j in range(m):
            out[3 + i] += wnd[i, j] * u[6 + j]
    symmetric_product(wwd, w, t)
    for i in range(3):
        out[3 + i] += t[i]
    add_cross(w, P[3:6], out[3:6])
    add_cross(v, P[0:3], out[3:6])
    for j in range(m):
        modal = 0.0
        for i in range(3):
            modal += wnd[i, j] * w[i]
            for k in range(3):
                modal -= v[i] * vw1[j, i, k] * w[k]
            for k in range(m):
                modal -= w[i] * wn1[j, i, k] * u[6 + k]
        symmetric_product(W[j], w, t)
        out[6 + j] += modal - 0.5 * dot(w, t)


@kernel
def add_inertia_damping(terms, M, W, u, wnd, vwd, wwd, P, scale, B):
    """Add scale * d(quadratic velocity terms)/du to `B` (6 + m, 6 + m)."""
    vw1, wn1 = terms[2], terms[8]
    m, n = len(W), 6 + len(W)
    v = u[0:3]
    w = u[3:6]
    t = np.empty(3)
    a = np.empty(3)
    # w x P_v, w x P_w + v x P_v: the momentum's part, columns of M
    for j in range(n):
        cross(w, M[0:3, j], t)
        for i in range(3):
            B[i, j] += scale * t[i]
        cross(w, M[3:6, j], t)
        add_cross(v, M[0:3, j], t)
        for i in range(3):
            B[3 + i, j] += scale * t[i]
    # the velocity's part, -P~
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        B[j, 3 + i] += scale * -P[k]
        B[k, 3 + i] += scale * P[j]
        B[3 + j, i] += scale * -P[k]
        B[3 + k, i] += scale * P[j]
        B[3 + j, 3 + i] += scale * -P[3 + k]
        B[3 + k, 3 + i] += scale * P[3 + j]
    for i in range(3):
        for j in range(3):
            B[i, 3 + j] += scale * vwd[i, j]
            B[3 + j, i] += scale * vwd[i, j]
        B[3 + i, 3 + i] += scale * wwd[i]
        j = (i + 1) % 3
        B[3 + i, 3 + j] += scale * wwd[3 + i]
        B[3 + j, 3 + i] += scale * wwd[3 + i]
    for j in range(m):
        matvec(vw1[j], w, a)
        for i in range(3):
            B[i, 6 + j] += scale * a[i]
            B[6 + j, i] -= scale * a[i]
        symmetric_product(W[j], w, a)
        matvec_t(vw1[j], v, t)
        for i in range(3):
            a[i] += t[i]
            for k in range(m):
                a[i] += wn1[j, i, k] * u[6 + k]
            B[3 + i, 6 + j] += scale * (a[i] + wnd[i, j])
            B[6 + j, 3 + i] += scale * (wnd[i, j] - a[i])
        for k in range(m):
            spin = wn1[j, 0, k] * w[0] + wn1[j, 1, k] * w[1] + wn1[j, 2, k] * w[2]
            B[6 + k, 6 + j] += scale * spin
            B[6 + j, 6 + k] -= scale * spin


@kernel
def add_inertia_stiffness(terms, W, u, A, scale, B):
    """Add scale * d(M A + quadratic velocity terms)/deta to the modal columns of `B` (6 + m, 6 + m)."""
    vw1, ww2, wn1 = terms[2], terms[6], terms[8]
    m = len(W)
    v = u[0:3]
    w = u[3:6]
    alpha = A[3:6]
    a = np.empty(3)
    b = np.empty(3)
    t = np.empty(3)
    for j in range(m):
        matvec(vw1[j], w, a)  # dP_v/deta_j
        symmetric_product(W[j], w, b)
        matvec_t(vw1[j], v, t)
        for i in range(3):
            b[i] += t[i]
            for k in range(m):
                b[i] += wn1[j, i, k] * u[6 + k]  # dP_w/deta_j
        matvec(vw1[j], alpha, t)
        add_cross(w, a, t)
        for i in range(3):
            B[i, 6 + j] += scale * t[i]
        symmetric_product(W[j], alpha, t)
        add_cross(w, b, t)
        add_cross(v, a, t)
        for i in range(3):
            for k in range(3):
                t[i] += vw1[j, k, i] * A[k]
            for k in range(m):
                t[i] += wn1[j, i, k] * A[6 + k]
        for k in range(m):
            symmetric_product(ww2[j, k], w, b)
            for i in range(3):
                t[i] += 2.0 * u[6 + k] * b[i]
            # modal rows: -1/2 w . dW_k/deta_j w, and M_wn^T w'
            B[6 + k, 6 + j] += scale * (
                wn1[j, 0, k] * alpha[0] + wn1[j, 1, k] * alpha[1] + wn1[j, 2, k] * alpha[2] - dot(w, b))
        for i in range(3):
            B[3 + i, 6 + j] += scale * t[i]
