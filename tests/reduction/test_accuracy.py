"""How an accuracy is asked for, how it is met, and that its bound lies above the error between all lines."""

from dataclasses import replace

import numpy as np
import pytest
from reduction.beams import planar_beam
from reduction.solids import STEEL, block
from reduction.test_bases import ENDS, at_ends, of_beam, of_floating, relative_error
from scipy import sparse
from scipy.linalg import eigh

from flexmb import fem, reduction
from flexmb.errors import ReductionError


@pytest.fixture(scope="module")
def fe():
    return planar_beam(40)


def test_names_and_numbers_are_read_as_they_are_written(fe):
    said = lambda basis, modes="usual": reduction.reduce(fe, ENDS, modes, basis=basis, compare=0)  # noqa: E731
    assert said("Craig Chang").quality["basis"] == "Rubin()"
    assert said("characteristic constraint modes").quality["basis"].startswith("CharacteristicModes")
    krylov = said("Krylov frequencies=0, 50 order=2").quality["basis"]
    assert krylov == "Krylov(frequencies=(0.0, 50.0), order=2, two_sided=False)"
    assert reduction.Krylov(50.0) == reduction.Krylov((50.0,))
    usual = said("Rubin", "up to 200 Hz within 0.5 %").n_modes
    for text in ("up to .2 kHz, within .5 percent", "up to 200 Hz within 0.5 % of response"):
        assert said("Rubin", text).n_modes == usual
    for text in ("200 Hz", "up to 200 Hz within 0,5 %", "12"):
        with pytest.raises(ReductionError, match="decimals have a point"):
            said("Rubin", text)
    for accuracy in (1.0, 1.5):
        with pytest.raises(ReductionError, match=r"below 1.*0\.01 for 1 %"):
            reduction.UpTo(200.0, accuracy)


@pytest.mark.parametrize("basis", ["CraigBampton", "Rubin", "Krylov", "CharacteristicModes", "Balanced"])
def test_an_accuracy_takes_all_modes_where_there_are_few(basis):
    """One beam element has six elastic modes, fewer than any guess begins with."""
    fe = fem.frame([(0, 0, 0), (1, 0, 0)], section=fem.Section.rectangle(0.02, 0.03), material=STEEL)
    data = reduction.reduce(fe, {"a": [0], "b": [1]}, "up to 5 kHz within 0.01 %", basis=basis, compare=0)
    assert data.n_modes == 6
    assert data.quality["transfer"]["relative"] < 1e-7


def with_three_masses():
    """A beam of ten elements with masses, as of a deck, at its ends and in its middle only."""
    points = np.column_stack([np.linspace(0.0, 1.0, 11), np.zeros((11, 2))])
    fe = fem.frame(points, section=fem.Section.rectangle(0.02, 0.03), material=STEEL)
    at = np.isin(fe.dofs[:, 0], [0, 5, 10])
    mass = np.where(at, np.where(fe.dofs[:, 1] < 3, 1.0, 1e-3), 0.0)
    return replace(fe, M=sparse.csr_matrix(sparse.diags(mass)))


@pytest.mark.parametrize(
    ("basis", "of"),
    [("CraigBampton", " of the frequencies"), ("CraigBampton", ""), ("Rubin", ""), ("CharacteristicModes", "")],
)
def test_an_accuracy_takes_all_modes_with_mass(basis, of):
    """Six modes are all that lie between the ends."""
    ends = {"a": [0], "b": [10]}
    asked = f"up to 5 kHz within 0.01 %{of}"
    data = reduction.reduce(with_three_masses(), ends, asked, basis=basis, error_up_to=5000.0)
    assert data.n_modes <= 12
    assert data.quality["transfer"]["relative"] < 1e-4


@pytest.mark.parametrize("basis", ["CraigBampton", "Rubin", "Krylov", "CharacteristicModes", "Balanced"])
def test_a_basis_that_does_not_grow_any_more_is_told(basis):
    """A load on a node without mass is in no mode: no number of them meets it, and what does is said."""
    given = {"basis": basis, "loads": {"push": {3: (0.0, 0.0, 1.0)}}, "compare": 0}
    asked = {"a": [0]}, "up to 50 Hz within 0.001 %"
    with pytest.raises(ReductionError, match=r"with \d+ (modes, all there are|shapes).*join by residual_vectors"):
        reduction.reduce(with_three_masses(), *asked, **given)


def dense_error(fe, data, zeta, band):
    """Largest error over the largest response on lines that are close everywhere, by dense matrices."""
    full, modal = at_ends(fe, data)
    own = np.sqrt(eigh(fe.K.toarray(), fe.M.toarray(), eigvals_only=True)[2:12]) / (2 * np.pi)
    beside = np.concatenate([own, data.frequencies])[:, None] * (1.0 + zeta * np.linspace(-3.0, 3.0, 61))
    hertz = np.concatenate([np.linspace(0.0, band, 400), beside.ravel()])
    hertz = np.unique(hertz[hertz <= band])
    return relative_error(of_beam(fe, full, hertz, zeta), of_floating(data, modal, hertz, zeta))


@pytest.mark.parametrize("basis", [reduction.Krylov(), reduction.CraigBampton(), reduction.CharacteristicModes(2)])
@pytest.mark.parametrize("zeta", [0.003, 0.01, 0.05])
def test_the_largest_error_lies_at_no_line_that_is_looked_at_first(fe, basis, zeta):
    """Near a resonance that both have apart the error is largest between its middle and its half width."""
    modes = "usual" if isinstance(basis, reduction.Krylov) else 1
    for band in (40.0, 60.0, 120.0):
        data = reduction.reduce(fe, ENDS, modes, basis=basis, error_up_to=band, damping=zeta, compare=0)
        told = data.quality["transfer"]["relative"]
        assert 1.0 - 2e-3 <= told / dense_error(fe, data, zeta, band) <= 10.0


@pytest.mark.parametrize(
    ("damping", "least"),
    [
        (reduction.Rayleigh(2.0, 0.0), lambda w: 1.0 / w.max()),
        (reduction.Rayleigh(0.0, 1e-5), lambda w: 0.5e-5 * w.min()),
        (reduction.Bands(((50.0, 0.03), (90.0, 0.004), (1e4, 0.001))), lambda w: 0.004),
        ([0.02, 0.005, 0.03, 0.01, 0.01, 0.01], lambda w: 0.005),
    ],
)
def test_responses_are_compared_with_the_least_damping_in_the_band(fe, damping, least):
    """Free modes of the beam at 26, 73, 143 Hz: of 4.73, 7.85 and 10.996 squared."""
    data = reduction.reduce(fe, ENDS, 4, damping=damping, error_up_to=100.0, compare=0)
    EI, rhoA = 210e9 * 0.04 * 0.02**3 / 12, 7850.0 * 0.04 * 0.02
    w = np.array([4.730041, 7.853205]) ** 2 / 4.0 * np.sqrt(EI / rhoA)
    assert data.quality["transfer"]["damping"] == pytest.approx(least(w), rel=1e-4)


CALCULIX = {
    50.0: 1.4323971e-7 - 4.5652685e-10j,
    231.0378: 3.0036757e-7 - 9.5623869e-9j,
    295.1286: 1.1649911e-6 - 1.9266947e-7j,
    313.4402: 4.5632839e-9 - 6.7628535e-6j,
    670.2089: -3.2812259e-8 - 4.9182549e-10j,
    1570.505: 1.0441205e-8 - 1.1355215e-9j,
    1808.958: -7.1266813e-8 - 1.4943929e-7j,
    3000.0: -2.3382803e-9 - 6.4679185e-11j,
}
"""m, CalculiX 2.20, the block of the tests (C3D10), clamped at its left face, 1 N along y spread over the nodes of the
right one: mean displacement of these along y, *STEADY STATE DYNAMICS with 100 modes of 1 % modal damping."""


@pytest.mark.parametrize("basis", ["CraigBampton", "Rubin", "Krylov", "CharacteristicModes"])
def test_an_accuracy_is_met_beside_another_program(basis):
    """The 100 modes of CalculiX lack 0.02 % of the static response."""
    places = {"a": "left", "b": reduction.Averaging("right")}
    asked = {"modes": "up to 3000 Hz within 1 %", "basis": basis, "damping": 0.01}
    data = reduction.reduce(block(), places, frame="a", compare=0, stress=False, **asked)
    w, shape = np.sqrt(np.diag(data.stiffness)), data.marker_translations[1, 1]
    hertz = np.array(list(CALCULIX))
    drive = 2.0 * np.pi * hertz[:, None]
    found = np.sum(shape**2 / (w**2 - drive**2 + 2j * 0.01 * w * drive), axis=1)
    exact = np.array(list(CALCULIX.values()))
    assert np.abs(found - exact).max() < 0.01 * np.abs(exact).max()
    assert found[0] == pytest.approx(exact[0], rel=5e-4)
