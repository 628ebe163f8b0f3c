"""Compiled kernels of the solid elements: stiffness, mass, stress and geometric stiffness.

docs/theory/elements.md derives the equations. Every element matrix is contracted from scalar gradients (G_a: gradient
of the shape function of node a in body axes). So one kernel serves all element kinds and, through the full elasticity
matrix, isotropic, orthotropic and anisotropic materials.
"""

from __future__ import annotations

import numpy as np

from flexmb.fem.block_pattern import scatter_blocks, scatter_scalar
from flexmb.math.kernel import kernel

__all__ = [
    "assemble_mass",
    "assemble_stiffness",
    "jacobian_range",
    "modal_gradient_products",
    "nodal_sum",
    "point_stress",
    "scalar_geometric_stiffness",
]


@kernel
def inverse_jacobian(x, dn, inverse):
    """Fill dX_l/dx_k into inverse[l, k] and return det dx/dX, for node positions x (nn, 3), eq. (fe-jacobian)."""
    j = np.zeros((3, 3))
    for a in range(len(x)):
        for k in range(3):
            for m in range(3):
                j[k, m] += x[a, k] * dn[a, m]
    c0 = j[1, 1] * j[2, 2] - j[1, 2] * j[2, 1]
    c1 = j[1, 2] * j[2, 0] - j[1, 0] * j[2, 2]
    c2 = j[1, 0] * j[2, 1] - j[1, 1] * j[2, 0]
    det = j[0, 0] * c0 + j[0, 1] * c1 + j[0, 2] * c2
    inverse[0, 0] = c0 / det
    inverse[1, 0] = c1 / det
    inverse[2, 0] = c2 / det
    inverse[0, 1] = (j[0, 2] * j[2, 1] - j[0, 1] * j[2, 2]) / det
    inverse[1, 1] = (j[0, 0] * j[2, 2] - j[0, 2] * j[2, 0]) / det
    inverse[2, 1] = (j[0, 1] * j[2, 0] - j[0, 0] * j[2, 1]) / det
    inverse[0, 2] = (j[0, 1] * j[1, 2] - j[0, 2] * j[1, 1]) / det
    inverse[1, 2] = (j[0, 2] * j[1, 0] - j[0, 0] * j[1, 2]) / det
    inverse[2, 2] = (j[0, 0] * j[1, 1] - j[0, 1] * j[1, 0]) / det
    return det


@kernel
def transform(dn, inverse, scale, first, g):
    """Fill g[first:] with scale * dn inverse: gradients in body axes from reference gradients."""
    for a in range(len(dn)):
        for k in range(3):
            g[first + a, k] = scale * (dn[a, 0] * inverse[0, k] + dn[a, 1] * inverse[1, k] + dn[a, 2] * inverse[2, k])


@kernel
def stiffness_matrix(x, dn, w, di, dc, c9, gram, ke):
    """Fill ke with the element stiffness of nodes and incompatible modes, not yet condensed, eq. (fe-stiffness).

    gram[a, b] (9,) = int G_a G_b^T; ke_ab = C : gram_ab. c9 (9, 9): C_ijkl at the row 3 i + k, column 3 j + l.
    """
    nn, ni = dn.shape[1], di.shape[1]
    nt = nn + ni
    inverse, centre, g = np.empty((3, 3)), np.empty((3, 3)), np.empty((nt, 3))
    det_centre = inverse_jacobian(x, dc, centre) if ni else 1.0
    gram[:] = 0.0
    for q in range(len(w)):
        det = inverse_jacobian(x, dn[q], inverse)
        transform(dn[q], inverse, 1.0, 0, g)
        transform(di[q], centre, det_centre / det, nn, g)  # Taylor's correction: passes the patch test
        for a in range(nt):
            for i in range(3):
                h = w[q] * det * g[a, i]
                for b in range(a, nt):
                    for j in range(3):
                        gram[a, b, 3 * i + j] += h * g[b, j]
    for a in range(nt):
        for b in range(a, nt):
            for i in range(3):
                for k in range(3):
                    value = 0.0
                    for p in range(9):
                        value += c9[3 * i + k, p] * gram[a, b, p]
                    ke[3 * a + i, 3 * b + k] = value
                    ke[3 * b + k, 3 * a + i] = value


@kernel
def condense(ke, n):
    """Eliminate the rows and columns from n on, last first, eq. (fe-condense); ke[:n, :n] is then the condensed matrix.

    Row p >= n keeps the equation ``ke[p, :p + 1] @ amplitudes[:p + 1] = 0`` from which `amplitudes` finds them again.
    """
    for p in range(len(ke) - 1, n - 1, -1):
        for i in range(p):
            factor = ke[i, p] / ke[p, p]
            for j in range(i + 1):
                ke[i, j] -= factor * ke[p, j]
                ke[j, i] = ke[i, j]


@kernel
def amplitudes(ke, n, u):
    """Fill the incompatible amplitudes u[n:] of the nodal displacements u[:n] after `condense`."""
    for p in range(n, len(ke)):
        for k in range(u.shape[1]):
            value = 0.0
            for j in range(p):
                value -= ke[p, j] * u[j, k]
            u[p, k] = value / ke[p, p]


@kernel
def gather(points, cell, x):
    """Fill x (nn, 3) with the node positions of a cell."""
    for a in range(len(cell)):
        for k in range(3):
            x[a, k] = points[cell[a], k]


@kernel
def assemble_stiffness(points, cells, dn, w, di, dc, c9, start, indices, data):
    """Add the stiffness of all cells to the CSR values `data`, N/m."""
    nn = cells.shape[1]
    nt = nn + di.shape[1]
    ke, gram, x = np.empty((3 * nt, 3 * nt)), np.empty((nt, nt, 9)), np.empty((nn, 3))
    for e in range(len(cells)):
        gather(points, cells[e], x)
        stiffness_matrix(x, dn, w, di, dc, c9, gram, ke)
        condense(ke, 3 * nn)
        scatter_blocks(start, indices, cells[e], ke, data)


@kernel
def assemble_mass(points, cells, value, dn, w, density, lumped, start, indices, data):
    """Add the scalar mass of all cells to the node pattern, kg, eq. (fe-mass); lumped: eq. (fe-lumping)."""
    nn = cells.shape[1]
    me, x, inverse = np.empty((nn, nn)), np.empty((nn, 3)), np.empty((3, 3))
    for e in range(len(cells)):
        gather(points, cells[e], x)
        me[:] = 0.0
        for q in range(len(w)):
            factor = density * w[q] * inverse_jacobian(x, dn[q], inverse)
            for a in range(nn):
                for b in range(nn):
                    me[a, b] += factor * value[q, a] * value[q, b]
        if lumped:
            total, trace = 0.0, 0.0
            for a in range(nn):
                trace += me[a, a]
                for b in range(nn):
                    total += me[a, b]
            for a in range(nn):
                for b in range(nn):
                    me[a, b] *= total / trace if a == b else 0.0
        scatter_scalar(start, indices, cells[e], me, data)


@kernel
def jacobian_range(points, cells, dn, low, high, size):
    """Fill smallest and largest det dx/dX of each cell over the given points, and its extent cubed (m3)."""
    nn = cells.shape[1]
    x, inverse = np.empty((nn, 3)), np.empty((3, 3))
    for e in range(len(cells)):
        gather(points, cells[e], x)
        extent = 0.0
        for a in range(nn):
            for k in range(3):
                extent = max(extent, abs(x[a, k] - x[0, k]))
        size[e] = extent**3
        low[e], high[e] = np.inf, -np.inf
        for q in range(len(dn)):
            det = inverse_jacobian(x, dn[q], inverse)
            low[e], high[e] = min(low[e], det), max(high[e], det)


@kernel
def point_stress(points, cells, dn_at, di_at, dn, w, di, dc, c9, elasticity, u, stress):
    """Fill stress (ne, np, 6, k), Pa, at the points with gradients dn_at, for displacements u (n, 3, k), m.

    The incompatible modes follow the nodal displacements by the condensation of the element, eq. (fe-condense).
    """
    nn, ni, cases = cells.shape[1], di.shape[1], u.shape[2]
    nt = nn + ni
    x, inverse, centre, g = np.empty((nn, 3)), np.empty((3, 3)), np.empty((3, 3)), np.empty((nt, 3))
    ue, strain = np.empty((3 * nt, cases)), np.empty((6, cases))
    ke, gram = np.empty((3 * nt, 3 * nt)), np.empty((nt, nt, 9))
    for e in range(len(cells)):
        gather(points, cells[e], x)
        for a in range(nn):
            for i in range(3):
                for k in range(cases):
                    ue[3 * a + i, k] = u[cells[e, a], i, k]
        det_centre = 1.0
        if ni:
            stiffness_matrix(x, dn, w, di, dc, c9, gram, ke)
            condense(ke, 3 * nn)
            amplitudes(ke, 3 * nn, ue)
            det_centre = inverse_jacobian(x, dc, centre)
        for q in range(len(dn_at)):
            det = inverse_jacobian(x, dn_at[q], inverse)
            transform(dn_at[q], inverse, 1.0, 0, g)
            transform(di_at[q], centre, det_centre / det, nn, g)
            strain[:] = 0.0
            for a in range(nt):
                gx, gy, gz = g[a, 0], g[a, 1], g[a, 2]
                for k in range(cases):
                    ux, uy, uz = ue[3 * a, k], ue[3 * a + 1, k], ue[3 * a + 2, k]
                    strain[0, k] += gx * ux
                    strain[1, k] += gy * uy
                    strain[2, k] += gz * uz
                    strain[3, k] += gy * ux + gx * uy
                    strain[4, k] += gz * uy + gy * uz
                    strain[5, k] += gx * uz + gz * ux
            for i in range(6):
                for k in range(cases):
                    value = 0.0
                    for j in range(6):
                        value += elasticity[i, j] * strain[j, k]
                    stress[e, q, i, k] = value


@kernel
def nodal_sum(cells, extrapolation, stress, total, count):
    """Add the stress continued from the stress points to the nodes of each cell, and count the cells per node."""
    for e in range(len(cells)):
        for a in range(cells.shape[1]):
            node = cells[e, a]
            count[node] += 1
            for q in range(stress.shape[1]):
                for i in range(6):
                    for k in range(stress.shape[3]):
                        total[node, i, k] += extrapolation[a, q] * stress[e, q, i, k]


@kernel
def scalar_geometric_stiffness(points, cells, dn, w, stress, start, indices, data):
    """Add int G_a . sigma G_b of one load case, stress (ne, nq, 6, 1), to the node pattern, eq. (fe-geometric)."""
    nn = cells.shape[1]
    ke, x, inverse, g = np.empty((nn, nn)), np.empty((nn, 3)), np.empty((3, 3)), np.empty((nn, 3))
    for e in range(len(cells)):
        gather(points, cells[e], x)
        ke[:] = 0.0
        for q in range(len(w)):
            factor = w[q] * inverse_jacobian(x, dn[q], inverse)
            transform(dn[q], inverse, 1.0, 0, g)
            s = stress[e, q]
            for b in range(nn):
                tx = factor * (s[0, 0] * g[b, 0] + s[3, 0] * g[b, 1] + s[5, 0] * g[b, 2])
                ty = factor * (s[3, 0] * g[b, 0] + s[1, 0] * g[b, 1] + s[4, 0] * g[b, 2])
                tz = factor * (s[5, 0] * g[b, 0] + s[4, 0] * g[b, 1] + s[2, 0] * g[b, 2])
                for a in range(nn):
                    ke[a, b] += g[a, 0] * tx + g[a, 1] * ty + g[a, 2] * tz
        scatter_scalar(start, indices, cells[e], ke, data)


@kernel
def modal_gradient_products(points, cells, dn, w, modes, products):
    """Fill products (ne nq 6, pairs) = w det sum_i of d_j phi_a,i d_k phi_b,i for jk = xx, yy, zz, xy, yz, zx.

    modes (n, 3, m); pairs a <= b counted row by row. Times the stress and summed, this is eq. (fe-projected).
    """
    nn, m = cells.shape[1], modes.shape[2]
    x, inverse, g, h = np.empty((nn, 3)), np.empty((3, 3)), np.empty((nn, 3)), np.empty((3, 3, m))
    row = 0
    for e in range(len(cells)):
        gather(points, cells[e], x)
        for q in range(len(w)):
            factor = w[q] * inverse_jacobian(x, dn[q], inverse)
            transform(dn[q], inverse, 1.0, 0, g)
            h[:] = 0.0
            for a in range(nn):
                for i in range(3):
                    for j in range(3):
                        for k in range(m):
                            h[i, j, k] += g[a, j] * modes[cells[e, a], i, k]
            pair = 0
            for a in range(m):
                for i in range(3):
                    hx, hy, hz = factor * h[i, 0, a], factor * h[i, 1, a], factor * h[i, 2, a]
                    for b in range(a, m):
                        p = pair + b - a
                        products[row, p] += hx * h[i, 0, b]
                        products[row + 1, p] += hy * h[i, 1, b]
                        products[row + 2, p] += hz * h[i, 2, b]
                        products[row + 3, p] += hx * h[i, 1, b] + hy * h[i, 0, b]
                        products[row + 4, p] += hy * h[i, 2, b] + hz * h[i, 1, b]
                        products[row + 5, p] += hx * h[i, 2, b] + hz * h[i, 0, b]
                pair += m - a
            row += 6
