"""K, M and K_g of the compiled kernels against scikit-fem's own forms and against the textbook B-matrix."""

import numpy as np
import pytest
import skfem
from fem.structured import CELL_TYPES, structured
from scipy.spatial import cKDTree
from skfem.helpers import ddot, dot, grad, sym_grad, trace
from tolerances import MACHINE

from flexmb import fem
from flexmb.fem.solids.elements import SOLID_ELEMENTS, rule, shape_functions
from flexmb.model.material import Material

pytestmark = pytest.mark.filterwarnings("ignore::flexmb.fem.meshes.mesh.MeshWarning")

MATERIAL = Material(young=3.0, poisson=0.31, density=2.0)
LAME = MATERIAL.elasticity[0, 1]
WITH_SKFEM = [name for name in CELL_TYPES if SOLID_ELEMENTS[name].basis]
COMPATIBLE = {"hexahedron": fem.HEX8_COMPATIBLE, "wedge": fem.WEDGE6_COMPATIBLE}


def bent(points):
    """A smooth curved shape, so that second-order cells are truly curved."""
    x, y, z = points.T
    return np.column_stack([x + 0.08 * y * z, y + 0.1 * np.sin(x), z - 0.05 * x * y])


def mesh_for(cell_type):
    # scikit-fem maps 20-node hexahedra by their corners only: straight edges there.
    curved = cell_type in ("tetra10", "hexahedron27", "tetra")
    return structured(cell_type, (2, 1, 2), skew=0.2, curve=bent if curved else None)


def skfem_basis(mesh, order):
    """Vector basis of scikit-fem with our integration rule, and the place of each of our freedoms in it."""
    ((cell_type, cells),) = mesh.cells
    element = SOLID_ELEMENTS[cell_type]
    cls = {
        "tetra": skfem.MeshTet,
        "tetra10": skfem.MeshTet2,
        "hexahedron27": skfem.MeshHex2,
        "wedge": skfem.MeshWedge1,
    }.get(cell_type, skfem.MeshHex)
    if element.family == "hexahedron":
        from skfem.io.meshio import INV_HEX_MAPPING

        n = 27 if cell_type == "hexahedron27" else 8
        order_of_nodes = INV_HEX_MAPPING[:n]
        used, new = np.unique(cells[:, :n], return_inverse=True)
        t, p = new.reshape(-1, n)[:, order_of_nodes], mesh.points[used]
    else:
        t, p = cells, mesh.points
    their_mesh = cls(np.ascontiguousarray(p.T), np.ascontiguousarray(t.T))
    scalar_element = getattr(skfem, element.basis)()
    points, weights = rule(element.family, order)
    quadrature = (np.ascontiguousarray(points.T), weights)
    scalar = skfem.Basis(their_mesh, scalar_element, quadrature=quadrature)
    vector = skfem.Basis(their_mesh, skfem.ElementVector(scalar_element), quadrature=quadrature)
    # Freedoms of a vector basis: local numbers run node by node, three components each.
    node_of = np.empty(vector.N, int)
    component = np.empty(vector.N, int)
    # doflocs interpolates linearly between corners on curved cells: match by the isoparametric position instead.
    where = scalar.mapping.F(scalar_element.doflocs.T)  # (3, ne, nn)
    distance, nearest = cKDTree(mesh.points).query(where.reshape(3, -1).T)
    assert distance.max() < 1e-9
    nearest = nearest.reshape(where.shape[1:])
    for i in range(scalar_element.doflocs.shape[0]):
        for k in range(3):
            node_of[vector.element_dofs[3 * i + k]] = nearest[:, i]
            component[vector.element_dofs[3 * i + k]] = k
    ours = np.empty(vector.N, int)
    ours[3 * node_of + component] = np.arange(vector.N)
    return vector, ours


def difference(a, b):
    return abs(a - b).max() / abs(b).max()


@pytest.mark.parametrize("cell_type", WITH_SKFEM)
def test_stiffness_equals_scikit_fem(cell_type):
    mesh = mesh_for(cell_type)
    basis, ours = skfem_basis(mesh, SOLID_ELEMENTS[cell_type].stiffness_order)

    @skfem.BilinearForm
    def stiffness(u, v, w):
        e = sym_grad(u)
        return 2.0 * MATERIAL.shear * ddot(e, sym_grad(v)) + LAME * trace(e) * trace(sym_grad(v))

    fe = fem.solid(mesh, MATERIAL, elements=COMPATIBLE)
    assert difference(fe.K, stiffness.assemble(basis)[ours][:, ours]) < MACHINE


@pytest.mark.parametrize("cell_type", WITH_SKFEM)
def test_mass_equals_scikit_fem(cell_type):
    mesh = mesh_for(cell_type)
    basis, ours = skfem_basis(mesh, SOLID_ELEMENTS[cell_type].mass_order)
    mass = skfem.BilinearForm(lambda u, v, w: MATERIAL.density * dot(u, v)).assemble(basis)
    assert difference(fem.solid(mesh, MATERIAL).M, mass[ours][:, ours]) < MACHINE


@pytest.mark.parametrize("cell_type", WITH_SKFEM)
def test_geometric_stiffness_equals_scikit_fem(cell_type, rng):
    mesh = mesh_for(cell_type)
    basis, ours = skfem_basis(mesh, SOLID_ELEMENTS[cell_type].stiffness_order)
    fe = fem.solid(mesh, MATERIAL, elements=COMPATIBLE)
    u = rng.standard_normal(fe.ndof)
    theirs = np.empty_like(u)
    theirs[ours] = u

    @skfem.BilinearForm
    def initial_stress(a, b, w):
        e = (grad(w["u"]) + np.swapaxes(grad(w["u"]), 0, 1)) / 2.0
        sigma = 2.0 * MATERIAL.shear * e + LAME * trace(e) * np.eye(3)[:, :, None, None]
        return ddot(np.einsum("ki...,ij...->kj...", grad(a), sigma), grad(b))

    reference = initial_stress.assemble(basis, u=basis.interpolate(theirs))[ours][:, ours]
    (block,) = fe.blocks
    found = block.geometric_stiffness(fe.field(u)[:, :, 0], fe.dofs)
    assert difference(found, reference) < MACHINE


def test_stiffness_and_mass_of_the_wedge_with_15_nodes():
    """scikit-fem lacks this element: textbook B-matrix (Zienkiewicz & Taylor, The Finite Element Method)."""
    mesh = structured("wedge15", (1, 2, 1), skew=0.2, curve=bent)
    element = SOLID_ELEMENTS["wedge15"]
    fe = fem.solid(mesh, MATERIAL)
    k, m = np.zeros((fe.ndof, fe.ndof)), np.zeros((fe.ndof, fe.ndof))
    for row in mesh.cells[0][1]:
        freedoms = (3 * row[:, None] + np.arange(3)).ravel()
        for order, matrix in ((element.stiffness_order, k), (element.mass_order, m)):
            points, weights = rule("wedge", order)
            for value, gradient, w in zip(*shape_functions(element, points), weights):
                jacobian = gradient.T @ mesh.points[row]
                g = np.linalg.solve(jacobian, gradient.T)
                b = np.zeros((6, 45))
                for i, (p, q) in enumerate(((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0))):
                    b[i, p::3] = g[q]
                    b[i, q::3] = g[p]
                n = np.kron(value, np.eye(3))
                part = b.T @ MATERIAL.elasticity @ b if matrix is k else MATERIAL.density * n.T @ n
                matrix[np.ix_(freedoms, freedoms)] += w * np.linalg.det(jacobian) * part
    assert difference(fe.K.toarray(), k) < MACHINE
    assert difference(fe.M.toarray(), m) < MACHINE


@pytest.mark.parametrize("cell_type", CELL_TYPES)
def test_shape_functions_are_one_at_their_node_and_their_gradients_agree(cell_type, rng):
    """The 15-node wedge included: partition of unity, Kronecker property, gradient against a central difference."""
    element = SOLID_ELEMENTS[cell_type]
    value, _ = shape_functions(element, element.nodes)
    assert np.abs(value - np.eye(len(value))).max() < MACHINE
    at = rng.uniform(0.1, 0.3, (4, 3))
    gradient = shape_functions(element, at)[1]
    h = 1e-5
    for k in range(3):
        step = h * np.eye(3)[k]
        central = (shape_functions(element, at + step)[0] - shape_functions(element, at - step)[0]) / (2 * h)
        assert np.abs(central - gradient[:, :, k]).max() < 1e-8
