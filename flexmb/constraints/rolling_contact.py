"""`Touching` and `NoSlip`: a disc or sphere on a plane, in contact and without slip."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from flexmb.constraints.rows import HEADER, apply_multiplier, set_gradient
from flexmb.math.kernel import inner_kernel
from flexmb.math.tables import row_kernel
from flexmb.math.vectors import add_skew, cross, dot
from flexmb.model.primitives import Equation
from flexmb.model.table import Table

__all__ = ["NoSlip", "Touching"]

ROW = np.dtype([*HEADER, ("radius", float), ("disc", np.int64)], align=True)


@inner_kernel
def _arm(a, b, radius, disc, rho):
    """Write the vector from the centre to the contact point to `rho`; return c = n . z_b (0 for a sphere).

    rho = -r n for a sphere, -r (n - c z) / sqrt(1 - c^2) for a disc with the axis z and the plane's normal n.
    """
    n, z = a.R[:, 2], b.R[:, 2]
    c = dot(n, z) if disc == 1 else 0.0
    scale = -radius / (1.0 - c * c) ** 0.5
    for i in range(3):
        rho[i] = scale * (n[i] - c * z[i])
    return c


@inner_kernel
def _arm_rate(c, radius, dn, z, dz, dc, rho, out):
    """Write the change of rho to `out` when n, z and c change by dn, dz and dc."""
    q = 1.0 - c * c
    scale = -radius / q**0.5
    for i in range(3):
        out[i] = scale * (dn[i] - dc * z[i] - c * dz[i]) + rho[i] * c * dc / q


@row_kernel
def touching(raw, data, state, work):
    """g = n . d + n . rho = n . d - r sqrt(1 - c^2), eq. (touching).

    dg = n . (dr_b - dr_a) + (n x (d + rho)) . dtheta_a ... with dc = (n x z) . (dtheta_a - dtheta_b).
    """
    rows = raw.view(ROW)
    d, rate, t, m, nz = np.empty(3), np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    dn, dz, ddn, ddz = np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    for k in range(rows.shape[0]):
        row = rows[k]
        a, b = work.markers[row.a], work.markers[row.b]
        equation = work.equations[row.equation]
        leg_a, leg_b = work.legs[row.leg], work.legs[row.leg + 1]
        n, z = a.R[:, 2], b.R[:, 2]
        c = dot(n, z) if row.disc == 1 else 0.0
        s = (1.0 - c * c) ** 0.5
        for i in range(3):
            d[i] = b.r[i] - a.r[i]
            rate[i] = b.v[i] - a.v[i]
        cross(n, d, t)
        cross(n, z, nz)
        # d(-r s) = r c / s dc
        h = row.radius * c / s if row.disc == 1 else 0.0
        for i in range(3):
            m[i] = t[i] + h * nz[i]
        set_gradient(leg_a, 1.0, n, m)
        for i in range(3):
            leg_a.gradient[i] = -n[i]
            m[i] = -h * nz[i]
        set_gradient(leg_b, 1.0, n, m)
        cross(a.w, n, dn)
        cross(b.w, z, dz)
        cross(a.w, dn, ddn)
        cross(b.w, dz, ddz)
        dc = dot(dn, z) + dot(n, dz)
        ddc = dot(ddn, z) + 2.0 * dot(dn, dz) + dot(n, ddz)
        equation.g = dot(n, d) - row.radius * s
        equation.rate = 0.0
        equation.drift = dot(ddn, d) + 2.0 * dot(dn, rate)
        if row.disc == 1:
            equation.drift += h * ddc + row.radius / s**3 * dc * dc
        lam = state.lam[row.equation]
        apply_multiplier(equation, leg_a, leg_b, a, b, lam)
        if work.weights[0].wanted == 1:
            _touching_stiffness(work.pairs[row.pair].K, lam, row.radius, row.disc, n, z, nz, d, c, s)


@inner_kernel
def _touching_stiffness(K, lam, radius, disc, n, z, nz, d, c, s):
    """Add -lam d(gradient): as for a point in a plane, and for h (n x z), h = r c / s."""
    add_skew(K, 0, 3, -lam, n)
    add_skew(K, 6, 3, lam, n)
    add_skew(K, 3, 0, lam, n)
    add_skew(K, 3, 6, -lam, n)
    nd = dot(n, d)
    for i in range(3):
        for j in range(3):
            K[3 + i, 3 + j] -= lam * n[i] * d[j]
        K[3 + i, 3 + i] += lam * nd
    if disc == 0:
        return
    h, dh = radius * c / s, radius / s**3
    for i in range(3):
        for j in range(3):
            # d(n x z) by theta_a: n z^T - c I, by theta_b: c I - z n^T; dh = r / s^3 dc
            by_a = dh * nz[i] * nz[j] + h * n[i] * z[j]
            by_b = -dh * nz[i] * nz[j] - h * z[i] * n[j]
            if i == j:
                by_a -= h * c
                by_b += h * c
            K[3 + i, 3 + j] -= lam * by_a
            K[3 + i, 9 + j] -= lam * by_b
            K[9 + i, 3 + j] += lam * by_a
            K[9 + i, 9 + j] += lam * by_b


@inner_kernel
def _slip_terms(a, b, row, lever, rho, drho, u):
    """Write d + rho, rho, its rate, and the slip velocity of the contact point; return c = n . z_b."""
    t, dn, dz = np.empty(3), np.empty(3), np.empty(3)
    c = _arm(a, b, row.radius, row.disc, rho)
    cross(a.w, a.R[:, 2], dn)
    cross(b.w, b.R[:, 2], dz)
    dc = 0.0
    if row.disc == 1:
        dc = dot(dn, b.R[:, 2]) + dot(a.R[:, 2], dz)
    _arm_rate(c, row.radius, dn, b.R[:, 2], dz, dc, rho, drho)
    for i in range(3):
        lever[i] = b.r[i] - a.r[i] + rho[i]
    cross(b.w, rho, u)
    cross(a.w, lever, t)
    for i in range(3):
        u[i] += b.v[i] - a.v[i] - t[i]
    return c


@row_kernel
def no_slip(raw, data, state, work):
    """g = e . (v_b + w_b x rho - v_a - w_a x (d + rho)) for e = x and y of a, eq. (no-slip)."""
    rows = raw.view(ROW)
    lever, rho, drho, u = np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    t, s, m, de = np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    for k in range(rows.shape[0]):
        row = rows[k]
        a, b = work.markers[row.a], work.markers[row.b]
        c = _slip_terms(a, b, row, lever, rho, drho, u)
        for side in range(2):
            equation = work.equations[row.equation + side]
            leg_a, leg_b = work.legs[row.leg + 2 * side], work.legs[row.leg + 2 * side + 1]
            e = a.R[:, side]
            cross(lever, e, m)
            set_gradient(leg_a, -1.0, e, m)
            cross(rho, e, m)
            set_gradient(leg_b, 1.0, e, m)
            equation.g = dot(e, u)
            equation.rate = 0.0
            # e' . u + e . (w_b x rho' - w_a x (d' + rho'))
            cross(a.w, e, de)
            for i in range(3):
                t[i] = b.w[i] - a.w[i]
                s[i] = b.v[i] - a.v[i]
            cross(t, drho, m)
            cross(a.w, s, t)
            equation.drift = dot(de, u) + dot(e, m) - dot(e, t)
            lam = state.lam[row.equation + side]
            apply_multiplier(equation, leg_a, leg_b, a, b, lam)
            if work.weights[0].wanted == 1:
                _slopes(row, a, b, c, e, rho, lever, u, lam, leg_a, leg_b, work.pairs[row.pair].K, side)


@inner_kernel
def _slopes(row, a, b, c, e, rho, lever, u, lam, leg_a, leg_b, K, side):
    """Write the derivative of the residual by displacements to the legs, and -lam d(gradient) to K."""
    n, z = a.R[:, 2], b.R[:, 2]
    unit, dn, dz, de, drho = np.zeros(3), np.zeros(3), np.zeros(3), np.zeros(3), np.zeros(3)
    dd, t, w, dv = np.zeros(3), np.empty(3), np.empty(3), np.zeros(3)
    for j in range(12):
        unit[:] = 0.0
        unit[j % 3] = 1.0
        dn[:] = 0.0
        dz[:] = 0.0
        de[:] = 0.0
        dd[:] = 0.0
        dv[:] = 0.0
        if j < 3:
            dd[j] = -1.0
        elif j < 6:
            cross(unit, n, dn)
            cross(unit, e, de)
            # twists turn with their bodies: d(v_a + w_a x lever) at constant twist in body axes
            cross(unit, a.w, w)
            cross(w, lever, t)
            cross(unit, a.v, w)
            for i in range(3):
                dv[i] = -w[i] - t[i]
        elif j < 9:
            dd[j - 6] = 1.0
        else:
            cross(unit, z, dz)
            cross(unit, b.w, w)
            cross(w, rho, t)
            cross(unit, b.v, w)
            for i in range(3):
                dv[i] = w[i] + t[i]
        dc = dot(dn, z) + dot(n, dz) if row.disc == 1 else 0.0
        _arm_rate(c, row.radius, dn, z, dz, dc, rho, drho)
        for i in range(3):
            w[i] = b.w[i] - a.w[i]
        cross(w, drho, t)
        cross(a.w, dd, w)
        change = dot(de, u)
        for i in range(3):
            change += e[i] * (t[i] - w[i] + dv[i])
            w[i] = dd[i] + drho[i]
        if j < 6:
            leg_a.slope[j] = change
        else:
            leg_b.slope[j - 6] = change
        # gradients: a (-e, -lever x e), b (e, rho x e)
        for i in range(3):
            K[i, j] += lam * de[i]
            K[6 + i, j] -= lam * de[i]
        cross(w, e, t)
        for i in range(3):
            K[3 + i, j] += lam * t[i]
        cross(lever, de, t)
        for i in range(3):
            K[3 + i, j] += lam * t[i]
        cross(drho, e, t)
        for i in range(3):
            K[9 + i, j] -= lam * t[i]
        cross(rho, de, t)
        for i in range(3):
            K[9 + i, j] -= lam * t[i]


@dataclass(frozen=True)
class Touching(Equation):
    """A disc or sphere around marker b touches the x-y plane of marker a from its positive side.

    Parameters
    ----------
    radius : float, m
    disc : bool
        A disc with the axis z of marker b; otherwise a sphere.
    """

    radius: float
    disc: bool

    table: ClassVar[Table] = Table("Touching", ROW, {"evaluate": touching})
    stiffens: ClassVar[bool] = True

    def record(self, compiler, markers):
        return {"disc": int(self.disc)}


@dataclass(frozen=True)
class NoSlip(Touching):
    """The contact point of the disc or sphere has no velocity relative to the plane's body, along x and y of marker a.

    Parameters
    ----------
    radius : float, m
    disc : bool
        A disc with the axis z of marker b; otherwise a sphere.
    """

    table: ClassVar[Table] = Table("NoSlip", ROW, {"evaluate": no_slip})
    count: ClassVar[int] = 2
    level: ClassVar[int] = 1
