"""Numbers of cell types in VTK and XDMF; meshio uses VTK's node order."""

from __future__ import annotations

import numpy as np

from flexmb.errors import MeshError

__all__ = ["VTK_TYPES", "XDMF_TYPES", "flat_cells", "mixed_topology", "skin_cells"]

VTK_TYPES = {
    "vertex": 1,
    "line": 3,
    "triangle": 5,
    "quad": 9,
    "tetra": 10,
    "hexahedron": 12,
    "wedge": 13,
    "pyramid": 14,
    "line3": 21,
    "triangle6": 22,
    "quad8": 23,
    "tetra10": 24,
    "hexahedron20": 25,
    "wedge15": 26,
    "pyramid13": 27,
    "quad9": 28,
    "hexahedron27": 29,
}

XDMF_TYPES = {
    "vertex": 1,
    "line": 2,
    "triangle": 4,
    "quad": 5,
    "tetra": 6,
    "pyramid": 7,
    "wedge": 8,
    "hexahedron": 9,
    "line3": 34,
    "quad9": 35,
    "triangle6": 36,
    "quad8": 37,
    "tetra10": 38,
    "pyramid13": 39,
    "wedge15": 40,
    "hexahedron20": 48,
    "hexahedron27": 50,
}


def _number(table, name: str) -> int:
    if name not in table:
        raise MeshError(
            "VTK output",
            found=f"cell type '{name}'",
            expected=f"One of: {', '.join(table)}",
            remedy="Draw the part with another element type",
        )
    return table[name]


def flat_cells(cells) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return connectivity (flat), end of each cell in it (ne,), and VTK type of each cell (ne,)."""
    connectivity = np.concatenate([np.asarray(c).ravel() for _, c in cells]).astype(np.int64)
    lengths = np.concatenate([np.full(len(c), np.shape(c)[1]) for _, c in cells])
    types = np.concatenate([np.full(len(c), _number(VTK_TYPES, name), np.uint8) for name, c in cells])
    return connectivity, np.cumsum(lengths).astype(np.int64), types


def mixed_topology(cells) -> np.ndarray:
    """Return the cells as XDMF's mixed topology: type, (number of nodes for vertices and lines,) nodes, ..."""
    blocks = []
    for name, connectivity in cells:
        number = _number(XDMF_TYPES, name)
        head = [number] if number > 2 else [number, np.shape(connectivity)[1]]
        blocks.append(np.hstack([np.tile(head, (len(connectivity), 1)), connectivity]).ravel())
    return np.concatenate(blocks).astype(np.int64)


FACETS = {3: "triangle", 4: "quad", 6: "triangle6", 8: "quad8", 9: "quad9"}
"""Cell type of a facet by its number of nodes."""


def skin_cells(cells) -> tuple[np.ndarray | None, tuple[tuple[str, np.ndarray], ...]]:
    """Return the nodes on the skin of solid cells and the skin as cells on them; None and the cells if none is solid.

    Cells of other kinds (shells, lines) are part of the skin as they are.
    """
    from flexmb.fem.meshes.facets import skin
    from flexmb.fem.solids.elements import SOLID_ELEMENTS

    solid = [(name, np.asarray(rows)) for name, rows in cells if name in SOLID_ELEMENTS and len(rows)]
    if not solid:
        return None, tuple(cells)
    facets = skin(solid)
    counts = (facets >= 0).sum(axis=1)
    outer = [(FACETS[n], facets[counts == n][:, :n]) for n in np.unique(counts)]
    outer += [(name, np.asarray(rows)) for name, rows in cells if name not in SOLID_ELEMENTS]
    nodes = np.unique(np.concatenate([rows.ravel() for _, rows in outer]))
    return nodes, tuple((name, np.searchsorted(nodes, rows)) for name, rows in outer)
