"""`ShellBlock`: matrices, stress and geometric stiffness of flat shell elements of one cell type."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import ClassVar

import numpy as np
from scipy import sparse

from flexmb.fem.nodal_assembly import gathered, rotated, scattered, summed
from flexmb.fem.shells.bending import curvature_rows, slope_rows
from flexmb.fem.shells.functions import CORNERS, functions, integration_points, mass_points
from flexmb.fem.shells.membrane import displacement_gradient, displacement_rows, drilling_row, strain_rows
from flexmb.fem.shells.slopes import NodalSlopes, nodal_slopes
from flexmb.model.material import Material

__all__ = ["ShellBlock"]

DRILLING_INERTIA = 1e-3
"""Share of rho t^3 / 12 given to theta_z, so that the mass matrix is positive definite; 1e-3 t^2 / L^2 of
the inertia."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ShellBlock:
    """Flat shell elements with three or four corners; an `ElementBlock`.

    Parameters
    ----------
    connectivity : (ne, c), int
    axes : (ne, 3, 3)
        Rows: local x, y, and z normal to the element, in body axes.
    corners : (ne, c, 2), m
        Corners in local axes, projected onto the mean plane of a warped quadrilateral.
    heights : (ne, c), m
        Distance of the corners from the mean plane, along local z.
    thickness : (ne,), m
    material : Material
    number_of_nodes : int
    centers : (ne, 3), m, or None
        Mean of the corners, in body axes; None: nodal stress is the mean of the cells' corners for triangles too.
    side : float or None
        Where `nodal_stress` is taken: -1 bottom, 0 middle, +1 top (the side local z points to). None: nobody
        chose; it is the middle, which reductions warn of.
    """

    ROWS: ClassVar[tuple[str, ...]] = ("axes", "corners", "heights", "centers", "thickness")
    """Fields with a row per element."""

    connectivity: np.ndarray
    axes: np.ndarray
    corners: np.ndarray
    heights: np.ndarray
    thickness: np.ndarray
    material: Material
    number_of_nodes: int
    centers: np.ndarray | None = None
    side: float | None = None

    @property
    def cell_type(self) -> str:
        """Cell name in meshio's spelling."""
        return "triangle" if self.connectivity.shape[1] == 3 else "quad"

    @property
    def modulus(self) -> float:
        """Largest elastic stiffness of the material, Pa."""
        return float(self.elasticity[0, 0])

    @cached_property
    def elasticity(self) -> np.ndarray:
        """Plane stress elasticity (3, 3), Pa, for (e_xx, e_yy, 2 e_xy)."""
        nu = self.material.poisson
        matrix = np.array([[1.0, nu, 0.0], [nu, 1.0, 0.0], [0.0, 0.0, 0.5 * (1.0 - nu)]])
        return self.material.young / (1.0 - nu**2) * matrix

    @cached_property
    def strains(self):
        """Function (xi, eta) -> membrane strains per local displacement of the projected corners."""
        return strain_rows(self.corners, self.elasticity, self.material.poisson)

    softness = None
    """Shear parameter phi (ne, c) of every edge; None: no transverse shear."""
    spring: ClassVar[np.ndarray | None] = None
    """Share (ne,) of the in-plane shear stiffness that holds the rotation about the normal; None: the membrane turns
    with its corners."""
    point_masses: ClassVar[bool] = False
    """Have lumped masses no rotary inertia?"""

    def sections(self) -> tuple[np.ndarray, np.ndarray | None, np.ndarray]:
        """Return A, B and D (ne, 3, 3), N/m, N, N m, of the section; B None where it is zero."""
        t = self.thickness[:, None, None]
        return t * self.elasticity, None, t**3 / 12.0 * self.elasticity

    def areal_mass(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return mass per area (ne,), kg/m2, depth over which it is spread (ne,), m, and its height over the plane."""
        return self.material.density * self.thickness, self.thickness, np.zeros(len(self.thickness))

    def layer(self, side: float) -> tuple[np.ndarray, np.ndarray]:
        """Return the elasticity (3, 3) or (ne, 3, 3), Pa, and the height (ne,), m, of the material on a side."""
        return self.elasticity, 0.5 * side * self.thickness

    def points(self) -> list:
        """Return the functions at the integration points."""
        return [functions(self.corners, *point) for point in integration_points(self.corners.shape[1])]

    def stiffness(self) -> np.ndarray:
        """Return the element stiffness matrices (ne, 6 c, 6 c) in body axes, N/m (shells.md, eq.
        (shell-stiffness))."""
        total = np.zeros(())
        membrane, coupling, bending = self.sections()
        for at in self.points():
            strain, curvature = self.strains(at.xi, at.eta), curvature_rows(self.corners, at, self.softness)
            total = total + _weighted(strain, membrane, at.weight) + _weighted(curvature, bending, at.weight)
            if coupling is not None:
                cross = at.weight[:, None, None] * (strain.swapaxes(1, 2) @ coupling @ curvature)
                total = total - cross - cross.swapaxes(1, 2)
            total = total + self._sheared(at)
            total = total + self._drilled(at, membrane[:, 2:, 2:])
        return self._in_body_axes(total)

    def _drilled(self, at, shear: np.ndarray) -> np.ndarray | float:
        """Return what ties the rotation about the normal to the rotation of the plane at a point, (ne, 6 c, 6 c)."""
        if self.spring is not None:
            return _weighted(
                drilling_row(self.corners, at, False)[:, None, :], self.spring[:, None, None] * shear, at.weight
            )
        if self.cell_type == "triangle":  # OPT resists by itself
            return 0.0
        return _weighted(drilling_row(self.corners, at)[:, None, :], shear, at.weight)

    def _sheared(self, at) -> np.ndarray | float:
        """Return the stiffness of transverse shear at a point, (ne, 6 c, 6 c); 0 without."""
        return 0.0

    def mass(self, lumped: bool = False) -> np.ndarray:
        """Return the element mass matrices (ne, 6 c, 6 c) in body axes, kg (eq. (shell-mass)).

        Consistent with a quadratic field (edges bow with the nodal rotations), or `lumped` by rows of the
        linear functions.
        """
        count = self.connectivity.shape[1]
        total, rotation = np.zeros(()), np.zeros((len(self.connectivity), count, count))
        for point in mass_points(count):
            at = functions(self.corners, *point)
            share = np.diag(at.value) if lumped else np.outer(at.value, at.value)
            rotation += at.weight[:, None, None] * share
            if not lumped:
                total = total + _weighted(
                    displacement_rows(self.corners, at, self.spring is None), np.eye(3), at.weight
                )
        matrix = np.zeros((len(rotation), count, 6, count, 6))
        per_area, depth, height = self.areal_mass()
        inertia = rotation * (depth**2 / 12.0)[:, None, None]
        if not (lumped and self.point_masses):
            for direction, factor in ((3, 1.0), (4, 1.0), (5, DRILLING_INERTIA)):
                matrix[:, :, direction, :, direction] = factor * inertia
        if lumped:
            for direction in range(3):
                matrix[:, :, direction, :, direction] = rotation
        matrix = matrix.reshape(len(rotation), 6 * count, 6 * count) + total
        moved = replace(self, heights=self.heights - height[:, None])
        return moved._in_body_axes(per_area[:, None, None] * matrix)

    def part(self, chosen: np.ndarray, nodes: np.ndarray, number: np.ndarray) -> ShellBlock:
        """Return the chosen elements (mask) on the given nodes (old numbers); `number` (n,) are the new ones."""
        rows = {name: getattr(self, name)[chosen] for name in self.ROWS if getattr(self, name) is not None}
        return replace(self, connectivity=number[self.connectivity[chosen]], number_of_nodes=len(nodes), **rows)

    def matrices(self, dofs: np.ndarray, lumped: bool) -> tuple[sparse.csr_matrix, sparse.csr_matrix]:
        """Return K and M (ndof, ndof) of these elements, in the freedoms `dofs`."""
        return (
            summed(self.stiffness(), self.connectivity, dofs, self.number_of_nodes),
            summed(self.mass(lumped), self.connectivity, dofs, self.number_of_nodes),
        )

    def geometric_stiffness(self, displacement: np.ndarray, dofs: np.ndarray) -> sparse.csr_matrix:
        """Initial-stress stiffness (ndof, ndof), N/m, of the membrane forces that `displacement` (n, 6), m,
        causes."""
        local = self._local(np.asarray(displacement, float).reshape(self.number_of_nodes, 6, 1))
        matrices = self._in_body_axes(self._geometric(local)[..., 0])
        return summed(matrices, self.connectivity, dofs, self.number_of_nodes)

    def projected_geometric_stiffness(self, displacements: np.ndarray, modes: np.ndarray) -> np.ndarray:
        """``modes^T K_g modes`` for each of the load cases in `displacements` (n, 6, l): (l, m, m), N/m."""
        stressing, shapes = self._local(displacements), self._local(modes)
        out = np.zeros((displacements.shape[-1], modes.shape[-1], modes.shape[-1]))
        for at in self.points():
            forces = self._membrane_forces(stressing, at) * at.weight[:, None, None]
            for field in self._gradients(at):
                slope = field @ shapes  # (ne, 2, m)
                for a, b, component in ((0, 0, 0), (1, 1, 1), (0, 1, 2), (1, 0, 2)):
                    for case in range(len(out)):
                        out[case] += slope[:, a].T @ (forces[:, component, case, None] * slope[:, b])
        return 0.5 * (out + out.swapaxes(1, 2))

    def nodal_stress(self, displacements: np.ndarray) -> np.ndarray:
        """Stress xx, yy, zz, xy, yz, zx at nodes, (n, 6, k), Pa, on the surface `side`; NaN at nodes of
        other blocks."""
        return self.surface_stress(displacements, self.side or 0.0)

    def surface_stress(self, displacements: np.ndarray, side: float) -> np.ndarray:
        """Return the stress at nodes (n, 6, k), Pa, in body axes: side -1 bottom, 0 middle, +1 top.

        Mean of the quadrilaterals at the node; of triangles from quadratics through the nodes around, where there are
        enough of them (docs/theory/shells.md, "Stress at nodes").
        """
        displacements = np.asarray(displacements, float)
        if self.cell_type == "quad" or self.centers is None or not self.fits(side):
            return scattered(self._corner_stress(displacements, side), self.connectivity, self.number_of_nodes)
        return self._fitted_stress(displacements, side)

    def fits(self, side: float) -> bool:
        """Whether stress may be fitted over cells: they are of one material and one plane."""
        return True

    @cached_property
    def slopes(self) -> NodalSlopes:
        """Slopes along the surface at the nodes."""
        own = self.heights - self.heights.mean(axis=1)[:, None]  # without the offset of a layup
        nodes, local = np.zeros((self.number_of_nodes, 3)), np.dstack([self.corners, own])
        centers = np.zeros((len(local), 3)) if self.centers is None else self.centers
        nodes[self.connectivity] = centers[:, None] + local @ self.axes
        return nodal_slopes(self.connectivity, self.axes[:, 2], self.thickness, nodes)

    def _fitted_stress(self, displacements: np.ndarray, side: float) -> np.ndarray:
        at, size = self.slopes, displacements.shape[-1]
        field = displacements.reshape(self.number_of_nodes, 6 * size)
        (u_x, v_x, tx_x, ty_x), (u_y, v_y, tx_y, ty_y) = (
            np.einsum("lai,lcik->calk", at.axes[:, :2], (rows @ field).reshape(-1, 2, 3, size)).reshape(4, -1, size)
            for rows in (at.along_x, at.along_y)
        )
        strain = np.stack([u_x, v_y, u_y + v_x], axis=1)
        curvature = np.stack([-ty_x, tx_y, tx_x - ty_y], axis=1)  # w_x = -theta_y, w_y = theta_x
        elasticity, height = self.layer(side)
        over_nodes = (height - self.heights[:, 0])[at.cell]
        layer = elasticity if elasticity.ndim == 2 else elasticity[at.cell]
        plane = layer @ (strain - over_nodes[:, None, None] * curvature)
        total = np.zeros((self.number_of_nodes, 6, size))
        np.add.at(total, at.node, at.share[:, None, None] * _in_space(plane, at.axes))
        cells = np.bincount(self.connectivity.ravel(), minlength=self.number_of_nodes).astype(float)
        if at.left.any():  # a strip of single triangles, a lonely one
            corners = self.connectivity[at.left]
            share = 1.0 / cells[corners][:, None, None]
            np.add.at(total, corners, share * self._corner_stress(displacements, side)[at.left])
        total[cells == 0.0] = np.nan
        return total

    def element_stress(self, displacements: np.ndarray, cells: np.ndarray | None = None) -> np.ndarray:
        """Stress xx, yy, zz, xy, yz, zx, (ne, corners, 6, k), Pa, on the surface `side` at the corners of chosen cells
        (all by default), each cell by itself."""
        stress = self._corner_stress(np.asarray(displacements, float), self.side or 0.0)
        return stress if cells is None else stress[cells]

    def _corner_stress(self, displacements: np.ndarray, side: float) -> np.ndarray:
        local = self._local(displacements)
        elasticity, height = self.layer(side)
        corner_values = []
        for xi, eta in CORNERS[self.connectivity.shape[1]]:
            curvature = curvature_rows(self.corners, functions(self.corners, xi, eta), self.softness)
            strain = self.strains(xi, eta) - height[:, None, None] * curvature
            plane = elasticity @ (strain @ local)  # (ne, 3, k)
            corner_values.append(_in_space(plane, self.axes))
        return np.stack(corner_values, axis=1)

    def _gradients(self, at) -> list[np.ndarray]:
        """Gradients (ne, 2, 6 c) of u, v and w at a point."""
        plane = displacement_gradient(self.corners, at, self.spring is None)
        return [plane[:, 0], plane[:, 1], slope_rows(self.corners, at)]

    def _membrane_forces(self, local: np.ndarray, at) -> np.ndarray:
        return self.thickness[:, None, None] * (self.elasticity @ (self.strains(at.xi, at.eta) @ local))

    def _geometric(self, local: np.ndarray) -> np.ndarray:
        """Return (ne, 6 c, 6 c, k) in local axes (eq. (shell-geometric))."""
        total = np.zeros(())
        for at in self.points():
            n_x, n_y, n_xy = np.moveaxis(self._membrane_forces(local, at), 1, 0)[:, :, 0]
            tensor = np.stack([np.stack([n_x, n_xy], axis=1), np.stack([n_xy, n_y], axis=1)], axis=1)
            for field in self._gradients(at):
                total = total + at.weight[:, None, None] * (field.swapaxes(1, 2) @ tensor @ field)
        return total[..., None]

    def _local(self, field: np.ndarray) -> np.ndarray:
        """Displacements (ne, 6 c, k) of the projected corners in local axes."""
        values = gathered(field, self.connectivity, self.axes)
        nodal = values.reshape(len(values), -1, 6, values.shape[-1])
        nodal[:, :, 0] -= self.heights[:, :, None] * nodal[:, :, 4]
        nodal[:, :, 1] += self.heights[:, :, None] * nodal[:, :, 3]
        return values

    def _in_body_axes(self, matrices: np.ndarray) -> np.ndarray:
        """Move the matrices from the projected corners to the nodes (rigid arms along z) and turn them."""
        count = self.connectivity.shape[1]
        rows = matrices.reshape(len(matrices), count, 6, -1).copy()
        rows[:, :, 4] -= self.heights[:, :, None] * rows[:, :, 0]
        rows[:, :, 3] += self.heights[:, :, None] * rows[:, :, 1]
        columns = rows.reshape(len(matrices), -1, count, 6)
        columns[..., 4] -= self.heights[:, None, :] * columns[..., 0]
        columns[..., 3] += self.heights[:, None, :] * columns[..., 1]
        return rotated(columns.reshape(matrices.shape), self.axes)


def _in_space(plane: np.ndarray, axes: np.ndarray) -> np.ndarray:
    """Return xx, yy, zz, xy, yz, zx in body axes, (ne, 6, k), of plane stress (ne, 3, k) in local axes (ne, 3, 3)."""
    tensor = np.zeros((len(plane), 3, 3, plane.shape[-1]))
    tensor[:, 0, 0], tensor[:, 1, 1] = plane[:, 0], plane[:, 1]
    tensor[:, 0, 1] = tensor[:, 1, 0] = plane[:, 2]
    body = np.einsum("eia,eijk,ejb->eabk", axes, tensor, axes, optimize=True)
    return body[:, [0, 1, 2, 0, 1, 2], [0, 1, 2, 1, 2, 0]]


def _weighted(rows: np.ndarray, elasticity: np.ndarray, weight: np.ndarray) -> np.ndarray:
    return weight[:, None, None] * (rows.swapaxes(1, 2) @ elasticity @ rows)
