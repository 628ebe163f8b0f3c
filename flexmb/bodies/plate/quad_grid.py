"""A grid of points from a mesh of quadrilaterals in rows and columns."""

from __future__ import annotations

from typing import Any

import numpy as np

from flexmb.errors import ModelError

__all__ = ["grid_of_mesh"]


def grid_of_mesh(mesh: Any, group: str | None, title: str) -> np.ndarray:
    """Return the nodes (p, q, 3), m, of the quadrilaterals of a mesh, or of one of its named groups, row by row.

    The first row begins at the corner with the lowest node number and runs as its quadrilateral is ordered, so that
    the grid has the normal of the cells.

    Raises
    ------
    ModelError
        Other cells, an unknown group, or quadrilaterals that are not a full grid of rows and columns.
    """
    if group is not None and group not in mesh.cell_sets:
        raise ModelError(
            title,
            found=f"mesh '{mesh.name}' has no group '{group}'",
            expected=f"One of: {', '.join(mesh.cell_sets) or 'none'}",
            remedy="Correct the group's name",
        )
    kinds = []
    quads = np.empty((0, 4), int)
    for k, (kind, cells) in enumerate(mesh.cells):
        chosen = cells if group is None else cells[mesh.cell_sets[group][k]]
        if len(chosen):
            kinds.append(kind)
            quads = chosen if kind == "quad" else quads
    others = [kind for kind in kinds if kind not in ("quad", "line", "vertex")]
    if others or not len(quads):
        raise ModelError(
            title,
            found=f"a mesh of {', '.join(kinds) or 'no cells'}",
            expected="quadrilaterals of four nodes",
            remedy="Mesh a transfinite surface with recombined elements, or name the group of the shell",
        )
    return mesh.points[_rows(quads, title)]


def _rows(quads: np.ndarray, title: str) -> np.ndarray:
    """Return node numbers (p, q) of the grid."""
    of_edge: dict[frozenset, list[int]] = {}
    for e, quad in enumerate(quads.tolist()):
        for k in range(4):
            of_edge.setdefault(frozenset((quad[k], quad[(k + 1) % 4])), []).append(e)
    numbers, uses = np.unique(quads, return_counts=True)
    corners = numbers[uses == 1]
    used: set[int] = set()
    rows: list[list[int]] = []
    if len(corners):
        e = int(np.flatnonzero(np.any(quads == corners[0], axis=1))[0])
        start: int | None = e
        first = _turned(quads[e], int(corners[0]), None)
        while start is not None and start not in used:
            lower, upper, above = _row(quads, of_edge, start, first, used)
            rows += [lower] if not rows else []
            rows.append(upper)
            start = above
            if start is not None:
                first = _turned(quads[start], upper[0], upper[1])
    if len(used) < len(quads) or len({len(row) for row in rows}) != 1 or len(np.unique(rows)) != np.size(rows):
        raise ModelError(
            title,
            found=f"{len(quads)} quadrilaterals, of which {len(used)} lie in rows",
            expected="an open grid of rows and columns: four corners, four cells at every node inside",
            remedy="Mesh a transfinite surface; a tube or a ring is cut along a line, other shapes are parted",
        )
    return np.array(rows).T


def _turned(quad, first: int, second: int | None) -> list[int]:
    """Return the nodes of a cell beginning with `first`, then `second`, in either sense."""
    nodes = [int(n) for n in quad]
    k = nodes.index(first)
    ahead = nodes[k:] + nodes[:k]
    return ahead if second is None or ahead[1] == second else [ahead[0], *ahead[:0:-1]]


def _row(quads, of_edge, e: int, nodes: list[int], used: set[int]):
    """Return lower and upper nodes of a row of cells, and the cell above its first one."""
    lower, upper = nodes[:2], [nodes[3], nodes[2]]
    above = next((n for n in of_edge[frozenset(upper)] if n != e), None)
    used.add(e)
    while True:
        e = next((n for n in of_edge[frozenset((lower[-1], upper[-1]))] if n != e), -1)
        if e < 0 or e in used:
            return lower, upper, above
        used.add(e)
        nodes = _turned(quads[e], lower[-1], None)
        ahead = nodes if nodes[3] == upper[-1] else [nodes[0], *nodes[:0:-1]]
        lower.append(ahead[1])
        upper.append(ahead[2])
