"""What an engineer looks for in a new deck: parts that hang apart, nodes that were not merged, free edges, mass."""

from __future__ import annotations

from collections import Counter

import numpy as np
from scipy import sparse
from scipy.spatial import cKDTree

from flexmb.fem.deck.inventory import mass_and_center
from flexmb.fem.fe_model import FEModel

__all__ = ["deck_checks"]

COINCIDENT = 1e-7
"""Nodes nearer than this fraction of the diagonal count as coincident."""


def deck_checks(fe: FEModel) -> list[str]:
    """Return sentences on mass properties, parts, coincident nodes and free edges of an FE model."""
    mass, centre = mass_and_center(fe)
    motions = fe.rigid_motions()
    inertia = (motions.T @ (fe.M @ motions))[3:, 3:]
    if mass > 0.0:
        inertia = inertia - mass * (centre @ centre * np.eye(3) - np.outer(centre, centre))
    lines = [f"mass {mass:.8g}, centre of mass ({', '.join(f'{x:.6g}' for x in centre)})"]
    lines.append("inertia about it " + "; ".join(" ".join(f"{x:.6g}" for x in row) for row in inertia))
    lines.append(_parts(fe))
    lines.append(_coincident(fe))
    edges = _free_edges(fe)
    if edges is not None:
        lines.append(f"{edges} free edges of shells")
    return lines


def _parts(fe: FEModel) -> str:
    """Count the parts that no element, link or spring joins; six rigid motions need one."""
    rows = np.column_stack([fe.dofs[:, 0], np.arange(fe.ndof)])
    n = len(fe.nodes)
    ties = sparse.coo_matrix((np.ones(len(rows)), (rows[:, 0], n + rows[:, 1])), shape=(n + fe.ndof,) * 2)
    coupled = fe.K.tocoo()
    graph = ties + sparse.coo_matrix(
        (np.ones(len(coupled.data)), (n + coupled.row, n + coupled.col)), shape=(n + fe.ndof,) * 2
    )
    _, label = sparse.csgraph.connected_components(graph, directed=False)
    used = np.unique(fe.dofs[:, 0])
    sizes = Counter(label[used].tolist())
    if len(sizes) <= 1:
        return "one connected part"
    small = min(sizes, key=lambda key: sizes[key])
    at = int(used[label[used] == small][0])
    return f"{len(sizes)} parts that nothing joins; the smallest has {sizes[small]} nodes, one is {fe.node_name(at)}"


def _coincident(fe: FEModel) -> str:
    own = np.unique(fe.dofs[:, 0])
    points = fe.nodes[own]
    diagonal = float(np.linalg.norm(np.ptp(points, axis=0))) if len(points) else 0.0
    pairs = cKDTree(points).query_pairs(COINCIDENT * diagonal, output_type="ndarray") if diagonal > 0.0 else []
    if not len(pairs):
        return "no nodes at one place"
    a, b = (fe.node_name(int(own[k])) for k in pairs[0])
    return f"{len(pairs)} pairs of nodes at one place, not merged; the first are {a} and {b}"


def _free_edges(fe: FEModel) -> int | None:
    """Return the number of edges of shells that belong to one shell only; None without shells."""
    cells = [block.connectivity for block in fe.blocks if block.cell_type in ("triangle", "quad")]
    if not cells:
        return None
    ends = np.vstack([np.sort(np.stack([c, np.roll(c, -1, axis=1)], axis=2).reshape(-1, 2), axis=1) for c in cells])
    _, count = np.unique(ends, axis=0, return_counts=True)
    return int((count == 1).sum())
