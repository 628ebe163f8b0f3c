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
    """Return the number of a node given by number, by the name of a set of one node, or by coordinates (3,), m."""
    is_point = not isinstance(node, str) and as_array(node).ndim == 1
    numbers = _nearest(fe, node) if is_point else node_numbers(fe, node)
    if len(numbers) != 1:
        raise MeshError(
            f"FE model '{fe.name}'",
            found=f"'{node}' has {len(numbers)} nodes",
            expected="one node",
            remedy="Give a node number, or link the set to one node with fem.with_rigid_link",
        )
    return int(numbers[0])


def node_numbers(fe: FEModel, nodes: NodeName | Iterable[int]) -> np.ndarray:
    """Return node numbers (k,) from names of node sets, node numbers, or coordinates (3,) or (k, 3) of nodes, m.

    Three whole numbers are node numbers; as a tuple they are refused where they could be a place as well.
    """
    if isinstance(nodes, str):
        return np.asarray(fe.node_set(nodes), int)
    if isinstance(nodes, list | tuple) and nodes and all(isinstance(name, str) for name in nodes):
        return np.concatenate([np.asarray(fe.node_set(name), int) for name in nodes])
    array = np.atleast_1d(as_array(nodes))
    if array.dtype.kind == "f" and array.shape[-1:] == (3,) and array.ndim <= 2:
        return np.concatenate([_nearest(fe, point) for point in np.atleast_2d(array)])
    if array.size and (array.dtype.kind not in "iu" or array.ndim != 1):
        raise MeshError(
            f"FE model '{fe.name}'",
            found=f"nodes = {nodes!r:.80}",
            expected="names of node sets, node numbers, or the coordinates x, y, z of nodes",
            remedy='Write "root", [0, 4, 7], or (0.0, 0.0, 0.1)',
        )
    if isinstance(nodes, tuple) and len(nodes) == 3:
        _refuse_two_meanings(fe, array)
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


def _refuse_two_meanings(fe: FEModel, whole: np.ndarray) -> None:
    """Raise MeshError where a tuple of three whole numbers names a node twice, or a node stands at that place."""
    distance = np.linalg.norm(fe.nodes - whole, axis=1).min(initial=np.inf)
    if len(set(whole.tolist())) == 3 and distance > NEAR * _extent(fe):
        return
    raise MeshError(
        f"FE model '{fe.name}'",
        found=f"nodes = {tuple(whole.tolist())}, three node numbers or a place",
        expected="whole numbers of nodes in a list, or coordinates with a decimal point",
        remedy=f"Write {sorted(set(whole.tolist()))} for nodes, or {tuple(whole.astype(float).tolist())} for the place",
    )


def _extent(fe: FEModel) -> float:
    return max(float(np.ptp(fe.nodes, axis=0).max(initial=0.0)), 1e-300) if len(fe.nodes) else 1e-300


def _nearest(fe: FEModel, where) -> np.ndarray:
    point = np.asarray(where, float)
    if point.shape != (3,):
        raise MeshError(
            f"FE model '{fe.name}'",
            found=f"coordinates of shape {point.shape}",
            expected="(3,), m",
            remedy="Give x, y, z of one node",
        )
    distance = np.linalg.norm(fe.nodes - point, axis=1)
    nearest = int(np.argmin(distance))
    if not distance[nearest] <= NEAR * _extent(fe):
        raise MeshError(
            f"FE model '{fe.name}'",
            found=f"no node at {point.tolist()} m; the nearest, {fe.node_name(nearest)}, is "
            f"{distance[nearest]:.3g} m away",
            expected="the coordinates of a node",
            remedy="Make a node there with fem.with_rigid_link or fem.with_averaging_link",
        )
    return np.array([nearest])
