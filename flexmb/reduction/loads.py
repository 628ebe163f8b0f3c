"""Load shapes: distributed loads of unit size, as nodal forces, and what they turn with."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from flexmb.errors import ReductionError, did_you_mean
from flexmb.fem.fe_model import FEModel
from flexmb.fem.surface_load import pressure_change, pressure_field, traction_field
from flexmb.model.described import Described, finite_array
from flexmb.reduction.interfaces import DIRECTIONS
from flexmb.reduction.selection import nodes_of

__all__ = ["MATERIAL", "LineLoad", "Load", "NodalForces", "Pressure", "facets_of", "load_vectors", "loads_of"]

MATERIAL = "material"
"""What a load turns with if each of its forces turns with its own node."""


class Load(metaclass=Described):
    """A load shape. `turns_with` is `MATERIAL`, the name of an interface, or None for the default of `reduce`."""

    turns_with: str | None = None

    def nodal(self, fe: FEModel, part: str) -> np.ndarray:
        """Return the nodal forces and moments of the unit load (n, 6), N and N m, in body axes."""
        field = np.zeros((len(fe.nodes), 6))
        field[fe.dofs[:, 0], fe.dofs[:, 1]] = self.forces(fe, part)
        return field

    def forces(self, fe: FEModel, part: str) -> np.ndarray:
        """Return the forces on the freedoms, (ndof,), N and N m."""
        return fe.forces(self.nodal(fe, part)[:, :, None])[:, 0]


@dataclass(frozen=True)
class Pressure(Load):
    """Unit pressure (1 Pa) on a facet set, against the outward normal, or unit traction along a fixed direction.

    A positive amplitude pushes onto the surface, as in `fem.pressure_load`; a negative one is suction.

    Parameters
    ----------
    where : str
        Name of a facet set (or of a node set that holds whole shell elements).
    direction : (3,) or None
        Direction of a unit traction in body axes, normalised here; None for a pressure on each facet.
    turns_with : str or None
        None: a pressure along the normal follows the deformed surface; a traction is as in `LineLoad`.
    """

    where: str
    direction: Any = None
    turns_with: str | None = None

    def nodal(self, fe: FEModel, part: str) -> np.ndarray:
        """Return the nodal forces of the unit load (n, 6), N, in body axes."""
        total = np.zeros((len(fe.nodes), 6, 1))
        for facets in facets_of(fe, self.where, part):
            if self.direction is None:
                total += pressure_field(fe, facets, 1.0)
            else:
                total += traction_field(fe, facets, _unit(self.direction, part))
        return total[:, :, 0]

    def surface_change(self, fe: FEModel, part: str, field: np.ndarray) -> np.ndarray | None:
        """Return the change of the forces (n, 6, m) with the surface as `field` (n, 6, m) moves it, or None."""
        if self.direction is not None or self.turns_with not in (None, MATERIAL):
            return None
        changes = [pressure_change(fe, facets, 1.0, field) for facets in facets_of(fe, self.where, part)]
        return np.sum(changes, axis=0)


@dataclass(frozen=True)
class LineLoad(Load):
    """Unit force per length (1 N/m) along `direction` (body axes) on the line elements whose nodes lie in a set.

    Consistent for cubic beams: q L / 2 at each end, and moments +-q L^2 / 12 about the transverse axis.

    Parameters
    ----------
    where : set name or node numbers
    direction : (3,)
    turns_with : str or None
        The name of an interface: the load keeps its direction as seen from there (a dead load, if that is held);
        "material": each force turns with its node (a follower load); None: the first interface that can hold the
        body. The frame of the body plays no part.
    """

    where: Any
    direction: Any
    turns_with: str | None = None

    def nodal(self, fe: FEModel, part: str) -> np.ndarray:
        """Return the nodal forces and moments of the unit load (n, 6), N and N m, in body axes."""
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
        return field


@dataclass(frozen=True, eq=False)
class NodalForces(Load):
    """A table of nodal forces: node number -> force (3,) or force and moment (6,), N and N m, in body axes.

    `turns_with` is as in `LineLoad`.
    """

    table: Mapping[int, Any]
    turns_with: str | None = None

    def nodal(self, fe: FEModel, part: str) -> np.ndarray:
        """Return the nodal forces and moments of the unit load (n, 6), N and N m, in body axes."""
        field = np.zeros((len(fe.nodes), 6))
        for node, value in self.table.items():
            value = finite_array(value)
            whole = isinstance(node, int | np.integer) and not isinstance(node, bool)
            if not whole or value.shape not in ((3,), (6,)) or not 0 <= node < len(fe.nodes):
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
                found=f"a load on {fe.node_name(lost[0][0])} in {DIRECTIONS[lost[0][1]]}",
                expected="a freedom that the node has",
                remedy="Solid nodes carry no moments: use pairs of forces or a rigid interface",
            )
        return field


def loads_of(loads: Mapping[str, Any]) -> dict[str, Load]:
    """Return the loads as such: a bare string is a `Pressure`, a bare table a `NodalForces`.

    Anything with ``forces(fe, part) -> (ndof,)`` will do.
    """
    found: dict[str, Load] = {}
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
        found[name] = load if isinstance(load, Load) else _Foreign(load)
    return found


@dataclass(frozen=True, eq=False)
class _Foreign(Load):
    """A load that tells its forces on the freedoms only."""

    load: Any

    def forces(self, fe: FEModel, part: str) -> np.ndarray:
        """Return the forces on the freedoms, (ndof,), N and N m."""
        return self.load.forces(fe, part)


def load_vectors(fe: FEModel, loads: Mapping[str, Any]) -> np.ndarray:
    """Return the forces on the freedoms of each unit load shape, (ndof, nl)."""
    columns = [load.forces(fe, f"Load '{name}'") for name, load in loads_of(loads).items()]
    return np.column_stack(columns) if columns else np.zeros((fe.ndof, 0))


def facets_of(fe: FEModel, name: str, part: str) -> list[np.ndarray]:
    """Return the facets (nf, nodes per facet) of a facet set, or of the shells of a node set, by number of nodes."""
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
    given, direction = direction, finite_array(direction)
    size = np.linalg.norm(direction)
    if direction.shape != (3,) or not size > 0.0:
        raise ReductionError(
            part,
            found=f"direction {given!r:.80}",
            expected="three numbers, not all zero",
            remedy="Give a direction in body axes, e.g. (0, 0, 1)",
        )
    return direction / size
