"""Chains of nodes in a mesh of lines: from branch to branch, from corner to corner, or around."""

from __future__ import annotations

import numpy as np

from flexmb.errors import ModelError

__all__ = ["line_chains", "single_chain"]


def line_chains(points: np.ndarray, lines: np.ndarray, corner: float, title: str) -> list[list[int]]:
    """Return the chains of node numbers; one that begins and ends with the same node is a ring.

    Parameters
    ----------
    points : (n, 3), m
    lines : (ne, 2) int
    corner : float, rad
        Chains end where the direction turns by more.
    title : str
        Whose mesh it is, for messages.
    """
    points, lines = np.asarray(points, float), np.asarray(lines, int).reshape(-1, 2)
    _refuse(points, lines, title)
    around: dict[int, list[int]] = {}
    for k, (a, b) in enumerate(lines):
        around.setdefault(int(a), []).append(k)
        around.setdefault(int(b), []).append(k)

    def ends_at(node: int) -> bool:
        at = around[node]
        if len(at) != 2:
            return True
        first, second = (_direction(points, lines[k], node) for k in at)
        return float(np.dot(-first, second)) < np.cos(corner)

    left = set(range(len(lines)))
    chains = []
    ends = [node for node in sorted(around) if ends_at(node)]
    for start in [*ends, *(node for node in sorted(around) if node not in ends)]:
        for k in around[start]:
            chain = [start]
            while k in left:
                left.discard(k)
                chain.append(int(lines[k][1] if lines[k][0] == chain[-1] else lines[k][0]))
                if chain[-1] == start or ends_at(chain[-1]):
                    break
                k = next((other for other in around[chain[-1]] if other in left), k)
            if len(chain) > 1:
                chains.append(chain)
    return chains


def single_chain(points: np.ndarray, lines: np.ndarray, title: str) -> tuple[np.ndarray, bool]:
    """Return the points (n, 3) of a mesh that is one line, in order, and whether it is a ring;
    ModelError for branches.
    """
    chains = line_chains(points, lines, np.pi, title)
    if len(chains) != 1:
        ends = [node for chain in chains for node in (chain[0], chain[-1])]
        branch = next((node for node in ends if ends.count(node) > 2), None)
        where = (
            f", which branch at node {branch} ({np.round(points[branch], 6).tolist()} m)" if branch is not None else ""
        )
        raise ModelError(
            title,
            found=f"{len(chains)} lines{where}",
            expected="one line without branches",
            remedy="Name one group of lines, or make several bodies with flexmb.line_network",
        )
    chain = chains[0]
    ring = chain[0] == chain[-1]
    return points[chain[:-1] if ring else chain], ring


def _refuse(points, lines, title) -> None:
    if not len(lines):
        raise ModelError(
            title,
            found="a mesh without line cells",
            expected="lines between nodes",
            remedy="Mesh the curves (one-dimensional elements), or give points",
        )
    length = np.linalg.norm(points[lines[:, 1]] - points[lines[:, 0]], axis=1)
    if not length.min() > 1e-9 * length.max():
        k = int(np.argmin(length))
        raise ModelError(
            title,
            found=f"line {k} between the nodes {lines[k].tolist()} has the length {length[k]:.3g} m",
            expected="lines with a length",
            remedy="Merge or remove the nodes that coincide",
        )
    _, first, counts = np.unique(np.sort(lines, axis=1), axis=0, return_index=True, return_counts=True)
    if counts.max() > 1:
        k = int(first[np.argmax(counts)])
        raise ModelError(
            title,
            found=f"the nodes {lines[k].tolist()} are joined by {counts.max()} lines",
            expected="one line between two nodes",
            remedy="Remove the double ones",
        )


def _direction(points, line, node: int) -> np.ndarray:
    d = points[line[1] if line[0] == node else line[0]] - points[node]
    return d / np.linalg.norm(d)
