"""Point masses of little or no mass between cut joints: unknowns of the closure instead of being eliminated.

The closing equations are condensed to the multipliers with the inverse masses of all bodies, eq. (tree-closure). A
point of mass m contributes 1 / m, which hides its neighbours' contributions by rounding. With m of 1e-8 of theirs the
joints of a rod on such a point would look dependent, and the rod would fall. Its accelerations stay unknown instead,

    [M_p, -G_p^T; G_p, W] (a_p, lam) = (f_p, -error),

which is regular for M_p = 0 as well, if the equations hold the point (Udwadia & Phohomsiri 2006). Motions of these
points that no equation holds are those of the points alone: their small masses would count as zero in that matrix.
"""

from __future__ import annotations

import numpy as np

from flexmb.tree.any_body.loops import RANK, independent_values

__all__ = ["LightPoints"]

LIGHT = 1e-3
"""Mass of a point, relative to what its equations feel of the other bodies, below which it is not eliminated."""
ROUNDED = 1e3 * np.finfo(float).eps
"""Of a sum: a term below this is not known."""


class LightPoints:
    """The light point masses of a tree at one state; what they would contribute to the closure is taken out of it.

    Attributes
    ----------
    velocities : (np,) of int
        Their velocities; none if all points are heavy.
    mass : (np,), kg
        By velocity.
    gradient : (nc, np)
        Of the cut equations.
    mobility : (nc,)
        About what a unit multiplier of each cut equation does to it by way of all other bodies.
    """

    def __init__(self, tables, work, store, system, mobility: np.ndarray):
        points = np.array([k for k in range(len(tables.iu)) if tables.outer[k] < 0 and tables.nu[k] == 3], int)
        first = np.asarray(tables.iu, int)[points]
        lent = np.zeros(system.nu)
        lent[system.program.floor_at[:, 0]] = system.program.floor
        diagonal = work.S[work.rows[first]]
        mass = diagonal - lent[first]
        mass[mass <= ROUNDED * diagonal] = 0.0
        gradient = _gradients(tables.cut_equations, work, first)
        felt = np.einsum("npj,npj->np", gradient, gradient)
        mobile = np.divide(1.0, diagonal, out=np.zeros(len(first)), where=diagonal > 0.0)
        others = mobility - felt @ mobile
        others[others <= ROUNDED * mobility] = 0.0
        light = self._light(mass, felt, others)
        self.velocities = (first[light][:, None] + np.arange(3)).ravel()
        self.mass = np.repeat(mass[light], 3)
        self.gradient = gradient[:, light].reshape(len(mobility), len(self.mass))
        self.mobility = others + felt[:, ~light] @ mobile[~light]
        if np.any(light):
            # an equation between such points only is as soft as the others
            usual = np.max(self.mobility, initial=0.0) or 1.0
            self.mobility = np.where(self.mobility > 0.0, self.mobility, usual)
        for k in points[light]:
            store.plain[tables.i_plain[k] : tables.i_plain[k] + 9] = 0.0  # what holds it decides how it moves

    @staticmethod
    def _light(mass: np.ndarray, felt: np.ndarray, others: np.ndarray) -> np.ndarray:
        """Return which points are light, (n,) of bool: beside the frames that they hold, or else the heaviest point."""
        if not len(mass) or not felt.size:
            return np.zeros(len(mass), bool)
        heaviest = np.max(mass)
        seen = others if np.any(others > 0.0) else np.full(len(felt), 1.0 / heaviest if heaviest > 0.0 else 0.0)
        touched = felt > 0.0
        usual = np.median(seen[seen > 0.0]) if np.any(seen > 0.0) else 0.0
        return np.any(touched, axis=0) & (mass * usual < LIGHT)

    def closer(self, values, tables):
        """Return what finds the accelerations (np,) of the points and the multipliers (nc,), and self-stresses (nc, k).

        `values` are what multipliers do by way of the other bodies (see `responses`). What is returned takes what the
        multipliers have to remove (nc,), and the loads (np,) of the points.
        """
        nc = len(self.mobility)
        W = np.zeros((nc, nc))
        columns = np.repeat(np.arange(nc), np.diff(tables.start_row))
        W[tables.rows, columns] = values
        of_lam = 1.0 / np.sqrt(self.mobility)
        rows = self.gradient * of_lam[:, None]
        size = np.linalg.norm(rows.reshape(nc, -1, 3), axis=(0, 2))  # by point: an axis may be across all its rods
        of_a = np.repeat(1.0 / np.where(size > 0.0, size, 1.0), 3)
        G = rows * of_a
        mass = self.mass * of_a**2
        move, alone = _apart(mass, G)
        held, r = G @ move, move.shape[1]
        matrix = np.block(
            [[move.T @ (mass[:, None] * move), -held.T], [held, of_lam[:, None] * W * of_lam]],
        )
        U, s, Vt = np.linalg.svd(matrix)
        kept = independent_values(s)

        def solved(error: np.ndarray, force: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
            force = of_a * force
            own = alone @ force
            right = np.concatenate([move.T @ force, -of_lam * error - G @ own])
            x = Vt[:kept].T @ ((U[:, :kept].T @ right) / s[:kept])
            return of_a * (own + move @ x[:r]), of_lam * x[r:]

        # without an effect on any body: multipliers that hold themselves in balance
        return solved, of_lam[:, None] * Vt[kept:, r:].T


def _apart(mass: np.ndarray, G: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the motions (n, r) that the gradients G (nc, n) hold, and what forces do to all others, (n, n).

    mass : (n,) what a motion that is held moves with it of the others costs no force: the two are apart by it
    """
    s, Vt = np.linalg.svd(G)[1:]
    r = int(np.sum(s > RANK * np.max(s, initial=0.0)))
    held, free = Vt[:r].T, Vt[r:].T
    inverse = np.linalg.pinv(free.T @ (mass[:, None] * free), rcond=ROUNDED, hermitian=True)
    alone = free @ inverse @ free.T
    return held - alone @ (mass[:, None] * held), alone


def _gradients(equations: np.ndarray, work, first: np.ndarray) -> np.ndarray:
    """Return the gradients (nc, n, 3) of equations with respect to points whose first velocities are `first` (n,)."""
    found = np.zeros((len(equations), len(first), 3))
    number = {int(iu): k for k, iu in enumerate(first)}
    for n, equation in enumerate(work.equations[equations] if len(first) else ()):
        for leg in work.legs[int(equation["leg"]) : int(equation["leg"]) + int(equation["legs"])]:
            marker = work.markers[leg["marker"]]
            k = number.get(int(marker["iu"])) if marker["nu"] == 3 else None
            if k is not None:
                at = int(marker["iJ"])
                found[n, k] += leg["gradient"] @ work.J[at : at + 18].reshape(6, 3)
    return found
