"""Lumped masses with hardly any moment of inertia, and flywheels with hardly any mass: joints stay what they are."""

import warnings

import numpy as np
import pytest
from scipy import linalg

import flexmb as fmb

ACROSS = (np.pi / 2, 0.0, 0.0)


def two_links(inertia: float, length: float = 1.0) -> fmb.Model:
    """Ziegler's column: masses 2 and 1 kg at the ends of two links, springs at both hinges, a follower load of 1 N m
    over the length."""
    one, two = (
        fmb.RigidBody(
            name,
            mass=mass,
            inertia=(inertia,) * 3,
            at=(k * length, 0, 0),
            markers={"inner": fmb.Pose((-length, 0, 0), ACROSS), "outer": fmb.Pose((0, 0, 0), ACROSS)},
        )
        for k, (name, mass) in enumerate((("one", 2.0), ("two", 1.0)), 1)
    )
    pins = (("ground.hinge", "one.inner"), ("one.outer", "two.inner"))
    return fmb.Model(
        bodies=[fmb.Ground(markers={"hinge": fmb.Pose((0, 0, 0), ACROSS)}), one, two],
        joints=[fmb.Revolute(f"pin{k}", markers=pair) for k, pair in enumerate(pins)],
        forces=[
            *(fmb.TorsionSpring(f"spring{k}", joint=f"pin{k}", stiffness=1.0) for k in range(2)),
            fmb.PointLoad("load", marker="two.outer", force=(-1.0 / length, 0, 0), axes="two.outer"),
        ],
        sensors=[fmb.Reaction("reaction", joint="pin0")],
    )


@pytest.mark.parametrize("length", [1.0, 1e-3, 1e3])
@pytest.mark.parametrize("share", [1e-9, 1e-11, 1e-12, 2e-13])
def test_frequencies_of_lumped_masses(share, length):
    """Two freedoms, and the frequencies of Ziegler's column (Bolotin, Nonconservative problems, 1963) in its plane."""
    model = two_links(share * length**2, length)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert fmb.check(model).mobility == 2
        found = fmb.linearize(model).frequencies
    stiffness, mass = np.array([[1.0, 0.0], [-1.0, 1.0]]), np.array([[3.0, 1.0], [1.0, 1.0]]) * length**2
    expected = np.sort(np.sqrt(linalg.eigvals(stiffness, mass).real)) / (2.0 * np.pi)
    np.testing.assert_allclose(found, expected, rtol=1e-7)


@pytest.mark.parametrize("integrator", [fmb.GeneralizedAlpha(rtol=1e-7), fmb.Implicit(rtol=1e-7), fmb.IDA(rtol=1e-8)])
def test_motion_of_lumped_masses(integrator):
    """As of links without any moment of inertia."""
    runs = []
    for inertia in (1e-12, 0.0):
        model = two_links(inertia)
        falling = fmb.Model(bodies=model.bodies, joints=model.joints, sensors=model.sensors, gravity=(0, 0, -9.81))
        runs.append(fmb.simulate(falling, 0.3, samples=4, integrator=integrator)["reaction"])
    np.testing.assert_allclose(runs[0], runs[1], rtol=0, atol=1e-4)


@pytest.mark.parametrize("mass", [1e-6, 1e-12, 1e-14])
def test_a_flywheel_without_mass_turns_on_two_balls(mass):
    """1 kg m2 on a line through two balls, 0.3 m from its centre: one freedom, a = F r / (J + m r^2)."""
    balls = {"low": (0, 0, 0), "high": (0, 0, 1)}
    wheel = fmb.RigidBody(
        "wheel",
        mass=mass,
        inertia=(1.0, 1.0, 1.0),
        at=(0.3, 0, 0.5),
        markers={"low": (-0.3, 0, -0.5), "high": (-0.3, 0, 0.5), "centre": (0, 0, 0)},
    )
    model = fmb.Model(
        bodies=[fmb.Ground(markers=balls), wheel],
        joints=[fmb.Spherical(name, markers=(f"ground.{name}", f"wheel.{name}")) for name in balls],
        forces=[fmb.PointLoad("push", marker="wheel.centre", force=(0, 1, 0))],
    )
    assert fmb.check(model).mobility == 1
    np.testing.assert_allclose(
        fmb.accelerations(model)["wheel"], (0, 0.09 / (1 + 0.09 * mass), 0, 0, 0, 0.3 / (1 + 0.09 * mass)), atol=1e-9
    )


def test_a_moment_of_inertia_without_digits_is_told():
    with pytest.warns(fmb.ValidityWarning, match=r"Body 'one' has a moment of inertia of 1e-15.*arm of joint 'pin0'"):
        fmb.check(two_links(1e-15))
