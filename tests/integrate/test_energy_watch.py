"""The balance of energy of a run: no false warnings with few samples or with drives, and none missed with drives."""

import warnings

import numpy as np
import pytest
from by_turns import every_second

import flexmb as fmb

INTEGRATORS = {
    "alpha": fmb.GeneralizedAlpha(),
    "IDA": fmb.IDA(),
    "explicit": fmb.Explicit(),
    "recursive": fmb.Explicit(formulation=fmb.Recursive()),
    "implicit": fmb.Implicit(),
}
LENGTH, MASS, G = 1.0, 1.0, 9.81


def pendulum(*joints, **options):
    """Return a slender rod on a hinge, horizontal at first."""
    rod = fmb.RigidBody.rod("rod", length=LENGTH, mass=MASS, radius=0.01)
    hinge = fmb.Revolute("A", markers=("ground.origin", "rod.start"))
    return fmb.Model(gravity=(0, -G, 0), bodies=[fmb.Ground(), rod], joints=[hinge, *joints], **options)


@pytest.mark.parametrize("name", INTEGRATORS)
def test_two_samples_of_a_pendulum_are_no_reason_to_warn(name):
    """30 s from its turning point to one nearby: what the samples show of its energy is a hundredth of what moves."""
    with warnings.catch_warnings():
        warnings.simplefilter("error", fmb.ValidityWarning)
        solution = fmb.simulate(pendulum(), 30.0, samples=2, integrator=INTEGRATORS[name])
    if name == "alpha":  # it loses 3 mJ of 4.9 J; the two samples show 30 mJ
        assert "balance of energy was looked at in 2 samples" in solution.statistics["notes"][0]
    else:
        assert "notes" not in solution.statistics


@pytest.mark.parametrize(("name", "samples"), every_second(INTEGRATORS, [2, 31]))
def test_the_work_of_a_drive_is_that_of_the_closed_form(name, samples):
    """angle = 3 sin(2 t): the work is the change of m L^2 w^2 / 6 + m g L / 2 sin(angle); gravity's is no work here."""
    drive = fmb.Drive("m", joint="A", angle=fmb.expression("3*sin(2*t)"))
    with warnings.catch_warnings():
        warnings.simplefilter("error", fmb.ValidityWarning)
        solution = fmb.simulate(pendulum(drive), 30.0, samples=samples, integrator=INTEGRATORS[name])
    inertia = MASS * (LENGTH**2 / 3.0 + 0.25 * 0.01**2)

    def energy(t):
        angle, rate = 3.0 * np.sin(2.0 * t), 6.0 * np.cos(2.0 * t)
        return 0.5 * inertia * rate**2 + 0.5 * MASS * G * LENGTH * np.sin(angle)

    expected = energy(solution.t) - energy(0.0)
    np.testing.assert_allclose(solution.phases[0].works[:, 1], expected, atol=0.02 * np.ptp(energy(np.linspace(0, 6))))


def test_a_run_of_no_time(recwarn):
    """A duration whose square is below all numbers."""
    model = fmb.Model(
        bodies=[fmb.Ground(), fmb.RigidBody("b", mass=1.0, inertia=(1, 1, 1))],
        gravity=(0, 0, -9.81),
    )
    assert fmb.simulate(model, 4.3e-197, samples=3, integrator=fmb.Explicit()).status.kind == "finished"
    assert not [entry for entry in recwarn if "energy" in str(entry.message)]


@pytest.mark.parametrize("holds", ["joint", "drive"])
@pytest.mark.parametrize("name", ["alpha", "IDA", "explicit", "implicit"])
def test_a_wing_that_stands_has_no_energy(name, holds, recwarn):
    """The lift of a held wing, 100 N and more, works on the rounding of its place: 1e-9 J by IDA, and nothing moves."""
    wing = fmb.RigidBody("wing", mass=2.0, inertia=(1, 1, 1))
    markers = ("ground.origin", "wing.center")
    held = [fmb.Fixed("root", markers=markers)]
    if holds == "drive":
        held = [fmb.Revolute("root", markers=markers), fmb.Drive("still", joint="root", angle=0.3)]
    air = fmb.Airload("air", marker="wing.center", chord=0.5, span=1.0, wind=(30.0, 0.0, 2.0))
    model = fmb.Model(bodies=[fmb.Ground(), wing], joints=held, forces=[air])
    assert fmb.simulate(model, 1.0, samples=101, integrator=INTEGRATORS[name]).status.ok
    assert not [entry for entry in recwarn if "no law explains" in str(entry.message)]


def test_a_vibration_of_a_ten_thousandth_is_looked_at():
    """A step of 0.2 of a period takes energy from a swing of 1e-4 m: small, but it moves."""
    spring = fmb.SpringDamper("k", markers=("ground.origin", "m.center"), stiffness=1e4, length=1.0)
    slow = fmb.PointMass("m", mass=1.0, at=(1.0, 0, 0), velocity=(0.01, 0, 0))
    model = fmb.Model(bodies=[fmb.Ground(), slow], forces=[spring])
    with pytest.warns(fmb.ValidityWarning, match="no law explains"):
        fmb.simulate(model, 1.0, samples=401, integrator=fmb.GeneralizedAlpha(step=0.0125, rho_inf=0.0))
