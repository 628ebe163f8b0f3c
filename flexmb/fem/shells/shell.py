"""`shell`: thin-walled parts of flat triangles and quadrilaterals, six freedoms per node."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from flexmb.errors import MeshError, did_you_mean
from flexmb.fem.fe_model import FEModel
from flexmb.fem.meshes.cells import kept_cells
from flexmb.fem.meshes.mesh import Mesh
from flexmb.fem.nodal_assembly import all_freedoms, summed
from flexmb.fem.plausibility import require_material, warn_about_material, warn_about_size
from flexmb.fem.shells.block import ShellBlock
from flexmb.fem.told import keeping_warnings
from flexmb.model.described import check_kind, is_number
from flexmb.model.material import Material

__all__ = ["WARPING", "check_side", "flattened", "shell"]

WARPING = 0.2
"""Largest distance of a quadrilateral's corners from its mean plane, as a share of the square root of its
area."""


@keeping_warnings
def shell(
    mesh: Mesh,
    material: Any = None,
    thickness: Any = None,
    *,
    lumped: bool = False,
    stress_side: float | None = None,
    name: str | None = None,
) -> FEModel:
    """Return an FE model of the triangles and quadrilaterals of a mesh, six freedoms per node.

    Thin shells without transverse shear deformation: discrete Kirchhoff bending with membranes that have a
    rotation about the normal at the corners (docs/theory/shells.md). Corners of a warped quadrilateral are
    joined to its mean plane rigidly.

    Parameters
    ----------
    mesh : Mesh
        First-order triangles and quadrilaterals; other cells are left out.
    thickness : float, m, or mapping of group name to float, or (ne,) for the cells of a mesh of one kind
    lumped : bool
        Diagonal mass in local axes instead of the consistent one.
    stress_side : float or None
        Where the stress is recovered: -1 bottom, 0 middle, +1 top; top is where the right-hand rule of the
        cell points. None: the middle, which has no stress of bending; reductions warn of it.

    Raises
    ------
    MeshError
        No such cells, a cell without thickness, degenerate or strongly warped cells.
    """
    name = mesh.name if name is None else name
    part = f"Shell '{name}'"
    require_material(part, material, "fem.shell(mesh, {}, thickness=0.002)")
    check_kind(
        material,
        Material,
        f"{part}, material",
        "Write flexmb.Material(young=210e9, poisson=0.3, density=7850.0)",
        MeshError,
    )
    check_side(stress_side, part)
    nodes, cells, groups, node_sets, facet_sets, numbering = kept_cells(mesh, ("triangle", "quad"), part)
    warn_about_material(part, material.young, material.density)
    blocks = []
    for cell_type, connectivity in cells.items():
        each = _thickness(part, thickness, len(connectivity), groups[cell_type])
        blocks.append(_block(part, cell_type, nodes, connectivity, each, material, stress_side))
    dofs = all_freedoms(len(nodes))
    stiffness, mass = (
        sum(summed(matrices(block), block.connectivity, dofs, len(nodes)) for block in blocks)
        for matrices in (ShellBlock.stiffness, lambda block: block.mass(lumped))
    )
    warn_about_size(part, nodes, mass=float(mass.tocsr()[::6, ::6].sum()))
    return FEModel(
        nodes=nodes,
        dofs=dofs,
        K=stiffness.tocsr(),
        M=mass.tocsr(),
        node_sets=node_sets,
        facet_sets=facet_sets,
        blocks=tuple(blocks),
        name=name,
        numbering=numbering,
    )


def _block(part: str, cell_type: str, nodes, connectivity, thickness, material, side) -> ShellBlock:
    """Return the elements of all cells of one type, with the thickness of each."""
    axes, corners, heights = flattened(part, cell_type, nodes, connectivity)
    return ShellBlock(
        connectivity=connectivity,
        axes=axes,
        corners=corners,
        heights=heights,
        centers=nodes[connectivity].mean(axis=1),
        thickness=thickness,
        material=material,
        number_of_nodes=len(nodes),
        side=side,
    )


def _thickness(part: str, thickness, count: int, groups: Mapping[str, np.ndarray]) -> np.ndarray:
    if isinstance(thickness, np.ndarray) and thickness.shape == (count,) and np.all(thickness > 0.0):
        return thickness.astype(float)
    for value in thickness.values() if isinstance(thickness, Mapping) else [thickness]:
        if not is_number(value):
            raise MeshError(
                part,
                found=f"the thickness {value!r}",
                expected="a number, m, or a mapping of group name to number",
                remedy='Write thickness=0.002 or thickness={"skin": 0.002, "rib": 0.003}',
            )
    if not isinstance(thickness, Mapping):
        values = np.full(count, float(thickness))
    else:
        values = np.zeros(count)
        for group, value in thickness.items():
            if group in groups:
                values[groups[group]] = value
    if not (values > 0.0).all():
        known = ", ".join(sorted(groups)) or "none"
        cell = int(np.argmin(values))
        remedy = f"The mesh has the groups: {known}"
        if isinstance(thickness, Mapping):
            wrong = [group for group in thickness if group not in groups]
            remedy += ". " + " ".join(did_you_mean(group, groups) for group in wrong) if wrong else ""
        raise MeshError(
            part,
            found=f"cell {cell} has the thickness {values[cell]:g} m",
            expected="a positive number",
            remedy=remedy,
        )
    return values


def flattened(part: str, cell_type: str, nodes: np.ndarray, connectivity: np.ndarray, labels=None):
    """Return axes (ne, 3, 3), corners (ne, c, 2) in the mean plane and heights (ne, c) of the corners above
    it."""
    points = nodes[connectivity]
    if cell_type == "triangle":
        first, second = points[:, 1] - points[:, 0], points[:, 2] - points[:, 0]
        along = first
    else:  # the mean plane is parallel to both diagonals
        first, second = points[:, 2] - points[:, 0], points[:, 3] - points[:, 1]
        along = points[:, 1] + points[:, 2] - points[:, 0] - points[:, 3]
    normal = np.cross(first, second)
    double_area = np.linalg.norm(normal, axis=1)
    longest = np.maximum(np.linalg.norm(first, axis=1), np.linalg.norm(second, axis=1))
    if (double_area <= 1e-8 * longest**2).any():
        cell = int(np.argmin(double_area / longest**2))
        raise MeshError(
            part,
            found=f"{_named(cell_type, cell, connectivity, labels)} has no area",
            expected="corners that span a plane",
            remedy="Remove the cell or merge its nodes",
        )
    z = normal / double_area[:, None]
    x = along - (along * z).sum(axis=1)[:, None] * z
    x /= np.linalg.norm(x, axis=1)[:, None]
    axes = np.stack([x, np.cross(z, x), z], axis=1)
    local = np.einsum("eai,eci->eca", axes, points - points.mean(axis=1)[:, None])
    heights = local[:, :, 2]
    warped = np.abs(heights).max(axis=1) > WARPING * np.sqrt(0.5 * double_area)
    turned = _corner_areas(local[:, :, :2]).min(axis=1) <= 0.0
    for bad, what, remedy in (
        (warped, "is warped out of its plane", "Split it into two triangles"),
        (turned, "is not convex", "Mesh again"),
    ):
        if bad.any():
            cell = int(np.argmax(bad))
            raise MeshError(
                part,
                found=f"{_named(cell_type, cell, connectivity, labels)} {what}",
                expected="convex, nearly flat cells",
                remedy=remedy,
            )
    return axes, local[:, :, :2], heights


def _named(cell_type: str, cell: int, connectivity: np.ndarray, labels) -> str:
    """Return words for a cell: its number in the file (`labels`), or its place and its nodes."""
    if labels is not None:
        return f"element {int(labels[cell])}"
    return f"{cell_type} {cell} with the nodes {connectivity[cell].tolist()}"


def _corner_areas(corners: np.ndarray) -> np.ndarray:
    """Return twice the signed area (ne, c) of the triangle at every corner; positive for a convex cell."""
    after, before = np.roll(corners, -1, axis=1) - corners, np.roll(corners, 1, axis=1) - corners
    return after[..., 0] * before[..., 1] - after[..., 1] * before[..., 0]


def check_side(stress_side: float | None, part: str) -> None:
    """Raise MeshError if a side of shells is not between -1 and +1; None is nobody's choice."""
    if stress_side is not None and not (is_number(stress_side) and abs(stress_side) <= 1.0):
        raise MeshError(
            part,
            found=f"stress_side = {stress_side!r}",
            expected="-1 (bottom), 0 (middle) or +1 (top)",
            remedy="Write stress_side=1 for the outer fibres on top",
        )
