"""Transverse shear of a stack of plies: the compliance (2, 2) that stores the energy of the shear stress in it.

J. M. Whitney, Shear correction factors for orthotropic laminates under static load, J. Appl. Mech. 40 (1973) 302-304;
K. Rohwer, Improved transverse shear stiffnesses for layered finite elements, DFVLR-FB 88-32 (1988).
"""

from __future__ import annotations

import numpy as np

from flexmb.fem.shells.laminate_block import turned_plane

__all__ = ["diagonal_compliance", "shear_compliance", "turned_compliance"]


def shear_compliance(plies: list[tuple[np.ndarray, float, float]], across: list[tuple[float, float]]) -> np.ndarray:
    """Return the compliance S (2, 2), m/N, of ``g = S q``: shear strains (xz, yz) by shear forces per width.

    Cylindrical bending about either axis has the shear stress ``q_a f_a(z)``, ``f_a = -int E_a z dz / int E_a z^2 dz``
    from the lower face, z from the neutral plane of E_a = Q_aa. The complementary energy of both is
    ``S_ab = int f_a (1 / G)_ab f_b dz``, where the compliance 1 / G of a ply is turned with it (docs/theory/shells.md,
    eq. (shell-laminate-shear)).

    Parameters
    ----------
    plies : list of (elasticity (3, 3), thickness, angle in rad), upwards, as in `laminate`
    across : list of (float, float), Pa
        Shear moduli (G_1z, G_2z) of each ply in its own axes; inf for rigid ones.
    """
    low = np.concatenate([[0.0], np.cumsum([thickness for _, thickness, _ in plies])])
    moduli = np.array([turned_plane(q, angle).diagonal()[:2] for q, _, angle in plies])  # (plies, 2)
    weight = moduli.T @ np.diff(low)
    if not (weight > 0.0).all():
        return np.zeros((2, 2))
    neutral = moduli.T @ np.diff(low**2) / 2.0 / weight
    inertia = np.array([moduli[:, k] @ np.diff((low - neutral[k]) ** 3) / 3.0 for k in range(2)])
    points, weights = np.polynomial.legendre.leggauss(3)  # exact: f^2 is of degree 4
    moment, total = np.zeros((2, 1)), np.zeros((2, 2))
    for k, ((_, thickness, angle), own) in enumerate(zip(plies, across, strict=True)):
        z = low[k] + 0.5 * thickness * (1.0 + points) - neutral[:, None]  # (2, points)
        begin, end = low[k] - neutral[:, None], low[k + 1] - neutral[:, None]
        flow = (moment - moduli[k][:, None] * (z**2 - begin**2) / 2.0) / inertia[:, None]
        soft = turned_compliance(diagonal_compliance(*own), angle)
        total += soft * ((flow * (0.5 * thickness * weights)) @ flow.T)
        moment = moment - moduli[k][:, None] * (end**2 - begin**2) / 2.0
    return total


def diagonal_compliance(first: float, second: float) -> np.ndarray:
    """Return the compliance (2, 2) of two stiffnesses along the axes; inf: rigid."""
    return np.diag([1.0 / first, 1.0 / second])


def turned_compliance(compliance: np.ndarray, angle) -> np.ndarray:
    """Return compliances (..., 2, 2) in axes from which their own are turned by `angle` (...), rad."""
    c, s = np.cos(angle), np.sin(angle)
    turn = np.moveaxis(np.array([[c, -s], [s, c]]), (0, 1), (-2, -1))
    return turn @ compliance @ turn.swapaxes(-1, -2)
