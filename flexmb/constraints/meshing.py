"""`Meshing`: the teeth of two wheels on parallel axes whose distance may change."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from flexmb.constraints.rows import HEADER, apply_multiplier, centripetal
from flexmb.math.kernel import inner_kernel
from flexmb.math.tables import row_kernel
from flexmb.math.vectors import cross, dot
from flexmb.model.primitives import Equation
from flexmb.model.table import Table

__all__ = ["Meshing"]

ROW = np.dtype(
    [
        *HEADER,
        ("radius_a", float),  # m
        ("radius_b", float),  # m, negative if the smaller wheel runs inside the larger
        ("offset", float),  # m
        ("branch_a", np.int64),  # full turns of the line of centres, seen from a and from b
        ("branch_b", np.int64),
    ],
    align=True,
)


@inner_kernel
def _bearing(m, d, branch, state, work, p):
    """Return the angle of `d` in the x-y plane of marker m, counted through full turns; write dangle/dd to `p`."""
    x, y = m.R[:, 0], m.R[:, 1]
    s, c = dot(y, d), dot(x, d)
    for i in range(3):
        p[i] = (c * y[i] - s * x[i]) / (s * s + c * c)
    angle = np.arctan2(s, c)
    near = state.q[len(state.q) - len(work.branches) + branch]
    angle += 2.0 * np.pi * np.round((near - angle) / (2.0 * np.pi))
    work.branches[branch] = angle
    return angle


@inner_kernel
def _second_rate(m, d, rate):
    """Return the second rate of the bearing of `d` at zero accelerations."""
    x, y = m.R[:, 0], m.R[:, 1]
    s, c = dot(y, d), dot(x, d)
    dx, dy, ddx, ddy = np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    cross(m.w, x, dx)
    cross(m.w, y, dy)
    centripetal(m.w, x, ddx)
    centripetal(m.w, y, ddy)
    ds, dc = dot(dy, d) + dot(y, rate), dot(dx, d) + dot(x, rate)
    dds, ddc = dot(ddy, d) + 2.0 * dot(dy, rate), dot(ddx, d) + 2.0 * dot(dx, rate)
    r2 = s * s + c * c
    turn = (c * ds - s * dc) / r2
    return (c * dds - s * ddc - 2.0 * turn * (s * ds + c * dc)) / r2


@inner_kernel
def _add_curvature(m, d, p, own, other, scale, K):
    """Add scale * d(gradient) of a bearing to `K` (12, 12); gradient: own (-p, p x d), other (p, 0)."""
    x, y = m.R[:, 0], m.R[:, 1]
    s, c = dot(y, d), dot(x, d)
    r2 = s * s + c * c
    unit, dd, dx, dy, dp = np.zeros(3), np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    t, u = np.empty(3), np.empty(3)
    for j in range(6):  # d, then the rotation of the marker
        unit[:] = 0.0
        unit[j % 3] = 1.0
        dd[:] = 0.0
        dx[:] = 0.0
        dy[:] = 0.0
        if j < 3:
            dd[j] = 1.0
        else:
            cross(unit, x, dx)
            cross(unit, y, dy)
        ds, dc = dot(dy, d) + dot(y, dd), dot(dx, d) + dot(x, dd)
        growth = 2.0 * (s * ds + c * dc)
        for i in range(3):
            dp[i] = (dc * y[i] + c * dy[i] - ds * x[i] - s * dx[i] - growth * p[i]) / r2
        cross(dp, d, t)
        cross(p, dd, u)
        column = other + j if j < 3 else own + j
        for i in range(3):
            K[own + i, column] -= scale * dp[i]
            K[own + 3 + i, column] += scale * (t[i] + u[i])
            K[other + i, column] += scale * dp[i]
            if j < 3:
                K[own + i, own + j] += scale * dp[i]
                K[own + 3 + i, own + j] -= scale * (t[i] + u[i])
                K[other + i, own + j] -= scale * dp[i]


@row_kernel
def evaluate(raw, data, state, work):
    """g = r_A alpha + r_B beta - offset, eq. (meshing), with the bearings alpha of d from a and beta of -d from b."""
    rows = raw.view(ROW)
    d, rate, p, back, back_rate, o = (np.empty(3), np.empty(3), np.empty(3), np.empty(3), np.empty(3), np.empty(3))
    t, u = np.empty(3), np.empty(3)
    for n in range(rows.shape[0]):
        row = rows[n]
        a, b = work.markers[row.a], work.markers[row.b]
        equation = work.equations[row.equation]
        leg_a, leg_b = work.legs[row.leg], work.legs[row.leg + 1]
        for i in range(3):
            d[i] = b.r[i] - a.r[i]
            rate[i] = b.v[i] - a.v[i]
            back[i] = -d[i]
            back_rate[i] = -rate[i]
        alpha = _bearing(a, d, row.branch_a, state, work, p)
        beta = _bearing(b, back, row.branch_b, state, work, o)
        cross(p, d, t)
        cross(o, back, u)
        for i in range(3):
            leg_b.gradient[i] = row.radius_a * p[i] - row.radius_b * o[i]
            leg_a.gradient[i] = -leg_b.gradient[i]
            leg_a.gradient[3 + i] = row.radius_a * t[i]
            leg_b.gradient[3 + i] = row.radius_b * u[i]
        equation.g = row.radius_a * alpha + row.radius_b * beta - row.offset
        equation.rate = 0.0
        equation.drift = row.radius_a * _second_rate(a, d, rate) + row.radius_b * _second_rate(b, back, back_rate)
        lam = state.lam[row.equation]
        apply_multiplier(equation, leg_a, leg_b, a, b, lam)
        if work.weights[0].wanted == 1:
            K = work.pairs[row.pair].K
            _add_curvature(a, d, p, 0, 6, -lam * row.radius_a, K)
            _add_curvature(b, back, o, 6, 0, -lam * row.radius_b, K)


@dataclass(frozen=True)
class Meshing(Equation):
    """The pitch circles around the z-axes of two markers roll on each other.

    Parameters
    ----------
    radius_a, radius_b : float, m
        That of b is negative if the wheels mesh inside.
    """

    radius_a: float
    radius_b: float

    table: ClassVar[Table] = Table("Meshing", ROW, {"evaluate": evaluate})
    stiffens: ClassVar[bool] = True

    def record(self, compiler, markers):
        """Return radii, offset of the configuration as described, and the branches of both bearings."""
        names = {number: name for name, number in compiler.marker_index.items()}
        bearings, branches = [], []
        for own, other in (markers, markers[::-1]):
            (r, R), (target, _) = compiler.pose(own), compiler.pose(other)
            x, y, _ = R.T @ (target - r)
            bearings.append(float(np.arctan2(y, x)))
            branches.append(compiler.branch(f"bearing: {names[own]}, {names[other]}", bearings[-1]))
        offset = self.radius_a * bearings[0] + self.radius_b * bearings[1]
        return {"offset": offset, "branch_a": branches[0], "branch_b": branches[1]}
