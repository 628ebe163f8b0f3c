"""`SolidBlock`: the solid elements of one kind and material, as reduction and recovery see them."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy import sparse

from flexmb.fem.block_pattern import BlockPattern, node_pattern
from flexmb.fem.solids import kernels
from flexmb.fem.solids.elements import SolidElement

__all__ = ["SolidBlock"]

CHUNK = 500
"""Elements per chunk of the projected geometric stiffness: the products of 50 modes then take about 120 MB."""

TENSOR = np.array([[0, 3, 5], [3, 1, 4], [5, 4, 2]])
"""Place of the tensor component ij among xx, yy, zz, xy, yz, zx."""


@dataclass(frozen=True, kw_only=True, eq=False)
class SolidBlock:
    """Solid elements of one kind and one material (an `ElementBlock`).

    Parameters
    ----------
    element : SolidElement
    nodes : (n, 3), m
        All node positions of the FE model.
    connectivity : (ne, nodes per cell)
        Node numbers in meshio's order.
    elasticity : (6, 6), Pa
        For stress xx, yy, zz, xy, yz, zx and engineering shear strain, in body axes.
    density : float, kg/m3
    """

    element: SolidElement
    nodes: np.ndarray
    connectivity: np.ndarray
    elasticity: np.ndarray
    density: float

    @property
    def cell_type(self) -> str:
        """Cell name in meshio's spelling."""
        return self.element.cell_type

    @property
    def modulus(self) -> float:
        """Largest elastic stiffness of the material, Pa."""
        return float(np.max(np.diag(self.elasticity)))

    def add_stiffness(self, pattern: BlockPattern, data: np.ndarray) -> None:
        """Add the stiffness matrices, N/m, to the values `data` of ``pattern.blocks``."""
        kernels.assemble_stiffness(
            self.nodes, self.connectivity, *self._stiffness_tables(), pattern.start, pattern.indices, data
        )

    def add_mass(self, pattern: BlockPattern, data: np.ndarray, lumped: bool) -> None:
        """Add the scalar mass matrices, kg, to the values `data` of ``pattern.scalar``."""
        t = self.element.tables
        kernels.assemble_mass(
            self.nodes,
            self.connectivity,
            t.mass_value,
            t.mass_gradient,
            t.mass_weight,
            self.density,
            lumped,
            pattern.start,
            pattern.indices,
            data,
        )

    def part(self, chosen: np.ndarray, nodes: np.ndarray, number: np.ndarray) -> SolidBlock:
        """Return the chosen elements (mask) on the given nodes (old numbers); `number` (n,) are the new ones."""
        return replace(self, nodes=self.nodes[nodes], connectivity=number[self.connectivity[chosen]])

    def matrices(self, dofs: np.ndarray, lumped: bool) -> tuple[sparse.csr_matrix, sparse.csr_matrix]:
        """Return K and M (ndof, ndof) of these elements, in the freedoms `dofs`."""
        pattern = node_pattern(len(self.nodes), [self.connectivity])
        stiffness, mass = np.zeros(9 * len(pattern.indices)), np.zeros(len(pattern.indices))
        self.add_stiffness(pattern, stiffness)
        self.add_mass(pattern, mass, lumped)
        moved = np.flatnonzero(dofs[:, 1] < 3)  # nodes shared with shells or beams have rotations too
        rows = 3 * dofs[moved, 0] + dofs[moved, 1]
        into = sparse.csr_matrix((np.ones(len(moved)), (moved, np.arange(len(moved)))), shape=(len(dofs), len(moved)))
        K, M = pattern.blocks(stiffness)[rows][:, rows], pattern.three_times(mass)[rows][:, rows]
        return (into @ K @ into.T).tocsr(), (into @ M @ into.T).tocsr()

    def geometric_stiffness(self, displacement: np.ndarray, dofs: np.ndarray) -> sparse.csr_matrix:
        """Initial-stress stiffness (ndof, ndof), N/m, of the stress that `displacement` (n, 6), m, causes.

        ``K_g = int grad(du)^T sigma grad(u)``, the same in each direction, eq. (fe-geometric).
        """
        t = self.element.tables
        u = np.ascontiguousarray(displacement[:, :3], float).reshape(len(self.nodes), 3, 1)
        pattern = node_pattern(len(self.nodes), [self.connectivity])
        data = np.zeros(len(pattern.indices))
        for cells in self._chunks():
            stress = self._stress(cells, t.stiffness_gradient, t.stiffness_inner, u)
            kernels.scalar_geometric_stiffness(
                self.nodes,
                cells,
                t.stiffness_gradient,
                t.stiffness_weight,
                stress,
                pattern.start,
                pattern.indices,
                data,
            )
        # Rows of K: dofs may hold rotations of other blocks, and may be in any order.
        place = np.full((len(self.nodes), 3), -1)
        moved = np.flatnonzero(dofs[:, 1] < 3)
        place[dofs[moved, 0], dofs[moved, 1]] = moved
        scalar = pattern.scalar(data).tocoo()
        rows, columns = place[scalar.row].ravel(), place[scalar.col].ravel()
        kept = (rows >= 0) & (columns >= 0)
        return sparse.csr_matrix(
            (np.repeat(scalar.data, 3)[kept], (rows[kept], columns[kept])), shape=(len(dofs), len(dofs))
        )

    def projected_geometric_stiffness(self, displacements: np.ndarray, modes: np.ndarray) -> np.ndarray:
        """``modes^T K_g(displacements[..., l]) modes`` for each load case l: (k, m, m), no matrix assembled.

        displacements (n, 6, k), modes (n, 6, m). At an integration point the result is linear in the six stresses,
        eq. (fe-projected), so a chunk of elements is one matrix product (k, 6 nq) (6 nq, m (m + 1) / 2).
        """
        t = self.element.tables
        u = np.ascontiguousarray(displacements[:, :3], float)
        phi = np.ascontiguousarray(modes[:, :3], float)
        cases, m = u.shape[2], phi.shape[2]
        result = np.zeros((cases, m * (m + 1) // 2))
        for cells in self._chunks():
            stress = self._stress(cells, t.stiffness_gradient, t.stiffness_inner, u)
            products = np.zeros((stress.shape[0] * stress.shape[1] * 6, result.shape[1]))
            kernels.modal_gradient_products(self.nodes, cells, t.stiffness_gradient, t.stiffness_weight, phi, products)
            result += stress.reshape(-1, cases).T @ products
        full = np.empty((cases, m, m))
        a, b = np.triu_indices(m)
        full[:, a, b] = result
        full[:, b, a] = result
        return full

    def nodal_stress(self, displacements: np.ndarray) -> np.ndarray:
        """Stress xx, yy, zz, xy, yz, zx, (n, 6, k), Pa, of displacements (n, 6, k), m; NaN at nodes of other blocks.

        Sampled at the stress points, continued to the nodes and averaged over the cells at each node, eq. (fe-stress).
        """
        t = self.element.tables
        u = np.ascontiguousarray(displacements[:, :3], float)
        total, count = np.zeros((len(self.nodes), 6, u.shape[2])), np.zeros(len(self.nodes))
        for cells in self._chunks():
            stress = self._stress(cells, t.stress_gradient, t.stress_inner, u)
            kernels.nodal_sum(cells, t.extrapolation, stress, total, count)
        with np.errstate(invalid="ignore"):
            return total / count[:, None, None]

    def element_stress(self, displacements: np.ndarray, cells: np.ndarray | None = None) -> np.ndarray:
        """Stress xx, yy, zz, xy, yz, zx, (ne, nodes of a cell, 6, k), Pa, at the nodes of chosen cells (all by
        default), each cell by itself: where neighbours differ, the mesh is too coarse."""
        t = self.element.tables
        u = np.ascontiguousarray(displacements[:, :3], float)
        chosen = self.connectivity if cells is None else self.connectivity[cells]
        stress = self._stress(chosen, t.stress_gradient, t.stress_inner, u)
        return np.einsum("np,epck->enck", t.extrapolation, stress)

    def _chunks(self):
        return (self.connectivity[i : i + CHUNK] for i in range(0, len(self.connectivity), CHUNK))

    def _stiffness_tables(self):
        t, c9 = self.element.tables, self.elasticity[TENSOR[:, :, None, None], TENSOR[None, None]]
        # C_ijkl at row (i, k), column (j, l)
        c9 = np.ascontiguousarray(c9.transpose(0, 2, 1, 3).reshape(9, 9))
        return t.stiffness_gradient, t.stiffness_weight, t.stiffness_inner, t.centre_gradient, c9

    def _stress(self, cells: np.ndarray, gradient: np.ndarray, inner: np.ndarray, u: np.ndarray) -> np.ndarray:
        stress = np.empty((len(cells), len(gradient), 6, u.shape[2]))
        kernels.point_stress(
            self.nodes,
            cells,
            gradient,
            inner,
            *self._stiffness_tables(),
            np.ascontiguousarray(self.elasticity, float),
            u,
            stress,
        )
        return stress
