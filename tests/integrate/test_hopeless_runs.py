"""A run whose end is years away says so, with the state it has reached; any other is left alone."""

import pytest

import flexmb as fmb
from flexmb.integrate.runs import phases


@pytest.fixture
def pendulum():
    bar = fmb.RigidBody("bar", mass=1.0, inertia=(1e-3, 0.1, 0.1), at=(0.5, 0, 0), markers={"A": (-0.5, 0, 0)})
    return fmb.Model(
        gravity=(0, -9.81, 0),
        bodies=[fmb.Ground(markers={"A": (0, 0, 0)}), bar],
        joints=[fmb.Revolute("hinge", markers=("ground.A", "bar.A"))],
    )


@pytest.mark.parametrize("integrator", [fmb.GeneralizedAlpha(step=1e-3), fmb.GeneralizedAlpha()])
def test_years(pendulum, integrator, monkeypatch):
    monkeypatch.setattr(phases, "TRIED", 0.0)
    monkeypatch.setattr(phases, "STEPS", 100)
    with pytest.raises(
        fmb.IntegrationError, match=r"\d+ steps have reached t = .* would take .* years.*SI units"
    ) as caught:
        fmb.simulate(pendulum, t_end=1e15, samples=10_000_001, integrator=integrator)
    assert 0.0 <= caught.value.solution.t[-1] < 1e12


def test_hours_are_none_of_ours(pendulum, monkeypatch):
    monkeypatch.setattr(phases, "TRIED", 0.0)
    monkeypatch.setattr(phases, "STEPS", 10)
    assert fmb.simulate(pendulum, t_end=2.0, samples=3).status.ok
