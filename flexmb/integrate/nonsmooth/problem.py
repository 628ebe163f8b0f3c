"""The impulses of all contacts of a step as one problem, and block Gauss-Seidel sweeps over them.

Contact i has 1 row (no friction), 3 rows (normal, two tangents) or 6 (also spin about the normal and two rolling
velocities). Its velocity is ``xi = W_i v + shift``; an impulse P_i changes the velocities and the impulses of all
joints, springs and flexible coordinates of the parts it touches by ``X_i P_i``, X = S^-1 W^T with the factorised
iteration matrix S of the step. So joints beside a contact stay exact, and free bodies cost what they are. Theory:
nonsmooth.
"""

from __future__ import annotations

from typing import Annotated, NamedTuple

import numpy as np

from flexmb.integrate.nonsmooth.cone import disc_moment, residual_of_contact, solve_cone
from flexmb.math.block_parts import solve_part
from flexmb.math.kernel import inner_kernel, kernel
from flexmb.math.structures import ArrayOf, FloatRows, Floats, IntegerRows, Integers, structure

__all__ = ["POINT", "Problem", "add_impulse", "new_problem", "residuals", "sweep", "velocity_of", "write_problem"]

POINT = np.dtype(
    [
        ("a", np.int64),  # marker of the first surface
        ("b", np.int64),  # marker of the second
        ("owner", np.int64),  # number of the force
        ("key", np.int64),  # number of the pair of surfaces
        ("r", float, 3),  # m, the point in W
        ("axes", float, (3, 3)),  # normal from a to b, and two tangents, in W
        ("local", float, 3),  # m, the point in the axes of marker a
        ("gap", float),  # m
        ("restitution", float),
        ("poisson", float),
        ("was", float),  # m/s, normal velocity before the step
        ("strikes", np.int64),  # 1: that is the approach of an impact, in this step
        ("friction", float),
        ("drilling", float),  # m
        ("rolling", float),  # m
    ],
    align=True,
)
"""One point at which two surfaces touch or are about to."""


@structure
class Problem(NamedTuple):
    """The contacts of a step."""

    points: Annotated[np.ndarray, ArrayOf(POINT)]
    """(n,)"""
    rows: Integers
    """(n,) 1, 3 or 6"""
    legs: IntegerRows
    """(n, 6) first velocity, number of velocities and place in W of the markers a and b"""
    spans: IntegerRows
    """(n, 4) part, or -1, and place in X of the two parts"""
    W: Floats
    """velocity per velocities of a marker, (rows, nu) each"""
    X: Floats
    """change of the unknowns of a part by an impulse, (rows, size) each"""
    D: Floats
    """(36 n,) velocity per impulse of each contact, (rows, rows)"""
    P: FloatRows
    """(n, 6) N s, N m s"""
    shift: Floats
    """(n,) m/s, added to the normal velocity: of restitution, or of a gap that may close"""
    least: Floats
    """(n,) N s, least normal impulse"""
    before: Floats
    """(nu + ng,) velocities before the step, in body axes as W; zeros for the joints"""
    struck: FloatRows
    """(n, 6) N s, N m s, what impacts press into contacts that follow Poisson's law"""
    active: Integers
    """(n,) 1: takes part, 2: as an impact, 0: is not reached in this step"""


@inner_kernel
def _part_of(parts, marker):
    return parts.of[marker.iu] if marker.nu > 0 else -1


@kernel
def _measure(points, work, parts, frictionless, rows, legs, spans):
    """Write the shapes of all contacts; return the sizes of W and X."""
    size_W, size_X = 0, 0
    for i in range(len(points)):
        point = points[i]
        m = 3 if point.friction > 0.0 else 1
        if point.drilling > 0.0 or point.rolling > 0.0:
            m = 6
        rows[i] = 1 if frictionless else m
        for side in range(2):
            marker = work.markers[point.b if side == 1 else point.a]
            legs[i, 3 * side], legs[i, 3 * side + 1], legs[i, 3 * side + 2] = marker.iu, marker.nu, size_W
            size_W += rows[i] * marker.nu
            part = _part_of(parts, marker)
            if side == 1 and part == spans[i, 0]:
                part = -1
            spans[i, 2 * side], spans[i, 2 * side + 1] = part, size_X
            if part >= 0:
                size_X += rows[i] * (parts.start[part + 1] - parts.start[part])
    return size_W, size_X


def new_problem(points: np.ndarray, work, parts, frictionless: bool) -> Problem:
    """Return the storage for these contacts; `frictionless` ones have the normal row alone."""
    n = len(points)
    rows, legs, spans = np.zeros(n, np.int64), np.zeros((n, 6), np.int64), np.full((n, 4), -1, np.int64)
    size_W, size_X = _measure(points, work, parts, frictionless, rows, legs, spans)
    return Problem(
        points=points,
        rows=rows,
        legs=legs,
        spans=spans,
        W=np.zeros(max(1, size_W)),
        X=np.zeros(max(1, size_X)),
        D=np.zeros(36 * n),
        P=np.zeros((n, 6)),
        shift=np.zeros(n),
        least=np.zeros(n),
        before=np.zeros(len(parts.of)),
        struck=np.zeros((n, 6)),
        active=np.ones(n, np.int64),
    )


@inner_kernel
def _write_leg(point, marker, sign, rows, J, W, at):
    """Write W of one marker: a point moves with v + w x (r - r_marker)."""
    g = np.empty(6)
    for k in range(rows):
        axis = k if k < 3 else k - 3
        n0, n1, n2 = sign * point.axes[axis, 0], sign * point.axes[axis, 1], sign * point.axes[axis, 2]
        if k < 3:
            l0, l1, l2 = point.r[0] - marker.r[0], point.r[1] - marker.r[1], point.r[2] - marker.r[2]
            g[0], g[1], g[2] = n0, n1, n2
            g[3], g[4], g[5] = l1 * n2 - l2 * n1, l2 * n0 - l0 * n2, l0 * n1 - l1 * n0
        else:
            g[0] = g[1] = g[2] = 0.0
            g[3], g[4], g[5] = n0, n1, n2
        for i in range(6):
            if g[i] != 0.0:
                start = marker.iJ + i * marker.nu
                for j in range(marker.nu):
                    W[at + k * marker.nu + j] += g[i] * J[start + j]


@kernel
def write_problem(problem, work, S, pattern, parts):
    """Write W, X and D of all contacts with the factors S; velocities are taken from the markers of `work`."""
    p = problem
    total = len(parts.of)
    b, given = np.zeros(total), np.zeros(total)
    for i in range(len(p.points)):
        point, m = p.points[i], p.rows[i]
        for side in range(2):
            marker = work.markers[point.b if side == 1 else point.a]
            _write_leg(point, marker, 1.0 if side == 1 else -1.0, m, work.J, p.W, p.legs[i, 3 * side + 2])
        for side in range(2):
            part, at = p.spans[i, 2 * side], p.spans[i, 2 * side + 1]
            if part < 0:
                continue
            first, size = parts.start[part], parts.start[part + 1] - parts.start[part]
            for k in range(m):
                for leg in range(2):
                    iu, nu, w = p.legs[i, 3 * leg], p.legs[i, 3 * leg + 1], p.legs[i, 3 * leg + 2]
                    if nu > 0 and parts.of[iu] == part:
                        for j in range(nu):
                            b[iu + j] += p.W[w + k * nu + j]
                solve_part(S, pattern, parts, part, b, given)
                for n in range(size):
                    unknown = parts.unknowns[first + n]
                    p.X[at + k * size + n] = b[unknown]
                for leg in range(2):
                    iu, nu, w = p.legs[i, 3 * leg], p.legs[i, 3 * leg + 1], p.legs[i, 3 * leg + 2]
                    if nu > 0 and parts.of[iu] == part:
                        for r in range(m):
                            for j in range(nu):
                                p.D[36 * i + r * m + k] += p.W[w + r * nu + j] * b[iu + j]
                for n in range(size):
                    b[parts.unknowns[first + n]] = 0.0


@kernel
def velocity_of(p, i, v, xi):
    """Write the velocity W_i v of a contact (without its shift) to `xi`."""
    m = p.rows[i]
    for k in range(m):
        xi[k] = 0.0
    for leg in range(2):
        iu, nu, w = p.legs[i, 3 * leg], p.legs[i, 3 * leg + 1], p.legs[i, 3 * leg + 2]
        for k in range(m):
            total = 0.0
            for j in range(nu):
                total += p.W[w + k * nu + j] * v[iu + j]
            xi[k] += total


@kernel
def add_impulse(p, parts, i, dP, v):
    """Add the change of all unknowns by the impulse dP of contact i to `v`."""
    m = p.rows[i]
    for side in range(2):
        part, at = p.spans[i, 2 * side], p.spans[i, 2 * side + 1]
        if part < 0:
            continue
        first, size = parts.start[part], parts.start[part + 1] - parts.start[part]
        for k in range(m):
            x = dP[k]
            if x != 0.0:
                for n in range(size):
                    v[parts.unknowns[first + n]] += x * p.X[at + k * size + n]


@inner_kernel
def _turning(p, i, D, xi, P):
    """Write the moments of drilling and rolling friction that belong to the normal impulse, in place of P[3:]."""
    point, m = p.points[i], 6
    reach = point.drilling * P[0]
    if reach > 0.0 and D[3 * m + 3] > 0.0:
        P[3] = min(reach, max(-reach, P[3] - xi[3] / D[3 * m + 3]))
    else:
        P[3] = 0.0


@inner_kernel
def _rolling(p, i, D, xi, P):
    m = 6
    reach = p.points[i].rolling * P[0]
    if not reach > 0.0:
        P[4] = P[5] = 0.0
        return
    soft = 1e-13 * (D[4 * m + 4] + D[5 * m + 5])
    a, b, c, d = D[4 * m + 4] + soft, D[4 * m + 5], D[5 * m + 4], D[5 * m + 5] + soft
    x, y = xi[4] - a * P[4] - b * P[5], xi[5] - c * P[4] - d * P[5]
    P[4], P[5] = disc_moment(a, b, c, d, x, y, reach)


@kernel
def sweep(p, parts, v, backwards):
    """Solve every contact with all others as they are, one after another; return the largest change of a velocity (m/s)
    that an impulse has made, and how many contacts had no solution.
    """
    largest, unsolved = 0.0, 0
    xi, q, new, dP, D3 = np.zeros(6), np.empty(3), np.zeros(6), np.zeros(6), np.empty((3, 3))
    n = len(p.points)
    for turn in range(n):
        i = n - 1 - turn if backwards else turn
        if p.active[i] == 0:
            continue
        m, mu = p.rows[i], p.points[i].friction
        D = p.D[36 * i : 36 * i + m * m]
        P = p.P[i]
        velocity_of(p, i, v, xi)
        xi[0] += p.shift[i]
        if m == 1:
            new[0] = max(p.least[i], P[0] - xi[0] / D[0]) if D[0] > 0.0 else 0.0
        else:
            for r in range(3):
                q[r] = xi[r]
                new[r] = P[r]
                for k in range(3):
                    D3[r, k] = D[r * m + k]
                    q[r] -= D3[r, k] * P[k]
            if not solve_cone(D3, q, mu, new[:3], p.least[i]):
                unsolved += 1
        for k in range(min(m, 3)):
            dP[k] = new[k] - P[k]
            P[k] = new[k]
            largest = max(largest, abs(dP[k]) * D[k * m + k])
        for k in range(3, m):
            dP[k] = 0.0
        add_impulse(p, parts, i, dP, v)
        if m == 6:
            for stage in range(2):
                velocity_of(p, i, v, xi)
                for k in range(6):
                    new[k] = P[k]
                if stage == 0:
                    _turning(p, i, D, xi, new)
                else:
                    _rolling(p, i, D, xi, new)
                for k in range(6):
                    dP[k] = new[k] - P[k]
                    P[k] = new[k]
                    lever = (D[0] / D[k * m + k]) ** 0.5 if k >= 3 and D[k * m + k] > 0.0 else 1.0
                    largest = max(largest, abs(dP[k]) * D[k * m + k] * lever)
                add_impulse(p, parts, i, dP, v)
    return largest, unsolved


@kernel
def residuals(p, v, out):
    """Write by how much (m/s) every contact misses its laws to `out` (n,); return the largest and its contact."""
    xi, largest, worst = np.zeros(6), 0.0, 0
    for i in range(len(p.points)):
        out[i] = 0.0
        m = p.rows[i]
        D0 = p.D[36 * i]
        if p.active[i] == 0 or not D0 > 0.0:
            continue
        point, P = p.points[i], p.P[i]
        velocity_of(p, i, v, xi)
        xi[0] += p.shift[i]
        if m == 1:
            out[i] = abs(P[0] - max(p.least[i], P[0] - xi[0] / D0)) * D0
        else:
            most = max(D0, p.D[36 * i + m + 1], p.D[36 * i + 2 * m + 2])
            out[i] = residual_of_contact(P, xi, 1.0 / most, point.friction, p.least[i])
        if m == 6:
            d = p.D[36 * i + 3 * m + 3]
            reach = point.drilling * P[0]
            lever = (D0 / d) ** 0.5 if d > 0.0 else 0.0
            out[i] = max(out[i], abs(P[3] - min(reach, max(-reach, P[3] - xi[3] / d))) * d * lever if d > 0.0 else 0.0)
            d = max(p.D[36 * i + 4 * m + 4], p.D[36 * i + 5 * m + 5])
            if d > 0.0:
                y, z, reach = P[4] - xi[4] / d, P[5] - xi[5] / d, point.rolling * P[0]
                size = (y * y + z * z) ** 0.5
                part = 1.0 if size <= reach else reach / size
                missed = ((P[4] - part * y) ** 2 + (P[5] - part * z) ** 2) ** 0.5
                out[i] = max(out[i], missed * d * (D0 / d) ** 0.5)
        if not out[i] <= largest:
            largest, worst = out[i], i
    return largest, worst
