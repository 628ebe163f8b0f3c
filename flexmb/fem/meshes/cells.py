"""The cells of a mesh that frames and shells are made of, with their groups."""

from __future__ import annotations

import numpy as np

from flexmb.errors import MeshError
from flexmb.fem.meshes.mesh import Mesh
from flexmb.fem.meshes.repeated_cells import first_copies
from flexmb.fem.told import tell

__all__ = ["kept_cells"]


def kept_cells(mesh: Mesh, cell_types: tuple[str, ...], part: str):
    """Return the mesh reduced to some cell types, and the cell numbers of every group per type.

    Returns
    -------
    nodes : (n, 3), m
        The nodes of the kept cells only.
    cells : dict of cell type to (ne, c), int
    groups : dict of cell type to dict of group name to cell numbers
    node_sets, facet_sets : dict of name to node numbers
        The sets of the mesh, renumbered; emptied ones are left out.
    numbering : Numbering or None
        Of the kept nodes.
    """
    cells = {name: mesh.cells_of(name) for name in cell_types}
    cells = {name: connectivity for name, connectivity in cells.items() if len(connectivity)}
    if not cells:
        found = ", ".join(f"{len(connectivity)} {name}" for name, connectivity in mesh.cells) or "no cells"
        raise MeshError(
            part,
            found=f"the mesh '{mesh.name}' has {found}",
            expected=f"cells of {', '.join(cell_types)}",
            remedy="Mesh with first-order elements and put the lines or surfaces into a physical group",
        )
    for cell_type, connectivity in cells.items():
        first = first_copies(cell_type, connectivity)
        copies = np.flatnonzero(first != np.arange(len(first)))
        if len(copies):
            tell(
                f"{part}: {len(copies)} {cell_type} cells lie on others, the first is number {copies[0]} on number "
                f"{first[copies[0]]} (counted from 0). Each carries its own mass and stiffness: right for a doubler or "
                "a rod along a bar, wrong for a cell that is listed twice"
            )
    used = np.zeros(len(mesh.points), bool)
    for connectivity in cells.values():
        used[connectivity] = True
    number = np.append(np.where(used, np.cumsum(used) - 1, -1), -1)
    groups: dict[str, dict[str, np.ndarray]] = {name: {} for name in cells}
    for group, members in mesh.cell_sets.items():
        for (cell_type, _), rows in zip(mesh.cells, members, strict=False):
            if cell_type in cells and rows is not None and len(rows):
                groups[cell_type][group] = np.asarray(rows, int)
    node_sets = {name: number[nodes[used[nodes]]] for name, nodes in mesh.node_sets.items() if used[nodes].any()}
    facet_sets = {}
    for name, facets in mesh.facet_sets.items():
        whole = (used[facets] | (facets < 0)).all(axis=1)
        if whole.any():
            facet_sets[name] = number[facets[whole]]
    numbering = None if mesh.numbering is None else mesh.numbering.of(np.flatnonzero(used), ())
    return mesh.points[used], {name: number[c] for name, c in cells.items()}, groups, node_sets, facet_sets, numbering
