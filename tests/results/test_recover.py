"""Recovery against the formulas written out node by node, and the closed forms of simple stress states."""

import numpy as np
import pytest
from reduction.solids import STEEL, block
from results.spinning import block_data, spinning_model, spinning_phase
from scipy.spatial.transform import Rotation
from tolerances import MACHINE

from flexmb import fem, reduction
from flexmb.errors import ModelError
from flexmb.results import recover


def test_positions_node_by_node(rng):
    data = block_data()
    q = np.hstack([rng.normal(size=(4, 3)), rng.normal(size=(4, 4)), 0.1 * rng.normal(size=(4, 2))])
    q[:, 3:7] /= np.linalg.norm(q[:, 3:7], axis=1)[:, None]
    expected = np.empty((4, 9, 3))
    for k in range(4):
        R = Rotation.from_quat(q[k, 3:7], scalar_first=True).as_matrix()
        for n in range(9):
            expected[k, n] = q[k, :3] + R @ (data.nodes[n] + data.shapes[n] @ q[k, 7:])
    np.testing.assert_allclose(recover.positions(data, q), expected, rtol=0, atol=4 * MACHINE)
    np.testing.assert_allclose(recover.positions(data, q, [8, 2]), expected[:, [8, 2]], rtol=0, atol=4 * MACHINE)


def test_velocities_are_the_rates_of_positions(rng):
    """Central differences of the positions along r' = R v, R' = R w~, eta'."""
    data, h = block_data(), 1e-6
    turn = Rotation.random(random_state=4)
    r, eta, u = rng.normal(size=3), 0.1 * rng.normal(size=2), rng.normal(size=8)

    def position(t):
        p = (turn * Rotation.from_rotvec(t * u[3:6])).as_quat(scalar_first=True)
        return recover.positions(data, np.concatenate([r + t * turn.apply(u[:3]), p, eta + t * u[6:]]))[0]

    q = np.concatenate([r, turn.as_quat(scalar_first=True), eta])
    found = recover.velocities(data, q, u)[0]
    np.testing.assert_allclose(found, (position(h) - position(-h)) / (2 * h), rtol=0, atol=1e-8)
    np.testing.assert_array_equal(recover.velocities(data, q, u, [8, 2])[0], found[[8, 2]])


def test_element_stress_of_a_pulled_block(rng):
    """Axial force 1 kN on 0.06 m x 0.04 m, away from the ends; the nodes show the mean over their cells."""
    fe = block(divisions=(8, 2, 1))
    data = reduction.reduce(fe, interfaces={"left": "left", "right": "right"}, modes=2)
    (solid,) = fe.blocks
    pull = 1e3 * (data.marker_translations[1, 0] - data.marker_translations[0, 0])
    eta = np.linalg.solve(data.stiffness, pull)
    single = recover.element_stress(data, eta, solid)[0]
    middle = np.abs(fe.nodes[solid.connectivity, 0].mean(axis=1) - 0.2) < 0.06
    assert middle.sum() > 2
    np.testing.assert_allclose(single[middle, :, 0], 1e3 / (0.06 * 0.04), rtol=1e-3)
    total, count = np.zeros((len(fe.nodes), 6)), np.zeros(len(fe.nodes))
    np.add.at(total, solid.connectivity, single)
    np.add.at(count, solid.connectivity, 1.0)
    nodal = recover.stress(data, eta)[0]
    np.testing.assert_allclose(total / count[:, None], nodal, atol=1e-10 * np.abs(nodal).max())
    np.testing.assert_array_equal(recover.element_stress(data, eta, solid, [4])[0, 0], single[4])


def test_elements_that_cannot_give_stress():
    data = reduction.reduce(block(), interfaces={"left": "left", "right": "right"}, modes=1)
    beam = fem.frame(points=[(0, 0, 0), (1, 0, 0)], section=fem.Section.rectangle(0.1, 0.1), material=STEEL)
    with pytest.raises(ModelError, match=r"FrameBlock that cannot give it stress.*beams have recover.section_forces"):
        recover.element_stress(data, np.zeros((1, data.n_modes)), beam.blocks[0])


def test_principal_stresses(rng):
    """Simple states, and the invariants of any: trace, sum of squares, and von Mises from the differences."""
    np.testing.assert_allclose(recover.principal([5.0, 0, 0, 0, 0, 0]), [5.0, 0, 0], atol=MACHINE)
    np.testing.assert_allclose(recover.principal([0, 0, 0, 0, 0, 3.0]), [3.0, 0, -3.0], atol=10 * MACHINE)
    sigma = rng.normal(size=(4, 7, 6))
    a, b, c = np.moveaxis(recover.principal(sigma), -1, 0)
    np.testing.assert_allclose(a + b + c, sigma[..., :3].sum(axis=-1), atol=100 * MACHINE)
    von_mises = np.sqrt(0.5 * ((a - b) ** 2 + (b - c) ** 2 + (c - a) ** 2))
    np.testing.assert_allclose(von_mises, recover.von_mises(sigma), rtol=1e-10)


@pytest.mark.parametrize(
    ("sigma", "expected"),
    [
        ((5.0, 0, 0, 0, 0, 0), 5.0),  # uniaxial: the stress itself
        ((0, 0, 0, 0, -2.0, 0), 2.0 * np.sqrt(3.0)),  # pure shear: sqrt(3) tau
        ((7.0, 7.0, 7.0, 0, 0, 0), 0.0),  # hydrostatic: nothing
        ((4.0, -4.0, 0, 0, 0, 0), 4.0 * np.sqrt(3.0)),  # shear at 45 degrees
    ],
)
def test_von_mises_of_simple_states(sigma, expected):
    np.testing.assert_allclose(recover.von_mises(np.array(sigma)[None]), [expected], rtol=MACHINE, atol=MACHINE)


def test_envelope_in_pieces(rng, monkeypatch):
    """Largest over time per node with its time, also when the series goes through in pieces."""
    data = block_data()
    t, eta = np.linspace(0, 1, 23), rng.normal(size=(23, 2))
    all_values = recover.von_mises(recover.stress(data, eta))
    whole = recover.von_mises_envelope(data, t, eta)
    monkeypatch.setattr(recover, "CHUNK", 6 * 9 * 4)
    pieces = recover.von_mises_envelope(data, t, eta)
    for envelope in (whole, pieces):
        np.testing.assert_allclose(envelope.value, all_values.max(axis=0), rtol=MACHINE)
        np.testing.assert_array_equal(envelope.time, t[all_values.argmax(axis=0)])
    np.testing.assert_allclose(recover.largest_von_mises(data, eta), all_values.max(axis=1), rtol=MACHINE)


def test_selected_modes_only():
    """A body that moves with some of its modes is recovered with these."""
    model = spinning_model()
    body = model.body("block").replaced(modes=[1])
    data = recover.modal_data(body)
    np.testing.assert_array_equal(data.shapes, model.body("block").data.shapes[..., [1]])


@pytest.mark.parametrize("modes", ["first", [0, 9], 7, None])
def test_modes_that_cannot_be_selected(modes):
    with pytest.raises(ModelError, match="mode selection"):
        block_data().selected(modes)


def test_messages():
    with pytest.raises(ModelError, match=r"a RigidBody has no modes.*a FloatingBody"):
        recover.modal_data(spinning_model().body("rod"))
    with pytest.raises(ModelError, match=r"there are no stress modes.*fem.solid"):
        recover.stress(block_data(stress=False), np.zeros((1, 2)))
    with pytest.raises(ModelError, match=r"node 9.*0 to 8"):
        recover.displacement(block_data(), np.zeros((1, 2)), [1, 9])


def test_series_names_what_is_missing():
    from flexmb.errors import FlexmbError
    from flexmb.results import Series

    with pytest.raises(FlexmbError, match=r"marker 'rod.ende' does not exist.*Did you mean 'rod.end'\?"):
        Series(spinning_phase()).marker("rod.ende")
