"""`Mesh`: nodes, cells of any mixture of kinds, and named groups, as a mesh file gives them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from flexmb.errors import MeshError, did_you_mean
from flexmb.model.numbering import Numbering

__all__ = ["DIMENSION", "Mesh", "MeshWarning"]

DIMENSION = {
    "vertex": 0,
    "line": 1,
    "line3": 1,
    "triangle": 2,
    "triangle6": 2,
    "quad": 2,
    "quad8": 2,
    "quad9": 2,
    "tetra": 3,
    "tetra10": 3,
    "hexahedron": 3,
    "hexahedron20": 3,
    "hexahedron27": 3,
    "wedge": 3,
    "wedge15": 3,
}
"""Dimension of every cell kind that flexmb reads, by its name in meshio's spelling."""

NODES = {
    "vertex": 1,
    "line": 2,
    "line3": 3,
    "triangle": 3,
    "triangle6": 6,
    "quad": 4,
    "quad8": 8,
    "quad9": 9,
    "tetra": 4,
    "tetra10": 10,
    "hexahedron": 8,
    "hexahedron20": 20,
    "hexahedron27": 27,
    "wedge": 6,
    "wedge15": 15,
}
"""Nodes per cell."""

LARGEST = 1e30
"""Coordinate, m, beyond which volumes and stiffnesses leave the range of numbers."""


class MeshWarning(UserWarning):
    """A mesh can be used, but is probably not what was meant."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Mesh:
    """Nodes, cells and named groups. A skfem.Mesh holds one kind of cell; a real part has several.

    Parameters
    ----------
    points : (n, 3), m
        Node positions, body axes.
    cells : tuple of (cell type, (ne, nodes per cell) int)
        One entry per cell type, in meshio's names and node order.
    node_sets : mapping of name to node numbers
        Every named group of any dimension, as its nodes.
    facet_sets : mapping of name to (nf, nodes per facet)
        Named groups of surface cells. Rows of a set that mixes triangles and quadrilaterals end in -1.
    cell_sets : mapping of name to a tuple of cell numbers
        Named groups of cells: one array of row numbers per entry of `cells`.
    name : str
        Used in messages and reports.
    warnings : tuple of str
        Warnings when the mesh was read; the FE model keeps them.
    numbering : Numbering or None
        Numbers of the nodes in the file; None where they equal the rows.
    """

    points: np.ndarray
    cells: tuple[tuple[str, np.ndarray], ...]
    node_sets: Mapping[str, np.ndarray] = field(default_factory=dict)
    facet_sets: Mapping[str, np.ndarray] = field(default_factory=dict)
    cell_sets: Mapping[str, tuple[np.ndarray, ...]] = field(default_factory=dict)
    name: str = "part"
    warnings: tuple[str, ...] = ()
    numbering: Numbering | None = None

    def __post_init__(self):
        part, shape = f"Mesh '{self.name}'", np.shape(self.points)
        if len(shape) != 2 or shape[1] != 3:
            raise MeshError(
                part,
                found=f"points have the shape {shape}",
                expected="(n, 3)",
                remedy="Give one row x, y, z per node; planar meshes need z = 0",
            )
        if not np.all(np.isfinite(self.points)):
            bad = int(np.flatnonzero(~np.isfinite(self.points).all(axis=1))[0])
            raise MeshError(
                part,
                found=f"node {bad} is at {self.points[bad]}",
                expected="finite coordinates",
                remedy="Write the mesh again",
            )
        if np.abs(self.points).max(initial=0.0) > LARGEST:
            bad = int(np.abs(self.points).max(axis=1).argmax())
            raise MeshError(
                part,
                found=f"node {bad} is at {np.asarray(self.points)[bad].tolist()} m",
                expected=f"coordinates up to {LARGEST:g} m, whose products are finite",
                remedy="A number of the file is damaged: write the mesh again",
            )
        for cell_type, connectivity in self.cells:
            check_cells(part, cell_type, connectivity, len(self.points))

    def __repr__(self):
        counts = ", ".join(f"{len(rows)} {kind}" for kind, rows in self.cells) or "no cells"
        size = " x ".join(f"{x:.4g}" for x in np.ptp(self.points, axis=0)) if len(self.points) else "0"
        sets = ", ".join(sorted({*self.node_sets, *self.facet_sets, *self.cell_sets})) or "none"
        return f"Mesh('{self.name}': {len(self.points)} nodes, {counts}, {size} m, sets: {sets})"

    def cells_of(self, cell_type: str) -> np.ndarray:
        """Return the connectivity of one cell type, (ne, nodes per cell); empty if there is none."""
        for found, connectivity in self.cells:
            if found == cell_type:
                return connectivity
        return np.zeros((0, NODES[cell_type]), int)

    def cell_set(self, name: str) -> tuple[np.ndarray, ...]:
        """Return the cell numbers of a named set, one array per entry of `cells`."""
        if name not in self.cell_sets:
            known = ", ".join(sorted(self.cell_sets)) or "none"
            raise MeshError(
                f"Mesh '{self.name}'",
                found=f"the cell set '{name}' does not exist",
                expected=f"One of: {known}",
                remedy=did_you_mean(name, self.cell_sets),
            )
        return self.cell_sets[name]

    def only(self, *names: str) -> Mesh:
        """Return the mesh of the cells of some cell sets: ``fem.shell(mesh.only("skin"), ...)`` of a mesh with solids.

        Nodes of other cells go; the sets of nodes, facets and cells that are left keep their names.
        """
        kept = [
            np.unique(np.concatenate([np.asarray(self.cell_set(name)[k], int) for name in names]))
            for k in range(len(self.cells))
        ]
        new = [np.full(len(cells), -1) for _, cells in self.cells]
        for number, rows in zip(new, kept):
            number[rows] = np.arange(len(rows))
        sets = {
            key: tuple(number[rows][number[rows] >= 0] for number, rows in zip(new, members))
            for key, members in self.cell_sets.items()
        }
        used = np.zeros(len(self.points) + 1, bool)
        for (_, cells), rows in zip(self.cells, kept):
            used[cells[rows]] = True
        used[-1] = True  # the filler -1 of mixed facet rows
        facets = {key: rows[used[rows].all(axis=1)] for key, rows in self.facet_sets.items()}
        mesh = replace(
            self,
            cells=tuple((kind, cells[rows]) for (kind, cells), rows in zip(self.cells, kept)),
            cell_sets={key: members for key, members in sets.items() if any(map(len, members))},
            facet_sets={key: rows for key, rows in facets.items() if len(rows)},
        )
        return mesh.without_unused_nodes()

    def scaled(self, factor: float) -> Mesh:
        """Return the mesh with all coordinates multiplied: ``scaled(1e-3)`` turns millimetres into metres."""
        return replace(self, points=self.points * factor)

    def without_unused_nodes(self) -> Mesh:
        """Return the mesh without nodes that belong to no cell, renumbered consistently in the same order."""
        used = np.zeros(len(self.points), bool)
        for _, connectivity in self.cells:
            used[connectivity] = True
        if used.all():
            return self
        number = np.where(used, np.cumsum(used) - 1, -1)
        number = np.append(number, -1)  # so that the filler -1 of mixed facet rows stays -1
        return replace(
            self,
            points=self.points[used],
            cells=tuple((cell_type, number[connectivity]) for cell_type, connectivity in self.cells),
            node_sets={name: number[nodes[used[nodes]]] for name, nodes in self.node_sets.items() if used[nodes].any()},
            facet_sets={name: number[facets] for name, facets in self.facet_sets.items()},
            numbering=None if self.numbering is None else self.numbering.of(np.flatnonzero(used), self.numbering.cells),
        )


def check_cells(part: str, cell_type: str, connectivity: np.ndarray, n_nodes: int) -> None:
    """Raise MeshError unless the cells are of a known kind and name existing nodes."""
    if cell_type not in DIMENSION:
        raise MeshError(
            part,
            found=f"{len(connectivity)} cells of the type '{cell_type}'",
            expected=f"One of: {', '.join(DIMENSION)}",
            remedy="Mesh again with tetrahedra, hexahedra or wedges of first or second order",
        )
    shape = np.shape(connectivity)
    if len(shape) != 2 or shape[1] != NODES[cell_type]:
        raise MeshError(
            part,
            found=f"{cell_type} cells have the shape {shape}",
            expected=f"(number of cells, {NODES[cell_type]})",
            remedy="Give one row of node numbers per cell",
        )
    if len(connectivity) and (connectivity.min() < 0 or connectivity.max() >= n_nodes):
        raise MeshError(
            part,
            found=f"{cell_type} cells name the node {connectivity.max()}",
            expected=f"node numbers 0 to {n_nodes - 1}",
            remedy="Write the mesh again with all its nodes",
        )
