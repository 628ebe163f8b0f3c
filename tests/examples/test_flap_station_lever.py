"""The lever of the flap station: what the reduced body has in common with the mesh it came from.

References: the mesh integrated by scikit-fem (mass, inertia); SciPy's ARPACK and SuperLU on the full K and M.
"""

from pathlib import Path

import numpy as np
import pytest
from scipy.sparse.linalg import LinearOperator, eigsh, splu

import flexmb as fmb
from flexmb import fem, reduction

MESH = Path(fmb.__file__).parent / "cli" / "demo_data" / "lever_arm.msh"
TITANIUM = fmb.MATERIALS["titanium"]


@pytest.fixture(scope="module")
def fe():
    return fem.solid(fem.read_mesh(MESH), TITANIUM)


@pytest.fixture(scope="module")
def data(fe):
    bores = {"root": reduction.Averaging("bore_root"), "tip": reduction.Averaging("bore_tip")}
    return reduction.reduce(fe, interfaces=bores, modes=12)


def test_the_packaged_mesh_is_that_of_the_repository():
    repository = Path(__file__).parents[2] / "meshes" / "lever_arm.msh"
    assert MESH.read_bytes() == repository.read_bytes()


def test_mass_and_inertia(fe, data):
    """Data set: 24 kg. Moments of the mesh by quadrature: m = sum w rho det J, and so on."""
    from skfem import ElementTetP2, MappingIsoparametric, MeshTet2
    from skfem.quadrature import get_quadrature

    mesh = MeshTet2(*_skfem_arrays(fe))
    points, weights = get_quadrature(ElementTetP2, 8)
    mapping = MappingIsoparametric(mesh, ElementTetP2())
    x = mapping.F(points)
    dm = TITANIUM.density * np.abs(mapping.detDF(points)) * weights
    mass = dm.sum()
    assert data.mass == pytest.approx(24.0, rel=1e-5)
    assert data.mass == pytest.approx(mass, rel=1e-10)
    center = np.einsum("ief,ef->i", x, dm) / mass
    np.testing.assert_allclose(data.center_of_mass, center, atol=1e-10)
    second = np.einsum("ief,jef,ef->ij", x - center[:, None, None], x - center[:, None, None], dm)
    inertia = np.trace(second) * np.eye(3) - second
    np.testing.assert_allclose(data.inertia, inertia, atol=1e-10 * inertia.max())


def _skfem_arrays(fe):
    """Nodes and cells in scikit-fem's order: corners, then the edges 01 12 02 03 13 23 (as Gmsh and VTK have them)."""
    (block,) = fe.blocks
    return fe.nodes.T.copy(), block.connectivity.T.copy()


def test_six_rigid_modes_are_gone(fe, data):
    """12 interface freedoms + 12 modes - 6; what is left has neither momentum nor moment of momentum."""
    assert data.n_modes == 18
    assert data.frequencies.min() > 500.0
    U = np.zeros((fe.ndof, 6))
    node, direction = fe.dofs[:, 0], fe.dofs[:, 1]
    U[np.arange(fe.ndof), direction] = 1.0
    for k in range(3):
        U[:, 3 + k] = np.cross(np.eye(3)[k], fe.nodes[node])[np.arange(fe.ndof), direction]
    shapes = data.shapes[node, direction]
    momentum = U.T @ (fe.M @ shapes)
    scale = np.sqrt(np.outer(np.diag(U.T @ (fe.M @ U)), np.diag(data.invariants.nn)))
    assert np.abs(momentum / scale).max() < 1e-9
    assert np.abs(fe.K @ U).max() < 1e-9 * np.abs(fe.K).max()


def test_frequencies_of_the_full_model(fe, data):
    """First six elastic frequencies of the free mesh, 29640 freedoms: within 1 %."""
    shift = -((2 * np.pi * 100.0) ** 2)
    lu = splu(
        (fe.K - shift * fe.M).tocsc(),
        permc_spec="MMD_AT_PLUS_A",
        diag_pivot_thresh=0.0,
        options={"SymmetricMode": True},
    )
    inverse = LinearOperator(fe.K.shape, lu.solve)
    w2 = np.sort(eigsh(fe.K, 12, fe.M, sigma=shift, OPinv=inverse, return_eigenvectors=False))
    full = np.sqrt(w2[6:]) / (2 * np.pi)
    assert np.sqrt(np.abs(w2[:6])).max() / (2 * np.pi) < 0.01  # Hz: the rigid ones
    errors = data.frequencies[:6] / full - 1.0
    assert np.all(errors > 0.0)  # Rayleigh-Ritz: from above
    assert errors.max() < 0.01


def test_static_tip_deflection_is_exact(fe, data):
    """40 kN across the tip, root held: against the full mesh under the same loads, spread over the same bores.

    Tip load and root reactions balance each other, so the free mesh is solved with three nodes held without reactions;
    then the mean motion of the root bore is taken off.
    """
    names = ("bore_root", "bore_tip")
    C = np.hstack([_average(fe, fe.node_sets[n], at) for n, at in zip(names, data.marker_positions)])  # q = C^T U
    arm = data.marker_positions[1] - data.marker_positions[0]
    force = np.array([0.0, 0.0, 40e3])
    load = np.concatenate([-force, -np.cross(arm, force), force, np.zeros(3)])
    free = np.setdiff1d(np.arange(fe.ndof), _supports(fe))
    U = np.zeros(fe.ndof)
    lu = splu(
        fe.K[free][:, free].tocsc(), permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True}
    )
    right = (C @ load)[free]
    for _ in range(3):  # refined: the mesh's K has a condition of 1e10
        U[free] += lu.solve(right - (fe.K @ U)[free])
    G = np.vstack(
        [data.marker_translations[0], data.marker_rotations[0], data.marker_translations[1], data.marker_rotations[1]]
    )
    reduced = G @ np.linalg.solve(data.stiffness, G.T @ load)
    full, found = (_tip_against_root(q, arm) for q in (C.T @ U, reduced))
    assert full[2] == pytest.approx(_timoshenko(40e3), rel=0.1)  # the hub is stiffer, the bores give way
    np.testing.assert_allclose(found, full, rtol=0, atol=1e-8 * np.abs(full).max())


def _timoshenko(force):
    """Return the deflection (m) of the tapered web as a cantilever: int F (L - x)^2/(E I) + 1.2 F/(G A) dx."""
    x = np.linspace(0.0, 0.6, 601)
    height, width = 0.14 - 0.05 / 0.6 * x, 0.06
    bending = (0.6 - x) ** 2 / (TITANIUM.young * width * height**3 / 12.0)
    return force * np.trapezoid(bending + 1.2 / (TITANIUM.shear * width * height), x)


def _average(fe, nodes, at):
    """Return the matrix (ndof, 6) of the mean motion of nodes about a point: q = (R^T R)^-1 R^T U."""
    rows = np.flatnonzero(np.isin(fe.dofs[:, 0], nodes))
    arm, direction = fe.nodes[fe.dofs[rows, 0]] - at, fe.dofs[rows, 1]
    R = np.zeros((len(rows), 6))
    R[np.arange(len(rows)), direction] = 1.0
    for k in range(3):
        R[:, 3 + k] = np.cross(np.eye(3)[k], arm)[np.arange(len(rows)), direction]
    mean = np.zeros((fe.ndof, 6))
    mean[rows] = R @ np.linalg.inv(R.T @ R)
    return mean


def _supports(fe):
    """Return six freedoms that hold the mesh and no more: x, y, z; y, z of a node ahead in x; y of one above."""
    wanted = (((0.0, 0.0, 0.0), (0, 1, 2)), ((0.6, 0.0, 0.0), (1, 2)), ((0.0, 0.0, 0.1), (1,)))
    held = []
    for point, directions in wanted:
        node = int(np.argmin(np.linalg.norm(fe.nodes - point, axis=1)))
        held += [int(np.flatnonzero((fe.dofs[:, 0] == node) & (fe.dofs[:, 1] == d))[0]) for d in directions]
    return held


def _tip_against_root(q, arm):
    """Return displacement and rotation of the tip (6,) without the motion of the root."""
    return np.concatenate([q[6:9] - q[:3] - np.cross(q[3:6], arm), q[9:] - q[3:6]])
