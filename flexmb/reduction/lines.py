"""Nodes that lie one behind the other: the line along which a load travels."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.sparse.csgraph import minimum_spanning_tree
from scipy.spatial import cKDTree
from scipy.spatial.distance import cdist

from flexmb.errors import ReductionError
from flexmb.fem.fe_model import FEModel
from flexmb.reduction.selection import is_point, nodes_of, points_of

__all__ = ["in_line"]

MOST_NODES = 3000
"""Each has a load shape of its own, and all distances between them are looked at."""
BACKWARDS = -1e-3
"""Cosine between two steps below which a line turns back; a square corner does not."""
NEAR = 4
"""Nodes of one element lie at most this many places apart: two edges of an element of second order."""
GAP = 2.5
"""Step over both of its neighbours from which on a set holds two lines; without a node it is 2."""
CLOSED = 1.5
"""The ends of a line that are this near to each other, relative to its longest step, make it a ring."""


def in_line(fe: FEModel, where: Any, part: str) -> tuple[np.ndarray, np.ndarray]:
    """Return the nodes of a line in order (n,), and how far along it they lie (n,), m.

    Node numbers and coordinates are taken in the order given. Nodes of a set are put in order, straight or curved: each
    beside the nearest ones, from the end with the lower number.

    Parameters
    ----------
    fe : FEModel
    where : name of a set, node numbers, or coordinates (k, 3), m
    part : str
        The thing that asks, for messages.

    Raises
    ------
    ReductionError
        Fewer than two nodes, nodes that are named twice or lie at one place, a line that branches or turns back.
    """
    nodes = nodes_of(fe, where, part)
    if not 2 <= len(nodes) <= MOST_NODES:
        raise _no_line(
            part,
            f"{len(nodes)} node{'s' * (len(nodes) > 1)}",
            "Name a longer line" if len(nodes) < 2 else "Name every second or third node of the line",
            f"2 to {MOST_NODES} nodes in a line",
        )
    given = _as_given(fe, where, nodes, part)
    ordered = _ordered(fe, nodes, part) if given is None else given
    steps = np.linalg.norm(np.diff(fe.nodes[ordered], axis=0), axis=1)
    _check_steps(fe, ordered, steps, part, given is not None)
    _check_elements(fe, ordered, part)
    if given is None:
        _check_open(fe, ordered, steps, part)
    return ordered, np.concatenate([[0.0], np.cumsum(steps)])


def _no_line(part: str, found: str, remedy: str, expected: str = "nodes in a line, one behind the other"):
    return ReductionError(part, found=found, expected=expected, remedy=remedy)


def _as_given(fe: FEModel, where: Any, nodes: np.ndarray, part: str) -> np.ndarray | None:
    """Return nodes in the order of numbers or coordinates; None for names."""
    if is_point(where):
        given = nodes[cKDTree(fe.nodes[nodes]).query(points_of(where))[1]]
    else:
        given = np.zeros(0) if isinstance(where, str) else np.atleast_1d(np.asarray(where))
        if given.dtype.kind not in "iuf" or not len(given):
            return None
        given = given.astype(int)
    if len(given) > len(nodes):
        twice = next(int(node) for k, node in enumerate(given) if node in given[:k])
        raise _no_line(part, f"{fe.node_name(twice)} twice", "Name each node once; a ring is left at its last node")
    return given


def _ordered(fe: FEModel, nodes: np.ndarray, part: str) -> np.ndarray:
    """Return the nodes of a set one beside the nearest other: the path that their shortest tree must be."""
    points = fe.nodes[nodes]
    distance = cdist(points, points)
    np.fill_diagonal(distance, np.inf)
    k, other = np.unravel_index(int(distance.argmin()), distance.shape)
    if not distance[k, other] > 0.0:
        raise _no_line(
            part,
            f"{fe.node_name(nodes[k])} and {fe.node_name(nodes[other])} at one place",
            "Merge duplicate nodes of the mesh, or name one of the two",
        )
    np.fill_diagonal(distance, 0.0)
    tree = minimum_spanning_tree(distance).tocoo()
    beside: list[list[int]] = [[] for _ in nodes]
    for a, b in zip(tree.row.tolist(), tree.col.tolist()):
        beside[a].append(b)
        beside[b].append(a)
    branch = next((k for k, near in enumerate(beside) if len(near) > 2), None)
    if branch is not None:
        raise _no_line(
            part,
            f"nodes that spread about {fe.node_name(nodes[branch])}",
            "Name the nodes of one line, or give node numbers in order; contact=... holds what presses anywhere on a "
            "surface",
        )
    path = [min(k for k, near in enumerate(beside) if len(near) == 1)]
    while len(path) < len(nodes):
        path.append(next(k for k in beside[path[-1]] if k not in path[-2:]))
    return nodes[path]


def _check_steps(fe: FEModel, ordered: np.ndarray, steps: np.ndarray, part: str, given: bool) -> None:
    """Refuse lines that stand still or turn back."""
    still = np.flatnonzero(~(steps > 0.0))
    if len(still):
        a, b = ordered[still[0]], ordered[still[0] + 1]
        raise _no_line(
            part, f"{fe.node_name(a)} and {fe.node_name(b)} at one place", "Merge duplicate nodes of the mesh"
        )
    along = np.diff(fe.nodes[ordered], axis=0) / steps[:, None]
    back = np.flatnonzero(np.einsum("ij,ij->i", along[1:], along[:-1]) < BACKWARDS)
    if len(back):
        raise _no_line(
            part,
            f"a line that turns back at {fe.node_name(ordered[back[0] + 1])}",
            "Give the numbers in the order in which the load passes the nodes, or name a set: that is put in order"
            if given
            else "Name the nodes of one line, or give node numbers in order",
        )


def _check_elements(fe: FEModel, ordered: np.ndarray, part: str) -> None:
    """Refuse lines that go forth and back beside each other, as over the nodes of a strip: elements hold both ways.

    Elements between the ends close a ring.
    """
    place = np.full(len(fe.nodes), -1)
    place[ordered] = np.arange(len(ordered))
    for block in fe.blocks:
        at = place[block.connectivity]
        first = np.where(at < 0, len(ordered), at).min(axis=1)
        apart = at.max(axis=1) - first
        apart[apart >= len(ordered) - 1 - NEAR] = 0
        worst = int(np.argmax(apart)) if len(apart) else 0
        if len(apart) and apart[worst] > NEAR:
            a, b = ordered[first[worst]], ordered[at[worst].max()]
            raise _no_line(
                part,
                f"{fe.node_name(a)} and {fe.node_name(b)} in one element, {apart[worst]} places apart along the line",
                "Name the nodes of one line, not of a strip or a surface",
            )


def _check_open(fe: FEModel, ordered: np.ndarray, steps: np.ndarray, part: str) -> None:
    """Refuse rings and two lines where nobody said where they begin."""
    inner = steps[1:-1] > GAP * np.maximum(steps[2:], steps[:-2])
    if inner.any():
        k = int(np.argmax(inner)) + 1
        raise _no_line(
            part,
            f"a gap of {steps[k]:.3g} m between {fe.node_name(ordered[k])} and {fe.node_name(ordered[k + 1])}",
            "Name the nodes of one line, or give node numbers in order",
        )
    gap = np.linalg.norm(fe.nodes[ordered[0]] - fe.nodes[ordered[-1]])
    if len(ordered) > 3 and gap < CLOSED * steps.max():
        raise _no_line(
            part,
            f"a ring: its ends, {fe.node_name(ordered[0])} and {fe.node_name(ordered[-1])}, are neighbours",
            "Give node numbers in order, from where the load comes on",
        )
