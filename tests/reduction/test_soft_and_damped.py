"""Bodies with hinges, soft springs and dampers inside, and bands that nobody means."""

from dataclasses import replace

import numpy as np
import pytest
from reduction.solids import STEEL, block
from scipy import sparse

from flexmb import fem, reduction
from flexmb.errors import ReductionError

SECTION = fem.Section.rectangle(0.02, 0.03)
ENDS = {"a": [0], "b": [17]}


def two_beams(push, turn):
    """Two beams of 1 m, joined end to end by springs of stiffness `push`, N/m, and `turn`, N m/rad."""
    x = np.concatenate([np.linspace(0.0, 1.0, 9), np.linspace(1.0, 2.0, 9)])
    pairs = [(k, k + 1) for k in range(17) if k != 8]
    fe = fem.frame(np.column_stack([x, 0.0 * x, 0.0 * x]), connectivity=pairs, section=SECTION, material=STEEL)
    return fem.with_spring(fe, 8, (push, push, push, turn, turn, turn), to=9)


@pytest.mark.parametrize("basis", ["CraigBampton", "Rubin", "Krylov", "CharacteristicModes", "Balanced"])
def test_a_hinge_between_interfaces_is_named_with_every_basis(basis):
    with pytest.raises(ReductionError, match=r"a mechanism: node \d+ at .* without strain energy.*a hinge"):
        reduction.reduce(two_beams(1e9, 0.0), ENDS, basis=basis)


@pytest.mark.parametrize(("push", "turn"), [(1e9, 1e-3), (1e3, 1e-3)])
def test_attachment_modes_are_exact_in_statics_beside_soft_springs(push, turn):
    """Responses in which a soft joint moves a million times as far as the beams bend keep the bending: 18 shapes, of 6
    modes and 12 loads, and statics as exact as the matrices of the interfaces."""
    data = reduction.reduce(two_beams(push, turn), ENDS, 6, basis="Rubin")
    assert data.n_modes == 18
    assert data.quality["static_error"] < 1e-8
    same = reduction.reduce(two_beams(push, turn), ENDS, 40)
    assert data.frequencies[:6] == pytest.approx(same.frequencies[:6], rel=1e-4)


def opening(damper):
    """Two beams on a yoke with a damper, N s/m, between their ends, and unit forces that open the fork, (ndof, 1)."""
    x, y = np.linspace(0.0, 1.0, 11), np.linspace(0.0, 0.3, 11)[1:-1]
    lower, upper = (np.column_stack([x, 0.0 * x + h, 0.0 * x]) for h in (0.0, 0.3))
    points = np.vstack([lower[::-1], np.column_stack([0.0 * y, y, 0.0 * y]), upper])
    fe = fem.frame(points, section=SECTION, material=STEEL, name="fork")
    apart = np.zeros((fe.ndof, 1))
    apart[[1, 6 * (len(points) - 1) + 1]] = [[-1.0], [1.0]]
    return replace(fe, C=sparse.csr_matrix(damper * apart @ apart.T)), apart


@pytest.mark.parametrize(("damper", "told"), [(1.0, False), (10.0, False), (200.0, True), (1000.0, True)])
def test_dampers_that_couple_modes_are_told(damper, told):
    """Response of the opening to its own forces, against the matrices of all freedoms with the damper as it is."""
    fe, apart = opening(damper)
    last = len(fe.nodes) - 1
    data = reduction.reduce(fe, {"one": [0], "other": [last]}, 40)
    basis = np.linalg.qr(fe.M @ fe.rigid_motions(), mode="complete")[0][:, 6:]
    K, M, C = (basis.T @ (matrix @ basis) for matrix in (fe.K, fe.M, fe.C))
    load, shape = basis.T @ apart, data.marker_translations[1, 1] - data.marker_translations[0, 1]
    own = np.diag(2.0 * data.damping_ratios * np.sqrt(np.diag(data.stiffness)))
    error = 0.0
    for w in 2.0 * np.pi * np.linspace(5.0, 95.0, 40):
        full = (load.T @ np.linalg.solve(K - w**2 * M + 1j * w * C, load)).item()
        found = shape @ np.linalg.solve(data.stiffness - w**2 * data.invariants.nn + 1j * w * own, shape)
        error = max(error, abs(found - full) * w * damper)  # of the damper's force, over the force that opens
    assert (error > 0.1) == told
    assert any("couple modes" in text and "SpringDamper" in text for text in data.quality["warnings"]) == told


def test_a_ratio_that_takes_the_place_of_dampers_is_told():
    fe, _ = opening(5.0)
    ends = {"one": [0], "other": [len(fe.nodes) - 1]}
    data = reduction.reduce(fe, ends, 4, damping=0.01)
    assert data.damping_ratios == pytest.approx(0.01)
    assert "damping=0.01 takes their place" in data.quality["warnings"][-1]
    assert not any("dampers" in text for text in reduction.reduce(fe, ends, 4).quality["warnings"])
    still = reduction.reduce(replace(fe, C=None), ends, 4, damping=0.01)
    assert not any("dampers" in text for text in still.quality["warnings"])


def test_a_band_with_more_modes_than_anyone_means_is_refused(monkeypatch):
    monkeypatch.setattr("flexmb.reduction.framed_body.MOST_KNOWN", 20)
    for asked in ({"error_up_to": 1e6}, {"modes": "up to 1000 kHz within 1 %"}, {"basis": reduction.Krylov(1e6)}):
        with pytest.raises(ReductionError, match=r"more than 20 elastic modes below .* frequencies are in Hz"):
            reduction.reduce(opening(0.0)[0], {"one": [0]}, **asked)


def test_the_report_says_where_the_response_is_largest_and_how_far_off_it_is_elsewhere():
    """A soft joint makes the largest response; 1 % of it says nothing of the bending of the beams."""
    data = reduction.reduce(two_beams(1e9, 1.0), ENDS, 2, error_up_to=100.0, compare=0)
    told = data.quality["transfer"]
    error, response = np.array(told["error"]), np.array(told["response"])
    assert told["relative"] < 0.05
    assert (error / response).max() > 0.3
    line = next(line for line in data.report().splitlines() if line.startswith("  response "))
    assert f"largest at {told['frequencies'][int(response.argmax())]:.4g} Hz" in line
    assert f"at most {100.0 * (error / response).max():.3g} % of the response at the same frequency" in line


@pytest.mark.parametrize("basis", ["CraigBampton", "Rubin", "CharacteristicModes"])
def test_a_solid_that_nothing_loads_has_its_free_modes(basis):
    """The elimination of a mesh is asked for no response at all."""
    solid = block((0.4, 0.06, 0.04), (12, 3, 2))
    free = fem.eigenmodes(solid, n=10).frequencies[6:]
    data = reduction.reduce(solid, {}, 4, basis=basis, compare=0, stress=False)
    assert data.frequencies == pytest.approx(free, rel=1e-6)
