"""CB01: free-free frequencies of a planar beam against the number of fixed-interface modes.

Source: validation case CB01 (20 cubic Hermite elements, consistent mass); Craig & Bampton, AIAA J. 6 (1968) 1313.
"""

import numpy as np
import pytest
from reduction.beams import planar_beam

from flexmb import reduction

TOLERANCE = 1e-8  # of the case: deterministic linear algebra


@pytest.mark.parametrize("count", [0, 2, 4, 6, 8, 10])
def test_reduced_frequencies(reference, count):
    case = reference("CB01")["reference"]
    expected = np.array(case["reduced"][str(count)]["f_Hz"])
    data = reduction.reduce(planar_beam(), {"a": "left", "b": "right"}, modes=count)
    assert data.n_modes == 4 - case["n_zero"] + count  # the two rigid modes are gone
    assert data.quality["rigid_modes"]["removed"] == case["n_zero"]
    np.testing.assert_allclose(data.frequencies[: len(expected)], expected, rtol=TOLERANCE)


def test_full_and_fixed_interface_frequencies(reference):
    case = reference("CB01")["reference"]
    data = reduction.reduce(planar_beam(), {"a": "left", "b": "right"}, modes=10, compare=6)
    full = [row["full"] for row in data.quality["frequencies"]]
    np.testing.assert_allclose(full, case["full_elastic_Hz"], rtol=TOLERANCE)
    np.testing.assert_allclose(
        data.quality["fixed_interface_frequencies"][:6], case["fixed_interface_Hz"], rtol=TOLERANCE
    )


def test_errors_are_positive_and_fall_with_every_mode():
    errors = np.array(
        [
            [
                row["error"]
                for row in reduction.reduce(planar_beam(), {"a": "left", "b": "right"}, modes=count).quality[
                    "frequencies"
                ][:2]
            ]
            for count in range(11)
        ]
    )
    assert np.all(errors >= -1e-10)
    assert np.all(np.diff(errors, axis=0) <= 1e-10)
