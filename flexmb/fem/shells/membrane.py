"""Membranes with a rotation about the normal at the corners, the triangle OPT and an Allman quadrilateral, or without.

Triangle: C. A. Felippa, A study of optimal membrane triangles with drilling freedoms, Comput. Methods Appl.
Mech. Eng. 192 (2003) 2125-2168, the ANDES template with the parameters OPT. Quadrilateral: A.
Ibrahimbegovic, R. L. Taylor, E. L. Wilson, A robust quadrilateral membrane finite element with drilling
degrees of freedom, Int. J. Numer. Meth. Eng. 30 (1990) 445-457, with two internal modes after R. L. Taylor,
P. J. Beresford, E. L. Wilson, ibid. 10 (1976) 1211-1219. Equations: docs/theory/shells.md. Freedoms per
corner: u, v, theta_z.

Without rotation (`bows` False): the triangle of constant strain, and the quadrilateral of Taylor, Beresford and Wilson
with its four internal modes. So are the shells of programs whose nodes do not turn in the plane.
"""

from __future__ import annotations

import numpy as np

from flexmb.fem.shells.functions import Functions, edges, functions, integration_points

__all__ = ["displacement_gradient", "displacement_rows", "drilling_row", "strain_rows"]

BETA = (1.0, 2.0, 1.0, 0.0, 1.0, -1.0, -1.0, -1.0, -2.0)
"""Felippa 2003, table 1, column OPT: beta_1 .. beta_9."""
NATURAL = (
    ((1, 2, 3), (4, 5, 6), (7, 8, 9)),
    ((9, 7, 8), (3, 1, 2), (6, 4, 5)),
    ((5, 6, 4), (8, 9, 7), (2, 3, 1)),
)
"""Felippa 2003, eq. 27: which beta stands where in Q_1, Q_2, Q_3 (rows: sides 21, 32, 13)."""


def strain_rows(corners: np.ndarray, elasticity: np.ndarray, poisson: float, bows: bool = True):
    """Return the function (xi, eta) -> (e_xx, e_yy, 2 e_xy) per nodal displacement, (ne, 3, 6 c).

    `elasticity` (3, 3), Pa, is for plane stress: the internal modes of the quadrilateral depend on it. `bows`: whether
    the edges bow with the rotations about the normal; without, these strain nothing.
    """
    if corners.shape[1] == 4:
        return _quadrilateral(corners, elasticity, bows)
    return _optimal_triangle(corners, poisson) if bows else _constant_triangle(corners)


def displacement_gradient(corners: np.ndarray, at: Functions, bows: bool = True) -> np.ndarray:
    """Return d(u, v)/d(x, y) of Allman's field per nodal displacement: (ne, 2 components, 2 derivatives, 6
    c).

    Linear (bilinear) functions, and per edge a bow ``l (theta_j - theta_i) / 8`` along the outward normal
    (eq. (shell-allman)), unless `bows` is False.
    """
    ne, count = corners.shape[:2]
    length, tangent = edges(corners)
    out = np.zeros((ne, 2, 2, count, 6))
    out[:, 0, :, :, 0] = at.gradient
    out[:, 1, :, :, 1] = at.gradient
    for k in range(count if bows else 0):
        outward = np.stack([tangent[:, k, 1], -tangent[:, k, 0]], axis=1)
        bow = outward[:, :, None] * at.edge_gradient[:, None, :, k] * (length[:, k] / 8.0)[:, None, None]
        out[:, :, :, (k + 1) % count, 5] += bow
        out[:, :, :, k, 5] -= bow
    return out.reshape(ne, 2, 2, 6 * count)


def displacement_rows(corners: np.ndarray, at: Functions, bows: bool = True) -> np.ndarray:
    """Return (u, v, w) per nodal displacement, (ne, 3, 6 c): linear (bilinear) fields plus one bow per edge.

    In the plane the bow of `displacement_gradient`, if `bows`; out of it ``l (w_s,i - w_s,j) / 8`` with w_s of the
    nodal rotations.
    """
    ne, count = corners.shape[:2]
    length, tangent = edges(corners)
    out = np.zeros((ne, 3, count, 6))
    for direction in range(3):
        out[:, direction, :, direction] = at.value
    for k in range(count):
        bow = at.edge_value[k] * length[:, k] / 8.0
        t_x, t_y = tangent[:, k, 0], tangent[:, k, 1]
        for corner, sign in ((k, 1.0), ((k + 1) % count, -1.0)):
            if bows:
                out[:, 0, corner, 5] -= sign * bow * t_y
                out[:, 1, corner, 5] += sign * bow * t_x
            out[:, 2, corner, 3] += sign * bow * t_y
            out[:, 2, corner, 4] -= sign * bow * t_x
    return out.reshape(ne, 3, 6 * count)


def drilling_row(corners: np.ndarray, at: Functions, bows: bool = True) -> np.ndarray:
    """Return ``theta_z - (v_x - u_y) / 2`` per nodal displacement, (ne, 6 c): the nodal rotation against
    the membrane's."""
    slope = displacement_gradient(corners, at, bows)
    row = (0.5 * (slope[:, 0, 1] - slope[:, 1, 0])).reshape(len(corners), -1, 6)
    row[:, :, 5] += at.value
    return row.reshape(len(corners), -1)


def _constant_triangle(corners: np.ndarray):
    at = functions(corners, 0.0, 0.0)
    slope = displacement_gradient(corners, at, False)
    rows = np.stack([slope[:, 0, 0], slope[:, 1, 1], slope[:, 0, 1] + slope[:, 1, 0]], axis=1)
    return lambda xi, eta: rows


def _quadrilateral(corners: np.ndarray, elasticity: np.ndarray, bows: bool):
    """Allman strains plus u = a_1 (1 - xi^2), v = a_2 (1 - eta^2), condensed: in-plane bending keeps its lateral
    contraction. Without bows both components get both modes, since the edges do not bend by themselves."""
    ne = len(corners)
    centre = functions(corners, 0.0, 0.0)
    modes = ((0, 0), (1, 1)) if bows else ((0, 0), (1, 1), (0, 1), (1, 0))  # (component, xi or eta)

    def compatible(at: Functions) -> np.ndarray:
        slope = displacement_gradient(corners, at, bows)
        return np.stack([slope[:, 0, 0], slope[:, 1, 1], slope[:, 0, 1] + slope[:, 1, 0]], axis=1)

    def internal(at: Functions) -> np.ndarray:
        # derivatives by the centre's axes, scaled so that they integrate to zero: constant strain stays exact
        slope = _inverse_jacobian(corners) @ np.array([[-2.0 * at.xi, 0.0], [0.0, -2.0 * at.eta]])
        slope *= (centre.weight / at.weight)[:, None, None]
        rows = np.zeros((ne, 3, len(modes)))
        for k, (component, square) in enumerate(modes):
            rows[:, component, k] = slope[:, component, square]
            rows[:, 2, k] = slope[:, 1 - component, square]
        return rows

    coupling, own = np.zeros((ne, len(modes), 24)), np.zeros((ne, len(modes), len(modes)))
    for xi, eta, weight in integration_points(4):
        at = functions(corners, xi, eta, weight)
        rows = internal(at)
        stress = at.weight[:, None, None] * (rows.swapaxes(1, 2) @ elasticity)
        coupling, own = coupling + stress @ compatible(at), own + stress @ rows
    amplitudes = -np.linalg.solve(own, coupling)

    def rows_at(xi: float, eta: float) -> np.ndarray:
        at = functions(corners, xi, eta)
        return compatible(at) + internal(at) @ amplitudes

    return rows_at


def _inverse_jacobian(corners: np.ndarray) -> np.ndarray:
    """Return (ne, 2, 2) at the centre: d(xi, eta) columns to d(x, y) rows."""
    x, y = 0.25 * np.array([[-1.0, 1.0, 1.0, -1.0], [-1.0, -1.0, 1.0, 1.0]])
    return np.linalg.inv(np.stack([x, y]) @ corners)


def _optimal_triangle(corners: np.ndarray, poisson: float):
    """Mean strain of the edge displacements plus ``3 sqrt(beta_0) / 2`` times the deviatoric one (eq.
    (shell-opt)).

    Both are orthogonal in energy, so their sum under the mid-edge rule is the stiffness K_b + K_h of the
    paper.
    """
    ne = len(corners)
    x, y = corners[:, :, 0], corners[:, :, 1]
    sides = ((1, 0), (2, 1), (0, 2))  # 21, 32, 13
    dx, dy = (np.stack([c[:, i] - c[:, j] for i, j in sides], axis=1) for c in (x, y))
    double_area = dx[:, 0] * dy[:, 1] - dx[:, 1] * dy[:, 0]
    squares = dx**2 + dy**2

    mean = np.zeros((ne, 3, 3, 6))
    turn = np.zeros((ne, 3, 3, 6))
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        x_kj, y_jk = x[:, k] - x[:, j], y[:, j] - y[:, k]
        x_ki, y_ik = x[:, k] - x[:, i], y[:, i] - y[:, k]
        x_ij, y_ji = x[:, i] - x[:, j], y[:, j] - y[:, i]
        mean[:, 0, i, 0] = mean[:, 2, i, 1] = y_jk
        mean[:, 1, i, 1] = mean[:, 2, i, 0] = x_kj
        mean[:, 0, i, 5] = 0.25 * y_jk * (y_ik - y_ji)  # alpha_b / 6 with alpha_b = 3 / 2
        mean[:, 1, i, 5] = 0.25 * x_kj * (x_ki - x_ij)
        mean[:, 2, i, 5] = 0.5 * (x_ki * y_ik - x_ij * y_ji)
        turn[:, :, i, 0], turn[:, :, i, 1] = x_kj[:, None], -y_jk[:, None]
        turn[:, i, i, 5] = 2.0 * double_area
    mean /= double_area[:, None, None, None]
    turn /= 2.0 * double_area[:, None, None, None]

    natural = _natural_to_cartesian(dx, dy, squares, double_area)
    scale = 1.5 * np.sqrt(max(0.5 * (1.0 - 4.0 * poisson**2), 0.01))
    beta = np.array([0.0, *BETA])[np.array(NATURAL)]  # (3 corners, 3 sides, 3)
    corner_rows = beta[:, None] * (double_area[:, None] / 3.0 / squares)[None, :, :, None]
    deviatoric = scale * natural @ corner_rows @ turn.reshape(ne, 3, 18)

    def rows_at(xi: float, eta: float) -> np.ndarray:
        at_point = np.tensordot(np.array([1.0 - xi - eta, xi, eta]), deviatoric, axes=1)
        return mean.reshape(ne, 3, 18) + at_point

    return rows_at


def _natural_to_cartesian(dx, dy, squares, double_area) -> np.ndarray:
    """Return (ne, 3, 3): Cartesian strains from the strains along the sides 21, 32, 13 (Felippa 2003, eq.
    21)."""
    rows = np.empty((len(dx), 3, 3))
    for side, (a, b) in enumerate(((1, 2), (2, 0), (0, 1))):  # the two other sides
        rows[:, 0, side] = -dy[:, a] * dy[:, b]
        rows[:, 1, side] = -dx[:, a] * dx[:, b]
        rows[:, 2, side] = dy[:, a] * dx[:, b] + dx[:, a] * dy[:, b]
    return rows * (squares / double_area[:, None] ** 2)[:, None, :]
