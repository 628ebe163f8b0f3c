"""Guyan's condensation as the special case without normal modes, and stress under interface loads, both against the
full model solved densely."""

import numpy as np
import pytest
from reduction.beams import planar_beam
from reduction.solids import block
from scipy.linalg import eigh
from tolerances import MACHINE

from flexmb import reduction
from flexmb.reduction.loads import load_vectors

ENDS = {"a": "left", "b": "right"}


@pytest.fixture(scope="module")
def fe():
    return block(divisions=(5, 2, 1))


def rigid_ends(fe):
    """Return T: all freedoms from those inside and twelve of the two rigid ends."""
    ends = [fe.node_set("left"), fe.node_set("right")]
    columns = []
    for nodes in ends:
        point = fe.nodes[nodes].mean(axis=0)
        for k in range(6):
            field = np.zeros((len(fe.nodes), 6, 1))
            axis = np.eye(3)[k % 3]
            field[nodes, :3, 0] = axis if k < 3 else np.cross(axis, fe.nodes[nodes] - point)
            columns.append(fe.vectors(field))
    inner = np.flatnonzero(~np.isin(fe.dofs[:, 0], np.concatenate(ends)))
    return np.hstack([np.eye(fe.ndof)[:, inner], *columns])


def condensed(K, M, masters):
    """Guyan 1965: T = [I; -K_ss^-1 K_sm], T^T K T and T^T M T."""
    slaves = np.setdiff1d(np.arange(len(K)), masters)
    T = np.zeros((len(K), len(masters)))
    T[masters] = np.eye(len(masters))
    T[slaves] = -np.linalg.solve(K[np.ix_(slaves, slaves)], K[np.ix_(slaves, masters)])
    return T.T @ K @ T, T.T @ M @ T


def test_no_normal_modes_is_guyan_of_a_beam():
    beam = planar_beam(n_el=6)
    K, M = condensed(beam.K.toarray(), beam.M.toarray(), np.array([0, 1, 12, 13]))
    exact = np.sqrt(eigh(K, M, eigvals_only=True)[2:]) / (2 * np.pi)
    data = reduction.reduce(beam, ENDS, modes=0)
    np.testing.assert_allclose(data.frequencies, exact, rtol=1e-9)


def test_no_normal_modes_is_guyan_of_a_solid(fe):
    T = rigid_ends(fe)
    masters = np.arange(T.shape[1] - 12, T.shape[1])
    K, M = condensed(T.T @ (fe.K @ T), T.T @ (fe.M @ T), masters)
    exact = np.sqrt(eigh(K, M, eigvals_only=True)[6:]) / (2 * np.pi)
    data = reduction.reduce(fe, ENDS, modes=0)
    np.testing.assert_allclose(data.frequencies, exact, rtol=1e-9)


@pytest.mark.parametrize("modes", [0, 4])
def test_stress_under_interface_loads_is_that_of_the_full_model(fe, modes):
    """Force and moment on b with a held: every nodal stress, at the joints too, with any number of normal modes."""
    data = reduction.reduce(fe, ENDS, modes=modes, frame="a", compare=0)
    load = np.array([100.0, -40.0, 70.0, 3.0, -5.0, 2.0])
    T = rigid_ends(fe)
    T = np.delete(T, np.arange(T.shape[1] - 12, T.shape[1] - 6), axis=1)
    force = np.zeros(T.shape[1])
    force[-6:] = load
    u = T @ np.linalg.solve(T.T @ (fe.K @ T), force)
    exact = fe.blocks[0].nodal_stress(fe.field(u))[:, :, 0]
    motion = np.vstack([data.marker_translations[1], data.marker_rotations[1]])
    eta = motion.T @ load / np.diag(data.stiffness)
    np.testing.assert_allclose(data.stress_modes @ eta, exact, rtol=0, atol=1e5 * MACHINE * np.abs(exact).max())


def test_stress_under_a_distributed_load_with_its_residual_vector(fe):
    options = {"modes": 2, "frame": "a", "compare": 0, "loads": {"air": "top"}}
    T = rigid_ends(fe)
    T = np.delete(T, np.arange(T.shape[1] - 12, T.shape[1] - 6), axis=1)
    u = T @ np.linalg.solve(T.T @ (fe.K @ T), T.T @ load_vectors(fe, {"air": "top"})[:, 0])
    exact = fe.blocks[0].nodal_stress(fe.field(u))[:, :, 0]
    errors = []
    for residual in ((), ("air",)):
        data = reduction.reduce(fe, ENDS, residual_vectors=residual, **options)
        stress = data.stress_modes @ (data.load_shapes[0, 6:] / np.diag(data.stiffness))
        errors.append(np.abs(stress - exact).max() / np.abs(exact).max())
    assert errors[1] < 1e5 * MACHINE < errors[0]
