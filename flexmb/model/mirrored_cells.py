"""Cells of a mirror image: the nodes in an order that is not inside out."""

from __future__ import annotations

import numpy as np

__all__ = ["mirrored_cells"]

ORDERS = {
    "triangle": (0, 2, 1),
    "triangle6": (0, 2, 1, 5, 4, 3),
    "quad": (0, 3, 2, 1),
    "quad8": (0, 3, 2, 1, 7, 6, 5, 4),
    "quad9": (0, 3, 2, 1, 7, 6, 5, 4, 8),
    "tetra": (0, 2, 1, 3),
    "tetra10": (0, 2, 1, 3, 6, 5, 4, 7, 9, 8),
    "hexahedron": (0, 3, 2, 1, 4, 7, 6, 5),
    "hexahedron20": (0, 3, 2, 1, 4, 7, 6, 5, 11, 10, 9, 8, 15, 14, 13, 12, 16, 19, 18, 17),
    "hexahedron27": (0, 3, 2, 1, 4, 7, 6, 5, 11, 10, 9, 8, 15, 14, 13, 12, 16, 19, 18, 17, 22, 23, 20, 21, 24, 25, 26),
    "wedge": (0, 2, 1, 3, 5, 4),
    "wedge15": (0, 2, 1, 3, 5, 4, 8, 7, 6, 11, 10, 9, 12, 14, 13),
    "pyramid": (0, 3, 2, 1, 4),
    "pyramid13": (0, 3, 2, 1, 4, 8, 7, 6, 5, 9, 12, 11, 10),
}
"""New order of the nodes by meshio cell type; points and lines have no inside."""


def mirrored_cells(cells: tuple[tuple[str, np.ndarray], ...]) -> tuple[tuple[str, np.ndarray], ...]:
    """Return the cells (meshio cell type, (ne, nn) int) of the image of a mesh in a mirror."""
    return tuple((kind, np.asarray(nodes)[:, ORDERS[kind]] if kind in ORDERS else nodes) for kind, nodes in cells)
