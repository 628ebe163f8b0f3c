"""FM02: flexible slider-crank of Simeon (1996) with consistent longitudinal mass; own minimal-coordinate solution."""

import numpy as np
import pytest
from verification.simeon_crank import CRANK, rod_angle, rod_data, slider_crank, start

import flexmb as fmb

BAR_MASS = np.array([[8.0, 1.0], [1.0, 2.0]]) / 15.0


def test_motion(reference):
    """Modal data made by hand from shape functions move like the minimal coordinates."""
    case = reference("FM02")["reference"]
    rod = fmb.FloatingBody("rod", data=rod_data(BAR_MASS), at=(CRANK, 0, 0))
    model = slider_crank(rod, sensors=[fmb.Position("slider", marker="slider.center")])
    solution = fmb.simulate(
        model,
        0.1,
        samples=[0.0, *(float(t) for t in case)],
        start=start(reference("FM01")),
        integrator=fmb.GeneralizedAlpha(rho_inf=0.9, rtol=1e-8),
    )
    q = solution.phases[0].q[1:, 14:18]
    expected = np.array([row["q"] for row in case.values()])
    np.testing.assert_allclose(q, expected, rtol=0, atol=1e-4 * np.abs(expected).max())
    np.testing.assert_allclose(rod_angle(solution)[1:], [row["phi2"] for row in case.values()], rtol=0, atol=1e-6)
    np.testing.assert_allclose(solution["slider"][1:, 0], [row["x3"] for row in case.values()], rtol=0, atol=1e-6)


@pytest.mark.slow
def test_other_integrator(reference):
    case = reference("FM02")["reference"]
    model = slider_crank(fmb.FloatingBody("rod", data=rod_data(BAR_MASS), at=(CRANK, 0, 0)))
    solution = fmb.simulate(
        model,
        0.1,
        samples=[0.0, *(float(t) for t in case)],
        start=start(reference("FM01")),
        integrator=fmb.IDA(rtol=1e-8, atol=1e-10),
    )
    expected = np.array([row["q"] for row in case.values()])
    np.testing.assert_allclose(solution.phases[0].q[1:, 14:18], expected, rtol=0, atol=1e-8)
