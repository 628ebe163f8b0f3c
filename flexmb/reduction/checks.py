"""What must hold of an FE model before it can be reduced: mass, freedom, connection, no mechanism."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy import sparse

from flexmb.errors import ReductionError
from flexmb.fem.fe_model import FEModel
from flexmb.reduction.interfaces import DIRECTIONS, Coupling

__all__ = ["beside_largest", "check_connected", "check_grounding", "check_mass", "mechanism"]

_GROUNDED = 1e-5  # relative force of a rigid motion above which the stiffness matrix is grounded


def mechanism(fe: FEModel, freedom: int, found: str, *, held: bool = True) -> ReductionError:
    """Return the error for a singular stiffness, naming node, place and direction of the freedom.

    `held` says whether it moves while the interfaces are held.
    """
    node, direction = fe.dofs[freedom]
    at = ", ".join(f"{x:.4g}" for x in fe.nodes[node])
    return ReductionError(
        f"FE model '{fe.name}'",
        found=f"a mechanism: {fe.node_name(node)} at ({at}) m moves freely in "
        f"{DIRECTIONS[direction]}{' while the interfaces are held' if held else ''}; {found}",
        expected="a stiffness matrix that is singular for rigid motions only",
        remedy=f"Look there for elements that are not joined, a hinge, or a freedom without stiffness{_held_by(fe)}",
    )


def beside_largest(energy: np.ndarray) -> str:
    """Return words for the least of energies in ascending order beside the largest; none if all are zero."""
    return f" (relative {energy[0] / energy[-1]:.0e})" if energy[-1] != 0.0 else ""


def _held_by(fe: FEModel) -> str:
    """Return words for the supports of the file, which may be all that holds the part together."""
    return f". The file holds it by '{next(iter(fe.supports))}': name that as an interface" if fe.supports else ""


def check_connected(fe: FEModel, couplings: Sequence[Coupling]) -> None:
    """Raise if the elements and interfaces form more than one connected part."""
    K = fe.K
    if not np.all(K.data):  # zeros are places of the matrix, and join nothing
        K = K.copy()
        K.eliminate_zeros()
    blocks, of_freedom = sparse.csgraph.connected_components(K, directed=False)
    edges = [np.column_stack([blocks + fe.dofs[:, 0], of_freedom])]
    edges += [blocks + np.column_stack([np.full(len(c.nodes), c.nodes[0]), c.nodes]) for c in couplings]
    pairs = np.vstack(edges)
    used = np.unique(fe.dofs[:, 0])
    n = blocks + len(fe.nodes)
    graph = sparse.csr_matrix((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(n, n))
    count, label = sparse.csgraph.connected_components(graph, directed=False)
    label = label[blocks:]
    sizes = np.bincount(label[used], minlength=count)
    parts = np.flatnonzero(sizes)
    if len(parts) > 1:
        small = parts[np.argmin(sizes[parts])]
        node = int(used[label[used] == small][0])
        at = ", ".join(f"{x:.4g}" for x in fe.nodes[node])
        raise ReductionError(
            f"FE model '{fe.name}'",
            found=f"{len(parts)} parts that are not connected; the smallest has "
            f"{sizes[small]} nodes, e.g. {fe.node_name(node)} at ({at}) m",
            expected="one connected part",
            remedy="Merge duplicate nodes at the seam, join the parts with a rigid link, or reduce them apart",
        )


ABOUT_A_LINE = (
    "Bars and beams of a deck with lumped masses have no inertia about their own line: take the consistent mass, "
    "fem.read_deck(..., lumped=False), --consistent-mass, of a part in a model file lumped = false; or add masses with "
    "inertia at their nodes, Mass(at=[...], mass=0.0, inertia=(Ixx, Iyy, Izz)), or in the deck"
)
"""What to do where a body has mass, but all of it on one line."""


def check_mass(fe: FEModel, rigid_mass: np.ndarray, motions: np.ndarray) -> None:
    bad = np.flatnonzero(~(np.diag(rigid_mass) > 0.0))
    if len(bad) or np.linalg.eigvalsh(_unit_diagonal(rigid_mass)).min(initial=1.0) < 1e-12:
        where = DIRECTIONS[motions[bad[0]]] if len(bad) else "some combination of directions"
        raise ReductionError(
            f"FE model '{fe.name}'",
            found=f"no mass resists rigid motion in {where}",
            expected="a mass matrix that is positive for every rigid motion",
            remedy=ABOUT_A_LINE
            if len(bad) and motions[bad[0]] >= 3 and np.all(np.diag(rigid_mass)[motions < 3] > 0.0)
            else "Give the material a density or add lumped masses; check that M is not empty",
        )


def _unit_diagonal(matrix: np.ndarray) -> np.ndarray:
    size = np.sqrt(np.diag(matrix))
    return matrix / np.outer(size, size)


def check_grounding(fe: FEModel, rigid: np.ndarray, motions: np.ndarray) -> float:
    """Return the largest relative force of a rigid motion; raise if the stiffness matrix is tied to the ground."""
    force = np.linalg.norm(fe.K @ rigid, axis=0)
    handled = np.linalg.norm(abs(fe.K) @ np.abs(rigid), axis=0)
    ratio = force / np.where(handled > 0.0, handled, 1.0)
    worst = int(np.argmax(ratio))
    if ratio[worst] > _GROUNDED:
        raise ReductionError(
            f"FE model '{fe.name}'",
            found=f"rigid motion in {DIRECTIONS[motions[worst]]} meets a force "
            f"(relative {ratio[worst]:.1e}): the stiffness is grounded",
            expected=f"a free body (below {_GROUNDED:g})",
            remedy="Remove supports and springs to ground from the FE model; hold the body by joints",
        )
    return float(ratio[worst])
