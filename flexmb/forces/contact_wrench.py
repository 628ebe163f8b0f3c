"""The wrench of one contact between two surfaces, and its tangent."""

from __future__ import annotations

import numpy as np

from flexmb.forces.contact_force import CONTACT_FORCE, force_change, press, write_slopes
from flexmb.math.kernel import inner_kernel, kernel
from flexmb.math.vectors import cross, dot

__all__ = ["act_at_contact"]


@kernel
def act_at_contact(row, contact, motion, wanted, f, K, C, energy):
    """Add the wrench of a contact to f (6,), and -df/d(d, psi), -df/d(d', w) to K, C (6, 6), all in the axes of a.

    eq. (surface-contact) at x, with the relative velocity u = d' + w x (x - d).
    """
    at = np.empty(1, CONTACT_FORCE)[0]
    r = np.empty(3)
    t = np.empty(3)
    for i in range(3):
        r[i] = contact.x[i] - motion[i]
    cross(motion[6:9], r, t)
    for i in range(3):
        at.n[i] = contact.n[i]
        at.u[i] = motion[3 + i] + t[i]
    press(row, contact.gap, contact.area, at, energy)
    cross(r, at.F, t)
    for i in range(3):
        f[i] += at.F[i]
        f[3 + i] += t[i]
    if wanted:
        write_slopes(row, at)
        _add_tangent(contact, at, r, motion[6:9], K, C)


@inner_kernel
def _add_tangent(contact, at, r, w, K, C):
    """Add minus the derivatives of the wrench of a force `at` r from marker b, which turns with w against a."""
    n = contact.n
    dn = np.empty(3)
    dr = np.empty(3)
    du = np.empty(3)
    dF = np.empty(3)
    e = np.empty(3)
    t = np.empty(3)
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
        force_change(at, dgap, dA, dn, du, dF)
        cross(r, dF, t)
        cross(dr, at.F, e)
        for i in range(3):
            if first:
                K[i, k] -= dF[i]
                K[3 + i, k] -= t[i] + e[i]
            else:
                C[i, k] -= dF[i]
                C[3 + i, k] -= t[i] + e[i]
