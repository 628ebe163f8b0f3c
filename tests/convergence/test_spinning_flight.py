"""A ball that spins while it flies: the parabola r = v t + g t^2 / 2, whatever the spin.

The velocity of a body has components in its own axes, in which that of a spinning ball goes round; a step sees h w of a turn.
"""

import numpy as np
import pytest

import flexmb as fmb

SPIN, TIME = 20.0, 2.0


def error(integrator) -> float:
    """Return the distance from the parabola (20 m long) at the end, m."""
    ball = fmb.RigidBody("ball", mass=0.2, inertia=(2e-4,) * 3, velocity=(1.0, 0, 0), angular_velocity=(0, SPIN, 0))
    model = fmb.Model(gravity=(0, 0, -9.81), bodies=[fmb.Ground(), ball], sensors=[fmb.Position("r", marker="ball.center")])
    solution = fmb.simulate(model, TIME, samples=3, integrator=integrator)
    return float(np.linalg.norm(solution["r"][-1] - [TIME, 0.0, -0.5 * 9.81 * TIME**2]))


def test_generalized_alpha_is_of_second_order_in_the_turn_per_step():
    coarse, fine = (error(fmb.GeneralizedAlpha(step=h)) for h in (1e-3, 5e-4))
    assert coarse / fine == pytest.approx(4.0, rel=0.05)
    assert coarse == pytest.approx(9.6e-3, rel=0.05)  # h w = 0.02; the figure of docs/theory/integrators.md


@pytest.mark.parametrize(("integrator", "bound"), [(fmb.Explicit(), 1e-5), (fmb.IDA(), 2e-3)], ids=["explicit", "IDA"])
def test_methods_of_higher_order_keep_to_the_parabola(integrator, bound):
    assert error(integrator) < bound
