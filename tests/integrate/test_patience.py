"""How many steps compiled loops may take before they come back: as many as a slice of time needs, however many samples
they come back for besides."""

import numpy as np
import pytest

import flexmb as fmb
from flexmb.integrate.runs import patience, phases
from flexmb.integrate.runs.patience import Patience

ALONG_X = fmb.Pose.axes((0, 0, 0), z=(1, 0, 0))
FOLLOWING = 3.0 - 1.5 * fmb.measured(fmb.Acceleration("a", marker="cart.x"))
"""A force that follows the acceleration: samples are for Python to find."""
SAMPLES = 31


class Clock:
    """A clock on which every call takes a tenth of a slice."""

    def __init__(self):
        self.t = 0.0

    def perf_counter(self) -> float:
        self.t += 0.1 * patience.SLICE
        return self.t


def cart(effort) -> fmb.Model:
    """Return a cart on a rail with a motor."""
    return fmb.Model(
        bodies=[
            fmb.Ground(markers={"x": ALONG_X}),
            fmb.RigidBody("cart", mass=2.0, inertia=(1, 1, 1), markers={"x": ALONG_X}),
        ],
        joints=[fmb.Prismatic("rail", markers=("ground.x", "cart.x"))],
        forces=[fmb.Actuator("motor", joint="rail", effort=effort)],
    )


@pytest.mark.parametrize(
    ("integrator", "effort"),
    [
        (fmb.Implicit(step=1e-3), FOLLOWING),
        (fmb.Explicit(), 3.0),
        (fmb.Explicit(formulation=fmb.NullSpace()), 3.0),
    ],
    ids=repr,
)
def test_samples_allow_no_more_steps(integrator, effort, monkeypatch):
    """A call that ends at a sample has not used its steps: that it was short says nothing about so many.

    None of the methods takes more than ten steps between samples.
    """
    allowed, steps = [], Patience.steps

    def told(pace, **how):
        allowed.append(steps(pace, **how))
        return allowed[-1]

    monkeypatch.setattr(patience, "time", Clock())
    monkeypatch.setattr(Patience, "steps", told)
    monkeypatch.setattr(phases, "PATIENCE", 1e6)
    run = fmb.simulate(cart(effort), 0.3, samples=SAMPLES, integrator=integrator)
    assert run.status.ok
    assert 1 <= max(allowed) <= 40


def test_calls_that_use_their_steps_grow_and_long_ones_shrink(monkeypatch):
    clock = Clock()
    monkeypatch.setattr(patience, "time", clock)
    pace = Patience(1e6)
    assert [pace.steps() for _ in range(3)] == [1, 4, 16]
    assert [pace.steps(used=False) for _ in range(30)] == [16] * 30
    clock.t += 3.9 * patience.SLICE  # a call that took four slices
    assert pace.steps(used=False) == 4
    assert pace.steps() == 16


def test_without_a_limit_one_call_does_all():
    assert Patience(np.inf).steps(used=False) == np.iinfo(np.int64).max
