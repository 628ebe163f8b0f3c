"""The two elements of a plate: thin with four nodes of position and two gradients, shear-deformable with a director.

Numbers of an element in the bulk data, in this order; V nodal vectors, 12 (r, r_s, r_t of four nodes) or 8 (r, d):
nodes (4); where their rows begin in the matrix (16); mass (V, V); moments of mass (V); of area as drawn (V); points.
"""

from __future__ import annotations

import numpy as np

from flexmb.bodies.plate.strains import add_curvature, add_quadratic, collect, isotropic, local_vectors
from flexmb.math.kernel import inner_kernel, kernel
from flexmb.math.vectors import cross

__all__ = ["BENDING", "HEAD", "MEMBRANE", "SHELL", "add_pressure", "first_point", "plate_element"]

HEAD = 20
"""Nodes and rows at the beginning of an element."""
MEMBRANE, BENDING = 41, 64
"""Thin: nine points with stiffness, area, rest (3), r_1 r_2 (2, 12), N (12); four with stiffness, rest (3), r_1 r_2
r_11 r_22 r_12 (5, 12)."""
SHELL = 48
"""With director: four points with membrane and bending stiffness, area, rest (5), r_1 r_2 d_1 d_2 (4, 8), N (8)."""

STRETCH = np.array([[0.0, 0, 0, 0.5], [1, 1, 1, 0.5], [2, 0, 1, 1.0]])
"""E_11, E_22, 2 E_12 of r_1, r_2."""
DIRECTOR = np.array([[0.0, 0, 0, 0.5], [1, 1, 1, 0.5], [2, 0, 2, 1.0], [3, 1, 3, 1.0], [4, 0, 3, 1.0], [4, 1, 2, 1.0]])
"""E_11, E_22, kappa_11, kappa_22, 2 kappa_12 of r_1, r_2, d_1, d_2."""
IN_PLANE = np.array([[0.0, 0, 1, 1.0]])
"""2 E_12 of r_1, r_2 in the middle."""
THICKNESS = np.array([[k, 2 * k + 1.0, 2 * k + 1.0, 0.5] for k in range(4)])
"""E_33 + 1/2 at the nodes, of r, d of four nodes."""
EDGES = ((0, 1), (3, 2), (0, 3), (1, 2))
"""Edges with the nodes at their ends: two along s, two along t."""
SHEAR = np.array(
    [
        [k, 2.0 * p, 2 * q + 1.0, 0.25 if p == b else -0.25]
        for k, (a, b) in enumerate(EDGES)
        for p in (b, a)
        for q in (a, b)
    ]
)
"""Transverse shear in the middle of the edges, half the edge times the mean director, of r, d of four nodes."""


@kernel
def first_point(V):
    """Return where the points begin in an element."""
    return HEAD + V * V + 2 * V


@inner_kernel
def _add_point(P, data, rest, at, C, factors, q, u, x, rate, out, H, f, K):
    """Add the quadratic strains P of a point with coefficients from `at`; return energy and power. x ... H: scratch.

    `factors` are the damping time tau, and what stiffness and damping count in the matrix.
    """
    tau, ck, cd = factors
    local_vectors(data, at, q, x)
    local_vectors(data, at, u, rate)
    out[:] = 0.0
    H[:] = 0.0
    energy, power = add_quadratic(P, x, rate, data, rest, C, tau, ck, cd, out, H)
    collect(data, at, out, H, ck != 0.0 or cd != 0.0, f, K)
    return energy, power


@inner_kernel
def _thin(data, start, nu, tau, q, u, ck, cd, f, K):
    """Membrane at nine points, bending at four."""
    x = np.empty((5, 3))
    rate = np.empty((5, 3))
    out = np.empty((5, 3))
    flat = np.empty((6, 6))
    bent = np.empty((15, 15))
    C = np.zeros((3, 3))
    energy, power = 0.0, 0.0
    for g in range(9):
        at = start + first_point(12) + MEMBRANE * g
        isotropic(data[at], nu, C, 0)
        e, p = _add_point(STRETCH, data, at + 2, at + 5, C, (tau, ck, cd), q, u, x[:2], rate[:2], out[:2], flat, f, K)
        energy += e
        power += p
    for g in range(4):
        at = start + first_point(12) + 9 * MEMBRANE + BENDING * g
        isotropic(data[at], nu, C, 0)
        local_vectors(data, at + 4, q, x)
        local_vectors(data, at + 4, u, rate)
        out[:] = 0.0
        bent[:] = 0.0
        e, p = add_curvature(x, rate, data, at + 1, C, tau, ck, cd, out, bent)
        collect(data, at + 4, out, bent, ck != 0.0 or cd != 0.0, f, K)
        energy += e
        power += p
    return energy, power


@inner_kernel
def _shell(data, start, nu, tau, q, u, ck, cd, f, K):
    """Stretch and bending at four points, shear in the plane in the middle, transverse shear from the edges."""
    x = np.empty((4, 3))
    rate = np.empty((4, 3))
    out = np.empty((4, 3))
    H = np.empty((12, 12))
    C = np.zeros((5, 5))
    energy, power = 0.0, 0.0
    at = start + first_point(8)
    for _ in range(4):
        C[0, 0] = C[1, 1] = data[at]
        C[0, 1] = C[1, 0] = nu * data[at]
        isotropic(data[at + 1], nu, C, 2)
        e, p = _add_point(DIRECTOR, data, at + 3, at + 8, C, (tau, ck, cd), q, u, x, rate, out, H, f, K)
        energy += e
        power += p
        at += SHELL
    G, flat = np.full((1, 1), data[at]), np.empty((6, 6))
    e, p = _add_point(IN_PLANE, data, at + 1, at + 2, G, (tau, ck, cd), q, u, x[:2], rate[:2], out[:2], flat, f, K)
    energy += e
    power += p
    at += 18
    S = data[at : at + 16].copy().reshape((4, 4))
    e, p = add_quadratic(SHEAR, q, u, data, at + 16, S, tau, ck, cd, f, K)
    energy += e
    power += p
    walls = np.zeros((4, 4))
    for k in range(4):
        walls[k, k] = data[at + 20 + k]
    e, p = add_quadratic(THICKNESS, q, u, np.full(4, 0.5), 0, walls, 0.0, ck, 0.0, f, K)
    return energy + e, power + p


@kernel
def plate_element(data, start, nu, tau, q, u, ck, cd, f, K):
    """Write the forces f (V, 3) and ck df/dq + cd df/du to K (3 V, 3 V); return strain energy and dissipated power."""
    f[:] = 0.0
    if ck != 0.0 or cd != 0.0:
        K[:] = 0.0
    if q.shape[0] == 12:
        return _thin(data, start, nu, tau, q, u, ck, cd, f, K)
    return _shell(data, start, nu, tau, q, u, ck, cd, f, K)


@kernel
def add_pressure(data, start, pressure, q, ck, f, K):
    """Subtract the forces of a pressure along the normal r_1 x r_2 from f, and add their stiffness to K.

    eq. (plate-pressure).
    """
    V = q.shape[0]
    points, stride, first, shapes = (9, MEMBRANE, 5, 29) if V == 12 else (4, SHELL, 8, 40)
    x = np.empty((2, 3))
    c = np.empty(3)
    for g in range(points):
        at = start + first_point(V) + stride * g
        area = data[at + 1] if V == 12 else data[at + 2]
        local_vectors(data, at + first, q, x)
        cross(x[0], x[1], c)
        for v in range(V):
            share = pressure * area * data[at + shapes + v]
            for i in range(3):
                f[v, i] -= share * c[i]
            if ck == 0.0 or share == 0.0:
                continue
            for w in range(V):
                d1, d2 = data[at + first + w], data[at + first + V + w]
                # dr_1 x r_2 + r_1 x dr_2 = (d2 r_1 - d1 r_2) x dq
                for i in range(3):
                    j, k = (i + 1) % 3, (i + 2) % 3
                    K[3 * v + i, 3 * w + k] -= ck * share * (d2 * x[0, j] - d1 * x[1, j])
                    K[3 * v + i, 3 * w + j] += ck * share * (d2 * x[0, k] - d1 * x[1, k])
