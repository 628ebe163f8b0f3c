"""`RodBlock`: bars that carry axial force and torque, hinged at their nodes."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy import sparse

from flexmb.fem.nodal_assembly import gathered, rotated, summed

__all__ = ["RodBlock"]


@dataclass(frozen=True, kw_only=True, eq=False)
class RodBlock:
    """Bars with two nodes; an `ElementBlock`.

    K = EA/L and GJ/L between the axial translations and rotations, mass consistent with linear functions; the
    geometric stiffness is N/L across the bar (C. A. Felippa, Nonlinear Finite Element Methods, ch. 9).

    Parameters
    ----------
    connectivity : (ne, 2), int
    axes : (ne, 3, 3)
        Rows: local x along the bar, y, z.
    lengths, axial, torsion, mass_per_length, polar : (ne,), m, N, N m2, kg/m, kg m
        axial is E A, torsion G J, polar the polar mass inertia per length.
    number_of_nodes : int
    point_masses : bool
        Masses as in Nastran: lumped ones have no inertia about the bar; coupled ones are lumped across it, and
        the mean of lumped and consistent along it (MSC Nastran, Dynamic Analysis User's Guide, coupled mass of CROD).
    """

    connectivity: np.ndarray
    axes: np.ndarray
    lengths: np.ndarray
    axial: np.ndarray
    torsion: np.ndarray
    mass_per_length: np.ndarray
    polar: np.ndarray
    number_of_nodes: int
    cell_type: str = "line"
    point_masses: bool = False
    modulus: float = 0.0  # no nodal stress

    def part(self, chosen: np.ndarray, nodes: np.ndarray, number: np.ndarray) -> RodBlock:
        """Return the chosen bars (mask) on the given nodes (old numbers); `number` (n,) are the new ones."""
        names = ("axes", "lengths", "axial", "torsion", "mass_per_length", "polar")
        return replace(
            self,
            connectivity=number[self.connectivity[chosen]],
            number_of_nodes=len(nodes),
            **{name: getattr(self, name)[chosen] for name in names},
        )

    def matrices(self, dofs: np.ndarray, lumped: bool) -> tuple[sparse.csr_matrix, sparse.csr_matrix]:
        """Return K and M (ndof, ndof) of these bars, in the freedoms `dofs`."""
        ne = len(self.lengths)
        stiffness, mass = np.zeros((ne, 2, 6, 2, 6)), np.zeros((ne, 2, 6, 2, 6))
        for a in range(2):
            for b in range(2):
                sign = 1.0 if a == b else -1.0
                stiffness[:, a, 0, b, 0] = sign * self.axial / self.lengths
                stiffness[:, a, 3, b, 3] = sign * self.torsion / self.lengths
                share = (0.5 if a == b else 0.0) if lumped else (1.0 / 3.0 if a == b else 1.0 / 6.0)
                half = 0.5 if a == b else 0.0
                along, across = (0.5 * (share + half), half) if self.point_masses else (share, share)
                for k in range(3):
                    mass[:, a, k, b, k] = (across if k else along) * self.mass_per_length * self.lengths
                if not (lumped and self.point_masses):
                    mass[:, a, 3, b, 3] = share * self.polar * self.lengths
        return self._summed(stiffness, dofs), self._summed(mass, dofs)

    def geometric_stiffness(self, displacement: np.ndarray, dofs: np.ndarray) -> sparse.csr_matrix:
        """Initial-stress stiffness (ndof, ndof), N/m, of the axial forces that `displacement` (n, 6), m, causes."""
        force = self._force(np.asarray(displacement, float).reshape(self.number_of_nodes, 6, 1))[:, 0]
        matrix = np.zeros((len(force), 2, 6, 2, 6))
        for a in range(2):
            for b in range(2):
                for k in (1, 2):
                    matrix[:, a, k, b, k] = (1.0 if a == b else -1.0) * force / self.lengths
        return self._summed(matrix, dofs)

    def projected_geometric_stiffness(self, displacements: np.ndarray, modes: np.ndarray) -> np.ndarray:
        """``modes^T K_g modes`` for each load case in `displacements` (n, 6, l): (l, m, m), N/m."""
        local = gathered(modes, self.connectivity, self.axes).reshape(len(self.lengths), 2, 6, -1)
        across = local[:, 1, 1:3] - local[:, 0, 1:3]  # (ne, 2, m)
        force = self._force(displacements) / self.lengths[:, None]
        return np.einsum("el,eka,ekb->lab", force, across, across, optimize=True)

    def nodal_stress(self, displacements: np.ndarray) -> np.ndarray:
        """No nodal stress: NaN (n, 6, k)."""
        return np.full(displacements.shape, np.nan)

    def _force(self, displacements: np.ndarray) -> np.ndarray:
        """Axial force (ne, k), N."""
        local = gathered(displacements, self.connectivity, self.axes).reshape(len(self.lengths), 2, 6, -1)
        return (self.axial / self.lengths)[:, None] * (local[:, 1, 0] - local[:, 0, 0])

    def _summed(self, matrices: np.ndarray, dofs: np.ndarray) -> sparse.csr_matrix:
        local = matrices.reshape(len(self.lengths), 12, 12)
        return summed(rotated(local, self.axes), self.connectivity, dofs, self.number_of_nodes)
