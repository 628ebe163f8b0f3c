"""`FrameBlock`: section forces, fibre stress and geometric stiffness of the beams of an FE model.

Geometric stiffness: second-order part of the strain energy of a beam in the rotation vector of its
cross-sections (docs/theory/frames.md, eq. (frame-geometric)), so nodal moments are semitangential, as the
multibody side applies them.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from scipy import sparse

from flexmb.fem.frames.element import FrameElements, chosen_rows, gauss
from flexmb.fem.nodal_assembly import gathered, rotated, summed

__all__ = ["FrameBlock"]

GEOMETRIC_POINTS = 4

# Second derivatives of the second-order energy density, eq. (frame-geometric): (a, b, section force, factor)
# with the gradient g = (u', v', w', theta_x, theta_y, theta_z, theta_x', theta_y', theta_z') and (N, V_y,
# V_z, M_x, M_y, M_z).
GEOMETRIC_TERMS = (
    (1, 1, 0, 1.0),
    (2, 2, 0, 1.0),
    (2, 3, 1, 1.0),
    (0, 5, 1, -1.0),
    (3, 4, 1, 0.5),
    (0, 4, 2, 1.0),
    (1, 3, 2, -1.0),
    (3, 5, 2, 0.5),
    (4, 8, 3, -0.5),
    (5, 7, 3, 0.5),
    (5, 6, 4, -0.5),
    (3, 8, 4, 0.5),
    (3, 7, 5, -0.5),
    (4, 6, 5, 0.5),
)


@dataclass(frozen=True, kw_only=True, eq=False)
class FrameBlock:
    """Beams with two nodes; an `ElementBlock`.

    Parameters
    ----------
    connectivity : (ne, 2), int
        First and second node of every beam.
    axes : (ne, 3, 3)
        Rows: local x, y, z in body axes.
    elements : FrameElements
        Interpolation of the beams in local axes.
    wagner : function of the fraction of the length -> (ne or 1, 6)
        Wagner coefficient ``int sigma_xx (y^2 + z^2) dA`` per section force, m2 and m.
    bending : function of the fraction of the length -> (ne or 1, 3, 6)
        ``sigma_xx = (1, y, z) @ bending @ section forces``, y and z from the line of nodes, 1/m2, 1/m3.
    number_of_nodes : int
    """

    connectivity: np.ndarray
    axes: np.ndarray
    elements: FrameElements
    wagner: Callable[[float], np.ndarray]
    bending: Callable[[float], np.ndarray]
    number_of_nodes: int
    cell_type: str = "line"
    modulus: float = 0.0  # no nodal stress

    def part(self, chosen: np.ndarray, nodes: np.ndarray, number: np.ndarray) -> FrameBlock:
        """Return the chosen beams (mask) on the given nodes (old numbers); `number` (n,) are the new ones."""
        return replace(
            self,
            connectivity=number[self.connectivity[chosen]],
            axes=self.axes[chosen],
            elements=self.elements.part(chosen),
            wagner=chosen_rows(self.wagner, chosen),
            bending=chosen_rows(self.bending, chosen),
            number_of_nodes=len(nodes),
        )

    def matrices(self, dofs: np.ndarray, lumped: bool) -> tuple[sparse.csr_matrix, sparse.csr_matrix]:
        """Return K and M (ndof, ndof) of these beams, in the freedoms `dofs`."""
        mass = self.elements.lumped_mass() if lumped else self.elements.consistent_mass()
        stiffness, mass = (
            summed(rotated(local, self.axes), self.connectivity, dofs, self.number_of_nodes)
            for local in (self.elements.stiffness(), mass)
        )
        return stiffness, mass

    def geometric_stiffness(self, displacement: np.ndarray, dofs: np.ndarray) -> sparse.csr_matrix:
        """Initial-stress stiffness (ndof, ndof), N/m, of the section forces that `displacement` (n, 6), m,
        causes."""
        forces = self._end_forces(np.asarray(displacement, float).reshape(self.number_of_nodes, 6, 1))
        local = self._local_geometric_stiffness(forces[..., 0], self._geometric_points())
        return summed(rotated(local, self.axes), self.connectivity, dofs, self.number_of_nodes)

    def projected_geometric_stiffness(self, displacements: np.ndarray, modes: np.ndarray) -> np.ndarray:
        """``modes^T K_g modes`` for each of the load cases in `displacements` (n, 6, l): (l, m, m), N/m."""
        forces = self._end_forces(displacements)
        shapes = gathered(modes, self.connectivity, self.axes)
        flat = shapes.reshape(-1, shapes.shape[-1])
        out = np.empty((forces.shape[-1], shapes.shape[-1], shapes.shape[-1]))
        points = self._geometric_points()  # the same for all cases, and most of the work
        for case in range(forces.shape[-1]):
            local = self._local_geometric_stiffness(forces[..., case], points)
            out[case] = flat.T @ (local @ shapes).reshape(flat.shape)
        return 0.5 * (out + out.swapaxes(1, 2))

    def nodal_stress(self, displacements: np.ndarray) -> np.ndarray:
        """Return NaN (n, 6, k): the stress of a beam varies over its section, see `section_forces`,
        `fibre_stress`."""
        return np.full((self.number_of_nodes, 6, displacements.shape[-1]), np.nan)

    def section_forces(self, displacements: np.ndarray) -> np.ndarray:
        """Return N, V_y, V_z (N), M_x, M_y, M_z (N m) at both ends of every beam: (ne, 2, 6, k).

        Local axes, on the line of nodes, exerted by the part with larger x on the part with smaller x: N >
        0 is tension. `displacements` (n, 6, k) or (n, 6), m and rad, of all nodes.
        """
        displacements = np.asarray(displacements, float).reshape(self.number_of_nodes, 6, -1)
        local = gathered(displacements, self.connectivity, self.axes)
        return np.stack([self.elements.section_forces(end) @ local for end in (0.0, 1.0)], axis=1)

    def fibre_stress(self, displacements: np.ndarray, fibre: tuple[float, float]) -> np.ndarray:
        """Return the axial stress (ne, 2, k), Pa, at both ends of every beam in the fibre (y, z), m, from
        the nodes."""
        forces = self.section_forces(displacements)
        row = np.array([1.0, *fibre])
        rows = [(row @ self.bending(end))[:, None] for end in (0.0, 1.0)]  # (ne or 1, 1, 6)
        return np.stack([(rows[j] @ forces[:, j])[:, 0] for j in range(2)], axis=1)

    def _end_forces(self, displacements: np.ndarray) -> np.ndarray:
        return self.elements.end_forces @ gathered(displacements, self.connectivity, self.axes)

    def _geometric_points(self) -> list[tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]]:
        """Return of every Gauss point the length (ne,), m, up to the second node, the weights (ne,), m, the derivatives
        of the geometric terms (ne, 9, 12), and Wagner's coefficients (ne or 1, 6).
        """
        lengths, found = self.elements.lengths, []
        for fraction, weight in gauss(GEOMETRIC_POINTS):
            shape, slope = self.elements.interpolation(fraction), self.elements.gradient(fraction)
            fields = np.concatenate([slope[:, :3], shape[:, 3:], slope[:, 3:]], axis=1)
            found.append(((1.0 - fraction) * lengths, weight * lengths, fields, self.wagner(fraction)))
        return found

    def _local_geometric_stiffness(self, end_forces: np.ndarray, points) -> np.ndarray:
        """Return (ne, 12, 12), N/m, for the section forces (ne, 6) at the second nodes; see `_geometric_points`."""
        lengths = self.elements.lengths
        total = np.zeros((len(lengths), 12, 12))
        for remaining, weights, fields, wagner in points:
            forces = end_forces.copy()
            forces[:, 4] -= remaining * end_forces[:, 2]
            forces[:, 5] += remaining * end_forces[:, 1]
            density = np.zeros((len(lengths), 9, 9))
            for a, b, force, factor in GEOMETRIC_TERMS:
                density[:, a, b] += factor * forces[:, force]
                if a != b:
                    density[:, b, a] += factor * forces[:, force]
            density[:, 6, 6] += (wagner * forces).sum(axis=1)
            total += weights[:, None, None] * (fields.swapaxes(1, 2) @ density @ fields)
        return total
