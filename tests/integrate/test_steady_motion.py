"""Steady rotation of bodies without frame: point masses and cables on a rotor, against closed forms."""

import numpy as np
import pytest
from numpy.polynomial import Polynomial

import flexmb as fmb
from flexmb import fem

SPEED = 20.0
HUB = 0.3
"""Distance from the axis at which something is attached, m."""


def rotor(body, joints=(), forces=(), speed=SPEED, sensors=()) -> fmb.Model:
    """A hub that turns about z at constant speed, with a marker on its rim."""
    ground = fmb.Ground(markers={"track": fmb.Pose.axes(z=(1, 0, 0), x=(0, 0, 1))})
    hub = fmb.RigidBody("hub", mass=1.0, inertia=(0.1, 0.1, 0.1), markers={"rim": (HUB, 0, 0)})
    spin = fmb.Drive("spin", joint="axis", angle=fmb.expression("w * t", w=speed))
    axis = fmb.Revolute("axis", markers=("ground.origin", "hub.center"))
    return fmb.Model(bodies=[ground, hub, body], joints=[axis, spin, *joints], forces=forces, sensors=sensors)


def test_a_mass_on_a_rotating_spring():
    """Radius r of k (r - e - l0) = m W^2 r; x'' - 2 W y' + (k/m - W^2) x = 0,
    y'' + 2 W x' + (F/(m s) - W^2) y = 0 about it.
    """
    m, k, free = 0.5, 1500.0, 0.2
    mass = fmb.PointMass("mass", mass=m, at=(0.55, 0, 0))
    spring = fmb.SpringDamper("spring", markers=("hub.rim", "mass.center"), stiffness=k, length=free)
    model = rotor(
        mass,
        forces=[spring],
        sensors=[fmb.Position("r", marker="mass.center"), fmb.Acceleration("a", marker="mass.center")],
    )
    steady = fmb.statics(model)
    r = k * (HUB + free) / (k - m * SPEED**2)
    np.testing.assert_allclose(steady["r"][-1], (r, 0, 0), atol=1e-7)
    np.testing.assert_allclose(steady["a"][-1], (-(SPEED**2) * r, 0, 0), rtol=1e-6, atol=1e-6)
    across = SPEED**2 * r / (r - HUB)  # the force of the spring over its length and the mass: W^2 r / s
    x, y = k / m - SPEED**2, across - SPEED**2
    s2 = Polynomial((x * y, x + y + 4 * SPEED**2, 1.0)).roots().real
    expected = np.sort(np.sqrt([-s2[0], -s2[1], across])) / (2 * np.pi)
    np.testing.assert_allclose(fmb.linearize(model, steady).frequencies, expected, rtol=1e-6)


def test_a_mass_on_a_rotating_rod():
    """A pendulum in the field of a rotor: in the plane W sqrt(e / l), across it W sqrt(1 + e / l)."""
    length = 0.25
    mass = fmb.PointMass("mass", mass=0.5, at=(HUB + 0.8 * length, 0.6 * length, 0))
    rod = fmb.Rod("rod", markers=("hub.rim", "mass.center"))
    model = rotor(
        mass, joints=[rod], sensors=[fmb.Position("r", marker="mass.center"), fmb.Reaction("pull", joint="rod")]
    )
    steady = fmb.statics(model)
    np.testing.assert_allclose(steady["r"][-1], (HUB + length, 0, 0), atol=1e-7)
    np.testing.assert_allclose(steady["pull"][-1, 0], -0.5 * SPEED**2 * (HUB + length), rtol=1e-7)
    found = 2 * np.pi * fmb.linearize(model, steady).frequencies
    np.testing.assert_allclose(found, SPEED * np.sqrt([HUB / length, 1 + HUB / length]), rtol=1e-7)


def test_a_rotating_string():
    """Heavy string from the axis, no stiffness in bending: W sqrt(n (2 n - 1)) across, W sqrt(n (2 n - 1) - 1) in the
    plane.

    Southwell & Gough 1921. Its tension at the axis is P = m W^2 L / 2, more by 5/6 P / EA as it stretches.
    """
    steel = fmb.Material(young=2e9, poisson=0.3, density=7850.0)
    string = fmb.AncfCable(
        "string", points=((0, 0, 0), (2, 0, 0)), elements=10, section=fem.Section.solid_circle(0.001), material=steel
    )
    ball = fmb.Spherical("ball", markers=("hub.center", "string.start"))
    model = rotor(string, joints=[ball], sensors=[fmb.Reaction("pull", joint="ball")])
    steady = fmb.statics(model)
    pull = 0.5 * string.mass * SPEED**2 * 2.0
    pull *= 1.0 + 5 / 6 * pull / (2e9 * string.section.area)
    np.testing.assert_allclose(steady["pull"][-1, 0], -pull, rtol=2e-5)
    found = 2 * np.pi * fmb.linearize(model, steady).frequencies
    n = np.arange(1, 4)
    flap, lag = SPEED * np.sqrt(n * (2 * n - 1)), SPEED * np.sqrt(n * (2 * n - 1) - 1.0)
    np.testing.assert_allclose(found[:5], np.sort([*flap, *lag])[:5], rtol=3e-3, atol=0.05)


def test_what_hangs_on_a_rotor_turns_with_it():
    """A lag hinge parallel to the axis of the rotor does not turn,
    although less energy would be in a blade that stays.
    """
    blade = fmb.RigidBody.rod("blade", mass=1.0, length=1.0, at=(HUB, 0, 0))
    hinge = fmb.Revolute("hinge", markers=("hub.rim", "blade.start"))
    model = rotor(blade, joints=[hinge])
    steady = fmb.statics(model)
    assert steady.final.u[-1] == pytest.approx(SPEED, rel=1e-7)
    # W sqrt(e S / J) with S = m l / 2 and J = m l^2 / 3 about the hinge
    assert fmb.linearize(model, steady).frequencies[0] == pytest.approx(
        SPEED * np.sqrt(1.5 * HUB) / (2 * np.pi), rel=1e-4
    )


def test_a_mechanism_that_cannot_go_on_steadily_is_refused():
    """A slider-crank."""
    coupler = fmb.RigidBody.rod("coupler", mass=1.0, length=1.0, at=(HUB, 0, 0))
    model = rotor(
        coupler,
        joints=[
            fmb.Revolute("pin", markers=("hub.rim", "coupler.start")),
            fmb.InLine("slider", markers=("ground.track", "coupler.end")),
        ],
    )
    with pytest.raises(fmb.IntegrationError) as caught:
        fmb.statics(model)
    assert "not steadily" in str(caught.value)
    assert all((caught.value.part, caught.value.expected, caught.value.remedy, caught.value.solution))
    assert fmb.statics(model.changed("spin", angle=0.0)).status.finished
