"""Thin plate bending of flat triangles and quadrilaterals: the discrete Kirchhoff elements DKT and DKQ.

J.-L. Batoz, K.-J. Bathe, L.-W. Ho, A study of three-node triangular plate bending elements, Int. J. Numer.
Meth. Eng. 15 (1980) 1771-1812; J.-L. Batoz, M. Ben Tahar, Evaluation of a new quadrilateral thin plate
bending element, ibid. 18 (1982) 1655-1677. Both are one formula here: docs/theory/shells.md, eq.
(shell-kirchhoff). Freedoms per corner: w, theta_x, theta_y.
"""

from __future__ import annotations

import numpy as np

from flexmb.fem.shells.functions import Functions, edges

__all__ = ["curvature_rows", "edge_bows", "slope_rows"]


def curvature_rows(corners: np.ndarray, at: Functions, softness: np.ndarray | None = None) -> np.ndarray:
    """Return (w_xx, w_yy, 2 w_xy), 1/m, of the discrete Kirchhoff slopes per nodal displacement: (ne, 3, 6 c).

    With `softness` phi (ne, c) of the edges the slopes belong to the sections of a plate that shears
    (`shell_shear`).
    """
    along_x = _slopes(corners, at.gradient[:, 0], at.edge_gradient[:, 0], softness)
    along_y = _slopes(corners, at.gradient[:, 1], at.edge_gradient[:, 1], softness)
    return np.stack([along_x[:, 0], along_y[:, 1], along_y[:, 0] + along_x[:, 1]], axis=1)


def slope_rows(corners: np.ndarray, at: Functions) -> np.ndarray:
    """Return the discrete Kirchhoff slopes (w_x, w_y) per nodal displacement: (ne, 2, 6 c)."""
    shape = (len(corners), corners.shape[1])
    return _slopes(corners, np.broadcast_to(at.value, shape), np.broadcast_to(at.edge_value, shape))


def edge_bows(corners: np.ndarray, softness: np.ndarray | None = None) -> np.ndarray:
    """Return the amplitude of the slope along each edge per nodal displacement: (ne, edge, corner, 6).

    The size that gives the middle the slope of the cubic line w(s): ``3 (w_j - w_i) / (2 l) - 3 (w_s,i +
    w_s,j) / 4``, divided by 1 + phi where the plate shears (Katili 1993, eq. 16).
    """
    ne, count = corners.shape[:2]
    length, tangent = edges(corners)
    bows = np.zeros((ne, count, count, 6))
    for k in range(count):
        i, j = k, (k + 1) % count
        bows[:, k, i, 2], bows[:, k, j, 2] = -1.5 / length[:, k], 1.5 / length[:, k]
        for corner in (i, j):
            bows[:, k, corner, 3] = -0.75 * tangent[:, k, 1]
            bows[:, k, corner, 4] = 0.75 * tangent[:, k, 0]
    return bows if softness is None else bows / (1.0 + softness)[:, :, None, None]


def _slopes(
    corners: np.ndarray, value: np.ndarray, edge_value: np.ndarray, softness: np.ndarray | None = None
) -> np.ndarray:
    """Return (ne, 2, 6 c) for corner and edge functions, or one derivative of them, (ne, c).

    At the corners ``w_x = -theta_y, w_y = theta_x``. Edge k adds its bow along its tangent.
    """
    ne, count = value.shape
    tangent = edges(corners)[1]
    bows = edge_bows(corners, softness)
    out = np.zeros((ne, 2, count, 6))
    out[:, 0, :, 4] = -value
    out[:, 1, :, 3] = value
    for k in range(count):
        out += (edge_value[:, k, None] * tangent[:, k])[:, :, None, None] * bows[:, k, None]
    return out.reshape(ne, 2, 6 * count)
