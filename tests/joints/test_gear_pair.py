"""`GearPair`: wheels whose axes may move, against closed forms, couplers and an auxiliary linkage."""

import numpy as np
import pytest
from tolerances import SOLVER

import flexmb as fmb

RING, PINION = 0.9, 0.05  # m, pitch radii of a circular rack and its pinion
AXIS = RING - PINION


def wheel(name, J, at=(0, 0, 0), mass=1.0, **fields):
    return fmb.RigidBody(name, mass=mass, inertia=(J, J, J), at=at, **fields)


def driven_rack(teeth, guide, *more, forces=(), bodies=(), markers=None):
    """Return a rack around the origin whose teeth are those of a pinion at x = 0.85 m with a torque of 200 N m."""
    return fmb.Model(
        bodies=[
            fmb.Ground(markers={"pinion": (AXIS, 0, 0)}),
            wheel("rack", 0.5, mass=8.6, markers=markers),
            wheel("pinion", 2e-3, (AXIS, 0, 0)),
            *bodies,
        ],
        joints=[fmb.Revolute("pinion", markers=("ground.pinion", "pinion.center")), guide, *more, teeth],
        forces=[fmb.Actuator("torque", joint="pinion", effort=200.0), *forces],
    )


def test_on_fixed_axes_it_moves_like_a_coupler_and_loads_the_bearings():
    """alpha = T / (J_p + J_r i^2), i = r_p / r_r; the teeth push with F = J_r alpha i / r_r across the line
    of centres.
    """
    guide = fmb.Revolute("guide", markers=("ground.origin", "rack.center"))
    i = PINION / RING
    pair = fmb.GearPair("teeth", markers=("rack.center", "pinion.center"), radii=(RING, PINION), inside=True)
    coupler = fmb.Coupler("teeth", joints=("guide", "pinion"), ratio=i)
    one, two = (fmb.accelerations(driven_rack(teeth, guide)) for teeth in (pair, coupler))
    alpha = 200.0 / (2e-3 + 0.5 * i * i)
    force = 0.5 * alpha * i / RING
    for result in (one, two):
        assert result["pinion"][5] == pytest.approx(alpha, rel=SOLVER)
        assert result["rack"][5] == pytest.approx(alpha * i, rel=SOLVER)
    # the pinion pushes the rack upwards, so the teeth push the pinion downwards, at 50 mm from its axis
    np.testing.assert_allclose(one.reactions["teeth"], [0, -force, 0, 0, 0, -PINION * force], rtol=1e-8, atol=1e-6)
    np.testing.assert_allclose(one.reactions["guide"][:3], [0, -force, 0], rtol=1e-8, atol=1e-6)
    np.testing.assert_allclose(two.reactions["guide"][:3], 0.0, atol=1e-6)


def test_an_auxiliary_linkage_does_the_same():
    """A rack on springs: a telescopic crank from the pinion's axis to the rack's centre carries two couplers' worth of
    teeth, R (theta_R - phi) = r (theta_P - phi) with its angle phi. Same motion, and the crank's push is the tooth
    force."""
    spring = [fmb.Bushing("spring", markers=("ground.origin", "rack.center"), stiffness=(5e4, 5e4, 0, 0, 0, 0))]
    guide = fmb.Planar("guide", markers=("ground.origin", "rack.center"))
    pair = fmb.GearPair("teeth", markers=("rack.center", "pinion.center"), radii=(RING, PINION), inside=True)
    one = fmb.simulate(driven_rack(pair, guide, forces=spring), 0.03, samples=31)
    along = fmb.Pose.axes(z=(1, 0, 0))
    crank = fmb.RigidBody("crank", mass=0.0, inertia=(0, 0, 0), at=(AXIS, 0, 0), markers={"slot": along})
    slider = fmb.RigidBody(
        "slider", mass=0.0, inertia=(0, 0, 0), markers={"slot": fmb.Pose.axes((AXIS, 0, 0), z=(1, 0, 0))}
    )
    linkage = driven_rack(
        fmb.Coupler("teeth", joints=("crank to rack", "crank to pinion"), ratio=PINION / RING),
        guide,
        fmb.Revolute("crank to pinion", markers=("crank.center", "pinion.center")),
        fmb.Prismatic("crank", markers=("crank.slot", "slider.slot")),
        fmb.Revolute("crank to rack", markers=("slider.center", "rack.center")),
        forces=spring,
        bodies=(crank, slider),
    )
    two = fmb.simulate(linkage, 0.03, samples=31)
    centre = fmb.Position("centre", marker="rack.center")
    assert np.abs(one[centre][:, 1]).max() > 0.01  # the centre yields to the tooth force
    np.testing.assert_allclose(two[centre], one[centre], atol=1e-5 * np.abs(one[centre]).max())
    push, crank_push = (s[fmb.Reaction("r", joint=name)] for s, name in ((one, "teeth"), (two, "crank to rack")))
    np.testing.assert_allclose(crank_push[1:, :2], -push[1:, :2], atol=1e-4 * np.abs(push).max())


@pytest.mark.parametrize(("inside", "turns"), [(False, 2.0), (True, -1.0)])
def test_a_wheel_that_rolls_round_another(inside, turns):
    """Once round: a coin of the same size turns twice, a wheel of half the size inside a ring once
    backwards; no carrier.
    """
    R, r = (0.4, 0.2) if inside else (0.2, 0.2)
    arm = R - r if inside else R + r
    model = fmb.Model(
        bodies=[
            fmb.Ground(),
            wheel("arm", 0.1, markers={"pin": (arm, 0, 0)}),
            wheel("planet", 0.01, (arm, 0, 0)),
        ],
        joints=[
            fmb.Revolute("arm", markers=("ground.origin", "arm.center")),
            fmb.Revolute("pin", markers=("arm.pin", "planet.center")),
            fmb.GearPair("teeth", markers=("ground.origin", "planet.center"), radii=(R, r), inside=inside),
            fmb.Drive("motor", joint="arm", angle=fmb.ramp(rate=2 * np.pi)),
        ],
        sensors=[fmb.JointCoordinate("on arm", joint="pin")],
    )
    solution = fmb.kinematics(model, 3.0, samples=301)
    # relative to the arm one turn less
    np.testing.assert_allclose(solution["on arm"], (turns - 1.0) * 2 * np.pi * solution.t, atol=1e-8)


@pytest.mark.parametrize(
    ("fields", "found"),
    [
        ({"radii": (0.1, -0.2)}, "two lengths > 0 m"),
        ({"radii": 0.1}, "radii = 0.1"),
        ({"radii": ("a", 0.1)}, "radii = "),
        ({"radii": (0.1, 0.1), "inside": True}, "two radii that differ"),
    ],
)
def test_messages(fields, found):
    with pytest.raises(fmb.ModelError, match=found):
        fmb.GearPair("g", markers=("a.center", "b.center"), **fields)
