"""Which integrator is the default in orbit: explicit steps unless springs or dampers are too stiff for them.

References: two points on a spring vibrate with sqrt(k / m) about each other, m = m1 m2 / (m1 + m2); along the radius of
a circle, at rest in axes that turn with it, the spring is stretched by 3 n^2 m l / k.
"""

import re
import warnings

import numpy as np
import pytest

import flexmb as fmb

ORBIT = fmb.Orbit.circular(7e6)
MASSES, LENGTH = (100.0, 10.0), 20.0
REDUCED = MASSES[0] * MASSES[1] / sum(MASSES)


def tethered(stiffness: float, damping: float = 0.0) -> fmb.Model:
    """Two points above each other, turning with the radius, on a spring stretched by the gradient of gravity."""
    n = 2.0 * np.pi / ORBIT.period
    length = LENGTH * (1.0 + 3.0 * n**2 * REDUCED / stiffness)
    bodies, forces = [fmb.Ground()], []
    for name, mass, share in zip("ab", MASSES, (-MASSES[1], MASSES[0]), strict=True):
        x = share / sum(MASSES) * length
        bodies.append(fmb.PointMass(name, mass=mass, at=(x, 0, 0), velocity=(0, n * x, 0)))
        forces.append(fmb.CentralGravity(f"pull on {name}", body=name))
    spring = fmb.SpringDamper(
        "tether", markers=("a.center", "b.center"), stiffness=stiffness, damping=damping, length=LENGTH
    )
    distance = fmb.Distance("length", markers=("a.center", "b.center"))
    return fmb.Model(bodies=bodies, forces=[*forces, spring], sensors=[distance], origin=ORBIT)


def test_soft_springs_leave_explicit_steps():
    run = fmb.simulate(tethered(10.0), 500.0, samples=3)
    assert run.statistics["integrator"].startswith("Explicit(")
    stretch = 3.0 * (2.0 * np.pi / ORBIT.period) ** 2 * REDUCED * LENGTH / 10.0
    np.testing.assert_allclose(run["length"] - LENGTH, stretch, rtol=1e-4)


def test_stiff_springs_are_named_with_their_frequency():
    """100 000 steps between samples were not enough for 200 s of a run like this."""
    with pytest.warns(fmb.ValidityWarning, match="GeneralizedAlpha is used") as told:
        run = fmb.simulate(tethered(1e6, 1e3), 5400.0, samples=3)
    assert run.statistics["integrator"].startswith("GeneralizedAlpha(")
    found = float(re.search(r"up to (\S+) rad/s", str(told[0].message))[1])
    assert found == pytest.approx(np.sqrt(1e6 / REDUCED), rel=0.01)
    np.testing.assert_allclose(run["length"], LENGTH, rtol=1e-6)


def test_stiff_dampers_count_too():
    with pytest.warns(fmb.ValidityWarning, match="too stiff") as told:
        run = fmb.simulate(tethered(1.0, 1e6), 500.0, samples=3)
    assert run.statistics["integrator"].startswith("GeneralizedAlpha(")
    assert float(re.search(r"up to (\S+) rad/s", str(told[0].message))[1]) == pytest.approx(1e6 / REDUCED, rel=0.01)


def test_an_integrator_that_is_given_is_used():
    run = fmb.simulate(tethered(1e6), 1.0, samples=3, integrator=fmb.Explicit(rtol=1e-11, atol=1e-13, drift=1e-12))
    assert run.statistics["integrator"].startswith("Explicit(")


def test_stepper_and_continued_runs_choose_alike():
    with pytest.warns(fmb.ValidityWarning, match="too stiff"), fmb.stepper(tethered(1e6, 1e3), t_end=5400.0) as run:
        run.advance(to=10.0)
    assert run.solution.statistics["integrator"].startswith("GeneralizedAlpha(")
    begun = fmb.simulate(tethered(1e6, 1e3), 1.0, samples=3)
    assert begun.statistics["integrator"].startswith("Explicit(")
    with pytest.warns(fmb.ValidityWarning, match="too stiff"):
        ended = fmb.resume(begun, 5400.0, samples=3)
    assert ended.statistics["integrator"].startswith("GeneralizedAlpha(")


@pytest.mark.parametrize(
    "integrator", [fmb.GeneralizedAlpha(), fmb.IDA(), fmb.Implicit(), fmb.GeneralizedAlpha(step=50.0)]
)
def test_errors_that_add_up_are_told(integrator):
    """The spacecraft of the example was 0.37 m (IDA), 0.71 m (Implicit) and 0.42 m off within ten orbits, silently."""
    free = fmb.Model(
        bodies=[fmb.Ground(), fmb.PointMass("a", mass=1.0, at=(1, 0, 0))],
        forces=[fmb.CentralGravity("pull", body="a")],
        origin=ORBIT,
    )
    with pytest.warns(fmb.ValidityWarning, match=r"covers 1\.1 revolutions.*add up.*leave the integrator out"):
        fmb.simulate(free, 1.1 * ORBIT.period, samples=2, integrator=integrator)
    from_earth = fmb.Model(
        bodies=[fmb.Ground(), fmb.PointMass("a", mass=1.0, at=ORBIT.place, velocity=ORBIT.velocity)],
        forces=[fmb.CentralGravity("pull", body="a")],
    )
    with pytest.warns(fmb.ValidityWarning, match=r"covers 1\.1 revolutions of 5828"):
        fmb.simulate(from_earth, 1.1 * ORBIT.period, samples=2, integrator=integrator)


@pytest.mark.parametrize(
    ("integrator", "turns"),
    [(fmb.Explicit(), 1.1), (fmb.Implicit(rtol=1e-10, atol=1e-12), 1.1), (fmb.GeneralizedAlpha(), 0.2)],
)
def test_what_stays_close_is_not_told(integrator, turns):
    """And is right: Clohessy & Wiltshire's ellipse, x = 2 - cos(n t), y = 2 sin(n t) - 3 n t, which turns with n t."""
    free = fmb.Model(
        bodies=[fmb.Ground(), fmb.PointMass("a", mass=1.0, at=(1, 0, 0))],
        forces=[fmb.CentralGravity("pull", body="a")],
        sensors=[fmb.Position("place", marker="a.center")],
        origin=ORBIT,
    )
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        run = fmb.simulate(free, turns * ORBIT.period, samples=2, integrator=integrator)
    angle = 2.0 * np.pi * turns
    c, s = np.cos(angle), np.sin(angle)
    x, y = 2.0 - c, 2.0 * s - 3.0 * angle
    np.testing.assert_allclose(run["place"][-1], (c * x - s * y, s * x + c * y, 0.0), atol=1e-3)
