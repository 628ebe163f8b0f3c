"""`OnPath` and `OnStrip`: a point stays on the spline through markers, or on a surface along it: a curve that deforms.

The curve is c(s) = sum_k B_k(s) r_k, with the cardinal splines B_k of fixed knots, and m(s) = sum_k B_k(s) a_k is a
direction across it; r_k and a_k = R_k n_k move with the markers k. The place s is that nearest to the point p,
F = c'(s) . (p - c(s)) = 0, and the equation is g = m(s) . (p - c(s)). Theory: eq. (on-path).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from flexmb.constraints.marker_blocks import add_to_pair, block_codes, own_parts, projected
from flexmb.constraints.rows import HEADER
from flexmb.math.kernel import inner_kernel, kernel
from flexmb.math.splines import cardinal_splines, evaluate_cardinal, pack_spline
from flexmb.math.tables import row_kernel
from flexmb.math.vectors import cross, dot, matvec
from flexmb.model.primitives import Equation
from flexmb.model.table import Table

__all__ = ["OnPath", "OnStrip"]

ROW = np.dtype(
    [
        *HEADER,
        ("n", np.int64),  # markers of the path
        ("sides", np.int64),  # number of equations
        ("path", np.int64),  # numbers of the markers, in the bulk data
        ("basis", np.int64),  # of `cardinal_splines`
        ("across", np.int64),  # (sides, n, 3) directions in the axes of the markers
        ("spans", np.int64),  # of each leg: its group of coordinates
        ("codes", np.int64),  # of `block_codes` of these groups
        ("n_spans", np.int64),
        ("ends", np.int64),  # 1: beyond the ends is an error
        ("branch", np.int64),  # place on the path
    ],
    align=True,
)


@inner_kernel
def _sum(B, x, out):
    """Write sum_k B_jk x_k to `out` (j, 3)."""
    out[:] = 0.0
    for j in range(out.shape[0]):
        for k in range(x.shape[0]):
            for i in range(3):
                out[j, i] += B[j, k] * x[k, i]


@kernel
def nearest_on_path(basis, r, p, start, B, C):
    """Return s with c' . (p - c) = 0 near `start`; basis B (4, n) and curve C (4, 3), with derivatives, are left there.

    Newton's method; steps that lead farther away are halved, and where the distance bends down Gauss' approximation
    leads to the minimum, as in `nearest_parameter`.
    """
    s, step, least = start, 0.0, np.inf
    limit = 0.1 * basis[int(basis[0])]
    e = np.empty(3)
    for _ in range(100):
        evaluate_cardinal(basis, s, B)
        _sum(B, r, C)
        for i in range(3):
            e[i] = p[i] - C[0, i]
        far = dot(e, e)
        if far > least * (1.0 + 1e-12):
            step *= 0.5
            s -= step
        else:
            least = far
            square = dot(C[1], C[1])
            slope = square - dot(C[2], e)
            if slope <= 0.0:
                slope = square
            step = min(max(dot(C[1], e) / slope, -limit), limit)
            s += step
        if abs(step) <= 1e-14 * limit:
            break
    evaluate_cardinal(basis, s, B)
    _sum(B, r, C)
    return s


@inner_kernel
def _rates(B, C, r_dot, b, e, D, out):
    """Write the rates at fixed s of e, c', c'' to `out` (3, 3) and return the rate of s.

    From dF/dt = 0: ds/dt = (d(c')/dt . e + c' . de/dt) / D.
    """
    for i in range(3):
        out[0, i] = b.v[i]
        out[1, i] = out[2, i] = 0.0
        for k in range(r_dot.shape[0]):
            out[0, i] -= B[0, k] * r_dot[k, i]
            out[1, i] += B[1, k] * r_dot[k, i]
            out[2, i] += B[2, k] * r_dot[k, i]
    return (dot(out[1], e) + dot(C[1], out[0])) / D


@inner_kernel
def _second_place(C, e, D, move, s1):
    """Return s'' at accelerations of the markers that are zero, from F'' = 0."""
    total = 0.0
    for i in range(3):
        T1 = move[1, i] + C[2, i] * s1
        E1 = move[0, i] - C[1, i] * s1
        E2 = -2.0 * move[1, i] * s1 - C[2, i] * s1 * s1
        T2 = 2.0 * move[2, i] * s1 + C[3, i] * s1 * s1
        total += T2 * e[i] + 2.0 * T1 * E1 + C[1, i] * E2
    return total / D


@inner_kernel
def _drift(B, C, M, a, turn, e, move, s1, s2):
    """Return g'' at accelerations of the markers that are zero, s and its rates known; `turn` (n, 2, 3): a', a''."""
    total = 0.0
    for i in range(3):
        m_t, m_tt, m1_t = 0.0, 0.0, 0.0
        for k in range(a.shape[0]):
            m_t += B[0, k] * turn[k, 0, i]
            m_tt += B[0, k] * turn[k, 1, i]
            m1_t += B[1, k] * turn[k, 0, i]
        first = m_t + M[1, i] * s1
        second = m_tt + 2.0 * m1_t * s1 + M[2, i] * s1 * s1 + M[1, i] * s2
        E1 = move[0, i] - C[1, i] * s1
        E2 = -2.0 * move[1, i] * s1 - C[2, i] * s1 * s1 - C[1, i] * s2
        total += second * e[i] + 2.0 * first * E1 + M[0, i] * E2
    return total


@inner_kernel
def _slopes(B, C, M, a, e, D, Gx, Fx, mixed):
    """Write dG/dx, dF/dx at fixed s and d(G_s + mu F_s)/dx to (n + 1, 6) each; return mu = G_s/D.

    Leg 0 is the first marker of the path, leg 1 the point, the others follow as the markers of the path do.
    """
    t = np.empty(3)
    mu = (dot(M[1], e) - dot(M[0], C[1])) / D
    Gx[:] = 0.0
    Fx[:] = 0.0
    mixed[:] = 0.0
    for i in range(3):
        Gx[1, i] = M[0, i]
        Fx[1, i] = C[1, i]
        mixed[1, i] = M[1, i] + mu * C[2, i]
    for k in range(a.shape[0]):
        leg = k + 1 if k else 0
        for i in range(3):
            Gx[leg, i] = -B[0, k] * M[0, i]
            Fx[leg, i] = B[1, k] * e[i] - B[0, k] * C[1, i]
            mixed[leg, i] = -B[1, k] * M[0, i] - B[0, k] * M[1, i]
            mixed[leg, i] += mu * (B[2, k] * e[i] - 2.0 * B[1, k] * C[1, i] - B[0, k] * C[2, i])
        cross(a[k], e, t)
        for i in range(3):
            Gx[leg, 3 + i] = B[0, k] * t[i]
            mixed[leg, 3 + i] = B[1, k] * t[i]
        cross(a[k], C[1], t)
        for i in range(3):
            mixed[leg, 3 + i] -= B[0, k] * t[i]
    return mu


@inner_kernel
def _skew_blocks(K, row, column, scale, a):
    """Add scale a~ to the block at `row`, `column`, and its transpose to the mirrored one."""
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        K[row + k, column + j] += scale * a[i]
        K[row + j, column + k] -= scale * a[i]
        K[column + j, row + k] += scale * a[i]
        K[column + k, row + j] -= scale * a[i]


@inner_kernel
def _add_curvature(K, scale, B, a, e, mu):
    """Add scale (G_xx + mu F_xx) to `K`, at fixed s: what turned directions and moved tangents do."""
    n = a.shape[0]
    for k in range(n):
        leg = 6 * (k + 1) if k else 0
        _skew_blocks(K, 6, leg + 3, -scale * B[0, k], a[k])
        along = dot(a[k], e)
        for i in range(3):
            K[6 + i, leg + i] += scale * mu * B[1, k]
            K[leg + i, 6 + i] += scale * mu * B[1, k]
            for j in range(3):  # (theta x a) x e
                K[leg + 3 + i, leg + 3 + j] += scale * B[0, k] * a[k, i] * e[j]
            K[leg + 3 + i, leg + 3 + i] -= scale * B[0, k] * along
        for j in range(n):
            other = 6 * (j + 1) if j else 0
            _skew_blocks(K, other, leg + 3, scale * B[0, k] * B[0, j], a[k])
            for i in range(3):
                K[leg + i, other + i] -= scale * mu * (B[1, k] * B[0, j] + B[0, k] * B[1, j])


@inner_kernel
def _add_tangent(K, lam, B, C, M, a, e, D, mu, Fx, mixed):
    """Add -lam d(gradient)/dx, x the displacements of all markers, to `K`; s_x = F_x / D."""
    _add_curvature(K, -lam, B, a, e, mu)
    both = dot(M[2], e) - 2.0 * dot(M[1], C[1]) - dot(M[0], C[2])
    both += mu * (dot(C[3], e) - 3.0 * dot(C[1], C[2]))
    flat, slope = mixed.ravel(), Fx.ravel()
    for i in range(len(flat)):
        for j in range(len(flat)):
            K[i, j] -= lam / D * (flat[i] * slope[j] + slope[i] * flat[j] + both / D * slope[i] * slope[j])


@inner_kernel
def _gather(row, data, work, r, r_dot):
    """Write places and velocities of the markers of the path to `r`, `r_dot` (n, 3)."""
    for k in range(row.n):
        marker = work.markers[int(data[row.path + k])]
        for i in range(3):
            r[k, i], r_dot[k, i] = marker.r[i], marker.v[i]


@inner_kernel
def _directions(row, data, work, side, a, turn):
    """Write the directions a_k of an equation to `a` (n, 3), their rates and second rates to `turn` (n, 2, 3)."""
    for k in range(row.n):
        marker, at = work.markers[int(data[row.path + k])], row.across + 3 * (side * row.n + k)
        matvec(marker.R, data[at : at + 3], a[k])
        cross(marker.w, a[k], turn[k, 0])
        cross(marker.w, turn[k, 0], turn[k, 1])


@inner_kernel
def _add_to_matrix(row, data, work, K):
    """Add K (6 n + 6, 6 n + 6) of all legs to the iteration matrix, body by body."""
    count = row.n + 1
    numbers, spans, firsts = np.empty(count, np.int64), np.empty(count, np.int64), np.empty(count, np.int64)
    for k in range(count):
        numbers[k] = work.legs[row.leg + k].marker
        spans[k] = int(data[row.spans + k])
    total = own_parts(spans, numbers, work.markers, firsts)
    M = projected(numbers, firsts, total, K, np.zeros(K.shape), work)
    done = np.zeros((row.n_spans, row.n_spans))
    for c in range(count):
        for d in range(count):
            if done[spans[c], spans[d]] == 0.0:
                done[spans[c], spans[d]] = 1.0
                code = int(data[row.codes + row.n_spans * spans[c] + spans[d]])
                add_to_pair(code, M, firsts[c], firsts[d], work)


@row_kernel
def evaluate(raw, data, state, work):
    """g = m(s) . (p - c(s)) at the nearest point s of the path, eq. (on-path)."""
    rows = raw.view(ROW)
    C, M, move, e = np.empty((4, 3)), np.empty((3, 3)), np.empty((3, 3)), np.empty(3)
    for number in range(rows.shape[0]):
        row = rows[number]
        n = row.n
        r, r_dot, a, turn = np.empty((n, 3)), np.empty((n, 3)), np.empty((n, 3)), np.empty((n, 2, 3))
        B, K = np.empty((4, n)), np.zeros((6 * n + 6, 6 * n + 6))
        Gx, Fx, mixed = np.empty((n + 1, 6)), np.empty((n + 1, 6)), np.empty((n + 1, 6))
        _gather(row, data, work, r, r_dot)
        b, basis = work.markers[row.b], data[row.basis :]
        near = state.q[len(state.q) - len(work.branches) + row.branch]
        s = nearest_on_path(basis, r, b.r, near, B, C)
        work.branches[row.branch] = s
        outside = row.ends == 1 and (s < 0.0 or s > basis[n])
        for i in range(3):
            e[i] = b.r[i] - C[0, i]
        D = dot(C[1], C[1]) - dot(C[2], e)
        s1 = _rates(B, C, r_dot, b, e, D, move)
        s2 = _second_place(C, e, D, move, s1)
        for side in range(row.sides):
            equation = work.equations[row.equation + side]
            _directions(row, data, work, side, a, turn)
            _sum(B, a, M)
            mu = _slopes(B, C, M, a, e, D, Gx, Fx, mixed)
            lam = state.lam[row.equation + side]
            equation.g = dot(M[0], e) if not outside else np.nan
            equation.rate = 0.0
            equation.drift = _drift(B, C, M, a, turn, e, move, s1, s2)
            equation.force = lam
            for k in range(n + 1):
                leg = work.legs[row.leg + side * (n + 1) + k]
                marker = work.markers[leg.marker]
                for i in range(6):
                    leg.gradient[i] = Gx[k, i] + mu * Fx[k, i]
                    marker.wrench[i] += leg.gradient[i] * lam
            if work.weights[0].wanted == 1:
                _add_tangent(K, lam, B, C, M, a, e, D, mu, Fx, mixed)
        if work.weights[0].wanted == 1 and work.weights[0].stiffness != 0.0:
            _add_to_matrix(row, data, work, K)


@dataclass(frozen=True, eq=False)
class OnPath(Equation):
    """Marker b lies on the spline through marker a and further ones (two equations).

    Parameters
    ----------
    strict : bool
        Beyond the ends is an error.
    name : str
        Of the joint.
    axis : int
        -1: any directions across the path; 0, 1, 2: this axis of its markers.
    """

    strict: bool
    name: str
    axis: int = -1

    table: ClassVar[Table] = Table("OnPath", ROW, {"evaluate": evaluate})
    count: ClassVar[int] = 2
    stiffens: ClassVar[bool] = False

    def involved(self, markers):
        """Return all markers: a, b, and those through which the path goes on."""
        return markers

    def record(self, compiler, markers):
        """Return the own fields of the row."""
        path = (markers[0], *markers[2:])
        poses = [compiler.pose(m) for m in path]
        points = np.array([r for r, _ in poses])
        basis, across = cardinal_splines(points), self.directions(poses)
        groups: dict[tuple[int, int, int], int] = {}
        for marker in markers:
            groups.setdefault(compiler.span(marker), marker)
        n = len(groups)
        codes = block_codes(compiler, list(groups.values()), [(a, b) for b in range(n) for a in range(b)])
        return {
            "n": len(path),
            "sides": self.count,
            "path": compiler.bulk(np.array(path, float)),
            "basis": compiler.bulk(basis),
            "across": compiler.bulk(across),
            "spans": compiler.bulk(np.array([list(groups).index(compiler.span(m)) for m in markers], float)),
            "codes": compiler.bulk(codes),
            "n_spans": n,
            "ends": int(self.strict),
            "branch": compiler.branch(
                f"place on the path of {self.name}", nearest_place(basis, points, compiler.position(markers[1]))
            ),
        }

    def directions(self, poses) -> np.ndarray:
        """Return the directions (count, n, 3) across the path in the axes of its markers, as described."""
        if self.axis >= 0:
            return np.tile(np.eye(3)[self.axis], (1, len(poses), 1))
        table = pack_spline(np.array([r for r, _ in poses]), False)
        n = len(poses)
        found = np.empty((2, n, 3))
        coefficients = table[n + 1 :].reshape(n - 1, 4, 6)
        for k, (_, R) in enumerate(poses):
            h = table[1 + k] - table[min(k, n - 2) + 1]
            a3, a2, a1, a0 = coefficients[min(k, n - 2)]
            tangent = ((3.0 * a3 * h + 2.0 * a2) * h + a1)[:3]
            first = (((a3 * h + a2) * h + a1) * h + a0)[3:]
            second = np.cross(tangent / np.linalg.norm(tangent), first)
            found[0, k], found[1, k] = R.T @ first, R.T @ second
        return found


@dataclass(frozen=True, eq=False)
class OnStrip(OnPath):
    """Marker b lies on the surface along the path that has the given axis of its markers as normal (one equation).

    Parameters
    ----------
    strict : bool
        Beyond the ends is an error.
    name : str
        Of the joint.
    axis : int
        0, 1 or 2.
    """

    count: ClassVar[int] = 1


def nearest_place(basis: np.ndarray, points: np.ndarray, point: np.ndarray) -> float:
    """Return the parameter of the spline through `points` (n, 3) nearest to a point: the best of many, then Newton."""
    n = len(points)
    B, C = np.empty((4, n)), np.empty((4, 3))
    many = np.linspace(0.0, basis[n], 10 * n)
    distances = []
    for s in many:
        evaluate_cardinal(basis, s, B)
        distances.append(float(np.sum((point - B[0] @ points) ** 2)))
    return float(nearest_on_path(basis, points, point, many[int(np.argmin(distances))], B, C))
