"""The element of a shear-deformable beam: three nodes with position and two directors, strains of a Cosserat rod.

At a point the strains follow from ``r'``, the directors ``a = r_y``, ``b = r_z`` and their derivatives by x. The
directors give the frame of the section, ``e3 = b/|b|``, ``e1 = a x b/|a x b|``, ``e2 = e3 x e1``; the strains are
``(e1.r', e2.r', e3.r')`` (stretch, shears) and ``(e3.e2', e1.e3', e2.e1')`` (torsion, bendings). Nachbagauer, Gruber &
Gerstmayr 2013 (structural mechanics form); eq. (beam-strains).

All functions here pass a complex step, which makes their derivatives exact.
"""

from __future__ import annotations

import numpy as np

from flexmb.bodies.line.director_frame import section_frame, section_spin, spin_gradient
from flexmb.math.kernel import inner_kernel, kernel
from flexmb.math.vectors import cross, dot

__all__ = ["ELEMENT", "LOCAL", "beam_element", "strains"]

LOCAL = 15
"""Numbers at a point: r', r_y, r_z, r_y', r_z'."""
ELEMENT = 70
"""Numbers per element in the bulk data: length (1), mass of positions, r_y, r_z (27), mass moments (3), section
stiffness of y, z and shear (3), two points with stiffness, strain-free value and damping of six strains (36)."""
STEP = 1e-30


@kernel
def strains(x, s):
    """Write stretch and shears, torsion and bendings at the local vectors x (5, 3) to `s` (6,)."""
    E = np.empty((3, 3), x.dtype)
    length, across, along = section_frame(x[1], x[2], E)
    for k in range(3):
        s[k] = dot(E[k], x[0])
    section_spin(E, length, across, along, x[3], x[4], s[3:6])


@inner_kernel
def _forces(x, n, out):
    """Write to `out` (5, 3) the forces of the stress resultants n (6,): the gradient of n . strains."""
    E = np.empty((3, 3), x.dtype)
    length, across, along = section_frame(x[1], x[2], E)
    k2 = dot(E[0], x[4]) / length
    k3 = (along * k2 - dot(E[0], x[3])) / across
    G = np.empty((3, 3), x.dtype)  # derivatives by e1, e2, e3
    second = n[4] + n[5] * along / across
    out[:] = 0.0
    for i in range(3):
        G[0, i] = n[0] * x[0, i] + second * x[4, i] / length - n[5] * x[3, i] / across
        G[1, i] = n[1] * x[0, i] - n[3] * x[4, i] / length - n[5] * k3 / across * x[1, i]
        G[2, i] = n[2] * x[0, i] + n[5] * k2 / across * x[1, i]
        out[0, i] = n[0] * E[0, i] + n[1] * E[1, i] + n[2] * E[2, i]
        out[1, i] = n[5] / across * (k2 * E[2, i] - k3 * E[1, i])
    stretch = (n[3] * dot(E[1], x[4]) / length - second * k2) / length
    for i in range(3):
        out[2, i] = stretch * E[2, i]
    spin_gradient(E, length, across, along, n[3:6], out[3], out[4])
    torque = np.zeros(3, x.dtype)
    c = np.empty(3, x.dtype)
    for k in range(3):
        cross(E[k], G[k], c)
        for m in range(3):
            torque[m] += dot(c, E[m])
    spin_gradient(E, length, across, along, torque, out[1], out[2])


@inner_kernel
def _resultants(x, rate, data, at, damped, s, n):
    """Write the stress resultants, with damping, to `n`; `s` are the strains. Return energy and dissipated power."""
    strains(x, s)
    energy = 0.0 * s[0]
    power = 0.0 * s[0]
    for k in range(6):
        n[k] = data[at + k] * (s[k] - data[at + 6 + k])
        energy += 0.5 * n[k] * (s[k] - data[at + 6 + k])
    if damped:
        unit = np.zeros(6, x.dtype)
        g = np.empty((5, 3), x.dtype)
        for k in range(6):
            unit[k] = 1.0
            _forces(x, unit, g)
            unit[k] = 0.0
            speed = 0.0 * s[0]
            for v in range(5):
                speed += dot(g[v], rate[v])
            n[k] += data[at + 12 + k] * speed
            power += data[at + 12 + k] * speed * speed
    return energy, power


@inner_kernel
def _tangent(x, rate, data, at, damped, ck, cd, H):
    """Write ck times the derivative of the forces by x, and cd times that by x', to H (15, 15)."""
    z = np.empty((5, 3), np.complex128)
    dz = np.empty((5, 3), np.complex128)
    s = np.empty(6, np.complex128)
    n = np.empty(6, np.complex128)
    out = np.empty((5, 3), np.complex128)
    H[:] = 0.0
    for v in range(5):
        for i in range(3):
            z[v, i], dz[v, i] = x[v, i], rate[v, i]
    for half in range(2):
        weight = ck if half == 0 else cd
        if weight == 0.0 or (half == 1 and not damped):
            continue
        for k in range(15):
            moved = z if half == 0 else dz
            kept = moved[k // 3, k % 3]
            moved[k // 3, k % 3] += STEP * 1j
            _resultants(z, dz, data, at, damped, s, n)
            _forces(z, n, out)
            moved[k // 3, k % 3] = kept
            for v in range(5):
                for i in range(3):
                    H[3 * v + i, k] += weight * out[v, i].imag / STEP


@inner_kernel
def _add_section_strain(q, data, start, ck, f, K):
    """Add the energy of directors that are not unit and perpendicular, at the three nodes; return it.

    With the Green strains (a.a - 1)/2, (b.b - 1)/2 and a.b.
    """
    energy = 0.0
    for node in range(3):
        share = 4.0 / 6.0 if node == 1 else 1.0 / 6.0
        ky, kz, ks = share * data[start + 31], share * data[start + 32], share * data[start + 33]
        a, b = q[9 * node + 3 : 9 * node + 6], q[9 * node + 6 : 9 * node + 9]
        y, z, g = 0.5 * (dot(a, a) - 1.0), 0.5 * (dot(b, b) - 1.0), dot(a, b)
        energy += 0.5 * (ky * y * y + kz * z * z + ks * g * g)
        i0 = 9 * node + 3
        for i in range(3):
            f[i0 + i] += ky * y * a[i] + ks * g * b[i]
            f[i0 + 3 + i] += kz * z * b[i] + ks * g * a[i]
        if ck != 0.0:
            for i in range(3):
                K[i0 + i, i0 + i] += ck * ky * y
                K[i0 + 3 + i, i0 + 3 + i] += ck * kz * z
                K[i0 + i, i0 + 3 + i] += ck * ks * g
                K[i0 + 3 + i, i0 + i] += ck * ks * g
                for j in range(3):
                    K[i0 + i, i0 + j] += ck * (ky * a[i] * a[j] + ks * b[i] * b[j])
                    K[i0 + 3 + i, i0 + 3 + j] += ck * (kz * b[i] * b[j] + ks * a[i] * a[j])
                    K[i0 + i, i0 + 3 + j] += ck * ks * b[i] * a[j]
                    K[i0 + 3 + i, i0 + j] += ck * ks * a[i] * b[j]
    return energy


@inner_kernel
def _shapes(g, L, N, D):
    """Write the quadratic shape functions and their derivatives by x at Gauss point g of two."""
    x = -(3.0**-0.5) if g == 0 else 3.0**-0.5
    N[0], N[1], N[2] = 0.5 * x * (x - 1.0), 1.0 - x * x, 0.5 * x * (x + 1.0)
    D[0], D[1], D[2] = (2.0 * x - 1.0) / L, -4.0 * x / L, (2.0 * x + 1.0) / L


@inner_kernel
def _local(q, N, D, x):
    """Write r', r_y, r_z, r_y', r_z' of nodal coordinates (27,) to x (5, 3)."""
    for i in range(3):
        for v in range(5):
            x[v, i] = 0.0
        for k in range(3):
            x[0, i] += D[k] * q[9 * k + i]
            x[1, i] += N[k] * q[9 * k + 3 + i]
            x[2, i] += N[k] * q[9 * k + 6 + i]
            x[3, i] += D[k] * q[9 * k + 3 + i]
            x[4, i] += D[k] * q[9 * k + 6 + i]


@inner_kernel
def _collect(H, N, D, K):
    """Add the local matrix H (15, 15) to the nodes' K (27, 27)."""
    T = np.empty((15, 27))
    for i in range(15):
        for k in range(3):
            for j in range(3):
                T[i, 9 * k + j] = D[k] * H[i, j]
                T[i, 9 * k + 3 + j] = N[k] * H[i, 3 + j] + D[k] * H[i, 9 + j]
                T[i, 9 * k + 6 + j] = N[k] * H[i, 6 + j] + D[k] * H[i, 12 + j]
    for k in range(3):
        for i in range(3):
            for j in range(27):
                K[9 * k + i, j] += D[k] * T[i, j]
                K[9 * k + 3 + i, j] += N[k] * T[3 + i, j] + D[k] * T[9 + i, j]
                K[9 * k + 6 + i, j] += N[k] * T[6 + i, j] + D[k] * T[12 + i, j]


@kernel
def beam_element(data, start, q, u, ck, cd, f, K):
    """Write the forces f (27,) and ck df/dq + cd df/du to K (27, 27); return strain energy and dissipated power."""
    N = np.empty(3)
    D = np.empty(3)
    x = np.empty((5, 3))
    rate = np.empty((5, 3))
    s = np.empty(6)
    n = np.empty(6)
    out = np.empty((5, 3))
    H = np.empty((15, 15))
    f[:] = 0.0
    tangent = ck != 0.0 or cd != 0.0
    if tangent:
        K[:] = 0.0
    energy, power = _add_section_strain(q, data, start, ck, f, K), 0.0
    for g in range(2):
        at = start + 34 + 18 * g
        damped = data[at + 12] > 0.0
        _shapes(g, data[start], N, D)
        _local(q, N, D, x)
        _local(u, N, D, rate)
        one, two = _resultants(x, rate, data, at, damped, s, n)
        energy += one
        power += two
        _forces(x, n, out)
        for k in range(3):
            for i in range(3):
                f[9 * k + i] += D[k] * out[0, i]
                f[9 * k + 3 + i] += N[k] * out[1, i] + D[k] * out[3, i]
                f[9 * k + 6 + i] += N[k] * out[2, i] + D[k] * out[4, i]
        if tangent:
            _tangent(x, rate, data, at, damped, ck, cd, H)
            _collect(H, N, D, K)
    return energy, power
