"""The point of a curve nearest to a given one, also where the distance hardly bends: near the centre of curvature."""

import numpy as np
import pytest

from flexmb.math.splines import nearest_parameter, pack_spline

X = np.linspace(-2.0, 2.0, 401)
CURVE = pack_spline(np.column_stack([X, 0.5 * X**2, 0.0 * X]), closed=False)  # centre of curvature (0, 1, 0)


@pytest.mark.parametrize("height", [-1.0, 0.0, 0.5, 0.75, 0.9, 0.97, 1.0, 1.1, 2.0])
@pytest.mark.parametrize("side", [-0.3, 0.01, 0.2])
def test_the_distance_is_stationary_and_least(height, side):
    """The nearest point of y = x^2 / 2 solves x^3 / 2 + (1 - height) x = side; the start is on the point's side."""
    roots = np.roots([0.5, 0.0, 1.0 - height, -side])
    wanted = min(roots[np.isreal(roots)].real, key=lambda x: (x - side) ** 2 + (0.5 * x**2 - height) ** 2)
    middle, out, point = 0.5 * CURVE[int(CURVE[0])], np.empty((4, 6)), np.array([side, height, 0.0])
    nearest_parameter(CURVE, point, middle + np.sign(side) * 0.5, False, -1, out)
    assert abs(out[1, :3] @ (point - out[0, :3])) < 1e-13
    assert out[0, 0] == pytest.approx(wanted, abs=1e-6)  # how close the spline is to the parabola
