"""Load shapes: distributed loads of unit size, as nodal forces.

Consistent nodal forces F = int N^T p dA by the facet's own shape functions, so the total force and moment are those of
the pressure on the faceted surface.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from flexmb.errors import ReductionError, did_you_mean
from flexmb.fem.fe_model import FEModel

__all__ = ["LineLoad", "NodalForces", "Pressure", "load_vectors"]


@dataclass(frozen=True)
class Pressure:
    """Unit pressure (1 Pa) on a facet set, along the outward normal or along a fixed direction.

    Parameters
    ----------
    where : str
        Name of a facet set (or of a node set that holds whole shell elements).
    direction : (3,) or None
        Direction of a unit traction in body axes, normalised here; None for the outward normal of each facet.
    """

    where: str
    direction: Any = None


@dataclass(frozen=True)
class LineLoad:
    """Unit force per length (1 N/m) along `direction` (body axes) on the line elements whose nodes lie in a set."""

    where: Any
    direction: Any


@dataclass(frozen=True, eq=False)
class NodalForces:
    """A table of nodal forces: node number -> force (3,) or force and moment (6,), N and N m, in body axes."""

    table: Mapping[int, Any]


def load_vectors(fe: FEModel, loads: Mapping[str, Any]) -> np.ndarray:
    """Return the nodal forces of each unit load shape, (ndof, nl); a bare string is a `Pressure`."""
    columns = []
    for name, load in loads.items():
        part = f"Load '{name}'"
        load = (
            Pressure(load)
            if isinstance(load, str)
            else NodalForces(load)
            if isinstance(load, Mapping)
            else load
        )
        if isinstance(load, Pressure):
            field = _pressure(fe, load, part)
        elif isinstance(load, LineLoad):
            field = _line_load(fe, load, part)
        elif isinstance(load, NodalForces):
            field = _table(fe, load, part)
        else:
            raise ReductionError(
                part,
                found=f"{type(load).__name__}",
                remedy="See flexmb.reduction.loads",
                expected="a facet set's name, Pressure, LineLoad, NodalForces or a table {node: force}",
            )
        columns.append(fe.vectors(field[:, :, None])[:, 0])
    return np.column_stack(columns) if columns else np.zeros((fe.ndof, 0))


def _table(fe: FEModel, load: NodalForces, part: str) -> np.ndarray:
    field = np.zeros((len(fe.nodes), 6))
    present = {tuple(pair) for pair in fe.dofs.tolist()}
    for node, value in load.table.items():
        value = np.asarray(value, float)
        if value.shape not in ((3,), (6,)) or not 0 <= int(node) < len(fe.nodes):
            raise ReductionError(
                part,
                found=f"node {node} with a force of shape {value.shape}",
                expected=f"node 0 to {len(fe.nodes) - 1} with 3 forces or 3 forces and 3 moments",
                remedy="Give a table {node number: (fx, fy, fz)}",
            )
        for direction in np.flatnonzero(value):
            if (int(node), int(direction)) not in present:
                raise ReductionError(
                    part,
                    found=f"a load on node {node} in direction {direction}",
                    expected="a freedom that the node has (0-2 forces, 3-5 moments)",
                    remedy="Solid nodes carry no moments: use pairs of forces or a rigid interface",
                )
        field[int(node), : len(value)] += value
    return field


def _line_load(fe: FEModel, load: LineLoad, part: str) -> np.ndarray:
    """Consistent forces and moments of a uniform load: q L / 2 and +-q L^2 / 12 about the transverse axis."""
    from flexmb.reduction.selection import nodes_of

    inside = np.isin(np.arange(len(fe.nodes)), nodes_of(fe, load.where, part))
    q = _unit(load.direction, part)
    field, found = np.zeros((len(fe.nodes), 6)), 0
    for block in fe.blocks:
        if block.cell_type != "line":
            continue
        lines = block.connectivity[np.all(inside[block.connectivity], axis=1)]
        along = fe.nodes[lines[:, 1]] - fe.nodes[lines[:, 0]]
        length = np.linalg.norm(along, axis=1)[:, None]
        for end, sign in ((0, 1.0), (1, -1.0)):
            np.add.at(field[:, :3], lines[:, end], q * length / 2.0)
            np.add.at(field[:, 3:], lines[:, end], sign * np.cross(along, q) * length / 12.0)
        found += len(lines)
    if not found:
        raise ReductionError(
            part,
            found=f"no line element has all its nodes in {load.where!r}",
            expected="a node set that holds beam elements",
            remedy="Name the set of the loaded beams, or use Pressure for facets",
        )
    return field


def _pressure(fe: FEModel, load: Pressure, part: str) -> np.ndarray:
    facets = _facets(fe, load.where, part)
    direction = None if load.direction is None else _unit(load.direction, part)
    field = np.zeros((len(fe.nodes), 6))
    for points in facets:
        shapes, slopes, weights = _facet_rule(points.shape[1], part)
        x = fe.nodes[points]  # (nf, nodes, 3)
        tangent = np.einsum("qdn,fni->fqdi", slopes, x)
        area = np.cross(tangent[:, :, 0], tangent[:, :, 1])  # outward normal times area density
        if direction is not None:
            area = np.linalg.norm(area, axis=2)[:, :, None] * direction
        np.add.at(field[:, :3], points, np.einsum("q,qn,fqi->fni", weights, shapes, area))
    return field


def _facets(fe: FEModel, name: str, part: str) -> list[np.ndarray]:
    if name in fe.facet_sets:
        facets = np.asarray(fe.facet_sets[name])
        if facets.dtype != object and facets.ndim == 2 and len(facets):
            return [facets.astype(int)]
        by_size: dict[int, list] = {}
        for facet in facets:
            by_size.setdefault(len(facet), []).append(facet)
        if by_size:
            return [np.asarray(group, int) for group in by_size.values()]
    elif name in fe.node_sets:
        inside = np.isin(np.arange(len(fe.nodes)), fe.node_sets[name])
        shells = [b.connectivity for b in fe.blocks if b.cell_type.startswith(("triangle", "quad"))]
        found = [c[np.all(inside[c], axis=1)] for c in shells]
        if any(len(c) for c in found):
            return [c for c in found if len(c)]
    known = sorted(fe.facet_sets)
    what = (
        "is a node set without facets"
        if name in fe.node_sets
        else ("has no facets" if name in fe.facet_sets else "does not exist")
    )
    raise ReductionError(
        part,
        found=f"the facet set '{name}' {what}",
        expected=f"One of: {', '.join(known) or 'none'}",
        remedy=did_you_mean(name, known) or "Mark the loaded surface as a physical group of the mesh",
    )


def _unit(direction, part: str) -> np.ndarray:
    direction = np.asarray(direction, float)
    size = np.linalg.norm(direction)
    if direction.shape != (3,) or not size > 0.0:
        raise ReductionError(
            part,
            found=f"direction {direction!r}",
            expected="three numbers, not all zero",
            remedy="Give a direction in body axes, e.g. (0, 0, 1)",
        )
    return direction / size


def _facet_rule(nodes: int, part: str) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Shape functions (q, n), slopes (q, 2, n) and weights (q,) of a facet (3, 6, 4, 8, 9 nodes, meshio's order)."""
    if nodes in (3, 6):
        a, b = 0.445948490915965, 0.091576213509771  # Dunavant, degree 4
        points = np.array([[a, a], [1 - 2 * a, a], [a, 1 - 2 * a], [b, b], [1 - 2 * b, b], [b, 1 - 2 * b]])
        weights = 0.5 * np.repeat([0.223381589678011, 0.109951743655322], 3)
        powers = [(0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2)][:nodes]
        corners = np.array([[0, 0], [1, 0], [0, 1], [0.5, 0], [0.5, 0.5], [0, 0.5]])[:nodes]
    elif nodes in (4, 8, 9):
        line, w = np.polynomial.legendre.leggauss(3)
        points = np.array([(x, y) for x in line for y in line])
        weights = np.outer(w, w).ravel()
        powers = [(0, 0), (1, 0), (0, 1), (1, 1), (2, 0), (0, 2), (2, 1), (1, 2), (2, 2)][:nodes]
        corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1], [0, -1], [1, 0], [0, 1], [-1, 0], [0, 0]])[
            :nodes
        ]
    else:
        raise ReductionError(
            part,
            found=f"facets with {nodes} nodes",
            expected="3, 6, 4, 8 or 9 nodes",
            remedy="Use NodalForces for other surfaces",
        )
    i, j = np.array(powers).T

    def monomials(at, di=0, dj=0):
        x, y = at[:, :1], at[:, 1:]
        factor = (i if di else 1) * (j if dj else 1)
        return factor * x ** np.maximum(i - di, 0) * y ** np.maximum(j - dj, 0)

    solve = np.linalg.inv(monomials(corners))
    slopes = np.stack([monomials(points, di=1) @ solve, monomials(points, dj=1) @ solve], axis=1)
    return monomials(points) @ solve, slopes, weights
