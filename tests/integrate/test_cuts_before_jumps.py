"""Cut off just before a block samples: the sample of that time is there in the continued run, which equals the whole.

A time step ends a rounding before the jump. A state that was kept there stood for the sample, and was none.
"""

import os
import signal

import numpy as np
import pytest

import flexmb as fmb
from flexmb.integrate.runs import phases
from flexmb.integrate.runs.marks import meets_at_once

X = fmb.JointCoordinate("x", joint="rail")


def cart() -> fmb.Model:
    """A cart on a rail whose controller samples every 4 ms, two samples of the run."""
    control = fmb.formula("-30*x - 3*rate(x)", over={"x": X})
    return fmb.Model(
        bodies=[fmb.Ground(), fmb.RigidBody("cart", mass=1.0, inertia=(1, 1, 1), at=(0, 0, 0.3))],
        joints=[fmb.Prismatic("rail", markers=("ground.origin", "cart.center"))],
        forces=[fmb.Actuator("push", joint="rail", effort=fmb.Sampled(control, period=0.004))],
        sensors=[X],
    )


def interrupted(number: int, **settings) -> fmb.Solution:
    """Run and press Ctrl-C when the integrator has come back for the so manieth time."""
    calls = iter(range(1, 10_000))

    def progress(t, end):
        if next(calls) == number:
            os.kill(os.getpid(), signal.SIGINT)

    return fmb.simulate(cart(), **settings, progress=progress)


@pytest.mark.parametrize(
    "integrator", [fmb.MoreauJean(step=2e-3), fmb.GeneralizedAlpha(step=2e-3)], ids=lambda i: type(i).__name__
)
def test_no_sample_is_passed_over(integrator, monkeypatch):
    """Cut off after every step near the second sample of the controller, t = 0.004 s."""
    monkeypatch.setattr(phases, "CHUNK", 0.0)  # the run looks up after every mark
    settings = {"t_end": 0.06, "samples": 31, "integrator": integrator}
    whole = fmb.simulate(cart(), **settings)
    seen = set()
    for number in range(2, 7):
        cut = interrupted(number, **settings)
        assert cut.status.kind == "interrupted"
        seen.add(float(cut.final.t))
        rest = fmb.resume(cut, **settings)
        np.testing.assert_array_equal(rest.t, whole.t)
        np.testing.assert_allclose(rest["x"], whole["x"], rtol=0, atol=1e-12)
    assert min(seen) < 0.004 < max(seen)


def test_a_mark_a_rounding_ahead():
    marks = np.array([0.0, 0.5, 1.0])
    assert meets_at_once(marks, 2, 1.0 - 1e-12)
    assert not meets_at_once(marks, 2, 1.0 - 1e-9)
    assert not meets_at_once(marks, 2, 1.0)
    assert not meets_at_once(marks, 3, 1.0)
