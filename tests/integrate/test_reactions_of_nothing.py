"""Joints that carry nothing: their multipliers are rounding, and what follows them or accelerations is solved all the
same. Two bodies that fall together, in several directions."""

import numpy as np
import pytest
from by_turns import every_second

import flexmb as fmb

GRAVITY = 9.81
ANGLES = [0.1, 0.23, 0.36, 0.49, 1.4]  # rad
RUNS = ANGLES[::2]
FORMULATIONS = [fmb.Augmented(), fmb.NullSpace(), fmb.UdwadiaPhohomsiri(), fmb.Baumgarte(), fmb.Recursive()]
INTEGRATORS = [fmb.GeneralizedAlpha(), fmb.Implicit(), fmb.IDA(), *(fmb.Explicit(formulation=f) for f in FORMULATIONS)]


def pair(angle: float, *, friction: bool) -> fmb.Model:
    """Return two bodies on one hinge: with friction in it, or with a push along x against the acceleration along x."""
    at = np.array([0.5, 0.1, 0.2])
    turned = np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]]) @ at
    one = fmb.RigidBody("one", mass=200.0, inertia=(30, 40, 50), rotation=(0, 0, angle), markers={"p": tuple(at)})
    two = fmb.RigidBody(
        "two",
        mass=17.0,
        inertia=(3, 4, 5),
        at=tuple(2 * turned),
        rotation=(0, 0, angle),
        markers={"p": tuple(-at)},
    )
    felt = fmb.measured(fmb.Acceleration("felt", marker="one.center"), 0)
    return fmb.Model(
        bodies=[fmb.Ground(), one, two],
        joints=[fmb.Revolute("j", markers=("one.p", "two.p"))],
        forces=[
            fmb.JointFriction("rub", joint="j", moving=0.2, radius=0.02)
            if friction
            else fmb.PointLoad("push", marker="one.center", force=(-3.0 * felt, 0, 0))
        ],
        sensors=[fmb.Position("place", marker="two.center")],
        gravity=(0, 0, -GRAVITY),
    )


@pytest.mark.parametrize(("integrator", "friction"), every_second(INTEGRATORS, [True, False]))
def test_two_bodies_fall_together(integrator, friction):
    for angle in RUNS:
        run = fmb.simulate(pair(angle, friction=friction), 0.1, samples=3, integrator=integrator)
        fallen = run["place"][-1, 2] - run["place"][0, 2]
        assert fallen == pytest.approx(-0.5 * GRAVITY * 0.1**2, rel=1e-5)


@pytest.mark.parametrize("friction", [True, False])
@pytest.mark.parametrize("formulation", FORMULATIONS, ids=repr)
def test_accelerations_of_a_fall(formulation, friction):
    for angle in ANGLES:
        found = fmb.accelerations(pair(angle, friction=friction), formulation=formulation)
        assert [found[body][2] for body in ("one", "two")] == pytest.approx([-GRAVITY, -GRAVITY], abs=1e-9)
