"""From a meshio mesh and the groups of each file format to one `Mesh`."""

from __future__ import annotations

import io
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from flexmb.errors import MeshError
from flexmb.fem.announced import require_counts
from flexmb.fem.meshes.abaqus_cards import read_abaqus_cards
from flexmb.fem.meshes.abaqus_surfaces import surface_facets
from flexmb.fem.meshes.facets import without_copies
from flexmb.fem.meshes.gmsh_groups import entity_groups, physical_names
from flexmb.fem.meshes.mesh import DIMENSION, Mesh, check_cells
from flexmb.fem.meshes.nastran_cards import read_nastran_cards
from flexmb.fem.meshes.nastran_connectors import nastran_connectors
from flexmb.fem.meshes.nastran_mesh import read_nastran_mesh
from flexmb.fem.meshes.repeated_cells import merged_copies
from flexmb.model.numbering import Numbering

__all__ = [
    "GroupedMesh",
    "check_once",
    "from_abaqus",
    "from_gmsh",
    "from_nastran",
    "from_vtu",
    "known_nodes",
    "rows_of",
    "to_mesh",
]


@dataclass(kw_only=True)
class GroupedMesh:
    """What a reader hands on: points, blocks of cells as in the file, groups by name.

    ``cell_sets[name]`` is a list with one array of row numbers per block; ``facet_sets`` holds facets that the
    file defines by element faces. ``left_out`` names what carries mass or stiffness and is not part of a mesh;
    ``notes`` are sentences on what else was not taken over. A file may write a cell ``once_per_group``. ``labels`` (n,)
    are the numbers of the nodes in the file, where it has any; ``unit``, m, is its unit of length, where it names one.
    """

    points: np.ndarray
    blocks: list[tuple[str, np.ndarray]]
    node_sets: dict[str, np.ndarray] = field(default_factory=dict)
    cell_sets: dict[str, list[np.ndarray]] = field(default_factory=dict)
    facet_sets: dict[str, np.ndarray] = field(default_factory=dict)
    left_out: list[str] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    once_per_group: bool = False
    labels: np.ndarray | None = None
    unit: float | None = None


def to_mesh(grouped: GroupedMesh, name: str, part: str) -> Mesh:
    """Return a `Mesh`: one entry per cell type, point groups as node sets, surface groups as facet sets."""
    if not sum(len(cells) for cell_type, cells in grouped.blocks if cell_type != "vertex"):
        raise MeshError(
            part,
            found=f"{len(grouped.points)} points, but no cells",
            expected="a mesh with cells",
            remedy="In Gmsh, add the cells to save to a physical group (or save all)",
        )
    points = np.array(grouped.points, float)
    if points.shape[1] == 2:
        points = np.column_stack([points, np.zeros(len(points))])
    for cell_type, cells in grouped.blocks:
        check_cells(part, cell_type, cells, len(points))
    order = [t for t in dict.fromkeys(t for t, _ in grouped.blocks) if t != "vertex"]
    merged = tuple((t, np.concatenate([np.asarray(c, np.int64) for u, c in grouped.blocks if u == t])) for t in order)
    first, counted = [], dict.fromkeys([*order, "vertex"], 0)  # row of each block's first cell in its merged entry
    for cell_type, cells in grouped.blocks:
        first.append(counted[cell_type])
        counted[cell_type] += len(cells)
    nodes, facets, cell_sets = _sets(grouped, order, first)
    merged, cell_sets = _each_once(merged, cell_sets, grouped)
    return Mesh(
        points=points,
        cells=merged,
        name=name,
        cell_sets=cell_sets,
        node_sets={key: np.unique(np.concatenate(value)).astype(np.int64) for key, value in nodes.items()},
        facet_sets={key: without_copies(stacked(value)) for key, value in facets.items()},
        numbering=None if grouped.labels is None else Numbering(nodes=np.asarray(grouped.labels, np.int64)),
    )


def _sets(grouped: GroupedMesh, order: list[str], first: list[int]):
    """Return nodes and facets of every group, in pieces, and the cells, by the types in `order`; `first` is the row of
    each block's first cell among all of its type.
    """
    nodes = {key: [np.asarray(value, np.int64)] for key, value in grouped.node_sets.items()}
    facets = {key: [value] for key, value in grouped.facet_sets.items()}
    for key, facet_nodes in grouped.facet_sets.items():
        nodes.setdefault(key, []).append(facet_nodes[facet_nodes >= 0])
    cell_sets: dict[str, tuple[np.ndarray, ...]] = {}
    for key, rows in grouped.cell_sets.items():
        members: dict[str, list[np.ndarray]] = {t: [np.zeros(0, np.int64)] for t in order}
        for (cell_type, cells), begin, chosen in zip(grouped.blocks, first, rows):
            if not len(chosen):
                continue
            nodes.setdefault(key, []).append(np.asarray(cells)[chosen].ravel())
            if cell_type != "vertex":
                members[cell_type].append(begin + np.asarray(chosen, np.int64))
            if DIMENSION[cell_type] == 2:
                facets.setdefault(key, []).append(np.asarray(cells)[chosen])
        if any(len(row) > 1 for row in members.values()):
            cell_sets[key] = tuple(np.unique(np.concatenate(members[t])) for t in order)
    return nodes, facets, cell_sets


def _each_once(cells, cell_sets, grouped: GroupedMesh):
    """Return cells and cell sets without copies of cells; what nobody can have meant goes to the notes."""
    kept, sets = [], {key: list(rows) for key, rows in cell_sets.items()}
    for k, (cell_type, connectivity) in enumerate(cells):
        own = {key: rows[k] for key, rows in cell_sets.items()}
        stay, number, copies = merged_copies(cell_type, connectivity, own, grouped.once_per_group)
        if copies:
            grouped.notes.append(
                f"{copies} {cell_type} cells are listed twice, the first has the nodes "
                f"{connectivity[np.setdiff1d(np.arange(len(connectivity)), stay)[0]].tolist()} (counted from 0); each "
                "was taken once, because a copy would double its mass and stiffness"
            )
        kept.append((cell_type, connectivity[stay]))
        for key, rows in own.items():
            sets[key][k] = np.unique(number[rows])
    return tuple(kept), {key: tuple(rows) for key, rows in sets.items()}


def stacked(tables: list[np.ndarray]) -> np.ndarray:
    """Stack facets of several widths, filling short rows with -1."""
    wide = max(table.shape[1] for table in tables)
    return np.concatenate(
        [
            np.pad(np.asarray(table, np.int64), ((0, 0), (0, wide - table.shape[1])), constant_values=-1)
            for table in tables
        ]
    )


def _meshio() -> Any:
    """Import meshio, and tell it the dimension of the 15-node wedge, which 5.3.5 reads but forgot to list."""
    import meshio
    from meshio import _mesh

    _mesh.topological_dimension.setdefault("wedge15", 3)
    return meshio


def from_gmsh(path: Path) -> GroupedMesh:
    """Read a Gmsh file; physical groups become sets, unnamed ones are called ``volume_7``, ``surface_3``, ..."""
    try:
        mesh = _meshio().gmsh.read(str(path))
    except ValueError as error:
        if "gmsh:physical" not in str(error):
            raise
        raise MeshError(
            f"Mesh file '{path}'",
            found="some cells are in physical groups and some are in none",
            expected="all saved cells in groups, or no groups at all",
            remedy="In Gmsh, save without 'Save all elements', or put the rest into a group",
        ) from None
    blocks = [(block.type, np.asarray(block.data)) for block in mesh.cells]
    dimension = [DIMENSION.get(cell_type, -1) for cell_type, _ in blocks]
    names, groups = physical_names(path), entity_groups(path)
    sets: dict[str, list[np.ndarray]] = {}
    tags_by_block = mesh.cell_data.get("gmsh:physical", [])
    for b, first in enumerate(tags_by_block):
        found = {int(tag): np.flatnonzero(first == tag) for tag in np.unique(first)}
        entity = mesh.cell_data["gmsh:geometrical"][b] if groups is not None else np.zeros(0, int)
        if groups is not None and len(entity):  # a block is one entity; meshio knows the first of its groups
            found = dict.fromkeys(groups.get((dimension[b], int(entity[0])), ()), np.arange(len(entity)))
        for tag, rows in found.items():
            word = ("point", "line", "surface", "volume")[dimension[b]]
            name = names.get((dimension[b], tag), f"{word}_{tag}")
            if tag > 0:
                members = sets.setdefault(name, [np.zeros(0, np.int64) for _ in blocks])
                members[b] = np.union1d(members[b], rows)
    return GroupedMesh(points=mesh.points, blocks=blocks, cell_sets=sets, once_per_group=True)


def from_vtu(path: Path) -> GroupedMesh:
    """Read a VTK unstructured grid.

    An integer array of zeros and ones is a set: of nodes in point data, of cells in cell data. Any other integer
    cell array "part" gives one set per value, "part_3".
    """
    meshio = _meshio()
    require_counts(path)
    mesh = (meshio.vtu if path.suffix.lower() == ".vtu" else meshio.vtk).read(str(path))
    blocks = [(block.type, np.asarray(block.data)) for block in mesh.cells]
    nodes = {name: np.flatnonzero(values) for name, values in mesh.point_data.items() if _is_flag([values])}
    sets: dict[str, list[np.ndarray]] = {}
    for name, rows in mesh.cell_data.items():
        rows = [np.asarray(r) for r in rows]
        if _is_flag(rows):
            sets[name] = [np.flatnonzero(r) for r in rows]
        elif all(r.ndim == 1 and np.issubdtype(r.dtype, np.integer) for r in rows):
            for value in np.unique(np.concatenate(rows)):
                sets[f"{name}_{value}"] = [np.flatnonzero(r == value) for r in rows]
    return GroupedMesh(points=mesh.points, blocks=blocks, node_sets=nodes, cell_sets=sets)


def _is_flag(rows: list[Any]) -> bool:
    """Are these one-dimensional integer arrays of zeros and ones?"""
    return all(np.ndim(r) == 1 and np.asarray(r).dtype.kind in "iub" for r in rows) and bool(
        np.isin(np.concatenate([np.asarray(r, np.int64) for r in rows]), (0, 1)).all()
    )


def from_nastran(path: Path) -> GroupedMesh:
    """Read Nastran bulk data: properties become cell sets, SET, SET1 and SET3 become sets of nodes or cells."""
    mesh = read_nastran_mesh(path)
    cards = read_nastran_cards(path, mesh.ids, np.concatenate([np.zeros(0, np.int64), *mesh.elements.values()]))
    place = {int(number): i for i, number in enumerate(mesh.ids)}
    check_once(path, mesh.ids, mesh.points)
    blocks = [(kind, rows_of(path, cells, mesh.ids)) for kind, cells in mesh.cells.items()]
    sets: dict[str, list[np.ndarray]] = {}
    for b, properties in enumerate(mesh.properties.values()):
        for pid in np.unique(properties):
            rows = sets.setdefault(
                cards.property_names.get(int(pid), f"pid_{pid}"), [np.zeros(0, np.int64) for _ in blocks]
            )
            rows[b] = np.union1d(rows[b], np.flatnonzero(properties == pid))
    for name, numbers in cards.element_sets.items():
        sets[name] = [np.flatnonzero(np.isin(ids, numbers)) for ids in mesh.elements.values()]
    nodes = {name: known_nodes(name, numbers, place, path) for name, numbers in cards.node_sets.items()}
    spiders, left_out = nastran_connectors(path)
    left_out += [f"{number} {name}" for name, number in sorted(mesh.unknown.items())]
    nodes |= {name: known_nodes(name, numbers, place, path) for name, numbers in spiders.items() if len(numbers)}
    return GroupedMesh(
        points=mesh.points,
        blocks=blocks,
        node_sets=nodes,
        cell_sets=sets,
        left_out=left_out,
        notes=cards.notes,
        labels=mesh.ids,
    )


def rows_of(path: Path, cells: np.ndarray, ids: np.ndarray) -> np.ndarray:
    """Return cells of file numbers as rows of the table of grid points."""
    order = np.argsort(ids, kind="stable")
    place = np.minimum(np.searchsorted(ids[order], cells), max(len(ids) - 1, 0))
    missing = ids[order][place] != cells if len(ids) else np.ones(cells.shape, bool)
    if missing.any():
        raise MeshError(
            f"Mesh file '{path}'",
            found=f"a cell names the node {cells[missing][0]}, which does not exist",
            expected="cells of existing nodes",
            remedy="Write the file again, complete",
        )
    return order[place]


def check_once(path: Path, numbers: np.ndarray, points: np.ndarray) -> None:
    """Raise MeshError if a grid point is given twice at different places; the same twice is allowed in Nastran."""
    order = np.argsort(numbers, kind="stable")
    same = numbers[order][1:] == numbers[order][:-1]
    apart = np.abs(points[order][1:] - points[order][:-1]).max(axis=1, initial=0.0) > 0.0
    if (same & apart).any():
        twice = numbers[order][1:][same & apart]
        raise MeshError(
            f"Mesh file '{path}'",
            found=f"{len(twice)} grid points at two places, the first is {twice[0]}",
            expected="every grid point once",
            remedy="Renumber one of the parts before they are put into one file",
        )


def known_nodes(name: str, numbers: np.ndarray, place: dict[int, int], path: Path) -> np.ndarray:
    missing = [int(n) for n in numbers if int(n) not in place]
    if missing:
        raise MeshError(
            f"Mesh file '{path}'",
            found=f"the set '{name}' names the node {missing[0]}, which does not exist ({len(missing)} such nodes)",
            expected="sets of existing nodes",
            remedy="If it is a set of elements, say so in its $HMSET comment (type 2) or use SET3"
            if path.suffix.lower() in (".bdf", ".nas", ".fem")
            else "Write the file again, complete",
        )
    return np.array([place[int(n)] for n in numbers], np.int64)


def from_abaqus(path: Path) -> GroupedMesh:
    """Read an Abaqus input file: NSET, ELSET (also in ELEMENT) and element-based SURFACE definitions."""
    cards = read_abaqus_cards(path)
    mesh = _meshio().abaqus.read(io.StringIO(cards.mesh_text))
    blocks = [(block.type, np.asarray(block.data)) for block in mesh.cells]
    place = {number: i for i, number in enumerate(cards.node_ids)}
    sets = {
        name: [np.flatnonzero(np.isin(ids, numbers)) for ids in cards.element_ids]
        for name, numbers in cards.element_sets.items()
        if not name.startswith("_")
    }  # "_" marks internal sets
    nodes = {name: known_nodes(name, numbers, place, path) for name, numbers in cards.node_sets.items()}
    for name, wanted in cards.nodes_of.items():
        rows = [cells[np.isin(ids, np.concatenate(wanted))] for (_, cells), ids in zip(blocks, cards.element_ids)]
        nodes[name] = np.unique(np.concatenate([nodes.get(name, np.zeros(0, np.int64)), *(r.ravel() for r in rows)]))
    facets: dict[str, list[np.ndarray]] = {}
    for name, lines in cards.surfaces.items():
        for numbers, side in lines:
            found = surface_facets(blocks, cards.element_ids, numbers, side)
            facets.setdefault(name, []).extend(found)
            if not found:
                cards.unread.append(f"surface '{name}', side '{side}': its elements have no such face")
    return GroupedMesh(
        points=mesh.points,
        blocks=blocks,
        node_sets=nodes,
        cell_sets=sets,
        facet_sets={name: stacked(tables) for name, tables in facets.items() if tables},
        left_out=[f"{number} {keyword}" for keyword, number in sorted(cards.left_out.items())],
        notes=[f"not read: {text}" for text in cards.unread],
        labels=np.array(cards.node_ids, np.int64),
    )
