"""The damping of a contact for a coefficient of restitution far from one: by integration of the law itself."""

import pytest
from scipy.integrate import solve_ivp

import flexmb as fmb
from flexmb.errors import ModelError


@pytest.mark.parametrize("exponent", [1.0, 1.5])
@pytest.mark.parametrize("restitution", [0.2, 0.5, 0.8])
def test_a_body_bounces_back_as_asked(restitution, exponent):
    """m p'' = -k p^n (1 + c p') from p = 0 at the speed v until p = 0 again, by Runge-Kutta of order eight."""
    speed, k, m = 2.0, 1e6, 0.5
    c = fmb.Contact.damping_for(restitution, speed)

    def rates(t, y):
        return [y[1], -k / m * max(y[0], 0.0) ** exponent * (1.0 + c * y[1])]

    def leaves(t, y):
        return y[0] if t > 0.0 else 1.0

    leaves.terminal, leaves.direction = True, -1
    found = solve_ivp(rates, (0.0, 1.0), [0.0, speed], method="DOP853", events=leaves, rtol=1e-11, atol=1e-14)
    assert -found.y_events[0][0][1] == pytest.approx(restitution * speed, rel=1e-6)


def test_near_one_it_is_the_formula_of_hunt_and_crossley():
    assert fmb.Contact.damping_for(0.999, 3.0) == pytest.approx(1.5 * 0.001 / 3.0, rel=2e-3)
    assert fmb.Contact.damping_for(1.0, 3.0) == 0.0
    for wrong in ((0.0, 1.0), (1.1, 1.0), (0.5, 0.0), ("x", 1.0)):
        with pytest.raises(ModelError, match="0 < restitution <= 1"):
            fmb.Contact.damping_for(*wrong)
