"""Steps that pass over a growth: m x'' = F + d x' leaves every bound, and an implicit formula damps it to nothing."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from by_turns import slow

import flexmb as fmb
from flexmb.integrate import Family

MASS = 2.0
ALONG_X = fmb.Pose.axes((0, 0, 0), z=(1, 0, 0))
X = fmb.JointCoordinate("x", joint="rail")
INTEGRATORS = [fmb.GeneralizedAlpha(), fmb.Implicit(), fmb.IDA(), fmb.Explicit()]


def cart(effort) -> fmb.Model:
    """Return a cart on a rail that an actuator moves."""
    return fmb.Model(
        bodies=[
            fmb.Ground(markers={"x": ALONG_X}),
            fmb.RigidBody("cart", mass=MASS, inertia=(1, 1, 1), markers={"x": ALONG_X}),
        ],
        joints=[fmb.Prismatic("rail", markers=("ground.x", "cart.x"))],
        forces=[fmb.Actuator("motor", joint="rail", effort=effort)],
        sensors=[X],
    )


def fed_back(k: float, d: float):
    """Return 1 N + k x + d x'."""
    return fmb.formula("1 + k*x + d*rate(x)", over={"x": X}, k=k, d=d)


@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize("gain", [1e9, 1e12])
@pytest.mark.filterwarnings("ignore::flexmb.errors.ValidityWarning")
def test_a_gain_far_too_high_ends_the_run(integrator, gain):
    """The speed is F / d (e^(d t / m) - 1): no number after 2 us. The error names force, part, and the time m / d."""
    grows = rf"Body 'cart'.*unstable.*by e every {MASS / gain:.3g} s.*Force 'motor'"
    with pytest.raises(fmb.IntegrationError, match=grows) as caught:
        fmb.simulate(cart(fed_back(0.0, gain)), t_end=1.0, integrator=integrator)
    assert len(caught.value.solution.t) >= 1


@pytest.mark.filterwarnings("ignore::flexmb.errors.ValidityWarning")
def test_a_growth_of_places():
    """x grows as e^(t sqrt(k / m)), 44.7 us."""
    with pytest.raises(fmb.IntegrationError, match=r"by e every 4\.47e-05 s.*passed over it") as caught:
        fmb.simulate(cart(fed_back(1e9, 0.0)), t_end=1.0, samples=11, integrator=fmb.Implicit())
    assert len(caught.value.solution.t) == 11


@pytest.mark.filterwarnings("ignore::flexmb.errors.ValidityWarning")
def test_a_growth_that_swings():
    """A lag T in k x: m T s^3 + m s^2 + k = 0 has a pair of roots to the right, at half the cube root of k / (m T)."""
    k, lag = 1e15, 1e-3
    roots = np.roots([MASS * lag, MASS, 0.0, k])
    assert roots.real.max() > 1e4
    assert abs(roots[roots.real.argmax()].imag) > 1e4
    pushed = fmb.formula("1 - k*y", over={"y": fmb.Lag(fmb.measured("x"), time=lag)}, k=k)
    with pytest.raises(fmb.IntegrationError, match=rf"by e every {1.0 / roots.real.max():.3g} s.*Force 'motor'"):
        fmb.simulate(cart(pushed), t_end=1.0, samples=11, integrator=fmb.Implicit())


@pytest.mark.parametrize("integrator", INTEGRATORS[:3])
@pytest.mark.parametrize(("k", "d"), [(30.0, 0.0), (-1e9, -1e5), (0.0, -1e9)])
def test_what_is_slow_or_stable_runs(integrator, k, d, recwarn):
    """A growth that steps follow, and feedback of the right sign however strong, end the run at its end."""
    solution = fmb.simulate(cart(fed_back(k, d)), t_end=1.0, samples=11, integrator=integrator)
    assert solution.status.ok
    if k > 0.0:
        rate = np.sqrt(k / MASS)
        expected = (np.cosh(rate) - 1.0) / k
        assert solution["x"][-1] == pytest.approx(expected, rel=1e-3)
    if k < 0.0:
        assert solution["x"][-1] == pytest.approx(1.0 / -k, rel=1e-3)


def test_a_growth_within_limits_is_followed():
    """Behind a limit the force is a constant: the cart leaves as x = F t^2 / (2 m), and no growth is left."""
    effort = fmb.Limit(fed_back(0.0, 1e9), limits=(-4.0, 4.0))
    solution = fmb.simulate(cart(effort), t_end=1.0, samples=11, integrator=fmb.IDA())
    assert solution.status.ok


@pytest.mark.parametrize("integrator", INTEGRATORS[:3])
def test_what_nothing_sets_going_stands(integrator):
    """x'' = 9 x from x = 0 stays there: that is no failure, but worth knowing."""
    effort = fmb.formula("k*x", over={"x": X}, k=9.0 * MASS)
    with pytest.warns(fmb.ValidityWarning, match=r"Body 'cart'.*by e every 0\.333 s.*stands still"):
        solution = fmb.simulate(cart(effort), t_end=100.0, samples=11, integrator=integrator)
    assert solution.status.ok
    assert np.abs(solution["x"]).max() == 0.0


@pytest.mark.parametrize("integrator", INTEGRATORS[:3])
def test_a_short_growth_after_a_long_rest_runs(integrator):
    """Held for 100 s, let go for a second: x = F / k (cosh(3) - 1). The time of rest says nothing about it."""
    effort = fmb.formula("1 + k*x", over={"x": X}, k=9.0 * MASS)
    hold = fmb.Event("hold", at=1e-4, then=fmb.Lock("rail"))
    go = fmb.Event("go", at=100.0, then=fmb.Unlock("rail"))
    model = dataclasses.replace(cart(effort), events=[hold, go])
    solution = fmb.simulate(model, t_end=101.0, samples=3, integrator=integrator)
    assert solution.status.ok
    assert solution["x"][-1] == pytest.approx((np.cosh(3.0) - 1.0) / (9.0 * MASS), rel=1e-2)


@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.filterwarnings("ignore::flexmb.errors.ValidityWarning")
def test_a_gain_far_too_high_ends_a_stepped_run(integrator):
    """It is looked at now and then; what was reached before stays."""
    run = fmb.stepper(cart(fed_back(0.0, 1e9)), integrator=integrator)

    def moved_on():
        for _ in range(100):
            run.advance(by=0.01)

    with pytest.raises(fmb.IntegrationError, match=r"Body 'cart'.*unstable.*by e every 2e-09 s.*Force 'motor'"):
        moved_on()
    assert not run.status.ok
    assert len(run.solution.t) >= 1


@pytest.mark.parametrize("integrator", INTEGRATORS[:3])
def test_a_stepped_run_of_one_call_warns(integrator):
    with (
        pytest.warns(fmb.ValidityWarning, match=r"Body 'cart'.*by e every 2e-09 s.*passed over it"),
        fmb.stepper(cart(fed_back(0.0, 1e9)), integrator=integrator) as run,
    ):
        run.advance(to=1.0)


@pytest.mark.parametrize("integrator", [*INTEGRATORS[:2], slow(INTEGRATORS[2]), *INTEGRATORS[3:]])
def test_a_growth_that_is_held_from_outside_runs(integrator, recwarn):
    """x'' = 9 x, and a hand that holds it by 40 x + 12 x', set every 50 ms for 40 s: e^120 by itself."""
    effort = fmb.formula("k*x", over={"x": X}, k=9.0 * MASS) + fmb.input("hand")
    model = dataclasses.replace(cart(effort), sensors=[X, fmb.Velocity("v", marker="cart.x")])
    with fmb.stepper(model, integrator=integrator, keep=False) as run:
        for k in range(800):
            run.set("hand", 0.2 - MASS * (40.0 * run["x"] + 12.0 * run["v"][0]))
            run.advance(to=0.05 * (k + 1))
        assert run["x"] == pytest.approx(0.1 / 31.0, rel=1e-4)  # (40 - 9) x = 0.1
    assert not [str(one.message) for one in recwarn if "unstable" in str(one.message)]


@pytest.mark.parametrize("integrator", INTEGRATORS[:3])
@pytest.mark.filterwarnings("ignore::flexmb.errors.ValidityWarning")
def test_variants_of_an_ensemble_are_looked_at(integrator):
    family = Family()
    assert family.solution(cart(fed_back(0.0, -1e9)), t_end=1.0, integrator=integrator, samples=11).status.ok
    with pytest.raises(fmb.IntegrationError, match=r"Body 'cart'.*by e every 2e-09 s.*passed over it"):
        family.solution(cart(fed_back(0.0, 1e9)), t_end=1.0, integrator=integrator, samples=11)
