"""The wrench of one contact between two surfaces, and its tangent."""

from __future__ import annotations

import numpy as np

from flexmb.forces.rows import hunt_crossley
from flexmb.math.kernel import kernel
from flexmb.math.vectors import cross, dot

__all__ = ["act_at_contact"]


@kernel
def act_at_contact(row, contact, motion, wanted, f, K, C, energy):
    """Add the wrench of a contact to f (6,), and -df/d(d, psi), -df/d(d', w) to K, C (6, 6), all in the axes of a.

    eq. (surface-contact): ``F = A (k p^e (1 + D p')) (n - mu s / sqrt(s^2 + v0^2))`` at x, with the penetration p,
    p' = -n.u, the relative velocity u = d' + w x (x - d) and the slip s = u - (n.u) n.
    """
    n = contact.n
    r = np.empty(3)
    u = np.empty(3)
    s = np.empty(3)
    F = np.empty(3)
    t = np.empty(3)
    w = motion[6:9]
    for i in range(3):
        r[i] = contact.x[i] - motion[i]
    cross(w, r, t)
    for i in range(3):
        u[i] = motion[3 + i] + t[i]
    un = dot(n, u)
    p = -contact.gap
    force, slope, rate_slope, elastic = hunt_crossley(p, -un, row.stiffness, row.exponent, row.damping)
    area, mu = contact.area, row.friction
    for i in range(3):
        s[i] = u[i] - un * n[i]
    q = (dot(s, s) + row.transition**2) ** 0.5
    for i in range(3):
        F[i] = area * force * (n[i] - mu * s[i] / q)
        f[i] += F[i]
    cross(r, F, t)
    for i in range(3):
        f[3 + i] += t[i]
    energy[0].potential += area * elastic * p / (row.exponent + 1.0)
    energy[0].dissipation += area * ((force - elastic) * -un + mu * force * dot(s, s) / q)
    if not wanted:
        return
    dn = np.empty(3)
    dr = np.empty(3)
    du = np.empty(3)
    dF = np.empty(3)
    e = np.empty(3)
    for j in range(12):
        k = j % 6
        first = j < 6  # d and psi, then d' and w
        e[:] = 0.0
        e[k % 3] = 1.0
        dgap, dA = 0.0, 0.0
        if first:
            for i in range(3):
                dn[i] = contact.N[i, k]
                dr[i] = contact.X[i, k] - (1.0 if i == k else 0.0)
            cross(w, dr, du)
            cross(e, r, t)
            dgap = n[k] if k < 3 else dot(n, t)
            dA = contact.A[k]
        else:
            dn[:] = 0.0
            dr[:] = 0.0
            if k < 3:
                du[:] = e
            else:
                cross(e, r, du)
        dun = dot(dn, u) + dot(n, du)
        change = area * (-slope * dgap - rate_slope * dun) + dA * force
        along = 0.0
        for i in range(3):
            t[i] = du[i] - dun * n[i] - un * dn[i]  # of the slip
            along += s[i] * t[i]
        for i in range(3):
            dF[i] = change * (n[i] - mu * s[i] / q)
            dF[i] += area * force * (dn[i] - mu * (t[i] - s[i] * along / (q * q)) / q)
        cross(r, dF, t)
        cross(dr, F, e)
        for i in range(3):
            if first:
                K[i, k] -= dF[i]
                K[3 + i, k] -= t[i] + e[i]
            else:
                C[i, k] -= dF[i]
                C[3 + i, k] -= t[i] + e[i]
