"""CB02: a reduced body is exact in statics for interface loads, whatever the number of modes.

Source: validation case CB02; closed form of the cantilever,
w = F L^3 / 3 EI + M L^2 / 2 EI, slope = F L^2 / 2 EI + M L / EI.
"""

import numpy as np
import pytest
from reduction.beams import planar_beam

from flexmb import reduction

TOLERANCE = 1e-9  # of the case: constraint modes are exact for interface loads


def held_at_a(data, tip_load):
    """Deflection (uy, rz) at b relative to the frame of a: rigid motion plus modes, a held by its two freedoms."""
    L = data.marker_positions[1, 0]
    shapes = np.vstack([data.marker_translations[:, 1], data.marker_rotations[:, 2]])  # y at a, b; rotation at a, b
    rigid = np.array([[1, 0], [1, L], [0, 1], [0, 1]], float)
    G = np.hstack([rigid, shapes])
    K = np.zeros((G.shape[1], G.shape[1]))
    K[2:, 2:] = data.stiffness
    hold, tip = G[[0, 2]], G[[1, 3]]
    saddle = np.block([[K, hold.T], [hold, np.zeros((2, 2))]])
    return tip @ np.linalg.solve(saddle, np.concatenate([tip.T @ tip_load, np.zeros(2)]))[: G.shape[1]]


@pytest.mark.parametrize("count", [0, 1, 5, 12])
def test_tip_deflection_is_exact(reference, count):
    case = reference("CB02")["reference"]
    data = reduction.reduce(planar_beam(), {"a": "left", "b": "right"}, modes=count)
    found = held_at_a(data, np.array([100.0, -3.0]))
    np.testing.assert_allclose(found, case["closed_form"], rtol=TOLERANCE)
    np.testing.assert_allclose(found, case["tip"], rtol=TOLERANCE)


@pytest.mark.parametrize("count", [0, 5])
def test_mass_and_its_moments(reference, count):
    case = reference("CB02")["reference"]
    data = reduction.reduce(planar_beam(), {"a": "left", "b": "right"}, modes=count)
    moments = [data.invariants.vv[1, 1], data.invariants.vw0[1, 2], data.invariants.ww0[2, 2]]
    np.testing.assert_allclose(moments, list(case["rigid_transverse"].values()), rtol=TOLERANCE)
    np.testing.assert_allclose(data.mass, case["mass"], rtol=TOLERANCE)
