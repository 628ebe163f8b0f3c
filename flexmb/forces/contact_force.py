"""The force at a point where two surfaces touch: pressure and friction, eq. (surface-contact), and how it changes.

    F = A f (n - mu s / q),    f = k p^e (1 + D p'),    q = sqrt(s^2 + v0^2)

with the area A, the normal n, the penetration p, its rate p' = -n.u, and the slip s = u - (n.u) n of the relative
velocity u.
"""

from __future__ import annotations

import numpy as np

from flexmb.forces.rows import hunt_crossley
from flexmb.math.kernel import kernel
from flexmb.math.vectors import dot

__all__ = ["CONTACT_FORCE", "force_change", "press", "write_slopes"]

CONTACT_FORCE = np.dtype(
    [
        ("n", float, 3),  # normal
        ("u", float, 3),  # m/s, relative velocity
        ("s", float, 3),  # m/s, its part along the surface
        ("way", float, 3),  # n - mu s / q
        ("F", float, 3),  # N
        ("by_u", float, (3, 3)),  # dF/du
        ("by_n", float, (3, 3)),  # dF/dn
        ("area", float),  # m2
        ("q", float),  # m/s
        ("f", float),  # N/m2, with its derivatives by p and p'
        ("slope", float),
        ("rate_slope", float),
    ],
    align=True,
)


@kernel
def press(law, gap, area, at, energy):
    """Write the force that follows from n and u of `at`, a row of `CONTACT_FORCE`; add what it stores and dissipates.

    `law` has stiffness, exponent, damping, friction and transition.
    """
    n, u, s = at.n, at.u, at.s
    un = dot(n, u)
    force, slope, rate_slope, elastic = hunt_crossley(-gap, -un, law.stiffness, law.exponent, law.damping)
    mu = law.friction
    for i in range(3):
        s[i] = u[i] - un * n[i]
    q = (dot(s, s) + law.transition**2) ** 0.5
    for i in range(3):
        at.way[i] = n[i] - mu * s[i] / q
        at.F[i] = area * force * at.way[i]
    at.area, at.q, at.f, at.slope, at.rate_slope = area, q, force, slope, rate_slope
    energy[0].potential += -area * elastic * gap / (law.exponent + 1.0)
    energy[0].dissipation += area * ((force - elastic) * -un + mu * force * dot(s, s) / q)


@kernel
def write_slopes(law, at):
    """Write the derivatives of the force by relative velocity and normal, for what `force_change` makes of them.

    With P = I - s s^T / q^2, and s normal to n: dF/du = -A D n^T - A f mu / q (P - n n^T) and
    dF/dn = -A D u^T + A f I + A f mu / q (n u^T + (n.u) P), D = df/dp' (n - mu s / q).
    """
    n, u, s = at.n, at.u, at.s
    un = dot(n, u)
    pressed, steep = at.area * at.f, at.area * at.rate_slope
    share = pressed * law.friction / at.q
    for i in range(3):
        for j in range(3):
            same = 1.0 if i == j else 0.0
            P = same - s[i] * s[j] / (at.q * at.q)
            at.by_u[i, j] = -steep * at.way[i] * n[j] - share * (P - n[i] * n[j])
            at.by_n[i, j] = -steep * at.way[i] * u[j] + pressed * same + share * (n[i] * u[j] + un * P)


@kernel
def force_change(at, dgap, darea, dn, du, dF):
    """Write the change of the force to `dF` (3,), for changes of gap, area, normal (3,) and relative velocity (3,)."""
    change = darea * at.f - at.area * at.slope * dgap
    for i in range(3):
        dF[i] = change * at.way[i]
        for j in range(3):
            dF[i] += at.by_n[i, j] * dn[j] + at.by_u[i, j] * du[j]
