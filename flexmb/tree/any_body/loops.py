"""Closed loops: what unit multipliers of the cut equations do to the tree, and the multipliers that close it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy import sparse
from scipy.linalg import svd
from scipy.sparse.linalg import splu

from flexmb.math.kernel import inner_kernel, kernel
from flexmb.tree.any_body.passes import joint_multipliers, solve

__all__ = ["add_loads", "are_open", "closer", "independent_values", "mobilities", "responses", "stress_basis"]

RANK = 1e-7
"""Singular values of the scaled closing equations below this, relative to the largest, count as dependence.

They are squares of the values of G: near a singular position a smaller bound turns rounding into accelerations, which
explicit methods follow with ever smaller steps. Tried on two four-bars that pass a line within 1 s: at 1e-8 144 steps
and 4e-5 J of energy lost, at 1e-7 91 steps and 1e-8 J, at 1e-6 no better, at 1e-5 2e-7 J.
"""
USUAL = 10.0
"""A singular value beyond this is that of a body which hardly resists, and no measure for the others."""
ROUNDING = 1e-13
"""The same, relative to free bodies: where all closing equations are dependent, the largest is rounding as well. Also
relative to the largest value, whatever its size."""
DENSE = 400
"""Number of cut equations up to which they are solved by singular values."""
OPEN = 1e-3
"""Acceleration that is left of a closing equation, relative to its terms, above which the equation does not hold."""
NOISE = 1e-9
"""The same, relative to the largest terms of all closing equations, below which it is rounding."""
SHIFT = 1e-11
"""Added to the scaled diagonal beyond that number, so that dependent equations have a solution."""


@kernel
def add_loads(work, equations, lam, force):
    """Add the generalised forces of multipliers `lam` of some equations to `force` (nu,)."""
    for n in range(len(equations)):
        row = work.equations[equations[n]]
        for m in range(row.leg, row.leg + row.legs):
            leg = work.legs[m]
            marker = work.markers[leg.marker]
            nu = marker.nu
            for k in range(6):
                x = leg.gradient[k] * lam[n]
                if x == 0.0:
                    continue
                for j in range(nu):
                    force[marker.iu + j] += x * work.J[marker.iJ + k * nu + j]
                    if marker.iH >= 0:
                        force[marker.iu + j] -= x * work.H[marker.iH + k * nu + j]


@inner_kernel
def _gradient_times(work, equation, a):
    """Return G[equation] a."""
    row = work.equations[equation]
    s = 0.0
    for n in range(row.leg, row.leg + row.legs):
        leg = work.legs[n]
        marker = work.markers[leg.marker]
        for k in range(6):
            x = leg.gradient[k]
            if x != 0.0:
                for j in range(marker.nu):
                    s += x * work.J[marker.iJ + k * marker.nu + j] * a[marker.iu + j]
    return s


@kernel
def responses(tables, work, store, force, a, values):
    """Write what unit multipliers do to the cut equations they reach, eq. (tree-closure), in the order of tables.rows.

    `force` and `a` (nu,) are zero, and are zero again afterwards.
    """
    unit = np.ones(1)
    for n in range(len(tables.cut_equations)):
        add_loads(work, tables.cut_equations[n : n + 1], unit, force)
        for t in range(tables.start_cut_tree[n], tables.start_cut_tree[n + 1]):
            solve(tables, store, tables.cut_trees[t], force, 0.0, a)
        for r in range(tables.start_row[n], tables.start_row[n + 1]):
            values[r] = _gradient_times(work, tables.cut_equations[tables.rows[r]], a)
        for t in range(tables.start_cut_tree[n], tables.start_cut_tree[n + 1]):
            tree = tables.cut_trees[t]
            for k in range(tables.trees[tree], tables.trees[tree + 1]):
                for j in range(tables.iu[k], tables.iu[k] + tables.nu[k]):
                    force[j] = 0.0
                    a[j] = 0.0


@kernel
def mobilities(work, equations, least, out):
    """Write about what a unit multiplier of each equation does to it between free bodies, whose inertias are at least
    `least` (nu,).
    """
    for n in range(len(equations)):
        row = work.equations[equations[n]]
        out[n] = 0.0
        for m in range(row.leg, row.leg + row.legs):
            leg = work.legs[m]
            marker = work.markers[leg.marker]
            for j in range(marker.nu):
                x = 0.0
                for k in range(6):
                    x += leg.gradient[k] * work.J[marker.iJ + k * marker.nu + j]
                inertia = max(least[marker.iu + j], work.S[work.rows[marker.iu + j] + j])
                out[n] += x * x / inertia if inertia > 0.0 else 0.0  # a point without mass: see LightPoints


@kernel
def are_open(work, equations, usual, a):
    """Is one of the equations not satisfied by the accelerations a (nu,), beyond rounding and singular positions?

    usual : (nc,) mobilities, which make equations comparable
    """
    left, terms, most = np.zeros(len(equations)), np.zeros(len(equations)), 0.0
    for n in range(len(equations)):
        row = work.equations[equations[n]]
        one = usual[n] ** -0.5 if usual[n] > 0.0 else 0.0
        left[n], terms[n] = one * row.drift, one * abs(row.drift)
        for m in range(row.leg, row.leg + row.legs):
            leg = work.legs[m]
            marker = work.markers[leg.marker]
            for k in range(6):
                left[n] += one * leg.gradient[k] * marker.bias[k]
                terms[n] += one * abs(leg.gradient[k] * marker.bias[k])
            for j in range(marker.nu):
                x = 0.0
                for k in range(6):
                    x += leg.gradient[k] * work.J[marker.iJ + k * marker.nu + j]
                left[n] += one * x * a[marker.iu + j]
                terms[n] += one * abs(x * a[marker.iu + j])
        most = max(most, terms[n])
    return bool(np.any(np.abs(left) > np.maximum(OPEN * terms, NOISE * most)))


def independent_values(s: np.ndarray) -> int:
    """Return how many singular values, in falling order, are those of independent equations."""
    return int(np.sum(s > max(RANK * min(s[0], USUAL), ROUNDING * max(s[0], 1.0))))


def closer(tables, values, mobility) -> tuple[Callable[[np.ndarray], np.ndarray], np.ndarray]:
    """Return what finds the multipliers (nc,) that remove errors of the cut equations (nc,), and self-stresses (nc, k).

    They are made comparable by their mobilities between free bodies (nc,), as a loop may leave an equation none.
    Self-stresses are multipliers without effect, from dependent equations; beyond `DENSE` they are not sought.
    """
    nc = len(mobility)
    matrix = sparse.csc_matrix((values, tables.rows, tables.start_row), shape=(nc, nc))
    scale = 1.0 / np.sqrt(mobility)
    matrix = sparse.diags(scale) @ matrix @ sparse.diags(scale)
    if nc <= DENSE:
        U, s, Vt = svd(matrix.toarray())
        rank = independent_values(s)
        pushed, moved = scale[:, None] * Vt[:rank].T / s[:rank], U[:, :rank].T * scale
        return lambda error: -pushed @ (moved @ error), scale[:, None] * Vt[rank:].T
    factors = splu((matrix + SHIFT * sparse.eye(nc)).tocsc())

    def solved(error):
        x, right = np.zeros(nc), -scale * error
        for _ in range(4):
            x += factors.solve(right - matrix @ x)
        return scale * x

    return solved, np.zeros((nc, 0))


def stress_basis(tables, work, store, stresses, weight, nu: int) -> np.ndarray:
    """Return an orthonormal basis (ng, k) of the self-stresses of all joints, times the roots of weights (ng,).

    Without their parts along it, multipliers times these roots have least norm.
    """
    full, a = np.zeros((len(weight), stresses.shape[1])), np.zeros(nu)
    for n in range(stresses.shape[1]):
        force, column = np.zeros(nu), np.zeros(len(weight))
        column[tables.cut_equations] = stresses[:, n]
        add_loads(work, tables.cut_equations, np.ascontiguousarray(stresses[:, n]), force)
        for tree in range(len(tables.trees) - 1):
            solve(tables, store, tree, force, 0.0, a)
        joint_multipliers(tables, store, column)
        full[:, n] = column
    return np.linalg.qr(np.sqrt(weight)[:, None] * full)[0]
