"""The law of contacts whose gap is a given function of the relative motion: force, energy and exact tangent.

With the gap g(x) over x = (d, psi), its gradient G and second derivatives H, the penetration is p = -g and the force
(force and moment on b in the axes of a) is F(p, p') G - mu F sum_m s_m / sqrt(s^2 + v_0^2) T_m with the slips
s_m = T_m . v of v = (d', w). H_ij is the change of G_i as b turns by dpsi_j. Theory: eq. (gap-contact).
"""

from __future__ import annotations

import numpy as np

from flexmb.forces.rows import hunt_crossley
from flexmb.math.kernel import kernel

__all__ = ["GAP_LAW", "add_gap_contact", "angle_derivatives", "clear_gap"]

GAP_LAW = [
    ("stiffness", float),  # N/m^e
    ("exponent", float),
    ("damping", float),  # s/m
    ("friction", float),
    ("transition", float),  # m/s
]
"""Fields of rows whose law this is."""


@kernel
def clear_gap(G, H, T, dT):
    """Make the derivatives of a gap and of its slips zero."""
    G[:] = 0.0
    H[:] = 0.0
    T[:] = 0.0
    dT[:] = 0.0


@kernel
def add_gap_contact(row, v, g, G, H, T, dT, energy, wanted, f, K, C):
    """Add the force of a contact with the gap g < 0 to `f` (6,), and with `wanted` its tangent to `K`, `C` (6, 6).

    Parameters
    ----------
    row : record with the fields of GAP_LAW
    v : (6,), velocity and angular velocity of b relative to a, in the axes of a
    G : (6,), H : (6, 6)
        Derivatives of the gap.
    T : (2, 6), dT : (2, 6, 6)
        Of the two slips by v, and how they change with x.
    energy : record of `Energy`
    """
    rate = 0.0
    for i in range(6):
        rate -= G[i] * v[i]
    force, slope, damping, elastic = hunt_crossley(-g, rate, row.stiffness, row.exponent, row.damping)
    s0, s1 = 0.0, 0.0
    for i in range(6):
        s0 += T[0, i] * v[i]
        s1 += T[1, i] * v[i]
    q = (s0 * s0 + s1 * s1 + row.transition**2) ** 0.5
    share = row.friction * force / q
    for i in range(6):
        f[i] += force * G[i] - share * (s0 * T[0, i] + s1 * T[1, i])
    energy.potential += -elastic * g / (row.exponent + 1.0)
    energy.dissipation += (force - elastic) * rate + share * (s0 * s0 + s1 * s1)
    if not wanted:
        return
    for j in range(6):
        dforce, d0, d1 = -slope * G[j], 0.0, 0.0
        for k in range(6):
            dforce -= damping * H[k, j] * v[k]
            d0 += dT[0, k, j] * v[k]
            d1 += dT[1, k, j] * v[k]
        dq = (s0 * d0 + s1 * d1) / q
        eq = (s0 * T[0, j] + s1 * T[1, j]) / q
        mu = row.friction
        for i in range(6):
            along = s0 * T[0, i] + s1 * T[1, i]
            moved = d0 * T[0, i] + d1 * T[1, i] + s0 * dT[0, i, j] + s1 * dT[1, i, j]
            turned = T[0, j] * T[0, i] + T[1, j] * T[1, i]
            K[i, j] -= dforce * (G[i] - mu * along / q) + force * H[i, j]
            K[i, j] += mu * force * (moved - along * dq / q) / q
            C[i, j] += damping * G[j] * (G[i] - mu * along / q)
            C[i, j] += mu * force * (turned - along * eq / q) / q


@kernel
def angle_derivatives(s, c, S, D, A, B):
    """Return the angle atan2(s, c) of two numbers that are linear in the axes of b; write its derivatives.

    `S`, `D` (4, 3): first derivatives of s and c by psi in row 0, second ones in the others, [1 + j] by psi_j.
    `A` (3,) and `B` (3, 3) receive those of the angle, B[i, j]: how A_i changes with psi_j.
    """
    r2 = s * s + c * c
    for i in range(3):
        A[i] = (c * S[0, i] - s * D[0, i]) / r2
    for j in range(3):
        growth = 2.0 * (s * S[0, j] + c * D[0, j]) / r2
        for i in range(3):
            B[i, j] = (D[0, j] * S[0, i] + c * S[1 + j, i] - S[0, j] * D[0, i] - s * D[1 + j, i]) / r2
            B[i, j] -= growth * A[i]
    return np.arctan2(s, c)
