"""`solid`: a mesh of solid cells and a material become an FE model."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from scipy.sparse.csgraph import connected_components

from flexmb.errors import MeshError, did_you_mean
from flexmb.fem.block_pattern import BlockPattern, node_pattern
from flexmb.fem.fe_model import FEModel
from flexmb.fem.meshes.facets import oriented_facet_sets, same_side
from flexmb.fem.meshes.mesh import DIMENSION, Mesh
from flexmb.fem.meshes.repeated_cells import first_copies
from flexmb.fem.plausibility import require_material, warn_about_material, warn_about_size
from flexmb.fem.solids import kernels
from flexmb.fem.solids.block import SolidBlock
from flexmb.fem.solids.elements import SOLID_ELEMENTS, SolidElement
from flexmb.fem.told import keeping_warnings, tell
from flexmb.model.described import check_kind

__all__ = ["oriented", "solid"]

FLAT = 1e-9
"""det dx/dX below this fraction of the cell's extent cubed counts as zero: the cell is flat or folded."""


@keeping_warnings
def solid(mesh: Mesh, material=None, *, lumped: bool = False, elements: Mapping[str, Any] | None = None) -> FEModel:
    """Return stiffness, mass and element blocks of the solid cells of a mesh.

    Stiffness int B^T C B, eq. (fe-stiffness), and mass int rho N^T N, eq. (fe-mass), of isoparametric elements.
    Cells numbered left-handed are renumbered; flat, folded and inside-out cells are an error.

    Parameters
    ----------
    mesh : Mesh
        Tetrahedra, hexahedra and wedges of first or second order in any mixture; shell and beam cells are ignored.
    material : Material, OrthotropicMaterial, or a mapping of cell-set name to material
        With a mapping, every solid cell must belong to exactly one of the sets.
    lumped : bool
        Diagonal mass by scaling the diagonal of the consistent one (Hinton, Rock & Zienkiewicz 1976).
    elements : mapping of cell type to SolidElement, optional
        Replaces the element of a cell type: ``{"hexahedron": fem.HEX8_COMPATIBLE}``.

    Returns
    -------
    FEModel
        Three translations per node; K in N/m, M in kg; node and facet sets of the mesh.

    Raises
    ------
    MeshError
        No solid cells, inverted or flat cells, cells that are listed twice, without or with several materials.

    Warns
    -----
    MeshWarning
        Separate pieces, cells that are far too stiff, an implausible size or speed of sound.

    Examples
    --------
    >>> fe = solid(read_mesh("meshes/conrod.msh"), Material(young=210e9, poisson=0.3, density=7850.0))  # doctest: +SKIP
    """
    check_kind(mesh, Mesh, "fem.solid", "Read one with fem.read_mesh('part.msh')", MeshError)
    part = f"Mesh '{mesh.name}'"
    kinds = {**SOLID_ELEMENTS, **(elements or {})}
    _check_solid_cells(part, mesh)
    mesh = mesh.without_unused_nodes()
    blocks = _blocks(part, mesh, material, kinds)
    _warn_about_elements(part, blocks)
    n = len(mesh.points)
    pattern = node_pattern(n, [block.connectivity for block in blocks])
    _check_connection(part, pattern)
    stiffness, mass = np.zeros(9 * len(pattern.indices)), np.zeros(len(pattern.indices))
    for block in blocks:
        block.add_stiffness(pattern, stiffness)
        block.add_mass(pattern, mass, lumped)
    warn_about_size(part, mesh.points, mass=float(mass.sum()))
    m = pattern.three_times(mass)
    if lumped:
        m.eliminate_zeros()
    facets = oriented_facet_sets([(b.cell_type, b.connectivity) for b in blocks], mesh.node_sets, mesh.facet_sets, n)
    return FEModel(
        nodes=mesh.points,
        dofs=np.column_stack([np.repeat(np.arange(n), 3), np.tile([0, 1, 2], n)]),
        K=pattern.blocks(stiffness),
        M=m,
        node_sets=dict(mesh.node_sets),
        facet_sets=facets,
        blocks=tuple(blocks),
        name=mesh.name,
        numbering=mesh.numbering,
    )


def _check_solid_cells(part: str, mesh: Mesh) -> None:
    """Raise MeshError unless the mesh has solid cells."""
    if not any(DIMENSION[cell_type] == 3 and len(cells) for cell_type, cells in mesh.cells):
        found = ", ".join(f"{len(cells)} {cell_type}" for cell_type, cells in mesh.cells) or "no cells at all"
        raise MeshError(
            part,
            found=f"no solid cells, but {found}",
            expected="tetrahedra, hexahedra or wedges",
            remedy="Save the volume group too, or use fem.shell or fem.frame",
        )


def _blocks(part: str, mesh: Mesh, material, kinds: Mapping[str, SolidElement]) -> list[SolidBlock]:
    """Return the solid cells by type and material, checked and numbered right-handed."""
    blocks = []
    for number, (cell_type, connectivity) in enumerate(mesh.cells):
        if DIMENSION[cell_type] < 3 or not len(connectivity):
            continue
        element = kinds[cell_type]
        _check_each_once(part, cell_type, connectivity)
        cells = _right_handed(part, mesh.points, connectivity, element)
        for given, rows in _materials(part, mesh, material, number, len(cells)):
            warn_about_material(part, float(np.max(np.diag(given.elasticity))), float(given.density))
            blocks.append(
                SolidBlock(
                    element=element,
                    nodes=mesh.points,
                    connectivity=cells[rows],
                    elasticity=given.elasticity,
                    density=float(given.density),
                )
            )
    return blocks


def _right_handed(part: str, points: np.ndarray, connectivity: np.ndarray, element: SolidElement) -> np.ndarray:
    """Return the cells `oriented`, and tell it where all were numbered the other way round."""
    cells = oriented(part, points, connectivity, element)
    if (cells != connectivity).any(axis=1).all():
        tell(f"{part}: all {len(cells)} {element.cell_type} cells are numbered left-handed; they were renumbered")
    return cells


def oriented(
    part: str, points: np.ndarray, connectivity: np.ndarray, element: SolidElement, labels: np.ndarray | None = None
) -> np.ndarray:
    """Return the cells with det dx/dX > 0 at all integration points; MeshError if that cannot be had.

    A cell with det < 0 everywhere may only be numbered the other way round (scikit-fem sorts its tetrahedra so) and
    is mirrored. It may also be turned inside out by a node that went through the opposite face: then it lies on
    the same side of a common face as its neighbour, which `same_side` finds.
    """
    tables = element.tables
    at = np.concatenate([tables.stiffness_gradient, tables.mass_gradient])
    cells = np.array(connectivity, np.int64, order="C")
    low, high, size = np.empty(len(cells)), np.empty(len(cells)), np.empty(len(cells))
    kernels.jacobian_range(points, cells, at, low, high, size)
    bad = low <= FLAT * size
    if not bad.any():
        return cells
    mirrored = high < -FLAT * size
    cells[mirrored] = cells[mirrored][:, element.mirror]
    bad &= ~mirrored
    if mirrored.any() and not mirrored.all():
        bad[same_side(element, cells)] = True
        bad &= mirrored | (low <= FLAT * size)
    if bad.any():
        first = int(np.flatnonzero(bad)[0])
        nodes = f"with the nodes {connectivity[first].tolist()}"
        which = f"number {first} (counted from 0), {nodes}" if labels is None else f"element {int(labels[first])}"
        raise MeshError(
            part,
            found=f"{bad.sum()} of {len(cells)} {element.cell_type} cells are inverted or flat "
            f"(det dx/dX <= 0), the first is {which}, near "
            f"{np.round(points[cells[first]].mean(axis=0), 6).tolist()} m",
            expected="a positive Jacobian at every integration point",
            remedy="Mesh again: finer at curved surfaces, or with straight-sided second-order cells",
        )
    return cells


def _materials(part: str, mesh: Mesh, material, number: int, n_cells: int):
    """Yield (material, row numbers) for the cells of one entry of the mesh; each row once."""
    require_material(part, material, "fem.solid(mesh, {})")
    if not isinstance(material, Mapping):
        _check_material(part, material)
        yield material, np.arange(n_cells)
        return
    count = np.zeros(n_cells, int)
    for name, given in material.items():
        _check_solid_set(part, mesh, name)
        _check_material(f"{part}, cell set '{name}'", given)
        rows = mesh.cell_set(name)[number]
        count[rows] += 1
        if len(rows):
            yield given, rows
    for wrong, words in ((count == 0, "no material"), (count > 1, "several materials")):
        if wrong.any():
            raise MeshError(
                part,
                found=f"{wrong.sum()} {mesh.cells[number][0]} cells have {words}, "
                f"the first is number {int(np.flatnonzero(wrong)[0])} (counted from 0)",
                expected=f"each cell in exactly one of the sets: {', '.join(material)}",
                remedy=f"The mesh has the cell sets: {', '.join(sorted(mesh.cell_sets)) or 'none'}",
            )


def _check_solid_set(part: str, mesh: Mesh, name: str) -> None:
    """Raise MeshError unless the mesh has a cell set of this name with solid cells."""
    solid = sorted(
        own
        for own, rows in mesh.cell_sets.items()
        if any(len(r) and DIMENSION[kind] == 3 for r, (kind, _) in zip(rows, mesh.cells))
    )
    if name not in solid:
        what = "holds no solid cells" if name in mesh.cell_sets else "does not exist"
        raise MeshError(
            part,
            found=f"a material is given for the cell set '{name}', which {what}",
            expected=f"sets with solid cells: {', '.join(solid) or 'none'}",
            remedy=did_you_mean(name, solid) or "Name the physical groups of volumes in the mesh",
        )


def _check_each_once(part: str, cell_type: str, connectivity: np.ndarray) -> None:
    """Raise MeshError where a cell is listed twice: two solids cannot be in one place."""
    first = first_copies(cell_type, connectivity)
    copies = np.flatnonzero(first != np.arange(len(first)))
    if len(copies):
        raise MeshError(
            part,
            found=f"{len(copies)} {cell_type} cells are listed twice, the first is number {copies[0]} "
            f"(counted from 0), which has the nodes of number {first[copies[0]]}",
            expected="each cell once: a copy doubles mass and stiffness there",
            remedy="Leave the copies out, or read the file with fem.read_mesh, which merges them",
        )


def _check_material(part: str, material) -> None:
    """Raise MeshError unless `material` is one."""
    if not (hasattr(material, "elasticity") and hasattr(material, "density")):
        raise MeshError(
            part,
            found=f"the material is {material!r}",
            expected="a flexmb.Material, an OrthotropicMaterial, or a mapping of cell set to one",
            remedy='Write flexmb.Material(young=210e9, poisson=0.3, density=7850.0), or flexmb.MATERIALS["steel"]',
        )


def _warn_about_elements(part: str, blocks: list[SolidBlock]) -> None:
    stiff = {"tetra": "tetra10", "wedge": "wedge15"}
    for cell_type in sorted({block.cell_type for block in blocks} & set(stiff)):
        tell(
            f"{part}: {cell_type} cells of first order are far too stiff in bending; "
            f"use {stiff[cell_type]} (second order)"
        )


def _check_connection(part: str, pattern: BlockPattern) -> None:
    """Warn when the solids fall apart: the model then has more than six rigid motions."""
    pieces, label = connected_components(pattern.scalar(np.ones(len(pattern.indices))), directed=False)
    if pieces > 1:
        sizes = np.sort(np.bincount(label))[::-1]
        tell(
            f"{part}: the solid cells form {pieces} separate pieces of {', '.join(map(str, sizes[:5]))} "
            "nodes; merge coincident nodes, or join the pieces by couplings"
        )
