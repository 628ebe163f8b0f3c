"""Every kind of FE model is reduced: shells, offset masses, links, foreign matrices, mixtures of freedoms."""

from dataclasses import replace

import numpy as np
import pytest
from reduction.solids import STEEL, block
from scipy.linalg import eigh

from flexmb import fem, reduction

SECTION = fem.Section.rectangle(0.02, 0.03)


def beam(n=12):
    return fem.frame(np.linspace((0.0, 0.0, 0.0), (1.0, 0.2, 0.1), n + 1), section=SECTION, material=STEEL)


def plate(n=6):
    x, y = np.meshgrid(np.linspace(0, 0.6, n + 1), np.linspace(0, 0.3, n + 1), indexing="ij")
    number = np.arange((n + 1) ** 2).reshape(n + 1, n + 1)
    quads = np.stack([number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]], axis=-1).reshape(-1, 4)
    mesh = fem.Mesh(
        points=np.column_stack([x.ravel(), y.ravel(), 0 * x.ravel()]),
        cells=(("quad", quads),),
        node_sets={"a": number[0], "b": number[-1]},
    )
    return fem.shell(mesh, STEEL, 0.004)


MODELS = {
    "beam with an offset mass": (lambda: fem.with_mass(beam(), 12, 3.0, (0.1, 0.2, 0.3), (0.1, 0.0, 0.2)), 0, 6),
    "beam with a rigid link": (lambda: fem.with_rigid_link(beam(), 6, [9]), 0, 12),
    "shell": (plate, "a", "b"),
    "matrices of a solid": (lambda: replace(block(), blocks=()), "left", "right"),
}


@pytest.mark.parametrize("kind", MODELS)
def test_frequencies_and_mass_properties(kind):
    """Dense solution of the full model; mass properties from its own rigid motions."""
    model, a, b = MODELS[kind]
    fe = model()
    data = reduction.reduce(fe, {"a": reduction.Averaging(a) if isinstance(a, str) else a, "b": b}, modes=30)
    w2 = eigh(fe.K.toarray(), fe.M.toarray(), eigvals_only=True)
    assert np.abs(w2[:6]).max() < 1e-6 * w2[6]
    exact = np.sqrt(w2[6:9]) / (2 * np.pi)
    tolerance = 1e-3 if not isinstance(a, str) else 0.05  # rigid edges stiffen
    np.testing.assert_allclose(data.frequencies[:3], exact, rtol=tolerance)
    assert np.all(data.frequencies[:3] > exact * (1 - 1e-9))
    rigid = fe.rigid_motions()
    np.testing.assert_allclose(data.mass, rigid[:, 0] @ (fe.M @ rigid[:, 0]), rtol=1e-10)


def test_offset_mass_in_closed_form():
    """Centre of mass and inertia of a slender beam with a point mass on an arm."""
    fe = fem.with_mass(beam(), 12, 3.0, offset=(0.1, 0.0, 0.2))
    data = reduction.reduce(fe, {"a": 0, "b": 6}, modes=4)
    length = np.linalg.norm([1.0, 0.2, 0.1])
    own = 7850.0 * 0.02 * 0.03 * length
    arm = np.array([1.1, 0.2, 0.3])
    np.testing.assert_allclose(data.mass, own + 3.0, rtol=1e-12)
    np.testing.assert_allclose(
        data.center_of_mass, (own * np.array([0.5, 0.1, 0.05]) + 3.0 * arm) / (own + 3.0), rtol=1e-10
    )


def test_station_on_a_linked_node_follows_the_link():
    fe = fem.with_rigid_link(beam(), 6, [9])
    data = reduction.reduce(fe, {"a": 0, "b": 12}, modes=6, stations={"from": [6], "to": [9]})
    one, other = data.marker_names.index("from"), data.marker_names.index("to")
    arm = data.marker_positions[other] - data.marker_positions[one]
    expected = data.marker_translations[one] + np.cross(data.marker_rotations[one].T, arm).T
    np.testing.assert_allclose(data.marker_translations[other], expected, atol=1e-12 * np.abs(expected).max())
    np.testing.assert_allclose(data.marker_rotations[other], data.marker_rotations[one], rtol=1e-12)


def test_foreign_matrices_have_no_stress_and_still_everything_else():
    fe = replace(block(), blocks=())
    data = reduction.reduce(
        fe, {"a": "left", "b": "right"}, modes=4, stations={"p": (0.21, 0.03, 0.021), "n": [5]}, frame="a"
    )
    assert data.stress_modes is None
    assert data.cells == ()
    whole = reduction.reduce(block(), {"a": "left", "b": "right"}, modes=4, frame="a")
    np.testing.assert_allclose(data.frequencies, whole.frequencies, rtol=1e-10)
