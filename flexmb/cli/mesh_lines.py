"""What a mesh holds, in lines: size, cells, and the named groups of which interfaces are made."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from flexmb.fem import Mesh

__all__ = ["mesh_lines"]


def mesh_lines(mesh: Mesh) -> list[str]:
    """Return the lines; lengths are those of the file, which does not say what they are."""
    low, high = mesh.points.min(axis=0), mesh.points.max(axis=0)
    cells = ", ".join(f"{len(rows)} {kind}" for kind, rows in mesh.cells)
    lines = [
        f"Mesh '{mesh.name}': {len(mesh.points)} nodes, {cells}",
        f"  from {_point(low)} to {_point(high)}, {' x '.join(f'{x:.4g}' for x in high - low)}: in metres, or in the "
        "unit that --scale of flexmb reduce turns into metres (0.001 for mm)",
        "",
    ]
    if not mesh.node_sets:
        return [*lines, "No named groups: nodes by number or coordinates can be interfaces, surfaces cannot."]
    width = max(len(name) for name in mesh.node_sets)
    lines.append(f"{'group':{width}s}  {'nodes':>7s}  {'cells':>7s}  of             middle of its extent")
    for name, nodes in mesh.node_sets.items():
        count, kinds = _cells(mesh, name)
        middle = _point((mesh.points[nodes].min(axis=0) + mesh.points[nodes].max(axis=0)) / 2.0) if len(nodes) else "-"
        lines.append(f"{name:{width}s}  {len(nodes):7d}  {count:7d}  {kinds:13s}  {middle}")
    return lines


def _cells(mesh: Mesh, name: str) -> tuple[int, str]:
    """Return how many cells of which kinds a group has."""
    numbers = mesh.cell_sets.get(name, ())
    kinds = [kind for (kind, _), rows in zip(mesh.cells, numbers, strict=False) if len(rows)]
    return sum(len(rows) for rows in numbers), ", ".join(kinds) or "nodes alone"


def _point(x: np.ndarray) -> str:
    """Return coordinates; what is rounding against the others is zero."""
    size = np.abs(x).max(initial=0.0)
    return f"({', '.join(f'{v if abs(v) > 1e-6 * size else 0.0:.4g}' for v in x)})"
