"""`PointOnPlane`: a mass on an inclined plane, and a body whose corner stays in a plane while it turns freely."""

import numpy as np
import pytest

import flexmb as fmb


def test_a_mass_slides_down_an_inclined_plane():
    """It falls with g sin(alpha) along the slope; the plane presses with m g cos(alpha) (Galilei)."""
    alpha, m, g = 0.3, 2.0, 9.81
    plane = fmb.Pose(at=(0, 0, 0), rotation=(0, alpha, 0))  # z tilts towards x
    model = fmb.Model(
        gravity=(0, 0, -g),
        bodies=[fmb.Ground(markers={"slope": plane}), fmb.PointMass("mass", mass=m, velocity=(0, 0.5, 0))],
        joints=[fmb.PointOnPlane("on", markers=("ground.slope", "mass.center"))],
        sensors=[fmb.Position("r", marker="mass.center"), fmb.Reaction("N", joint="on", axes="ground.slope")],
    )
    report = fmb.check(model)
    assert (report.mobility, report.gruebler, report.equations) == (2, 2, 1)
    t = 0.5
    solution = fmb.simulate(model, t, samples=6)
    fallen = 0.5 * g * np.sin(alpha) * t**2
    expected = (fallen * np.cos(alpha), 0.5 * t, -fallen * np.sin(alpha))
    assert solution["r"][-1] == pytest.approx(expected, rel=1e-6)
    assert solution["N"][-1] == pytest.approx([0, 0, m * g * np.cos(alpha), 0, 0, 0], abs=1e-6)


def test_the_body_turns_freely_about_the_point():
    """A rod, thrown with its end in a plane, without weight: energy and momentum along the plane stay."""
    rod = fmb.RigidBody.rod("rod", length=1.0, mass=1.0, radius=0.05, angular_velocity=(0.3, -1.0, 2.0))
    joint = fmb.PointOnPlane("on", markers=("ground.origin", "rod.start"))
    sensors = [fmb.Position("foot", marker="rod.start"), fmb.Momentum("momentum"), fmb.Energy("energy")]
    model = fmb.Model(bodies=[fmb.Ground(), rod], joints=[joint], sensors=sensors)
    assert fmb.check(model).mobility == 5
    solution = fmb.simulate(model, 1.0, samples=11, integrator=fmb.Explicit())
    assert np.abs(solution["foot"][:, 2]).max() < 1e-8
    assert np.ptp(solution["foot"][:, :2], axis=0).max() > 0.01
    energy = solution["energy"]
    assert np.ptp(energy) < 1e-6 * energy[0]
    momentum = solution["momentum"]
    assert np.ptp(momentum[:, :2], axis=0) == pytest.approx([0.0, 0.0], abs=1e-7)
