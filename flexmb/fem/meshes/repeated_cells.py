"""Cells that are listed twice: each copy would carry stiffness and mass of its own."""

from __future__ import annotations

import numpy as np

from flexmb.fem.meshes.facets import row_keys

__all__ = ["CORNER_NODES", "first_copies", "merged_copies"]

CORNER_NODES = {
    "line": 2,
    "line3": 2,
    "triangle": 3,
    "triangle6": 3,
    "quad": 4,
    "quad8": 4,
    "quad9": 4,
    "tetra": 4,
    "tetra10": 4,
    "hexahedron": 8,
    "hexahedron20": 8,
    "hexahedron27": 8,
    "wedge": 6,
    "wedge15": 6,
}
"""Corner nodes by cell type; they stand first in every row."""


SOLIDS = frozenset(kind for kind in CORNER_NODES if kind.startswith(("tetra", "hexa", "wedge")))


def first_copies(cell_type: str, connectivity: np.ndarray) -> np.ndarray:
    """Return for every cell the number of the first one with the same corner nodes, in whatever order, (ne,)."""
    (key,) = row_keys(np.sort(connectivity[:, : CORNER_NODES[cell_type]], axis=1))
    first = np.full(int(key.max(initial=-1)) + 1, len(key))
    np.minimum.at(first, key, np.arange(len(key)))
    return first[key]


def merged_copies(
    cell_type: str, cells: np.ndarray, groups: dict[str, np.ndarray], once_per_group: bool
) -> tuple[np.ndarray, np.ndarray, int]:
    """Return which cells to keep, the new number of every cell, and how many copies nobody can have meant.

    Copies of solids are merged, and copies of lines and surfaces in the same groups. Copies in other groups are two
    parts that lie on one another (a rod along a bar, a doubler on a skin).

    Parameters
    ----------
    groups : dict of name to row numbers
    once_per_group : bool
        The format writes a cell once for each of its groups (Gmsh 2.2): such copies are the same cell, and meant.
    """
    first = first_copies(cell_type, cells)
    every = np.arange(len(cells))
    if np.array_equal(first, every):
        return every, every, 0
    again, member = np.zeros(len(cells), bool), np.zeros(len(cells), bool)  # once more in a group; in any group
    for rows in groups.values():
        member[rows] = True
        _, earliest = np.unique(first[rows], return_index=True)
        again[np.delete(rows, earliest)] = True
    again |= (first != every) & ~member
    merged = again | (first != every) & (once_per_group or cell_type in SOLIDS)
    number = np.cumsum(~merged) - 1
    unmeant = int((again if once_per_group else merged).sum())
    return np.flatnonzero(~merged), number[np.where(merged, first, every)], unmeant
