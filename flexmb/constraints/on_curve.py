"""`OnCurve` and `OnTrace`: a point stays on a curve, or on the surface that a plane curve sweeps along an axis."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from flexmb.constraints.rows import HEADER, add_block, apply_multiplier, set_gradient
from flexmb.math.kernel import inner_kernel
from flexmb.math.splines import evaluate_spline, nearest_parameter
from flexmb.math.tables import row_kernel
from flexmb.math.vectors import add_skew, cross, dot, matvec, matvec_t
from flexmb.model.primitives import Equation
from flexmb.model.table import Table

__all__ = ["OnCurve", "OnTrace"]

ROW = np.dtype(
    [
        *HEADER,
        ("curve", np.int64),  # in the bulk data
        ("closed", np.int64),
        ("ends", np.int64),  # 1: beyond the ends is an error
        ("axis", np.int64),  # of the sweep, or -1: a curve, two equations
        ("branch", np.int64),  # place on the curve
    ],
    align=True,
)


@inner_kernel
def _make_unit(w):
    """Make the rows of `w` (3, 3), a vector and its first two derivatives, into the unit vector's."""
    size = dot(w[0], w[0]) ** 0.5
    for i in range(3):
        w[0, i] /= size
    s1 = dot(w[0], w[1])
    for i in range(3):
        w[1, i] = (w[1, i] - s1 * w[0, i]) / size
    # |w|'' = n' . w' + n . w'' with w' = s1 n + |w| n'
    s2 = size * dot(w[1], w[1]) + dot(w[0], w[2])
    for i in range(3):
        w[2, i] = (w[2, i] - s2 * w[0, i] - 2.0 * s1 * w[1, i]) / size


@inner_kernel
def _normal(C, second, n):
    """Write a unit normal of the curve and its first two derivatives by the parameter to `n` (3, 3).

    `C` (4, 6) holds the curve c, the vector m, and their derivatives. First normal: m without its part along the
    tangent, made a unit vector; second normal: tangent x first.
    """
    t = np.empty((3, 3))
    first = np.empty((3, 3))
    x = np.empty(3)
    for k in range(3):
        for i in range(3):
            t[k, i] = C[k + 1, i]
    _make_unit(t)
    m0, m1, m2 = C[0, 3:6], C[1, 3:6], C[2, 3:6]
    along = dot(m0, t[0])
    along1 = dot(m1, t[0]) + dot(m0, t[1])
    along2 = dot(m2, t[0]) + 2.0 * dot(m1, t[1]) + dot(m0, t[2])
    for i in range(3):
        first[0, i] = m0[i] - along * t[0, i]
        first[1, i] = m1[i] - along1 * t[0, i] - along * t[1, i]
        first[2, i] = m2[i] - along2 * t[0, i] - 2.0 * along1 * t[1, i] - along * t[2, i]
    _make_unit(first)
    n[:] = first
    if second == 1:
        n[:] = 0.0
        for k in range(3):
            for j in range(k + 1):
                cross(t[j], first[k - j], x)
                for i in range(3):
                    n[k, i] += (2.0 if k == 2 and j == 1 else 1.0) * x[i]


@inner_kernel
def _derivatives(C, e, n, slope, H):
    """Write gradient (3,) and Hessian (3, 3) of g = n(s) . (p - c(s)) by the point p to `slope` and `H`.

    s is the nearest parameter, c' . e = 0, with ds/dp = c' / D, D = |c'|^2 - c'' . e.
    """
    c1, c2, c3 = C[1, 0:3], C[2, 0:3], C[3, 0:3]
    D = dot(c1, c1) - dot(c2, e)
    mu = dot(n[1], e)
    bend = 3.0 * dot(c1, c2) - dot(c3, e)
    both = dot(n[2], e) - dot(n[1], c1) - mu / D * bend
    for i in range(3):
        slope[i] = n[0, i] + mu / D * c1[i]
        for j in range(3):
            si, sj = c1[i] / D, c1[j] / D
            H[i, j] = (n[1, i] + mu / D * c2[i]) * sj + si * (n[1, j] + mu / D * c2[j]) + both * si * sj


@row_kernel
def evaluate(raw, data, state, work):
    """g = n(s) . (R_a^T d - c(s)) at the nearest point s of the curve, eq. (on-curve)."""
    rows = raw.view(ROW)
    C = np.empty((4, 6))
    n, H = np.empty((3, 3)), np.empty((3, 3))
    d, V, t, p, speed, N = np.empty(3), np.empty(3), np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    slope, moment, swing, zero = np.empty(3), np.empty(3), np.empty(3), np.zeros(3)
    for k in range(rows.shape[0]):
        row = rows[k]
        a, b = work.markers[row.a], work.markers[row.b]
        for i in range(3):
            d[i] = b.r[i] - a.r[i]
        cross(a.w, d, t)
        cross(a.w, t, swing)
        for i in range(3):
            V[i] = b.v[i] - a.v[i] - t[i]
        cross(a.w, V, t)
        matvec_t(a.R, d, p)
        matvec_t(a.R, V, speed)
        table = data[row.curve :]
        near = state.q[len(state.q) - len(work.branches) + row.branch]
        s = nearest_parameter(table, p, near, row.closed == 1, row.axis, C)
        work.branches[row.branch] = s
        outside = row.ends == 1 and (s < 0.0 or s > table[int(table[0])])
        for i in range(3):
            p[i] = 0.0 if i == row.axis else p[i] - C[0, i]
        for side in range(2 if row.axis < 0 else 1):
            equation = work.equations[row.equation + side]
            leg_a, leg_b = work.legs[row.leg + 2 * side], work.legs[row.leg + 2 * side + 1]
            _normal(C, side, n)
            _derivatives(C, p, n, slope, H)
            matvec(a.R, slope, N)
            cross(d, N, moment)
            set_gradient(leg_a, -1.0, N, moment)
            set_gradient(leg_b, 1.0, N, zero)
            equation.g = dot(n[0], p) if not outside else np.nan
            equation.rate = 0.0
            equation.drift = -dot(N, swing) - 2.0 * dot(N, t)
            for i in range(3):
                equation.drift += speed[i] * dot(H[i], speed)
            lam = state.lam[row.equation + side]
            apply_multiplier(equation, leg_a, leg_b, a, b, lam)
            if work.weights[0].wanted == 1:
                _add_stiffness(work.pairs[row.pair].K, lam, N, d, a.R, H)


@inner_kernel
def _add_stiffness(K, lam, N, d, R, H):
    """Add -lam d(gradient): as for a plane with the normal N, and E^T H E; E is the change of the point."""
    add_skew(K, 0, 3, -lam, N)
    add_skew(K, 6, 3, lam, N)
    add_skew(K, 3, 0, lam, N)
    add_skew(K, 3, 6, -lam, N)
    add_block(K, 3, 3, -lam, N, d, -dot(N, d))
    E = np.zeros((3, 12))
    HE = np.empty(3)
    t = np.empty(3)
    for m in range(3):
        cross(d, R[:, m], t)
        for i in range(3):
            E[m, i], E[m, 3 + i], E[m, 6 + i] = -R[i, m], -t[i], R[i, m]
    for j in range(9):
        for m in range(3):
            HE[m] = H[m, 0] * E[0, j] + H[m, 1] * E[1, j] + H[m, 2] * E[2, j]
        for i in range(9):
            K[i, j] -= lam * (E[0, i] * HE[0] + E[1, i] * HE[1] + E[2, i] * HE[2])


@dataclass(frozen=True, eq=False)
class OnCurve(Equation):
    """Marker b lies on a curve of marker a (two equations).

    Parameters
    ----------
    curve : numbers of `flexmb.math.splines.pack_spline`
    closed : bool
    strict : bool
        Beyond the ends of an open curve is an error.
    name : str
        Of the joint.
    axis : int
        -1: no axis of a sweep.
    """

    curve: np.ndarray
    closed: bool
    strict: bool
    name: str
    axis: int = -1

    table: ClassVar[Table] = Table("OnCurve", ROW, {"evaluate": evaluate})
    count: ClassVar[int] = 2
    stiffens: ClassVar[bool] = True

    def record(self, compiler, markers):
        (r_a, R_a), (r_b, _) = (compiler.pose(m) for m in markers)
        branch = compiler.branch(f"place on the curve of {self.name}", self.nearest(R_a.T @ (r_b - r_a)))
        strict = int(self.strict and not self.closed)
        return {"curve": compiler.bulk(self.curve), "closed": int(self.closed), "ends": strict, "branch": branch}

    def nearest(self, point: np.ndarray) -> float:
        """Return the parameter nearest to a point (3,) in the axes of a: the best of many, then Newton's method."""
        out = np.empty((4, 6))
        many = np.linspace(0.0, self.curve[int(self.curve[0])], 10 * int(self.curve[0]))
        distances = []
        for s in many:
            evaluate_spline(self.curve, s, self.closed, out)
            e = point - out[0, :3]
            e[self.axis if self.axis >= 0 else slice(0, 0)] = 0.0
            distances.append(e @ e)
        return float(nearest_parameter(self.curve, point, many[np.argmin(distances)], self.closed, self.axis, out))


@dataclass(frozen=True, eq=False)
class OnTrace(OnCurve):
    """Marker b lies on the surface that a plane curve of marker a sweeps along an axis (one equation).

    Parameters
    ----------
    curve : numbers of `flexmb.math.splines.pack_spline`
    closed : bool
    strict : bool
        Beyond the ends of an open curve is an error.
    name : str
        Of the joint.
    axis : int
        0, 1 or 2.
    """

    count: ClassVar[int] = 1
