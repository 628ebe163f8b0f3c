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
from flexmb.math.vectors import add_combination, add_cross, cross, dot, matvec, matvec_t

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
    bent = np.zeros((6, m))
    add_combination(eta, ww2.reshape((m, 6 * m)), bent.reshape(6 * m))  # ww2 is symmetric in its modes
    for j in range(m):
        for e in range(6):
            ww[e] += eta[j] * (bent[e, j] + ww1[j, e])
            W[j, e] = 2.0 * bent[e, j] + ww1[j, e]
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
    wn = wn0.copy()
    add_combination(eta, wn1.reshape((m, 3 * m)), wn.reshape(3 * m))
    for i in range(3):
        for j in range(m):
            M[i, 6 + j] = vn[i, j]
            M[6 + j, i] = vn[i, j]
            M[3 + i, 6 + j] = wn[i, j]
            M[6 + j, 3 + i] = wn[i, j]
    for j in range(m):
        for k in range(m):
            M[6 + j, 6 + k] = nn[j, k]


@kernel
def rates(terms, W, u, wnd, vwd, wwd, swing):
    """Write the rates of M_wn (3, m), M_vw (3, 3) and M_ww (6,), and ``swing[j] = c_j eta'`` (m, 3)."""
    vw1, wn1 = terms[2], terms[8]
    m = len(W)
    rate = u[6:]
    wnd[:] = 0.0
    vwd[:] = 0.0
    wwd[:] = 0.0
    add_combination(rate, wn1.reshape((m, 3 * m)), wnd.reshape(3 * m))
    add_combination(rate, vw1.reshape((m, 9)), vwd.reshape(9))
    add_combination(rate, W, wwd)
    modal_products(wn1, rate, swing)


@kernel
def modal_products(wn1, x, out):
    """Write ``c_j x`` (m, 3) of all modes to `out`, for x (m,); three sums at a time hide the latency of each."""
    for j in range(len(wn1)):
        a, b, c = 0.0, 0.0, 0.0
        for k in range(len(x)):
            a += wn1[j, 0, k] * x[k]
            b += wn1[j, 1, k] * x[k]
            c += wn1[j, 2, k] * x[k]
        out[j, 0], out[j, 1], out[j, 2] = a, b, c


@kernel
def add_inertia(terms, M, W, u, A, wnd, vwd, wwd, swing, P, out):
    """Add M A plus the quadratic velocity terms to `out` (6 + m,); A is the acceleration less gravity.

    `wnd`, `vwd`, `wwd`, `swing` come from `rates`; the momentum is left in `P` (6 + m,).
    """
    vw1 = terms[2]
    m = len(W)
    v = u[0:3]
    w = u[3:6]
    t = np.empty(3)
    P[:] = 0.0
    add_combination(u, M, P)
    add_combination(A, M, out)
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
    add_combination(w, wnd, out[6:])
    for j in range(m):
        modal = dot(w, swing[j])
        for i in range(3):
            for k in range(3):
                modal += v[i] * vw1[j, i, k] * w[k]
        symmetric_product(W[j], w, t)
        out[6 + j] -= modal + 0.5 * dot(w, t)


@kernel
def add_inertia_damping(terms, M, W, u, wnd, vwd, wwd, swing, P, scale, B):
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
            a[i] += t[i] + swing[j, i]
            B[3 + i, 6 + j] += scale * (a[i] + wnd[i, j])
            B[6 + j, 3 + i] += scale * (wnd[i, j] - a[i])
        for k in range(m):
            spin = wn1[j, 0, k] * w[0] + wn1[j, 1, k] * w[1] + wn1[j, 2, k] * w[2]
            B[6 + k, 6 + j] += scale * spin
            B[6 + j, 6 + k] -= scale * spin


@kernel
def add_inertia_stiffness(terms, W, u, A, swing, scale, B):
    """Add scale * d(M A + quadratic velocity terms)/deta to the modal columns of `B` (6 + m, 6 + m)."""
    vw1, ww2, wn1 = terms[2], terms[6], terms[8]
    m = len(W)
    v = u[0:3]
    w = u[3:6]
    alpha = A[3:6]
    a = np.empty(3)
    b = np.empty(3)
    t = np.empty(3)
    modal = np.empty((m, 3))
    modal_products(wn1, A[6:], modal)
    bending = np.zeros((6, m))  # half the rates of W
    add_combination(u[6:], ww2.reshape((m, 6 * m)), bending.reshape(6 * m))
    # weights of the six entries of a symmetric matrix in w . S w
    squares = np.empty(6)
    for i in range(3):
        squares[i] = -scale * w[i] * w[i]
        squares[3 + i] = -2.0 * scale * w[i] * w[(i + 1) % 3]
    turned = np.empty(m)
    for j in range(m):
        matvec(vw1[j], w, a)  # dP_v/deta_j
        symmetric_product(W[j], w, b)
        matvec_t(vw1[j], v, t)
        for i in range(3):
            b[i] += t[i] + swing[j, i]  # dP_w/deta_j
        matvec(vw1[j], alpha, t)
        add_cross(w, a, t)
        for i in range(3):
            B[i, 6 + j] += scale * t[i]
        symmetric_product(W[j], alpha, t)
        add_cross(w, b, t)
        add_cross(v, a, t)
        for i in range(3):
            t[i] += modal[j, i]
            for k in range(3):
                t[i] += vw1[j, k, i] * A[k]
        symmetric_product(bending[:, j], w, b)
        for i in range(3):
            B[3 + i, 6 + j] += scale * (t[i] + 2.0 * b[i])
        # modal rows: -1/2 w . dW_k/deta_j w, and M_wn^T w'
        add_combination(squares, ww2[j], B[6 + j, 6:])
        turned[:] = 0.0
        add_combination(alpha, wn1[j], turned)
        for k in range(m):
            B[6 + k, 6 + j] += scale * turned[k]
