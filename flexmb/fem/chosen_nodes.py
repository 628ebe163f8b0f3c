"""Which nodes of an FE model are meant: named sets, numbers, or coordinates, in supports, masses, springs and links."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from flexmb.errors import MeshError
from flexmb.fem.fe_model import FEModel

__all__ = ["NodeName", "as_array", "node_number", "node_numbers"]

NodeName = int | str | Sequence[float]
NEAR = 1e-6
"""Distance from a node up to which coordinates name it, relative to the largest extent of the model."""


def node_number(fe: FEModel, node: NodeName) -> int:
    """Return the number of one node, named as for `node_numbers`: 4, [4], "end", or (0.0, 0.0, 0.1), m.

    Three whole numbers are no place: coordinates have a decimal point.
    """
    numbers = np.unique(node_numbers(fe, node))
    if len(numbers) != 1:
        raise MeshError(
            f"FE model '{fe.name}'",
            found=f"{node!r:.80} has {len(numbers)} nodes",
            expected="one node",
            remedy="Give a node number, coordinates with a decimal point, or link the set to one node with "
            "fem.with_rigid_link",
        )
    return int(numbers[0])


def node_numbers(fe: FEModel, nodes: NodeName | Iterable[int]) -> np.ndarray:
    """Return node numbers (k,) from names of node sets, node numbers, or coordinates (3,) or (k, 3) of nodes, m.

    Three whole numbers are node numbers. They are refused where one is repeated, and as a tuple where a node stands
    at that place: they may be coordinates.
    """
    if isinstance(nodes, str):
        return _of_set(fe, nodes)
    if isinstance(nodes, list | tuple) and nodes and all(isinstance(name, str) for name in nodes):
        return np.concatenate([_of_set(fe, name) for name in nodes])
    array = np.atleast_1d(as_array(nodes))
    if (array.dtype.kind == "f" or not array.size) and array.shape[-1:] == (3,) and array.ndim <= 2:
        return np.array([_at(fe, point) for point in np.atleast_2d(array)], int)
    if array.ndim != 1 or (array.size and array.dtype.kind not in "iu"):
        raise MeshError(
            f"FE model '{fe.name}'",
            found=f"nodes = {nodes!r:.80}",
            expected="names of node sets, node numbers, or the coordinates x, y, z of nodes",
            remedy=_remedy(array),
        )
    if array.shape == (3,):
        _refuse_two_meanings(fe, array, is_tuple=isinstance(nodes, tuple))
    if array.size and (array.min() < 0 or array.max() >= len(fe.nodes)):
        raise MeshError(
            f"FE model '{fe.name}'",
            found=f"node {array.max() if array.max() >= len(fe.nodes) else array.min()} does not exist",
            expected=f"node numbers 0 to {len(fe.nodes) - 1}",
            remedy="Node numbers start at 0; named sets are safer",
        )
    return array.astype(int)


def as_array(nodes) -> np.ndarray:
    """Return nodes as an array; rows of different lengths as one (1, 1) of objects, which no caller takes."""
    try:
        return np.asarray(nodes)
    except ValueError:
        return np.empty((1, 1), object)


def _of_set(fe: FEModel, name: str) -> np.ndarray:
    if name in fe.supports and name not in fe.node_sets:
        raise MeshError(
            f"FE model '{fe.name}'",
            found=f"'{name}' are supports of the deck, which have directions of their own",
            expected="names of node sets beside others, or beside directions",
            remedy=f"Give that name alone, without directions: '{name}'",
        )
    return np.asarray(fe.node_set(name), int)


def _remedy(array: np.ndarray) -> str:
    if array.size and array.dtype.kind in "iu" and array.shape[-1] == 3:
        return f"Write coordinates with a decimal point, {tuple(array.reshape(-1, 3)[0].astype(float).tolist())}"
    if array.dtype.kind == "f" and array.ndim == 1 and np.all(array == np.round(array)):
        return "Node numbers are whole numbers: write [0, 4], or numbers.astype(int)"
    return 'Write "root", [0, 4, 7], or (0.0, 0.0, 0.1)'


def _refuse_two_meanings(fe: FEModel, whole: np.ndarray, is_tuple: bool) -> None:
    """Raise MeshError where three whole numbers name a node twice, or, as a tuple, a node stands at that place."""
    numbers = sorted(set(whole.tolist()))
    if len(numbers) == 3 and not (is_tuple and len(_near(fe, whole))):
        return
    raise MeshError(
        f"FE model '{fe.name}'",
        found=f"nodes = {tuple(whole.tolist())}, three node numbers or a place",
        expected="whole numbers of nodes in a list, each once, or coordinates with a decimal point",
        remedy=f"Write {numbers} for nodes, or {tuple(whole.astype(float).tolist())} for the place",
    )


def _near(fe: FEModel, point: np.ndarray) -> np.ndarray:
    """Return the nodes at a point (3,), m, nearest first."""
    extent = max(float(np.ptp(fe.nodes, axis=0).max(initial=0.0)), 1e-300) if len(fe.nodes) else 1e-300
    distance = np.linalg.norm(fe.nodes - point, axis=1)
    near = np.flatnonzero(distance <= NEAR * extent)
    return near[np.argsort(distance[near], kind="stable")]


def _at(fe: FEModel, point: np.ndarray) -> int:
    """Return the node at a point (3,), m: the only one, or the only one of several with freedoms of its own."""
    near = _near(fe, point)
    if len(near) > 1 and np.isin(near, fe.dofs[:, 0]).any():
        near = near[np.isin(near, fe.dofs[:, 0])]
    if len(near) == 1:
        return int(near[0])
    if len(near):
        numbers = sorted(near.tolist())
        raise MeshError(
            f"FE model '{fe.name}'",
            found=f"{len(near)} nodes at {point.tolist()} m: {', '.join(map(fe.node_name, numbers[:6]))}",
            expected="the coordinates of one node",
            remedy=f"Write their numbers, {numbers[:6]}, or those of them that are meant",
        )
    distance = np.linalg.norm(fe.nodes - point, axis=1)
    nearest = int(np.argmin(distance))
    hint = "; for node numbers, give whole numbers: numbers.astype(int)" if np.all(point == np.round(point)) else ""
    raise MeshError(
        f"FE model '{fe.name}'",
        found=f"no node at {point.tolist()} m; the nearest, {fe.node_name(nearest)}, is {distance[nearest]:.3g} m away",
        expected="the coordinates of a node",
        remedy=f"Make a node there with fem.with_rigid_link or fem.with_averaging_link{hint}",
    )
