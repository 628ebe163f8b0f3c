"""Transverse shear of flat shell elements: the discrete Kirchhoff-Mindlin elements DKMQ and DKMT.

I. Katili, A new discrete Kirchhoff-Mindlin element based on Mindlin-Reissner plate theory and assumed shear strain
fields, parts I (triangle) and II (quadrilateral), Int. J. Numer. Meth. Eng. 36 (1993) 1859-1883 and 1885-1908. Each
edge shears by ``2/3 phi`` of the amplitude of its bow, ``phi = 12 D S / l^2`` with bending stiffness D and shear
compliance S along it; without shear deformation (phi = 0) they are DKT and DKQ.
"""

from __future__ import annotations

import numpy as np

from flexmb.fem.shells.bending import edge_bows
from flexmb.fem.shells.functions import Functions, edges

__all__ = ["edge_softness", "shear_rows", "stiffness_of"]

LEAST = 1e-2
"""A direction that does not shear, beside one that does, shears by this share of the other: a matrix that is singular
in part has no stiffness."""


def edge_softness(corners: np.ndarray, bending: np.ndarray, compliance: np.ndarray) -> np.ndarray:
    """Return phi (ne, c) of every edge: `bending` (ne, 3, 3), N m, and shear `compliance` (ne, 2, 2), m/N, in local
    axes.
    """
    length, tangent = edges(corners)
    x, y = tangent[..., 0], tangent[..., 1]
    rows = np.stack([x * x, y * y, x * y], axis=2)  # strain along the edge from (e_xx, e_yy, 2 e_xy)
    along = np.einsum("eci,eij,ecj->ec", rows, bending, rows)
    soft = np.einsum("eci,eij,ecj->ec", tangent, compliance, tangent)
    return 12.0 * along * soft / length**2


def shear_rows(corners: np.ndarray, at: Functions, softness: np.ndarray) -> np.ndarray:
    """Return the transverse shear strains (ne, 2, 6 c) per nodal displacement at a point."""
    ne, count = corners.shape[:2]
    length, tangent = edges(corners)
    share = (2.0 / 3.0) * softness[:, :, None, None] * edge_bows(corners, softness)  # along each edge, (ne, c, c, 6)
    rows = share.reshape(ne, count, 6 * count)
    if count == 4:
        xi, eta = at.xi, at.eta
        along_xi = 0.25 * (
            (1.0 - eta) * length[:, 0, None] * rows[:, 0] - (1.0 + eta) * length[:, 2, None] * rows[:, 2]
        )
        along_eta = 0.25 * ((1.0 + xi) * length[:, 1, None] * rows[:, 1] - (1.0 - xi) * length[:, 3, None] * rows[:, 3])
        x, y = np.array([[-1.0, 1.0, 1.0, -1.0], [-1.0, -1.0, 1.0, 1.0]])
        slope = 0.25 * np.stack([x * (1.0 + y * eta), y * (1.0 + x * xi)])
        return np.linalg.solve(slope @ corners, np.stack([along_xi, along_eta], axis=1))
    value = np.array([1.0 - at.xi - at.eta, at.xi, at.eta])
    out = np.zeros((ne, 2, 6 * count))
    for corner in range(3):
        before = (corner + 2) % 3
        pair = np.stack([tangent[:, corner], tangent[:, before]], axis=1)
        out += value[corner] * np.linalg.solve(pair, np.stack([rows[:, corner], rows[:, before]], axis=1))
    return out


def stiffness_of(compliance: np.ndarray) -> np.ndarray:
    """Return the stiffnesses H (ne, 2, 2), N/m, of compliances; zero where nothing shears."""
    values, vectors = np.linalg.eigh(compliance)
    largest = values[:, -1:]
    floor = np.where(largest > 0.0, LEAST * largest, 1.0)
    share = np.where(largest > 0.0, 1.0 / np.maximum(values, floor), 0.0)
    return (vectors * share[:, None, :]) @ vectors.swapaxes(1, 2)
