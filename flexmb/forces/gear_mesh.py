"""Where two involute gears touch: gap of a flank, place on the line of action, and their exact derivatives.

Seen in the axes of gear a, whose z is its axis, gear b is at d with its axis q = Q e_z. In the slice at z the axis of b
passes c = d + q zeta, zeta = (z - d_z) / q_z. With the distance |c|, the bearing theta of c, the turn psi of b and
w = z - zeta, the gap of the flank sigma = +-1 along the line of action in the transverse plane is, eq. (gear-gap),

    gap = r inv alpha - tight - sigma u,   u = r theta - r_b2 psi - h tan(beta_b) w - u_0,

r = r_b1 + r_b2, cos alpha = r / |c|. Inside a ring r_b2 and |c| count as negative. All base radii divide into whole
pitches, so full turns of theta and psi change nothing.
"""

from __future__ import annotations

import math

import numpy as np

from flexmb.forces.gap_contact import angle_derivatives
from flexmb.math.kernel import inner_kernel, kernel

__all__ = ["axis_in_slice", "flank", "pair_stiffness", "turn_of_axes"]


@kernel
def turn_of_axes(Q, A, B):
    """Return the turn of b about the z-axis of a (the twist of Q); write its derivatives, see `angle_derivatives`."""
    S, D = np.zeros((4, 3)), np.zeros((4, 3))
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        # column n of Q turns by e_i x column: component j loses column k, component k gains column j
        for n in range(2):
            sign_s = 1.0 if n == 0 else -1.0
            row_s = 1 - n  # s = Q10 - Q01
            if row_s == j:
                S[0, i] -= sign_s * Q[k, n]
            elif row_s == k:
                S[0, i] += sign_s * Q[j, n]
            if n == j:  # c = Q00 + Q11
                D[0, i] -= Q[k, n]
            elif n == k:
                D[0, i] += Q[j, n]
            for m in range(3):  # e_i x (e_m x column) = e_m column_i - column delta_im
                S[1 + m, i] += sign_s * ((Q[i, n] if m == row_s else 0.0) - (Q[row_s, n] if i == m else 0.0))
                D[1 + m, i] += (Q[i, n] if m == n else 0.0) - (Q[n, n] if i == m else 0.0)
    return angle_derivatives(Q[1, 0] - Q[0, 1], Q[0, 0] + Q[1, 1], S, D, A, B)


@kernel
def axis_in_slice(z, d, Q, y, Y, YY):
    """Write c_x, c_y and w of the slice at z to `y` (3,), first and second derivatives by (d, psi) to `Y` (3, 6) and
    `YY` (3, 6, 6).
    """
    q = Q[:, 2]
    zeta = (z - d[2]) / q[2]
    dq, dzeta = np.zeros((3, 6)), np.zeros(6)
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        dq[j, 3 + i], dq[k, 3 + i] = -q[k], q[j]
    dzeta[2] = -1.0 / q[2]
    for i in range(6):
        dzeta[i] -= zeta * dq[2, i] / q[2]
    y[0], y[1], y[2] = d[0] + q[0] * zeta, d[1] + q[1] * zeta, z - zeta
    for m in range(2):
        for i in range(6):
            Y[m, i] = (1.0 if i == m else 0.0) + dq[m, i] * zeta + q[m] * dzeta[i]
    for i in range(6):
        Y[2, i] = -dzeta[i]
    for i in range(6):
        for j in range(6):
            second = np.zeros(3)
            if i >= 3 and j >= 3:  # e_i x (e_j x q) = e_j q_i - q delta_ij
                second[j - 3] += q[i - 3]
                if i == j:
                    for m in range(3):
                        second[m] -= q[m]
            ddzeta = 2.0 * zeta * dq[2, i] * dq[2, j] / q[2] ** 2 - zeta * second[2] / q[2]
            if i == 2:
                ddzeta += dq[2, j] / q[2] ** 2
            if j == 2:
                ddzeta += dq[2, i] / q[2] ** 2
            for m in range(2):
                YY[m, i, j] = dq[m, i] * dzeta[j] + dq[m, j] * dzeta[i] + q[m] * ddzeta + zeta * second[m]
            YY[2, i, j] = -ddzeta


@inner_kernel
def _polar(first, second, turn, c, a, g, h):
    """Write gradient and second derivatives by c of P(|c|) + turn theta to `g` (2,), `h` (2, 2), with P' and P''."""
    r = (c[0] / a, c[1] / a)
    t = (-r[1], r[0])
    for i in range(2):
        g[i] = first * r[i] + turn / a * t[i]
        for j in range(2):
            h[i, j] = second * r[i] * r[j] + first / a * t[i] * t[j] - turn / (a * a) * (r[i] * t[j] + t[i] * r[j])


@kernel
def flank(row, sigma, z, y, Y, YY, psi, A, B, d1, d2, s1, s2):
    """Return the overlap of the flanks, and the place on the line of action from where it leaves the base circle of a.

    Their derivatives by (d, psi) are written to `d1` (6,), `d2` (6, 6) and `s1`, `s2`. The overlap is nan where the
    wheels are so near that their base circles have no common tangent.
    """
    a = (y[0] * y[0] + y[1] * y[1]) ** 0.5
    r, side = row.base_a + row.base_b, row.side
    cosine = r / (side * a)
    if not 0.0 < cosine < 1.0:
        return np.nan, 0.0
    alpha = math.acos(cosine)
    sine, cot = math.sin(alpha), cosine / math.sin(alpha)
    theta = math.atan2(side * y[1], side * y[0])
    u = r * theta - row.base_b * psi - row.lead * y[2] - row.offset
    u -= row.pitch * math.floor(u / row.pitch + 0.5)
    gap = r * (sine / cosine - alpha) - row.tight - sigma * u
    place = row.base_a * (sigma * theta + alpha + row.half) - sigma * row.lead * z
    g, h, p, k = np.empty(2), np.empty((2, 2)), np.empty(2), np.empty((2, 2))
    _polar(-side * sine, -side * cosine * cot / a, sigma * r, y, a, g, h)
    _polar(
        row.base_a * cot / a, -row.base_a * cot / (a * a) * (1.0 / (sine * sine) + 1.0), sigma * row.base_a, y, a, p, k
    )
    by_w = -sigma * row.lead
    for i in range(6):
        d1[i] = g[0] * Y[0, i] + g[1] * Y[1, i] + by_w * Y[2, i]
        s1[i] = p[0] * Y[0, i] + p[1] * Y[1, i]
        if i >= 3:
            d1[i] -= sigma * row.base_b * A[i - 3]
        for j in range(6):
            d2[i, j] = g[0] * YY[0, i, j] + g[1] * YY[1, i, j] + by_w * YY[2, i, j]
            s2[i, j] = p[0] * YY[0, i, j] + p[1] * YY[1, i, j]
            for m in range(2):
                for n in range(2):
                    d2[i, j] += h[m, n] * Y[m, i] * Y[n, j]
                    s2[i, j] += k[m, n] * Y[m, i] * Y[n, j]
            if i >= 3 and j >= 3:
                d2[i, j] -= sigma * row.base_b * B[i - 3, j - 3]
    return -gap, place


@inner_kernel
def _rise(x):
    """Return 0 below -1/2, 1 above 1/2, in between the polynomial of degree five, and two derivatives."""
    if x <= -0.5:
        return 0.0, 0.0, 0.0
    if x >= 0.5:
        return 1.0, 0.0, 0.0
    t = x + 0.5
    return (
        t * t * t * (10.0 + t * (6.0 * t - 15.0)),
        30.0 * t * t * (1.0 - t) ** 2,
        60.0 * t * (1.0 - t) * (1.0 - 2.0 * t),
    )


@kernel
def pair_stiffness(row, place, out):
    """Write the stiffness per width of all pairs of teeth that touch, N/m2, and its first and second derivative by the
    place on the line of action to `out` (3,); return how many pairs that are.

    Each pair has c' (1 - fall xi^2) over its path, xi = -1 and 1 at the ends; it comes and goes over `ramp`.
    """
    half, middle = 0.5 * (row.last - row.first), 0.5 * (row.last + row.first)
    out[:] = 0.0
    low = row.first - 0.5 * row.ramp
    s = place - row.pitch * math.floor((place - low) / row.pitch)
    count = 0
    while s < row.last + 0.5 * row.ramp:
        xi = (s - middle) / half
        f0, f1, f2 = 1.0 - row.fall * xi * xi, -2.0 * row.fall * xi / half, -2.0 * row.fall / (half * half)
        u0, u1, u2 = _rise((s - row.first) / row.ramp)
        v0, v1, v2 = _rise((row.last - s) / row.ramp)
        w0 = u0 * v0
        w1 = (u1 * v0 - u0 * v1) / row.ramp
        w2 = (u2 * v0 - 2.0 * u1 * v1 + u0 * v2) / row.ramp**2
        out[0] += row.stiffness * f0 * w0
        out[1] += row.stiffness * (f1 * w0 + f0 * w1)
        out[2] += row.stiffness * (f2 * w0 + 2.0 * f1 * w1 + f0 * w2)
        if row.first <= s <= row.last:
            count += 1
        s += row.pitch
    return count
