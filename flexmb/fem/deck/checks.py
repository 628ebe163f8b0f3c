"""What an engineer looks for in a new deck: parts that hang apart, nodes that were not merged, free edges, mass."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy import sparse

from flexmb.fem.deck.inventory import mass_and_center, numbers
from flexmb.fem.fe_model import FEModel

__all__ = ["DeckChecks", "deck_checks"]

COINCIDENT = 1e-7
"""Nodes nearer than this fraction of the diagonal count as coincident."""
NAMED = 6
"""Parts and pairs that are named one by one."""


@dataclass(frozen=True, kw_only=True, eq=False)
class DeckChecks:
    """What was found in an FE model.

    Parameters
    ----------
    mass, center, inertia : float, (3,) and (3, 3)
        Inertia about the centre of mass; kg, m and kg m2 where the units are SI.
    parts : tuple of (k,) int
        Nodes of every part that no element, link or spring joins to another, the largest first.
    unmerged : (np, 2) int
        Pairs of nodes at one place that nothing joins directly.
    joined : int
        Pairs of nodes at one place that a spring or an element joins: hinges.
    free_edges : (ne, 2) int
        Edges of shells that belong to one shell only.
    unused : (k,) int
        Nodes of the deck that nothing uses.
    """

    mass: float
    center: np.ndarray
    inertia: np.ndarray
    parts: tuple[np.ndarray, ...]
    unmerged: np.ndarray
    joined: int
    free_edges: np.ndarray
    unused: np.ndarray
    fe: FEModel

    def sentences(self) -> list[str]:
        """Return what was found, a sentence each."""
        lines = [f"mass {self.mass:.8g}, centre of mass ({', '.join(numbers(self.center))})"]
        about = numbers(self.inertia)
        lines.append("inertia about it " + "; ".join(" ".join(about[k : k + 3]) for k in (0, 3, 6)))
        lines += [self._parts(), self._coincident()]
        if any(block.cell_type in ("triangle", "quad") for block in self.fe.blocks):
            lines.append(f"{len(self.free_edges)} free edges of shells")
        if len(self.unused):
            first = self.fe.node_name(int(self.unused[0]))
            lines.append(f"{len(self.unused)} nodes that nothing uses, the first is {first}")
        return lines

    def numbers(self) -> dict[str, Any]:
        """Return what was found as JSON can hold it; nodes by their numbers in the deck."""
        label = (lambda k: int(k)) if self.fe.labels is None else (lambda k: int(self.fe.labels[k]))  # type: ignore[index]
        return {
            "mass": self.mass,
            "center_of_mass": self.center.tolist(),
            "inertia": self.inertia.tolist(),
            "parts": [{"nodes": len(part), "first_node": label(part[0])} for part in self.parts],
            "unmerged": [[label(a), label(b)] for a, b in self.unmerged],
            "pairs_joined_by_springs": self.joined,
            "free_edges": len(self.free_edges),
            "unused_nodes": [label(k) for k in self.unused],
        }

    def _parts(self) -> str:
        if len(self.parts) <= 1:
            return "one connected part"
        few = [f"{len(p)} at {self.fe.node_name(int(p[0]))}" for p in self.parts[:NAMED]]
        more = f" and {len(self.parts) - NAMED} more" if len(self.parts) > NAMED else ""
        return f"{len(self.parts)} parts that nothing joins, with nodes: {', '.join(few)}{more}"

    def _coincident(self) -> str:
        hinges = f"; {self.joined} pairs at one place are joined by springs or elements" if self.joined else ""
        if not len(self.unmerged):
            return f"no unmerged nodes{hinges}"
        few = [f"{self.fe.node_name(int(a))} and {self.fe.node_name(int(b))}" for a, b in self.unmerged[:NAMED]]
        more = f" and {len(self.unmerged) - NAMED} more" if len(self.unmerged) > NAMED else ""
        return f"{len(self.unmerged)} pairs of nodes at one place that nothing joins: {'; '.join(few)}{more}{hinges}"


def deck_checks(fe: FEModel) -> DeckChecks:
    """Return mass properties, parts, coincident nodes, free edges and unused nodes of an FE model."""
    mass, center = mass_and_center(fe)
    motions = fe.rigid_motions()
    inertia = (motions.T @ (fe.M @ motions))[3:, 3:]
    if mass > 0.0:
        inertia = inertia - mass * (center @ center * np.eye(3) - np.outer(center, center))
    unmerged, joined = _coincident(fe)
    return DeckChecks(
        mass=mass,
        center=center,
        inertia=inertia,
        parts=_parts(fe),
        unmerged=unmerged,
        joined=joined,
        free_edges=_free_edges(fe),
        unused=_unused(fe),
        fe=fe,
    )


def _parts(fe: FEModel) -> tuple[np.ndarray, ...]:
    """Return the parts that no element, link or spring joins, by their nodes with freedoms of their own."""
    n = len(fe.nodes)
    rows = np.arange(fe.ndof)
    ties = sparse.coo_matrix((np.ones(fe.ndof), (fe.dofs[:, 0], n + rows)), shape=(n + fe.ndof,) * 2)
    coupled = fe.K.tocoo()
    graph = ties + sparse.coo_matrix(
        (np.ones(len(coupled.data)), (n + coupled.row, n + coupled.col)), shape=(n + fe.ndof,) * 2
    )
    _, label = sparse.csgraph.connected_components(graph, directed=False)
    used = np.unique(fe.dofs[:, 0])
    order = np.argsort(label[used], kind="stable")
    cuts = np.flatnonzero(np.diff(label[used][order])) + 1
    return tuple(sorted(np.split(used[order], cuts), key=len, reverse=True))


def _coincident(fe: FEModel) -> tuple[np.ndarray, int]:
    """Return the pairs of nodes at one place that share no stiffness, and how many pairs do."""
    from scipy.spatial import cKDTree

    own = np.unique(fe.dofs[:, 0])
    points = fe.nodes[own]
    diagonal = float(np.linalg.norm(np.ptp(points, axis=0))) if len(points) else 0.0
    if not diagonal > 0.0:
        return np.zeros((0, 2), int), 0
    pairs = own[cKDTree(points).query_pairs(COINCIDENT * diagonal, output_type="ndarray")].reshape(-1, 2)
    if not len(pairs):
        return pairs, 0
    of = sparse.csr_matrix((np.ones(fe.ndof), (np.arange(fe.ndof), fe.dofs[:, 0])), shape=(fe.ndof, len(fe.nodes)))
    touched = np.unique(pairs)
    shared = (of[:, touched].T @ abs(fe.K) @ of[:, touched]).tocsr()
    at = np.searchsorted(touched, pairs)
    directly = np.asarray(shared[at[:, 0], at[:, 1]]).ravel() > 0.0
    return pairs[~directly], int(directly.sum())


def _free_edges(fe: FEModel) -> np.ndarray:
    """Return the edges (ne, 2) of shells that belong to one shell only."""
    cells = [block.connectivity for block in fe.blocks if block.cell_type in ("triangle", "quad")]
    if not cells:
        return np.zeros((0, 2), int)
    ends = np.vstack([np.sort(np.stack([c, np.roll(c, -1, axis=1)], axis=2).reshape(-1, 2), axis=1) for c in cells])
    edges, count = np.unique(ends, axis=0, return_counts=True)
    return edges[count == 1]


def _unused(fe: FEModel) -> np.ndarray:
    """Return the nodes of the deck without freedoms, that no link moves and no cell has."""
    used = np.zeros(len(fe.nodes), bool)
    used[fe.dofs[:, 0]] = True
    for block in fe.blocks:
        used[np.unique(block.connectivity)] = True
    if fe.expansion is not None:
        used |= (np.diff(fe.expansion.indptr).reshape(-1, 6) > 0).any(axis=1)
    for at in fe.reference_points.values():
        used[at.node] = True
    return np.flatnonzero(~used)
