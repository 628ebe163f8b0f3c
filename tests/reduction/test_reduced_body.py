"""The reduced body against the FE model it came from: rigid modes, mass, statics, frequencies, body mass matrix."""

import numpy as np
import pytest
from reduction.beams import planar_beam
from reduction.solids import block
from scipy.linalg import eigh
from scipy.sparse.linalg import splu
from tolerances import MACHINE

from flexmb import fem, reduction
from flexmb.model.material import Material
from flexmb.reduction.loads import load_vectors

STEEL = Material(young=210e9, poisson=0.3, density=7850.0)


@pytest.fixture(scope="module")
def fe():
    return block()


@pytest.fixture(scope="module")
def data(fe):
    return reduction.reduce(fe, {"a": "left", "b": "right"}, modes=8)


def skew_frame():
    points = np.linspace((0.0, 0.0, 0.0), (0.6, 0.2, -0.1), 11)
    return fem.frame(points, section=fem.Section.rectangle(0.02, 0.03), material=STEEL)


def test_six_rigid_modes_are_removed(fe, data):
    assert data.n_modes == 2 * 6 + 8 - 6
    assert data.frequencies.min() > 100.0
    assert data.quality["rigid_modes"]["removed"] == 6


def test_buckens_conditions(fe, data):
    """E^T M Phi = 0, (PX)^T M Phi = 0, Phi^T M Phi = I, Phi^T K Phi = diag(w2) (Buckens frame)."""
    phi = fe.vectors(np.concatenate([data.shapes, np.zeros_like(data.shapes)], axis=1))
    rigid = fe.rigid_motions()
    scale = np.sqrt(np.diag(rigid.T @ (fe.M @ rigid)))
    assert np.abs(rigid.T @ (fe.M @ phi) / scale[:, None]).max() < MACHINE
    assert np.abs(phi.T @ (fe.M @ phi) - np.eye(data.n_modes)).max() < 1e3 * MACHINE
    stiffness = phi.T @ (fe.K @ phi)
    scale = np.sqrt(np.diag(data.stiffness))
    assert np.abs((stiffness - data.stiffness) / np.outer(scale, scale)).max() < 1e4 * MACHINE


def test_mass_properties_are_those_of_the_mesh(data):
    """Closed form of the homogeneous block 0.4 x 0.06 x 0.04 m."""
    a, b, c = 0.4, 0.06, 0.04
    mass = 7850.0 * a * b * c
    np.testing.assert_allclose(data.mass, mass, rtol=1e-10)
    np.testing.assert_allclose(data.center_of_mass, [a / 2, b / 2, c / 2], rtol=1e-10)
    expected = mass / 12.0 * np.diag([b * b + c * c, a * a + c * c, a * a + b * b])
    np.testing.assert_allclose(data.inertia, expected, atol=1e-10 * expected.max())


def test_frequencies_bound_those_of_the_full_model_from_above(fe, data):
    """Dense solution of the full model without any coupling; the rigid ends and the few modes only stiffen it."""
    exact = np.sqrt(eigh(fe.K.toarray(), fe.M.toarray(), eigvals_only=True)[6:12]) / (2 * np.pi)
    error = data.frequencies[:5] / exact[:5] - 1.0
    assert np.all(error > 0.0)
    assert np.all(error < 0.02)


def test_reported_full_frequencies_are_those_of_the_model_with_rigid_ends(fe, data):
    """The rigid coupling is part of the model compared with: T^T K T, T^T M T solved densely."""
    T = rigid_ends(fe)
    exact = np.sqrt(eigh(T.T @ (fe.K @ T), T.T @ (fe.M @ T), eigvals_only=True)[6:12]) / (2 * np.pi)
    found = [row["full"] for row in data.quality["frequencies"]]
    np.testing.assert_allclose(found, exact, rtol=1e-9)
    errors = [row["error"] for row in data.quality["frequencies"]]
    np.testing.assert_allclose(errors, data.frequencies[:6] / exact - 1.0, atol=1e-9)


def rigid_ends(fe):
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


def test_statics_is_exact_at_the_interfaces(fe, data):
    """End force and moment on b, a held: the displacement of b equals a direct sparse solution of the full model."""
    T = rigid_ends(fe)
    inner = T.shape[1] - 12
    K = T.T @ (fe.K @ T)
    free = np.r_[np.arange(inner), inner + 6 + np.arange(6)]
    load = np.zeros(len(free))
    load[-6:] = [100.0, -40.0, 70.0, 3.0, -5.0, 2.0]
    exact = np.linalg.solve(K[np.ix_(free, free)], load)[-6:]
    np.testing.assert_allclose(held_response(data, load[-6:]), exact, rtol=1e-8, atol=1e-8 * np.abs(exact).max())


def held_response(data, load):
    """Motion of marker b under a load on b, marker a held: rigid motion of the frame plus modes."""
    motion = []
    for number in range(2):
        arm = data.marker_positions[number]
        rigid = np.eye(6)
        rigid[:3, 3:] = np.column_stack([np.cross(axis, arm) for axis in np.eye(3)])
        modes = np.vstack([data.marker_translations[number], data.marker_rotations[number]])
        motion.append(np.hstack([rigid, modes]))
    K = np.zeros((motion[0].shape[1],) * 2)
    K[6:, 6:] = data.stiffness
    saddle = np.block([[K, motion[0].T], [motion[0], np.zeros((6, 6))]])
    return motion[1] @ np.linalg.solve(saddle, np.r_[motion[1].T @ load, np.zeros(6)])[: len(K)]


def test_clamped_and_buckens_frame_give_the_same_statics(fe):
    load = np.array([100.0, -40.0, 70.0, 3.0, -5.0, 2.0])
    responses = [
        held_response(reduction.reduce(fe, {"a": "left", "b": "right"}, modes=4, frame=frame), load)
        for frame in ("buckens", "a", "b")
    ]
    for other in responses[1:]:
        np.testing.assert_allclose(other, responses[0], rtol=1e-9, atol=1e-9 * np.abs(responses[0]).max())


def test_clamped_frame_has_no_motion_at_its_interface(fe):
    data = reduction.reduce(fe, {"a": "left", "b": "right"}, modes=4, frame="a")
    assert data.frame == "a"
    assert np.abs(data.marker_translations[0]).max() < MACHINE
    assert np.abs(data.marker_rotations[0]).max() < 1e2 * MACHINE
    T = rigid_ends(fe)
    keep = np.r_[np.arange(T.shape[1] - 12), T.shape[1] - 6 + np.arange(6)]
    T = T[:, keep]
    exact = np.sqrt(eigh(T.T @ (fe.K @ T), T.T @ (fe.M @ T), eigvals_only=True)[:4]) / (2 * np.pi)
    np.testing.assert_allclose(data.frequencies[:4], exact, rtol=0.01)
    assert np.all(data.frequencies[:4] >= exact * (1 - 1e-10))


@pytest.mark.parametrize("frame", ["buckens", "a"])
def test_body_mass_matrix_is_the_polynomial(frame, rng):
    """M_b(eta) from the ten invariants against V^T M V with V = [E | P (X + Phi eta) | Phi] built directly (solids)."""
    fe = block()
    data = reduction.reduce(fe, {"a": "left", "b": "right"}, modes=5, frame=frame)
    phi = fe.vectors(np.concatenate([data.shapes, np.zeros_like(data.shapes)], axis=1))
    eta = 0.05 * rng.standard_normal(data.n_modes) / np.abs(data.shapes).max()
    moved = fe.nodes + data.shapes @ eta
    rotation = np.zeros((len(fe.nodes), 6, 3))
    for k, axis in enumerate(np.eye(3)):
        rotation[:, :3, k] = np.cross(axis, moved)
        rotation[:, 3 + k, k] = 1.0
    V = np.hstack([fe.rigid_motions()[:, :3], fe.vectors(rotation), phi])
    expected = V.T @ (fe.M @ V)
    found = body_mass_matrix(data.invariants, eta)
    scale = np.sqrt(np.diag(expected))
    assert np.abs((found - expected) / np.outer(scale, scale)).max() < MACHINE


def body_mass_matrix(i, eta):
    vw = i.vw0 + np.einsum("j,jab->ab", eta, i.vw1)
    ww = i.ww0 + np.einsum("j,jab->ab", eta, i.ww1) + np.einsum("j,k,jkab->ab", eta, eta, i.ww2)
    wn = i.wn0 + np.einsum("j,jab->ab", eta, i.wn1)
    return np.block([[i.vv, vw, i.vn], [vw.T, ww, wn], [i.vn.T, wn.T, i.nn]])


def test_frame_mass_properties():
    """Slender rod along a skew line: m L^2 / 12 about its centre, plus the section's own inertia about its axis."""
    fe = skew_frame()
    data = reduction.reduce(fe, {"a": "start", "b": "end"}, modes=4)
    length = np.linalg.norm([0.6, 0.2, -0.1])
    mass = 7850.0 * 0.02 * 0.03 * length
    np.testing.assert_allclose(data.mass, mass, rtol=1e-10)
    np.testing.assert_allclose(data.center_of_mass, [0.3, 0.1, -0.05], rtol=1e-10)
    polar = 7850.0 * length * 0.02 * 0.03 * (0.02**2 + 0.03**2) / 12
    np.testing.assert_allclose(np.trace(data.inertia), 2 * mass * length**2 / 12 + 2 * polar, rtol=1e-9)


def test_guyan_keeps_constraint_modes_only(fe):
    data = reduction.reduce(fe, {"a": "left", "b": "right"}, modes=0)
    assert data.n_modes == 6
    assert data.quality["normal_modes"] == 0


def test_bodies_without_or_with_weak_interfaces_keep_their_exact_modes(fe):
    """No interface: the shapes are the free-free modes themselves."""
    exact = np.sqrt(eigh(fe.K.toarray(), fe.M.toarray(), eigvals_only=True)[6:14]) / (2 * np.pi)
    data = reduction.reduce(fe, {}, modes=8)
    np.testing.assert_allclose(data.frequencies, exact, rtol=1e-9)
    node = reduction.reduce(fe, {"a": reduction.Nodes([3])}, modes=12)
    assert node.n_modes == 3 + 12
    np.testing.assert_allclose(node.frequencies[:3], exact[:3], rtol=1e-4)


def test_modes_by_accuracy_of_frequencies_meet_the_accuracy_and_no_less_modes_do():
    fe = planar_beam()
    data = reduction.reduce(fe, {"a": "left", "b": "right"}, modes="up to 400 Hz within 0.2 % of the frequencies")
    exact = np.sqrt(eigh(fe.K.toarray(), fe.M.toarray(), eigvals_only=True)[2:7]) / (2 * np.pi)
    error = data.frequencies[:5] / exact - 1.0
    assert exact[4] < 400.0
    assert error.max() < 0.002
    fewer = reduction.reduce(fe, {"a": "left", "b": "right"}, modes=data.quality["normal_modes"] - 1)
    assert (fewer.frequencies[:5] / exact - 1.0).max() > 0.002


def test_residual_vector_makes_a_distributed_load_exact(fe):
    """Static deflection of b under pressure with a held, against a sparse solution of the full model."""
    data = reduction.reduce(
        fe,
        {"a": reduction.Rigid("left"), "b": reduction.Averaging("right")},
        modes=2,
        loads={"air": "top"},
        residual_vectors=["air"],
        frame="a",
    )
    q = data.load_shapes[0, 6:] / np.diag(data.stiffness)
    free = np.flatnonzero(~np.isin(fe.dofs[:, 0], fe.node_set("left")))
    F = load_vectors(fe, {"air": "top"})[free, 0]
    u = np.zeros(fe.ndof)
    u[free] = splu(fe.K[free][:, free].tocsc()).solve(F)
    exact = fe.field(u)[:, :3, 0]
    assert np.abs(data.shapes @ q - exact).max() < 1e-8 * np.abs(exact).max()
    without = reduction.reduce(
        fe, {"a": "left", "b": reduction.Averaging("right")}, modes=2, loads={"air": "top"}, frame="a"
    )
    plain = without.shapes @ (without.load_shapes[0, 6:] / np.diag(without.stiffness))
    assert np.abs(plain - exact).max() > 1e-5 * np.abs(exact).max()


def test_stress_modes_give_the_stress_of_a_pulled_bar(fe):
    """Uniaxial tension through averaging ends: sigma_xx = F / A away from the ends, the others vanish."""
    data = reduction.reduce(
        fe, {"a": reduction.Averaging("left"), "b": reduction.Averaging("right")}, modes=6, frame="a"
    )
    force = 1000.0
    q = force * data.marker_translations[1, 0] / np.diag(data.stiffness)
    stress = data.stress_modes @ q
    middle = fe.node_set("mid")
    np.testing.assert_allclose(stress[middle, 0], force / (0.06 * 0.04), rtol=2e-2)
    assert np.abs(stress[middle, 1:]).max() < 2e-2 * force / (0.06 * 0.04)


@pytest.mark.parametrize("scale", [1.0, 1e-2, 1e-4])
def test_residual_vector_of_a_small_load_on_a_small_block(scale):
    """1 Pa on a steel block of any size: its response is kept, as that of 1 MPa is (splu of the full model)."""
    small = block(tuple(scale * x for x in (0.4, 0.06, 0.04)))
    options = {"modes": 2, "frame": "a", "compare": 0, "loads": {"air": "top"}}
    data = reduction.reduce(small, {"a": "left"}, residual_vectors=["air"], **options)
    assert data.n_modes == reduction.reduce(small, {"a": "left"}, **options).n_modes + 1
    free = np.flatnonzero(~np.isin(small.dofs[:, 0], small.node_set("left")))
    u = np.zeros(small.ndof)
    u[free] = splu(small.K[free][:, free].tocsc()).solve(load_vectors(small, {"air": "top"})[free, 0])
    exact = small.field(u)[:, :3, 0]
    q = data.load_shapes[0, 6:] / np.diag(data.stiffness)
    assert np.abs(data.shapes @ q - exact).max() < 1e-8 * np.abs(exact).max()
