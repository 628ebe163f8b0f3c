"""The element of a cable: two nodes with position and gradient, axial and bending strain of the centre line.

With the gradient ``rho = r'`` and ``sigma = r''`` at a point, the strain energy per length of the initial curve is
``1/2 EA (|rho| - l)^2 + 1/2 EI (|rho x sigma| / |rho|^2 - k)^2``. Gerstmayr & Shabana 2006 (element, quadrature: five
points for the axial, three for the bending part); Gerstmayr & Irschik 2008 (the two strains). eq. (cable-energy).

In an element of length L, gradients depend on three vectors only: d = (r_b - r_a)/L and the two nodal gradients. Forces
and stiffness are collected for these nine local freedoms, z = (d, r'_a, r'_b).
"""

from __future__ import annotations

import numpy as np

from flexmb.math.kernel import kernel
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


@kernel
def _bending(rho, sigma, stiffness, k0, scale, gr, gs, F, H):
    """Add the forces of 1/2 k (|rho x sigma|/|rho|^2 - k0)^2 to F (2, 3), scale times its Hessian to H; return it.

    H (4, 9) has the blocks rho rho, rho sigma, sigma rho, sigma sigma, each row by row; gr, gs (3,) are scratch.

    With a = rho.rho, b = rho.sigma, d = sigma.sigma, the squared curvature is w = d/a - (b/a)^2.
    """
    a, b, d = dot(rho, rho), dot(rho, sigma), dot(sigma, sigma)
    r = 1.0 / a
    br, r2 = b * r, r * r
    w = d * r - br * br
    first, second, value = 1.0, 0.0, w
    if k0 > 0.0:
        root = (w + SMOOTH * k0 * k0) ** 0.5
        rest = k0 * (1.0 + SMOOTH) ** 0.5
        value = (root - rest) ** 2
        first = 1.0 - rest / root
        second = 0.5 * rest / root**3
    w_a, w_b, w_d = (2.0 * br * br - d * r) * r, -2.0 * br * r, r
    for i in range(3):
        gr[i] = 2.0 * w_a * rho[i] + w_b * sigma[i]
        gs[i] = w_b * rho[i] + 2.0 * w_d * sigma[i]
        F[0, i] += 0.5 * stiffness * first * gr[i]
        F[1, i] += 0.5 * stiffness * first * gs[i]
    if scale != 0.0:
        aa, ab, bb, ad = (2.0 * d * r - 6.0 * br * br) * r2, 4.0 * br * r2, -2.0 * r2, -r2
        x, y = 0.5 * stiffness * scale * first, 0.5 * stiffness * scale * second
        for i in range(3):
            for j in range(3):
                rr, rs, sr, ss = rho[i] * rho[j], rho[i] * sigma[j], sigma[i] * rho[j], sigma[i] * sigma[j]
                k = 3 * i + j
                H[0, k] += x * (4.0 * aa * rr + 2.0 * ab * (rs + sr) + bb * ss) + y * gr[i] * gr[j]
                H[1, k] += x * (2.0 * ab * rr + 4.0 * ad * rs + bb * sr) + y * gr[i] * gs[j]
                H[2, k] += x * (2.0 * ab * rr + 4.0 * ad * sr + bb * rs) + y * gs[i] * gr[j]
                H[3, k] += x * bb * rr + y * gs[i] * gs[j]
            H[0, 4 * i] += 2.0 * x * w_a
            H[1, 4 * i] += x * w_b
            H[2, 4 * i] += x * w_b
            H[3, 4 * i] += 2.0 * x * w_d
    return 0.5 * stiffness * value


@kernel
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


@kernel
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


@kernel
def _axial(rho, rate, k, rest, c, ck, cd, F, H):
    """Write the force of 1/2 k (|rho| - rest)^2 and of the damping to F, and the derivatives to H; return both."""
    length = dot(rho, rho) ** 0.5
    r = 1.0 / length
    speed = dot(rho, rate) * r
    tension = k * (length - rest) + c * speed
    for i in range(3):
        F[i] = tension * r * rho[i]
    if ck != 0.0 or cd != 0.0:
        along = (ck * (k - tension * r) + cd * c - ck * c * speed * r) * r * r
        turning = ck * c * r * r
        for i in range(3):
            for j in range(3):
                H[3 * i + j] = rho[i] * (along * rho[j] + turning * rate[j])
            H[4 * i] += ck * tension * r
    return 0.5 * k * (length - rest) ** 2, c * speed * speed


@kernel
def cable_element(data, start, z, rate, ck, cd, f, K, scratch):
    """Write the forces f (9,) and ck dF/dz + cd dF/dz' to K (3, 3, 9); return strain energy and dissipated power.

    Parameters
    ----------
    data, start : bulk data and where the element begins
    z, rate : (3, 3)
        d, r'_a, r'_b and their rates.
    K : (3, 3, 9)
        A block, row by row, for every two of the three vectors.
    scratch : (20, 3)
    """
    L = data[start]
    rho, sigma, rrate, srate, gr, gs = scratch[0], scratch[1], scratch[2], scratch[3], scratch[4], scratch[5]
    F, H = scratch[6:8], scratch[8:20].reshape((4, 9))
    strain, power = 0.0, 0.0
    tangent = ck != 0.0 or cd != 0.0
    f[:] = 0.0
    if tangent:
        K[:] = 0.0
    for g in range(5):
        at = start + 21 + 3 * g
        for i in range(3):
            rho[i] = AXIAL[g, 0] * z[0, i] + AXIAL[g, 1] * z[1, i] + AXIAL[g, 2] * z[2, i]
            rrate[i] = AXIAL[g, 0] * rate[0, i] + AXIAL[g, 1] * rate[1, i] + AXIAL[g, 2] * rate[2, i]
        one, two = _axial(rho, rrate, data[at], data[at + 1], data[at + 2], ck, cd, F[0], H[0])
        strain += one
        power += two
        for m in range(3):
            for i in range(3):
                f[3 * m + i] += AXIAL[g, m] * F[0, i]
        if tangent:
            for m in range(3):
                for n in range(3):
                    x = AXIAL[g, m] * AXIAL[g, n]
                    for k in range(9):
                        K[m, n, k] += x * H[0, k]
    for g in range(3):
        at = start + 36 + 3 * g
        for i in range(3):
            rho[i] = BENDING[g, 0] * z[0, i] + BENDING[g, 1] * z[1, i] + BENDING[g, 2] * z[2, i]
            sigma[i] = (BENDING[g, 3] * z[0, i] + BENDING[g, 4] * z[1, i] + BENDING[g, 5] * z[2, i]) / L
        F[:] = 0.0
        H[:] = 0.0
        strain += _bending(rho, sigma, data[at], data[at + 1], ck, gr, gs, F, H)
        if data[at + 2] > 0.0:
            for i in range(3):
                rrate[i] = BENDING[g, 0] * rate[0, i] + BENDING[g, 1] * rate[1, i] + BENDING[g, 2] * rate[2, i]
                srate[i] = (BENDING[g, 3] * rate[0, i] + BENDING[g, 4] * rate[1, i] + BENDING[g, 5] * rate[2, i]) / L
            power += _bending_damping(rho, sigma, rrate, srate, data[at + 2], STRAIGHT / L**2, ck, cd, F, H)
        for m in range(3):
            for i in range(3):
                f[3 * m + i] += BENDING[g, m] * F[0, i] + BENDING[g, 3 + m] / L * F[1, i]
        if tangent:
            for m in range(3):
                c1, s1 = BENDING[g, m], BENDING[g, 3 + m] / L
                for n in range(3):
                    c2, s2 = BENDING[g, n], BENDING[g, 3 + n] / L
                    cc, cs, sc, ss = c1 * c2, c1 * s2, s1 * c2, s1 * s2
                    for k in range(9):
                        K[m, n, k] += cc * H[0, k] + cs * H[1, k] + sc * H[2, k] + ss * H[3, k]
    return strain, power
