"""Reactions at samples of a joint with friction: those of the motion, also where steps have just been cut elsewhere.

Reference: the pendulum's one equation of motion, solved by scipy; its friction depends on its own reaction.
"""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import flexmb as fmb

MASS, LEVER, INERTIA, G = 2.0, 0.5, 0.05, 9.81
MOVING, STANDING, STRIBECK, TRANSITION, RADIUS = 0.2, 0.3, 0.5, 0.1, 0.05
TIMES = np.linspace(0.0, 0.3, 601)


def model(ball: bool) -> fmb.Model:
    """A pendulum with friction in its hinge, let go from the horizontal; beside it a ball falls on a plane."""
    hinge = fmb.Pose.axes((0, 0, 0), x=(1, 0, 0), z=(0, 1, 0))
    start = fmb.Pose.axes((-LEVER, 0, 0), x=(1, 0, 0), z=(0, 1, 0))
    bodies = [
        fmb.Ground(markers={"hinge": hinge, "plane": (3, 0, 0)}),
        fmb.RigidBody("arm", mass=MASS, inertia=(INERTIA,) * 3, at=(LEVER, 0, 0), markers={"start": start}),
    ]
    forces = [
        fmb.JointFriction(
            "friction",
            joint="pin",
            moving=MOVING,
            standing=STANDING,
            stribeck=STRIBECK,
            transition=TRANSITION,
            radius=RADIUS,
        )
    ]
    if ball:
        bodies.append(fmb.PointMass("ball", mass=0.1, at=(3, 0, 0.15)))
        forces.append(fmb.Contact("floor", markers=("ground.plane", "ball.center"), radius=0.05, stiffness=1e6))
    return fmb.Model(
        gravity=(0, 0, -G),
        bodies=bodies,
        joints=[fmb.Revolute("pin", markers=("ground.hinge", "arm.start"))],
        forces=forces,
        sensors=[fmb.Reaction("pin force", joint="pin")],
    )


def resultant(phi: float, omega: float, alpha: float) -> tuple[float, float]:
    """Return the force of the hinge on the arm, (along x, along z), N; phi grows downwards from the x-axis."""
    ax = -LEVER * (np.sin(phi) * alpha + np.cos(phi) * omega**2)
    az = -LEVER * (np.cos(phi) * alpha - np.sin(phi) * omega**2)
    return MASS * ax, MASS * (az + G)


def acceleration(phi: float, omega: float) -> float:
    """Return the angular acceleration, rad/s2, whose own reaction makes the friction."""
    mu = MOVING + (STANDING - MOVING) * np.exp(-((omega / STRIBECK) ** 2))
    about = INERTIA + MASS * LEVER**2

    def left(alpha: float) -> float:
        normal = np.hypot(*resultant(phi, omega, alpha))
        friction = mu * normal * RADIUS * np.tanh(omega / TRANSITION)
        return about * alpha - MASS * G * LEVER * np.cos(phi) + friction

    return brentq(left, -200.0, 200.0, xtol=1e-13)


@pytest.fixture(scope="module")
def expected() -> np.ndarray:
    """Reaction (n, 2), N."""
    motion = solve_ivp(
        lambda _, y: (y[1], acceleration(*y)), (0, TIMES[-1]), (0, 0), rtol=1e-10, atol=1e-12, t_eval=TIMES
    )
    return np.array([resultant(phi, omega, acceleration(phi, omega)) for phi, omega in motion.y.T])


@pytest.mark.parametrize("ball", [False, True], ids=["alone", "beside impacts"])
def test_reactions_are_those_of_the_motion(ball, expected):
    """The multipliers of the steps themselves swing for a while after a contact begins or ends, by 0.1 % here."""
    solution = fmb.simulate(model(ball), TIMES[-1], samples=TIMES, integrator=fmb.GeneralizedAlpha(rtol=1e-7))
    found = solution["pin force"][:, [0, 2]]
    np.testing.assert_allclose(found, expected, rtol=0, atol=2e-5 * np.abs(expected).max())
    if ball:
        assert solution.statistics["cut at contacts"] > 0
