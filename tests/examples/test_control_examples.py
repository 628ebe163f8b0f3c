"""The skyhook damper against its closed form, and flutter against the determinant with Theodorsen's function."""

from __future__ import annotations

from importlib import util
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import newton

import flexmb as fmb


def example(name: str):
    path = Path(__file__).parents[2] / "examples" / f"{name}.py"
    spec = util.spec_from_file_location(name, path)
    module = util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_skyhook_has_the_transmissibility_of_the_closed_form():
    found = example("skyhook").main()
    assert found["sky"] < 1e-12
    assert found["passive"] < 1e-12
    assert abs(found["run"]) < 1e-6


def test_flutter_speed_is_that_of_the_determinant():
    found = example("flutter").main()
    assert found["speed"] == pytest.approx(found["Jones"], rel=1e-8)
    assert found["frequency"] == pytest.approx(found["Jones frequency"], rel=1e-8)
    assert found["speed"] == pytest.approx(found["Theodorsen"], rel=0.01)


def test_the_section_grows_beyond_flutter_and_settles_below():
    """A run tells the same as the eigenvalues: growth over a second, 7 % below and above."""

    flutter = example("flutter")
    for speed in (0.93 * 54.259, 1.07 * 54.259):
        rate, frequency = flutter.growth(speed)
        half = np.pi / frequency
        run = fmb.simulate(
            flutter.section(speed, pitch=1e-5),  # 240 times as much in the end
            24 * half,
            samples=np.arange(24 * 40 + 1) * half / 40,
            integrator=fmb.Implicit(),
        )
        early, late = (np.abs(run["a"][40 * k : 40 * (k + 2)]).sum() for k in (14, 22))
        assert np.log(late / early) == pytest.approx(8 * half * rate, abs=5e-3)


def test_the_controller_of_the_tip_is_unstable_from_the_gain_of_theory_on():
    """The model has four elements, theory is the beam itself; the controller of the hub never drives a mode."""
    found = example("flexible_arm").main()
    assert found["gain"] == pytest.approx(found["theory"], rel=1e-3)
    assert found["frequency"] == pytest.approx(found["theory frequency"], rel=1e-3)
    assert found["hub"] < 0.0


@pytest.mark.parametrize("elements", [2, 6, 12])
def test_slow_motions_beside_fast_dampers_are_no_zeros(elements):
    """The arm turns at 4.2 rad/s on its controller, beside a pole of -8e7 1/s of the axial damping."""
    arm = example("flexible_arm")
    s = newton(lambda s: arm.characteristic(s, 1.0, tip=False) / s**2, -2.4 + 4.2j, tol=1e-12)
    found = fmb.linearize(arm.arm(1.0, tip=False, elements=elements)).eigenvalues
    assert np.abs(found - s).min() < 2e-4 * abs(s)
    assert np.abs(found).min() > 1.0


@pytest.mark.parametrize("gain", [1e-3, 1e-2])
def test_soft_controllers_of_fine_meshes_are_no_zeros(gain):
    """The arm turns at 0.15 rad/s, beside a strip whose elements would ring at 1e7 rad/s."""
    arm = example("flexible_arm")
    guess = np.roots([0.0426, gain * arm.LEAD, gain])[0]
    s = newton(lambda s: arm.characteristic(s, gain, tip=False) / s**2, guess, tol=1e-12)
    found = fmb.linearize(arm.arm(gain, tip=False, elements=12)).eigenvalues
    assert np.abs(found - s).min() < 1e-5 * abs(s)
    assert np.abs(found).min() > 0.9 * abs(s)


def test_the_hand_of_an_arm_approaches_its_goal_as_a_critically_damped_oscillator():
    """But for the half sample by which held torques lag behind: errors fall with it."""
    _, computed, expected = example("task_space_control").main(0.3)
    assert np.abs(computed - expected).max() < 3e-3 * computed[0]
