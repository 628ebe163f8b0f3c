"""The slider-crank of FM03 as one floating body, as several, and in absolute nodal coordinates, stiff and soft.

Reference of the stiff one: FM03, a geometrically exact rod. Of the soft ones: cable and beam elements, two formulations
that share no element, against each other; they know no limit of deflection.
"""

import warnings

import numpy as np
import pytest
from by_turns import slow
from verification.soft_crank import ROD, TIMES, ancf, bow, floating

import flexmb as fmb

RODS = {
    "one": floating(1),
    "three": floating(3),
    "six": floating(6),
    "cable": ancf(fmb.AncfCable, 12),
    "beam": ancf(fmb.AncfBeam, 8),
}


def difference(rod, exact, softness):
    """Return the largest difference relative to the largest deflection;
    floating bodies may warn that it is too much.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", fmb.ValidityWarning)
        return np.abs(bow(rod, softness) - exact).max() / np.abs(exact).max()


@pytest.mark.parametrize("name", ["one", slow("three"), slow("six"), "cable", "beam"])
def test_all_agree_on_the_stiff_rod(reference, name):
    """0.6 % of the length: 2 % of the largest deflection, the tolerance of the case."""
    case = reference("FM03")["reference"]
    expected = np.array([row["mid_transverse"] for row in case.values()])
    at = [int(np.argmin(np.abs(TIMES - float(t)))) for t in case]
    np.testing.assert_allclose(bow(RODS[name], 1.0)[at], expected, atol=0.02 * np.abs(expected).max())


@pytest.mark.slow
def test_deflection_of_seven_percent():
    """One linear body errs by percents, six of them and the beam by 1 %."""
    exact = bow(RODS["cable"], 10.0)
    assert np.abs(exact).max() == pytest.approx(0.068 * ROD, rel=0.02)
    assert 0.03 < difference(RODS["one"], exact, 10.0) < 0.1
    assert difference(RODS["six"], exact, 10.0) < 0.015
    assert difference(RODS["beam"], exact, 10.0) < 0.02


def test_deflection_of_a_quarter():
    """One body is plainly wrong, and the run says so; six bodies and the beam are within 6 %."""
    exact = bow(ancf(fmb.AncfCable, 24), 20.0)
    assert np.abs(exact).max() == pytest.approx(0.267 * ROD, rel=0.02)
    with pytest.warns(fmb.ValidityWarning) as told:
        found = bow(RODS["one"], 20.0)
    assert any("Body 'rod_1' deforms by" in str(warning.message) for warning in told)
    assert np.abs(found - exact).max() > 0.5 * np.abs(exact).max()
    assert difference(RODS["six"], exact, 20.0) < 0.06
    assert difference(RODS["beam"], exact, 20.0) < 0.06
