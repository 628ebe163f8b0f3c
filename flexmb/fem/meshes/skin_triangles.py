"""The surface of a mesh as triangles on its nodes."""

from __future__ import annotations

import numpy as np

from flexmb.fem.meshes.facets import skin
from flexmb.fem.solids.elements import SOLID_ELEMENTS

__all__ = ["skin_triangles"]

PARTS = {
    "triangle": ((0, 1, 2),),
    "quad": ((0, 1, 2), (0, 2, 3)),
    "triangle6": ((0, 3, 5), (3, 1, 4), (5, 4, 2), (3, 4, 5)),
    "quad8": ((0, 4, 7), (4, 1, 5), (5, 2, 6), (6, 3, 7), (4, 5, 7), (5, 6, 7)),
    "quad9": tuple((8, a, b) for a, b in ((0, 4), (4, 1), (1, 5), (5, 2), (2, 6), (6, 3), (3, 7), (7, 0))),
}
"""Triangles of a facet, by the places of its nodes, round the outward normal."""
FACETS = {3: "triangle", 4: "quad", 6: "triangle6", 8: "quad8", 9: "quad9"}


def skin_triangles(cells) -> tuple[np.ndarray, np.ndarray]:
    """Return the triangles (n, 3) of the free surface of solid cells, outward, and those (m, 3) of shell cells."""
    solid = [(name, np.asarray(rows)) for name, rows in cells if name in SOLID_ELEMENTS and len(rows)]
    outer = []
    if solid:
        facets = skin(solid)
        counts = (facets >= 0).sum(axis=1)
        outer = [(FACETS[int(n)], facets[counts == n][:, :n]) for n in np.unique(counts)]
    sheets = [(name, np.asarray(rows)) for name, rows in cells if name in PARTS and len(rows)]
    return _cut(outer), _cut(sheets)


def _cut(facets) -> np.ndarray:
    found = [rows[:, list(part)] for name, rows in facets for part in PARTS[name]]
    return np.concatenate(found).astype(np.int64) if found else np.zeros((0, 3), np.int64)
