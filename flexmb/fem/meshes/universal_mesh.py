"""Meshes of universal files: datasets 15, 781, 2411 (nodes), 2412 (elements), 2435, 2452, 2467, 2477 (groups)."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from flexmb.errors import MeshError
from flexmb.fem.meshes.groups import GroupedMesh, check_once, known_nodes, rows_of
from flexmb.fem.meshes.universal_datasets import BEAMS, OLD_GROUPS, POSITIONS, UniversalFile, universal_file

__all__ = ["from_universal"]

SURFACES = (*range(41, 46), *range(51, 56), *range(61, 66), *range(71, 76), *range(91, 96))
"""Descriptors of plane stress, plane strain, plates, membranes and thin shells, but for the cubic ones."""
SOLIDS = (101, 102, 104, 105, 111, 112, 113, 115, 116, 118)
"""Descriptors of thick shells and solids, but for the cubic ones."""
KINDS = {
    **{(d, n): kind for d in BEAMS for n, kind in ((2, "line"), (3, "line3"))},
    **{(d, n): kind for d in SURFACES for n, kind in ((3, "triangle"), (4, "quad"), (6, "triangle6"), (8, "quad8"))},
    **{
        (d, n): kind
        for d in SOLIDS
        for n, kind in (
            (4, "tetra"),
            (6, "wedge"),
            (8, "hexahedron"),
            (10, "tetra10"),
            (15, "wedge15"),
            (20, "hexahedron20"),
        )
    },
}
"""Kind of cell by descriptor and number of nodes."""
ORDERS = {
    "line3": (0, 2, 1),
    "triangle6": (0, 2, 4, 1, 3, 5),
    "quad8": (0, 2, 4, 6, 1, 3, 5, 7),
    "tetra10": (0, 2, 4, 9, 1, 3, 5, 6, 7, 8),
    "wedge15": (0, 2, 4, 9, 11, 13, 1, 3, 5, 10, 12, 14, 6, 7, 8),
    "hexahedron20": (0, 2, 4, 6, 12, 14, 16, 18, 1, 3, 5, 7, 13, 15, 17, 19, 8, 9, 10, 11),
}
"""Places in the file of the nodes of a cell: the file goes round the lower face, corners and midside nodes in turn,
along the middles of the vertical edges, and round the upper face."""
NAMES = {
    **dict.fromkeys((136, 137, 138, 139), "springs"),
    121: "rigid bars",
    122: "rigid elements",
    141: "dampers",
    142: "dampers",
    161: "lumped masses",
}
"""What carries mass or stiffness and is no cell."""


def from_universal(path: Path) -> GroupedMesh:
    """Read nodes, elements and groups; elements with one property number are the set ``pid_<number>``."""
    part, found = f"Mesh file '{path}'", universal_file(path)
    if not found.labels:
        raise MeshError(
            part,
            found=f"no nodes; the datasets {', '.join(map(str, sorted(found.skipped))) or 'none'}",
            expected=f"nodes (dataset {', '.join(map(str, POSITIONS))}) and elements (2412)",
            remedy="Export the mesh, not only results",
        )
    labels, points = np.array(found.labels, np.int64), np.array(found.points)
    check_once(path, labels, points)
    labels, first = np.unique(labels, return_index=True)
    blocks, numbers, families, left_out = [], [], [], []
    for (descriptor, count), rows in found.elements.items():
        table = np.array(rows, np.int64)
        kind = KINDS.get((descriptor, count))
        if kind is None:
            name = NAMES.get(descriptor, f"elements of {count} nodes with the descriptor {descriptor}")
            left_out.append((f"{len(rows)} {name}", table[:, 0]))
            continue
        cells = table[:, 2:][:, ORDERS.get(kind, range(count))]
        blocks.append((kind, rows_of(path, cells, labels)))
        numbers.append(table[:, 0])
        families.append(table[:, 1])
    every = np.concatenate([np.zeros(0, np.int64), *numbers, *(members for _, members in left_out)])
    _numbered_once(part, every)
    sets = {
        f"pid_{family}": [np.flatnonzero(rows == family) for rows in families]
        for family in np.unique(np.concatenate([np.zeros(0, np.int64), *families]))
    }
    nodes, notes = _members(path, found, labels, numbers, every, sets)
    return GroupedMesh(
        points=points[first],
        blocks=blocks,
        node_sets=nodes,
        cell_sets=sets,
        left_out=[text for text, _ in left_out],
        notes=notes,
        labels=labels,
        unit=found.unit,
    )


def _members(path: Path, found: UniversalFile, labels, numbers, every, sets) -> tuple[dict[str, np.ndarray], list[str]]:
    """Return the groups of nodes and what was not taken; the groups of elements are added to `sets`."""
    place = {int(label): row for row, label in enumerate(labels)}
    nodes: dict[str, np.ndarray] = {}
    notes = []
    for group in found.groups:
        if len(group.nodes):
            rows = known_nodes(group.name, group.nodes, place, path)
            nodes[group.name] = np.union1d(nodes.get(group.name, rows), rows)
        if len(group.elements):
            missing = np.setdiff1d(group.elements, every)
            if len(missing):  # Gmsh names points that it does not write
                notes.append(
                    f"the group '{group.name}' names {len(missing)} elements that are not in the file, the first is "
                    f"{missing[0]}"
                )
            known = sets.get(group.name, [np.zeros(0, np.int64) for _ in numbers])
            sets[group.name] = [
                np.union1d(rows, np.flatnonzero(np.isin(own, group.elements))) for rows, own in zip(known, numbers)
            ]
        if group.others:
            notes.append(f"{group.others} members of the group '{group.name}' are neither nodes nor elements")
    old = sorted(found.skipped & set(OLD_GROUPS))
    if old:
        notes.append(f"groups of the datasets {', '.join(map(str, old))} were not read; 2467 is")
    return nodes, notes


def _numbered_once(part: str, every: np.ndarray) -> None:
    numbers, count = np.unique(every, return_counts=True)
    if (count > 1).any():
        raise MeshError(
            part,
            found=f"{(count > 1).sum()} element numbers twice, the first is {numbers[count > 1][0]}",
            expected="every element once",
            remedy="Renumber one of the parts before they are put into one file",
        )
