"""Dead centres by name: parallelograms, whose places are known in closed form, with their bars in one line."""

import warnings

import numpy as np
import pytest
from verification.mechanisms import four_bar_places, four_bars

import flexmb as fmb
from flexmb.errors import IntegrationError
from flexmb.system import assemble
from flexmb.system.dead_centre import joints_at_dead_centre


def joints_there(n: int, angle: float) -> list[str]:
    """Return the joints of n parallelograms that are told where the cranks have turned by an angle from upright."""
    system, state = assemble(four_bars(n))
    half = 0.5 * (np.pi / 2.0 - angle)
    for k in range(n + 1):
        state.q[system.body_slices[f"c{k}"][0]] = (k, 0, 0, np.cos(half), 0, 0, np.sin(half))
    for k in range(n):
        state.q[system.body_slices[f"b{k}"][0]] = (k + np.sin(angle), np.cos(angle), 0, 1, 0, 0, 0)
    return joints_at_dead_centre(system, state, system.workspace())


@pytest.mark.parametrize("n", [1, 2])
@pytest.mark.parametrize("off", [0.0, 1e-9, -1e-6, 1e-4])
def test_bars_in_one_line(n, off):
    assert set(joints_there(n, np.pi / 2.0 + off)) >= {"g0", "l0", "r0", "g1"}


@pytest.mark.parametrize("n", [1, 2])
@pytest.mark.parametrize("angle", [0.0, 0.5, 1.4, np.pi / 2.0 + 0.1, 3.0])
def test_other_places_are_none(n, angle):
    assert joints_there(n, angle) == []


def test_a_state_that_is_no_number_is_none():
    assert joints_there(1, np.nan) == []


@pytest.mark.slow
def test_explicit_steps_name_the_dead_centre():
    """All bars lie in one line at t = 0.7144 s: the closed equation of the one freedom."""
    assert four_bar_places(2, 0.71436)[3, 1] == pytest.approx(0.0, abs=1e-4)
    told = r"dead centre near t = 0\.7143\d* s.*\(.*l0.*\).*step size fell below.*Recursive\(\)"
    with warnings.catch_warnings():  # of its pace
        warnings.simplefilter("ignore", fmb.SlowRunWarning)
        with pytest.raises(IntegrationError, match=told):
            fmb.simulate(four_bars(2), 1.0, integrator=fmb.Explicit())


def test_joint_coordinates_pass_it():
    solution = fmb.simulate(four_bars(2), 1.0, integrator=fmb.Explicit(formulation=fmb.Recursive()))
    np.testing.assert_allclose(solution["B0"][-1, :2], four_bar_places(2, 1.0)[3, :2], atol=1e-9)
