"""A motion that follows a measurement: a heavy flywheel carries the reference, a coupler prescribes it."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import flexmb as fmb
from flexmb.errors import CompileError

W, D, HEAVY = 12.0, 0.8, 1e6
PIN = fmb.Pose.axes(z=(0, 1, 0))


def hung(name: str, mass: float, inertia: float, y: float, below: float, turned: float = 0.0) -> fmb.RigidBody:
    """Return a body on a pin along y, its centre of mass so far below the pin."""
    at = (-below * np.sin(turned), y, -below * np.cos(turned))
    top = {"pin": fmb.Pose.axes((0, 0, below), z=(0, 1, 0))}
    return fmb.RigidBody(name, mass=mass, inertia=(inertia,) * 3, at=at, rotation=(0, turned, 0), markers=top)


def test_a_drive_that_follows_a_measurement_says_how_to_do_it():
    ground = fmb.Ground(markers={"rod": fmb.Pose.axes(z=(0, 1, 0))})
    pin = fmb.Revolute("pin", markers=("ground.rod", "rod.pin"))
    turn = fmb.measured(fmb.Position("p", marker="rod.center"), 0)
    drive = fmb.Drive("motor", joint="pin", angle=turn)
    model = fmb.Model(bodies=[ground, hung("rod", 1.0, 0.03, 0.0, 0.3)], joints=[pin, drive])
    with pytest.raises(CompileError, match=r"'motor'.*measured.*heavy body which an Actuator moves.*Coupler"):
        fmb.simulate(model, 0.1)


def test_a_rod_follows_the_filtered_angle_of_a_pendulum():
    """x'' = w^2 (a - x) - 2 d w x' with the angle a of a free pendulum: scipy. What the rod asks for turns the flywheel
    by its share of the inertia, 1e-6, only.
    """
    names = {"free": 0.0, "rod": 1.0, "reference": 2.0}
    ground = fmb.Ground(markers={name: fmb.Pose.axes((0, y, 0), z=(0, 1, 0)) for name, y in names.items()})
    bodies = [ground, hung("free", 2.0, 0.05, 0.0, 0.4, 0.5), hung("rod", 1.0, 0.03, 1.0, 0.3),
              hung("reference", 1.0, HEAVY, 2.0, 0.0)]  # fmt: skip
    joints = [fmb.Revolute(name, markers=(f"ground.{name}", f"{name}.pin")) for name in names]
    over = {"a": fmb.JointCoordinate("a", joint="free"), "x": fmb.JointCoordinate("x", joint="reference")}
    push = fmb.formula("I*(w**2*(a - x) - 2*d*w*rate(x))", over=over, I=HEAVY, w=W, d=D)
    model = fmb.Model(
        bodies=bodies,
        joints=[*joints, fmb.Coupler("prescribes", joints=("reference", "rod"), ratio=1.0)],
        forces=[fmb.Actuator("filter", joint="reference", effort=push)],
        sensors=[*over.values(), fmb.JointCoordinate("follows", joint="rod")],
        gravity=(0, 0, -9.81),
    )
    solution = fmb.simulate(model, 1.5, samples=16, integrator=fmb.Explicit(rtol=1e-9))
    about = 0.05 + 2.0 * 0.4**2

    def rates(_, y):
        a, da, x, dx = y
        return da, -2.0 * 9.81 * 0.4 * np.sin(a) / about, dx, W**2 * (a - x) - 2.0 * D * W * dx

    start = [solution["a"][0], 0.0, 0.0, 0.0]
    wanted = solve_ivp(rates, (0.0, 1.5), start, t_eval=solution.t, rtol=1e-10, atol=1e-12).y[2]
    assert np.abs(wanted).max() > 0.3
    assert np.abs(solution["follows"] - wanted).max() < 5e-6
