"""Interfaces: how a joint takes hold of the mesh, rigidly (RBE2), by average (RBE3) or at bare nodes."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from itertools import combinations
from typing import Any

import numpy as np

from flexmb.errors import ReductionError
from flexmb.fem.fe_model import FEModel
from flexmb.fem.surface_load import node_areas
from flexmb.model.described import Described, finite_array
from flexmb.reduction.selection import nodes_of

__all__ = ["Averaging", "Coupling", "Nodes", "Rigid", "independent_columns", "offered", "resolve", "rigid_block"]

DIRECTIONS = ("x", "y", "z", "rotation x", "rotation y", "rotation z")
MOST_BARE = 1000
"""Bare nodes of an interface: of 4600 freedoms the reduction takes a quarter of an hour, and the third power of it."""
_FLAT = 1e-6  # a node set this thin, relative to its radius, has no rotation about its axis


@dataclass(frozen=True)
class Rigid(metaclass=Described):
    """The nodes move as a rigid body with the interface (RBE2): a pin in a bore, a bolted flange.

    Parameters
    ----------
    where : set name, node numbers or coordinates
    at : (3,), m, or None
        Reference point; None for the centroid of the surface, or the mean of the nodes where there are no facets.
    """

    where: Any
    at: Any = None


@dataclass(frozen=True)
class Averaging(metaclass=Described):
    """The interface moves like the weighted mean of the nodes (RBE3) and adds no stiffness: a soft or wide contact.

    Parameters
    ----------
    where, at : as `Rigid`
    weights : (k,) or None
        Weight of each node in ascending node number; equal if None.
    """

    where: Any
    at: Any = None
    weights: Any = None


@dataclass(frozen=True)
class Nodes(metaclass=Described):
    """Every freedom of the nodes is kept; each node becomes an interface ``name`` (or ``name_<node>`` if several).

    Parameters
    ----------
    where : set name, node numbers or coordinates
    """

    where: Any


@dataclass(frozen=True, eq=False)
class Coupling:
    """An interface resolved on an FE model.

    The interface coordinates are q (nf,), motions of the reference point along `freedoms` (0..2 translation, 3..5
    rotation). Prescribing kinds give the nodes' freedoms ``U[rows] = matrix @ q``, (rows, nf); averaging kinds read
    ``q = matrix @ U[rows]``, (nf, rows), and have the weighted mean of their nodes, `center`.
    """

    name: str
    position: np.ndarray
    nodes: np.ndarray
    rows: np.ndarray
    matrix: np.ndarray
    freedoms: np.ndarray
    averaging: bool = False
    label: str = field(default="rigid")
    center: np.ndarray | None = None


def rigid_block(fe: FEModel, rows: np.ndarray, point: np.ndarray) -> np.ndarray:
    """Return the rigid motions about `point` in the freedoms `rows`: (rows, 6), translations then rotations."""
    node, direction = fe.dofs[rows, 0], fe.dofs[rows, 1]
    block = np.zeros((len(rows), 6))
    block[np.arange(len(rows)), direction] = 1.0
    arm = fe.nodes[node] - point
    for k in range(3):
        turned = np.cross(np.eye(3)[k], arm)
        translation = direction < 3
        block[translation, 3 + k] = turned[translation, direction[translation]]
    return block


def independent_columns(block: np.ndarray, length: float) -> np.ndarray:
    """Return the columns of a rigid block that are independent, earlier ones first (rotations scaled by `length`)."""
    scaled = block / np.array([1.0, 1.0, 1.0, length, length, length])
    scale = np.linalg.norm(scaled, axis=0).max()
    chosen, basis = [], np.zeros((len(block), 0))
    for j in range(block.shape[1]):
        rest = scaled[:, j] - basis @ (basis.T @ scaled[:, j])
        rest -= basis @ (basis.T @ rest)
        size = np.linalg.norm(rest)
        if size > _FLAT * scale:
            chosen.append(j)
            basis = np.column_stack([basis, rest / size])
    return np.array(chosen, int)


def offered(fe: FEModel, interfaces: Mapping[str, Any] | Iterable[str] | str) -> Mapping[str, Any]:
    """Return interfaces by name from "all" or a list of names: the reference points that a deck offers.

    "all" takes every reference node with six independent freedoms, and every one that follows the mean of others.
    """
    if isinstance(interfaces, Mapping):
        return interfaces
    own = np.bincount(fe.dofs[:, 0], minlength=len(fe.nodes))
    if isinstance(interfaces, str) and interfaces == "all":
        names = [n for n, at in fe.reference_points.items() if at.averaged is not None or own[at.node] == 6]
        taken: dict[int, str] = {}
        for name in names:  # one node may be the reference of two links
            taken.setdefault(fe.reference_points[name].node, name)
        names = [name for name in names if name in taken.values()]
        if not names:
            raise ReductionError(
                f"FE model '{fe.name}'",
                found="interfaces='all', but the model offers no reference points",
                expected="RBE2, RBE3, couplings or ASET nodes of a deck (fem.read_deck)",
                remedy='Name the interfaces: interfaces={"a": "bore_a"}'
                + (f", or by the supports of the file: {', '.join(sorted(fe.supports)[:6])}" if fe.supports else ""),
            )
        return {name: name for name in names}
    names = [interfaces] if isinstance(interfaces, str) else list(interfaces)
    if not all(isinstance(name, str) and name in fe.reference_points for name in names):
        return interfaces  # type: ignore[return-value] # refused with the names of what a mapping would be
    return {name: name for name in names}


def resolve(fe: FEModel, interfaces: Mapping[str, Any]) -> list[Coupling]:
    """Return the couplings of all interfaces in the order given; check that no two share a node."""
    everything = np.arange(fe.ndof)
    center = fe.nodes.mean(axis=0)
    radius = np.linalg.norm(fe.nodes - center, axis=1).max() or 1.0
    whole = independent_columns(rigid_block(fe, everything, center), radius)
    couplings = [c for name, where in interfaces.items() for c in _couple(fe, name, where, whole)]
    for a, b in combinations(couplings, 2):
        common = np.intersect1d(a.nodes, b.nodes)
        if len(common):
            every = len(np.unique(fe.dofs[:, 0]))
            whole_part = next((c.name for c in (a, b) if len(c.nodes) == every), None)
            raise ReductionError(
                f"Interfaces '{a.name}' and '{b.name}'",
                found=f"{len(common)} common nodes, first {fe.node_name(common[0])}"
                + (f"; '{whole_part}' has all {every} nodes of the part" if whole_part is not None else ""),
                expected="interfaces without common nodes",
                remedy="Shrink one of the groups in the mesh, or join both into one interface",
            )
    return couplings


def _couple(fe: FEModel, name: str, where, whole: np.ndarray) -> list[Coupling]:
    part = f"Interface '{name}'"
    kind = where if isinstance(where, (Rigid, Averaging, Nodes)) else Rigid(where)
    of_deck = isinstance(kind.where, str) and kind.where in fe.reference_points and kind.where not in fe.node_sets
    if of_deck:
        kind = _at_reference(fe, kind)
    nodes = nodes_of(fe, kind.where, part)
    rows = np.flatnonzero(np.isin(fe.dofs[:, 0], nodes))
    if isinstance(kind, Nodes):
        if len(nodes) > MOST_BARE:
            raise ReductionError(
                part,
                found=f"{kind.where!r:.80} selects {len(nodes)} of {len(np.unique(fe.dofs[:, 0]))} nodes, and each "
                "becomes an interface by itself",
                expected=f"at most {MOST_BARE} bare nodes: a body has a shape for each of their freedoms",
                remedy="Name fewer nodes, or make one interface of them: reduction.Rigid(...) or "
                "reduction.Averaging(...), in the shell GROUP or averaging:GROUP",
            )
        return [_bare(fe, name if len(nodes) == 1 else f"{name}_{node}", node) for node in nodes]
    point = _center(fe, kind.where, nodes) if kind.at is None else finite_array(kind.at)
    if point.shape != (3,):
        raise ReductionError(
            part,
            found=f"at = {kind.at!r:.80}",
            expected="a reference point: three numbers, m",
            remedy="Leave it out for the centroid of the surface or the mean of the nodes",
        )
    if isinstance(kind, Averaging):
        return [_averaging(fe, name, kind, nodes, rows, point, whole, of_deck)]
    if len(rows) == fe.ndof:
        raise ReductionError(
            part,
            found=f"{kind.where!r:.80} selects all {len(nodes)} nodes of FE model '{fe.name}', which an interface "
            "makes rigid",
            expected="nodes of the place where a joint takes hold; others that can deform",
            remedy="Name a surface of the part rather than its volume, take reduction.Averaging(...) (in the shell "
            "averaging:GROUP) for the mean of all nodes, or describe the part as a RigidBody",
        )
    block = rigid_block(fe, rows, point)
    freedoms = _full_motion(fe, part, block, nodes, point, whole, "reduction.Nodes(...) for a hinge-free bare node")
    return [Coupling(name, point, nodes, rows, block[:, freedoms], freedoms)]


def _at_reference(fe: FEModel, kind: Rigid | Averaging | Nodes) -> Rigid | Averaging | Nodes:
    """Return the coupling of a reference point of a deck: its node, or the mean of the nodes it follows."""
    at = fe.reference_points[kind.where]
    if at.averaged is None:
        return replace(kind, where=np.array([at.node]))
    weights = np.asarray(at.weights, float)
    kept = weights != 0.0  # corners of quadrilaterals of second order have negative shares of the area
    return Averaging(np.asarray(at.averaged)[kept], at=fe.nodes[at.node], weights=weights[kept])


def _center(fe: FEModel, where, nodes: np.ndarray) -> np.ndarray:
    """Centroid int x dA / A of a named surface: the mean of its nodes depends on where the mesh is fine."""
    if not isinstance(where, str) or where not in fe.facet_sets:
        return fe.nodes[nodes].mean(axis=0)
    area = node_areas(fe, where)
    return area @ fe.nodes / area.sum()


def _bare(fe: FEModel, name: str, node: int) -> Coupling:
    rows = np.flatnonzero(fe.dofs[:, 0] == node)
    return Coupling(
        name,
        fe.nodes[node].copy(),
        np.array([node]),
        rows,
        np.eye(len(rows)),
        fe.dofs[rows, 1],
        label="bare nodes",
    )


def _averaging(fe, name, kind, nodes, rows, point, whole, signed) -> Coupling:
    """q = (R^T W R)^-1 R^T W U: least-squares rigid motion of the nodes, by translations where they suffice."""
    part = f"Interface '{name}'"
    weights = np.ones(len(nodes)) if kind.weights is None else finite_array(kind.weights)
    if weights.shape != nodes.shape or not (signed or np.all(weights > 0.0)):
        raise ReductionError(
            part,
            found=f"weights of shape {weights.shape}, smallest {weights.min(initial=np.inf):.3g}",
            expected=f"{len(nodes)} positive weights",
            remedy="Give one weight per node of the set",
        )
    translations = rows[fe.dofs[rows, 1] < 3]
    radius = np.linalg.norm(fe.nodes[nodes] - point, axis=1).max() or 1.0
    if len(independent_columns(rigid_block(fe, translations, point), radius)) == len(whole):
        rows = translations
    block = rigid_block(fe, rows, point)
    freedoms = _full_motion(fe, part, block, nodes, point, whole, "reduction.Rigid(...) on a wider set")
    weight = weights[np.searchsorted(nodes, fe.dofs[rows, 0])]
    scale = np.where(freedoms < 3, 1.0, radius)
    scaled = block[:, freedoms] / scale
    average = np.linalg.solve(scaled.T @ (weight[:, None] * scaled), (weight[:, None] * scaled).T) / scale[:, None]
    center = weights @ fe.nodes[nodes] / weights.sum()
    return Coupling(name, point, nodes, rows, average, freedoms, averaging=True, label="averaging", center=center)


def _full_motion(fe, part, block, nodes, point, whole, instead) -> np.ndarray:
    """Return the freedoms of the interface; they must be as many as the whole model has rigid motions."""
    radius = np.linalg.norm(fe.nodes[nodes] - point, axis=1).max() or 1.0
    freedoms = independent_columns(block, radius)
    if len(freedoms) < len(whole):
        missing = [DIRECTIONS[j] for j in whole if j not in freedoms]
        shape = "a single node" if len(nodes) == 1 else f"{len(nodes)} collinear nodes"
        raise ReductionError(
            part,
            found=f"{shape} without rotational freedoms: no {', '.join(missing)}",
            expected="nodes that span a surface, or a node with rotations",
            remedy=f"Add nodes that are off the line, or use {instead}",
        )
    return freedoms
