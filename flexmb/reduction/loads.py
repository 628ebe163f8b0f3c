"""Load shapes: distributed loads of unit size, as nodal forces."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from flexmb.errors import ReductionError, did_you_mean
from flexmb.fem.fe_model import FEModel
from flexmb.fem.surface_load import pressure_load, traction_load
from flexmb.reduction.interfaces import DIRECTIONS
from flexmb.reduction.selection import nodes_of

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

    def forces(self, fe: FEModel, part: str) -> np.ndarray:
        """Return the forces on the freedoms, (ndof,), N and N m."""
        total = np.zeros(fe.ndof)
        for facets in _facets(fe, self.where, part):
            if self.direction is None:
                total -= pressure_load(fe, facets)  # a pressure acts against the outward normal
            else:
                total += traction_load(fe, facets, _unit(self.direction, part))
        return total


@dataclass(frozen=True)
class LineLoad:
    """Unit force per length (1 N/m) along `direction` (body axes) on the line elements whose nodes lie in a set.

    Consistent for cubic beams: q L / 2 at each end, and moments +-q L^2 / 12 about the transverse axis.
    """

    where: Any
    direction: Any

    def forces(self, fe: FEModel, part: str) -> np.ndarray:
        """Return the forces on the freedoms, (ndof,), N and N m."""
        inside = np.isin(np.arange(len(fe.nodes)), nodes_of(fe, self.where, part))
        q = _unit(self.direction, part)
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
                found=f"no line element has all its nodes in {self.where!r}",
                expected="a node set that holds beam elements",
                remedy="Name the set of the loaded beams, or use Pressure for facets",
            )
        return fe.forces(field[:, :, None])[:, 0]


@dataclass(frozen=True, eq=False)
class NodalForces:
    """A table of nodal forces: node number -> force (3,) or force and moment (6,), N and N m, in body axes."""

    table: Mapping[int, Any]

    def forces(self, fe: FEModel, part: str) -> np.ndarray:
        """Return the forces on the freedoms, (ndof,), N and N m."""
        field = np.zeros((len(fe.nodes), 6))
        for node, value in self.table.items():
            value = np.asarray(value, float)
            if value.shape not in ((3,), (6,)) or not 0 <= int(node) < len(fe.nodes):
                raise ReductionError(
                    part,
                    found=f"node {node} with a force of shape {value.shape}",
                    expected=f"node 0 to {len(fe.nodes) - 1} with 3 forces or 3 forces and 3 moments",
                    remedy="Give a table {node number: (fx, fy, fz)}",
                )
            field[int(node), : len(value)] += value
        carried = np.zeros(field.shape, bool)
        carried[fe.dofs[:, 0], fe.dofs[:, 1]] = True
        if fe.expansion is not None:
            carried |= (fe.expansion.getnnz(axis=1) > 0).reshape(carried.shape)
        lost = np.argwhere((field != 0.0) & ~carried)
        if len(lost):
            raise ReductionError(
                part,
                found=f"a load on node {lost[0][0]} in {DIRECTIONS[lost[0][1]]}",
                expected="a freedom that the node has",
                remedy="Solid nodes carry no moments: use pairs of forces or a rigid interface",
            )
        return fe.forces(field[:, :, None])[:, 0]


def load_vectors(fe: FEModel, loads: Mapping[str, Any]) -> np.ndarray:
    """Return the nodal forces of each unit load shape, (ndof, nl).

    A bare string is a `Pressure`, a bare table a `NodalForces`; anything with ``forces(fe, part) -> (ndof,)`` will do.
    """
    columns = []
    for name, load in loads.items():
        part = f"Load '{name}'"
        if isinstance(load, str):
            load = Pressure(load)
        elif isinstance(load, Mapping):
            load = NodalForces(load)
        if not hasattr(load, "forces"):
            raise ReductionError(
                part,
                found=f"{type(load).__name__}",
                expected="a facet set's name, Pressure, LineLoad, NodalForces or a table {node: force}",
                remedy="See flexmb.reduction.loads",
            )
        columns.append(load.forces(fe, part))
    return np.column_stack(columns) if columns else np.zeros((fe.ndof, 0))


def _facets(fe: FEModel, name: str, part: str) -> list[np.ndarray]:
    if name in fe.facet_sets:
        facets = np.asarray(fe.facet_sets[name], int)
        sizes = np.sum(facets >= 0, axis=1) if facets.ndim == 2 else np.zeros(0)  # rows of mixed sets end in -1
        if len(sizes):
            return [facets[sizes == size, :size] for size in np.unique(sizes)]
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
