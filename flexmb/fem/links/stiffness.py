"""`RigidLinkBlock`: the geometric stiffness of rigid links, from the forces that hold their nodes in them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from flexmb.fem.nodal_assembly import freedom_rows

__all__ = ["RigidLinkBlock"]


@dataclass(frozen=True, kw_only=True, eq=False)
class RigidLinkBlock:
    """Rigid links as an `ElementBlock` without cells.

    A link that turns by theta takes its nodes along ``theta x s + theta x (theta x s) / 2``; the second part works on
    the forces r that hold them, ``theta^T (sym(sum r s^T) - (sum r . s) I) theta / 2`` (docs/theory/frames.md, eq.
    (link-geometric)). Loads that act on the dependent nodes directly are not known here and count into r.

    Parameters
    ----------
    nodes : (k,) int
        Reference node of each row.
    number_of_nodes : int
    dofs : (nu, 2), int
        Freedoms of the model before the link.
    stiffness : (k, nu) csr, N/m
        Rows of its stiffness matrix: of the translations of the dependent nodes.
    directions, arms : (k,) int and (k, 3), m
        Direction 0..2 of each row, and from the reference node to its node.
    """

    nodes: np.ndarray
    number_of_nodes: int
    dofs: np.ndarray
    stiffness: sparse.csr_matrix
    directions: np.ndarray
    arms: np.ndarray
    cell_type: str = "vertex"
    modulus: float = 0.0

    @property
    def connectivity(self) -> np.ndarray:
        """No cells: (0, 1), int."""
        return np.zeros((0, 1), int)

    def geometric_stiffness(self, displacement: np.ndarray, dofs: np.ndarray) -> sparse.csr_matrix:
        """Stiffness (ndof, ndof), N m/rad, at the rotations of the reference node,
        of the forces of a `displacement`.
        """
        references, matrices = self._at_references(displacement[:, :, None])
        rows = freedom_rows(dofs, self.number_of_nodes)[references, 3:]
        i, j = np.broadcast_arrays(rows[:, :, None], rows[:, None, :])
        there = (i >= 0) & (j >= 0)
        return sparse.csr_matrix((matrices[..., 0][there], (i[there], j[there])), shape=(len(dofs),) * 2)

    def projected_geometric_stiffness(self, displacements: np.ndarray, modes: np.ndarray) -> np.ndarray:
        """``modes^T K_g modes`` for each load case in `displacements` (n, 6, l): (l, m, m), N m/rad."""
        references, matrices = self._at_references(displacements)
        turn = modes[references, 3:]
        return np.einsum("ria,rijl,rjb->lab", turn, matrices, turn, optimize=True)

    def nodal_stress(self, displacements: np.ndarray) -> np.ndarray:
        """No stress: NaN (n, 6, k)."""
        return np.full(displacements.shape, np.nan)

    def _at_references(self, displacements: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the reference nodes (nr,) and the stiffness (nr, 3, 3, l) at their rotations."""
        held = self.stiffness @ displacements[self.dofs[:, 0], self.dofs[:, 1]]
        references, of = np.unique(self.nodes, return_inverse=True)
        moments = np.zeros((len(references), 3, 3, held.shape[1]))  # sum r s^T
        np.add.at(moments, (of, self.directions), self.arms[:, :, None] * held[:, None, :])
        traces = np.einsum("riil->rl", moments)
        return references, 0.5 * (moments + moments.swapaxes(1, 2)) - np.eye(3)[:, :, None] * traces[:, None, None]
