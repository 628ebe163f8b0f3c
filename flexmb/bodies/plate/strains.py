"""Strains of a surface at a point with forces and tangents: products of local vectors, and curvatures with the normal.

Local vectors ``x`` (L, 3) are sums of the nodal vectors of an element. Membrane strains, the bending of plates with
directors and shear are quadratic, ``s_k = sum c x_i . x_j``; curvatures of a thin plate are ``n . r_ab`` with the unit
normal n. The derivatives are written by hand and exact. eq. (plate-membrane), (plate-curvature), (plate-director).
"""

from __future__ import annotations

import numpy as np

from flexmb.math.kernel import inner_kernel, kernel
from flexmb.math.vectors import cross, dot

__all__ = ["add_curvature", "add_quadratic", "collect", "isotropic", "local_vectors"]


@kernel
def isotropic(stiffness, nu, C, k):
    """Write the plane-stress matrix of the strains 11, 22, 2 x 12 times a stiffness to C, from row k on."""
    C[k, k] = C[k + 1, k + 1] = stiffness
    C[k, k + 1] = C[k + 1, k] = stiffness * nu
    C[k + 2, k + 2] = 0.5 * stiffness * (1.0 - nu)


@kernel
def local_vectors(data, at, q, x):
    """Write the sums of nodal vectors q (V, 3) with the coefficients (L, V) in `data` to x (L, 3)."""
    V = q.shape[0]
    for m in range(x.shape[0]):
        for i in range(3):
            x[m, i] = 0.0
        for v in range(V):
            c = data[at + m * V + v]
            if c != 0.0:
                for i in range(3):
                    x[m, i] += c * q[v, i]


@kernel
def collect(data, at, out, H, tangent, f, K):
    """Add local forces (L, 3) and the local matrix (3 L, 3 L) to f (V, 3) and K (3 V, 3 V) of the nodal vectors."""
    L, V = out.shape[0], f.shape[0]
    for m in range(L):
        for v in range(V):
            c = data[at + m * V + v]
            for i in range(3):
                f[v, i] += c * out[m, i]
    if not tangent:
        return
    T = np.zeros((3 * L, 3 * V))
    for i in range(3 * L):
        for m in range(L):
            for v in range(V):
                c = data[at + m * V + v]
                if c != 0.0:
                    for j in range(3):
                        T[i, 3 * v + j] += c * H[i, 3 * m + j]
    for m in range(L):
        for v in range(V):
            c = data[at + m * V + v]
            if c != 0.0:
                for i in range(3):
                    row, source = K[3 * v + i], T[3 * m + i]
                    for j in range(3 * V):
                        row[j] += c * source[j]


@inner_kernel
def _add_material(g, gu, C, n, alpha, beta, out, H):
    """Add sum n_k g_k to `out` and sum C_kl g_k (alpha g_l + beta gu_l) to H."""
    m, L = g.shape[0], g.shape[1]
    for k in range(m):
        for v in range(L):
            for i in range(3):
                out[v, i] += n[k] * g[k, v, i]
    if alpha == 0.0:
        return
    for k in range(m):
        for p in range(m):
            c = C[k, p]
            if c == 0.0:
                continue
            for v in range(L):
                for i in range(3):
                    left = c * g[k, v, i]
                    if left != 0.0:
                        for w in range(L):
                            for j in range(3):
                                H[3 * v + i, 3 * w + j] += left * (alpha * g[p, w, j] + beta * gu[p, w, j])


@inner_kernel
def _resultants(g, s, rest, at, rate, C, tau, n):
    """Write C (s - rest + tau s') to n; return energy and dissipated power."""
    m = g.shape[0]
    energy, power = 0.0, 0.0
    speed = np.zeros(m)
    if tau > 0.0:
        for k in range(m):
            for v in range(g.shape[1]):
                speed[k] += dot(g[k, v], rate[v])
    for k in range(m):
        elastic, viscous = 0.0, 0.0
        for p in range(m):
            elastic += C[k, p] * (s[p] - rest[at + p])
            viscous += tau * C[k, p] * speed[p]
        n[k] = elastic + viscous
        energy += 0.5 * elastic * (s[k] - rest[at + k])
        power += viscous * speed[k]
    return energy, power


@inner_kernel
def _products(P, x, s, g):
    """Write strains s_k = sum c x_i . x_j over the rows (k, i, j, c) of P, and their gradients (m, L, 3)."""
    s[:] = 0.0
    g[:] = 0.0
    for row in range(P.shape[0]):
        k, i, j, c = int(P[row, 0]), int(P[row, 1]), int(P[row, 2]), P[row, 3]
        s[k] += c * dot(x[i], x[j])
        for d in range(3):
            g[k, i, d] += c * x[j, d]
            g[k, j, d] += c * x[i, d]


@kernel
def add_quadratic(P, x, rate, rest, at, C, tau, ck, cd, out, H):
    """Add forces and matrix of quadratic strains (m of C) to `out` (L, 3) and H (3 L, 3 L).

    `rest[at:]` are the strains without stress. Returns strain energy and dissipated power.
    """
    m, L = C.shape[0], x.shape[0]
    s = np.empty(m)
    n = np.empty(m)
    g = np.empty((m, L, 3))
    gu = np.zeros((m, L, 3))
    if tau > 0.0:
        _products(P, rate, s, gu)
    _products(P, x, s, g)
    energy, power = _resultants(g, s, rest, at, rate, C, tau, n)
    _add_material(g, gu, C, n, ck + tau * cd, ck * tau, out, H)
    if ck != 0.0:
        for row in range(P.shape[0]):
            k, i, j, c = int(P[row, 0]), int(P[row, 1]), int(P[row, 2]), P[row, 3]
            for d in range(3):
                H[3 * i + d, 3 * j + d] += ck * n[k] * c
                H[3 * j + d, 3 * i + d] += ck * n[k] * c
    return energy, power


@inner_kernel
def _turned(M, normal, area, p):
    """Write p = (I - n n^T) M / |c|, the derivative of n . M by c = r_1 x r_2; return n . M."""
    kappa = dot(normal, M)
    for i in range(3):
        p[i] = (M[i] - kappa * normal[i]) / area
    return kappa


@inner_kernel
def _second_turn(kappa, p, normal, area, dc, dM, out):
    """Write the change of p for changes of c and M."""
    along, onto = dot(normal, dc), dot(normal, dM)
    turn = dot(p, dc)
    for i in range(3):
        across = (dc[i] - along * normal[i]) / area
        out[i] = (dM[i] - onto * normal[i] - kappa * across - normal[i] * turn - p[i] * along) / area


@inner_kernel
def _gradient_change(x, dx, M, dM, normal, area, out):
    """Write the change (2, 3) of the derivative of n . M by r_1, r_2 for changes dx (2, 3), dM (3,); add nothing.

    The derivatives are r_2 x p and p x r_1.
    """
    p = np.empty(3)
    dp = np.empty(3)
    dc = np.empty(3)
    t = np.empty(3)
    kappa = _turned(M, normal, area, p)
    cross(dx[0], x[1], dc)
    cross(x[0], dx[1], t)
    for i in range(3):
        dc[i] += t[i]
    _second_turn(kappa, p, normal, area, dc, dM, dp)
    cross(dx[1], p, out[0])
    cross(x[1], dp, t)
    for i in range(3):
        out[0, i] += t[i]
    cross(dp, x[0], out[1])
    cross(p, dx[0], t)
    for i in range(3):
        out[1, i] += t[i]
    return


@inner_kernel
def _add_curvature_hessian(x, n, normal, area, ck, H):
    """Add ck sum n_k d2(kappa_k) to H (15, 15): columns of r_1, r_2; columns of the second derivatives by symmetry."""
    M = np.empty(3)
    dM = np.zeros(3)
    dx = np.zeros((2, 3))
    t = np.empty((2, 3))
    for i in range(3):
        M[i] = n[0] * x[2, i] + n[1] * x[3, i] + 2.0 * n[2] * x[4, i]
    for column in range(6):
        dx[column // 3, column % 3] = 1.0
        _gradient_change(x, dx, M, dM, normal, area, t)
        dx[column // 3, column % 3] = 0.0
        for i in range(6):
            H[i, column] += ck * t[i // 3, i % 3]
    for d in range(3):
        # derivative by r_ab along axis d: dM = n_ab e_d
        dM[d] = 1.0
        M[:] = 0.0
        _gradient_change(x, dx, M, dM, normal, area, t)
        dM[d] = 0.0
        for i in range(6):
            for k in range(3):
                value = ck * n[k] * (2.0 if k == 2 else 1.0) * t[i // 3, i % 3]
                H[i, 6 + 3 * k + d] += value
                H[6 + 3 * k + d, i] += value


@kernel
def add_curvature(x, rate, rest, at, C, tau, ck, cd, out, H):
    """Add forces and matrix of the curvatures n . r_11, n . r_22, 2 n . r_12 to `out` (5, 3) and H (15, 15).

    x : r_1, r_2, r_11, r_22, r_12. Returns strain energy and dissipated power.
    """
    normal = np.empty(3)
    p = np.empty(3)
    s = np.empty(3)
    n = np.empty(3)
    g = np.zeros((3, 5, 3))
    gu = np.zeros((3, 5, 3))
    cross(x[0], x[1], normal)
    area = dot(normal, normal) ** 0.5
    for i in range(3):
        normal[i] /= area
    for k in range(3):
        f = 2.0 if k == 2 else 1.0
        s[k] = f * _turned(x[2 + k], normal, area, p)
        cross(x[1], p, g[k, 0])
        cross(p, x[0], g[k, 1])
        for i in range(3):
            g[k, 0, i] *= f
            g[k, 1, i] *= f
            g[k, 2 + k, i] = f * normal[i]
    energy, power = _resultants(g, s, rest, at, rate, C, tau, n)
    if tau > 0.0 and ck != 0.0:
        _rate_gradients(x, rate, normal, area, gu)
    _add_material(g, gu, C, n, ck + tau * cd, ck * tau, out, H)
    if ck != 0.0:
        _add_curvature_hessian(x, n, normal, area, ck, H)
    return energy, power


@inner_kernel
def _rate_gradients(x, rate, normal, area, gu):
    """Write the rates of the gradients of the curvatures to gu (3, 5, 3)."""
    dc = np.empty(3)
    t = np.empty(3)
    cross(rate[0], x[1], dc)
    cross(x[0], rate[1], t)
    for i in range(3):
        dc[i] += t[i]
    along = dot(normal, dc)
    for k in range(3):
        f = 2.0 if k == 2 else 1.0
        _gradient_change(x, rate, x[2 + k], rate[2 + k], normal, area, gu[k])
        for i in range(3):
            gu[k, 0, i] *= f
            gu[k, 1, i] *= f
            gu[k, 2 + k, i] = f * (dc[i] - along * normal[i]) / area
