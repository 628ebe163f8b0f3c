"""The element of a cable: two nodes with position and gradient, axial and bending strain of the centre line.

With the gradient ``rho = r'`` and ``sigma = r''`` at a point, the strain energy per length of the initial curve is
``1/2 EA (|rho| - l)^2 + 1/2 EI (|rho x sigma| / |rho|^2 - k)^2``. Gerstmayr & Shabana 2006 (element, quadrature: five
points for the axial, three for the bending part); Gerstmayr & Irschik 2008 (the two strains). eq. (cable-energy).

In an element of length L, gradients depend on three vectors only: d = (r_b - r_a)/L and the two nodal gradients. Forces
and stiffness are collected for these nine local freedoms, z = (d, r'_a, r'_b).
"""

from __future__ import annotations

import numpy as np

from flexmb.math.kernel import inner_kernel, kernel
from flexmb.math.vectors import cross, dot

__all__ = ["AXIAL", "BENDING", "ELEMENT", "cable_element"]

ELEMENT = 45
"""Numbers per element in the bulk data: length (1), mass (16), mass moments (4), axial points (5, 3), bending (3, 3).

A point has stiffness, strain-free value, damping, the first and last times the weight of the point.
"""


def _points(n: int) -> np.ndarray:
    """Return the Gauss points in 0..1."""
    return 0.5 * (1.0 + np.polynomial.legendre.leggauss(n)[0])


def _gradient(x) -> np.ndarray:
    """Return the coefficients of r' on z at x (n,): (n, 3)."""
    return np.stack([6 * x - 6 * x**2, 1 - 4 * x + 3 * x**2, 3 * x**2 - 2 * x], axis=1)


def _curvature(x) -> np.ndarray:
    """Return the coefficients of L r'' on z at x (n,): (n, 3)."""
    return np.stack([6 - 12 * x, 6 * x - 4, 6 * x - 2], axis=1)


AXIAL = np.ascontiguousarray(_gradient(_points(5)))
BENDING = np.ascontiguousarray(np.concatenate([_gradient(_points(3)), _curvature(_points(3))], axis=1))
STEP = 1e-30
STRAIGHT = 1e-6
"""Square of the curvature, times the length of the element, below which a line counts as straight for its damping."""
SMOOTH = 1e-6
"""Square of the share of the initial curvature by which the root in |curvature| is smoothed near zero."""


@inner_kernel
def _stretch_points(element, z, ck, W, U, V):
    """Add the five points of 1/2 k (|rho| - rest)^2 to W, and ck times their stiffness to U, V; return the energy."""
    strain = 0.0
    for g in range(5):
        k, rest = element[21 + 3 * g], element[22 + 3 * g]
        a0, a1, a2 = AXIAL[g, 0], AXIAL[g, 1], AXIAL[g, 2]
        x = a0 * z[0, 0] + a1 * z[1, 0] + a2 * z[2, 0]
        y = a0 * z[0, 1] + a1 * z[1, 1] + a2 * z[2, 1]
        v = a0 * z[0, 2] + a1 * z[1, 2] + a2 * z[2, 2]
        square = x * x + y * y + v * v
        length = square**0.5
        strain += 0.5 * k * (length - rest) ** 2
        tension = k * (1.0 - rest / length)
        t0, t1 = tension * a0, tension * a1
        W[0] += t0 * a0
        W[1] += t0 * a1
        W[2] += t0 * a2
        W[3] += t1 * a1
        W[4] += t1 * a2
        W[5] += tension * a2 * a2
        if ck != 0.0:
            f = ck * (k - tension) / square
            for m in range(3):
                a = AXIAL[g, m]
                U[g, 3 * m], U[g, 3 * m + 1], U[g, 3 * m + 2] = a * x, a * y, a * v
                V[g, 3 * m], V[g, 3 * m + 1], V[g, 3 * m + 2] = f * a * x, f * a * y, f * a * v
    return strain


@inner_kernel
def _squared_curvature(a, b, d, k0):
    """Return (kappa - k0)^2, its derivatives by a, b, d, and its second ones by aa, ab, bb, ad, bd, dd.

    With a = rho.rho, b = rho.sigma, d = sigma.sigma, the squared curvature is w = d/a - (b/a)^2.
    """
    r = 1.0 / a
    br, r2 = b * r, r * r
    w = d * r - br * br
    w_a, w_b, w_d = (2.0 * br * br - d * r) * r, -2.0 * br * r, r
    aa, ab, bb, ad = (2.0 * d * r - 6.0 * br * br) * r2, 4.0 * br * r2, -2.0 * r2, -r2
    if k0 <= 0.0:
        return w, w_a, w_b, w_d, aa, ab, bb, ad, 0.0, 0.0
    root = (w + SMOOTH * k0 * k0) ** 0.5
    rest = k0 * (1.0 + SMOOTH) ** 0.5
    first, second = 1.0 - rest / root, 0.5 * rest / root**3
    return (
        (root - rest) ** 2,
        first * w_a,
        first * w_b,
        first * w_d,
        first * aa + second * w_a * w_a,
        first * ab + second * w_a * w_b,
        first * bb + second * w_b * w_b,
        first * ad + second * w_a * w_d,
        second * w_b * w_d,
        second * w_d * w_d,
    )


@inner_kernel
def _bending_points(element, z, ck, W, U, V):
    """Add the three points of 1/2 k (kappa - k0)^2 to W, and ck times their stiffness to U, V; return the energy."""
    strain, inverse = 0.0, 1.0 / element[0]
    for g in range(3):
        k = 0.5 * element[36 + 3 * g]
        c0, c1, c2 = BENDING[g, 0], BENDING[g, 1], BENDING[g, 2]
        s0, s1, s2 = BENDING[g, 3] * inverse, BENDING[g, 4] * inverse, BENDING[g, 5] * inverse
        rho = (
            c0 * z[0, 0] + c1 * z[1, 0] + c2 * z[2, 0],
            c0 * z[0, 1] + c1 * z[1, 1] + c2 * z[2, 1],
            c0 * z[0, 2] + c1 * z[1, 2] + c2 * z[2, 2],
        )
        sigma = (
            s0 * z[0, 0] + s1 * z[1, 0] + s2 * z[2, 0],
            s0 * z[0, 1] + s1 * z[1, 1] + s2 * z[2, 1],
            s0 * z[0, 2] + s1 * z[1, 2] + s2 * z[2, 2],
        )
        a = rho[0] * rho[0] + rho[1] * rho[1] + rho[2] * rho[2]
        b = rho[0] * sigma[0] + rho[1] * sigma[1] + rho[2] * sigma[2]
        d = sigma[0] * sigma[0] + sigma[1] * sigma[1] + sigma[2] * sigma[2]
        value, w_a, w_b, w_d, aa, ab, bb, ad, bd, dd = _squared_curvature(a, b, d, element[37 + 3 * g])
        strain += k * value
        x, y, v = 2.0 * k * w_a, k * w_b, 2.0 * k * w_d
        W[0] += x * c0 * c0 + 2.0 * y * c0 * s0 + v * s0 * s0
        W[1] += x * c0 * c1 + y * (c0 * s1 + s0 * c1) + v * s0 * s1
        W[2] += x * c0 * c2 + y * (c0 * s2 + s0 * c2) + v * s0 * s2
        W[3] += x * c1 * c1 + 2.0 * y * c1 * s1 + v * s1 * s1
        W[4] += x * c1 * c2 + y * (c1 * s2 + s1 * c2) + v * s1 * s2
        W[5] += x * c2 * c2 + 2.0 * y * c2 * s2 + v * s2 * s2
        if ck != 0.0:
            k *= ck
            at = 5 + 3 * g
            for m in range(3):
                c, s = BENDING[g, m], BENDING[g, 3 + m] * inverse
                for i in range(3):
                    of_a, of_b, of_d = 2.0 * c * rho[i], c * sigma[i] + s * rho[i], 2.0 * s * sigma[i]
                    n = 3 * m + i
                    U[at, n], U[at + 1, n], U[at + 2, n] = of_a, of_b, of_d
                    V[at, n] = k * (aa * of_a + ab * of_b + ad * of_d)
                    V[at + 1, n] = k * (ab * of_a + bb * of_b + bd * of_d)
                    V[at + 2, n] = k * (ad * of_a + bd * of_b + dd * of_d)
    return strain


@inner_kernel
def _damping_force(rho, sigma, rrate, srate, c, straight, F):
    """Write the forces of the bending damping to F (2, 3) and return its power; passes a complex step.

    eq. (cable-bending-rate): the rate of the curvature without what a spin of the line about its tangent makes of it.
    Below the curvature `straight` (its square) that spin cannot be told and is not taken off.
    """
    a = dot(rho, rho)
    v = np.empty_like(rho)  # rho x sigma
    x = np.empty_like(rho)
    y = np.empty_like(rho)
    p = np.empty_like(rho)  # t x curvature
    cross(rho, sigma, v)
    cross(rrate, sigma, x)
    cross(rho, srate, y)
    cross(rho, v, p)
    along = dot(rho, rrate)
    for i in range(3):
        x[i] = (x[i] + y[i] - 2.0 * along * v[i] / a) / a
        p[i] /= a * a**0.5
    along = dot(rho, x) / a
    spin = dot(p, x) / (dot(v, v) / a**2 + straight)
    for i in range(3):
        y[i] = x[i] - rho[i] * along - p[i] * spin
    power = c * dot(x, y)
    bend = 2.0 * dot(y, v) / a**2
    cross(sigma, y, x)
    cross(y, rho, p)
    for i in range(3):
        F[0, i] = c * (x[i] / a - rho[i] * bend)
        F[1, i] = c * p[i] / a
    return power


@inner_kernel
def _bending_damping(rho, sigma, rrate, srate, c, straight, ck, cd, F, H):
    """Add the forces of the bending damping to F, ck and cd times its derivatives to H (by complex step, exact)."""
    x = np.empty((4, 3), np.complex128)
    G = np.empty((2, 3), np.complex128)
    for i in range(3):
        x[0, i], x[1, i], x[2, i], x[3, i] = rho[i], sigma[i], rrate[i], srate[i]
    power = _damping_force(x[0], x[1], x[2], x[3], c, straight, G).real
    for i in range(3):
        F[0, i] += G[0, i].real
        F[1, i] += G[1, i].real
    for half in range(2):
        weight = ck if half == 0 else cd
        if weight == 0.0:
            continue
        for k in range(6):
            row, column = 2 * half + k // 3, k % 3
            kept = x[row, column]
            x[row, column] += STEP * 1j
            _damping_force(x[0], x[1], x[2], x[3], c, straight, G)
            x[row, column] = kept
            for i in range(3):
                H[k // 3, 3 * i + k % 3] += weight * G[0, i].imag / STEP
                H[2 + k // 3, 3 * i + k % 3] += weight * G[1, i].imag / STEP
    return power


@inner_kernel
def _stiffness(W, U, V, ck, K):
    """Write U^T V + ck W x I, which is symmetric, to K: one block of two of the three vectors after the other."""
    w = 0
    for m in range(3):
        for n in range(m, 3):
            xx, xy, xz, yx, yy, yz, zx, zy, zz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
            for k in range(14):
                x, y, z = U[k, 3 * m], U[k, 3 * m + 1], U[k, 3 * m + 2]
                p, q, r = V[k, 3 * n], V[k, 3 * n + 1], V[k, 3 * n + 2]
                xx, xy, xz = xx + x * p, xy + x * q, xz + x * r
                yx, yy, yz = yx + y * p, yy + y * q, yz + y * r
                zx, zy, zz = zx + z * p, zy + z * q, zz + z * r
            own = ck * W[w]
            w += 1
            i, j = 3 * m, 3 * n
            K[i, j], K[i, j + 1], K[i, j + 2] = xx + own, xy, xz
            K[i + 1, j], K[i + 1, j + 1], K[i + 1, j + 2] = yx, yy + own, yz
            K[i + 2, j], K[i + 2, j + 1], K[i + 2, j + 2] = zx, zy, zz + own
            K[j, i], K[j, i + 1], K[j, i + 2] = xx + own, yx, zx
            K[j + 1, i], K[j + 1, i + 1], K[j + 1, i + 2] = xy, yy + own, zy
            K[j + 2, i], K[j + 2, i + 1], K[j + 2, i + 2] = xz, yz, zz + own


@inner_kernel
def _add_axial_damping(element, z, rate, ck, cd, f, K):
    """Add the forces of the damping c |rho|' along rho to f, ck and cd times their derivatives to K;
    return the power.
    """
    power = 0.0
    p = np.empty(9)
    rho = np.empty(3)
    rrate = np.empty(3)
    for g in range(5):
        c = element[23 + 3 * g]
        for i in range(3):
            rho[i] = AXIAL[g, 0] * z[0, i] + AXIAL[g, 1] * z[1, i] + AXIAL[g, 2] * z[2, i]
            rrate[i] = AXIAL[g, 0] * rate[0, i] + AXIAL[g, 1] * rate[1, i] + AXIAL[g, 2] * rate[2, i]
        square = dot(rho, rho)
        tension = c * dot(rho, rrate) / square
        power += tension * dot(rho, rrate)
        for m in range(3):
            for i in range(3):
                p[3 * m + i] = AXIAL[g, m] * rho[i]
                f[3 * m + i] += tension * p[3 * m + i]
        along, turning = (cd * c - 2.0 * ck * tension) / square, ck * c / square
        if ck == 0.0 and cd == 0.0:
            continue
        for n in range(3):
            for j in range(3):
                x = along * p[3 * n + j] + turning * AXIAL[g, n] * rrate[j]
                for k in range(9):
                    K[k, 3 * n + j] += p[k] * x
                for m in range(3):
                    K[3 * m + j, 3 * n + j] += ck * tension * AXIAL[g, m] * AXIAL[g, n]
    return power


@inner_kernel
def _add_bending_damping(element, z, rate, ck, cd, f, K):
    """Add the forces of the bending damping to f, ck and cd times their derivatives to K; return the power."""
    power, L = 0.0, element[0]
    x = np.empty((4, 3))
    F = np.zeros((2, 3))
    H = np.zeros((4, 9))
    for g in range(3):
        for i in range(3):
            x[:, i] = 0.0
            for m in range(3):
                x[0, i] += BENDING[g, m] * z[m, i]
                x[1, i] += BENDING[g, 3 + m] / L * z[m, i]
                x[2, i] += BENDING[g, m] * rate[m, i]
                x[3, i] += BENDING[g, 3 + m] / L * rate[m, i]
        F[:] = 0.0
        H[:] = 0.0
        power += _bending_damping(x[0], x[1], x[2], x[3], element[38 + 3 * g], STRAIGHT / L**2, ck, cd, F, H)
        for m in range(3):
            c1, s1 = BENDING[g, m], BENDING[g, 3 + m] / L
            for i in range(3):
                f[3 * m + i] += c1 * F[0, i] + s1 * F[1, i]
            for n in range(3):
                c2, s2 = BENDING[g, n], BENDING[g, 3 + n] / L
                for k in range(9):
                    K[3 * m + k // 3, 3 * n + k % 3] += c1 * (c2 * H[0, k] + s2 * H[1, k]) + s1 * (
                        c2 * H[2, k] + s2 * H[3, k]
                    )
    return power


@kernel
def cable_element(element, z, rate, ck, cd, f, K, scratch):
    """Write the forces f (9,) and ck dF/dz + cd dF/dz' to K (9, 9); return strain energy and dissipated power.

    The strain energy depends on products of the vectors z only: ``F = W z`` with a symmetric W (3, 3), and
    ``dF/dz = W x I + U^T V`` with three rows of U and V for a bending point and one for an axial point.

    Parameters
    ----------
    element : (45,)
        Its bulk data, see `ELEMENT`.
    z, rate : (3, 3)
        d, r'_a, r'_b and their rates.
        With ck = 0 what is added to it, zero without damping.
    scratch : (29, 9)
    """
    W, U, V = scratch[28], scratch[:14], scratch[14:28]
    W[:6] = 0.0
    strain = _stretch_points(element, z, ck, W, U, V) + _bending_points(element, z, ck, W, U, V)
    for i in range(3):
        f[i] = W[0] * z[0, i] + W[1] * z[1, i] + W[2] * z[2, i]
        f[3 + i] = W[1] * z[0, i] + W[3] * z[1, i] + W[4] * z[2, i]
        f[6 + i] = W[2] * z[0, i] + W[4] * z[1, i] + W[5] * z[2, i]
    if ck != 0.0:
        _stiffness(W, U, V, ck, K)
    power = 0.0
    if element[23] > 0.0:
        power += _add_axial_damping(element, z, rate, ck, cd, f, K)
    if element[38] > 0.0:
        power += _add_bending_damping(element, z, rate, ck, cd, f, K)
    return strain, power
