"""A slider drives a crank through its dead centre, with links of a millionth of its mass and equations that depend.

Reference: Lagrange's equation of the crank angle, p = M(theta) theta', p' = M' theta'^2 / 2 - V', by scipy's DOP853.
"""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import flexmb as fmb

CRANK, ROD, RADIUS, STIFFNESS, FREE = 0.15, 0.3, 0.01, 100.0, 0.2
START = np.radians(60.0)


def model(mass):
    """Return the mechanism with links of `mass`, kg, and a slider of 1 kg on a spring; no gravity."""
    tilt = -np.arcsin(CRANK * np.sin(START) / ROD)
    pin = CRANK * np.array([np.cos(START), np.sin(START), 0])
    along = fmb.Pose.axes((0, 0, 0), x=(0, 1, 0), z=(1, 0, 0))
    end = pin + ROD * np.array([np.cos(tilt), np.sin(tilt), 0])
    slider = fmb.RigidBody("slider", mass=1.0, inertia=(1e-3,) * 3, at=end)
    return fmb.Model(
        bodies=[
            fmb.Ground(markers={"pin": (0, 0, 0), "rail": along}),
            fmb.RigidBody.rod("crank", length=CRANK, mass=mass, radius=RADIUS, rotation=(0, 0, START)),
            fmb.RigidBody.rod("rod", length=ROD, mass=mass, radius=RADIUS, at=pin, rotation=(0, 0, tilt)),
            replace(slider, markers={"pin": (0, 0, 0), "rail": along}),
        ],
        joints=[
            fmb.Revolute("main", markers=("ground.pin", "crank.start")),
            fmb.Revolute("big", markers=("crank.end", "rod.start")),
            fmb.Spherical("small", markers=("rod.end", "slider.pin")),
            fmb.Prismatic("rail", markers=("ground.rail", "slider.rail")),
        ],
        forces=[fmb.SpringDamper("k", markers=("ground.pin", "slider.pin"), stiffness=STIFFNESS, length=FREE)],
        sensors=[fmb.Position("x", marker="slider.pin")],
    )


def place(theta):
    return CRANK * np.cos(theta) + ROD * np.sqrt(1.0 - (CRANK * np.sin(theta) / ROD) ** 2)


def inertia(theta, mass):
    """Return M(theta), kg m2, of crank, rod and slider."""
    cos = np.sqrt(1.0 - (CRANK * np.sin(theta) / ROD) ** 2)
    turn = -CRANK * np.cos(theta) / (ROD * cos)
    sin = -CRANK * np.sin(theta) / ROD
    x = -CRANK * np.sin(theta) - ROD * sin * turn
    middle = (x + ROD / 2 * sin * turn) ** 2 + (CRANK * np.cos(theta) + ROD / 2 * cos * turn) ** 2
    own = mass * (ROD**2 / 12 + RADIUS**2 / 4) * turn**2
    return mass * (CRANK**2 / 3 + RADIUS**2 / 4) + mass * middle + own + x**2


def reference(mass, times):
    """Return the places of the slider, m; derivatives by complex steps."""

    def rates(_, y):
        theta, p = y
        speed = p / inertia(theta, mass)
        step = theta + 1e-30j
        force = 0.5 * inertia(step, mass).imag / 1e-30 * speed**2
        return speed, force - STIFFNESS * (place(theta) - FREE) * place(step).imag / 1e-30

    found = solve_ivp(rates, (0.0, times[-1]), (START, 0.0), "DOP853", times, rtol=1e-12, atol=1e-14)
    return place(found.y[0])


@pytest.mark.parametrize("mass", [1e-4, 1e-6])
def test_a_dead_centre_takes_no_energy(mass, recwarn):
    """What yields where equations depend was a damper: IDA lost 5 and 19 % of the energy at any tolerance."""
    run = fmb.simulate(model(mass), 1.0, samples=21, integrator=fmb.IDA())
    np.testing.assert_allclose(run["x"][:, 0], reference(mass, run.t), rtol=0, atol=3e-4)
    assert not [one for one in recwarn if issubclass(one.category, fmb.errors.ValidityWarning)]


@pytest.mark.parametrize("samples", [6, 11, 21, 101])
def test_energy_that_implicit_makes_is_told_whatever_the_samples(samples):
    """Few samples do not show what moves; steps do: it was a note that they are too few, or nothing."""
    with pytest.warns(fmb.errors.ValidityWarning, match="(added|removed) .* J that no law explains") as told:
        run = fmb.simulate(model(1e-6), 1.0, samples=samples, integrator=fmb.Implicit())
    assert "a smaller rtol or step, or use IDA or Explicit to compare" in str(told[0].message)
    assert np.abs(run["x"][:, 0] - reference(1e-6, run.t)).max() > 3e-4
    assert "too few to know how much energy" not in " ".join(run.statistics["notes"])
