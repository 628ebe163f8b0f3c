"""Van der Pol's oscillator of mu = 5 over a period: rest and fast changes by turns.

Reference: SciPy's DOP853 at rtol = 1e-12 on the one equation x'' = mu (1 - x^2) x' - x.
"""

import numpy as np
import pytest
import scipy.integrate

import flexmb as fmb

MU, END = 5.0, 12.0


def oscillator():
    axes = fmb.Pose.axes(at=(0, 0, 0), z=(1, 0, 0), x=(0, 1, 0))
    body = fmb.RigidBody("b", mass=1.0, inertia=(1, 1, 1), at=(2.0, 0, 0), markers={"c": axes})
    effort = fmb.formula("mu * (1 - x**2) * rate(x) - x", over={"x": "x"}, mu=MU)
    return fmb.Model(
        bodies=[fmb.Ground(markers={"g": axes}), body],
        joints=[fmb.Prismatic("s", markers=("ground.g", "b.c"))],
        forces=[fmb.Actuator("f", joint="s", effort=effort)],
        sensors=[fmb.JointCoordinate("x", joint="s")],
    )


def exact(times):
    rates = lambda _, y: (y[1], MU * (1.0 - y[0] ** 2) * y[1] - y[0])  # noqa: E731
    found = scipy.integrate.solve_ivp(rates, (0.0, times[-1]), (2.0, 0.0), "DOP853", times, rtol=1e-12, atol=1e-14)
    return found.y[0]


@pytest.mark.parametrize(
    ("integrator", "error"),
    [
        (fmb.GeneralizedAlpha(), 2e-2),
        (fmb.Implicit(), 2e-3),
        (fmb.IDA(), 6e-3),
        (fmb.IDA(rtol=1e-9, atol=1e-11), 2e-5),
        (fmb.Explicit(), 1e-8),
    ],
    ids=["GeneralizedAlpha", "Implicit", "IDA", "IDA at 1e-9", "Explicit"],
)
def test_places_at_tolerances(integrator, error, recwarn):
    """Within half a percent of the motion by default, and closer by closer tolerances; no warning."""
    times = np.linspace(0.0, END, 121)
    run = fmb.simulate(oscillator(), END, samples=len(times), integrator=integrator)
    np.testing.assert_allclose(run["x"], exact(times), rtol=0.0, atol=error)
    assert not [one for one in recwarn if issubclass(one.category, fmb.errors.ValidityWarning)]


def test_differences_of_radau_do_not_outgrow_numbers(monkeypatch):
    """Three hundred matrices make them 1e300 times as long where nothing depends; here they begin as long as that."""

    class Late(scipy.integrate.Radau):
        def __init__(self, *given, **named):
            super().__init__(*given, **named)
            self.jac_factor = np.full(self.n, 1e307)

    times = np.linspace(0.0, 1.0, 11)
    expected = exact(times)
    monkeypatch.setattr(scipy.integrate, "Radau", Late)
    run = fmb.simulate(oscillator(), 1.0, samples=len(times), integrator=fmb.Explicit(method="Radau", rtol=1e-6))
    np.testing.assert_allclose(run["x"], expected, rtol=0.0, atol=1e-5)
